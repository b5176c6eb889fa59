// Buttons in the head of a panel: zoom and reset; save the picture and the numbers.

import { csvOf, pngOf } from "./picture.js";

/** Make an element with a text. */
export const element = (kind, textContent, className = "") => Object.assign(document.createElement(kind), { textContent, className });

/** Return the elements of sheets and sentences: a title, a table whose first row has its heads, and a note. */
export const sheetsOf = (sheets) => sheets.map(({ title, rows, note }) => {
  const box = element("div", "", "sheet");
  if (!rows.length) return element("p", title);
  const table = document.createElement("table");
  rows.forEach((cells, i) => cells.length && table.insertRow().append(...cells.map((each) => element(i ? "td" : "th", each))));
  box.append(element("h2", title), table, ...(note ? [element("p", note)] : []));
  return box;
});

/** Offer a file for download. */
export function keep(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Copy a text, or one that is promised; `say` tells the user how it ended. */
export async function copy(name, text, say) {
  try {
    await navigator.clipboard.write([new ClipboardItem({ "text/plain": text })]);
    say(`The ${name} is copied.`);
  } catch (error) {
    say(`The ${name} could not be copied: ${error.message}`);
  }
}

/**
 * Put the buttons into the head of a panel.
 *
 * `told` returns the subtitle of a picture, `table` returns the rows of its numbers, the first with their names.
 */
export function addTools(panel, plots, { name, told, table }) {
  const head = element("div", "", "head"), tools = element("span", "", "tools");
  const title = panel.querySelector("h2");
  title.before(head);
  tools.append(zoomButton(plots, title.textContent), saveMenu(panel, plots, title.textContent, { name, told, table }));
  head.append(title, tools);
}

/** A button that lets the next drag choose a part, and one that resets the view. */
function zoomButton(plots, title) {
  const button = buttonOf("Zoom");
  button.title = "Then drag a box. By mouse also: Ctrl and drag, or Ctrl and wheel";
  const isZoomed = () => plots.some((plot) => plot.zoomed);
  const show = () => {
    if (isZoomed()) for (const plot of plots) setBoxing(plot, false);
    button.textContent = isZoomed() ? "Show all" : "Zoom";
    button.setAttribute("aria-pressed", String(plots[0].boxing));
    button.setAttribute("aria-label", `${button.textContent}: ${title}`);
  };
  button.addEventListener("click", () => {
    const zoomed = isZoomed();
    for (const plot of plots) {
      if (zoomed) plot.reset();
      else setBoxing(plot, !plot.boxing);
    }
    show();
  });
  for (const plot of plots) plot.onZoom = show;
  show();
  return button;
}

const buttonOf = (text) => Object.assign(element("button", text), { type: "button" });

function setBoxing(plot, on) {
  plot.boxing = on;
  plot.element.classList.toggle("boxing", on);
}

function saveMenu(panel, plots, title, { name, told, table }) {
  const menu = element("details", "", "menu"), summary = element("summary", "Save");
  summary.setAttribute("aria-label", `Save: ${title}`);
  const drawn = () => ({ plots, title, subtitle: told(), key: keyOf(panel) });
  const makers = { png: () => pngOf(drawn()), csv: () => csvOf(table()) };
  const box = document.createElement("div");
  for (const [ending, make] of Object.entries(makers)) {
    const button = buttonOf(ending.toUpperCase());
    button.dataset.keep = ending;
    button.addEventListener("click", async () => {
      menu.open = false;
      keep(await make(), `${name()}.${ending}`);
    });
    box.append(button);
  }
  menu.append(summary, box);
  menu.addEventListener("focusout", ({ relatedTarget }) => {
    if (relatedTarget && !menu.contains(relatedTarget)) menu.open = false;
  });
  return menu;
}

/** Show a legend: a class, which may be empty, and its words each, and a colour where the class has none. */
export function fillKey(box, parts) {
  const text = JSON.stringify(parts);
  if (text === box.filled) return;
  box.filled = text;
  box.replaceChildren(...parts.map(([className, words, fill = ""]) => {
    const item = element("span", words, className ? "" : "reason"), icon = element("i", "", className);
    icon.style.backgroundColor = fill;
    if (className) item.prepend(icon);
    return item;
  }));
}

/** Return the words of a panel's key, each with the element before it. */
function keyOf(panel) {
  const spans = [...panel.querySelectorAll(".key span:not([hidden])")];
  if (spans.length) return spans.map((span) => ({ words: span.textContent.trim(), icon: span.querySelector("i") }));
  const words = panel.querySelector(".key")?.textContent.trim();
  return words ? [{ words, icon: null }] : [];
}
