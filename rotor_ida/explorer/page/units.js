// Numbers as they are shown: without dimensions, or in SI units with a prefix that suits.

import { state } from "./state.js";

/** How many of a unit of speed are one radian a second. */
export const SPEED_UNITS = { "rad/s": 1, rpm: 30 / Math.PI, Hz: 0.5 / Math.PI };
const UNITS = { length: "m", time: "s", force: "N", velocity: "m/s", energy: "J" };
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"], [1e-15, "f"]];

/** Return the factor and the unit in which to show numbers of a kind, of which `top` is large. */
export function shownIn(scales, kind, top) {
  const scale = scales?.[kind];
  if (!scale) return { factor: 1, unit: "" };
  if (kind === "rate") return { factor: scale * SPEED_UNITS[state.speedIn], unit: state.speedIn };
  const large = Math.abs(scale * top);
  const [size, prefix] = PREFIXES.find(([least]) => large >= least) ?? PREFIXES.at(-1);
  return { factor: scale / size, unit: prefix + UNITS[kind] };
}

/** Return a name with its unit, as an axis has it. */
export const labelled = (name, unit) => (unit ? `${name} [${unit}]` : name);

/** Return a number with about so many digits, as a person would write it. */
export function told(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
}

/** Return a dimensionless value of a kind with its unit, as a sentence has it. */
export function withUnit(scales, kind, value, digits = 4) {
  const { factor, unit } = shownIn(scales, kind, value);
  return `${told(value * factor, digits)}${unit && ` ${unit}`}`;
}

/** Return a round number just above another, so that an axis does not tremble. */
export function roundUp(value) {
  if (!(value > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(value));
  return ten * [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((step) => step * ten >= value * 0.999999);
}
