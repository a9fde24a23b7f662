// @ts-check
// What the hammer of the present case looks like: the sections of bar and tool, for the stage to draw to scale.

import { read } from "../core/units.js";
import { data } from "../core/state.js";
import { PLAIN } from "./stage.js";

/** @typedef {{ length: number, thick: number }} Section */

/** In metres; a case without sizes has a bar of one thickness. */
export function shapeOfCase() {
  const { tables, info } = data;
  if (!tables) return PLAIN;
  const known = (info?.bar?.sections ?? []).map((/** @type {any} */ one) => ({
    length: one.length_m,
    thick: one.diameter_m,
  }));
  const bar = known.length && (tables.bar?.sections || tables.bar?.length) ? known : PLAIN.bar;
  return {
    bar,
    tool: known.length ? toolOf(tables.tool) : [],
    held: Boolean(tables.body),
    rock: Boolean(tables.rock && tables.tool),
  };
}

/** Sections of the tool whose length and diameter are told; an endless rod is drawn as long as there is room.
 * @param {any} tool @returns {Section[]} */
function toolOf(tool) {
  const sections = Array.isArray(tool?.sections) ? tool.sections : [];
  const metres = (/** @type {unknown} */ text) => read(String(text ?? ""), "m").value;
  return sections
    .map((/** @type {any} */ one) => ({ length: metres(one.length) || 10, thick: metres(one.diameter) || 0 }))
    .filter((/** @type {Section} */ one) => one.thick > 0);
}
