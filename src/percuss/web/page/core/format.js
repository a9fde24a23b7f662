// How numbers are written: enough digits to work with, a thin space before the unit, a real minus sign.

import { THIN, converted, number, printed, read, shown } from "./units.js";
import { language } from "./words.js";

export { number };

/** The system of units that is read and typed: "practical", as the case and the field's data sheets have them, SI or US. */
export const system = /** @type {import("./units.js").System} */ (localStorage.getItem("percuss-units") ?? "practical");

/** Another one, for the whole page. @param {string} name */
export function useSystem(name) {
  localStorage.setItem("percuss-units", name);
  location.reload();
}

/** A quantity in the units that are read. @param {number} value @param {string} unit */
const inSystem = (value, unit) => (system === "practical" || !unit ? { value, unit } : shown(value, unit, system));

/** What is typed into a field of a quantity: in its unit, as a number of it, or {error, remedy}. @param {string} text
 * @param {string} unit @returns {import("./units.js").Quantity | import("./units.js").Refused} */
export function typedQuantity(text, unit) {
  const own = inSystem(1, unit).unit;
  const found = read(text, own, language);
  return found.error !== undefined ? found : { value: converted(found.value, own, unit), unit };
}

/** @param {number} value @param {string} unit @param {number} [digits] */
export function withUnit(value, unit, digits = 4) {
  const told = inSystem(value, unit);
  return `${number(told.value, digits)}${told.unit ? THIN + printed(told.unit) : ""}`;
}

/** A quantity before its unit, as on every axis: "stress [MPa]". @param {string} name @param {string} unit */
export const inUnit = (name, unit) => (unit ? `${name} [${printed(unit)}]` : name);

/** @type {[number, string][]} */
const LADDER = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
];

/** The factor and the unit with prefix in which a number of this size reads best. @param {number} size @param {string} unit */
export function scaleOf(size, unit) {
  const magnitude = Math.abs(size);
  if (!magnitude || !Number.isFinite(magnitude)) return { factor: 1, unit };
  const [factor, prefix] = LADDER.find(([limit]) => magnitude >= limit * 0.9999) ?? LADDER[LADDER.length - 1];
  return { factor: 1 / factor, unit: prefix + unit };
}

/** A quantity in SI with a prefix that suits it: 5700 J → 5.7 kJ. @param {number | null | undefined} value @param {string} unit @param {number} [digits] */
export function si(value, unit, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (system === "US") return withUnit(value, unit, digits);
  const scale = scaleOf(value, unit);
  return `${number(value * scale.factor, digits)}${scale.unit ? THIN + scale.unit : ""}`;
}

/** "1 start", "2 starts". @param {number} count @param {string} word */
export const counted = (count, word) => {
  const text = Number.isInteger(count) ? String(count) : number(count, 4);
  return `${text} ${word}${text === "1" ? "" : "s"}`;
};

/** An angle in radians and degrees. */
export const angle = (/** @type {number} */ phase) =>
  `${number(phase)}${THIN}rad (${number((phase * 180) / Math.PI)}°)`;

export const percent = (/** @type {number} */ share, digits = 3) => withUnit(share * 100, "%", digits);

/** "341 mm" → {value: 341, unit: "mm"}; a plain number has the unit "". @param {any} text @returns {{ value: number, unit: string } | null} */
export function quantity(text) {
  if (typeof text === "number") return { value: text, unit: "" };
  const found = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/.exec(String(text ?? ""));
  return found ? { value: Number(found[1]), unit: found[2] } : null;
}

/** A number as it is written into a case: short, exact enough for a slider, never in words. @param {number} value */
export function plainNumber(value, digits = 4) {
  return Number(value.toPrecision(digits));
}

/** The first four of a list, in a line. @param {(string | number)[]} items */
export const few = (items) => items.slice(0, 4).join(", ") + (items.length > 4 ? ", …" : "");
