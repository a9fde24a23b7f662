// Edits of a case's tables by hand, and what parameters stand at. What a slider or the map moves is moved by the
// server, which knows how a parameter is written in a case. Tables are never changed in place.

import { plainNumber, quantity } from "./format.js";
import { converted } from "./units.js";

/** A case as it is written: its tables by name. @typedef {Record<string, any>} Tables */

/** The steps of a key: "bar.sections[1].length" → bar, sections, 1, length. */
export const steps = (/** @type {string} */ key) => key.split(/[.[\]]+/).filter(Boolean);

/** The tables with one key set, or taken out when the value is undefined.
 * @param {Tables} tables @param {string} key @param {any} value @returns {Tables} */
export function withKey(tables, key, value) {
  const found = withStep(tables, steps(key), value);
  for (const table of ["start", "simulation"])
    if (key.startsWith(`${table}.`) && !Object.keys(found[table]).length) delete found[table];
  return found;
}

/** @param {any} inside @param {any[]} path @param {any} value @returns {any} */
function withStep(inside, [step, ...rest], value) {
  /** @type {any} */
  const found = Array.isArray(inside)
    ? [...inside]
    : typeof inside === "object"
      ? { ...inside }
      : /^\d+$/.test(step)
        ? []
        : {};
  const next = rest.length ? withStep(found[step], rest, value) : value;
  if (next !== undefined) found[step] = next;
  else if (Array.isArray(found))
    found[step] = null; // the others keep their places
  else delete found[step];
  return found;
}

/** @param {Tables} tables @param {string} key @returns {any} */
export const valueAt = (tables, key) => steps(key).reduce((found, step) => found?.[step], tables);

/** The key of the number that a key holds: of a table such as {kind = "ratio", value = 1e-3} that of its value. @param {Tables} tables @param {string} key */
export const heldAt = (tables, key) => (valueAt(tables, key)?.value === undefined ? key : `${key}.value`);

/** A range as the address keeps it, with the unit that its numbers are in: "300:340 mm".
 * @param {number} from @param {number} to @param {string | undefined} unit */
export const rangeText = (from, to, unit) => `${from}:${to}${unit ? ` ${unit}` : ""}`;

/** The range of an address, [from, to]; null for none, or none in this unit. @param {string} text @param {string} unit
 * @returns {[number, number] | null} */
export function rangeOf(text, unit) {
  const found = /^([-+.\deE]+):([-+.\deE]+)(?: (.+))?$/.exec(text);
  if (!found) return null;
  const [from, to] = [Number(found[1]), Number(found[2])];
  return isRange(from, to) && (found[3] ?? unit) === unit ? [from, to] : null;
}

export const isRange = (/** @type {number} */ from, /** @type {number} */ to) =>
  Number.isFinite(from) && Number.isFinite(to) && from < to;

/** What is typed for a key, in the unit that the key has: a length in mm stays one when 32 cm are typed. @param {any} text @param {any} before */
export function inOwnUnit(text, before) {
  const [now, own] = [text, before].map((one) => (typeof one === "string" ? quantity(one) : null));
  if (typeof text === "number" && own?.unit) return `${text} ${own.unit}`;
  if (!now?.unit || !own?.unit || now.unit === own.unit) return text;
  const value = converted(now.value, now.unit, own.unit);
  return Number.isFinite(value) ? `${plainNumber(value, 12)} ${own.unit}` : text;
}

/** The unit in which a key is written; undefined where the key has no number. @param {Tables} tables @param {string} key */
export const unitOf = (tables, key) => quantity(valueAt(tables, heldAt(tables, key)))?.unit;

/** The number that a parameter stands at now; undefined when it has none.
 * @param {Record<string, any>} data @param {string} name @returns {number | undefined} */
export function present(data, name) {
  if (name in data.placed) return data.placed[name];
  const known = data.info?.parameters.find((/** @type {any} */ p) => p.name === name);
  if (known?.dimensionless) return data.quick?.[name] ?? data.tables.system?.[name] ?? known.value ?? undefined;
  const written = quantity(valueAt(data.tables, heldAt(data.tables, name)));
  // in another unit, or in none that fits, only the server can tell
  return written && written.unit === known?.unit ? written.value : (known?.value ?? undefined);
}
