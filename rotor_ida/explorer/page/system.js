// The page of a rotor system: the file is at the program, which computes all that is drawn.

import { Live } from "./connection.js";
import { colour, forgetColours } from "./plot.js";
import { Signals, rowsOf } from "./signals.js";
import { Campbell, Force, Orbit, Shape, Sketch, SpeedMap } from "./system_panels.js";
import { LARGEST_FILE, SPEED_UNITS, SYSTEM_ENDINGS } from "./tables.js";
import { keep } from "./tools.js";
import { labelled, prefixed, told } from "./units.js";

const $ = (id) => document.getElementById(id);
const ABOUTS = ["system_run", "system_map", "system_run_up"];
const TYPES = { nc: "application/x-netcdf", png: "image/png", svg: "image/svg+xml", py: "text/x-python" };
const KEY = "rotor-ida-key";
// Milliseconds without a newer change before a question is sent.
const PAUSE = 120;
// Orbits side by side of a drop.
const MOST_ORBITS = 6;
// Of each slider: its words, its SI unit, its range over the value of the file, and that without a value.
const SLIDERS = {
  friction: ["friction", "", [0, 3], 0.5],
  damping: ["contact damping", "s/m", [0, 3], 1],
  stiffness: ["contact stiffness", "", [0.2, 5]],
  clearance: ["clearance", "m", [0.3, 3]],
  unbalance_factor: ["unbalance, of the file's", "", [0, 4]],
};

const page = (window.rotorIda = { sketch: null, run: null, map: null, campbell: null, runUp: null, time: 1, errors: [] });
const asked = { node: "", contact: 0, speed: null, revolutions: 60, changes: {} };
let number = 0, since = 0, timer = 0, playing = 0, orbits = [];
const view = { page, get now() { return timeShown(); } };

const sketch = new Sketch(document.querySelector('[data-panel="sketch"]'), view, choose);
const shape = new Shape(document.querySelector('[data-panel="shape"]'), view);
const force = new Force(document.querySelector('[data-panel="force"]'), view);
const map = new SpeedMap(document.querySelector('[data-panel="map"]'), view);
const campbell = new Campbell(document.querySelector('[data-panel="campbell"]'), view);
const signals = new Signals($("signal-panels"), { view: viewOfSignals, told: words });
const connection = new Live(keyKept(), { answered, opened, said: (text) => ($("connection").textContent = text) });

/** Return the key of the program: from the address, from this tab, or from another one. */
function keyKept() {
  const key = new URLSearchParams(location.hash.replace(/^#/, "")).get("key") ?? sessionStorage.getItem(KEY) ?? localStorage.getItem(KEY) ?? "";
  sessionStorage.setItem(KEY, key);
  localStorage.setItem(KEY, key);
  history.replaceState(null, "", location.pathname);
  return key;
}

// questions

/** Begin with the file that was dropped on the page of one disc, or with that of the command. */
async function opened() {
  const kept = await caches.open(KEY).then((cache) => cache.match("/system-file")).catch(() => null);
  if (!kept) return ask();
  await caches.delete(KEY);
  open(new File([await kept.blob()], decodeURIComponent(kept.headers.get("x-name"))));
}

/** Send a file to the program. */
function open(file) {
  const ending = file.name.slice(file.name.lastIndexOf(".")).toLowerCase();
  if (!SYSTEM_ENDINGS.includes(ending)) return fail(`${file.name} is not shown: it must end in ${SYSTEM_ENDINGS.join(" or ")}`);
  if (!file.size || file.size > LARGEST_FILE) return fail(`${file.name} is not shown: it must have up to ${Math.floor(LARGEST_FILE / 1e6)} MB, and not be empty`);
  const mine = (number += 1);
  connection.send({ about: "system_file", number: mine }, file, () => number === mine).catch(({ message }) => fail(message));
}

/** Ask all panels, or some, after a change. */
function ask(abouts = ABOUTS) {
  clearTimeout(timer);
  timer = setTimeout(() => connection.ask({ ...asked, number: (number += 1) }, abouts), PAUSE);
}

function answered({ about, part, facts, arrays, number: of }) {
  if (part === "mistake") return fail(facts.message);
  if (part === "trouble") return about === "system_run_up" ? showRunUp({ notes: [facts.message] }, {}) : fail(facts.message);
  if (about === "system_file") return begin();
  if (part === "file") return keep(new Blob([arrays.contents], { type: TYPES[facts.name.split(".").pop()] }), facts.name);
  if (of <= since || (of < number && part === "sketch" && page.sketch)) return; // of another file, or older
  $("trouble").hidden = true;
  document.querySelector(".panels").classList.remove("stale");
  ({ sketch: showSketch, run: showRun, map: showMap, campbell: showCampbell, run_up: showRunUp })[part]?.(facts, arrays);
}

/** Forget what was asked of another file. */
function begin() {
  Object.assign(asked, { node: "", contact: 0, speed: null, changes: {} });
  Object.assign(page, { sketch: null, run: null, map: null, campbell: null, runUp: null });
  for (const each of [sketch, shape, force, map, campbell, ...orbits]) each.drawn = null;
  since = number;
  ask();
}

function fail(message) {
  page.errors.push(message);
  $("trouble").textContent = `${message}.${page.run ? " What is greyed out shows the previous values." : ""}`;
  $("trouble").hidden = false;
  if (!page.run) $("verdict").firstElementChild.textContent = "No system is shown.";
  document.querySelector(".panels").classList.toggle("stale", Boolean(page.run));
}

/** Choose a node, or a contact and its node. */
function choose({ node, contact }) {
  if (contact !== undefined) {
    const other = contact !== asked.contact;
    asked.contact = contact;
    node ??= page.sketch.contacts[contact].node;
    if (other) {
      // changes are of one contact: the other one is again as in the file
      const { unbalance_factor: factor } = asked.changes;
      asked.changes = factor === undefined ? {} : { unbalance_factor: factor };
      buildSliders();
    }
  }
  if (node !== undefined) asked.node = node;
  $("node").value = asked.node;
  $("contact").value = asked.contact;
  ask();
}

// answers

function showSketch(facts) {
  const isNew = !page.sketch;
  page.sketch = facts;
  asked.node = facts.node;
  if (isNew) {
    options("node", facts.nodes.map((node) => [node, node]));
    options("contact", facts.contacts.map(({ node }, i) => [i, `${i} at ${node}`]));
    buildSliders();
    buildOrbits(facts);
  }
  $("of-contact").hidden = !facts.contacts.length;
  $("node").value = facts.node;
  $("contact").value = asked.contact;
  const what = facts.is_archive ? "Archive: what is played is in the file" : facts.is_drop ? "A drop, from its system file" : "A system file";
  $("about").textContent = `${what}; ${counted(facts.nodes.length, "node")}, ${counted(facts.contacts.length, "contact")}.`;
  sketch.show();
  if (isNew) for (const each of [map, campbell]) each.show(); // whose answers may have come before
}

const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

function options(id, pairs) {
  $(id).replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
}

function showRun(facts, arrays) {
  page.run = { facts, ...arrays };
  const verdict = $("verdict").firstElementChild;
  verdict.textContent = facts.verdict;
  verdict.className = facts.verdict.includes("rubs") || facts.drop ? "rub" : "clear";
  $("command").textContent = facts.command;
  $("python").textContent = facts.python;
  drawRun();
  signals.choose(page.sketch.is_archive || facts.drop ? ["full"] : ["bode", "full", "cascade"]);
}

function drawRun() {
  for (const each of [shape, force, ...orbits]) each.show();
}

function showMap(facts, arrays) {
  page.map = { facts, ...arrays };
  if (page.sketch) map.show();
}

function showCampbell(facts, arrays) {
  page.campbell = { facts, ...arrays };
  if (page.sketch) campbell.show();
}

function showRunUp(facts, arrays) {
  page.runUp = arrays;
  $("run-up-said").textContent = facts.notes.join("; ");
  signals.show();
}

/** Return what the panels of signals show: order 1 and cascade of the run-up, lines of the run. */
function viewOfSignals() {
  const { run, runUp } = page;
  const track = runUp?.order_speed && {
    order: { speed: runUp.order_speed, amplitude: runUp.order_amplitude, lag: runUp.order_lag },
    rows: runUp.cascade_speed ? rowsOf(runUp) : [],
  };
  const lines = run?.full_frequency && run.facts.speed && {
    over: run.full_frequency.map((each) => each / run.facts.speed), amplitude: run.full_amplitude, told: `node ${run.facts.node}`,
  };
  const si = page.sketch?.units === "SI";
  return { rotors: [{ track, lines: lines || null }], scales: si ? { length: 1, rate: 1 } : null, measured: null };
}

/** Return the words under a saved picture. */
function words() {
  const { run, sketch: { units } } = page;
  return `node ${asked.node}, speed ${speedTold(run.facts.speed, units)}`;
}

const speedTold = (value, units) => (units === "SI" ? `${told(value * SPEED_UNITS.rpm)} rpm` : told(value));

// controls

function buildSliders() {
  const { contacts, from_file: fromFile, file_speed: speed, is_archive: isArchive, is_drop: isDrop, units } = page.sketch;
  const rows = [];
  if (!isArchive) {
    const si = units === "SI";
    const factor = si ? SPEED_UNITS.rpm : 1;
    rows.push(slider(`speed${si ? " [rpm]" : ""}`, "speed", (asked.speed ?? speed) * factor, [0.1 * speed * factor, 2 * speed * factor], (value) => (asked.speed = value / factor)));
    if (!isDrop) rows.push(slider("revolutions", "revolutions", asked.revolutions, [10, 500], (value) => (asked.revolutions = Math.round(value))));
    for (const [name, [text, unit, [low, high], most]] of Object.entries(SLIDERS)) {
      const isOfAll = name === "unbalance_factor";
      if (!isOfAll && !contacts.length) continue;
      if (name === "friction" && !fromFile[asked.contact].rubs) continue;
      const value = isOfAll ? 1 : fromFile[asked.contact][name];
      const { factor: shown, unit: own } = si ? prefixed(unit, value) : { factor: 1, unit: "" };
      rows.push(slider(labelled(text, own), name, (asked.changes[name] ?? value) * shown, value ? [low * value * shown, high * value * shown] : [0, most], (given) => (asked.changes[name] = given / shown)));
    }
  }
  $("sliders").replaceChildren(...rows);
}

/** Return a number as short as its field is, in powers of ten if it is large. */
function brief(value, digits) {
  const rounded = Number(value.toPrecision(digits));
  return rounded < 1e6 ? String(rounded) : rounded.toExponential().replace("+", "");
}

function slider(text, name, value, [low, high], set) {
  const row = Object.assign(document.createElement("div"), { className: "control" });
  const label = Object.assign(document.createElement("label"), { textContent: text, htmlFor: `number-${name}` });
  const field = Object.assign(document.createElement("input"), { type: "number", id: `number-${name}`, step: "any", min: 0, value: brief(value, 6) });
  const range = Object.assign(document.createElement("input"), { type: "range", min: low, max: high, step: "any", value });
  range.setAttribute("aria-label", text);
  const change = (given) => {
    if (!Number.isFinite(given)) return;
    set(given);
    if (name === "revolutions") ask(["system_run"]);
    else ask();
  };
  range.addEventListener("input", () => {
    field.value = brief(range.valueAsNumber, 4);
    change(field.valueAsNumber);
  });
  field.addEventListener("change", () => {
    range.value = field.value;
    change(field.valueAsNumber);
  });
  row.append(label, field, range);
  return row;
}

/** Have one orbit, at the chosen node; of a drop those in all bearings. */
function buildOrbits({ contacts, is_drop: isDrop, is_archive: isArchive }) {
  const each = (isDrop || isArchive) && contacts.length > 1 ? contacts.slice(0, MOST_ORBITS).map((_, i) => i) : [null];
  $("orbits").replaceChildren(force.card);
  orbits = each.map((contact) => new Orbit($("orbits"), view, asked, contact));
}

// playback

/** Return the number of the sample that is shown. */
function timeShown() {
  const { t } = page.run;
  const time = page.time * t.at(-1);
  let [low, high] = [0, t.length - 1];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (t[middle] < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

function setTime(fraction) {
  page.time = Math.min(Math.max(fraction, 0), 1);
  $("time").value = page.time;
  if (page.run) {
    $("time").setAttribute("aria-valuetext", `t = ${told(page.run.t[timeShown()])}`);
    drawRun();
  }
}

function play(on) {
  cancelAnimationFrame(playing);
  playing = 0;
  $("play").setAttribute("aria-pressed", String(on));
  $("play").textContent = on ? "❚❚ pause" : "▶ play";
  if (!on) return;
  if (page.time >= 1) setTime(0);
  let last = performance.now();
  const step = (now) => {
    setTime(page.time + (now - last) / 1000 / Number($("pace").value));
    last = now;
    if (page.time >= 1) play(false);
    else playing = requestAnimationFrame(step);
  };
  playing = requestAnimationFrame(step);
}

// the beginning

$("choose").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => {
  if ($("file").files[0]) open($("file").files[0]);
  $("file").value = "";
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  if (event.dataTransfer.files[0]) open(event.dataTransfer.files[0]);
});
for (const id of ["node", "contact"]) $(id).addEventListener("change", () => choose({ [id]: id === "node" ? $(id).value : Number($(id).value) }));
for (const button of document.querySelectorAll("[data-file]")) {
  button.addEventListener("click", () => page.run && ask([`system_${button.dataset.file}`]));
}
$("controls").addEventListener("submit", (event) => event.preventDefault());
$("play").addEventListener("click", () => play(!playing));
$("time").addEventListener("input", () => {
  play(false);
  setTime($("time").valueAsNumber);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  forgetColours();
  if (page.sketch) for (const each of [sketch, map, campbell]) each.show();
  if (page.run) drawRun();
  signals.show();
});
colour("ink");
