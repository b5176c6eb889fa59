// uPlot adapted to this page: axes in the colours of the theme, and a drawing layer.

import uPlot from "./uplot/uPlot.esm.js";
import { told } from "./units.js";

const probe = document.createElement("span");

/** Return a colour of the style sheet in the current theme. */
export function colour(name) {
  if (!colours.has(name)) {
    if (!probe.isConnected) document.documentElement.append(probe);
    probe.style.color = `var(--${name})`;
    colours.set(name, getComputedStyle(probe).color);
  }
  return colours.get(name);
}
const colours = new Map();

/** Forget the colours, because the theme has changed. */
export const forgetColours = () => colours.clear();

const FONT = "12px system-ui, sans-serif";

/** Return the numbers at the ticks of an axis. */
export const numbers = (_plot, splits) => splits.map((each) => (each === null ? "" : String(Number(each.toPrecision(6)))));

function axis(label, extra) {
  return {
    label, labelSize: 18, labelGap: 0, labelFont: FONT, font: FONT, gap: 3,
    stroke: () => colour("muted"),
    grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { stroke: () => colour("line"), width: 1, size: 4 },
    values: numbers,
    ...extra,
  };
}

// Pixels of a digit in that font, and of the space beside the ticks of a vertical axis.
const DIGIT = 7, BESIDE = 14;
const longest = (words) => (words ?? []).reduce((most, each) => Math.max(most, each?.length ?? 0), 0);
/** Return the width of the ticks of a vertical axis. */
const roomFor = (_plot, words) => Math.max(42, BESIDE + DIGIT * longest(words));
/** Return the largest overhang of the last tick of a horizontal axis. */
const roomBeside = ({ axes }) => Math.max(8, 2 + 0.5 * DIGIT * longest(axes[0]?._values));

// Largest movement in pixels that counts as a click, not a box.
const CLICK = 6;
// Axes with one scale: the ranges decide how wide the tick labels are, and their width decides the
// ranges, so that drawing again need not come to an end.
const MOST_TURNS = 2;
// Reading distance from the pointer in pixels.
const NEAR = 12;

/** One plot. `draw` gets the canvas and the functions from values to its pixels. */
export class Plot {
  /** Build it; `reading` takes values and a distance, and returns the item there and its place. */
  constructor(element, { x, y, equal = false, draw, series = [{}], below, log = false, reading, steps, unnumbered = false }) {
    Object.assign(this, { element, equal, log, drawn: { draw, below }, reading, linked: [] });
    this.range = { x: [0, 1], y: [log ? 0.1 : 0, 1] };
    this.zoomed = null; // the ranges of a part that is shown, instead of all
    this.boxing = false; // whether each drag makes a box
    const options = {
      ...this.#size(),
      padding: [6, roomBeside, 0, 0],
      legend: { show: false },
      cursor: { points: { show: false }, drag: { x: false, y: false, setScale: false } },
      scales: {
        x: { time: false, range: () => this.shown.x },
        y: { range: () => this.shown.y, distr: log ? 3 : 1 },
      },
      axes: [axis(x, { size: 24, space: 44 }), axis(y, { size: roomFor, space: 28, ...(log ? LOG : {}), ...(steps ? { incrs: steps } : {}), ...(unnumbered ? { values: (_plot, splits) => splits.map(() => "") } : {}) })],
      series: [{}, ...series],
      hooks: {
        drawClear: below ? [(plot) => this.#inside(plot, below)] : [],
        draw: draw ? [(plot) => this.#inside(plot, draw)] : [],
        setCursor: [() => this.#read()],
        setSize: equal ? [() => this.turns > 0 && queueMicrotask(() => this.#apply(this.turns - 1))] : [],
      },
    };
    this.data = [[0, 1], ...series.map(() => [null, null])];
    this.plot = new uPlot(options, this.data, element);
    this.told = Object.assign(document.createElement("div"), { className: "readout", hidden: true });
    this.found = Object.assign(document.createElement("div"), { className: "found", hidden: true });
    this.plot.over.append(this.told, this.found);
    this.#listen();
    new ResizeObserver(() => {
      this.turns = MOST_TURNS;
      this.plot.setSize(this.#size());
    }).observe(element);
  }

  #size() {
    return { width: Math.max(this.element.clientWidth, 80), height: Math.max(this.element.clientHeight, 80) };
  }

  /** Return the ranges shown, one widened if both must have the same scale. */
  get shown() {
    const { x, y } = this.zoomed ?? this.range;
    if (!this.equal || !this.plot?.bbox?.width) return { x, y };
    const { width, height } = this.plot.bbox;
    const per = 0.5 * Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
    const about = ([low, high], pixels) => [0.5 * (low + high) - per * pixels, 0.5 * (low + high) + per * pixels];
    return { x: about(x, width), y: about(y, height) };
  }

  #inside(plot, draw) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineJoin = "bevel"; // the lines have many points, and round ones take long
    const [x, y] = ["x", "y"].map((scale) => {
      const log = this.log && scale === "y";
      const [min, max] = [plot.scales[scale].min, plot.scales[scale].max].map((each) => (log ? Math.log10(each) : each));
      const along = scale === "x" ? bbox.width / (max - min) : -bbox.height / (max - min);
      const origin = scale === "x" ? bbox.left : bbox.top + bbox.height;
      return log ? (value) => origin + (Math.log10(value) - min) * along : (value) => origin + (value - min) * along;
    });
    draw(new Pen(ctx, x, y, devicePixelRatio, bbox), plot);
    ctx.restore();
  }

  /** Show ranges, data and labels, and draw. */
  show({ x, y, data, labels }) {
    const units = labels?.map(unitOf).join();
    const [low, high] = this.zoomed?.x ?? [0, 0];
    if (this.zoomed && ((x && (high < x[0] || low > x[1])) || (units ?? this.units) !== this.units)) this.#zoom(null);
    if (labels) this.units = units;
    if (x) this.range.x = x;
    if (y) this.range.y = y;
    if (labels) labels.forEach((label, place) => (this.plot.axes[place].label = label));
    if (data) this.data = data;
    this.#apply();
  }

  #apply(turns = MOST_TURNS) {
    this.turns = turns;
    const { x, y } = this.shown;
    this.plot.batch(() => {
      this.plot.setData(this.data, false);
      this.plot.setScale("x", { min: x[0], max: x[1] });
      this.plot.setScale("y", { min: y[0], max: y[1] });
      this.plot.redraw(true, true);
    });
  }

  /** Return the values under a pointer. */
  at(event) {
    const box = this.plot.over.getBoundingClientRect();
    return [this.plot.posToVal(event.clientX - box.left, "x"), this.plot.posToVal(event.clientY - box.top, "y")];
  }

  /** Call `moved` with values while a pointer is down, and at its first touch. */
  onDrag(moved) {
    const over = this.plot.over;
    this.isDragged = true;
    over.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || this.box) return;
      over.setPointerCapture(event.pointerId);
      moved(...this.at(event), event);
    });
    over.addEventListener("pointermove", (event) => {
      if (over.hasPointerCapture(event.pointerId) && !this.box) moved(...this.at(event), event);
    });
  }

  // reading and zooming

  /** Show the item under the pointer. */
  #read() {
    if (!this.told) return;
    const { left, top } = this.plot.cursor;
    const away = !(left >= 0) || Boolean(this.box);
    this.told.hidden = away;
    this.found.hidden = true;
    if (away) return;
    const [x, y] = [this.plot.posToVal(left, "x"), this.plot.posToVal(top, "y")];
    const place = (at) => [this.plot.valToPos(at[0], "x"), this.plot.valToPos(at[1], "y")];
    const distance = (...at) => Math.hypot(place(at)[0] - left, place(at)[1] - top);
    const { text, at } = this.reading?.(x, y, distance, NEAR) ?? {};
    this.told.textContent = text ?? this.tell([x, y]);
    this.told.classList.toggle("left", left > 0.5 * this.plot.over.clientWidth && top < 60);
    if (!at) return;
    const [across, down] = place(at);
    Object.assign(this.found.style, { left: `${across}px`, top: `${down}px` });
    this.found.hidden = false;
  }

  /** Return values with the names and units of the axes. */
  tell(values, names = []) {
    return values.map((value, i) => {
      const label = this.label(i);
      const name = names[i] ?? label.replace(/ \[.*\]$/, "");
      const unit = unitOf(label);
      return `${name} ${told(value, 6)}${unit && ` ${unit}`}`;
    }).join(", ");
  }

  /** Show a part of x and y, or all of it, here and in the plots that share the x axis. */
  #zoom(part) {
    this.zoomed = part;
    for (const other of this.linked) {
      other.zoomed = part && { x: part.x, y: other.zoomed?.y ?? other.range.y };
      other.#apply();
    }
    this.onZoom?.();
  }

  /** Show all again. */
  reset() {
    this.#zoom(null);
    this.#apply();
  }

  #listen() {
    const { over } = this.plot;
    // uPlot keeps the plot's place until the page is scrolled; answers above the plot also move it
    over.addEventListener("pointermove", () => this.plot.syncRect(true), true);
    over.addEventListener("pointerdown", () => this.plot.syncRect(true), true);
    over.addEventListener("pointerdown", (event) => {
      const wanted = this.boxing || event.ctrlKey || event.metaKey || (!this.isDragged && event.pointerType === "mouse");
      if (event.button !== 0 || !wanted) return;
      over.setPointerCapture(event.pointerId);
      const element = Object.assign(document.createElement("div"), { className: "zoom-box" });
      over.append(element);
      this.box = { element, from: this.#pixels(event), to: this.#pixels(event) };
      this.#read();
    }, true);
    over.addEventListener("pointermove", (event) => {
      if (!this.box) return;
      this.box.to = this.#pixels(event);
      const { left, top, width, height } = this.#sides();
      Object.assign(this.box.element.style, { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${height}px` });
    });
    for (const name of ["pointerup", "pointercancel"]) {
      over.addEventListener(name, () => this.box && this.#endBox(name === "pointerup"));
    }
    over.addEventListener("dblclick", () => !this.isDragged && this.zoomed && this.reset());
    over.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return; // a pinch on a pad comes as such a wheel, too
      event.preventDefault();
      const [left, top] = this.#pixels(event);
      const by = Math.exp(Math.min(Math.max(0.01 * event.deltaY, -0.3), 0.3));
      this.#zoomAbout(left, top, by);
    }, { passive: false });
  }

  #pixels(event) {
    const { left, top, width, height } = this.plot.over.getBoundingClientRect();
    const within = (value, most) => Math.min(Math.max(value, 0), most);
    return [within(event.clientX - left, width), within(event.clientY - top, height)];
  }

  /** Return the sides of the box; a flat one spans the plot. */
  #sides() {
    const { from, to } = this.box;
    const { clientWidth, clientHeight } = this.plot.over;
    let [left, top] = [Math.min(from[0], to[0]), Math.min(from[1], to[1])];
    let [width, height] = [Math.abs(from[0] - to[0]), Math.abs(from[1] - to[1])];
    if (!this.equal && width > CLICK && height <= CLICK) [top, height] = [0, clientHeight];
    else if (!this.equal && height > CLICK && width <= CLICK) [left, width] = [0, clientWidth];
    return { left, top, width, height };
  }

  #endBox(taken) {
    const { left, top, width, height } = this.#sides();
    this.box.element.remove();
    this.box = null;
    if (taken && width > CLICK && height > CLICK) this.#zoomToPixels(left, top, width, height);
  }

  #zoomToPixels(left, top, width, height) {
    const value = (pixel, scale) => this.plot.posToVal(pixel, scale);
    this.#zoom({ x: [value(left, "x"), value(left + width, "x")], y: [value(top + height, "y"), value(top, "y")] });
    this.#apply();
  }

  #zoomAbout(left, top, by) {
    const { clientWidth: width, clientHeight: height } = this.plot.over;
    const { x } = this.range;
    this.#zoomToPixels(left * (1 - by), top * (1 - by), by * width, by * height);
    if (this.zoomed.x[1] - this.zoomed.x[0] >= x[1] - x[0]) this.reset();
  }

  /** Redraw the plot on another canvas, scaled by pixels per page pixel; `text` writes on it. */
  paint(ctx, pixel, text) {
    const { plot } = this;
    const size = pixel / devicePixelRatio;
    const box = Object.fromEntries(Object.entries(plot.bbox).map(([name, value]) => [name, value * size]));
    const place = (scale) => (value) => plot.valToPos(value, scale, true) * size;
    const [x, y] = [place("x"), place("y")];
    const [left, top, right, bottom] = [box.left, box.top, box.left + box.width, box.top + box.height].map((each) => each / pixel);
    const pen = new Pen(ctx, x, y, pixel, box);
    const muted = { fill: colour("muted") };
    const ends = ["x", "y"].map((scale) => [plot.scales[scale].min, plot.scales[scale].max]);
    plot.axes.forEach(({ _splits: splits, _values: values, label }, i) => {
      const at = i ? y : x;
      splits.forEach((each, place) => {
        const [a, b] = [at(each) / pixel, values[place]];
        pen.line(...[0, 1].map((axis) => (axis === i ? [each, each] : ends[axis])), { stroke: colour("grid") });
        if (b) text(b, i ? left - 6 : a, i ? a : bottom + 12, { ...muted, align: i ? "right" : "center" });
      });
      if (!label) return;
      ctx.save();
      ctx.translate((i ? 9 : 0.5 * (left + right)) * pixel, (i ? 0.5 * (top + bottom) : bottom + 28) * pixel);
      if (i) ctx.rotate(-0.5 * Math.PI);
      text(label, 0, 0, { ...muted, align: "center" });
      ctx.restore();
    });
    ctx.save();
    ctx.beginPath();
    ctx.rect(box.left, box.top, box.width, box.height);
    ctx.clip();
    this.drawn.below?.(pen, plot);
    plot.series.slice(1).forEach(({ stroke, width }, i) => {
      if (stroke) pen.line(this.data[0], this.data[i + 1], { stroke: stroke(), width: width / devicePixelRatio });
    });
    this.drawn.draw?.(pen, plot);
    ctx.restore();
  }

  /** Return the label of an axis: 0 for x, 1 for y. */
  label(axis) {
    return this.plot.axes[axis].label;
  }

  /** Describe the plot in words. */
  say(text) {
    this.element.setAttribute("aria-label", text);
  }
}

/** Return the nearest of some places, each x, y and what it is; none farther than `near`. */
export function nearest(places, distance, near) {
  let best;
  for (const each of places) {
    const away = distance(each[0], each[1]);
    if (away < near) [near, best] = [away, each];
  }
  return best;
}

const unitOf = (label) => /\[(.*)\]$/.exec(label)?.[1] ?? "";

const LOG = {
  values: ({ scales: { y } }, splits) => splits.map((each) => {
    if (!each) return "";
    if (Number.isInteger(Math.round(1e6 * Math.log10(each)) / 1e6)) return tens(each);
    return y.max < 30 * y.min ? told(each, 2) : "";
  }),
};
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const tens = (value) => {
  const power = Math.round(Math.log10(value));
  return `10${power < 0 ? "⁻" : ""}${[...String(Math.abs(power))].map((digit) => RAISED[digit]).join("")}`;
};

// Outlines of marks, in halves of their size; each side of a cross is a line there and back.
const OUTLINES = {
  diamond: [[[0, -1], [1, 0], [0, 1], [-1, 0]]], square: [[[-1, -1], [1, -1], [1, 1], [-1, 1]]],
  up: [[[0, -1], [1, 1], [-1, 1]]], down: [[[0, 1], [1, -1], [-1, -1]]],
  cross: [[[-1, -1], [1, 1]], [[-1, 1], [1, -1]]],
};

/** Draws in values. */
export class Pen {
  constructor(ctx, x, y, pixel, box) {
    Object.assign(this, { ctx, x, y, pixel, box });
  }

  /** A line through points from one place to another; a gap where `gap(i)` holds. */
  line(xs, ys, { stroke, width = 1, dash = [], from = 0, to = xs.length, gap, alpha = 1 }) {
    const { ctx } = this;
    ctx.beginPath();
    let down = false;
    for (let i = from; i < to; i++) {
      if (Number.isNaN(xs[i]) || (gap && gap(i))) {
        down = false;
        continue;
      }
      if (down) ctx.lineTo(this.x(xs[i]), this.y(ys[i]));
      else ctx.moveTo(this.x(xs[i]), this.y(ys[i]));
      down = true;
    }
    this.#stroke(stroke, width, dash, alpha);
  }

  /** A line through very many points from left to right, or back: of those in one pixel the extremes. */
  dense(xs, ys, { stroke, width = 1, gap }) {
    const { ctx, pixel } = this;
    let column = NaN, low = 0, high = 0, last = 0;
    const close = () => {
      if (Number.isNaN(column)) return;
      for (const height of [low, high, last]) ctx.lineTo(column * pixel, height);
    };
    ctx.beginPath();
    for (let i = 0; i < xs.length; i++) {
      const at = Math.round(this.x(xs[i]) / pixel), height = this.y(ys[i]), isThere = !Number.isNaN(at + height);
      if (at === column && isThere && !gap?.(i)) [low, high, last] = [Math.min(low, height), Math.max(high, height), height];
      else {
        close();
        if (isThere) ctx[Number.isNaN(column) || gap?.(i) ? "moveTo" : "lineTo"](at * pixel, height);
        [column, low, high, last] = [isThere ? at : NaN, height, height, height];
      }
    }
    close();
    this.#stroke(stroke, width, [], 1);
  }

  /** Words beside a place, offset in pixels to the right and below. */
  text(words, x, y, { fill, align = "left", right = 0, below = 0, size = 11 }) {
    const { ctx, pixel } = this;
    Object.assign(ctx, { font: `${size * pixel}px system-ui, sans-serif`, fillStyle: fill, textAlign: align, textBaseline: "middle" });
    ctx.fillText(words, this.x(x) + right * pixel, this.y(y) + below * pixel);
  }

  /** The area between two lines through points, in pieces where one of them is not a number. */
  area(xs, lows, highs, { fill, alpha = 1 }) {
    const { ctx } = this;
    for (let from = 0, to = 0; from < xs.length; from = to + 1) {
      for (to = from; to < xs.length && !Number.isNaN(xs[to]); to++);
      if (to === from) continue;
      ctx.beginPath();
      ctx.moveTo(this.x(xs[from]), this.y(highs[from]));
      for (let i = from + 1; i < to; i++) ctx.lineTo(this.x(xs[i]), this.y(highs[i]));
      for (let i = to - 1; i >= from; i--) ctx.lineTo(this.x(xs[i]), this.y(lows[i]));
      this.#fill(fill, alpha);
    }
  }

  circle(x, y, radius, { stroke, width = 1, dash = [], alpha = 1 }) {
    this.ctx.beginPath();
    this.ctx.ellipse(this.x(x), this.y(y), Math.abs(this.x(x + radius) - this.x(x)), Math.abs(this.y(y + radius) - this.y(y)), 0, 0, 2 * Math.PI);
    this.#stroke(stroke, width, dash, alpha);
  }

  /** A mark of a size in pixels: a disc, or another shape. */
  mark(x, y, size, { shape = "disc", fill, stroke, width = 1.5 }) {
    const { ctx } = this;
    const [left, top, half] = [this.x(x), this.y(y), 0.5 * size * this.pixel];
    ctx.beginPath();
    if (shape === "disc") ctx.arc(left, top, half, 0, 2 * Math.PI);
    for (const outline of OUTLINES[shape] ?? []) {
      outline.forEach(([across, down], i) => ctx[i ? "lineTo" : "moveTo"](left + half * across, top + half * down));
      ctx.closePath();
    }
    if (fill) this.#fill(fill, 1);
    if (stroke) this.#stroke(stroke, width, [], 1);
  }

  /** Many discs of one kind, some pixels wide; one that nobody could tell from that before is left out. */
  dots(xs, ys, size, { fill, alpha = 1 }) {
    const { ctx, pixel } = this;
    const half = 0.5 * size * pixel;
    let last = [NaN, NaN];
    ctx.beginPath();
    for (let i = 0; i < xs.length; i++) {
      const [left, top] = [this.x(xs[i]), this.y(ys[i])];
      if (Math.max(Math.abs(left - last[0]), Math.abs(top - last[1])) < 0.5 * pixel) continue;
      last = [left, top];
      ctx.moveTo(left + half, top);
      ctx.arc(left, top, half, 0, 2 * Math.PI);
    }
    this.#fill(fill, alpha);
  }

  arrow(x, y, dx, dy, { stroke, width = 1.5 }) {
    const { ctx, pixel } = this;
    const [a, b, c, d] = [this.x(x), this.y(y), this.x(x + dx), this.y(y + dy)];
    const length = Math.hypot(c - a, d - b);
    if (length < 2 * pixel) return;
    const [ux, uy, head] = [(c - a) / length, (d - b) / length, Math.min(7 * pixel, 0.5 * length)];
    ctx.beginPath();
    ctx.moveTo(a, b);
    ctx.lineTo(c, d);
    ctx.moveTo(c - head * (ux + 0.5 * uy), d - head * (uy - 0.5 * ux));
    ctx.lineTo(c, d);
    ctx.lineTo(c - head * (ux - 0.5 * uy), d - head * (uy + 0.5 * ux));
    this.#stroke(stroke, width, [], 1);
  }

  /** A rectangle over the whole height, between two values of x. */
  band(from, to, fill) {
    this.ctx.fillStyle = fill;
    this.ctx.fillRect(this.x(from), this.box.top, this.x(to) - this.x(from), this.box.height);
  }

  /** A picture between two corners. */
  image(picture, left, top, right, bottom) {
    this.ctx.imageSmoothingEnabled = false;
    this.ctx.drawImage(picture, this.x(left), this.y(top), this.x(right) - this.x(left), this.y(bottom) - this.y(top));
  }

  #fill(fillStyle, alpha) {
    Object.assign(this.ctx, { fillStyle, globalAlpha: alpha });
    this.ctx.fill();
    this.ctx.globalAlpha = 1;
  }

  #stroke(stroke, width, dash, alpha) {
    const { ctx, pixel } = this;
    Object.assign(ctx, { strokeStyle: stroke, lineWidth: width * pixel, globalAlpha: alpha });
    ctx.setLineDash(dash.map((each) => each * pixel));
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }
}
