// State of the page, stored in its address after the #.

import { DIMENSIONLESS, LEAST_SPEED, MACHINE, OPTIONAL, ROOM, START } from "./tables.js";

// Parameters that the paper's rotor lacks; the disc radius matters only with friction.
const { disc_radius: _, ...BEYOND } = OPTIONAL;
// Default disc radius with friction, in eccentricities.
const DISC_RADIUS = 10;
// Panels of signals that may be chosen.
export const SIGNALS = ["bode", "polar", "full", "cascade", "campbell"];
// Those that one disc and a rotor system begin with.
export const USUAL = "full";
const OF_SYSTEM = "bode,full,cascade,campbell";
// What sliders change of a rotor system: all of it, and the chosen contact.
const OF_ALL = ["speed", "unbalance_factor"], OF_CONTACT = ["clearance", "contact_stiffness", "contact_damping", "friction"];
export const SYSTEM = [...OF_ALL, ...OF_CONTACT];
const WORDS = { from: ["start", "here"], theme: ["", "light", "dark"], speedIn: ["rad/s", "rpm", "Hz"] };
// Start of the second run, if it differs.
export const SECOND_START = START.map((name) => `${name}2`);
const NUMBERS = ["unbalance_factor", ...SECOND_START, ...DIMENSIONLESS, ...MACHINE, ...Object.keys(BEYOND), "disc_radius", ...START, "revolutions", "second", "ramp", "fastest", "seconds"];

const DEFAULTS = {
  omega: 2, zeta: 0.07, delta0: 2,
  ...BEYOND, disc_radius: null,
  x: 0, y: 0, vx: 0, vy: 0, hangs: true, // whether it starts at rest where it hangs under its load
  second: null, // clearance of the rotor beside it, in the units of the first one
  revolutions: 60, from: "start", ramp: 0.002, theme: "", speedIn: "rpm", panels: "full",
  fastest: null, seconds: null, // of a machine: the speed to which it is run up [rad/s], from standstill in so long [s]
};
// Default run-up time of a machine in seconds.
const SECONDS = 20;
// Range of speeds of a dimensionless rotor, and the largest allowed one.
const SPEEDS = [0.05, 4], FASTEST = 1e6;
export const state = { ...DEFAULTS, disc_radius: DISC_RADIUS };

/** Whether the rotor is a system of some nodes, in a file that the program has. */
export const isSystem = () => state.node !== undefined;

/** What the program has answered about that file; null before the first answer. */
export let file = null;

/** That of a file that has no rotor to move. */
export const NO_FILE = { nodes: [], positions: [], contacts: [], given: { speed: 1 }, given_contacts: [], is_archive: true };

/** Show a measurement alone, in SI units. */
export function showAlone(measured) {
  Object.assign(state, { node: "", contact: 0, panels: "" });
  file = { ...NO_FILE, units: "SI", measured, panels: ["archive", ...SIGNALS.filter((name) => name !== "campbell")] };
}

/** Whether the rotor is given as a machine in SI units, or is a system in these. */
export const inSI = () => (isSystem() ? file?.units === "SI" : state.mass !== undefined);

/** Return the name of the speed in the state. */
export const speedName = () => (isSystem() || inSI() ? "speed" : "omega");

/** Take the answer about the file of a system; changes of another file are dropped. */
export function tellFile(facts) {
  file = facts;
  if (facts) suitSystem();
}

/** Choose a contact: changes are of one, and the other one is again as in the file. */
export function chooseContact(contact) {
  state.contact = contact;
  for (const name of OF_CONTACT) delete state[name];
  suitSystem();
}

const givenOfSystem = () => ({ ...file?.given, ...file?.given_contacts[state.contact] });

/** Fill in what is as in the file. */
function suitSystem() {
  if (!file) return;
  for (const [name, value] of Object.entries(givenOfSystem())) state[name] ??= value;
  state.contact_exponent = givenOfSystem().contact_exponent ?? state.contact_exponent;
  state.fastest = Math.max(file.given.speed, state.speed / ROOM);
}

/** Return what differs from the file. */
function changesOfSystem() {
  const given = givenOfSystem();
  return Object.fromEntries(SYSTEM.filter((name) => state[name] !== undefined && state[name] !== given[name]).map((name) => [name, state[name]]));
}

/** Return the names of the further parameters; the disc radius only with friction. */
export const namesBeyond = () => [...Object.keys(BEYOND).filter((name) => state[name] !== BEYOND[name]), ...(state.friction ? ["disc_radius"] : [])];

const usualPanels = () => (isSystem() ? OF_SYSTEM : USUAL);
const usualRadius = () => DISC_RADIUS * (inSI() ? state.eccentricity : 1);

/** Read the state from an address; return its key, if any. Missing entries get defaults. */
export function readAddress(hash) {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const isOfFile = given.has("node");
  const names = isOfFile ? SYSTEM : MACHINE.every((name) => given.has(name)) ? MACHINE : DIMENSIONLESS;
  for (const name of Object.keys(state)) delete state[name];
  Object.assign(state, DEFAULTS);
  if (isOfFile) {
    for (const name of [...DIMENSIONLESS, ...OF_CONTACT]) delete state[name];
    Object.assign(state, { node: given.get("node"), contact: Number(given.get("contact")) || 0 });
  }
  if (names === MACHINE) for (const name of DIMENSIONLESS) delete state[name];
  for (const name of NUMBERS) {
    if ([...DIMENSIONLESS, ...MACHINE, ...(isOfFile ? Object.keys(BEYOND) : ["unbalance_factor"])].includes(name) && !names.includes(name)) continue;
    const text = given.get(name);
    if (text !== null && text !== "" && Number.isFinite(Number(text))) state[name] = Number(text);
  }
  state.hangs = !START.some((name) => given.has(name));
  state.disc_radius ??= usualRadius();
  if (isOfFile) suitSystem();
  else if (inSI()) suitMachine();
  for (const [name, words] of Object.entries(WORDS)) {
    if (words.includes(given.get(name))) state[name] = given.get(name);
  }
  const panels = (given.get("panels") ?? usualPanels()).split(",");
  state.panels = SIGNALS.filter((name) => panels.includes(name)).join();
  return given.get("key");
}

/** Whether an address contains a rotor. */
export const tellsOfRotor = (hash) => /[#&](omega|mass|node)=/.test(hash);

/** Return the address entries for the state and for the starts of the runs; a first one that hangs at rest has none. */
export function address([first, second], hangs) {
  if (file?.measured) return `#${new URLSearchParams({ measured: file.measured })}`;
  const own = isSystem() ? { node: state.node, contact: state.contact, ...changesOfSystem() } : Object.fromEntries([...(inSI() ? MACHINE : DIMENSIONLESS), ...namesBeyond()].map((name) => [name, state[name]]));
  const told = new URLSearchParams(own);
  const put = (names) => names.forEach((name) => told.set(name, state[name]));
  if (!isSystem()) {
    if (!hangs) START.forEach((name, place) => told.set(name, first[place]));
    if (state.second !== null && state.from === "here") SECOND_START.forEach((name, place) => told.set(name, second[place]));
    put(["from"]);
    if (!state.friction && state.disc_radius !== usualRadius()) put(["disc_radius"]);
    if (inSI()) put(["fastest", "seconds"]);
    else if (state.ramp !== DEFAULTS.ramp) put(["ramp"]);
  }
  put(["revolutions", ...["second", "theme", "speedIn"].filter((name) => state[name] !== DEFAULTS[name])]);
  if (state.panels !== usualPanels()) put(["panels"]);
  return `#${told}`;
}

/** Return the machine of one side, for a question; of a system the node, what is changed, and the contact. */
export function machine(side) {
  if (isSystem()) {
    const { speed = null, ...changes } = changesOfSystem();
    return side ? { node: "", contact: state.second, speed, changes: changes.unbalance_factor === undefined ? {} : { unbalance_factor: changes.unbalance_factor } } : { node: state.node, contact: state.contact, speed, changes };
  }
  const names = [...(inSI() ? MACHINE : DIMENSIONLESS), ...namesBeyond()];
  const given = Object.fromEntries(names.map((name) => [name, state[name]]));
  if (side === 1) given[inSI() ? "clearance" : "delta0"] = state.second;
  return given;
}

/** Return a round number just above another, so that an axis stays still. */
export function roundUp(value, steps = [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10]) {
  if (!(value > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(value));
  return ten * steps.find((step) => step * ten >= value * 0.999999);
}

/** Return the reference frequency in rad/s, the rate of a dimensionless 1. */
export const referenceFrequency = () => isSystem() ? 1 : Math.sqrt((state.contact_stiffness * slopeScale()) / state.mass);

/** Return the factor from the contact stiffness to that of a spring, in N/m. */
const slopeScale = () => (state.contact_exponent > 1 ? Math.sqrt(state.eccentricity) : 1);

/** Return a dimensionless 1 of the further parameters in SI units. */
export function scalesBeyond() {
  const rate = referenceFrequency();
  const stiffness = state.mass * rate ** 2;
  return {
    shaft_stiffness: stiffness, contact_damping: 1 / (state.eccentricity * rate), load: stiffness * state.eccentricity,
    disc_radius: state.eccentricity,
  };
}

/** Change the contact law; keep all scales and the force at an indentation of one eccentricity. */
export function changeExponent(exponent) {
  const before = inSI() ? slopeScale() : 1;
  state.contact_exponent = exponent;
  if (inSI()) state.contact_stiffness = Number(((state.contact_stiffness * before) / slopeScale()).toPrecision(12));
}

/** Convert the rotor to a machine in SI units, of a default size if it had none. */
export function toSI() {
  const { omega, zeta, delta0, second } = state;
  Object.assign(state, { mass: 4, contact_stiffness: state.contact_exponent > 1 ? 1e9 : 1e6, eccentricity: 1e-6 });
  const rate = referenceFrequency();
  state.damping = 2 * zeta * state.mass * rate;
  state.clearance = delta0 * state.eccentricity;
  state.speed = omega * rate;
  Object.assign(state, { fastest: null, seconds: null });
  suitMachine();
  if (second !== null) state.second = second * state.eccentricity;
  for (const [name, scale] of Object.entries(scalesBeyond())) state[name] *= scale;
  for (const name of DIMENSIONLESS) delete state[name];
}

/** Convert the machine to dimensionless parameters. */
export function toDimensionless() {
  const rate = referenceFrequency();
  for (const [name, scale] of Object.entries(scalesBeyond())) state[name] /= scale;
  state.omega = state.speed / rate;
  state.ramp = Number(ramp().toPrecision(6));
  state.zeta = state.damping / (2 * state.mass * rate);
  state.delta0 = state.clearance / state.eccentricity;
  if (state.second !== null) state.second /= state.eccentricity;
  for (const name of MACHINE) delete state[name];
}

/** Fill in the largest speed and the run-up time of a machine. */
function suitMachine() {
  const rate = referenceFrequency();
  state.fastest ??= Math.max(state.speed, (SPEEDS[1] / ROOM) * rate);
  if (ROOM * state.fastest < state.speed) state.fastest = state.speed;
  state.seconds ??= state.ramp === DEFAULTS.ramp && state.shaft_stiffness ? SECONDS : Number((state.fastest / (state.ramp * rate ** 2)).toPrecision(6));
}

/** Show another rotor, given as it stands in the address; all other choices stay. */
export function setRotor(told) {
  const { theme, speedIn, seconds } = state;
  const panels = isSystem() === "node" in told ? { panels: state.panels } : {};
  const kept = { theme, speedIn, ...panels, ...(inSI() && !isSystem() ? { seconds } : {}) };
  readAddress(`#${new URLSearchParams({ ...kept, ...told })}`);
}

/** Return the dimensionless speed shown. */
export const speedOf = () => (speedName() === "speed" ? state.speed / referenceFrequency() : state.omega);

/** Return the speeds over which to show the response: those of the machine, or the usual ones, and the rotor's own. */
export function speedsShown() {
  if (isSystem()) return [0.1 * state.speed, ROOM * state.speed];
  if (inSI()) {
    const top = (ROOM * Math.max(state.fastest, state.speed / ROOM)) / referenceFrequency();
    return [LEAST_SPEED * top, top];
  }
  const { omega } = state;
  const low = omega > 0 && omega < SPEEDS[0] ? 0.5 * omega : SPEEDS[0];
  return [low, omega > SPEEDS[1] ? Math.min(roundUp(1.05 * omega), FASTEST) : SPEEDS[1]];
}

/** Return the dimensionless rate of change of the speed. */
export const ramp = () => (inSI() ? state.fastest / state.seconds / referenceFrequency() ** 2 : state.ramp);
