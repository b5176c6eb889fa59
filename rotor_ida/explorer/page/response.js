// The response curve: exact whirls with their folds and Hopf points, branches of limit cycles, and the rotors.

import { extremes, scaled } from "./arrays.js";
import { Plot, colour, nearest } from "./plot.js";
import { isSystem, roundUp, speedsShown } from "./state.js";
import { SPECIAL, STABILITY, wordsOf } from "./tables.js";
import { fillKey } from "./tools.js";
import { labelled, shownIn } from "./units.js";

// Dashes repeat the meaning of colours: lines and gaps in pixels.
const UNSTABLE_DASH = [5, 4], FREE_DASH = [12, 3, 2, 3];
const LONGEST_TRAIL = 600;
const STABLE = STABILITY.stable;
export const UNSTABLE = STABILITY.unstable;
const { fold: FOLD, period_doubling: DOUBLING, torus: TORUS, sliding: SLIDING, hopf: HOPF, discontinuous: DISCONTINUOUS } = SPECIAL;
const SPECIAL_WORDS = { [FOLD]: "fold of limit cycles", [DOUBLING]: "period doubling", [TORUS]: "torus point", [SLIDING]: "slip falls to 0", [HOPF]: "Hopf point", [DISCONTINUOUS]: "multipliers jump" };
const SHAPES = { [FOLD]: "diamond", [DOUBLING]: "square", [TORUS]: "disc", [SLIDING]: "cross", [HOPF]: "disc", [DISCONTINUOUS]: "down" };
// Points of branches that are in the key only where there are some.
const RARE = [[TORUS, "mark open cycle"], [SLIDING, "mark cross cycle"], [DISCONTINUOUS, "mark down"]];
// Friction-driven whirls: the name, the radii and the stability of each.
const WHIRLS = [["slipping backward whirl", "saddle_radius", "unstable"], ["dry whip without unbalance", "whip_radius", "stable"]];
// Points of the curve: the name, that of its arrays, and the shape; a Hopf point is open.
const MARKED = [["fold", "fold", "diamond"], ["graze", "graze", "up"], ["Hopf point", "hopf", "disc"]];
const WHIP_ROOM = 1.5;

export class Response {
  /** Build the panel; `moved` receives the speed to which it is dragged, in units of the page. */
  constructor(element, moved) {
    this.sides = [{ branches: [], trail: [] }, { branches: [], trail: [] }];
    this.two = false;
    this.plot = new Plot(element, { x: "speed", y: "radius", draw: (pen) => this.#draw(pen), reading: (...where) => this.#reading(...where) });
    this.plot.onDrag((x) => moved(x, speedsShown()[0] * (this.speed?.factor ?? 1)));
  }

  /** Return what is drawn of a side: lines and points over the speed, with radii and stability. */
  #items({ curve, branches, trail, place, passage }) {
    const items = [], words = wordsOf(STABILITY), points = { isPoint: true };
    const add = (what, omega, high, more) => omega?.length && items.push({ what: () => what, omega, high, low: high, stability: () => "", joins: () => true, ...more });
    const { omega, amplitude, stability, piece, in_contact: contact, ...marks } = curve?.arrays ?? {};
    for (const [name, key, told] of WHIRLS) add(name, marks.whip_omega, marks[key], { stability: () => told });
    add("", omega, amplitude, {
      what: (i) => (contact[i] ? "whirl in contact" : "contact-free whirl"), stability: (i) => words[stability[i]] ?? "",
      joins: (i) => piece[i] === piece[i - 1] && piece[i] >= 0,
    });
    for (const [what, name] of MARKED) add(what, marks[`${name}_omega`], marks[`${name}_amplitude`], points);
    for (const { arrays: { special_kind: kinds, special_point: places, ...arrays } } of branches) {
      add("limit cycle", arrays.omega, arrays.radius_max, { low: arrays.radius_min, stability: (i) => words[arrays.stability[i]] ?? "" });
      const at = (point) => arrays.radius_max[Math.min(Math.max(Math.round(point), 0), arrays.omega.length - 1)];
      add("", arrays.special_omega, places.map(at), { what: (i) => SPECIAL_WORDS[kinds[i]], ...points });
    }
    if (passage) add("while the speed changes", passage.omega, passage.high, { low: passage.low });
    const of = (name, list) => list.map((each) => each[name]);
    add("half way of a jump", of("omega", passage?.jumps ?? []), of("radius", passage?.jumps ?? []), points);
    const steps = trail.includes(place) || !place ? trail : [...trail, place];
    add("the rotor", of("omega", steps), of("high", steps), { low: of("low", steps), ...points });
    return items;
  }

  /** Return the numbers of the panel: curves, folds, branches, and tracks of the rotors. */
  table() {
    const largest = this.plot.label(1);
    const rows = this.#shown.flatMap((side, number) => this.#items(side).flatMap(({ what, omega, high, low, stability }) =>
      Array.from(omega, (each, i) => [number + 1, what(i), each * this.speed.factor, high[i] * this.length.factor, low[i] * this.length.factor, stability(i)])));
    return [["rotor", "what", this.plot.label(0), largest, largest.replace("radius", "smallest radius"), "stability"], ...rows.filter(([, what, each]) => what && !Number.isNaN(each))];
  }

  get #shown() {
    return this.sides.slice(0, this.two ? 2 : 1);
  }

  take(answer) {
    const side = this.sides[answer.side];
    if (answer.part === "curve") {
      const key = JSON.stringify({ ...answer.facts.rotor, omega: 0 });
      if (key !== side.key) Object.assign(side, { key, branches: [], trail: [] });
      side.curve = answer;
    } else if (answer.part === "branch") {
      const same = (each) => each.arrays.omega.length === answer.arrays.omega.length && each.arrays.omega[0] === answer.arrays.omega[0];
      if (!side.branches.some(same)) side.branches.push(answer);
    } else if (answer.part === "motion") {
      const { rotor, ending } = answer.facts;
      side.place = { omega: rotor.omega, low: ending.radius_min, high: ending.radius_max, scales: answer.facts.scales };
      const { band_speed: omega, band_low: low, band_high: high } = answer.arrays;
      if (omega) side.passage = { omega, low, high, jumps: [], highest: extremes(high)[1], isArchived: true };
      else if (side.passage?.isArchived) side.passage = undefined;
      if (omega) Object.assign(side.place, { omega: omega.at(-1), low: low.at(-1), high: high.at(-1) });
      side.trail.push(side.place);
      if (side.trail.length > LONGEST_TRAIL) side.trail.shift();
    }
  }

  /** Show the motion of each side while the speed changes, and its progress. */
  pass(tracks, omega) {
    this.sides.forEach((side, number) => {
      side.passage = tracks[number];
      if (!side.passage || omega === undefined) return;
      const [low, high] = side.passage.extent;
      side.place = { omega, low, high, scales: side.passage.scales };
    });
  }

  /** Discard the track of a side. */
  forgetTrail() {
    for (const side of this.sides) side.trail = [];
  }

  show() {
    const shown = this.#shown.filter((side) => side.curve);
    if (!shown.length) return;
    const scales = shown[0].place?.scales;
    const largest = (valuesOf, least) => shown.flatMap(valuesOf).reduce((most, each) => extremes(each ?? [], [0, most])[1], least);
    const last = largest(({ curve, place }) => [curve.arrays.omega, [place?.omega]], speedsShown()[1]);
    const least = largest(({ curve, place, branches, passage }) => [
      curve.arrays.amplitude, ...branches.map(({ arrays }) => arrays.radius_max), [passage?.highest, place?.high, curve.facts.rotor.delta0],
    ], isSystem() ? 0 : 1);
    // of dry whip, which may lie far above the rest, as much as leaves the rest its room
    const top = Math.min(largest(({ curve }) => WHIRLS.map(([, key]) => curve.arrays[key]), least), WHIP_ROOM * least);
    this.length = shownIn(scales, "length", top);
    this.speed = shownIn(scales, "rate", 1);
    this.plot.show({
      x: [0, last * this.speed.factor], y: [0, roundUp(1.05 * top * this.length.factor)],
      labels: [labelled(this.speed.unit ? "speed" : "speed ω", this.speed.unit), labelled("radius", this.length.unit)],
    });
    this.#say(shown);
    this.#key(shown);
  }

  #key(shown) {
    const parts = [];
    const reasons = new Set(shown.map(({ curve }) => curve.facts.why).filter(Boolean));
    if (shown.some(({ curve }) => curve.arrays.in_contact.includes(1))) {
      parts.push(["line-key", "exact whirl in contact"], ["line-key dashed", "unstable"], ["mark diamond", "fold"]);
    }
    const hasAny = (name) => shown.some(({ curve }) => curve.arrays[name]?.length);
    if (hasAny("hopf_omega")) parts.push(["mark open", "Hopf point"]);
    if (hasAny("graze_omega")) parts.push(["mark up", "graze"]);
    if (shown.some(({ curve }) => curve.arrays.in_contact.includes(0))) parts.push(["line-key free", "contact-free whirl"]);
    if (hasAny("whip_omega")) {
      parts.push(["line-key whip", "dry whip without unbalance"], ["line-key saddle", "slipping backward whirl, a saddle"]);
    }
    if (shown.some(({ branches }) => branches.length)) {
      parts.push(["line-key cycle", "limit cycle, largest radius"], ["line-key cycle thin", "smallest"]);
      parts.push(["mark diamond open cycle", "its fold"], ["mark square cycle", "period doubling"]);
      const has = (kind) => shown.some(({ branches }) => branches.some(({ arrays }) => arrays.special_kind.includes(kind)));
      for (const [kind, look] of RARE) if (has(kind)) parts.push([look, SPECIAL_WORDS[kind]]);
    }
    parts.push(["line-key dashed ring", "clearance"]);
    if (shown.some(({ passage }) => passage)) parts.push(["line-key passage", "while the speed changes"]);
    if (shown.some(({ passage }) => passage?.jumps.length)) parts.push(["mark jump", "half way of a jump"]);
    parts.push(["mark place", this.two ? "the first rotor" : "the rotor"]);
    if (this.two) parts.push(["mark square second", "the second rotor and its curves"]);
    fillKey(document.getElementById("response-key"), [...[...reasons].map((each) => ["", each]), ...parts]);
  }

  #draw(pen) {
    if (!this.length) return;
    const shown = this.#shown;
    shown.forEach((side, number) => {
      const ink = number ? colour("second") : colour("ink");
      if (side.curve) this.#drawCurve(pen, side.curve.arrays, ink);
      for (const branch of side.branches) this.#drawBranch(pen, branch.arrays, number ? ink : colour("full_contact"));
    });
    for (const { curve } of shown) {
      const ring = curve && curve.facts.rotor.delta0 * this.length.factor;
      if (curve) pen.line(this.plot.shown.x, [ring, ring], { stroke: colour("muted"), dash: [5, 4] });
    }
    const ink = (number) => colour(number ? "second" : "accent");
    shown.forEach((side, number) => side.passage && this.#drawPassage(pen, side.passage, ink(number)));
    shown.forEach((side, number) => this.#drawPlace(pen, side, ink(number), number ? "square" : "disc"));
  }

  /** Return the item near a place: a point, or else a line at this speed. */
  #reading(x, _y, distance, near) {
    if (!this.length) return null;
    const [points, places] = [[], []];
    this.#shown.forEach((side, number) => {
      for (const { what, omega, high, low, stability, isPoint, joins } of this.#items(side)) {
        const lines = low === high ? [["", high]] : [[isPoint ? "" : ", largest", high], [isPoint ? "" : ", smallest", low]];
        for (let i = isPoint ? 0 : 1; i < omega.length; i++) {
          const part = isPoint ? 1 : (x / this.speed.factor - omega[i - 1]) / (omega[i] - omega[i - 1]);
          if (!what(i) || !(part >= 0 && part <= 1) || !(isPoint || joins(i))) continue;
          for (const [which, radii] of lines) {
            const radius = isPoint ? radii[i] : radii[i - 1] + part * (radii[i] - radii[i - 1]);
            const name = `${stability(i) === "unstable" ? "unstable " : ""}${what(i)}${which}${number ? ", second rotor" : ""}`;
            (isPoint ? points : places).push([isPoint ? omega[i] * this.speed.factor : x, radius * this.length.factor, name]);
          }
        }
      }
    });
    const at = nearest(points, distance, near) ?? nearest(places, distance, near);
    return at ? { text: `${at[2]}: ${this.plot.tell(at.slice(0, 2))}`, at } : null;
  }

  #drawCurve(pen, arrays, ink) {
    drawWhirls(pen, this.#xs(arrays.omega), this.#ys(arrays.amplitude), arrays, ink);
    for (const [, key, stability] of WHIRLS) {
      const look = stability === "stable" ? { width: 2 } : { width: 1.2, dash: UNSTABLE_DASH };
      if (arrays[key]?.length) pen.line(this.#xs(arrays.whip_omega), this.#ys(arrays[key]), { stroke: colour("rolling"), ...look });
    }
    for (const [, name, shape] of MARKED) {
      const xs = this.#xs(arrays[`${name}_omega`] ?? []), ys = this.#ys(arrays[`${name}_amplitude`] ?? []);
      xs.forEach((x, i) => pen.mark(x, ys[i], 8, { shape, ...(name === "hopf" ? { fill: colour("card"), stroke: ink } : { fill: ink }) }));
    }
  }

  #xs(speeds) {
    return scaled(speeds, this.speed.factor);
  }

  #ys(radii) {
    return scaled(radii, this.length.factor);
  }

  #drawBranch(pen, arrays, ink) {
    const xs = this.#xs(arrays.omega);
    for (const [name, width] of [["radius_min", 0.8], ["radius_max", 1.6]]) {
      const ys = this.#ys(arrays[name]);
      for (const [from, to] of runsOf(xs.length, (i) => arrays.stability[i] === STABLE)) {
        const stable = arrays.stability[from] === STABLE;
        pen.line(xs, ys, { from: Math.max(from - 1, 0), to, stroke: ink, width, dash: stable ? [] : [4, 4] });
      }
      if (name === "radius_max") this.#drawSpecial(pen, arrays, ys, ink);
    }
  }

  #drawSpecial(pen, arrays, ys, ink) {
    arrays.special_kind.forEach((kind, i) => {
      if (!SPECIAL_WORDS[kind]) return;
      const point = Math.min(Math.max(arrays.special_point[i], 0), ys.length - 1);
      pen.mark(arrays.special_omega[i] * this.speed.factor, ys[point], 7, { shape: SHAPES[kind], fill: colour("card"), stroke: ink });
    });
  }

  /** Draw the radius while the speed changes, and the midpoints of jumps. */
  #drawPassage(pen, { omega, low, high, jumps }, ink) {
    const [xs, lows, highs] = [this.#xs(omega), this.#ys(low), this.#ys(high)];
    pen.area(xs, lows, highs, { fill: ink, alpha: 0.25 });
    pen.line(xs, lows, { stroke: ink, width: 0.7 });
    pen.line(xs, highs, { stroke: ink, width: 1.4 });
    for (const { omega: speed, radius, falls } of jumps) {
      pen.mark(speed * this.speed.factor, radius * this.length.factor, 12, { shape: falls ? "down" : "up", fill: colour("jump"), stroke: colour("card") });
    }
  }

  #drawPlace(pen, { place, trail }, ink, shape) {
    if (!place) return;
    const speeds = this.#xs(trail.map(({ omega }) => omega));
    for (const [name, size] of [["high", 4], ["low", 2]]) {
      pen.dots(speeds, this.#ys(trail.map((each) => each[name])), size, { fill: ink, alpha: 0.45 });
    }
    const x = place.omega * this.speed.factor, [low, high] = this.#ys([place.low, place.high]);
    pen.line([x, x], [-1e9, 1e9], { stroke: ink, width: 0.8, alpha: 0.5 });
    pen.line([x, x], [low, high], { stroke: ink, width: 3 });
    pen.mark(x, high, 10, { shape, fill: ink, stroke: colour("card") });
  }

  #say(shown) {
    const { place, curve } = shown[0];
    const folds = curve.arrays.fold_omega.length, hopf = curve.arrays.hopf_omega.length;
    const also = hopf ? ` and ${hopf} Hopf points` : "";
    const here = place ? ` The rotor is at speed ${place.omega.toPrecision(4)} with a radius of up to ${place.high.toPrecision(4)}.` : "";
    this.plot.say(`${curve.facts.why ?? `Radius of every synchronous whirl over the speed, with ${folds} folds${also}.`}${here}`);
  }
}

/** Draw a line through all synchronous whirls: dashed where they are unstable, in a separate colour out of contact. */
export function drawWhirls(pen, xs, ys, { omega, stability, piece, in_contact: contact }, ink) {
  const broken = (i) => i > 0 && piece[i] !== piece[i - 1];
  for (const [from, to] of runsOf(omega.length, (i) => `${piece[i]} ${stability[i] === UNSTABLE} ${contact[i]}`)) {
    if (Number.isNaN(omega[from]) || piece[from] < 0) continue;
    const begin = from > 0 && !broken(from) ? from - 1 : from;
    const unstable = stability[from] === UNSTABLE;
    const dash = unstable ? UNSTABLE_DASH : contact[from] ? [] : FREE_DASH;
    pen.line(xs, ys, { from: begin, to, stroke: contact[from] ? ink : colour("contact_free"), width: unstable ? 1.2 : 2, dash });
  }
}

/** Return the intervals over which `key` of the index is constant. */
function runsOf(count, key) {
  const runs = [];
  for (let i = 0; i < count; i++) {
    if (i && key(i) === key(i - 1)) runs.at(-1)[1] = i + 1;
    else runs.push([i, i + 1]);
  }
  return runs;
}
