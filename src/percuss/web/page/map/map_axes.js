// The axes of the map and what its colour shows, and the row in which they are chosen.

import { $, $$, h, put, select } from "../core/dom.js";
import { inUnit, plainNumber, withUnit } from "../core/format.js";
import { isRange, rangeOf, rangeText } from "../core/moves.js";
import { data, isHeld, show, switchesItself, view } from "../core/state.js";

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
const ofStructure = ({ label, ...one }) => ({ ...one, label: label.replace(" with elastic modes", "") });
const NEED_NO_RIGID = ["stable", "margin", "blow_energy", "impact_velocity", "label"];
const OF_STRUCTURES = Object.fromEntries(NEED_NO_RIGID.map((name) => [name, ofStructure(SHOWN[name])]));

const rigid = (label, ...quantities) => ({ label, quantities, body: { modes: 0 } });

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
  const found = { rock_share: "share into the rock", steel_tension: "tension in the tool" };
  if (drilling) found.rate_of_penetration = "rate of penetration";
  if (tool.joints?.length) found.joint_openings = "openings of joints";
  return Object.fromEntries(Object.entries(found).map(([name, label]) => [name, { label, quantities: [name], body }]));
}

/** What there is to show; the flow in SI is known of a machine whose supply has a pressure. */
function kinds() {
  if (isHeld()) return OF_STRUCTURES;
  if (!switchesItself()) return { ...SHOWN, ...ofTool() };
  const { flow, ...others } = OF_MACHINES;
  return data.tables.bar && !data.tables.load.pressure ? { ...others, ...ofTool() } : { ...others, flow, ...ofTool() };
}

/** What the colour shows. */
export const shown = () => kinds()[view.q] ?? Object.values(kinds())[0];

/** Its name, where the view asks for one that there is not. */
const shownName = () => (view.q in kinds() ? view.q : Object.keys(kinds())[0]);

/** What the server knows of a parameter of the case. */
export const parameter = (name) => data.info?.parameters.find((p) => p.name === name);

const title = (name) => parameter(name)?.label ?? name;

/** A value of an axis in words: "bar length = 300 mm". */
export const told = ({ name, unit }, value, digits = 4) => `${title(name)} = ${withUnit(value, unit, digits)}`;

/** The axis "x" or "y": {name, unit, from, to, whole}. */
export function axis(which) {
  const known = parameter(view[which]) ?? usual(which);
  const [from, to] = rangeOf(view[`${which}r`], known.unit) ?? [known.low, known.high];
  return { name: known.name, unit: known.unit, from, to, whole: known.name === "m" };
}

/** The axis where the view asks for one that the case has not: two that differ, the first port and the pressure. */
function usual(which) {
  const wish = { x: /^(restitution|load\.ports\[0\]\.behind)$/, y: /^(load_factor|load\.(pressure|scale))$/ }[which];
  const { parameters } = data.info;
  return parameters.find(({ name }) => wish.test(name)) ?? parameters[which === "x" ? 0 : Math.min(1, parameters.length - 1)];
}

export const labelOf = ({ name, unit }) => inUnit(title(name), unit);

/** The row of choices, made anew only when there is another choice: a range that is typed leaves its fields alone. */
export function choices(row) {
  if (!data.info) return;
  const names = data.info.parameters.map((p) => [p.name, p.label]);
  const chosen = { x: axis("x").name, y: axis("y").name, q: shownName() };
  const key = JSON.stringify([names, chosen, Object.keys(kinds())]);
  if (row.dataset.key === key) return fillEdges(row);
  row.dataset.key = key;
  const group = (which, title) =>
    h(
      "div",
      { class: "axis" },
      select(title, names, chosen[which], (name) => show(chosenAxis(which, name)), { id: `map-${which}` }),
      edge(which, "from"),
      edge(which, "to"),
    );
  const colours = Object.entries(kinds()).map(([name, { label }]) => [name, label]);
  put(
    row,
    group("x", "Across"),
    group("y", "Up"),
    select("Colour", colours, chosen.q, (q) => show({ q }), { id: "map-q" }),
    h("p", { class: "problem", role: "alert", id: "map-range-problem" }),
  );
}

/** Another axis; its range is kept in the view, for the server's range moves with the value that the parameter has. */
function chosenAxis(which, name) {
  const { low, high, unit } = parameter(name);
  return { [which]: name, [`${which}r`]: name.includes(".") ? rangeText(plainNumber(low), plainNumber(high), unit) : "" };
}

/** The ranges of both axes as the view keeps them. */
export const keptRanges = () => Object.fromEntries(["x", "y"].map((which) => [`${which}r`, kept(axis(which))]));

const kept = ({ from, to, unit }) => rangeText(from, to, unit);

/** One end of an axis. */
function edge(which, end) {
  const commit = (event) => {
    const ends = ["from", "to"].map((name) => $(`#map-${which}-${name}`));
    const [from, to] = ends.map((input) => (input.value === "" ? Number.NaN : Number(input.value)));
    const taken = isRange(from, to);
    for (const input of ends) input.setAttribute("aria-invalid", String(!taken && input === event.target));
    const words = "A range must go from a number to a greater one; the map keeps the previous range.";
    put($("#map-range-problem"), taken ? "" : words);
    if (taken) show({ [`${which}r`]: rangeText(from, to, axis(which).unit) });
  };
  const value = String(axis(which)[end]);
  const about = { "data-edge": `${which} ${end}`, "aria-describedby": "map-range-problem" };
  const input = { type: "number", step: "any", id: `map-${which}-${end}`, ".value": value, onchange: commit, ...about };
  const name = `${end}, ${which === "x" ? "across" : "up"}`;
  return h("label", { class: "pick" }, h("span", {}, end), h("input", { ...input, "aria-label": name }));
}

/** The ends as they are now; the one that is being typed into, and one that was not taken, are left alone. */
function fillEdges(row) {
  for (const input of $$("input[data-edge]", row)) {
    if (input === document.activeElement || input.getAttribute("aria-invalid") === "true") continue;
    const [which, end] = input.dataset.edge.split(" ");
    const value = String(axis(which)[end]);
    if (input.value !== value) input.value = value;
  }
}
