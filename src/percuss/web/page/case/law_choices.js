// What is chosen by name in a case: the law of damping with its value, what an impact does to the strain, and where the
// load acts.

import { choice, field } from "./form_fields.js";
import { plainNumber } from "../core/format.js";
import { rowsOf, sectioned } from "./sections_table.js";
import { data, setKey, setTables } from "../core/state.js";

/** @typedef {import("../core/moves.js").Tables} Tables */

const LAWS = [
  ["ratio", "ratio (of critical)"],
  ["kelvin_voigt", "Kelvin–Voigt"],
  ["external", "external (a drag)"],
  ["table", "table, by mode"],
];

const LAW_HINT = "the law; a change keeps the damping of the first mode";

/** @param {any} value */
const isTable = (value) => value !== null && typeof value === "object" && !Array.isArray(value);

/** The law of the case by its word; what stands in its place in a link is told of by the server.
 * @param {Tables} tables */
function lawOf({ bar, system }) {
  const { damping, drag } = bar ?? system ?? {};
  if (isTable(damping)) return String(damping.kind);
  if (damping !== undefined) return String(damping);
  return system || drag !== undefined ? "external" : "ratio";
}

const RATIO = "share of critical damping of every elastic mode";
const DRAG = "brakes the bar as a whole, too";

/** The field of the law's value. @param {Tables} tables @param {string} law @returns {import("./fields.js").Field} */
function valueField(tables, law) {
  const name = tables.bar ? "bar" : "system";
  const inTable = isTable(tables[name].damping);
  const key = `${name}.damping.value`;
  if (law === "kelvin_voigt") {
    const unit = tables.bar ? "a time, as 0.2 us" : "η, in radians of the load";
    return [key, "Loss time", `${unit}; the damping grows with the square of the frequency`];
  }
  if (law === "table")
    return [key, "Damping of each mode", `d₁, d₂, … ${tables.bar ? "in 1/s" : "per radian of the load"}`, true];
  if (law === "external") {
    if (!tables.bar) return [inTable ? key : "system.d", "Damping d", `D/(MΩ); ${DRAG}`];
    return [inTable ? key : "bar.drag", "Drag", `force per velocity and length, N*s/m^2; ${DRAG}`];
  }
  const brief = tables.bar && !inTable;
  return [brief ? "bar.damping_ratio" : key, "Damping ratio", brief ? `${RATIO}; 0.001 when empty` : RATIO];
}

/** The choice of a law of damping, and its value. @param {Tables} tables */
export function dampingFields(tables) {
  const law = lawOf(tables);
  const key = tables.bar ? "bar.damping" : "system.damping";
  const known = LAWS.some(([name]) => name === law);
  return [choice(key, "Damping", LAWS, law, changeLaw, LAW_HINT), known && field(valueField(tables, law))];
}

/** Another law that damps the first elastic mode as the present one does; of a table all modes that are known.
 * @param {string} kind */
function changeLaw(kind) {
  const { tables, info } = data;
  const name = tables.bar ? "bar" : "system";
  const { damping, damping_ratio, drag, d, ...rest } = tables[name];
  const rates = info?.body?.damping ?? [0];
  const omega = info?.body?.frequencies?.[0] ?? 1;
  const seconds = (tables.bar && info?.scales?.time_s) || 1; // of one radian
  const line = tables.bar && info?.bar ? info.bar.mass_kg / info.bar.length_m : 1; // a drag is per metre of bar
  const [value, unit, short] = /** @type {Record<string, any[]>} */ ({
    ratio: [plainNumber(rates[0] / (2 * omega)), "", tables.bar && "damping_ratio"],
    kelvin_voigt: [plainNumber((rates[0] / omega ** 2) * seconds * (tables.bar ? 1e6 : 1)), "us"],
    external: [plainNumber((rates[0] / seconds) * line), "N*s/m^2", tables.bar ? "drag" : "d"],
    table: [rates.map((/** @type {number} */ rate) => plainNumber(rate / seconds)), ""],
  })[kind];
  const written = tables.bar && unit ? `${value} ${unit}` : value;
  setTables({ ...tables, [name]: { ...rest, [short || "damping"]: short ? written : { kind, value: written } } });
}

/** What an impact does to the strain. @param {Tables} tables */
export function strainField(tables) {
  const key = tables.bar ? "contact.strain" : "system.strain";
  const present = (tables.bar ? tables.contact : tables.system)?.strain ?? "";
  const uniform = !sectioned(tables);
  const options = [
    ["", `not said: ${tables.bar && uniform ? "reversed" : "kept"}`],
    ["kept", "kept, as in B77"],
    ...(uniform ? [["reversed", "reversed, as by waves"]] : []),
  ];
  const hint = uniform ? "what the impact does to it" : "what the impact does to it; reversed is for uniform bars";
  return choice(key, "Strain at the impact", options, present, (value) => setKey(key, value || undefined), hint);
}

/** Where the load acts, when there is a choice or something to put right. @param {Tables} tables */
export function placeField(tables) {
  const present = tables.load?.at ?? 0;
  if (!sectioned(tables) && present === 0) return null;
  const steps = sectioned(tables) ? Math.max(rowsOf(tables).length - 1, 0) : 0;
  const options = Array.from({ length: steps + 1 }, (_, i) => [
    i,
    i ? `step ${i}: ${i} to ${i + 1}` : "the driven end",
  ]);
  const change = (/** @type {string} */ value) => setKey("load.at", Number(value) || undefined);
  return choice(
    "load.at",
    "Acts at",
    options,
    present,
    change,
    "the driven end, or the step from a section to the next",
  );
}

/** What decides which fields there are for these choices, and how they stand. @param {Tables} tables */
export const chosenLaws = (tables) => [
  lawOf(tables),
  isTable((tables.bar ?? tables.system)?.damping),
  tables.contact?.strain ?? tables.system?.strain,
  tables.load?.at,
  sectioned(tables) && rowsOf(tables).length,
];
