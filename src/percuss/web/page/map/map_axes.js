// The axes of the map and what its colour shows, and the row in which they are chosen.

import { h, menu, put } from "../core/dom.js";
import { inUnit, plainNumber, withUnit } from "../core/format.js";
import { rangeOf, rangeText } from "../core/moves.js";
import { rangeEnds } from "../core/range_ends.js";
import { effect, whenever } from "../core/signals.js";
import { data, isHeld, show, switchesItself, view } from "../core/state.js";

/** An axis, between its ends in its unit.
 * @typedef {{ name: string, unit: string, from: number, to: number, whole: boolean }} Axis */
/** @typedef {"x" | "y"} Which */
/** What the colour may show: its name, what the server is asked for it, and how.
 * @typedef {{ label: string, quantities: string[], body?: Record<string, any> }} Shown */

/** @type {Record<string, Shown>} */
const SHOWN = {
  verdict: { label: "verdict", quantities: ["orbits", "reduced_stable"] },
  reduced_margin: { label: "stability margin", quantities: ["reduced_margin"] },
  stable: { label: "verdict with elastic modes", quantities: ["orbits", "stable"] },
  margin: { label: "margin with elastic modes", quantities: ["margin"] },
  margin_rhythm: { label: "rhythm margin", quantities: ["margin_rhythm"] },
  margin_ringing: { label: "ringing margin", quantities: ["margin_ringing"] },
  blow_energy: { label: "blow energy", quantities: ["blow_energy"] },
  impact_velocity: { label: "striking speed", quantities: ["impact_velocity"] },
  power: { label: "percussive power", quantities: ["power"] },
  label: { label: "motion found by simulation", quantities: ["label"], body: { modes: 0, impacts: 400 } },
};

/** Those that need no rigid motion; a structure has no modes but elastic ones. */
const OF_STRUCTURES = Object.fromEntries(
  ["stable", "margin", "blow_energy", "impact_velocity", "label"].map((name) => {
    const { label, ...one } = SHOWN[name];
    return [name, { ...one, label: label.replace(" with elastic modes", "") }];
  }),
);

/** @param {string} label @param {string} quantity @returns {Shown} */
const rigid = (label, quantity) => ({ label, quantities: [quantity], body: { modes: 0 } });

/** The same of machines that switch themselves: of rigid pistons, which are there at once. */
const OF_MACHINES = {
  stall: rigid("runs, or why not", "stall"),
  blow_energy: rigid("blow energy", "blow_energy"),
  rate: rigid("blow rate", "rate"),
  speed: rigid("striking speed", "speed"),
  stroke: rigid("stroke", "stroke"),
  power: rigid("percussive power", "power"),
  flow: rigid("oil flow", "flow"),
  efficiency: rigid("efficiency", "efficiency"),
  duty: rigid("share of the power stroke", "duty"),
  multiplier: rigid("multiplier", "multiplier"),
};

/** The same of every hammer with a tool on rock: what one blow of its own cycle does. */
function ofTool() {
  const { tool, rock, drilling } = data.tables;
  if (!tool || !rock) return {};
  const body = switchesItself() ? { modes: 0 } : {};
  /** @type {Record<string, string>} */
  const found = { rock_share: "share into the rock", steel_tension: "tension in the tool" };
  if (drilling) found.rate_of_penetration = "rate of penetration";
  if (tool.joints?.length) found.joint_openings = "openings of joints";
  return Object.fromEntries(Object.entries(found).map(([name, label]) => [name, { label, quantities: [name], body }]));
}

/** What there is to show; the flow in SI is known of a machine whose supply has a pressure.
 * @returns {Record<string, Shown>} */
function kinds() {
  if (isHeld()) return OF_STRUCTURES;
  if (!switchesItself()) return { ...SHOWN, ...ofTool() };
  const { flow, ...others } = OF_MACHINES;
  return data.tables.bar && !data.tables.load.pressure ? { ...others, ...ofTool() } : { ...others, flow, ...ofTool() };
}

/** The name of what the colour shows: the first, where the view asks for one that there is not. */
const shownName = () => (view.q in kinds() ? view.q : Object.keys(kinds())[0]);

/** What the colour shows. */
export const shown = () => kinds()[shownName()];

/** What the server knows of a parameter of the case. @param {string} name */
export const parameter = (name) => data.info?.parameters.find((/** @type {any} */ one) => one.name === name);

/** @param {string} name */
const title = (name) => parameter(name)?.label ?? name;

/** A value of an axis in words: "bar length = 300 mm". @param {Axis} axis @param {number} value */
export const told = ({ name, unit }, value, digits = 4) => `${title(name)} = ${withUnit(value, unit, digits)}`;

/** An axis of the map. @param {Which} which @returns {Axis} */
export function axis(which) {
  const known = parameter(view[which]) ?? usual(which);
  const [from, to] = rangeOf(view[`${which}r`], known.unit) ?? [known.low, known.high];
  return { name: known.name, unit: known.unit, from, to, whole: known.name === "m" };
}

/** What the map of a kind of hammer is over, the best that the case has.
 * @type {Record<string, Record<Which, string[]>>} */
const USUAL = {
  clock: { x: ["restitution"], y: ["load_factor"] },
  held: { x: ["load.frequency", "stiffness", "restitution"], y: ["body.gap", "gap", "load_factor"] },
  valve: { x: ["load.ports[0].behind", "restitution"], y: ["load.pressure", "load.supply.flow", "load.scale"] },
};

/** The axis where the view asks for none, or for one that the case has not. @param {Which} which */
function usual(which) {
  const { parameters } = data.info;
  const names = USUAL[isHeld() ? "held" : switchesItself() ? "valve" : "clock"][which];
  const found = names.map(parameter).find(Boolean);
  return found ?? parameters[which === "x" ? 0 : Math.min(1, parameters.length - 1)];
}

/** @param {{ name: string, unit?: string }} axis */
export const labelOf = ({ name, unit = "" }) => inUnit(title(name), unit);

/** Whether what is known of the case is known of this kind of case. */
export const ready = () => Boolean(data.info) && Boolean(data.info.system) !== switchesItself();

/** The choices about the map: above it what stands up and what the colour shows, below it what stands across, each axis
 * between its ends; made anew only when there is another choice: a range that is typed leaves its fields alone.
 * @param {HTMLElement} above @param {HTMLElement} below */
export function startChoices(above, below) {
  const names = () =>
    data.info.parameters.map((/** @type {any} */ { name, label, unit }) => [name, inUnit(label, unit)]);
  const chosen = () => ({ x: axis("x").name, y: axis("y").name, q: shownName() });
  /** @param {Which | "q"} which @param {string} title @param {import("../core/dom.js").Options} options */
  const pick = (which, title, options) => {
    const onchange = (/** @type {string} */ name) => show(which === "q" ? { q: name } : chosenAxis(which, name));
    return menu(options, chosen()[which], onchange, { id: `map-${which}`, "aria-label": title, title });
  };
  const problem = h("p", { class: "problem", role: "alert", id: "map-range-problem" });
  /** The fields of the ends of both axes. @type {Record<string, ReturnType<typeof rangeEnds>>} */
  const ends = {};
  const endsOf = (/** @type {Which} */ which, /** @type {string} */ about) =>
    rangeEnds({
      id: `map-${which}`,
      about,
      range: () => axis(which),
      keeps: "the map",
      problem,
      taken: (from, to, unit) => show({ [`${which}r`]: rangeText(from, to, unit) }),
    });
  const build = () => {
    const [x, y] = [(ends.x = endsOf("x", "across")), (ends.y = endsOf("y", "up"))];
    const range = h("span", { class: "range" }, y.from, "…", y.to);
    const colours = Object.entries(kinds()).map(([name, { label }]) => [name, label]);
    put(problem, "");
    put(above, pick("y", "Up", names()), range, pick("q", "Colour", colours));
    put(below, x.from, pick("x", "Across", names()), x.to, problem);
  };
  whenever(() => ready() && [names(), chosen(), Object.keys(kinds())], build);
  effect(() => ready() && Object.values(ends).forEach(({ fill }) => fill()));
}

/** Another axis; its range is kept in the view, for the server's range moves with the value that the parameter has.
 * @param {Which} which @param {string} name */
function chosenAxis(which, name) {
  const { low, high, unit } = parameter(name);
  return {
    [which]: name,
    [`${which}r`]: name.includes(".") ? rangeText(plainNumber(low), plainNumber(high), unit) : "",
  };
}

/** The ranges of both axes as the view keeps them. */
export function keptRanges() {
  const kept = (/** @type {Axis} */ { from, to, unit }) => rangeText(from, to, unit);
  return { xr: kept(axis("x")), yr: kept(axis("y")) };
}
