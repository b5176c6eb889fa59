// The page of a rotor system: the file is at the program, which computes all that is drawn.

import { Address, keyKept } from "./address.js";
import { Live, Recorded } from "./connection.js";
import { colour, forgetColours } from "./plot.js";
import { Signals, rowsOf } from "./signals.js";
import { Campbell, Force, Orbit, Shape, Sketch, SpeedMap } from "./system_panels.js";
import { LARGEST_FILE, SPEED_UNITS, SYSTEM_ENDINGS } from "./tables.js";
import { copy, keep } from "./tools.js";
import { labelled, prefixed, told } from "./units.js";

const $ = (id) => document.getElementById(id);
const ABOUTS = ["system_run", "system_map", "system_run_up"];
const TYPES = { nc: "application/x-netcdf", png: "image/png", svg: "image/svg+xml", py: "text/x-python", html: "text/html" };
const KEY = "rotor-ida-key"; // of the file that the page of one disc hands over
const REVOLUTIONS = 60;
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

const recorded = $("recorded") && JSON.parse($("recorded").textContent);
let motion = {}; // what a recorded run has at all nodes
const page = (window.rotorIda = { sketch: null, run: null, map: null, campbell: null, runUp: null, time: 1, errors: [] });
const asked = { node: "", contact: 0, speed: null, revolutions: REVOLUTIONS, changes: {} };
let number = 0, since = 0, timer = 0, playing = 0, orbits = [];
const view = { page, get now() { return timeShown(); } };

const sketch = new Sketch(document.querySelector('[data-panel="sketch"]'), view, choose);
const shape = new Shape(document.querySelector('[data-panel="shape"]'), view);
const force = new Force(document.querySelector('[data-panel="force"]'), view);
const map = new SpeedMap(document.querySelector('[data-panel="map"]'), view);
const campbell = new Campbell(document.querySelector('[data-panel="campbell"]'), view);
const signals = new Signals($("signal-panels"), { view: viewOfSignals, told: words });
const kept = recorded ? null : new Address({ told: address, show: goBack, undo: $("undo"), redo: $("redo") });
let connection = null;

// the state in the address

/** Return the address of the state shown. */
function address() {
  const { node, contact, speed, revolutions, changes } = asked;
  const told = new URLSearchParams({ node, contact, revolutions, ...changes });
  if (speed !== null) told.set("speed", speed);
  return `#${told}`;
}

/** Read the state from an address; return its key, if any. Missing entries get defaults. */
function readAddress(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (name) => (given.get(name) && Number(given.get(name)) >= 0 ? Number(given.get(name)) : null);
  const changes = Object.fromEntries(Object.keys(SLIDERS).map((name) => [name, number(name)]).filter(([, value]) => value !== null));
  Object.assign(asked, { node: given.get("node") ?? "", contact: number("contact") ?? 0, speed: number("speed"), revolutions: number("revolutions") ?? REVOLUTIONS, changes });
  return given.get("key");
}

/** Show the state of the address after the browser went back or forward. */
function goBack() {
  if (!/[#&]node=/.test(location.hash)) return false;
  readAddress(location.hash);
  if (page.sketch) buildSliders();
  ask();
  return true;
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
  if (recorded) return connection.ask({ number: (number += 1) }, "nodes", recorded.nodes.indexOf(asked.node));
  if (ABOUTS.includes(abouts[0])) kept.keep();
  clearTimeout(timer);
  timer = setTimeout(() => connection.ask({ ...asked, number: (number += 1) }, abouts), PAUSE);
}

function answered({ about, part, facts, arrays, number: of }) {
  if (part === "mistake") return fail(facts.message);
  if (part === "trouble") return about === "system_run_up" ? showRunUp({ notes: [facts.message] }, {}) : fail(facts.message);
  if (about === "system_file") return begin();
  if (part === "file") said("");
  if (part === "file") return keep(new Blob([arrays.contents], { type: TYPES[facts.name.split(".").pop()] }), facts.name);
  if (of <= since || (of < number && part === "sketch" && page.sketch)) return; // of another file, or older
  $("trouble").hidden = true;
  document.querySelector(".panels").classList.remove("stale");
  if (part === "motion") motion = arrays;
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
  const what = recorded ? "A run, recorded at each node" : facts.is_archive ? "Archive: what is played is in the file" : facts.is_drop ? "A drop, from its system file" : "A system file";
  $("about").textContent = `${what}; ${counted(facts.nodes.length, "node")}, ${counted(facts.contacts.length, "contact")}.`;
  sketch.show();
  if (isNew) for (const each of [map, campbell]) each.show(); // whose answers may have come before
}

const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

function options(id, pairs) {
  $(id).replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
}

function showRun(facts, arrays) {
  page.run = { facts, ...motion, ...arrays };
  const verdict = $("verdict").firstElementChild;
  verdict.textContent = [facts.verdict, facts.bands].join(" ");
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
  $("run-up-said").textContent = [facts.touches, facts.notes.join("; ")].filter(Boolean).join(" ");
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
  if (!isArchive && !recorded) {
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
  if (!recorded && event.dataTransfer.files[0]) open(event.dataTransfer.files[0]);
});
for (const id of ["node", "contact"]) $(id).addEventListener("change", () => choose({ [id]: id === "node" ? $(id).value : Number($(id).value) }));
for (const button of document.querySelectorAll("[data-file]")) {
  button.addEventListener("click", () => {
    if (!page.run) return;
    said(`Saving .${button.dataset.file} …`);
    ask([`system_${button.dataset.file}`]);
  });
}
$("share").addEventListener("click", () => copy("address", new Blob([location.origin + location.pathname + address()], { type: "text/plain" }), said));
for (const id of ["command", "python"]) $(`copy-${id}`).addEventListener("click", () => copy(id, new Blob([$(id).textContent], { type: "text/plain" }), said));
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
document.body.classList.toggle("is-recorded", Boolean(recorded));
if (recorded) {
  asked.node = recorded.node;
  connection = new Recorded(recorded, { answered });
  ask();
} else {
  const key = readAddress(location.hash);
  kept.begin();
  connection = new Live(keyKept(key), { answered, opened, said });
}

function said(text) {
  $("connection").textContent = text;
}
