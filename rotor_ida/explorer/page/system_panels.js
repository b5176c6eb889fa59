// Panels of a rotor system: its sketch, moving shape, orbits, forces, exact whirls and Campbell diagram.

import { Plot, colour } from "./plot.js";
import { roundUp } from "./state.js";
import { SPEED_UNITS, STABILITY } from "./tables.js";
import { addTools } from "./tools.js";
import { labelled, prefixed, told } from "./units.js";

const TURN = 2 * Math.PI;
// Of the sketch: heights of contacts and supports, and the half-height of the heaviest node.
const STATOR = [0.72, 0.92], SUPPORT = -0.55, TALLEST = 0.6;
// A click beyond this height chooses a contact.
const ABOVE = 0.62;
// How the oblique view moves a point for x towards the viewer: along the shaft, of its length, and down.
const ALONG = 0.05, DOWN = 0.35;
const POINTS = 48; // of a ring
const JUMP = 0.05; // of the height of the diagram, from one whirl to another
const TRAIL = 1 / 20; // of the run, in bold behind the rotor
const INKS = ["contact", "second", "keyphasor", "rolling", "accent", "muted"];

/** Return the values of one node or contact, by its place. */
const column = (values, place, count) => values.subarray(place * count, (place + 1) * count);
const largest = (values) => values.reduce((top, each) => (Math.abs(each) > top ? Math.abs(each) : top), 0);
const si = (page, unit, size) => (page.sketch.units === "SI" ? prefixed(unit, size) : { factor: 1, unit: "" });
const speedIn = (page) => (page.sketch.units === "SI" ? { factor: SPEED_UNITS.rpm, unit: "rpm" } : { factor: 1, unit: "" });

/** Return the ends of the axis along the shaft; a single node is in its middle. */
function along(positions, margin) {
  const [low, high] = [Math.min(...positions), Math.max(...positions)];
  const beyond = margin * (high - low) || 0.5;
  return [low - beyond, high + beyond];
}

/** Write a legend: pairs of a class and words. */
function key(element, parts) {
  element.replaceChildren(...parts.map(([className, words, ink]) => {
    const item = Object.assign(document.createElement("span"), { className: className ? "" : "reason" });
    if (className) {
      const icon = Object.assign(document.createElement("i"), { className });
      if (ink) icon.style.color = `var(--${ink})`;
      item.append(icon);
    }
    item.append(words);
    return item;
  }));
}

class Panel {
  constructor(card, view, options) {
    Object.assign(this, { card, view });
    this.plot = new Plot(card.querySelector(".plot"), { draw: (pen) => this.drawn && this.draw(pen), ...options });
    addTools(card, [this.plot], { name: () => card.dataset.panel, told: () => this.words(), table: () => this.table() });
  }

  words() {
    const { sketch, run } = this.view.page;
    return sketch ? `node ${sketch.node}, ${run ? run.facts.verdict : ""}` : "";
  }
}

/** Shaft, masses, unbalance, contacts and supports; a click chooses. */
export class Sketch extends Panel {
  constructor(card, view, choose) {
    super(card, view, { x: "axial position", y: "", steps: [1000] });
    this.plot.onDrag((x, y, event) => event.type === "pointerdown" && this.#choose(x, y, choose));
  }

  show() {
    const { positions, has_positions: placed, nodes } = this.view.page.sketch;
    this.drawn = true;
    this.plot.show({
      x: along(positions, 0.06), y: [-1.05, 1.45],
      labels: [placed ? labelled("axial position", this.view.page.sketch.units === "SI" ? "m" : "") : "node", ""],
    });
    this.plot.say(`Sketch of the rotor with the nodes ${nodes.join(", ")}`);
  }

  #choose(x, y, choose) {
    const { positions, nodes, contacts } = this.view.page.sketch;
    const nearest = (places) => places.reduce((best, each, i) => (Math.abs(each - x) < Math.abs(places[best] - x) ? i : best), 0);
    const ofContacts = contacts.map(({ node }) => positions[nodes.indexOf(node)]);
    if (Math.abs(y) > ABOVE && contacts.length) choose({ contact: nearest(ofContacts) });
    else choose({ node: nodes[nearest(positions)] });
  }

  draw(pen) {
    const { positions, nodes, masses, contacts, supports, unbalance, node } = this.view.page.sketch;
    const at = (name) => positions[nodes.indexOf(name)];
    const heaviest = Math.max(...masses) || 1;
    pen.line([Math.min(...positions), Math.max(...positions)], [0, 0], { stroke: colour("muted"), width: 5 });
    positions.forEach((x, i) => {
      const half = TALLEST * Math.sqrt(masses[i] / heaviest);
      pen.line([x, x], [-half, half], { stroke: colour("muted"), width: 9, alpha: 0.55 });
    });
    contacts.forEach(({ node: name }, i) => {
      const x = at(name);
      const ink = i === Number(document.getElementById("contact").value) ? "accent" : "contact";
      for (const side of [-1, 1]) pen.line([x, x], STATOR.map((each) => side * each), { stroke: colour(ink), width: 10 });
    });
    for (const name of supports) pen.mark(at(name), SUPPORT, 11, { shape: "up", fill: colour("ink") });
    positions.forEach((x, i) => pen.mark(x, 0, nodes[i] === node ? 11 : 6, { fill: colour(nodes[i] === node ? "accent" : "ink"), stroke: colour("card") }));
    for (const name of unbalance) pen.mark(at(name), 0.3, 8, { shape: "diamond", fill: colour("keyphasor") });
    let last = -Infinity;
    positions.forEach((x, i) => {
      if (pen.x(x) - last < 44 * pen.pixel) return;
      last = pen.x(x);
      pen.text(nodes[i], x, 1.2, { fill: colour("muted"), align: "center" });
    });
  }

  table() {
    const { nodes, positions, masses } = this.view.page.sketch;
    return { node: nodes, position: positions, mass: masses };
  }
}

/** All nodes now, in an oblique view, with their orbits and clearances. */
export class Shape extends Panel {
  constructor(card, view) {
    super(card, view, { x: "axial position", y: "deflection" });
  }

  show() {
    const { page } = this.view;
    const { run, sketch: { positions, contacts, units } } = page;
    const top = Math.max(largest(run.x), largest(run.y), ...contacts.map(({ clearance }) => clearance)) || 1;
    this.drawn = si(page, "m", top);
    const span = Math.max(...positions) - Math.min(...positions) || 1;
    this.along = (ALONG * span) / (top * this.drawn.factor);
    const limit = (1 + DOWN) * top * this.drawn.factor;
    this.plot.show({
      x: along(positions, 0.08), y: [-limit, limit],
      labels: [page.sketch.has_positions ? labelled("axial position", units === "SI" ? "m" : "") : "node", labelled("deflection", this.drawn.unit)],
    });
    this.plot.say(`Deflected shape at t = ${told(run.t[this.view.now])}`);
  }

  draw(pen) {
    const { run, sketch: { positions, nodes, contacts } } = this.view.page;
    const { factor } = this.drawn;
    const now = this.view.now, count = run.t.length;
    const begin = Math.max(now - Math.ceil(TRAIL * count), 0);
    const place = (z, x, y) => [z - this.along * x * factor, (y - DOWN * x) * factor];
    const path = (z, xs, ys, style) => {
      const points = Array.from(xs, (x, i) => place(z, x, ys[i]));
      pen.line(points.map(([x]) => x), points.map(([, y]) => y), style);
    };
    pen.line([Math.min(...positions), Math.max(...positions)], [0, 0], { stroke: colour("muted"), dash: [8, 3, 2, 3] });
    const turns = Array.from({ length: POINTS + 1 }, (_, i) => (TURN * i) / POINTS);
    for (const { node, clearance, centre } of contacts) {
      path(positions[nodes.indexOf(node)], turns.map((a) => centre[0] + clearance * Math.cos(a)), turns.map((a) => centre[1] + clearance * Math.sin(a)), { stroke: colour("contact"), width: 1.4 });
    }
    const ends = nodes.map((_, i) => {
      const [x, y] = [column(run.x, i, count), column(run.y, i, count)];
      path(positions[i], x.subarray(begin, now + 1), y.subarray(begin, now + 1), { stroke: colour("accent"), alpha: 0.55 });
      return place(positions[i], x[now], y[now]);
    });
    pen.line(ends.map(([x]) => x), ends.map(([, y]) => y), { stroke: colour("ink"), width: 3 });
    for (const [x, y] of ends) pen.mark(x, y, 7, { fill: colour("ink"), stroke: colour("card") });
  }

  table() {
    const { run, sketch: { nodes, positions } } = this.view.page;
    const now = this.view.now, count = run.t.length;
    return { node: nodes, position: positions, x: nodes.map((_, i) => run.x[i * count + now]), y: nodes.map((_, i) => run.y[i * count + now]) };
  }
}

/** The orbit at the chosen node, or in one contact, up to now. */
export class Orbit extends Panel {
  constructor(parent, view, asked, contact) {
    const card = Object.assign(document.createElement("section"), { className: "card" });
    card.dataset.panel = contact === null ? "orbit" : `orbit-${contact}`;
    const area = Object.assign(document.createElement("div"), { className: "plot square" });
    area.setAttribute("role", "img");
    card.append(document.createElement("h2"), area);
    card.append(Object.assign(document.createElement("p"), { className: "key" }));
    parent.insertBefore(card, parent.lastElementChild); // the force comes last
    super(card, view, { x: "x", y: "y", equal: true });
    Object.assign(this, { asked, contact });
  }

  show() {
    const { page } = this.view;
    const { run, sketch: { nodes, contacts } } = page;
    const node = this.contact === null ? run.facts.node : contacts[this.contact].node;
    const chosen = contacts[this.asked.contact]?.node === node ? this.asked.contact : contacts.findIndex((each) => each.node === node);
    this.ring = this.contact ?? chosen;
    const ring = contacts[this.ring];
    const count = run.t.length, isIn = ring?.on_stator;
    const from = (axis, centre) => (isIn ? column(run[`contact_${axis}`], this.ring, count).map((each) => each + centre) : column(run[axis], nodes.indexOf(node), count));
    Object.assign(this, { x: from("x", ring?.centre[0]), y: from("y", ring?.centre[1]) });
    const top = Math.max(largest(this.x), largest(this.y), ring ? ring.clearance + Math.max(...ring.centre.map(Math.abs)) : 0) || 1;
    this.drawn = si(page, "m", top);
    const limit = 1.08 * top * this.drawn.factor;
    this.card.querySelector("h2").textContent = `Orbit at ${node}${isIn ? ", in its stator" : ""}`;
    this.plot.show({ x: [-limit, limit], y: [-limit, limit], labels: [labelled("x", this.drawn.unit), labelled("y", this.drawn.unit)] });
    key(this.card.querySelector(".key"), [["line-key passage thin", "the run"], ["line-key", "just before"], ...(ring ? [["line-key contact", "clearance"]] : [])]);
    this.plot.say(`Orbit at node ${node}`);
  }

  draw(pen) {
    const { factor } = this.drawn;
    const now = this.view.now;
    const [xs, ys] = [this.x, this.y].map((each) => each.map((value) => value * factor));
    const ring = this.view.page.sketch.contacts[this.ring];
    if (ring) pen.circle(ring.centre[0] * factor, ring.centre[1] * factor, ring.clearance * factor, { stroke: colour("contact"), width: 1.6 });
    pen.line(xs, ys, { stroke: colour("accent"), alpha: 0.35, to: now + 1 });
    pen.line(xs, ys, { stroke: colour("ink"), width: 1.6, from: Math.max(now - Math.ceil(TRAIL * xs.length), 0), to: now + 1 });
    pen.mark(xs[now], ys[now], 9, { fill: colour("accent"), stroke: colour("card") });
  }

  table() {
    return { t: Array.from(this.view.page.run.t), x: Array.from(this.x), y: Array.from(this.y) };
  }
}

/** Forces of the chosen contact over time; of a drop those of all bearings. */
export class Force extends Panel {
  constructor(card, view) {
    super(card, view, { x: "time", y: "force" });
  }

  show() {
    const { page } = this.view;
    const { run, sketch: { contacts } } = page;
    const chosen = Number(document.getElementById("contact").value || 0);
    this.contacts = run.facts.drop ? contacts.map((_, i) => i) : contacts.length ? [chosen] : [];
    const count = run.t.length;
    this.tangential = !run.facts.drop && this.contacts.length > 0 && largest(column(run.tangential_force, chosen, count)) > 0;
    const peaks = run.peak_force.filter((_, i) => this.contacts.includes(run.peak_contact[i]));
    const of = this.contacts.map((i) => largest(column(run.normal_force, i, count)));
    const top = Math.max(...of, largest(peaks), 0);
    this.drawn = si(page, "N", top || 1);
    this.time = si(page, "s", run.t.at(-1));
    const high = roundUp(1.05 * (top || 1) * this.drawn.factor);
    const low = this.tangential ? Math.min(0, -roundUp(-1.05 * this.drawn.factor * column(run.tangential_force, chosen, count).reduce((least, each) => Math.min(least, each), 0))) : 0;
    this.plot.show({ x: [0, run.t.at(-1) * this.time.factor], y: [top && low < 0 ? low : 0, high], labels: [labelled("time", this.time.unit), labelled("force", this.drawn.unit)] });
    const parts = this.contacts.map((i) => ["line-key", `normal force, contact ${i} at ${contacts[i].node}`, INKS[i % INKS.length]]);
    if (this.tangential) parts.push(["line-key", "tangential force", "keyphasor"]);
    if (peaks.length) parts.push(["mark open", "peak of a contact"]);
    if (!top) parts.push(["", contacts.length ? "no contact" : "the system has no contacts"]);
    key(this.card.querySelector(".key"), parts);
    this.plot.say(`Contact force over time, at most ${told(top * this.drawn.factor)} ${this.drawn.unit}`);
  }

  draw(pen) {
    const { run } = this.view.page;
    const count = run.t.length;
    const times = run.t.map((each) => each * this.time.factor);
    const scaled = (values) => values.map((each) => each * this.drawn.factor);
    for (const i of this.contacts) {
      pen.dense(times, scaled(column(run.normal_force, i, count)), { stroke: colour(INKS[i % INKS.length]), width: 1.2 });
      if (this.tangential) pen.dense(times, scaled(column(run.tangential_force, i, count)), { stroke: colour("keyphasor"), width: 1 });
    }
    run.peak_force.forEach((each, i) => {
      if (this.contacts.includes(run.peak_contact[i])) pen.mark(run.peak_time[i] * this.time.factor, each * this.drawn.factor, 5, { fill: colour("card"), stroke: colour("ink"), width: 1 });
    });
    const now = times[this.view.now];
    pen.line([now, now], this.plot.shown.y, { stroke: colour("accent"), width: 1.5 });
  }

  table() {
    const { run } = this.view.page;
    const count = run.t.length;
    return { t: Array.from(run.t), ...Object.fromEntries(this.contacts.map((i) => [`normal force ${i}`, Array.from(column(run.normal_force, i, count))])) };
  }
}

/** Exact whirls over the speed: stable ones full, others dashed; special speeds; the speed now. */
export class SpeedMap extends Panel {
  constructor(card, view) {
    super(card, view, { x: "speed", y: "amplitude" });
  }

  show() {
    const { page } = this.view;
    if (!page.map) return;
    const { speed, amplitude, facts } = page.map;
    const note = facts.notes.map((each) => ["", each]);
    this.drawn = null;
    if (speed) {
      const finite = amplitude.filter((each) => Number.isFinite(each));
      const top = largest(finite) || 1;
      this.drawn = si(page, "m", top);
      this.speed = speedIn(page);
      this.plot.show({
        x: [speed[0] * this.speed.factor, speed.at(-1) * this.speed.factor], y: [0, roundUp(1.05 * top * this.drawn.factor)],
        labels: [labelled("speed", this.speed.unit), labelled(`amplitude at ${facts.node}`, this.drawn.unit)],
      });
    } else this.plot.show({});
    key(this.card.querySelector(".key"), speed ? [...(facts.free ? [["line-key", "whirl without contact, its largest radius about the mean place"]] : [["line-key", "stable"], ["line-key dashed", "unstable"]]), ...(facts.kinds?.length ? [["mark open", [...new Set(facts.kinds)].join(", ")]] : []), ["line-key passage", "speed of the run"], ...note] : note);
    this.plot.say(`Exact synchronous whirls at ${facts.node} over the speed`);
  }

  draw(pen) {
    const { map: { speed, amplitude, stability, special_speed: specials }, sketch } = this.view.page;
    const count = speed.length;
    const xs = speed.map((each) => each * this.speed.factor);
    const [low, high] = this.plot.shown.y;
    const present = Array.from(xs, (_, j) => amplitude.filter((each, k) => k % count === j && Number.isFinite(each)).length);
    for (let i = 0; i < amplitude.length / count; i++) {
      const ys = column(amplitude, i, count).map((each) => each * this.drawn.factor);
      const states = column(stability, i, count);
      // whirls are in the order of their amplitudes: where some end, another one may take their place
      const jumps = (j) => j > 0 && present[j] !== present[j - 1] && Math.abs(ys[j] - ys[j - 1]) > JUMP * (high - low);
      for (const [isStable, style] of [[true, { width: 1.8 }], [false, { width: 1.2, dash: [5, 4] }]]) {
        const points = [];
        ys.forEach((each, j) => {
          if (jumps(j)) points.push([NaN, NaN]); // a pen breaks off where x is none
          points.push((states[j] === STABILITY.stable) === isStable && states[j] !== STABILITY.absent ? [xs[j], each] : [NaN, NaN]);
        });
        pen.line(points.map(([x]) => x), points.map(([, y]) => y), { stroke: colour("ink"), ...style });
      }
    }
    specials?.forEach((each) => {
      const x = each * this.speed.factor;
      pen.line([x, x], [low, high], { stroke: colour("muted"), dash: [2, 3] });
      pen.mark(x, low + 0.95 * (high - low), 7, { fill: colour("card"), stroke: colour("ink") });
    });
    const now = sketch.speed * this.speed.factor;
    pen.line([now, now], [low, high], { stroke: colour("accent"), width: 1.5 });
  }

  table() {
    const { speed, amplitude, stability } = this.view.page.map;
    const count = speed?.length ?? 0;
    return { speed: Array.from(amplitude ?? [], (_, i) => speed[i % count]), amplitude: Array.from(amplitude ?? []), stability: Array.from(stability ?? []) };
  }
}

/** Whirl speeds over the speed of the rotor, with the line on which they are equal. */
export class Campbell extends Panel {
  constructor(card, view) {
    super(card, view, { x: "speed", y: "whirl speed" });
  }

  show() {
    const { page } = this.view;
    if (!page.campbell) return;
    const { speed, whirl_speed: rates, facts } = page.campbell;
    this.drawn = speed ? speedIn(page) : null;
    if (speed) {
      const { factor, unit } = this.drawn;
      const top = 2 * speed.at(-1) * factor;
      const low = rates.some((each) => each < 0) ? -top : 0;
      this.plot.show({ x: [speed[0] * factor, speed.at(-1) * factor], y: [low, top], labels: [labelled("speed", unit), labelled("whirl speed", unit)] });
    }
    key(this.card.querySelector(".key"), [...(speed ? [["line-key", "damped"], ["line-key contact", "growing"], ["line-key dashed", "speed of the rotor, ±1X"]] : []), ...facts.notes.map((each) => ["", each])]);
    this.plot.say("Campbell diagram: whirl speeds over the speed, backward whirl below 0");
  }

  draw(pen) {
    const { speed, whirl_speed: rates, damping } = this.view.page.campbell;
    const { factor } = this.drawn;
    const count = speed.length;
    const xs = speed.map((each) => each * factor);
    for (let i = 0; i < rates.length / count; i++) {
      const ys = column(rates, i, count).map((each) => each * factor);
      const grows = column(damping, i, count);
      pen.dots(xs, ys, 3, { fill: colour("ink") });
      pen.dots(xs.filter((_, j) => grows[j] < 0), ys.filter((_, j) => grows[j] < 0), 4, { fill: colour("contact") });
    }
    for (const order of [-1, 1]) pen.line([xs[0], xs.at(-1)], [order * xs[0], order * xs.at(-1)], { stroke: colour("muted"), dash: [5, 4] });
    const now = this.view.page.sketch.speed * factor;
    pen.line([now, now], this.plot.shown.y, { stroke: colour("accent"), width: 1.5 });
  }

  table() {
    const { speed, whirl_speed: rates, damping } = this.view.page.campbell;
    return { speed: Array.from(rates ?? [], (_, i) => speed[i % speed.length]), "whirl speed": Array.from(rates ?? []), "damping ratio": Array.from(damping ?? []) };
  }
}
