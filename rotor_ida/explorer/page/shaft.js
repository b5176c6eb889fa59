// Panels of a rotor of some nodes: its sketch, and the shape of its shaft as it moves.

import { extremes, nearestIn } from "./arrays.js";
import { Plot, colour, numbers } from "./plot.js";
import { file, state } from "./state.js";
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
const TRAIL = 1 / 20; // of the run, in bold behind the rotor

const lengthLabel = () => (file.has_positions ? labelled("axial position", file.units === "SI" ? "m" : "") : "nodes at equal distances");
/** Without positions the axis has no scale, and no numbers. */
const scaleOfAxis = (plot) => (plot.plot.axes[0].values = file.has_positions ? numbers : (_plot, splits) => splits.map(() => ""));

/** Return the ends of the axis along the shaft; a single node is in its middle. */
function along(positions, margin) {
  const [low, high] = extremes(positions);
  const beyond = margin * (high - low) || 0.5;
  return [low - beyond, high + beyond];
}

class Panel {
  constructor(card, words, options) {
    this.card = card;
    this.plot = new Plot(card.querySelector(".plot"), { draw: (pen) => this.drawn && this.draw(pen), ...options });
    addTools(card, [this.plot], { name: () => card.dataset.panel, told: words, table: () => this.table() });
  }
}

/** Shaft, masses, unbalance, contacts and supports; a click chooses. */
export class Sketch extends Panel {
  constructor(card, words, choose) {
    super(card, words, { x: "axial position", y: "", steps: [1000], unnumbered: true });
    this.plot.onDrag((x, y, event) => event.type === "pointerdown" && this.#choose(x, y, choose));
  }

  show() {
    const { positions, nodes } = file;
    this.drawn = true;
    scaleOfAxis(this.plot);
    this.plot.show({ x: along(positions, 0.06), y: [-1.05, 1.45], labels: [lengthLabel(), ""] });
    this.plot.say(`Sketch of the rotor with the nodes ${nodes.join(", ")}`);
  }

  #choose(x, y, choose) {
    const { positions, nodes, contacts } = file;
    const ofContacts = contacts.map(({ node }) => positions[nodes.indexOf(node)]);
    if (Math.abs(y) > ABOVE && contacts.length) choose({ contact: nearestIn(ofContacts, x) });
    else choose({ node: nodes[nearestIn(positions, x)] });
  }

  draw(pen) {
    const { positions, nodes, masses, contacts, supports, unbalance, node } = file;
    const at = (name) => positions[nodes.indexOf(name)];
    const heaviest = Math.max(...masses) || 1;
    pen.line(extremes(positions), [0, 0], { stroke: colour("muted"), width: 5 });
    positions.forEach((x, i) => {
      const half = TALLEST * Math.sqrt(masses[i] / heaviest);
      pen.line([x, x], [-half, half], { stroke: colour("muted"), width: 9, alpha: 0.55 });
    });
    contacts.forEach(({ node: name }, i) => {
      const x = at(name);
      const ink = i === state.contact ? "accent" : "contact";
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
    const { nodes, positions, masses } = file;
    return [["node", "position", "mass"], ...nodes.map((node, i) => [node, positions[i], masses[i]])];
  }
}

/** All nodes now, in an oblique view, with their orbits and clearances. */
export class Shape extends Panel {
  constructor(card, words) {
    super(card, words, { x: "axial position", y: "deflection" });
  }

  take({ arrays: { shape_x: x, shape_y: y } }) {
    Object.assign(this, { x, y });
  }

  /** Show the shape after a part of the run. */
  show(part) {
    if (!this.x) return;
    const { positions, contacts, units } = file;
    this.count = this.x.length / positions.length;
    this.now = Math.round(part * (this.count - 1));
    const top = Math.max(...[this.x, this.y].flatMap((each) => extremes(each)).map(Math.abs), ...contacts.map(({ clearance }) => clearance)) || 1;
    this.drawn = units === "SI" ? prefixed("m", top) : { factor: 1, unit: "" };
    const [low, high] = extremes(positions);
    this.along = (ALONG * (high - low || 1)) / (top * this.drawn.factor);
    const limit = (1 + DOWN) * top * this.drawn.factor;
    scaleOfAxis(this.plot);
    this.plot.show({ x: along(positions, 0.08), y: [-limit, limit], labels: [lengthLabel(), labelled("deflection", this.drawn.unit)] });
    this.plot.say(`Deflected shape after ${told(100 * part, 3)} % of the run`);
  }

  draw(pen) {
    const { positions, nodes, contacts } = file;
    const { count, now, drawn: { factor } } = this;
    const begin = Math.max(now - Math.ceil(TRAIL * count), 0);
    const place = (z, x, y) => [z - this.along * x * factor, (y - DOWN * x) * factor];
    const path = (z, xs, ys, style) => {
      const points = Array.from(xs, (x, i) => place(z, x, ys[i]));
      pen.line(points.map(([x]) => x), points.map(([, y]) => y), style);
    };
    pen.line(extremes(positions), [0, 0], { stroke: colour("muted"), dash: [8, 3, 2, 3] });
    const turns = Array.from({ length: POINTS + 1 }, (_, i) => (TURN * i) / POINTS);
    for (const { node, clearance, centre } of contacts) {
      path(positions[nodes.indexOf(node)], turns.map((a) => centre[0] + clearance * Math.cos(a)), turns.map((a) => centre[1] + clearance * Math.sin(a)), { stroke: colour("contact"), width: 1.4 });
    }
    const ends = nodes.map((_, i) => {
      const [x, y] = [this.x, this.y].map((each) => each.subarray(i * count, (i + 1) * count));
      path(positions[i], x.subarray(begin, now + 1), y.subarray(begin, now + 1), { stroke: colour("accent"), alpha: 0.55 });
      return place(positions[i], x[now], y[now]);
    });
    pen.line(ends.map(([x]) => x), ends.map(([, y]) => y), { stroke: colour("ink"), width: 3 });
    for (const [x, y] of ends) pen.mark(x, y, 7, { fill: colour("ink"), stroke: colour("card") });
  }

  table() {
    const { nodes, positions } = file;
    const at = (values, i) => values[i * this.count + this.now];
    return [["node", "position", "x", "y"], ...nodes.map((node, i) => [node, positions[i], at(this.x, i), at(this.y, i)])];
  }
}
