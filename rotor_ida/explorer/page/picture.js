// Save a panel: its plots redrawn as PNG, or its numbers as a table.

import { Pen, colour } from "./plot.js";

const FONT = "system-ui, sans-serif";
const MARGIN = 10, TITLE = 48, LINE = 18;
// Pixels of a PNG for each pixel of the page.
const FINE = 3;

/** Return a panel as PNG, a promise of a blob: its plots below each other, a title, and its key. */
export function pngOf({ plots, key, title, subtitle }) {
  const sizes = plots.map(({ element }) => [element.clientWidth, element.clientHeight]);
  const width = Math.max(...sizes.map(([each]) => each), 320) + 2 * MARGIN;
  const { items, rows } = placed(key, width);
  const height = sizes.reduce((sum, [, each]) => sum + each, TITLE) + LINE * rows + 2 * MARGIN;
  const canvas = Object.assign(document.createElement("canvas"), { width: FINE * width, height: FINE * height });
  const ctx = canvas.getContext("2d");
  // a pen uses pixels of the picture, everything else those of the page
  const text = (words, x, y, { size = 12, align = "left", fill = colour("ink"), weight = "" } = {}) => {
    Object.assign(ctx, { font: `${weight} ${size * FINE}px ${FONT}`.trim(), textAlign: align, fillStyle: fill, textBaseline: "middle" });
    ctx.fillText(words, x * FINE, y * FINE);
  };
  ctx.fillStyle = colour("card");
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  text(title, MARGIN, MARGIN + 8, { size: 14, weight: "600" });
  text(subtitle, MARGIN, MARGIN + 25, { size: 11, fill: colour("muted") });
  let top = TITLE;
  for (const plot of plots) {
    ctx.save();
    ctx.translate(MARGIN * FINE, top * FINE);
    plot.paint(ctx, FINE, text);
    ctx.restore();
    top += plot.element.clientHeight;
  }
  for (const { words, icon, left, row } of items) {
    const middle = top + MARGIN + LINE * (row + 0.5);
    paintIcon(ctx, icon, (MARGIN + left) * FINE, middle * FINE, FINE);
    text(words, MARGIN + left + (icon ? ICON : 0), middle, { size: 11, fill: colour("muted") });
  }
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/** Return rows of numbers and words as CSV, a blob; the first one has the names. */
export const csvOf = (rows) => new Blob(rows.map((cells) => `${cells.map(cell).join(",")}\n`), { type: "text/csv" });

const cell = (value) => (Number.isNaN(value) ? "" : /[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : String(value ?? ""));

const ICON = 26, GAP = 14, LETTER = 6.2;

/** Return the positions of the items of a key, in rows; letters are assumed to have one width. */
function placed(key, width) {
  let [left, row] = [0, 0];
  const items = key.map(({ words, icon }) => {
    const wide = words.length * LETTER + (icon ? ICON : 0);
    if (left > 0 && left + wide > width - 2 * MARGIN) [left, row] = [0, row + 1];
    const item = { words, icon, left, row };
    left += wide + GAP;
    return item;
  });
  return { items, rows: items.length ? row + 1 : 0 };
}

/** Draw the symbol beside a word of a key, in the style of the page. */
function paintIcon(ctx, icon, left, middle, pixel) {
  if (!icon) return;
  const style = getComputedStyle(icon);
  const is = (name) => icon.classList.contains(name);
  // as it draws in a plot: in pixels of the picture
  const pen = new Pen(ctx, (x) => x, (y) => y, pixel, null);
  const centre = left + 10 * pixel;
  if (is("line-key")) {
    const dash = is("free") ? [12, 3, 2, 3] : { dashed: [5, 4], dotted: [2, 1.5] }[style.borderTopStyle] ?? [];
    const line = (stroke, width, dashes) => pen.line([left, left + 20 * pixel], [middle, middle], { stroke, width, dash: dashes });
    if (is("rolling")) {
      line(colour("rolling"), 3.4, []);
      line(colour("card"), 1, [3, 4]);
    } else line(is("free") ? colour("contact_free") : style.borderTopColor, parseFloat(style.borderTopWidth) || 2, dash);
    return;
  }
  const drawn = ["up", "down", "cross"].find(is);
  if (drawn) {
    pen.mark(centre, middle, 8, { shape: drawn, fill: colour(is("down") ? "card" : "ink"), stroke: colour(is("cycle") ? "full_contact" : "ink"), width: 1.2 });
    return;
  }
  const shape = is("diamond") ? "diamond" : is("swatch") || is("square") ? "square" : "disc";
  const { backgroundColor, borderTopColor } = style;
  pen.mark(centre, middle, 9, { shape, fill: backgroundColor === "rgba(0, 0, 0, 0)" ? colour("card") : backgroundColor, stroke: is("swatch") ? null : borderTopColor });
}
