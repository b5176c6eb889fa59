// The panels of one rotor: starts and basin, orbits, radius and force over time, section.

import { extremes, scaled } from "./arrays.js";
import { Plot, colour, nearest } from "./plot.js";
import { roundUp } from "./state.js";
import { EVENTS, MODES, wordsOf } from "./tables.js";
import { addTools, fillKey } from "./tools.js";
import { labelled, shownIn, told } from "./units.js";

// Above this number of events in view their marks would hide the motion.
const MANY_EVENTS = 160;
const KINDS = {
  contact_free: "contact-free", synchronous: "synchronous in contact", bouncing: "bouncing",
  full_contact: "full contact", rolling: "rolling", touching: "touching", quasi_periodic: "quasi-periodic",
  chaotic: "chaotic", undecided: "not decided",
};
// Number of earlier revolutions drawn faintly.
const EARLIER = 24;
// Number of revolutions of a run-up whose orbit is drawn.
const FEW = 8;
const FLIGHT = [4, 3], BACKWARDS = [2, 1.5], SLEEPERS = [3, 4];
// Least number of pixels along a side of a basin picture, for hatching.
const PICTURE = 432;
// Hatching of regions, so that they differ by more than colour; others are plain.
const TILE = 18;
const tile = (isDark) => Uint8Array.from({ length: TILE * TILE }, (_, i) => isDark(i % TILE, Math.floor(i / TILE)));
const HATCHED = {
  bouncing: tile((column, row) => (column + row) % TILE < 3),
  full_contact: tile((column, row) => (column - row + TILE) % TILE < 3),
  synchronous: tile((column) => column < 3),
  chaotic: tile((column, row) => column % 9 < 3 && row % 9 < 3),
};
// Events of friction, at which the normal force is not 0.
const HELD = [EVENTS.roll, EVENTS.slip, EVENTS.reverse];
const PLAIN = new Uint8Array(TILE * TILE);
// Events of a contact by their kind; two come with damping in it, three with friction.
const EVENT_WORDS = wordsOf(EVENTS);
const SHAPES = {
  [EVENTS.entry]: "disc", [EVENTS.exit]: "disc", [EVENTS.press]: "square", [EVENTS.release]: "square",
  [EVENTS.roll]: "up", [EVENTS.slip]: "down", [EVENTS.reverse]: "cross",
};
// Kinds of motion with friction; a contact without force counts as slip.
const { flight: FLIES, slipping_forward: SLIPS, slipping_backward: SLIPS_BACK, rolling: ROLLS, loose: LOOSE } = MODES;
const BANDS = { [SLIPS]: ["contact", 0.09], [LOOSE]: ["contact", 0.09], [SLIPS_BACK]: ["backwards", 0.16], [ROLLS]: ["rolling", 0.24] };
const DARKER = 0.78;
// Revolutions per second of the animation.
const PLAYED = 1;

export class Side {
  /** Build the panels in `element`; `moved` receives the start dragged on the plane. */
  constructor(element, number, { moved, asked, told, shown }) {
    element.append(document.getElementById("side").content.cloneNode(true));
    Object.assign(this, { element, number, moved, asked, shown, motion: null, basin: null, sectionOf: null, time: 1, window: 8 });
    for (const radio of element.querySelectorAll('[type="radio"]')) radio.name = `drag${number}`;
    const at = (panel, plot = ".plot") => element.querySelector(`[data-panel="${panel}"] ${plot}`);
    this.panels = Object.fromEntries([...element.querySelectorAll("[data-panel]")].map((each) => [each.dataset.panel, each]));
    const plane = { equal: true, x: "x", y: "y" };
    this.starts = new Plot(at("starts"), { ...plane, draw: (pen) => this.#drawStarts(pen), reading: (x, y) => this.#readStart(x, y) });
    const orbit = (axes) => ({ ...plane, draw: (pen) => this.#drawOrbit(pen, axes), reading: (...where) => this.#readOrbit(axes, ...where) });
    this.orbit = new Plot(at("orbit"), orbit(""));
    this.turning = new Plot(at("turning"), orbit("rotating_"));
    const over = { below: (pen) => this.#shadeContacts(pen), draw: (pen) => this.#markTime(pen) };
    this.radius = new Plot(at("history", '[data-plot="radius"]'), { ...over, x: "", y: "radius", reading: (...where) => this.#readTime("radius", ...where), series: [{ stroke: () => colour("ink"), width: 1.2, points: { show: false } }] });
    this.force = new Plot(at("history", '[data-plot="force"]'), { ...over, x: "time", y: "force", reading: (...where) => this.#readTime("force", ...where), series: [{ stroke: () => colour("contact"), width: 1.2, points: { show: false } }], draw: (pen) => this.#drawForce(pen) });
    this.section = new Plot(at("section"), { ...plane, draw: (pen) => this.#drawSection(pen), reading: (...where) => this.#readSection(...where) });
    this.plots = [this.starts, this.orbit, this.turning, this.radius, this.force, this.section];
    this.radius.linked = [this.force];
    this.force.linked = [this.radius];
    for (const [name, panel] of Object.entries(this.panels)) {
      const plots = name === "history" ? [this.radius, this.force] : [this[name]];
      addTools(panel, plots, { name: () => name + (number ? "-second" : ""), told: () => told(this), table: () => this.#table(name) });
    }
    this.#listen();
  }

  get wantsBasin() {
    return this.element.querySelector("[data-basin]").checked;
  }

  #listen() {
    const { element } = this;
    this.slider = element.querySelector("[data-time]");
    this.slider.addEventListener("input", () => this.#goTo(Number(this.slider.value)));
    const window_ = element.querySelector("[data-window]");
    window_.addEventListener("change", () => {
      this.window = Number(window_.value);
      this.#show();
    });
    this.play = element.querySelector("[data-play]");
    this.play.addEventListener("click", () => this.#playOrStop());
    element.querySelector("[data-basin]").addEventListener("change", () => {
      this.basin = null;
      this.drawStarts();
      this.asked(this.number);
    });
    this.starts.onDrag((x, y, event) => {
      const { factor } = this.#scale("length", this.reach);
      const velocity = event.shiftKey || element.querySelector('[value="velocity"]').checked;
      this.moved({ x: x / factor, y: y / factor, velocity });
    });
  }

  #goTo(part) {
    this.time = part;
    this.slider.value = part;
    this.#show();
  }

  #show() {
    this.drawMotion();
    if (this.motion) this.#drawTurning();
  }

  #playOrStop() {
    const on = this.play.getAttribute("aria-pressed") === "true";
    this.play.setAttribute("aria-pressed", String(!on));
    this.play.textContent = on ? "▶ play" : "❚❚ stop";
    if (on) return;
    if (this.time >= 1) this.#goTo(0);
    let before = performance.now();
    const step = (now) => {
      if (this.play.getAttribute("aria-pressed") !== "true") return;
      const revolutions = this.motion ? (this.motion.arrays.t.length - 1) / this.motion.facts.samples_per_revolution : 60;
      const part = Math.min(this.time + ((now - before) * PLAYED) / (1000 * revolutions), 1);
      before = now;
      this.#goTo(part);
      if (part >= 1) this.#playOrStop();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  // answers received

  take(answer) {
    if (answer.part === "motion") {
      if (answer.facts.is_whole && !this.motion?.facts.is_whole) {
        this.window = 0;
        this.element.querySelector("[data-window]").value = 0;
      }
      this.motion = answer;
    } else if (answer.part === "section") this.sectionOf = answer;
    else if (answer.part === "basin") this.#takeBasin(answer);
  }

  /** Discard the data of a rotor no longer shown. */
  forget() {
    this.basin = this.sectionOf = null;
    this.reason = "";
  }

  /** Show the reason why there is no basin. */
  noBasin(message) {
    this.reason = message;
    this.#keyOfBasin();
  }

  #takeBasin(answer) {
    const { count, attractors, finest } = answer.facts;
    const kinds = {};
    this.colours = attractors.map(({ kind }) => shade(colour(kind) || colour("undecided"), (kinds[kind] = (kinds[kind] ?? -1) + 1)));
    const palette = this.colours.map(channels);
    const none = channels(colour("undecided"));
    // the first pictures arrive while a slider may still move, and are plain
    const hatches = attractors.map(({ kind }) => (finest && HATCHED[kind]) || PLAIN);
    const each = finest ? Math.ceil(PICTURE / count) : 1;
    const size = count * each;
    const image = new ImageData(size, size);
    const pixels = new Uint32Array(image.data.buffer);
    const fills = palette.map((parts) => [packed(parts, 1), packed(parts, DARKER)]);
    const undecided = [packed(none, 1)];
    answer.arrays.label.forEach((label, place) => {
      const [left, top] = [each * Math.floor(place / count), each * (count - 1 - (place % count))]; // x, then y
      const [fill, hatch] = [fills[label] ?? undecided, hatches[label] ?? PLAIN];
      for (let row = top; row < top + each; row++) {
        const line = (row % TILE) * TILE;
        for (let column = left; column < left + each; column++) pixels[row * size + column] = fill[hatch[line + (column % TILE)]];
      }
    });
    const picture = new OffscreenCanvas(size, size);
    picture.getContext("2d").putImageData(image, 0, 0);
    this.basin = answer;
    this.picture = picture;
  }

  // drawing

  #scale(kind, top) {
    return shownIn(this.motion?.facts.scales, kind, top);
  }

  /** Draw orbit, radius and force of a run. */
  drawMotion() {
    if (!this.motion) return;
    const { arrays, facts } = this.motion;
    const each = facts.samples_per_revolution;
    const last = arrays.t.length - 1;
    const now = Math.round(this.time * last);
    const wide = Math.round(this.window * each);
    this.view = { from: wide ? Math.max(0, Math.min(now, last) - wide) : 0, to: now, now };
    if (wide && now < wide) this.view.to = Math.min(last, wide);
    this.shown(this.time);
    const top = facts.ending.radius_max;
    const drawn = Math.max(top, facts.rotor.delta0, maximum(arrays.radius.subarray(this.view.from, this.view.to)));
    this.length = this.#scale("length", drawn);
    const reach = roundUp(1.08 * drawn * this.length.factor);
    this.plane = { x: [-reach, reach], y: [-reach, reach] };
    const rubs = Boolean(arrays.mode);
    for (const [name, hides] of Object.entries({ damped: !facts.rotor.contact_damping, friction: !rubs, frictionless: rubs })) {
      for (const each of this.element.querySelectorAll(`[data-${name}]`)) each.hidden = hides;
    }
    const { unit } = this.length;
    this.orbit.show({ ...this.plane, labels: [labelled("x", unit), labelled("y", unit)] });
    this.#drawHistory();
  }

  #drawTurning() {
    const { unit } = this.length;
    this.turning.show({ ...this.plane, labels: [labelled("along the unbalance", unit), labelled("across it", unit)] });
  }

  /** Draw the panels that may lag. */
  drawRest() {
    if (!this.length) return;
    this.#drawTurning();
    this.#drawSectionPlot();
    this.#say();
  }

  #drawHistory() {
    const { arrays } = this.motion;
    const { from, to } = this.view;
    const time = this.#scale("time", arrays.t.at(-1));
    const force = this.#scale("force", this.motion.facts.ending.largest_force);
    const end = this.window ? to : arrays.t.length - 1;
    Object.assign(this, { timeUnit: time, forceUnit: force });
    const seen = (name, { factor }) => scaled(arrays[name].subarray(from, end + 1), factor);
    const [times, radii, forces] = [seen("t", time), seen("radius", this.length), seen("force", force)];
    const x = [arrays.t[from] * time.factor, arrays.t[end] * time.factor];
    const most = Math.max(maximum(radii), this.motion.facts.rotor.delta0 * this.length.factor);
    this.radius.show({ data: [times, radii], x, y: [0, roundUp(1.05 * most)], labels: ["", labelled("radius", this.length.unit)] });
    const hardest = Math.max(maximum(forces), ...this.#peaks(from, end).map(([, peak]) => peak), 0);
    this.force.show({ data: [times, forces], x, y: [0, roundUp(1.05 * hardest || 1)], labels: [labelled("time", time.unit), labelled("force", force.unit)] });
  }

  #peaks(from, to) {
    const { t, peak_time: times, peak_force: forces } = this.motion.arrays;
    const found = Array.from(times, (time, i) => [time, forces[i]]).filter(([time]) => time >= t[from] && time <= t[to]);
    return found.map(([time, force]) => [time * this.timeUnit.factor, force * this.forceUnit.factor]);
  }

  #shadeContacts(pen) {
    if (!this.forceUnit) return;
    const { entry_time: entries, exit_time: exits, t, mode } = this.motion.arrays;
    const { factor } = this.timeUnit;
    if (mode) this.#shadeModes(pen);
    else entries.forEach((entry, i) => pen.band((Number.isNaN(entry) ? t[0] : entry) * factor, (Number.isNaN(exits[i]) ? t.at(-1) : exits[i]) * factor, tint(colour("contact"), 0.09)));
  }

  /** Shade the phases of contact between events; those shorter than a sample are invisible. */
  #shadeModes(pen) {
    const { event_time: times, t, mode } = this.motion.arrays;
    const { factor } = this.timeUnit;
    let i = 0;
    for (let event = -1; event < times.length; event++) {
      const [from, to] = [event < 0 ? t[0] : times[event], event + 1 < times.length ? times[event + 1] : t.at(-1)];
      while (i < t.length && t[i] < from) i += 1;
      const band = t[i] < to || event < 0 ? BANDS[mode[i]] : null;
      if (band) pen.band(from * factor, to * factor, tint(colour(band[0]), band[1]));
    }
  }

  #markTime(pen) {
    if (!this.forceUnit) return;
    const { t, event_time: times, event_kind: kinds } = this.motion.arrays;
    const ring = this.motion.facts.rotor.delta0 * this.length.factor;
    pen.line([t[0] * this.timeUnit.factor, t.at(-1) * this.timeUnit.factor], [ring, ring], { stroke: colour("muted"), dash: [5, 4] });
    const [low, high] = this.radius.range.x;
    for (const i of this.#eventsIn(low / this.timeUnit.factor, high / this.timeUnit.factor)) {
      pen.mark(times[i] * this.timeUnit.factor, this.#radiusOf(i), 7, markOf(kinds[i]));
    }
    this.#line(pen, t, 1e9);
  }

  /** Return the distance from the axis at an event: the stator's, but inside it for the others. */
  #radiusOf(event) {
    const { event_kind: kinds, event_radius: radii } = this.motion.arrays;
    return this.length.factor * (Math.abs(kinds[event]) === 1 ? this.motion.facts.rotor.delta0 : radii[event]);
  }

  #drawForce(pen) {
    if (!this.forceUnit) return;
    const { t } = this.motion.arrays;
    for (const [time, force] of this.#peaks(this.view.from, this.window ? this.view.to : t.length - 1)) {
      pen.mark(time, force, 5, { fill: colour("card"), stroke: colour("contact"), width: 1.2 });
    }
    this.#line(pen, t, 1e9);
  }

  #line(pen, t, top) {
    const now = t[this.view.now] * this.timeUnit.factor;
    pen.line([now, now], [-top, top], { stroke: colour("accent"), width: 1.2 });
  }

  #drawOrbit(pen, axes) {
    if (!this.length) return;
    const { arrays, facts } = this.motion;
    const { factor } = this.length;
    const [xs, ys] = [scaled(arrays[`${axes}x`], factor), scaled(arrays[`${axes}y`], factor)];
    pen.circle(0, 0, facts.rotor.delta0 * factor, { stroke: colour("muted"), dash: [5, 4], width: 1.2 });
    const { now, from } = this.#turnsDrawn();
    const before = Math.max(0, from - Math.round(EARLIER * facts.samples_per_revolution));
    pen.line(xs, ys, { from: before, to: from + 1, stroke: colour("muted"), width: 0.6, alpha: 0.35 });
    const modes = arrays.mode ?? Int8Array.from(arrays.radius, (radius) => (radius <= facts.rotor.delta0 ? FLIES : SLIPS));
    drawModes(pen, xs, ys, modes, { from, to: now + 1 });
    this.#drawEvents(pen, axes);
    for (const i of this.#turns(from, now)) {
      pen.mark(xs[i], ys[i], 8, { shape: "diamond", fill: colour("keyphasor"), stroke: colour("card"), width: 1 });
    }
    const [x, y] = [xs[now], ys[now]];
    // of a node of a system no mass centre is known
    const angle = axes ? 0 : facts.rotor.omega * arrays.t[now];
    if (!facts.told) pen.arrow(x, y, factor * Math.cos(angle), factor * Math.sin(angle), { stroke: colour("ink") });
    pen.mark(x, y, 9, { fill: colour("accent"), stroke: colour("card") });
  }

  /** Return the part of the run whose orbit is drawn: of a run-up its last turns, as all would hide each other. */
  #turnsDrawn() {
    const { from, now } = this.view, { arrays, facts } = this.motion;
    return { now, from: arrays.band_speed ? Math.max(from, now - Math.round(FEW * facts.samples_per_revolution)) : from };
  }

  /** Return the samples once a revolution; none where a revolution is no whole number of them. */
  #turns(from, to) {
    const turn = this.motion.facts.samples_per_revolution;
    const first = Math.ceil(from / turn) * turn;
    return Number.isInteger(turn) && first <= to ? Array.from({ length: Math.floor((to - first) / turn) + 1 }, (_, i) => first + i * turn) : [];
  }

  #drawEvents(pen, axes) {
    const { arrays } = this.motion;
    const { from, now } = this.#turnsDrawn();
    const [xs, ys] = ["x", "y"].map((axis) => scaled(arrays[`event_${axes}${axis}`], this.length.factor));
    for (const i of this.#eventsIn(arrays.t[from], arrays.t[now])) pen.mark(xs[i], ys[i], 6, markOf(arrays.event_kind[i]));
  }

  /** Return the events between two times, or none if they would be too many to see the motion. */
  #eventsIn(low, high) {
    const times = this.motion.arrays.event_time;
    const seen = [...times.keys()].filter((i) => times[i] >= low && times[i] <= high);
    return seen.length > MANY_EVENTS ? [] : seen;
  }

  #drawSectionPlot() {
    const { xs, ys } = this.#sectionPoints();
    const reach = Math.max(...[xs, ys].flatMap((each) => extremes(each, [0, 0])).map(Math.abs));
    const { factor, unit } = this.length;
    const all = roundUp(1.15 * reach || this.motion.facts.rotor.delta0) * factor;
    this.section.show({ x: [-all, all], y: [-all, all], labels: [labelled("along the unbalance", unit), labelled("across it", unit)] });
    const key = this.panels.section.querySelector("[data-key]");
    const drawn = xs.length ? "the last half of the run, once a revolution" : "none: a revolution of this run is no whole number of its samples";
    key.textContent = this.sectionOf ? `settled: ${xs.length} points, once a revolution` : drawn;
  }

  #sectionPoints() {
    if (this.sectionOf) return { xs: this.sectionOf.arrays.section_x, ys: this.sectionOf.arrays.section_y };
    const { section_x: xs, section_y: ys } = this.motion.arrays;
    const half = Math.floor(xs.length / 2);
    return { xs: xs.slice(half), ys: ys.slice(half) };
  }

  #drawSection(pen) {
    if (!this.length) return;
    const { xs, ys } = this.#sectionPoints(), { factor } = this.length;
    pen.circle(0, 0, this.motion.facts.rotor.delta0 * factor, { stroke: colour("muted"), dash: [5, 4] });
    const many = xs.length > 1000;
    pen.dots(scaled(xs, factor), scaled(ys, factor), many ? 2 : 5, { fill: colour("ink"), alpha: many ? 0.6 : 0.8 });
  }

  /** Draw the plane of starts, with the basin if there is one. */
  drawStarts(start = this.start, reach = this.reach) {
    Object.assign(this, { start, reach });
    if (!start || !this.motion) return;
    const { factor, unit } = this.#scale("length", reach);
    this.starts.show({ x: [-reach * factor, reach * factor], y: [-reach * factor, reach * factor], labels: [labelled("x of the start", unit), labelled("y of the start", unit)] });
    this.#keyOfBasin();
  }

  #drawStarts(pen) {
    if (!this.start || !this.motion) return;
    const { factor } = this.#scale("length", this.reach);
    if (this.basin) {
      const edge = this.basin.facts.reach * factor;
      pen.image(this.picture, -edge, edge, edge, -edge);
    }
    pen.circle(0, 0, this.motion.facts.rotor.delta0 * factor, { stroke: colour("ink"), dash: [5, 4], alpha: 0.7 });
    const [x, y, vx, vy] = this.start.map((each) => each * factor);
    pen.arrow(x, y, vx, vy, { stroke: colour("card"), width: 4 });
    pen.arrow(x, y, vx, vy, { stroke: colour("ink"), width: 2 });
    pen.mark(x, y, 12, { fill: colour("card"), stroke: colour("ink"), width: 2 });
  }

  /** Return the numbers of a panel, by the names of its columns. */
  #table(panel) {
    const { arrays } = this.motion;
    const time = this.force.label(0), radius = this.radius.label(1), force = this.force.label(1);
    const [times, radii, forces] = [[arrays.t, this.timeUnit], [arrays.radius, this.length], [arrays.force, this.forceUnit]]
      .map(([values, { factor }]) => [...scaled(values, factor)]);
    if (panel === "section") {
      const { xs, ys } = this.#sectionPoints(), { factor } = this.length;
      return [[0, 1].map((axis) => this.section.label(axis)), ...Array.from(xs, (x, i) => [x * factor, ys[i] * factor])];
    }
    if (panel === "starts") return this.#tableOfStarts();
    if (panel !== "history") {
      const [xs, ys] = ["x", "y"].map((axis) => scaled(arrays[panel === "orbit" ? axis : `rotating_${axis}`], this.length.factor));
      return [[time, this[panel].label(0), this[panel].label(1), radius], ...times.map((each, i) => [each, xs[i], ys[i], radii[i]])];
    }
    const rows = times.map((each, i) => [each, "sample", radii[i], forces[i]]);
    arrays.event_time.forEach((each, i) => rows.push([each * this.timeUnit.factor, EVENT_WORDS[arrays.event_kind[i]], this.#radiusOf(i), HELD.includes(arrays.event_kind[i]) ? NaN : 0]));
    for (const [at, peak] of this.#peaks(0, times.length - 1)) rows.push([at, "peak", NaN, peak]);
    rows.sort(([one], [other]) => one - other);
    return [[time, "what", radius, force], ...rows];
  }

  /** Return each start of the plane and its end, or without a basin the start alone. */
  #tableOfStarts() {
    const { factor } = this.#scale("length", this.reach);
    const names = [this.starts.label(0), this.starts.label(1)];
    if (!this.basin) return [names, [this.start[0] * factor, this.start[1] * factor]];
    const { count, reach } = this.basin.facts;
    const middle = (place) => factor * reach * ((2 * place + 1) / count - 1);
    const row = (label, i) => [middle(Math.floor(i / count)), middle(i % count), label, this.#kindOf(label)];
    return [[...names, "attractor", "settles on"], ...Array.from(this.basin.arrays.label, row)];
  }

  /** Return in words the kind of motion that a label of the basin is of. */
  #kindOf(label) {
    return KINDS[this.basin.facts.attractors[label]?.kind ?? "undecided"];
  }

  // description of the place under the pointer

  #readStart(x, y) {
    if (!this.basin) return null;
    const { count, reach } = this.basin.facts;
    const { factor } = this.#scale("length", this.reach);
    const [column, row] = [x, y].map((each) => Math.floor(0.5 * count * (each / (factor * reach) + 1)));
    if (Math.min(column, row) < 0 || Math.max(column, row) >= count) return null;
    return { text: `${this.#kindOf(this.basin.arrays.label[column * count + row])}: ${this.starts.tell([x, y], ["x", "y"])}` };
  }

  #readOrbit(axes, x, y, distance, near) {
    if (!this.length) return null;
    const { arrays } = this.motion;
    const { t, event_time: times, event_kind: kinds } = arrays;
    const { factor } = this.length;
    const { from, now } = this.#turnsDrawn();
    const [low, high] = [t[from], t[now]];
    const [xs, ys, ex, ey] = [`${axes}x`, `${axes}y`, `event_${axes}x`, `event_${axes}y`].map((name) => scaled(arrays[name], factor));
    const places = this.#turns(from, now).map((i) => [xs[i], ys[i], "once a revolution", t[i]]);
    times.forEach((time, i) => time >= low && time <= high && places.push([ex[i], ey[i], EVENT_WORDS[kinds[i]], time]));
    const samples = Array.from({ length: now - from + 1 }, (_, i) => [xs[from + i], ys[from + i], "at", t[from + i]]);
    const found = nearest(places, distance, near) ?? nearest(samples, distance, near);
    const [a, b, name, time] = found ?? [x, y];
    const { factor: second, unit } = this.timeUnit;
    const when = found ? `${name} t = ${told(time * second, 7)}${unit && ` ${unit}`}: ` : "";
    return { text: `${when}${this.orbit.tell([a, b], ["x", "y"])}, ${this.radius.tell([0, Math.hypot(a, b)]).split(", ")[1]}`, at: found };
  }

  #readTime(name, x, _y, distance, near) {
    if (!this.forceUnit) return null;
    const { plot } = this[name];
    const { arrays } = this.motion, { factor, unit } = this.timeUnit;
    const { unit: other } = name === "radius" ? this.length : this.forceUnit;
    const told_ = (kind, [time, value]) => ({ text: `${kind}time ${told(time, 8)}${unit && ` ${unit}`}, ${name} ${told(value, 6)}${other && ` ${other}`}`, at: [time, value] });
    const beside = (time) => Math.abs(plot.valToPos(time * factor, "x") - plot.valToPos(x, "x"));
    if (name === "force") {
      const peak = this.#peaks(0, arrays.t.length - 1).find((at) => distance(...at) < near);
      if (peak) return told_("peak: ", peak);
    }
    const height = (event) => (name === "radius" ? this.#radiusOf(event) : 0);
    const isShown = (event) => name === "radius" || !HELD.includes(arrays.event_kind[event]);
    const events = [];
    arrays.event_time.forEach((time, i) => isShown(i) && beside(time) < 0.5 * near && events.push([time * factor, height(i), EVENT_WORDS[arrays.event_kind[i]]]));
    const event = nearest(events, distance, near);
    if (event) return told_(`${event[2]}: `, event);
    const [times, values] = this[name].data;
    const i = plot.valToIdx(x);
    return times.length ? told_("", [times[i], values[i]]) : null;
  }

  #readSection(_x, _y, distance, near) {
    if (!this.length) return null;
    const { xs, ys } = this.#sectionPoints();
    const at = nearest(Array.from(xs, (x, i) => [x, ys[i]].map((each) => each * this.length.factor)), distance, near);
    return at ? { text: `point: ${this.section.tell(at)}`, at } : null;
  }

  #keyOfBasin() {
    const key = this.panels.starts.querySelector("[data-key]");
    if (!this.basin) {
      fillKey(key, this.wantsBasin ? [["", this.reason || "computing the basin …"]] : []);
      this.starts.say("The plane of starts.");
      return;
    }
    const { attractors, undecided, finest, count } = this.basin.facts;
    const { factor, unit } = this.#scale("length", this.reach);
    const parts = attractors.map(({ kind, fraction, radius_max: radius }, place) => {
      const alone = attractors.filter((each) => each.kind === kind).length === 1;
      const which = alone || radius === null ? "" : ` to radius ${told(radius * factor, 3)}${unit && ` ${unit}`}`;
      return [KINDS[kind] + which, fraction, this.colours[place], kind];
    });
    if (undecided > 0) parts.push([KINDS.undecided, undecided, colour("undecided")]);
    const items = parts.filter(([, part]) => part > 0).map(([name, part, fill, kind]) => [`swatch ${HATCHED[kind] ? kind : ""}`, `${name} ${told(100 * part, 3)} %`, fill]);
    fillKey(key, [...items, ...(finest ? [] : [["", `${count}² starts, finer soon`]])]);
    this.starts.say(`Basins of the starts at this velocity: ${parts.map(([name, part]) => `${name} ${told(100 * part, 3)} %`).join(", ")}.`);
  }

  #say() {
    const { ending, rotor } = this.motion.facts;
    const { factor, unit } = this.length;
    const number = (value) => `${told(value * factor)}${unit ? ` ${unit}` : ""}`;
    const radii = `radius from ${number(ending.radius_min)} to ${number(ending.radius_max)}`;
    const rolls = ending.rolling_fraction > 0 ? `, rolling ${told(100 * ending.rolling_fraction, 3)} % of the time in contact` : "";
    this.orbit.say(`Orbit on fixed axes: ${radii}, stator at ${number(rotor.delta0)}${rolls}.`);
    this.turning.say(`Orbit on axes that turn with the unbalance: ${radii}.`);
    this.radius.say(`Radius over time: over the last half from ${number(ending.radius_min)} to ${number(ending.radius_max)}.`);
    this.force.say(`Contact force over time: up to ${told(ending.largest_force * this.forceUnit.factor)} ${this.forceUnit.unit} over the last half.`);
    this.section.say("Section: the rotor once a revolution, on axes that turn with the unbalance.");
  }
}

/** Draw an orbit in the colours of flight, forward slip or contact without friction, backward slip, and rolling. */
function drawModes(pen, xs, ys, modes, stretch) {
  const draw = (wanted, look) => {
    // a step that begins or ends in another mode is drawn in both, the later one above
    const gap = (i) => !wanted.includes(modes[i]) && !wanted.includes(modes[Math.max(i - 1, 0)]);
    pen.line(xs, ys, { ...stretch, ...look, gap });
  };
  draw([FLIES], { stroke: colour("flight"), width: 1.5, dash: FLIGHT });
  draw([SLIPS, LOOSE], { stroke: colour("contact"), width: 1.9 });
  draw([SLIPS_BACK], { stroke: colour("backwards"), width: 2.2, dash: BACKWARDS });
  draw([ROLLS], { stroke: colour("rolling"), width: 3.4 });
  draw([ROLLS], { stroke: colour("card"), width: 1, dash: SLEEPERS });
}

const markOf = (kind) => ({
  shape: SHAPES[kind],
  ...(SHAPES[kind] === "cross" ? { stroke: colour("ink"), width: 1.5 } : kind > 0 ? { fill: colour("ink"), stroke: colour("card"), width: 0.8 } : { fill: colour("card"), stroke: colour("ink"), width: 1.2 }),
});

const maximum = (values) => extremes(values, [0, 0])[1];

/** Return the red, green and blue of a computed colour. */
const channels = (text) => text.match(/\d+/g).slice(0, 3).map(Number);

/** Return a colour as four bytes of a picture, at a fraction of its lightness. */
const packed = ([red, green, blue], light) =>
  ((255 << 24) | (Math.round(blue * light) << 16) | (Math.round(green * light) << 8) | Math.round(red * light)) >>> 0;

const tint = (text, alpha) => `rgba(${channels(text).join(",")},${alpha})`;

/** Return a colour for another attractor of the same kind: each one lighter. */
const shade = (text, step) => `rgb(${channels(text).map((each) => Math.round(each + (255 - each) * Math.min(0.28 * step, 0.8))).join(",")})`;
