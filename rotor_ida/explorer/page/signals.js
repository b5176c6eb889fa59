// What the probes and the keyphasor of a machine would show: Bode and polar plot and cascade of the
// last run-up, and the full spectrum; beside them a measurement.

import { extremes, nearestIn, scaled } from "./arrays.js";
import { Plot, colour, nearest } from "./plot.js";
import { UNSTABLE, drawWhirls } from "./response.js";
import { roundUp, speedsShown } from "./state.js";
import { addTools, element, fillKey } from "./tools.js";
import { labelled, shownIn, told } from "./units.js";

const TITLES = { bode: "Bode: order 1", polar: "Polar: order 1", full: "Full spectrum", cascade: "Cascade", campbell: "Campbell diagram, contacts open" };
const DEGREES = 180 / Math.PI;
// Phase lags are told from a quarter turn ahead on.
const LEAST_LAG = -90;
// Lags that lie no further beyond 0 and 180 degrees need no wider axis.
const LAG_ROOM = 8;
const LAG_STEPS = [5, 10, 15, 30, 45, 90, 180];
// Orders that the full spectrum shows, and how far below its top, as a power of ten.
const ORDERS = 5, DECADES = 5;
// Of the height of a cascade the tallest line has so much; spectra are so many pixels apart.
const TALLEST = 0.3, ROW = 0.75, APART = 3;
// Lines up to so many times the highest speed.
const REACH = 2.3;
// About so many speeds are marked in a polar plot.
const MARKS = 7;
const TICKS = [1, 2, 5, 10];
// How far the speeds that are shown reach beyond those of a measurement.
const ROOM = 1.1;

/** Return phase lags in degrees, within one turn. */
const lagsOf = (lags) => Array.from(lags, (each) => wrapped(each * DEGREES));
const wrapped = (lag) => lag - 360 * Math.floor((lag - LEAST_LAG) / 360);
const jumps = (lags) => (i) => Math.abs(lags[i] - lags[i - 1]) > 180;
const signed = (order) => `${order < 0 ? "−" : ""}${Math.abs(order)}X`;

/** Return the sources with order 1 or exact whirls to draw. */
const ordersOf = ({ sources }) => sources.filter((each) => each.order.speed.length || each.curve);

/** A panel: its card, its plots, and what they show. */
class Panel {
  drawn = [];

  /** Build it with plots of a style each; `plots` returns the options of the one of some number. */
  constructor(name, { told: words }, plots, styles = ["square"]) {
    this.name = name;
    this.card = element("section", "", "card");
    this.card.dataset.panel = name;
    this.keyBox = element("p", "", "key");
    this.card.append(element("h2", TITLES[name]), this.keyBox);
    this.plotOf = plots;
    this.plots = [];
    for (const style of styles) this.add(style);
    [this.plot] = this.plots;
    addTools(this.card, this.plots, { name: () => name, told: words, table: () => this.table() });
  }

  /** Add a plot before the key. */
  add(style) {
    const box = element("div", "", `plot ${style}`);
    box.setAttribute("role", "img");
    this.keyBox.before(box);
    const { series: name, ...options } = this.plotOf(this.plots.length);
    if (name) box.dataset.plot = name;
    const reading = (...where) => readPoints(plot, this.points(name), ...where);
    const plot = new Plot(box, { reading, draw: (pen) => this.view && this.draw(pen, name), ...options });
    this.plots.push(plot);
  }

  /** Return the lines that are read under the pointer. */
  points(series) {
    return this.drawn.map(({ source, xs, [series]: named, ys = named }) => ({ name: source.name, xs, ys, at: series ? undefined : source.order.speed }));
  }

  /** Describe the drawn sources that have come so far, with words on each. */
  sayNow(plot, words, of) {
    plot.say(`${words} ${this.drawn.filter(({ xs }) => xs.length).map((each) => `${each.source.name}: ${of(each)}`).join("; ")}`);
  }

  /** Return the names and keys of the lines that are drawn. */
  keyOfSources({ sources, fastest }, { curve = false } = {}) {
    const parts = [];
    const curves = sources.map((each) => curve && each.curve).filter(Boolean);
    const shows = (is) => curves.some((each) => each.omega.some((omega, i) => each.piece[i] >= 0 && omega <= fastest && is(each.stability[i] === UNSTABLE, each.in_contact[i])));
    if (shows((unstable, contact) => contact && !unstable)) parts.push(["line-key", "exact whirl in contact"]);
    if (shows((unstable, contact) => !contact && !unstable)) parts.push(["line-key free", "contact-free whirl"]);
    if (shows((unstable) => unstable)) parts.push(["line-key dashed", "unstable"]);
    if (curves.some((each) => each.fold_omega.some((fold) => fold <= fastest))) parts.push(["mark diamond", "fold"]);
    for (const each of sources) if (hasPanel(each, this.name)) parts.push([each.icon, each.name]);
    return parts;
  }
}

/** Draw the exact whirls of a source at some places, with their folds. */
function drawExact(pen, xs, ys, { curve, ink }) {
  drawWhirls(pen, xs, ys, curve, ink("ink"));
  for (const i of foldsOf(curve)) pen.mark(xs[i], ys[i], 8, { shape: "diamond", fill: ink("ink") });
}

/** Amplitude and phase lag of order 1 over the speed. */
class Bode extends Panel {
  constructor(say) {
    const options = [{ series: "amplitude", x: "", y: "amplitude" }, { series: "lag", x: "speed", y: "phase lag [°]", steps: LAG_STEPS }];
    super("bode", say, (place) => options[place], ["low", "low"]);
    [this.amplitude, this.lag] = this.plots;
    this.amplitude.linked = [this.lag];
    this.lag.linked = [this.amplitude];
  }

  show(view) {
    this.view = view;
    this.drawn = ordersOf(view).map((source) => ({
      source, xs: scaled(source.order.speed, view.speed.factor), amplitude: scaled(source.order.amplitude, view.length.factor), lag: lagsOf(source.order.lag),
    }));
    const reaches = (beyond) => this.drawn.some(({ lag }) => lag.some(beyond));
    const y = [reaches((each) => each < -LAG_ROOM) ? LEAST_LAG : 0, reaches((each) => each > 180 + LAG_ROOM) ? 360 + LEAST_LAG : 180];
    const x = [0, view.fastest * view.speed.factor];
    this.amplitude.show({ x, y: [0, roundUp(1.05 * view.top * view.length.factor)], labels: ["", labelled("amplitude", view.length.unit)] });
    this.lag.show({ x, y, labels: [labelled(view.speed.unit ? "speed" : "speed ω", view.speed.unit), "phase lag [°]"] });
    fillKey(this.keyBox, [...this.keyOfSources(view, { curve: true }), ...view.missing]);
    const last = ({ xs, amplitude, lag }) => `at speed ${told(xs.at(-1))} amplitude ${told(amplitude.at(-1))}, phase lag ${told(lag.at(-1))} degrees`;
    this.sayNow(this.amplitude, "Amplitude of order 1 over the speed.", last);
    this.sayNow(this.lag, "Phase lag of order 1 over the speed.", last);
  }

  draw(pen, name) {
    const { length, speed } = this.view;
    for (const { source } of this.drawn) {
      const { curve } = source;
      if (curve) drawExact(pen, scaled(curve.omega, speed.factor), name === "lag" ? lagsOf(curve.phase_lag) : scaled(curve.amplitude, length.factor), source);
    }
    for (const { source, xs, [name]: ys } of this.drawn) {
      if (source.sparse) pen.dots(xs, ys, 4, { fill: source.ink(), alpha: 0.8 });
      pen.dense(xs, ys, { stroke: source.ink(), width: source.sparse ? 0.8 : 1.6, gap: name === "lag" ? jumps(ys) : undefined });
      if (!source.sparse && xs.length) pen.mark(xs.at(-1), ys.at(-1), 8, { fill: source.ink(), stroke: colour("card") });
    }
  }

  table() {
    const { speed, length } = this.view;
    const rows = this.drawn.flatMap(({ source: { name, curve }, xs, amplitude, lag }) => [
      ...Array.from(curve?.omega ?? [], (omega, i) => [`exact whirl, ${name}`, omega * speed.factor, curve.amplitude[i] * length.factor, wrapped(curve.phase_lag[i] * DEGREES)]),
      ...Array.from(xs, (each, i) => [name, each, amplitude[i], lag[i]]).filter(([, each]) => !Number.isNaN(each)),
    ]);
    return [["what", this.lag.label(0), this.amplitude.label(1), this.lag.label(1)], ...rows];
  }
}

/** Order 1 as a vector, on axes that turn with the unbalance. */
class Polar extends Panel {
  constructor(say) {
    super("polar", say, () => ({ equal: true, x: "along the unbalance", y: "across it" }));
  }

  show(view) {
    this.view = view;
    const along = (amplitude, lag, of) => Array.from(lag, (each, i) => view.length.factor * amplitude[i] * of(each));
    const place = (amplitude, lag) => ({ xs: along(amplitude, lag, Math.cos), ys: along(amplitude, lag, (each) => -Math.sin(each)) });
    this.drawn = ordersOf(view).map((source) => ({
      source, ...place(source.order.amplitude, source.order.lag), curve: source.curve && place(source.curve.amplitude, source.curve.phase_lag),
    }));
    this.top = view.top * view.length.factor;
    // what matters lies on the side to which the whirl lags
    const room = 0.08 * this.top || 1, { unit } = view.length;
    const [x, y] = ["xs", "ys"].map((axis) => {
      let ends = [0, 0];
      for (const { source, [axis]: values, curve } of this.drawn) {
        ends = extremes(values, ends);
        if (curve) ends = extremes(curve[axis].filter((_, i) => source.curve.omega[i] <= view.fastest), ends);
      }
      return [ends[0] - room, ends[1] + room];
    });
    this.plot.show({ x, y, labels: [labelled("along the unbalance", unit), labelled("across it", unit)] });
    fillKey(this.keyBox, [...this.keyOfSources(view, { curve: true }), ["dot", `speeds${view.speed.unit && ` [${view.speed.unit}]`}`], ...view.missing]);
    this.sayNow(this.plot, "Order 1 as a vector on axes that turn with the unbalance.", ({ xs, ys }) => `${told(xs.at(-1))} along the unbalance, ${told(ys.at(-1))} across it`);
  }

  draw(pen) {
    const ring = roundUp(this.top) / 2;
    for (const radius of [ring, 2 * ring]) pen.circle(0, 0, radius, { stroke: colour("grid"), width: 1 });
    pen.line([-4 * ring, 4 * ring], [0, 0], { stroke: colour("line") });
    pen.line([0, 0], [-4 * ring, 4 * ring], { stroke: colour("line") });
    for (const { source, xs, ys, curve } of this.drawn) {
      if (curve) drawExact(pen, curve.xs, curve.ys, source);
      if (source.sparse) pen.dots(xs, ys, 4, { fill: source.ink(), alpha: 0.8 });
      pen.line(xs, ys, { stroke: source.ink(), width: source.sparse ? 0.8 : 1.6 });
      this.#markSpeeds(pen, source, xs, ys);
      if (!source.sparse && xs.length) pen.arrow(0, 0, xs.at(-1), ys.at(-1), { stroke: source.ink(), width: 1.6 });
    }
  }

  /** Mark round speeds along a track, and write them beside it. */
  #markSpeeds(pen, source, xs, ys) {
    const speeds = scaled(source.order.speed, this.view.speed.factor);
    const [low, high] = extremes(speeds);
    if (!(high > low)) return;
    const step = roundUp((high - low) / MARKS, TICKS);
    const written = [];
    for (let i = 1; i < speeds.length; i++) {
      const [from, to] = [speeds[i - 1], speeds[i]];
      const round = step * (to > from ? Math.floor(to / step) : Math.ceil(to / step));
      // NaN, where the way has changed, lies between nothing
      if (!((to > from && round > from) || (to < from && round < from))) continue;
      const part = (round - from) / (to - from);
      const [x, y] = [xs[i - 1] + part * (xs[i] - xs[i - 1]), ys[i - 1] + part * (ys[i] - ys[i - 1])];
      pen.mark(x, y, 6, { fill: source.ink(), stroke: colour("card"), width: 1 });
      const [a, b] = [pen.x(x) / pen.pixel, pen.y(y) / pen.pixel];
      if (written.some(([c, d]) => Math.abs(a - c) < 26 && Math.abs(b - d) < 12)) continue;
      written.push([a, b]);
      pen.text(told(round, 4), x, y, { fill: colour("ink"), right: 6, below: -6 });
    }
  }

  table() {
    const { factor, unit } = this.view.speed;
    const rows = this.drawn.flatMap(({ source: { name, order }, xs, ys }) => xs.map((each, i) => [name, order.speed[i] * factor, each, ys[i]]));
    return [["what", labelled("speed", unit), this.plot.label(0), this.plot.label(1)], ...rows.filter(([, , x]) => !Number.isNaN(x))];
  }
}

/** Forward and backward lines of the motion now. */
class Full extends Panel {
  constructor(say) {
    super("full", say, () => ({ x: "frequency / speed", y: "amplitude", log: true }));
  }

  show(view) {
    this.view = view;
    this.drawn = view.sources.filter((each) => each.lines).map((source) => ({
      source, xs: source.lines.over, ys: scaled(source.lines.amplitude, view.length.factor), exact: source.exact && { over: source.exact.over, amplitude: scaled(source.exact.amplitude, view.length.factor) },
    }));
    const reach = Math.max(ORDERS, ...this.drawn.map(({ source }) => source.lines.orders ?? 0));
    const top = this.drawn.reduce((most, { xs, ys }) => extremes(ys.filter((_, i) => Math.abs(xs[i]) <= reach), [0, most])[1], 0) || 1;
    const ceiling = Math.ceil(Math.log10(1.5 * top));
    this.floor = 10 ** (ceiling - DECADES);
    this.plot.show({ x: [-reach, reach], y: [this.floor, 10 ** ceiling], labels: ["frequency / speed", labelled("amplitude", view.length.unit)] });
    const parts = this.keyOfSources(view);
    if (this.drawn.some(({ exact }) => exact)) parts.push(["mark diamond open cycle", "settled response"]);
    for (const { source: { name, lines } } of this.drawn) if (lines.told) parts.push(["", this.drawn.length > 1 ? `${name}: ${lines.told}` : lines.told]);
    fillKey(this.keyBox, parts);
    this.sayNow(this.plot, "Full spectrum: amplitude over frequency, backward whirl on the left, forward on the right.", ({ xs, ys }) => `1X ${told(heightAt(xs, ys, 1))}, −1X ${told(heightAt(xs, ys, -1))}`);
  }

  points() {
    return this.drawn.flatMap(({ source: { name }, xs, ys, exact }) => [
      { name, xs, ys, peaks: true }, ...(exact ? [{ name: `settled response, ${name}`, xs: exact.over, ys: exact.amplitude }] : []),
    ]);
  }

  draw(pen) {
    const top = this.plot.shown.y[1];
    for (const order of [1, -1]) {
      pen.line([order, order], [this.floor, top], { stroke: colour("muted"), dash: [3, 3] });
      pen.text(signed(order), order, top, { fill: colour("muted"), right: 4, below: 9 });
    }
    for (const { source, xs, ys, exact } of this.drawn) {
      pen.dense(xs, ys.map((each) => Math.max(each, 1e-3 * this.floor)), { stroke: source.ink("flight"), width: 1.3 });
      exact?.over.forEach((order, i) => {
        if (exact.amplitude[i] > this.floor) pen.mark(order, exact.amplitude[i], 7, { shape: "diamond", fill: colour("card"), stroke: colour("full_contact") });
      });
    }
  }

  table() {
    const rows = this.points().flatMap(({ name, xs, ys }) => Array.from(xs, (each, i) => [name, each, ys[i]]));
    return [["what", this.plot.label(0), this.plot.label(1)], ...rows];
  }
}

/** Full spectra over the speed, one behind the other; those of each rotor in a plot of its own. */
class Cascade extends Panel {
  constructor(say) {
    super("cascade", say, (place) => ({ x: "frequency", y: "speed", draw: (pen) => this.#draw(pen, place), reading: (x, y) => this.#reading(place, x, y) }));
  }

  show(view) {
    this.view = view;
    const { factor, unit } = view.speed;
    this.drawn = view.sources.filter(({ rows }) => rows.length).map((source) => ({
      source, rows: [...source.rows].sort((one, other) => other.speed - one.speed), top: source.rows.reduce((top, { amplitude }) => extremes(amplitude, [0, top])[1], 0),
    }));
    // as many plots as there is something to draw, and at least one
    while (this.plots.length > Math.max(this.drawn.length, 1)) this.plots.pop().element.remove();
    while (this.plots.length < this.drawn.length) {
      this.add("square");
      this.plots.at(-1).onZoom = this.plot.onZoom;
    }
    this.card.classList.toggle("several", this.drawn.length > 1);
    const speeds = this.drawn.flatMap(({ rows }) => [rows[0].speed, rows.at(-1).speed]);
    const [low, high] = speeds.length ? extremes(speeds) : [0, view.fastest];
    const room = Math.max(high - low, 0.05 * high) * factor;
    const reach = REACH * high * factor;
    const labels = [labelled("frequency", unit), labelled(unit ? "speed" : "speed ω", unit)];
    this.plots.forEach((plot, place) => {
      plot.show({ x: [-reach, reach], y: [Math.max(low * factor - 0.04 * room, 0), low * factor + (1 + TALLEST) * room], labels });
      const { source, rows } = this.drawn[place] ?? {};
      plot.say(rows ? `Cascade, ${source.name}: ${rows.length} full spectra from speed ${told(rows.at(-1).speed * factor)} to ${told(rows[0].speed * factor)}, backward whirl on the left, forward on the right.` : "Cascade: no spectrum yet.");
    });
    const parts = this.drawn.map(({ source, top }) => [source.icon, `${source.name}, tallest line ${told(top * view.length.factor, 3)}${view.length.unit && ` ${view.length.unit}`}`]);
    if (!parts.length) parts.push(["", "No spectrum yet: run the speed up or down, further at a slow rate."]);
    fillKey(this.keyBox, parts);
  }

  #reading(place, x, y) {
    if (!this.drawn[place]) return null;
    const { source, rows } = this.drawn[place];
    const { length, speed: { factor } } = this.view;
    const { speed, frequency, amplitude } = rows[nearestIn(rows.map((row) => row.speed * factor), y)];
    const best = nearestIn(frequency, x / factor);
    return { text: `${source.name}, speed ${told(speed * factor, 5)}: frequency ${told(frequency[best] * factor, 4)} (${told(frequency[best] / speed, 3)}X), amplitude ${told(amplitude[best] * length.factor, 4)}${length.unit && ` ${length.unit}`}` };
  }

  #draw(pen, place) {
    if (!this.drawn[place]) return;
    const { source, rows, top } = this.drawn[place];
    const { factor } = this.view.speed;
    const high = rows[0].speed * factor;
    let last = Infinity;
    for (const row of rows) {
      const base = pen.y(row.speed * factor);
      if (Math.abs(base - last) < APART * pen.pixel) continue;
      last = base;
      ridge(pen, row, factor, base, (ROW * TALLEST * pen.box.height) / (top || 1), source.ink("flight"));
    }
    for (const order of [-2, -1, 1, 2]) {
      pen.line([0, order * high], [0, high], { stroke: colour("muted"), dash: Math.abs(order) > 1 ? [1, 4] : [4, 4] });
      pen.text(signed(order), order * high, high, { fill: colour("muted"), align: "center", below: -10 });
    }
  }

  table() {
    const { speed: { factor }, length } = this.view;
    const rows = this.drawn.flatMap(({ source, rows: spectra }) => spectra.flatMap(({ speed, frequency, amplitude }) => Array.from(frequency, (each, i) => [source.name, speed * factor, each * factor, amplitude[i] * length.factor])));
    return [["what", this.plot.label(1), this.plot.label(0), labelled("amplitude", length.unit)], ...rows];
  }
}

/** Draw one spectrum of a cascade, before those of higher speeds; of the lines in one pixel the tallest. */
function ridge({ ctx, box, pixel, x }, { frequency, amplitude }, factor, base, scale, stroke) {
  const tops = new Map(); // by the column of pixels
  frequency.forEach((each, i) => {
    const at = Math.round(x(each * factor) / pixel);
    if (at >= box.left / pixel - 1 && at <= (box.left + box.width) / pixel + 1) tops.set(at, Math.max(tops.get(at) ?? 0, amplitude[i]));
  });
  const columns = [...tops.keys()], path = new Path2D();
  for (const [at, top] of tops) path.lineTo(at * pixel, base - scale * top);
  const filled = new Path2D(path);
  for (const at of [columns.at(-1), columns[0]]) filled.lineTo(at * pixel, base);
  Object.assign(ctx, { globalAlpha: 0.75, fillStyle: colour("card") });
  ctx.fill(filled);
  Object.assign(ctx, { globalAlpha: 1, strokeStyle: stroke, lineWidth: pixel });
  ctx.stroke(path);
}

/** Return which points of a curve are its folds. */
function foldsOf({ omega, amplitude, fold_omega: folds, fold_amplitude: heights }) {
  return Array.from(folds, (fold, which) => nearestIn(omega.map((each, i) => Math.hypot(each - fold, amplitude[i] - heights[which])), 0));
}

/** Return the point that lies nearest to a place, or the tallest line near it. */
function readPoints(plot, lines, x, _y, distance, near) {
  const { plot: own } = plot;
  const [low, high] = [-near, near].map((pixels) => own.posToVal(own.valToPos(x, "x") + pixels, "x"));
  const points = [], tallest = [];
  for (const { name, xs, ys, at, peaks } of lines) {
    for (let i = 0; i < xs.length; i++) if (xs[i] >= low && xs[i] <= high) (peaks ? tallest : points).push([xs[i], ys[i], name, at?.[i]]);
  }
  const found = nearest(points, distance, near) ?? tallest.sort(([, one], [, other]) => other - one)[0];
  if (!found) return null;
  const [a, b, name, speed] = found;
  return { text: `${name}: ${speed === undefined ? "" : `speed ω ${told(speed, 5)}, `}${plot.tell([a, b], plot.label(0) ? [] : ["speed"])}`, at: found };
}

/** Whirl speeds without contacts over the speed of the rotor, with the line on which they are equal. */
class Campbell extends Panel {
  constructor(say) {
    super("campbell", say, () => ({ x: "speed", y: "whirl speed", reading: undefined }));
  }

  show(view) {
    this.view = view;
    const { campbell, speed: { factor, unit }, now } = view;
    const { speed, whirl_speed: rates, damping } = campbell?.arrays ?? {};
    this.drawn = Array.from(speed ? rates : [], (rate, i) => [speed[i % speed.length] * factor, rate * factor, damping[i]]);
    this.now = now * factor;
    this.ends = speed && [speed[0] * factor, speed.at(-1) * factor];
    if (speed) {
      const top = 2 * this.ends[1];
      this.plot.show({ x: this.ends, y: [rates.some((each) => each < 0) ? -top : 0, top], labels: [labelled("speed", unit), labelled("whirl speed", unit)] });
    } else this.plot.show({});
    fillKey(this.keyBox, [...(speed ? [["dot", "damped"], ["dot growing", "growing"], ["line-key dashed", "speed of the rotor, ±1X"]] : []), ...(campbell?.facts.notes ?? []).map((each) => ["", each])]);
    this.plot.say("Campbell diagram: whirl speeds over the speed, backward whirl below 0");
  }

  draw(pen) {
    if (!this.ends) return;
    for (const [speed, rate, damping] of this.drawn) pen.dots([speed], [rate], damping < 0 ? 4 : 3, { fill: colour(damping < 0 ? "contact" : "ink") });
    for (const order of [-1, 1]) pen.line(this.ends, this.ends.map((each) => order * each), { stroke: colour("muted"), dash: [5, 4] });
    pen.line([this.now, this.now], this.plot.shown.y, { stroke: colour("accent"), width: 1.5 });
  }

  table() {
    return [[this.plot.label(0), this.plot.label(1), "damping ratio"], ...this.drawn];
  }
}

/** Return the height of the tallest line beside a place. */
const heightAt = (xs, ys, place) => extremes(ys.filter((_, i) => Math.abs(xs[i] - place) < 0.2))[1];

const KINDS = { bode: Bode, polar: Polar, full: Full, cascade: Cascade, campbell: Campbell };
/** Order 1 of what was never tracked. */
export const NOTHING = { speed: [], amplitude: [], lag: [] };

/** Return order 1 and spectra of an answer of the program; none before it has come. */
export function trackOf(answer) {
  const { order_speed: speed, order_amplitude: amplitude, order_lag: lag, cascade_speed: speeds, cascade_frequency: frequency, cascade_amplitude: heights } = answer?.arrays ?? {};
  const row = (each, i) => ({ speed: each, frequency, amplitude: heights.slice(i * frequency.length, (i + 1) * frequency.length) });
  return { order: speed ? { speed, amplitude, lag } : NOTHING, rows: Array.from(speeds ?? [], row) };
}

/** Return two pieces of order 1 as one, with a gap between them. */
export const joined = (one, other) =>
  one.speed.length ? Object.fromEntries(Object.keys(one).map((name) => [name, [...one[name], NaN, ...other[name]]])) : other;

/** Return whether a source has something to show in a panel. */
const hasPanel = ({ lines, rows, order }, panel) => (panel === "full" ? Boolean(lines) : (panel === "cascade" ? rows : order.speed).length > 0);

/** The panels that are chosen, and what they are shown of. */
export class Signals {
  /** Build them in `element`; `view` returns what there is to show, `told` the words under a picture. */
  constructor(element, { view, told: words }) {
    Object.assign(this, { element, view, words, panels: new Map() });
  }

  get plots() {
    return [...this.panels.values()].flatMap(({ plots }) => plots);
  }

  /** Whether one of some panels is shown. */
  has(names) {
    return names.some((name) => this.panels.has(name));
  }

  /** Show the panels of some names, in the usual order. */
  choose(names) {
    for (const [name, panel] of this.panels) {
      if (names.includes(name)) continue;
      panel.card.remove();
      this.panels.delete(name);
    }
    // from the last one on; a card that is there is not moved: its plots would lose the focus
    let behind = null;
    for (const name of Object.keys(KINDS).reverse().filter((each) => names.includes(each))) {
      if (!this.panels.has(name)) {
        this.panels.set(name, new KINDS[name]({ told: this.words }));
        this.element.insertBefore(this.panels.get(name).card, behind);
      }
      behind = this.panels.get(name).card;
    }
    this.element.hidden = !this.panels.size;
    this.show();
  }

  /** Draw all panels again. */
  show() {
    if (!this.panels.size) return;
    const { rotors, scales, speed, measured, campbell } = this.view();
    const sources = rotors.map(({ track, curve, lines, exact }, side) => ({
      name: rotors.length > 1 ? `${side ? "second" : "first"} rotor` : "the rotor",
      icon: side ? "line-key second" : "line-key passage thin",
      ink: (usual = "accent") => colour(side ? "second" : usual),
      order: track?.order ?? NOTHING, rows: track?.rows ?? [], curve: curve?.omega.length ? curve : null, lines, exact,
    }));
    if (measured) sources.push(measured);
    // a measurement may take up a small part of the speeds, and is what one looks at
    const largest = (valuesOf, least) => sources.reduce((most, source) => extremes(valuesOf(source) ?? [], [0, most])[1], least);
    const seen = largest(({ order }) => order.speed, 0);
    const fastest = measured?.order.speed.length ? ROOM * seen : largest(({ curve }) => curve?.omega, Math.max(seen, speedsShown()[1]));
    const whirls = largest(({ curve }) => curve?.amplitude.filter((_, i) => curve.omega[i] <= fastest), largest(({ order }) => order.amplitude, 0));
    const top = whirls || largest(({ lines }) => lines?.amplitude, 0) || 1e-9;
    const shown = {
      sources, fastest, top, campbell, now: speed, length: shownIn(scales, "length", top), speed: shownIn(scales, "rate", 1),
      missing: sources.some(({ order }) => order.speed.length) ? [] : [["", "Run the speed up or down to see the response."]],
    };
    for (const panel of this.panels.values()) panel.show(shown);
  }
}
