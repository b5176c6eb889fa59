// The page: changes become questions, answers become plots.

import { Address, keyKept } from "./address.js";
import { nearestIn } from "./arrays.js";
import { Live, Recorded } from "./connection.js";
import { Controls, UP_AND_DOWN, onArrows, parameterShown, written } from "./controls.js";
import { Measured } from "./measured.js";
import { Passage } from "./passage.js";
import { forgetColours } from "./plot.js";
import { Response } from "./response.js";
import { Shape, Sketch } from "./shaft.js";
import { DataSheetForm } from "./sheet.js";
import { Side } from "./side.js";
import { NOTHING, Signals, trackOf } from "./signals.js";
import {
  NO_FILE, SECOND_START, SIGNALS, USUAL, address, chooseContact, file, inSI, isSystem, machine, ramp, readAddress, referenceFrequency, roundUp, setRotor, showAlone, speedName, speedOf, speedsShown,
  state, tellFile, tellsOfRotor, toDimensionless, toSI,
} from "./state.js";
import { PARAMETERS, SPEED_UNITS, START } from "./tables.js";
import { addTools, copy, element, keep, sheetsOf } from "./tools.js";
import { prefixed, speedTyped, told, withUnit } from "./units.js";

const $ = (id) => document.getElementById(id);
// The panels of a rotor, and what panels of signals need beside: of the run, and of a system its whole run-up.
const PANELS = ["motion", "responses", "starts"];
const OF_SIGNALS = { lines: ["full"], campbell: ["campbell"], track: ["bode", "polar", "cascade"] };
// No start lies further from the axis.
const FURTHEST = 1e6;
// Scales of a measurement that is shown alone.
const SI = { length: 1, time: 1, rate: 1 };
// Step of an arrow key for a component of the start.
const STEP_OF_START = 0.05;
const recorded = $("recorded") && JSON.parse($("recorded").textContent);

// Displayed state: by side, the number of the newest question and the start of its run.
const sides = [];
let number = 0;
let starts = [[0, 0, 0, 0], [0, 0, 0, 0]];
let hanging = [true, true]; // by side, whether its run starts at rest where the rotor hangs
// Parts of answers not drawn yet.
const dirty = new Set();
// Parts with details drawn this many milliseconds later.
const later = new Set();
const LATER = 100;
// For tests: the displayed parts, and the numbers of the newest question and of what is drawn.
const page = (window.rotorIda = {
  shown: [{}, {}], state, asked: 0, drawn: 0,
  hasAllDrawn: () => dirty.size + later.size === 0,
  plotOf: (over) => [response.plot, sketch.plot, shape.plot, ...signals.plots, ...sides.flatMap((side) => side.plots)].map(({ plot }) => plot).find((plot) => plot.over === over),
});

// Sets the speed when the response curve is dragged.
let moveTo = (speed) => {
  state[speedName()] = speed;
  controls.show();
  ask();
};
const response = new Response(document.querySelector('[data-panel="response"] .plot'), (speed, low) => {
  moveTo(Math.max(Number(speed.toPrecision(4)), low) / (inSI() ? SPEED_UNITS[state.speedIn] : 1));
});
addTools(document.querySelector('[data-panel="response"]'), [response.plot], {
  name: () => "response", told: () => parametersOfAll(), table: () => response.table(),
});
const controls = new Controls(() => ask(), () => {
  response.show();
  showRamp();
  keepAddress();
});
const signals = new Signals($("signal-panels"), { view: viewOfSignals, told: () => parametersOfAll() });
const measured = (page.measured = new Measured({ send: (...given) => connection.send(...given), scales: scalesShown, changed: showMeasured, listens: !recorded }));
const sketch = new Sketch(document.querySelector('[data-panel="sketch"]'), () => parametersOf(0), choosePart);
const shape = new Shape(document.querySelector('[data-panel="shape"]'), () => parametersOf(0));
let connection = null, kept = null;
// The last run-up: its tracks, kept after other changes, and their rotors.
let lastTracks = [], lastRotors = "";
const passage = (page.passage = new Passage({ begin: beginPassage, ask: askPiece, moved: showPiece, rested: restPassage, changed: showPassage }));

// questions

/** Request everything again after a change. */
function ask({ again = false } = {}) {
  if (!connection || file?.measured) return;
  if (!again) passage.forget();
  page.asked = number += 1;
  for (const side of sides.keys()) {
    if (!again) {
      const begun = startOf(side);
      hanging[side] = !begun;
      starts[side] = begun ?? starts[side];
    }
    const wanted = PANELS.filter((about) => (about === "starts" ? sides[side].wantsBasin && !isSystem() : about === "motion" || !isSystem() || !side));
    sides[side].forget();
    connection.ask(recorded ? { number } : question(side), wanted);
  }
  showStart();
  keepAddress();
}

function question(side) {
  if (isSystem()) return { number, side, machine: machine(side), revolutions: state.revolutions };
  return {
    number, side, machine: machine(side), start: hanging[side] ? null : starts[side],
    revolutions: state.revolutions, speeds: speedsShown(), reach: reach(side),
  };
}

/** Return the parameters of the rotor shown, for the subtitle of a picture. */
function parametersOf(place) {
  const { rotor, scales, told: words } = page.shown[place].motion?.facts ?? { rotor: {}, scales: {} };
  if (words) return words;
  const si = scales.length ? `, clearance ${withUnit(scales, "length", rotor.delta0)}, speed ${withUnit(scales, "rate", rotor.omega)}` : "";
  const given = Object.keys(PARAMETERS).filter((name) => name in rotor).map((name) => `${PARAMETERS[name].symbol} = ${told(rotor[name], 6)}`);
  return given.join(", ") + si;
}

const parametersOfAll = () => sides.map((_, place) => parametersOf(place)).join("; ");

/** Return the start of the next run of a side: the initial state, nothing if it hangs at rest, or the end of the last run. */
function startOf(side) {
  const last = page.shown[side].motion;
  if (isSystem()) return null;
  return state.from === "here" && last && !released ? last.facts.end : state.hangs ? null : START.map((name) => state[name]);
}
let released = true; // whether the start itself was moved, so that all begin there

function reach(side) {
  if (isSystem()) return 1;
  const delta0 = inSI() ? machine(side).clearance / machine(side).eccentricity : machine(side).delta0;
  const start = Math.max(...START.map((name) => Math.abs(state[name])));
  return Math.min(roundUp(Math.max(8, 2.5 * delta0, 1.2 * start)), FURTHEST);
}

// answers

// What takes the parts of an answer that fill no panel of the rotor; those of its file only while it is shown.
const TAKEN = {
  mistake: refused, trouble: refused, file: keepFile, machine: takeRotor, system: takeRotor,
  progress: ({ facts: { done, total } }) => say(`Saving the page: ${done} of ${total} runs.`),
  measured: (answer) => measured.take(answer), run_up: (answer) => passage.take(answer),
  lines: takeSignals, campbell: takeSignals, track: takeSignals,
};
const OF_FILE = { sketch: takeSketch, archive: takeArchive, shape: (answer) => answer.side || shape.take(answer) };

function answered(answer) {
  const take = TAKEN[answer.part] ?? (answer.number >= since && OF_FILE[answer.part]);
  if (take) take(answer);
  else if (answer.number >= since) takePanel(answer); // else of another rotor
}

function takeSignals(answer) {
  const shown = page.shown[answer.side];
  if (answer.part === "track" && !isSystem()) passage.takeTrack(answer);
  else if (answer.number >= Math.max(shown[answer.part]?.number ?? 0, since)) shown[answer.part] = answer;
  showSignals();
}

function takePanel(answer) {
  if (!sides[answer.side]) return;
  const shown = page.shown[answer.side];
  if (answer.number < (shown[answer.part]?.number ?? 0)) return;
  if (answer.part !== "motion" && answer.part !== "curve" && answer.number < number) return;
  shown[answer.part] = answer;
  if (answer.part === "motion") {
    showStale();
    if (unitsChanged) measured.refresh();
    unitsChanged = false;
    if (state.from === "here") released = false;
    if (hanging[answer.side] && answer.number === number && !isSystem()) {
      starts[answer.side] = answer.facts.start;
      if (!answer.side) START.forEach((name, i) => (state[name] = answer.facts.start[i]));
      showStart();
    }
  }
  sides[answer.side].take(answer);
  response.take(answer);
  drawSoon(`${answer.side} ${answer.part}`);
}

let since = 0; // number of the first question about the rotor shown

/** Show the rotor that the program has found in a file or a data sheet. */
function takeRotor(answer) {
  const { facts: { state: told, notes }, about } = answer;
  if (about === "upload" && !measured.isOfRotor(answer)) return;
  forgetRotor();
  setRotor(told);
  $("sheet").close();
  showState();
  ask();
  $("sheet-notes").textContent = notes.length ? `Please check: ${notes.join("; ")}.` : "";
}

/** Forget all that is shown of another rotor. */
function forgetRotor() {
  since = number + 1;
  released = true;
  passage.forget();
  response.forgetTrail();
  lastTracks = [];
  tellFile(null);
  document.querySelector('[data-panel="archive"]').hidden = true;
  sketch.drawn = shape.drawn = shape.x = null;
  for (const place of page.shown.keys()) page.shown[place] = {};
}

/** Take what is in the file of a rotor system; the sliders begin there. */
function takeSketch({ side, facts }) {
  if (side) return;
  const isNew = !file;
  tellFile(facts);
  Object.assign(state, { node: facts.node });
  if (isNew) {
    const others = facts.contacts.map((_, i) => i).filter((i) => i !== state.contact);
    if (facts.is_drop && others.length) state.second ??= others[0];
    showState();
    if (state.second !== null) ask({ again: true });
  }
  showSystem();
  keepAddress();
}

/** Show the tables and the figure of an archive; of a result that is not played they are all there is. */
function takeArchive({ side, facts, arrays }) {
  if (side) return;
  if (facts.panels.length) {
    tellFile({ ...NO_FILE, panels: facts.panels });
    $("verdict").textContent = `${facts.name}: ${facts.kind}`;
    showSystem();
    chooseSignals();
  }
  $("sheets").replaceChildren(...sheetsOf(facts.sheets));
  const figure = $("figure");
  URL.revokeObjectURL(figure.src);
  figure.hidden = !arrays.figure;
  if (arrays.figure) figure.src = URL.createObjectURL(new Blob([arrays.figure], { type: "image/svg+xml" }));
  document.querySelector('[data-panel="archive"]').hidden = false;
}

/** Return whether a panel says something of the rotor, or the file, that is shown. */
const says = (panel) => !isSystem() || Boolean(file?.panels.includes(panel));

/** Show sketch, node and contact of a rotor system. */
function showSystem() {
  document.body.classList.toggle("shows-system", isSystem());
  document.body.classList.toggle("shows-measured", Boolean(file?.measured));
  document.body.classList.toggle("shows-archive", isSystem() && says("archive"));
  for (const panel of document.querySelectorAll("[data-panel]:not([data-panel=archive], #signal-panels *)")) panel.hidden = !says(panel.dataset.panel);
  for (const panel of ["sketch", "shape"]) document.querySelector(`[data-panel="${panel}"]`).hidden = !isSystem() || !(file?.nodes.length > 1);
  $("signals").hidden = !SIGNALS.some(says);
  $("revolutions").closest(".row").hidden = isSystem() && (!says("cascade") || file.is_archive);
  if (!isSystem() || !file?.nodes.length) return;
  const offer = (id, pairs, value) => {
    $(id).replaceChildren(...pairs.map(([each, text]) => new Option(text, each)));
    $(id).value = value;
  };
  offer("node", file.nodes.map((node) => [node, node]), state.node);
  offer("contact", file.contacts.map(({ node }, i) => [i, `${i} at ${node}`]), state.contact);
  $("of-contact").hidden = !file.contacts.length;
  $("about").textContent = recorded ? "A run, recorded at each node." : file.about;
  sketch.show();
}

/** Choose a node, or a contact and its node. */
function choosePart({ node, contact }) {
  if (contact !== undefined && contact !== state.contact) {
    chooseContact(contact);
    if (state.second === contact) state.second = file.contacts.findIndex((_, i) => i !== contact);
    controls.build();
  }
  state.node = node ?? file.contacts[contact].node;
  if (recorded) moveTo(state.node);
  else ask();
}

/** Handle an error in a whole answer or one of its parts. */
function refused({ part, about, side, number: asked = number, facts: { message } }) {
  if (about === "machine") $("sheet-wrong").textContent = message;
  else if (about === "upload") measured.fail(message.replace(/\.$/, ""), asked);
  else if (about === "starts") sides[side]?.noBasin(message);
  else if (about === "track" && isSystem()) $("of-run-up").textContent = message;
  else if (["campbell", "lines", "track"].includes(about)) passage.asked.clear();
  else if (about === "run_up" || (part === "mistake" && passage.waiting.size)) {
    passage.fail();
    $("passed").textContent += ` It could not be followed further: ${message}.`;
  }
  else if (about === "responses") {
    page.shown[side].unsettled = { number: asked, message };
    drawLater(`${side} settled`);
  } else {
    complain(message);
    if (part === "mistake" || about === "motion") lose(asked);
  }
}

/** Note an unanswered question: the plots show older values. */
function lose(asked) {
  lost = asked;
  showStale();
  for (const side of sides) if (side.element.matches(".stale") && !side.basin) side.noBasin("no basin of what was asked");
}
let unitsChanged = false; // whether the next run is told in other units
let lost = 0; // number of the newest question that was refused

/** Grey out the panels of a rotor that has changed since. */
function showStale() {
  const stale = sides.map((_, place) => passage.running || (page.shown[place].motion?.number ?? 0) < lost);
  stale.forEach((each, place) => $("sides").children[place].classList.toggle("stale", each));
  const some = stale.includes(true), isLost = some && !passage.running;
  document.querySelector('[data-panel="response"]').classList.toggle("stale", isLost);
  $("words").classList.toggle("stale", some);
  $("old").hidden = !isLost;
  if (!some) complain("");
}

/** Draw the main panels, and news on the plane of starts. The rest follows later. */
function draw() {
  const has = (place, ...names) => names.some((name) => dirty.has(`${place} ${name}`));
  sides.forEach((side, place) => {
    if (has(place, "motion")) side.drawMotion();
    if (has(place, "basin")) side.drawStarts(starts[place], reach(place));
  });
  // a curve and its run arrive one after the other, and are drawn together
  if (sides.some((_, place) => has(place, "motion", "curve", "branch")) && page.shown.slice(0, sides.length).every(isWhole)) response.show();
  dirty.forEach(drawLater);
  dirty.clear();
  page.drawn = page.shown[0].motion?.number ?? 0;
}

/** Return whether curve and run of a side are answers to the same question; of a system there is one curve. */
const isWhole = ({ motion, curve }, place) => (isSystem() && place) || motion?.number === curve?.number;

/** Draw the panels that may lag behind the slider, to keep both cores free for the others. */
function drawRest() {
  const has = (place, ...names) => names.some((name) => later.has(`${place} ${name}`));
  sides.forEach((side, place) => {
    if (has(place, "motion", "section")) side.drawRest();
    if (has(place, "motion") && !isSystem()) side.drawStarts(starts[place], reach(place));
  });
  if (sides.some((_, place) => has(place, "motion", "settled", "note", "curve"))) showWords();
  if (sides.some((_, place) => has(place, "motion", "settled", "curve"))) {
    askSignals();
    showSignals();
  }
  later.clear();
}

/** Draw a new part with the next frame. */
function drawSoon(part) {
  if (!dirty.size) requestAnimationFrame(draw);
  dirty.add(part);
}

/** Draw the rest of a part some time later. */
function drawLater(part) {
  if (!later.size) setTimeout(() => requestAnimationFrame(drawRest), LATER);
  later.add(part);
}

// panels of signals

/** Request what the panels of signals show, if needed and missing. */
function askSignals() {
  if (recorded || passage.running) return;
  for (const [about, names] of Object.entries(OF_SIGNALS)) {
    if (!signals.has(names) || (about === "track" && !(isSystem() && says("cascade")))) continue;
    sides.forEach((_, side) => {
      const { motion } = page.shown[side], key = `${side} ${about}`;
      if ((side && about !== "lines") || motion?.number !== number || askedFor.get(key) === number) return;
      askedFor.set(key, number);
      connection.ask(question(side), [about]);
    });
  }
}
const askedFor = new Map(); // of a side and what is asked of it: the number of the last question

/** Return the data of the signal panels: last run-up, exact curve and lines of each rotor. */
function viewOfSignals() {
  const rotors = sides.map((_, side) => {
    const { motion, lines, settled } = page.shown[side];
    const track = isSystem() ? trackOf(page.shown[side].track) : lastTracks[side];
    const row = passage.running && track?.rows.at(-1);
    const now = row
      ? { over: row.frequency.map((each) => each / row.speed), amplitude: row.amplitude, told: "while the speed changes, Hann window" }
      : lines && { over: lines.arrays.line_over_omega, amplitude: lines.arrays.line_amplitude, orders: lines.facts.orders, told: `bandwidth ${told(lines.facts.bandwidth_over_omega, 2)}X, flat-top window` };
    const fresh = !row && settled && settled.number === motion?.number && settled.arrays.exact_order;
    return { track, curve: response.sides[side].curve?.arrays, lines: now, exact: fresh ? { over: fresh, amplitude: settled.arrays.exact_amplitude } : null };
  });
  const { motion, track } = page.shown[0];
  const [scales, speed] = [scalesShown() ?? (motion ?? track)?.facts.scales, passage.running ? passage.speed : motion?.facts.rotor.omega];
  return { rotors, scales, speed, measured: measured.source(scales, speed), campbell: page.shown[0].campbell };
}

/** Return the scales of the machine shown, if it is one. */
function scalesShown() {
  if (file?.measured) return SI;
  const scales = page.shown[0].motion?.facts.scales;
  return scales?.length ? scales : null;
}

/** Draw or remove a measurement; choose suitable panels if none is chosen. */
function showMeasured(isThere) {
  if (isThere && (!state.panels || state.panels === USUAL)) {
    const { order, rows } = measured.found;
    state.panels = order === NOTHING ? "full" : file?.measured ? `bode,polar,${rows.length ? "cascade" : "full"}` : "bode,full";
    chooseSignals();
    keepAddress();
  } else signals.show();
}

function showSignals() {
  if (passage.begun) {
    lastTracks = passage.tracks;
    lastRotors = rotorsOf();
  }
  signals.show();
  if (isSystem()) {
    $("of-run-up").textContent = page.shown[0].track?.facts.words ?? "";
    return;
  }
  const other = state.panels && lastTracks.some(({ order }) => order.speed.length) && lastRotors !== rotorsOf();
  $("of-run-up").textContent = other ? `The last run-up was of another rotor: ${lastRotors}.` : "";
}

/** Return a key of the rotors, apart from their speed. */
const rotorsOf = () => sides.map((_, place) => (page.shown[place].motion ? parametersOf(place).replace(/(, )?(ω = [^,]*|speed .*)(, )?/g, "") : "")).join("; ");

/** Show the panels named in the state. */
function chooseSignals() {
  const chosen = state.panels.split(","), lacks = isSystem() ? SIGNALS.filter((name) => !says(name)) : recorded ? SIGNALS.filter((name) => name !== USUAL) : [];
  for (const box of document.getElementsByName("signals")) {
    box.checked = chosen.includes(box.value);
    box.closest("label").hidden = lacks.includes(box.value);
  }
  signals.choose(chosen.filter((name) => name && !lacks.includes(name)));
  if (page.shown[0].motion) {
    askSignals();
    showSignals();
  }
}

// words

function showWords() {
  showVerdict();
  const box = $("words");
  const parts = [];
  sides.forEach((_, place) => {
    const { motion, settled, note, unsettled } = page.shown[place];
    if (!motion) return;
    const { rotor, told: named } = motion.facts;
    const clearance = named ?? `Clearance ${withUnit(motion.facts.scales, "length", rotor.delta0)}`;
    $("sides").children[place].firstElementChild.textContent = clearance;
    parts.push(element("h2", sides.length > 1 ? clearance : "What it does"));
    const fresh = settled && settled.number === motion.number;
    const tell = ({ facts: { words, sheets = [] } }, first = "") => parts.push(...words.map((text, line) => element("p", text, line ? "" : first)), ...sheetsOf(sheets));
    if (fresh && !(isSystem() && place)) tell(settled, "lead");
    else if (unsettled?.number === motion.number) parts.push(element("p", `The settled response is not known: ${unsettled.message.replace(/\.$/, "")}.`));
    else if (rotor.zeta === 0) parts.push(element("p", "Without damping nothing settles.", "lead"));
    else if (!fresh) parts.push(element("p", "Simulating until it settles …", "waiting"));
    if (note?.number === motion.number) parts.push(element("p", note.facts.message));
    tell(motion);
    if (!place) parts.push(...sheetsOf(page.shown[0].curve?.facts.sheets ?? []));
  });
  box.replaceChildren(...parts);
}

/** Show the verdict in bold: for the current or last run-up, and for the speed held. */
function showVerdict() {
  const lines = sides.slice(0, isSystem() ? 1 : 2).map((_, place) => {
    const { motion, settled, unsettled } = page.shown[place];
    const which = sides.length > 1 && !isSystem() ? `${place ? "Second" : "First"} clearance. ` : "";
    const track = passage.begun && passage.tracks[place];
    if (track && (passage.running || passage.waiting.size)) return [track.now, which + (track.words || "Running up …")];
    const run = track && track.words ? `${track.words} ` : "";
    if (!motion) return ["unknown", "Computing …"];
    // the motion before the run-up was at another speed
    const old = run && motion.number !== number;
    if (!old && settled?.number === motion.number) return [settled.facts.level, `${which}${run}${run ? heldAt(settled.facts.verdict) : settled.facts.verdict}`];
    if (!old && (unsettled?.number === motion.number || motion.facts.rotor.zeta === 0)) return ["unknown", `${which}${run}${motion.facts.words[0]}`];
    return ["unknown", `${which}${run}Following the rotor until it settles …`];
  });
  const box = $("verdict");
  box.replaceChildren(...lines.map(([level, words]) => element("span", words, level)));
  // during a run-up the text changes its length many times a second: the buttons below must not move
  box.style.minHeight = passage.begun ? `${box.offsetHeight}px` : "";
  document.documentElement.style.setProperty("--verdict", `${box.offsetHeight}px`);
}

/** Return the verdict of the speed held behind that of the run-up, whose first word it need not repeat. */
function heldAt(verdict) {
  const words = verdict.replace(/^Rub: /, "");
  return `Held at this speed: ${words[0].toLowerCase()}${words.slice(1)}`;
}

const complain = (text) => {
  $("message").textContent = text;
  $("trouble").hidden = !text;
};

// the address, and files

/** Store the state in the address; the state before a change stays in the history. */
const keepAddress = () => kept?.keep();

/** Show the state of the address after the browser went back or forward. */
function goBack() {
  if (!tellsOfRotor(location.hash)) return;
  const wasSystem = isSystem();
  if (wasSystem !== /[#&]node=/.test(location.hash)) forgetRotor();
  readAddress(location.hash);
  passage.forget();
  response.forgetTrail();
  showState();
  showTheme();
  ask({ again: true });
}

// Receiver of a requested text, by its kind.
const copying = new Map();

const say = (text) => ($("connection").textContent = text);

function keepFile(answer) {
  const kind = answer.facts.name.split(".").pop();
  if (copying.has(kind)) {
    copying.get(kind)(new Blob([answer.arrays.contents], { type: "text/plain" }));
    copying.delete(kind);
    return;
  }
  if (kind === "html") say(`Saved ${answer.facts.name}.`);
  keep(new Blob([answer.arrays.contents]), answer.facts.name);
}

// a passage at a rate

/** Return the start of a run-up: the end of the drawn runs; nothing while these are missing. */
function beginPassage() {
  if (!sides.every((_, side) => page.shown[side].motion?.number === number)) {
    $("passed").textContent = "The run-up starts from the end of the drawn run, which is still being computed.";
    return null;
  }
  return { ...waysFrom(speedOf()), starts: sides.map((_, side) => page.shown[side].motion.facts.end) };
}

/** Return a speed with the limits of a run-up from it: the largest speed, or the range shown. */
function waysFrom(speed) {
  const [low, range] = speedsShown();
  const fastest = inSI() ? state.fastest / referenceFrequency() : range;
  return { speed, range, limits: [low, speed < fastest * 0.9999 ? fastest : range] };
}

/** Request a piece of the run-up of one rotor. */
function askPiece({ number: piece, side, start, angle, speed, to, rate }) {
  connection.ask({ ...question(side), number: piece, machine: { ...machine(side), ...atSpeed(speed) }, start, angle, revolutions: 1, to, rate }, ["run_up"]);
}

/** Return the entry of the state for a dimensionless speed. */
const atSpeed = (speed) => (inSI() ? { speed: speed * referenceFrequency() } : { omega: speed });

/** Show the progress of a run-up. */
function showPiece(speed) {
  for (const [name, value] of Object.entries(atSpeed(speed))) state[name] = Number(value.toPrecision(12));
  controls.show();
  response.pass(passage.tracks, speed);
  response.show();
  askTracks();
  showSignals();
  showPassed();
}

/** Request order 1 and spectra of a run-up so far, if they are shown. */
function askTracks() {
  if (!signals.has([...OF_SIGNALS.track, "full"])) return;
  passage.askTracks(({ number: piece, side, start, speed }) => connection.ask({ ...question(side), number: piece, machine: { ...machine(side), ...atSpeed(speed) }, start }, ["track"]));
}

/** Hold the current speed of a run-up, and show the response there. */
function restPassage() {
  askTracks();
  passage.tracks.forEach(({ held }, side) => {
    if (!held) return;
    hanging[side] = false;
    starts[side] = held;
  });
  ask({ again: true });
  showPassed();
}

function showPassage() {
  $("run-up").setAttribute("aria-pressed", String(passage.way === 1));
  $("run-down").setAttribute("aria-pressed", String(passage.way === -1));
  if (!passage.begun) {
    response.pass([]);
    showPassed();
  }
  showStale();
}

/** Describe the result of a run-up. */
function showPassed() {
  const scales = page.shown[0].motion?.facts.scales;
  const rate = (value) => withUnit(scales, "rate", value);
  const words = passage.tracks.map((track, side) => {
    const jumps = track.jumps.map(({ omega, fold, way, falls }) => {
      const late = way * (omega - fold.omega);
      return ` It jumped ${falls ? "down" : "up"} at ${rate(omega)}, ${withUnit(scales, "rate", late, 3)} past the fold at ${rate(fold.omega)}.`;
    });
    return `${passage.tracks.length > 1 ? `${side ? "Second" : "First"} rotor: ` : ""}${track.words}${jumps.join("")}`;
  });
  $("passed").textContent = words.join(" ");
  showVerdict();
}

/** Show the rate of the speed in the units of the page. */
function showRamp() {
  if (isSystem()) return;
  const unit = inSI() ? state.speedIn : "", factor = unit ? referenceFrequency() ** 2 * SPEED_UNITS[unit] : 1;
  $("ramp-name").textContent = unit ? `${unit}/s` : "rate";
  $("ramp").value = written(Number((ramp() * factor).toPrecision(4)));
  $("run-up-to").hidden = !unit;
  if (!unit) return;
  $("fastest-name").textContent = unit;
  $("fastest").value = Number((state.fastest * SPEED_UNITS[unit]).toPrecision(4));
  $("seconds").value = Number(state.seconds.toPrecision(4));
}

// a machine by its data sheet

new DataSheetForm({ ask: (quantities) => connection.ask({ number, quantities }, ["machine"]), given: () => (inSI() && !isSystem() ? machine(0) : {}) });

// controls beside the sliders

function showStart() {
  if (isSystem()) return;
  for (const name of START) {
    const field = $(`start-${name}`);
    if (document.activeElement !== field) field.value = writtenStart(name);
  }
  $("start-units").textContent = inSI() ? `Initial state [${startShown("x").unit}], [${startShown("vx").unit}]` : "Initial state";
}

const writtenStart = (name) => written(Number((starts[0][START.indexOf(name)] * startShown(name).factor).toPrecision(4)));

/** Return the scale of a component of the start in its field, and the unit. */
function startShown(name) {
  if (!inSI()) return { factor: 1, unit: "" };
  const velocity = name.startsWith("v");
  const scale = velocity ? state.clearance * Math.max(state.speed, 1) : state.clearance;
  const { factor, unit } = prefixed(velocity ? "m/s" : "m", scale || state.eccentricity);
  return { factor: factor * state.eccentricity * (velocity ? referenceFrequency() : 1), unit };
}

/** Begin at the start that was moved. */
function release() {
  released = true;
  ask();
}

function buildSides() {
  const two = state.second !== null && !recorded, count = two ? 2 : 1;
  while (sides.length > count) {
    $("sides").lastElementChild.remove();
    sides.pop();
    page.shown[sides.length] = {};
  }
  while (sides.length < count) {
    const box = element("div", "", "side"), isFirst = !sides.length;
    box.append(element("h2", ""));
    $("sides").append(box);
    sides.push(new Side(box, sides.length, { moved: moveStart, asked: () => ask({ again: true }), told: ({ number: place }) => parametersOf(place), shown: (part) => isFirst && isSystem() && shape.show(part) }));
  }
  if (isSystem()) showSystem(); // the panels of a new side, too
  $("sides").classList.toggle("two", two);
  response.two = two;
}

function moveStart({ x, y, velocity }) {
  if (recorded || isSystem()) return;
  const round = (value) => Number(value.toPrecision(4));
  if (velocity) Object.assign(state, { vx: round(x - state.x), vy: round(y - state.y) });
  else Object.assign(state, { x: round(x), y: round(y) });
  state.hangs = false;
  release();
}

/** Call `take` with the value of a button of a name when another one is chosen. */
function onChoice(name, take) {
  for (const each of document.getElementsByName(name)) each.addEventListener("change", () => take(each.value));
}

function listen() {
  for (const name of START) {
    const field = $(`start-${name}`);
    const put = (value) => {
      state[name] = Number(value.toPrecision(12));
      state.hangs = false;
      release();
    };
    field.addEventListener("change", () => {
      if (Number.isFinite(field.valueAsNumber)) put(field.valueAsNumber / startShown(name).factor);
    });
    onArrows(field, UP_AND_DOWN, (count) => {
      put(starts[0][START.indexOf(name)] + count * STEP_OF_START);
      field.value = writtenStart(name);
    });
  }
  $("rest").addEventListener("click", () => {
    state.hangs = true;
    release();
  });
  for (const id of ["node", "contact"]) $(id).addEventListener("change", () => choosePart({ [id]: id === "node" ? $(id).value : Number($(id).value) }));
  $("revolutions").addEventListener("change", () => {
    if (!($("revolutions").valueAsNumber > 0)) return;
    state.revolutions = $("revolutions").valueAsNumber;
    ask({ again: true });
  });
  onChoice("from", (from) => {
    state.from = from;
    released = from === "start";
    response.forgetTrail();
    ask();
  });
  onChoice("units", (units) => {
    if (units === "si") toSI();
    else toDimensionless();
    unitsChanged = true;
    controls.build();
    showRamp();
    ask({ again: true });
  });
  $("beside").addEventListener("change", () => {
    state.second = $("beside").checked ? state[inSI() ? "clearance" : "delta0"] / 2 : null;
    controls.show();
    buildSides();
    starts[1] = starts[0];
    ask();
  });
  new IntersectionObserver(([{ isIntersecting }]) => {
    document.body.classList.toggle("has-sliders", isIntersecting);
  }).observe($("controls"));
  onChoice("signals", () => {
    state.panels = [...document.querySelectorAll('[name="signals"]:checked')].map(({ value }) => value).join();
    chooseSignals();
    keepAddress();
  });
  $("run-up").addEventListener("click", () => passage.press(1, ramp()));
  $("run-down").addEventListener("click", () => passage.press(-1, ramp()));
  // at rest where the rotor hangs
  $("run-up-0").addEventListener("click", () => passage.press(1, ramp(), { ...waysFrom(0), starts: sides.map(() => null) }));
  const onNumber = (name, take) => $(name).addEventListener("change", () => {
    if (!($(name).valueAsNumber > 0)) return;
    take($(name).valueAsNumber);
    showRamp();
    passage.setRate(ramp());
    keepAddress();
  });
  onNumber("ramp", (value) => {
    if (inSI()) state.seconds = (state.fastest * SPEED_UNITS[state.speedIn]) / value;
    else state.ramp = value;
  });
  onNumber("seconds", (value) => (state.seconds = value));
  $("fastest").addEventListener("change", () => {
    const typed = speedTyped($("fastest").value);
    // another largest speed, reached at the same time: other axes, and another curve
    if (typed?.speed > 0) state.fastest = typed.speed;
    showRamp();
    passage.setRate(ramp());
    controls.show();
    ask();
  });
  $("saving").addEventListener("click", ({ target: { dataset: { file: kind } } }) => kind && connection.ask(question(0), [kind]));
  $("share").addEventListener("click", () => {
    copy("address", new Blob([location.origin + location.pathname + address(starts)], { type: "text/plain" }), say);
  });
  for (const button of document.querySelectorAll("[data-copy]")) {
    const kind = button.dataset.copy;
    button.addEventListener("click", () => {
      copy(button.dataset.name, new Promise((resolve) => copying.set(kind, resolve)), say);
      connection.ask(question(0), [kind]);
    });
  }
}

// the theme

const dark = matchMedia("(prefers-color-scheme: dark)");
function showTheme() {
  document.documentElement.dataset.theme = state.theme;
  const isDark = state.theme ? state.theme === "dark" : dark.matches;
  $("theme").textContent = isDark ? "Light" : "Dark";
  $("theme").setAttribute("aria-label", `Change to the ${isDark ? "light" : "dark"} theme`);
  forgetColours();
  sides.forEach((side, place) => {
    if (side.basin) side.take(side.basin);
    side.drawMotion();
    side.drawRest();
    if (!isSystem()) side.drawStarts(starts[place], reach(place));
  });
  response.show();
  signals.show();
  if (isSystem() && file?.nodes.length) sketch.show();
}
dark.addEventListener("change", showTheme);
$("theme").addEventListener("click", () => {
  state.theme = (state.theme ? state.theme === "dark" : dark.matches) ? "light" : "dark";
  showTheme();
  keepAddress();
});

// the beginning

function begin() {
  document.body.classList.toggle("is-recorded", Boolean(recorded));
  const key = readAddress(location.hash);
  const opened = new URLSearchParams(location.hash.slice(1)).get("measured");
  if (opened && !tellsOfRotor(location.hash)) {
    showAlone(opened);
    $("verdict").textContent = opened;
  }
  listen();
  showState();
  showTheme();
  if (recorded) beginRecorded();
  else {
    kept = new Address({ told: () => address(starts, hanging[0]), show: goBack });
    connection = new Live(keyKept(key), { answered, opened: () => {
      ask({ again: true });
      if (opened && !measured.found) measured.read(new File([], opened)); // the program has it
    }, said });
  }
}

/** Show the state in all controls. */
function showState() {
  const { from, units } = $("controls").elements;
  from.value = state.from;
  units.value = inSI() ? "si" : "none";
  $("beside").checked = state.second !== null;
  showSystem();
  $("revolutions").value = state.revolutions;
  starts = [START, SECOND_START].map((names) => names.map((name, i) => state[name] ?? state[START[i]]));
  hanging = [state.hangs, state.hangs];
  controls.build();
  showRamp();
  controls.unfold();
  buildSides();
  chooseSignals();
}

/** Show the state of the connection. */
function said(text) {
  say(text);
  if (text) {
    passage.fail();
    measured.fail("the program does not answer");
  }
  if (text && number) lose(number + 1);
}

/** Offer the recorded speeds and courses, or the nodes, and show the requested one. */
function beginRecorded() {
  const { places, place, state: rotorShown } = recorded;
  setRotor(rotorShown);
  connection = new Recorded(recorded, answered);
  if (isSystem()) {
    recorded.course = "nodes";
    moveTo = (node) => {
      recorded.place = places.indexOf(node);
      ask();
    };
    showState();
    moveTo(place);
    return;
  }
  recorded.course = "start";
  const range = Object.assign($("recorded-speed"), { max: places.length - 1 });
  const given = Object.entries(rotorShown).filter(([name]) => name in PARAMETERS && !["omega", "speed"].includes(name));
  $("recorded-rotor").textContent = given.map(([name, value]) => parameterShown(name, value)).join(", ");
  const goTo = (number) => {
    recorded.place = range.value = number;
    const words = `Speed ${inSI() ? `${told(places[number] * SPEED_UNITS[state.speedIn])} ${state.speedIn}` : told(places[number], 5)}`;
    $("recorded-name").textContent = words;
    range.setAttribute("aria-valuetext", words);
    ask();
  };
  onChoice("course", (course) => {
    recorded.course = course;
    response.forgetTrail();
    ask();
  });
  range.addEventListener("input", () => goTo(range.valueAsNumber));
  moveTo = (value) => goTo(nearestIn(places, value));
  moveTo(place);
}

begin();
