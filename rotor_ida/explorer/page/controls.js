// Sliders and number fields for the parameters of the state.

import { SYSTEM, changeExponent, file, inSI, isSystem, namesBeyond, roundUp, scalesBeyond, state } from "./state.js";
import { GRAVITY, PARAMETERS, ROOM, SPEED_UNITS } from "./tables.js";
import { element } from "./tools.js";
import { prefixed, speedTyped, told } from "./units.js";

const STEPS = 1000;
const linear = (low, high, step) => () => ({
  toSlider: (value) => value, fromSlider: (place) => place, min: low, max: high, step,
});
/** A slider over powers of ten of a scale of the machine. */
const logarithmic = (low, high, scale = () => 1) => ({
  toSlider: (value) => (value > 0 ? (STEPS * Math.log(value / (low * scale()))) / Math.log(high / low) : 0),
  fromSlider: (place) => Number((low * scale() * (high / low) ** (place / STEPS)).toPrecision(3)),
  min: 0, max: STEPS, step: 1,
});
/** A slider from 0 to a value, in steps of a four-hundredth; round as it is shown. */
const upTo = (most, shown = () => 1) => ({
  toSlider: (value) => value / most,
  fromSlider: (place) => Number((place * most * shown()).toPrecision(4)) / shown(),
  min: 0, max: 1, step: 1 / 400,
});
const speedShown = () => SPEED_UNITS[state.speedIn];
// Range of the sliders of a machine, as multiples of the given value.
const TIMES = 2, DECADE = 10;
// Given values of the machine; its sliders are centred on these.
let given = {};
/** Return a slider from 0 to twice the given value; if that is 0, up to a scale of the machine. */
const around = (name, scale) => () => upTo(roundUp(TIMES * given[name] || scale()));
/** Return a slider over powers of ten around the given value. */
const decades = (name) => () => logarithmic(1 / DECADE, DECADE, () => given[name]);

/** Sliders by parameter: without dimensions, and in SI units. */
const SLIDERS = {
  none: {
    omega: linear(0.05, 4, 0.005),
    zeta: linear(0, 0.5, 0.001),
    delta0: linear(0, 6, 0.01),
    shaft_stiffness: linear(0, 4, 0.01),
    contact_damping: linear(0, 3, 0.01),
    load: linear(0, 10, 0.02),
    friction: linear(0, 0.5, 0.005),
    disc_radius: () => logarithmic(0.1, 1e5),
  },
  si: {
    speed: () => upTo(ROOM * state.fastest, speedShown),
    clearance: around("clearance", () => 6 * state.eccentricity),
    eccentricity: decades("eccentricity"),
    damping: around("damping", () => Math.sqrt(state.mass * (state.shaft_stiffness || scalesBeyond().shaft_stiffness))),
    mass: decades("mass"),
    contact_stiffness: decades("contact_stiffness"),
    shaft_stiffness: around("shaft_stiffness", () => scalesBeyond().shaft_stiffness),
    contact_damping: around("contact_damping", () => scalesBeyond().contact_damping),
    load: around("load", () => TIMES * state.mass * GRAVITY),
    friction: linear(0, 0.5, 0.005),
    disc_radius: decades("disc_radius"),
    unbalance_factor: linear(0, 4, 0.01),
  },
};
/** Whether sliders lie around the values of a machine. */
const isGiven = () => inSI() || isSystem();
/** Return the sliders of the rotor shown. */
const slidersShown = () => SLIDERS[isGiven() ? "si" : "none"];
const FOLDED = ["shaft_stiffness", "contact_damping", "load", "friction", "disc_radius"];
/** Return a number for its field: short, with a power of ten where that helps. */
export function written(value) {
  const size = Math.abs(value);
  return value === 0 || (size >= 1e-3 && size < 1e6) ? String(value) : value.toExponential().replace("e+", "e");
}

/** Call `step` with 1 or -1 when an arrow key goes up or down, with 10 or -10 with Shift. */
export function onArrows(element, keys, step) {
  element.addEventListener("keydown", (event) => {
    const sign = keys[event.key];
    if (!sign || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    step(sign * (event.shiftKey ? 10 : 1));
  });
}
export const UP_AND_DOWN = { ArrowUp: 1, ArrowDown: -1 };
const ALL_ARROWS = { ...UP_AND_DOWN, ArrowRight: 1, ArrowLeft: -1 };

/** A choice of the unit in which speeds are shown. */
function unitChoice(units, changed) {
  const select = Object.assign(document.createElement("select"), { id: "speed-unit" });
  select.setAttribute("aria-label", "Unit of speed");
  for (const each of Object.keys(units)) select.add(new Option(each, each, false, each === state.speedIn));
  select.addEventListener("change", () => {
    state.speedIn = select.value;
    changed();
  });
  return select;
}

/** A slider with a number field; both change `state[key]` and call `changed`. */
function control(key, parameter, changed, unitChanged) {
  const box = element("div", "", "control");
  box.title = parameter.meaning;
  const { name, unit, units } = parameter;
  let slider = parameter.slider();
  const shown = () => (units ? units[state.speedIn] : parameter.factor);
  let typed = null; // what was typed, as long as it holds
  const head = element("span", "", "name");
  const label = document.createElement("label");
  label.append(name, unit && !units ? element("span", ` [${unit}]`, "unit") : "");
  const field = Object.assign(document.createElement("input"), { type: units ? "text" : "number", inputMode: "decimal", step: "any", id: `field-${key}`, min: 0, required: true });
  const range = Object.assign(document.createElement("input"), { type: "range", id: `slider-${key}` });
  label.htmlFor = field.id;
  range.setAttribute("aria-label", `${name}${unit ? `, ${unit}` : ""}`);
  Object.assign(range, { min: slider.min, max: slider.max, step: slider.step });
  head.append(label);
  const choice = units && unitChoice(units, unitChanged);
  if (units) head.append(choice);
  box.append(head, field, range);
  const write = () => {
    const value = state[key] * shown();
    field.value = written(typed?.value === state[key] && typed.shown === shown() ? typed.text : isGiven() ? Number(value.toPrecision(4)) : value);
  };
  const place = () => {
    // a value past the slider's end becomes its new centre
    if (isGiven() && !(slider.toSlider(state[key]) <= slider.max * 1.0001 && slider.toSlider(state[key]) >= slider.min - 1e-9)) given[key] = state[key];
    slider = parameter.slider();
    Object.assign(range, { min: slider.min, max: slider.max, step: slider.step });
    range.value = slider.toSlider(state[key]);
    range.setAttribute("aria-valuetext", `${field.value} ${units ? state.speedIn : unit}`.trim());
  };
  range.addEventListener("input", () => {
    state[key] = slider.fromSlider(Number(range.value));
    write();
    changed();
  });
  field.addEventListener("input", () => {
    const speed = units && speedTyped(field.value);
    if (units ? !speed : !Number.isFinite(field.valueAsNumber)) return;
    state[key] = units ? speed.speed : field.valueAsNumber / shown();
    const other = units && speed.unit !== state.speedIn;
    if (other) state.speedIn = speed.unit;
    typed = { value: state[key], shown: shown(), text: units ? parseFloat(field.value.replaceAll(",", "")) : field.valueAsNumber };
    if (other) unitChanged();
    if (key === "speed") state.fastest = Math.max(state.fastest, state.speed / ROOM);
    changed();
  });
  if (units) field.addEventListener("change", write); // a number alone, whatever was typed
  // from the value, which may lie between the steps of the slider or past its end
  const step = (count) => {
    const next = slider.toSlider(state[key]) + count * slider.step;
    state[key] = slider.fromSlider(Number(Math.max(next, slider.min).toPrecision(12)));
    write();
    changed();
  };
  onArrows(range, ALL_ARROWS, step);
  onArrows(field, UP_AND_DOWN, step);
  const show = () => {
    if (units) choice.value = state.speedIn;
    if (document.activeElement !== field) write();
    place();
  };
  return { box, show };
}

/** Return a parameter with its value and unit, for a list. */
export function parameterShown(key, value) {
  const { name } = parameterOf(key);
  return `${name[0].toLowerCase() + name.slice(1)} ${valueShown(key, value)}`;
}

/** Return the value of a parameter with its unit. */
export function valueShown(key, value) {
  const { units } = parameterOf(key);
  if (!inSI()) return told(value);
  const { unit, factor } = units ? { unit: state.speedIn, factor: units[state.speedIn] } : prefixed(unitOf(key), value);
  return `${told(value * factor)} ${unit}`.trim();
}

const unitOf = (key) => (key === "contact_stiffness" && state.contact_exponent === 1 ? "N/m" : PARAMETERS[key].unit);

/** Return the displayed data of a parameter; the unit of the contact stiffness depends on the contact law. */
function parameterOf(key) {
  const { words, symbol, meaning, si_meaning: meaningInSI } = PARAMETERS[key];
  const name = words[0].toUpperCase() + words.slice(1) + (symbol && !inSI() ? ` ${symbol}` : "");
  const shown = inSI() ? prefixed(unitOf(key), given[key] || state[key]) : { unit: "", factor: 1 };
  return {
    name, meaning: inSI() ? meaningInSI : meaning, ...shown,
    units: key === "speed" && inSI() ? SPEED_UNITS : null, slider: slidersShown()[key],
  };
}

/** Return what may be changed of a rotor system: nothing of one that is played from an archive, or not known yet. */
const namesOfSystem = () => (file && !file.is_archive && !document.getElementById("recorded") ? SYSTEM.filter((name) => state[name] !== undefined) : []);

export class Controls {
  constructor(changed, unitChanged) {
    this.machine = document.getElementById("machine");
    // the meaning of one slider may depend on the value of another
    const andShow = (then) => () => {
      this.show();
      then();
    };
    Object.assign(this, { changed: andShow(changed), unitChanged: andShow(unitChanged) });
    for (const radio of document.querySelectorAll('[name="exponent"]')) {
      radio.addEventListener("change", () => {
        changeExponent(Number(radio.value));
        this.build();
        changed();
      });
    }
    document.getElementById("weight").addEventListener("click", () => {
      state.load = Number((state.mass * GRAVITY).toPrecision(12));
      this.changed();
    });
    this.build();
  }

  /** Build the sliders in the units of the state, around its values. */
  build() {
    given = isGiven() ? { ...state } : {};
    const names = isSystem() ? namesOfSystem() : Object.keys(slidersShown()).filter((name) => !FOLDED.includes(name) && name !== "unbalance_factor");
    const own = names.map((name) => control(name, parameterOf(name), this.changed, this.unitChanged));
    own[0]?.box.classList.add("first");
    document.getElementById("sliders").replaceChildren(...own.map(({ box }) => box));
    this.controls = own;
    if (isSystem()) {
      this.show();
      return;
    }
    const beyond = FOLDED.map((name) => control(name, parameterOf(name), this.changed));
    beyond.forEach(({ box }, place) => document.getElementById(`beyond-${place}`).replaceChildren(box));
    document.getElementById("weight").hidden = !inSI();
    this.controls = [...own, ...beyond];
    const clearance = parameterOf(inSI() ? "clearance" : "delta0");
    this.second = control("second", { ...clearance, name: `${clearance.name}, second` }, this.changed);
    document.getElementById("second").replaceChildren(this.second.box);
    this.show();
  }

  /** Unfold the further parameters if any is set. */
  unfold() {
    if (!isSystem() && namesBeyond().length) this.machine.open = true;
  }

  /** Show the state. */
  show() {
    for (const radio of document.querySelectorAll('[name="exponent"]')) radio.checked = Number(radio.value) === state.contact_exponent;
    for (const each of this.controls) each.show();
    if (isSystem()) return;
    this.second.box.hidden = state.second === null;
    if (state.second !== null) this.second.show();
  }
}
