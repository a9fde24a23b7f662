// The sections of a bar, one row each, from the driven to the striking end, and of a tool from the struck face on: in SI
// their sizes and materials, in plain numbers their impedances and transit times.

import { button, div, h, menu, segments, table } from "../core/dom.js";
import { idOf, input, problemOf } from "./form_fields.js";
import { plainNumber, quantity } from "../core/format.js";
import { flush } from "../core/signals.js";
import { typed } from "./fields.js";
import { data, setKey, setTables } from "../core/state.js";

/** @typedef {import("../core/moves.js").Tables} Tables */
/** A chain of sections: its columns by the names of their numbers, its rows in the tables, and what it is called.
 * @typedef {{ form: "bar" | "system" | "tool", columns: [string, string][], rows: (tables: Tables) => any[],
 *   set: (rows: any[]) => void, id: string, who: string, ends: string[], legend: string, hint: string }} Chain */

/** @type {[string, string][]} */
const SIZES = [
  ["length", "Length"],
  ["diameter", "Diameter"],
  ["bore", "Bore"],
  ["area", "or area"],
  ["material", "Material"],
  ["youngs_modulus", "or modulus"],
  ["density", "and density"],
];

/** @type {[string, string][]} */
const PLAIN = [
  ["impedances", "Impedance"],
  ["transit_times", "Transit time"],
];

/** Whether a bar has sections. @param {Tables} tables */
export const sectioned = ({ bar, system }) =>
  bar ? bar.sections !== undefined : [system?.impedances, system?.transit_times].some((list) => list !== undefined);

/** @param {any} found @returns {any[]} */
const listed = (found) => (Array.isArray(found) ? found : []); // a link may have anything in its place

/** The rows as they stand in the tables. @param {Tables} tables @returns {any[]} */
export function rowsOf({ bar, system }) {
  if (bar) return listed(bar.sections);
  const [impedances, times] = PLAIN.map(([name]) => listed(system?.[name]));
  const count = Math.max(impedances.length, times.length);
  return Array.from({ length: count }, (_, i) => ({ impedances: impedances[i], transit_times: times[i] }));
}

/** @param {any[]} rows */
function setRows(rows) {
  const { tables } = data;
  if (tables.bar) return setKey("bar.sections", rows);
  const lists = PLAIN.map(([name]) => [name, rows.map((row) => row[name] ?? null)]);
  setTables({ ...tables, system: { ...tables.system, ...Object.fromEntries(lists) } });
}

const OWN = {
  rows: rowsOf,
  set: setRows,
  id: "sections",
  who: "Section",
  ends: ["driven end", "striking end"],
  legend: "Sections, from the driven to the striking end",
};
/** @type {Chain} */
const BAR = {
  ...OWN,
  form: "bar",
  columns: SIZES,
  hint:
    "Sizes with their unit, as 52 mm: a diameter, with a bore if there is one, or an area. A material that is left " +
    "empty is that of the bar.",
};
/** @type {Chain} */
const SYSTEM = {
  ...OWN,
  form: "system",
  columns: PLAIN,
  hint:
    "Impedances in any one unit, transit times in any one unit: only their ratios count, all transit times together " +
    "are 1/s.",
};
/** @type {Chain} */
const TOOL = {
  form: "tool",
  columns: SIZES,
  rows: ({ tool }) => listed(tool?.sections),
  set: (rows) => setKey("tool.sections", rows),
  id: "tool-sections",
  who: "Section of the tool",
  ends: ["struck face", "far end"],
  legend: "Sections of the tool, from the struck face on",
  hint: "Sizes with their unit. A last section without a length is endless. A material that is left empty is steel.",
};

/** Whether the bar is uniform or has sections, as two buttons. @param {Tables} tables */
export function uniformOrSections(tables) {
  const now = sectioned(tables);
  const pressed = (/** @type {boolean} */ on) => ({ "aria-pressed": String(on) });
  const toUniform = () => now && setTables(uniform(data.tables));
  const toSections = () => now || setTables(inSections(data.tables));
  return segments(
    "The bar is",
    button("Uniform", toUniform, { id: "bar-uniform", ...pressed(!now) }),
    button("Sections", toSections, { id: "bar-sections", ...pressed(now) }),
  );
}

/** The same bar as one section. Strain that turns over is a law of uniform bars only. @param {Tables} tables */
function inSections(tables) {
  if (!tables.bar) {
    const { strain, ...system } = tables.system;
    const kept = strain === undefined || strain === "reversed" ? {} : { strain };
    return { ...tables, system: { ...system, ...kept, impedances: [1], transit_times: [1] } };
  }
  const { length, diameter, area, ...bar } = tables.bar;
  const { strain, ...contact } = tables.contact ?? {};
  if (strain !== undefined && strain !== "reversed") contact.strain = strain;
  return { ...tables, bar: { ...bar, sections: [given({ length, diameter, area })] }, contact };
}

/** A uniform bar as long as all sections, with the cross-section and the material of the striking end.
 * @param {Tables} tables */
function uniform(tables) {
  const { at, ...load } = tables.load;
  if (!tables.bar) {
    const { impedances, transit_times, ...system } = tables.system;
    return { ...tables, system, load };
  }
  const { sections, ...bar } = tables.bar;
  const { bore, material, length, ...last } = rowsOf(tables).at(-1) ?? {};
  const known = data.about.materials[material];
  const [modulus, density] = [known?.youngs_modulus_Pa / 1e9, known?.density_kg_m3];
  const own = known && { youngs_modulus: `${modulus} GPa`, density: `${density} kg/m^3` };
  const area = data.info?.bar && `${plainNumber(data.info.bar.area_m2 * 1e4, 6)} cm^2`;
  const ring = bore && area && { diameter: undefined, area };
  return { ...tables, bar: given({ ...bar, length: wholeLength(tables), ...last, ...own, ...ring }), load };
}

/** @param {Record<string, any>} table */
const given = (table) => Object.fromEntries(Object.entries(table).filter(([, value]) => value !== undefined));

/** @param {Tables} tables */
function wholeLength(tables) {
  const parts = rowsOf(tables).map((row) => quantity(row?.length));
  const unit = parts[0]?.unit;
  const whole = parts.reduce((sum, part) => sum + (part?.value ?? 0), 0);
  if (parts.every((part) => part?.unit === unit)) return `${plainNumber(whole, 12)} ${unit}`.trim();
  return data.info?.bar ? `${plainNumber(data.info.bar.length_m * 1e3, 6)} mm` : undefined;
}

/** The table of the sections of a bar, with its buttons. @param {Tables} tables */
export const sectionsTable = (tables) => tableOf(tables.bar ? BAR : SYSTEM, tables);

/** That of the tool. @param {Tables} tables */
export const toolTable = (tables) => tableOf(TOOL, tables);

/** @param {Chain} chain @param {Tables} tables */
function tableOf(chain, tables) {
  const { form, columns, id } = chain;
  const { length } = chain.rows(tables);
  const rows = Array.from({ length }, (_, i) => row(chain, i, length));
  const heads = ["No.", ...columns.map(([, label]) => label), ""];
  const lists = form === "system" ? PLAIN.map(([name]) => `system.${name}`) : [`${form}.sections`];
  const add = () => {
    const now = chain.rows(data.tables);
    chain.set([...now, now.at(-1) ?? {}]);
    focusFirst(idOf(cellOf(form, now.length, columns[0][0])));
  };
  return h(
    "fieldset",
    { class: "wide", id },
    h("legend", {}, chain.legend),
    h("p", { class: "hint small muted", id: `${id}-hint` }, chain.hint),
    div("scroll", table(heads, rows, { class: "sections", "aria-describedby": `${id}-hint` })),
    lists.map(problemOf),
    div("row", button("Add a section", add, { id: `${id}-add` })),
  );
}

/** The key of a cell. @param {string} form @param {number} i @param {string} name */
const cellOf = (form, i, name) => (form === "system" ? `system.${name}[${i}]` : `${form}.sections[${i}].${name}`);

/** The cells of a row. @param {Chain} chain @param {number} i @param {number} count */
function row({ form, columns, id, rows, set, who, ends }, i, count) {
  const cell = (/** @type {[string, string]} */ [name, label]) => {
    const key = cellOf(form, i, name);
    const named = `${who} ${i + 1}: ${label.replace(/^(or|and) /, "").toLowerCase()}`;
    const told = { "aria-label": named, "aria-describedby": `${idOf(key)}-problem` };
    const control = name === "material" ? materials(key, told) : input(key, told);
    return [control, problemOf(key)];
  };
  const told = (/** @type {string} */ name, /** @type {string} */ words, /** @type {boolean} */ off) => ({
    id: `${id}-${name}-${i}`,
    "aria-label": words,
    title: words,
    ".disabled": off,
  });
  const swap = (/** @type {number} */ to) => () => {
    const next = [...rows(data.tables)];
    [next[i], next[to]] = [next[to], next[i]];
    set(next);
    const [ahead, other] = to < i ? ["up", "down"] : ["down", "up"];
    focusFirst(`${id}-${ahead}-${to}`, `${id}-${other}-${to}`);
  };
  const remove = () => {
    set(rows(data.tables).filter((_, j) => j !== i));
    focusFirst(`${id}-remove-${Math.min(i, count - 2)}`, `${id}-add`);
  };
  const own = `${who.toLowerCase()} ${i + 1}`;
  const moves = div(
    "row",
    button("↑", swap(i - 1), told("up", `Move ${own} toward the ${ends[0]}`, i === 0)),
    button("↓", swap(i + 1), told("down", `Move ${own} toward the ${ends[1]}`, i === count - 1)),
    button("×", remove, told("remove", `Remove ${own}`, count === 1)),
  );
  return [h("th", { scope: "row" }, String(i + 1)), ...columns.map(cell), h("td", { class: "moves" }, moves)];
}

/** The choice of a material. @param {string} key @param {Record<string, any>} told */
function materials(key, told) {
  const words = Object.keys(data.about.materials).map((name) => [name, name.replaceAll("_", " ")]);
  const options = [["", key.startsWith("tool.") ? "steel" : "as the bar"], ...words];
  return menu(options, "", (text) => setKey(key, typed(text)), { id: idOf(key), "data-key": key, ...told });
}

/** The first of these that can be used has the focus: nobody at the keyboard loses their place.
 * @param {string[]} ids */
function focusFirst(...ids) {
  flush(); // the rows are made anew
  const found = ids.map((id) => /** @type {HTMLButtonElement | null} */ (document.getElementById(id)));
  found.find((control) => control && !control.disabled)?.focus();
}
