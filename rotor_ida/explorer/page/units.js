// Displayed numbers: dimensionless, or in SI units with a suitable prefix.

import { state } from "./state.js";
import { SPEED_UNITS } from "./tables.js";

const UNITS = { length: "m", time: "s", force: "N", velocity: "m/s", energy: "J" };
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** Return the factor and the unit for numbers of a kind up to about `top`. */
export function shownIn(scales, kind, top) {
  const scale = scales?.[kind];
  if (!scale) return { factor: 1, unit: "" };
  if (kind === "rate") return { factor: scale * SPEED_UNITS[state.speedIn], unit: state.speedIn };
  const [size, prefix] = prefixFor(Math.abs(scale * top));
  return { factor: scale / size, unit: prefix + UNITS[kind] };
}

/** Return the size and the letter of the prefix that keeps a number short; none for 0. */
const prefixFor = (large) => (large ? (PREFIXES.find(([least]) => large >= least * 0.9999) ?? PREFIXES.at(-1)) : [1, ""]);

/** Return a typed speed in rad/s and its unit, which is the one shown if none is typed; null for other text. */
export function speedTyped(text) {
  const [, digits, typed] = /^([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z/]*)$/i.exec(text.trim().replace(/,(?=\d{3}\b)/g, "")) ?? [];
  const unit = typed ? Object.keys(SPEED_UNITS).find((each) => each.toLowerCase() === typed.toLowerCase()) : state.speedIn;
  return unit && Number.isFinite(Number(digits)) ? { speed: Number(digits) / SPEED_UNITS[unit], unit } : null;
}

/** Return the factor and the unit, with a prefix, in which to show a quantity of about some size. */
export function prefixed(unit, size) {
  if (!/^[mNs](?![a-z])/.test(unit)) return { factor: 1, unit };
  const [parts, prefix] = prefixFor(Math.abs(size));
  return { factor: 1 / parts, unit: prefix + unit };
}

/** Return a name with its unit, for an axis. */
export const labelled = (name, unit) => (unit ? `${name} [${unit}]` : name);

/** Return a number with about this many digits, in common notation. */
export function told(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
}

/** Return a dimensionless value of a kind with its unit, for a sentence. */
export function withUnit(scales, kind, value, digits = 4) {
  const { factor, unit } = shownIn(scales, kind, value);
  return `${told(value * factor, digits)}${unit && ` ${unit}`}`;
}
