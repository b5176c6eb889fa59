// uPlot, dressed for this page: axes in the colours of the theme, and room to draw on.

import uPlot from "./uplot/uPlot.esm.js";

const probe = document.createElement("span");

/** Return a colour of the style sheet, as it is in the theme of the moment. */
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

function axis(label, extra) {
  return {
    label, labelSize: 18, labelGap: 0, labelFont: FONT, font: FONT, gap: 3,
    stroke: () => colour("muted"),
    grid: { stroke: () => colour("grid"), width: 1 },
    ticks: { stroke: () => colour("line"), width: 1, size: 4 },
    values: (_plot, splits) => splits.map((each) => (each === null ? "" : String(Number(each.toPrecision(6))))),
    ...extra,
  };
}

/** One plot. `draw` gets the canvas and the functions from values to its pixels. */
export class Plot {
  constructor(element, { x, y, equal = false, draw, series = [{}], below, log = false }) {
    Object.assign(this, { element, equal });
    this.range = { x: [0, 1], y: [log ? 0.1 : 0, 1] };
    const options = {
      ...this.#size(),
      padding: [6, 8, 0, 0],
      legend: { show: false },
      cursor: { show: false, drag: { x: false, y: false } },
      scales: {
        x: { time: false, range: () => this.#widened().x },
        y: { range: () => this.#widened().y, distr: log ? 3 : 1 },
      },
      axes: [axis(x, { size: 24, space: 44 }), axis(y, { size: 42, space: 28, ...(log ? LOG : {}) })],
      series: [{}, ...series],
      hooks: {
        drawClear: below ? [(plot) => this.#inside(plot, below)] : [],
        draw: draw ? [(plot) => this.#inside(plot, draw)] : [],
        setSize: equal ? [() => queueMicrotask(() => this.#apply())] : [],
      },
    };
    this.data = [[0, 1], ...series.map(() => [null, null])];
    this.plot = new uPlot(options, this.data, element);
    new ResizeObserver(() => this.plot.setSize(this.#size())).observe(element);
  }

  #size() {
    return { width: Math.max(this.element.clientWidth, 80), height: Math.max(this.element.clientHeight, 80) };
  }

  /** Return the ranges, one of them widened where both must have one scale. */
  #widened() {
    const { x, y } = this.range;
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
      const { min, max } = plot.scales[scale];
      const along = scale === "x" ? bbox.width / (max - min) : -bbox.height / (max - min);
      const origin = scale === "x" ? bbox.left : bbox.top + bbox.height;
      return (value) => origin + (value - min) * along;
    });
    draw(new Pen(ctx, x, y, devicePixelRatio, bbox), plot);
    ctx.restore();
  }

  /** Show ranges, data and labels, and draw. */
  show({ x, y, data, labels }) {
    if (x) this.range.x = x;
    if (y) this.range.y = y;
    if (labels) labels.forEach((label, place) => (this.plot.axes[place].label = label));
    if (data) this.data = data;
    this.#apply();
  }

  #apply() {
    const { x, y } = this.#widened();
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
    over.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      over.setPointerCapture(event.pointerId);
      moved(...this.at(event), event);
    });
    over.addEventListener("pointermove", (event) => {
      if (over.hasPointerCapture(event.pointerId)) moved(...this.at(event), event);
    });
  }

  /** Say in words what is drawn. */
  say(text) {
    this.element.setAttribute("aria-label", text);
  }
}

const LOG = {
  values: (_plot, splits) => splits.map((each) => (each && Number.isInteger(Math.round(1e6 * Math.log10(each)) / 1e6) ? tens(each) : "")),
};
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const tens = (value) => {
  const power = Math.round(Math.log10(value));
  return `10${power < 0 ? "⁻" : ""}${[...String(Math.abs(power))].map((digit) => RAISED[digit]).join("")}`;
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

  circle(x, y, radius, { stroke, width = 1, dash = [], fill, alpha = 1 }) {
    const { ctx } = this;
    ctx.beginPath();
    ctx.ellipse(this.x(x), this.y(y), Math.abs(this.x(x + radius) - this.x(x)), Math.abs(this.y(y + radius) - this.y(y)), 0, 0, 2 * Math.PI);
    if (fill) {
      ctx.globalAlpha = alpha;
      ctx.fillStyle = fill;
      ctx.fill();
    }
    if (stroke) this.#stroke(stroke, width, dash, alpha);
  }

  /** A mark of so many pixels: "disc", "ring", "diamond" or "square". */
  mark(x, y, size, { shape = "disc", fill, stroke, width = 1.5, alpha = 1 }) {
    const { ctx, pixel } = this;
    const [left, top, half] = [this.x(x), this.y(y), 0.5 * size * pixel];
    ctx.beginPath();
    if (shape === "diamond") {
      ctx.moveTo(left, top - half);
      ctx.lineTo(left + half, top);
      ctx.lineTo(left, top + half);
      ctx.lineTo(left - half, top);
      ctx.closePath();
    } else if (shape === "square") ctx.rect(left - half, top - half, 2 * half, 2 * half);
    else ctx.arc(left, top, half, 0, 2 * Math.PI);
    ctx.globalAlpha = alpha;
    if (fill) {
      ctx.fillStyle = fill;
      ctx.fill();
    }
    if (stroke) this.#stroke(stroke, width, [], alpha);
    ctx.globalAlpha = 1;
  }

  /** Many discs of one kind, some pixels wide. */
  dots(xs, ys, size, { fill, alpha = 1 }) {
    const { ctx, pixel } = this;
    const half = 0.5 * size * pixel;
    ctx.beginPath();
    for (let i = 0; i < xs.length; i++) {
      const [left, top] = [this.x(xs[i]), this.y(ys[i])];
      ctx.moveTo(left + half, top);
      ctx.arc(left, top, half, 0, 2 * Math.PI);
    }
    ctx.globalAlpha = alpha;
    ctx.fillStyle = fill;
    ctx.fill();
    ctx.globalAlpha = 1;
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

  /** What takes long to draw and seldom changes: drawn anew for another key, else as it was. */
  kept(owner, key, draw) {
    const { width, height } = this.ctx.canvas;
    if (owner.kept?.key !== key) {
      const picture = new OffscreenCanvas(width, height);
      const own = picture.getContext("2d");
      own.lineJoin = this.ctx.lineJoin;
      draw(new Pen(own, this.x, this.y, this.pixel, this.box));
      owner.kept = { key, picture };
    }
    this.ctx.drawImage(owner.kept.picture, 0, 0);
  }

  /** A picture between two corners. */
  image(picture, left, top, right, bottom, alpha = 1) {
    const { ctx } = this;
    ctx.imageSmoothingEnabled = false;
    ctx.globalAlpha = alpha;
    ctx.drawImage(picture, this.x(left), this.y(top), this.x(right) - this.x(left), this.y(bottom) - this.y(top));
    ctx.globalAlpha = 1;
  }

  #stroke(stroke, width, dash, alpha) {
    const { ctx, pixel } = this;
    ctx.globalAlpha = alpha;
    ctx.strokeStyle = stroke;
    ctx.lineWidth = width * pixel;
    ctx.setLineDash(dash.map((each) => each * pixel));
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }
}
