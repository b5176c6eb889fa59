// What the probes and the keyphasor of a machine would show: Bode and polar plot and cascade of the
// last run-up, and the full spectrum; beside them a measurement.

import { Plot, colour } from "./plot.js";
import { UNSTABLE, drawWhirls } from "./response.js";
import { roundUp, speedsShown } from "./state.js";
import { addTools, fillKey } from "./tools.js";
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
const TICKS = [1, 2, 5];
// How far the speeds that are shown reach beyond those of a measurement.
const ROOM = 1.1;

/** Return phase lags in degrees, within one turn. */
const lagsOf = (lags) => Array.from(lags, (each) => wrapped(each * DEGREES));
const wrapped = (lag) => lag - 360 * Math.floor((lag - LEAST_LAG) / 360);
const times = (values, factor) => (factor === 1 ? values : values.map((each) => each * factor));
const largest = (values, top = 0) => {
  for (const each of values) if (each > top) top = each;
  return top;
};
const jumps = (lags) => (i) => Math.abs(lags[i] - lags[i - 1]) > 180;

/** Add a row to a table that is held as columns. */
const addRow = (columns, row) => Object.values(columns).forEach((column, i) => column.push(row[i]));

/** A panel: its card, its plots, and what they show. */
class Panel {
  constructor(name, plots, say) {
    this.card = Object.assign(document.createElement("section"), { className: "card" });
    this.card.dataset.panel = name;
    this.card.append(Object.assign(document.createElement("h2"), { textContent: TITLES[name] }));
    this.areas = plots.map(([className, key]) => {
      const element = Object.assign(document.createElement("div"), { className: `plot ${className}` });
      element.setAttribute("role", "img");
      if (key) element.dataset.plot = key;
      this.card.append(element);
      return element;
    });
    this.keyBox = Object.assign(document.createElement("p"), { className: "key" });
    this.card.append(this.keyBox);
    this.name = name;
    Object.assign(this, say);
  }

  tools() {
    addTools(this.card, this.plots, { name: () => this.name, told: () => this.told(), table: () => this.table() });
  }

  /** Return the names and keys of the lines that are drawn. */
  keyOfSources({ sources, fastest }, { curve = false } = {}) {
    const parts = [];
    const shows = (is) => curve && sources.some(({ curve: each }) => each?.omega.some((omega, i) => each.piece[i] >= 0 && omega <= fastest && is(each.stability[i] === UNSTABLE, each.in_contact[i])));
    if (shows((unstable, contact) => contact && !unstable)) parts.push(["line-key", "exact whirl in contact"]);
    if (shows((unstable, contact) => !contact && !unstable)) parts.push(["line-key free", "contact-free whirl"]);
    if (shows((unstable) => unstable)) parts.push(["line-key dashed", "unstable"]);
    if (curve && sources.some(({ curve: each }) => each?.fold_omega.some((fold) => fold <= fastest))) parts.push(["mark diamond", "fold"]);
    for (const each of sources) if (each.has(this.name)) parts.push([each.icon, each.name]);
    return parts;
  }
}

/** Amplitude and phase lag of order 1 over the speed. */
class Bode extends Panel {
  constructor(say) {
    super("bode", [["low", "amplitude"], ["low", "lag"]], say);
    const [upper, lower] = this.areas;
    const reading = (plot, name) => (...where) => readPoints(plot(), this.#points(name), ...where);
    this.amplitude = new Plot(upper, { x: "", y: "amplitude", draw: (pen) => this.#draw(pen, "amplitude"), reading: reading(() => this.amplitude, "amplitude") });
    this.lag = new Plot(lower, { x: "speed", y: "phase lag [°]", steps: LAG_STEPS, draw: (pen) => this.#draw(pen, "lag"), reading: reading(() => this.lag, "lag") });
    this.plots = [this.amplitude, this.lag];
    this.amplitude.linked = [this.lag];
    this.lag.linked = [this.amplitude];
    this.tools();
  }

  show(view) {
    this.view = view;
    this.drawn = view.sources.filter((each) => each.order.speed.length || each.curve).map((each) => ({
      source: each,
      speed: times(each.order.speed, view.speed.factor), amplitude: times(each.order.amplitude, view.length.factor), lag: lagsOf(each.order.lag),
    }));
    let low = 0, high = 180;
    for (const { lag } of this.drawn) {
      for (const each of lag) {
        if (each < -LAG_ROOM) low = LEAST_LAG;
        if (each > 180 + LAG_ROOM) high = 360 + LEAST_LAG;
      }
    }
    const x = [0, view.fastest * view.speed.factor];
    this.amplitude.show({ x, y: [0, roundUp(1.05 * view.top * view.length.factor)], labels: ["", labelled("amplitude", view.length.unit)] });
    this.lag.show({ x, y: [low, high], labels: [labelled(view.speed.unit ? "speed" : "speed ω", view.speed.unit), "phase lag [°]"] });
    fillKey(this.keyBox, [...this.keyOfSources(view, { curve: true }), ...view.missing]);
    const last = (values) => told(values.at(-1));
    const now = this.drawn.filter(({ speed }) => speed.length).map(({ source, speed, amplitude, lag }) => `${source.name}: at speed ${last(speed)} amplitude ${last(amplitude)}, phase lag ${last(lag)} degrees`).join("; ");
    this.amplitude.say(`Amplitude of order 1 over the speed. ${now}`);
    this.lag.say(`Phase lag of order 1 over the speed. ${now}`);
  }

  #points(name) {
    return (this.drawn ?? []).map(({ source, speed, ...values }) => ({ name: source.name, xs: speed, ys: values[name] }));
  }

  #draw(pen, name) {
    if (!this.view) return;
    const { length, speed } = this.view;
    const owner = (this.pictures ??= { amplitude: {}, lag: {} })[name];
    pen.kept(owner, keyOfCurves(pen, this[name], this.view), (own) => {
      for (const { source: { curve, ink } } of this.drawn) {
        if (!curve) continue;
        const ys = name === "lag" ? lagsOf(curve.phase_lag) : times(curve.amplitude, length.factor);
        drawWhirls(own, times(curve.omega, speed.factor), ys, curve, ink("ink"));
        for (const i of foldsOf(curve)) own.mark(curve.omega[i] * speed.factor, ys[i], 8, { shape: "diamond", fill: ink("ink") });
      }
    });
    for (const { source, speed: xs, [name]: ys } of this.drawn) {
      if (source.sparse) pen.dots(...unlessNear(pen, xs, ys), 4, { fill: source.ink(), alpha: 0.8 });
      pen.dense(xs, ys, { stroke: source.ink(), width: source.sparse ? 0.8 : 1.6, gap: name === "lag" ? jumps(ys) : undefined });
      if (!source.sparse && xs.length) pen.mark(xs.at(-1), ys.at(-1), 8, { fill: source.ink(), stroke: colour("card") });
    }
  }

  table() {
    const [{ label: speed }, { label: lag }] = this.lag.plot.axes;
    const columns = { what: [], [speed]: [], [this.amplitude.plot.axes[1].label]: [], [lag]: [] };
    const add = (...row) => addRow(columns, row);
    const { view } = this;
    for (const each of this.drawn) {
      const { curve } = each.source;
      curve?.omega.forEach((omega, i) => add(`exact whirl, ${each.source.name}`, omega * view.speed.factor, curve.amplitude[i] * view.length.factor, wrapped(curve.phase_lag[i] * DEGREES)));
      each.speed.forEach((at, i) => Number.isNaN(at) || add(each.source.name, at, each.amplitude[i], each.lag[i]));
    }
    return columns;
  }
}

/** Order 1 as a vector, on axes that turn with the unbalance. */
class Polar extends Panel {
  constructor(say) {
    super("polar", [["square"]], say);
    this.plot = new Plot(this.areas[0], { equal: true, x: "along the unbalance", y: "across it", draw: (pen) => this.#draw(pen), reading: (...where) => readPoints(this.plot, this.#points(), ...where) });
    this.plots = [this.plot];
    this.tools();
  }

  show(view) {
    this.view = view;
    const place = ({ amplitude, lag }) => {
      const [xs, ys] = [new Array(lag.length), new Array(lag.length)];
      for (let i = 0; i < lag.length; i++) {
        xs[i] = view.length.factor * amplitude[i] * Math.cos(lag[i]);
        ys[i] = -view.length.factor * amplitude[i] * Math.sin(lag[i]);
      }
      return { xs, ys };
    };
    this.drawn = view.sources.filter((each) => each.order.speed.length || each.curve).map((source) => ({
      source, ...place(source.order), curve: source.curve && place({ amplitude: source.curve.amplitude, lag: source.curve.phase_lag }),
    }));
    // what matters lies on the side to which the whirl lags
    let [left, right, low, high] = [0, 0, 0, 0];
    const reach = (xs, ys, isSeen) => {
      for (let i = 0; i < xs.length; i++) {
        if (!isSeen(i)) continue;
        if (xs[i] < left) left = xs[i];
        if (xs[i] > right) right = xs[i];
        if (ys[i] < low) low = ys[i];
        if (ys[i] > high) high = ys[i];
      }
    };
    for (const { source, xs, ys, curve } of this.drawn) {
      reach(xs, ys, () => true);
      if (curve) reach(curve.xs, curve.ys, (i) => source.curve.omega[i] <= view.fastest);
    }
    const top = view.top * view.length.factor;
    const room = 0.08 * top || 1;
    const { unit } = view.length;
    this.plot.show({ x: [left - room, right + room], y: [low - room, high + room], labels: [labelled("along the unbalance", unit), labelled("across it", unit)] });
    this.top = top;
    fillKey(this.keyBox, [...this.keyOfSources(view, { curve: true }), ["dot", `speeds${view.speed.unit && ` [${view.speed.unit}]`}`], ...view.missing]);
    const now = this.drawn.filter(({ xs }) => xs.length).map(({ source, xs, ys }) => `${source.name}: ${told(xs.at(-1))} along the unbalance, ${told(ys.at(-1))} across it`).join("; ");
    this.plot.say(`Order 1 as a vector on axes that turn with the unbalance. ${now}`);
  }

  #points() {
    return (this.drawn ?? []).map(({ source, xs, ys }) => ({ name: source.name, xs, ys, at: source.order.speed }));
  }

  #draw(pen) {
    if (!this.view) return;
    const grid = { stroke: colour("grid"), width: 1 };
    const ring = roundUp(this.top) / 2;
    pen.circle(0, 0, ring, grid);
    pen.circle(0, 0, 2 * ring, grid);
    pen.line([-4 * ring, 4 * ring], [0, 0], { stroke: colour("line") });
    pen.line([0, 0], [-4 * ring, 4 * ring], { stroke: colour("line") });
    for (const { source, xs, ys, curve } of this.drawn) {
      if (curve) {
        drawWhirls(pen, curve.xs, curve.ys, source.curve, source.ink("ink"));
        for (const i of foldsOf(source.curve)) pen.mark(curve.xs[i], curve.ys[i], 8, { shape: "diamond", fill: source.ink("ink") });
      }
      const [near, far] = unlessNear(pen, xs, ys);
      if (source.sparse) pen.dots(near, far, 4, { fill: source.ink(), alpha: 0.8 });
      pen.line(near, far, { stroke: source.ink(), width: source.sparse ? 0.8 : 1.6 });
      this.#markSpeeds(pen, source, xs, ys);
      if (!source.sparse && xs.length) pen.arrow(0, 0, xs.at(-1), ys.at(-1), { stroke: source.ink(), width: 1.6 });
    }
  }

  /** Mark round speeds along a track, and write them beside it. */
  #markSpeeds(pen, source, xs, ys) {
    const { factor } = this.view.speed;
    const speeds = source.order.speed;
    let [low, high] = [Infinity, -Infinity];
    for (const each of speeds) {
      if (each < low) low = each;
      if (each > high) high = each;
    }
    if (!(high > low)) return;
    const step = roundStep(((high - low) * factor) / MARKS);
    const written = [];
    for (let i = 1; i < speeds.length; i++) {
      const [from, to] = [speeds[i - 1] * factor, speeds[i] * factor];
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
    const [x, y] = this.plot.plot.axes.map(({ label }) => label);
    const columns = { what: [], [labelled("speed", this.view.speed.unit)]: [], [x]: [], [y]: [] };
    for (const { source, xs, ys } of this.drawn) {
      xs.forEach((each, i) => Number.isNaN(each) || addRow(columns, [source.name, source.order.speed[i] * this.view.speed.factor, each, ys[i]]));
    }
    return columns;
  }
}

/** Forward and backward lines of the motion now. */
class Full extends Panel {
  constructor(say) {
    super("full", [["square"]], say);
    this.plot = new Plot(this.areas[0], { x: "frequency / speed", y: "amplitude", log: true, draw: (pen) => this.#draw(pen), reading: (...where) => readPoints(this.plot, this.#points(), ...where) });
    this.plots = [this.plot];
    this.tools();
  }

  show(view) {
    this.view = view;
    this.drawn = view.sources.filter((each) => each.lines).map((source) => ({
      source, xs: source.lines.over, ys: times(source.lines.amplitude, view.length.factor), exact: source.exact && { over: source.exact.over, amplitude: times(source.exact.amplitude, view.length.factor) },
    }));
    let top = 0;
    const reach = Math.max(ORDERS, ...this.drawn.map(({ source }) => source.lines.orders ?? 0));
    for (const { xs, ys } of this.drawn) for (let i = 0; i < xs.length; i++) if (Math.abs(xs[i]) <= reach && ys[i] > top) top = ys[i];
    top ||= 1;
    const ceiling = Math.ceil(Math.log10(1.5 * top));
    this.floor = 10 ** (ceiling - DECADES);
    this.plot.show({ x: [-reach, reach], y: [this.floor, 10 ** ceiling], labels: ["frequency / speed", labelled("amplitude", view.length.unit)] });
    const parts = this.keyOfSources(view);
    if (this.drawn.some(({ exact }) => exact)) parts.push(["mark diamond open cycle", "settled response"]);
    for (const { source: { name, lines } } of this.drawn) if (lines.told) parts.push(["", this.drawn.length > 1 ? `${name}: ${lines.told}` : lines.told]);
    fillKey(this.keyBox, parts);
    const now = this.drawn.map(({ source, xs, ys }) => `${source.name}: 1X ${told(heightAt(xs, ys, 1))}, −1X ${told(heightAt(xs, ys, -1))}`).join("; ");
    this.plot.say(`Full spectrum: amplitude over frequency, backward whirl on the left, forward on the right. ${now}`);
  }

  #points() {
    return (this.drawn ?? []).flatMap(({ source, xs, ys, exact }) => [
      ...(exact ? [{ name: `settled response, ${source.name}`, xs: exact.over, ys: exact.amplitude }] : []), { name: source.name, xs, ys, peaks: true },
    ]);
  }

  #markOrders(pen) {
    for (const [order, words] of [[1, "1X"], [-1, "−1X"]]) {
      pen.line([order, order], [this.floor, this.plot.shown.y[1]], { stroke: colour("muted"), dash: [3, 3] });
      pen.text(words, order, this.plot.shown.y[1], { fill: colour("muted"), right: 4, below: 9 });
    }
  }

  #draw(pen) {
    if (!this.view) return;
    this.#markOrders(pen);
    for (const { source, xs, ys, exact } of this.drawn) {
      pen.dense(xs, ys.map((each) => Math.max(each, 1e-3 * this.floor)), { stroke: source.ink("flight"), width: 1.3 });
      exact?.over.forEach((order, i) => {
        if (exact.amplitude[i] > this.floor) pen.mark(order, exact.amplitude[i], 7, { shape: "diamond", fill: colour("card"), stroke: colour("full_contact") });
      });
    }
  }

  table() {
    const [x, y] = this.plot.plot.axes.map(({ label }) => label);
    const columns = { what: [], [x]: [], [y]: [] };
    for (const { source, xs, ys, exact } of this.drawn) {
      xs.forEach((each, i) => addRow(columns, [source.name, each, ys[i]]));
      exact?.over.forEach((each, i) => addRow(columns, [`settled response, ${source.name}`, each, exact.amplitude[i]]));
    }
    return columns;
  }
}

/** Full spectra over the speed, one behind the other; those of each rotor in a plot of its own. */
class Cascade extends Panel {
  constructor(say) {
    super("cascade", [["square"]], say);
    this.plots = [this.#plot(this.areas[0], 0)];
    this.tools();
  }

  #plot(element, place) {
    return new Plot(element, { x: "frequency", y: "speed", draw: (pen) => this.#draw(pen, place), reading: (x, y) => this.#reading(place, x, y) });
  }

  /** Have as many plots as there is something to draw, and at least one. */
  #makeRoom(count) {
    while (this.plots.length > Math.max(count, 1)) {
      this.plots.pop();
      this.areas.pop().remove();
    }
    while (this.plots.length < count) {
      const element = this.areas[0].cloneNode(false);
      this.areas.at(-1).after(element);
      this.areas.push(element);
      this.plots.push(this.#plot(element, this.plots.length));
      this.plots.at(-1).onZoom = this.plots[0].onZoom;
    }
    this.card.classList.toggle("several", count > 1);
  }

  show(view) {
    this.view = view;
    const { factor, unit } = view.speed;
    this.drawn = view.sources.filter(({ rows }) => rows.length).map((source) => ({
      source, rows: [...source.rows].sort((one, other) => other.speed - one.speed), top: source.rows.reduce((top, { amplitude }) => largest(amplitude, top), 0),
    }));
    this.#makeRoom(this.drawn.length);
    const speeds = this.drawn.flatMap(({ rows }) => [rows[0].speed, rows.at(-1).speed]);
    const [low, high] = speeds.length ? [Math.min(...speeds), Math.max(...speeds)] : [0, view.fastest];
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
    if (!this.drawn?.[place]) return null;
    const { source, rows } = this.drawn[place];
    const { length, speed: { factor } } = this.view;
    const row = rows.reduce((best, each) => (Math.abs(each.speed * factor - y) < Math.abs(best.speed * factor - y) ? each : best));
    let best = 0;
    row.frequency.forEach((each, i) => {
      if (Math.abs(each * factor - x) < Math.abs(row.frequency[best] * factor - x)) best = i;
    });
    return { text: `${source.name}, speed ${told(row.speed * factor, 5)}: frequency ${told(row.frequency[best] * factor, 4)} (${told(row.frequency[best] / row.speed, 3)}X), amplitude ${told(row.amplitude[best] * length.factor, 4)}${length.unit && ` ${length.unit}`}` };
  }

  #draw(pen, place) {
    if (!this.drawn?.[place]) return;
    const { source, rows, top } = this.drawn[place];
    const { factor } = this.view.speed;
    const high = rows[0].speed * factor;
    const base = (row) => pen.y(row.speed * factor);
    let last = Infinity;
    for (const row of rows) {
      if (Math.abs(base(row) - last) < APART * pen.pixel) continue;
      last = base(row);
      ridge(pen, row, factor, last, (ROW * TALLEST * pen.box.height) / (top || 1), source.ink("flight"));
    }
    for (const order of [-2, -1, 1, 2]) {
      pen.line([0, order * high], [0, high], { stroke: colour("muted"), dash: Math.abs(order) > 1 ? [1, 4] : [4, 4] });
      pen.text(`${order < 0 ? "−" : ""}${Math.abs(order)}X`, order * high, high, { fill: colour("muted"), align: "center", below: -10 });
    }
  }

  table() {
    const { factor } = this.view.speed;
    const [x, y] = this.plots[0].plot.axes.map(({ label }) => label);
    const columns = { what: [], [y]: [], [x]: [], [labelled("amplitude", this.view.length.unit)]: [] };
    for (const { source, rows } of this.drawn) {
      for (const { speed, frequency, amplitude } of rows) {
        frequency.forEach((each, i) => addRow(columns, [source.name, speed * factor, each * factor, amplitude[i] * this.view.length.factor]));
      }
    }
    return columns;
  }
}

/** Draw one spectrum of a cascade, before those of higher speeds; of the lines in one pixel the tallest. */
function ridge(pen, { frequency, amplitude }, factor, base, scale, stroke) {
  const { ctx, box, pixel } = pen;
  const trace = () => {
    ctx.beginPath();
    let column = NaN, top = 0, first = NaN;
    for (let i = 0; i < frequency.length; i++) {
      const at = Math.round(pen.x(frequency[i] * factor) / pixel);
      if (at < box.left / pixel - 1 || at > (box.left + box.width) / pixel + 1) continue;
      if (at === column) top = Math.max(top, amplitude[i]);
      else {
        if (!Number.isNaN(column)) {
          if (Number.isNaN(first)) ctx.moveTo((first = column) * pixel, base - scale * top);
          else ctx.lineTo(column * pixel, base - scale * top);
        }
        [column, top] = [at, amplitude[i]];
      }
    }
    if (!Number.isNaN(column)) ctx.lineTo(column * pixel, base - scale * top);
    return [first, column];
  };
  const [first, last] = trace();
  ctx.lineTo(last * pixel, base);
  ctx.lineTo(first * pixel, base);
  ctx.closePath();
  ctx.globalAlpha = 0.75;
  ctx.fillStyle = colour("card");
  ctx.fill();
  ctx.globalAlpha = 1;
  trace();
  Object.assign(ctx, { strokeStyle: stroke, lineWidth: pixel });
  ctx.stroke();
}

/** Return which points of a curve are its folds. */
function foldsOf({ omega, amplitude, fold_omega: folds, fold_amplitude: heights }) {
  return Array.from(folds, (fold, which) => {
    let best = 0, least = Infinity;
    omega.forEach((each, i) => {
      const away = Math.hypot(each - fold, amplitude[i] - heights[which]);
      if (away < least) [best, least] = [i, away];
    });
    return best;
  });
}

/** Return what a picture of exact curves depends on. */
const keyOfCurves = (pen, plot, view) => JSON.stringify([
  pen.box.width, pen.box.height, plot.shown, view.length, view.speed, colour("ink"),
  view.sources.map(({ curve }) => curve && [curve.omega.length, curve.omega[0], curve.amplitude[curve.amplitude.length >> 1], curve.phase_lag[0]]),
]);

/** Leave out points that nobody could tell from the one before. */
function unlessNear(pen, xs, ys) {
  const [near, far] = [[], []];
  let [a, b] = [NaN, NaN];
  for (let i = 0; i < xs.length; i++) {
    const [c, d] = [pen.x(xs[i]), pen.y(ys[i])];
    if (Math.abs(c - a) < pen.pixel && Math.abs(d - b) < pen.pixel && i < xs.length - 1) continue;
    [a, b] = [c, d];
    near.push(xs[i]);
    far.push(ys[i]);
  }
  return [near, far];
}

/** Return the point that lies nearest to a place, or the tallest line near it. */
function readPoints(plot, lines, x, _y, distance, near) {
  const { plot: { valToPos, posToVal } } = plot;
  const [low, high] = [-near, near].map((pixels) => posToVal.call(plot.plot, valToPos.call(plot.plot, x, "x") + pixels, "x"));
  let best = near, found = null, tallest = -Infinity;
  for (const { name, xs, ys, at, peaks } of lines) {
    for (let i = 0; i < xs.length; i++) {
      if (!(xs[i] >= low && xs[i] <= high)) continue;
      if (peaks && !found && ys[i] > tallest) {
        tallest = ys[i];
        found = { name, place: [xs[i], ys[i]], peak: true };
        continue;
      }
      if (peaks && found?.peak && ys[i] > tallest) {
        tallest = ys[i];
        found.place = [xs[i], ys[i]];
      }
      const away = peaks ? Infinity : distance(xs[i], ys[i]);
      if (away < best) [best, found] = [away, { name, place: [xs[i], ys[i]], speed: at?.[i] }];
    }
  }
  if (!found) return null;
  return { text: `${found.name}: ${found.speed === undefined ? "" : `speed ω ${told(found.speed, 5)}, `}${plot.tell(found.place, plot.plot.axes[0].label ? [] : ["speed"])}`, at: found.place };
}

/** Whirl speeds without contacts over the speed of the rotor, with the line on which they are equal. */
class Campbell extends Panel {
  constructor(say) {
    super("campbell", [["square"]], say);
    this.plot = new Plot(this.areas[0], { x: "speed", y: "whirl speed", draw: (pen) => this.#draw(pen) });
    this.plots = [this.plot];
    this.tools();
  }

  show({ campbell, speed: { factor, unit }, now }) {
    this.drawn = campbell?.arrays.speed && { ...campbell.arrays, factor, now: now * factor };
    if (this.drawn) {
      const { speed, whirl_speed: rates } = this.drawn;
      const top = 2 * speed.at(-1) * factor;
      this.plot.show({ x: [speed[0] * factor, speed.at(-1) * factor], y: [rates.some((each) => each < 0) ? -top : 0, top], labels: [labelled("speed", unit), labelled("whirl speed", unit)] });
    } else this.plot.show({});
    fillKey(this.keyBox, [...(this.drawn ? [["dot", "damped"], ["dot growing", "growing"], ["line-key dashed", "speed of the rotor, ±1X"]] : []), ...(campbell?.facts.notes ?? []).map((each) => ["", each])]);
    this.plot.say("Campbell diagram: whirl speeds over the speed, backward whirl below 0");
  }

  #draw(pen) {
    if (!this.drawn) return;
    const { speed, whirl_speed: rates, damping, factor, now } = this.drawn;
    const xs = times(speed, factor);
    rates.forEach((each, i) => {
      const grows = damping[i] < 0;
      pen.dots([xs[i % xs.length]], [each * factor], grows ? 4 : 3, { fill: colour(grows ? "contact" : "ink") });
    });
    for (const order of [-1, 1]) pen.line([xs[0], xs.at(-1)], [order * xs[0], order * xs.at(-1)], { stroke: colour("muted"), dash: [5, 4] });
    pen.line([now, now], this.plot.shown.y, { stroke: colour("accent"), width: 1.5 });
  }

  table() {
    const { speed, whirl_speed: rates, damping } = this.drawn ?? { speed: [], whirl_speed: [], damping: [] };
    return { speed: Array.from(rates, (_, i) => speed[i % speed.length]), "whirl speed": Array.from(rates), "damping ratio": Array.from(damping) };
  }
}

/** Return the height of the tallest line beside a place. */
function heightAt(xs, ys, place) {
  let top = NaN;
  for (let i = 0; i < xs.length; i++) if (Math.abs(xs[i] - place) < 0.2 && !(ys[i] <= top)) top = ys[i];
  return top;
}

/** Return a round step that is about as large as another. */
function roundStep(about) {
  const ten = 10 ** Math.floor(Math.log10(about));
  return ten * (TICKS.find((each) => each * ten >= about) ?? 10);
}

const KINDS = { bode: Bode, polar: Polar, full: Full, cascade: Cascade, campbell: Campbell };
/** Order 1 of what was never tracked. */
export const NOTHING = { speed: [], amplitude: [], lag: [] };

/** Return the spectra of a cascade one by one. */
export const rowsOf = ({ cascade_speed: speeds, cascade_frequency: frequency, cascade_amplitude: heights }) =>
  Array.from(speeds, (speed, i) => ({ speed, frequency, amplitude: heights.slice(i * frequency.length, (i + 1) * frequency.length) }));

/** Return order 1 and spectra of an answer of the program; none before it has come. */
export function trackOf(answer) {
  const { order_speed: speed, order_amplitude: amplitude, order_lag: lag, cascade_speed: rows } = answer?.arrays ?? {};
  return { order: speed ? { speed, amplitude, lag } : NOTHING, rows: rows ? rowsOf(answer.arrays) : [] };
}

/** Return two pieces of order 1 as one, with a gap between them. */
export const joined = (one, other) =>
  one.speed.length ? Object.fromEntries(Object.keys(one).map((name) => [name, [...one[name], NaN, ...other[name]]])) : other;

/** Return whether a source, of which it is a method, has something to show in a panel. */
export function hasPanel(panel) {
  if (panel === "full") return Boolean(this.lines);
  return panel === "cascade" ? this.rows.length > 0 : this.order.speed.length > 0;
}

/** The panels that are chosen, and what they are shown of. */
export class Signals {
  /** Build them in `element`; `view` returns what there is to show, `told` the words under a picture. */
  constructor(element, { view, told: words }) {
    Object.assign(this, { element, view, words, panels: new Map(), tracks: [] });
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
    for (const name of Object.keys(KINDS)) {
      if (!names.includes(name) || this.panels.has(name)) continue;
      const panel = new KINDS[name]({ told: this.words });
      this.panels.set(name, panel);
    }
    const order = Object.keys(KINDS).filter((name) => this.panels.has(name));
    // a card that is where it belongs is not moved: its plots would lose the focus
    order.forEach((name, place) => {
      const { card } = this.panels.get(name);
      if (this.element.children[place] !== card) this.element.insertBefore(card, this.element.children[place] ?? null);
    });
    this.element.hidden = !order.length;
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
      order: track?.order ?? NOTHING, rows: track?.rows ?? [], curve: curve?.omega.length ? curve : null, lines, exact, has: hasPanel,
    }));
    if (measured) sources.push(measured);
    // a measurement may take up a small part of the speeds, and is what one looks at
    const seen = sources.reduce((most, { order }) => largest(order.speed, most), 0);
    const fastest = measured?.order.speed.length ? ROOM * seen : sources.reduce((most, { curve }) => largest(curve?.omega ?? [], most), Math.max(seen, speedsShown()[1]));
    let top = 1e-9;
    for (const { order, curve } of sources) {
      top = largest(order.amplitude, top);
      curve?.omega.forEach((omega, i) => (top = omega <= fastest && curve.amplitude[i] > top ? curve.amplitude[i] : top));
    }
    if (top === 1e-9) for (const { lines } of sources) top = largest(lines?.amplitude ?? [], top);
    const shown = {
      sources, fastest, top, campbell, now: speed, length: shownIn(scales, "length", top), speed: shownIn(scales, "rate", 1),
      missing: sources.some(({ order }) => order.speed.length) ? [] : [["", "Run the speed up or down to see the response."]],
    };
    for (const panel of this.panels.values()) panel.show(shown);
  }
}
