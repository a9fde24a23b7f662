// Sliders of a machine that switches itself: keys of its case, in the place of those of a clocked load.

import { afterFrame, h, put } from "../core/dom.js";
import { plainNumber, quantity, withUnit } from "../core/format.js";
import { steps, valueAt, withKey } from "../core/moves.js";
import { data, drag, switchesItself } from "../core/state.js";

const FORCES = "load.states"; // all of them, where there is no pressure
const parts = { rows: [], base: null, mine: "", factor: 1 };

/** Their keys, with the units of their ranges. */
export const machineSliderNames = () => keysOf(data.tables).map(([key, , range]) => `${key} ${unitOf(key, range)}`);

const unitOf = (key, range) => (Array.isArray(range) ? quantity(valueAt(data.tables, key)).unit : range.unit);

/** The sliders of the case, with ranges about its values. */
export function machineSliders() {
  parts.base = null;
  parts.rows = keysOf(data.tables).map(slider);
  return parts.rows.map((row) => row.box);
}

/** Their values, when the case has other ones. */
export const followMachineSliders = afterFrame(() => switchesItself() && parts.rows.forEach((row) => row.follow()));

/** [key, words, range] of what there is a slider for; a range is of shares of the value, or {low, high, unit}. */
function keysOf(tables) {
  const { load, contact, system } = tables;
  const found = [];
  const number = (key) => quantity(valueAt(tables, key));
  const add = (key, words, range = [0.25, 2]) => number(key)?.value > 0 && found.push([key, words, range]);
  if (number("load.supply.flow")) add("load.supply.flow", "Flow of the pump");
  else if (number("load.pressure")) add("load.pressure", "Pressure");
  else found.push([FORCES, "Forces of the valve", { low: 0.25, high: 2, unit: "×" }]);
  const ports = Array.isArray(load.ports) ? load.ports.slice(0, 4) : [];
  ports.forEach((port, i) => {
    const name = port?.on === "impact" ? `Blow → ${port.to}` : `Port ${i + 1} → ${port?.to}`;
    add(`load.ports[${i}].behind`, `${name}: place`);
    add(`load.ports[${i}].speed`, `${name}: speed`);
    const delay = number(`load.ports[${i}].delay`);
    const unit = delay?.unit || (tables.bar ? "ms" : "");
    const high = delay?.value > 0 ? 4 * delay.value : tables.bar ? (unit === "s" ? 0.01 : 10) : 1;
    found.push([`load.ports[${i}].delay`, `${name}: delay`, { low: 0, high, unit }]);
  });
  for (const name of Object.keys(load.chambers ?? {})) add(`load.chambers.${name}.area`, `Chamber ${name}: area`, [0.5, 1.5]);
  (Array.isArray(load.orifices) ? load.orifices.slice(0, 4) : []).forEach((passage, i) => {
    add(`load.orifices[${i}].drop`, `Passage ${passage?.chamber} – ${passage?.to}: drop`, [0, 3]);
  });
  const table = contact ? "contact" : "system";
  if (number(`${table}.restitution`) && !(contact ?? system).law) found.push([`${table}.restitution`, "Restitution R", { low: 0, high: 0.95, unit: "" }]);
  add("load.chamber.force", "Gas: force at the tool");
  add("load.chamber.stiffness", "Gas: stiffness");
  add("load.chamber.volume", "Gas: volume", [0.5, 2]);
  return found;
}

function slider([key, words, range]) {
  const id = `slide-${steps(key).join("-")}`;
  const begun = quantity(valueAt(data.tables, key));
  const [low, high] = Array.isArray(range) ? range.map((part) => part * begun.value) : [range.low, range.high];
  const unit = unitOf(key, range);
  const output = h("output", { for: id });
  const told = (value) => {
    const text = withUnit(value, unit);
    put(output, text);
    input.setAttribute("aria-valuetext", text);
  };
  const input = h("input", {
    type: "range",
    id,
    min: low,
    max: high,
    step: (high - low) / 1000,
    oninput: (event) => {
      const value = plainNumber(Math.min(Math.max(Number(event.target.value), Number(input.min)), Number(input.max)));
      told(value);
      drag(key === FORCES ? pushed(value) : withKey(data.tables, key, unit ? `${value} ${unit}` : value));
    },
  });
  const follow = () => {
    const found = key === FORCES ? { value: factor(), unit } : (quantity(valueAt(data.tables, key)) ?? { value: 0, unit });
    if (found.unit !== unit) return; // there are other sliders at once
    if (found.value > Number(input.max)) input.max = found.value;
    if (found.value < Number(input.min)) input.min = found.value;
    if (document.activeElement !== input || Math.abs(Number(input.value) - found.value) > Number(input.step)) input.value = found.value;
    told(found.value);
  };
  follow();
  const head = h("div", { class: "head" }, h("label", { for: id }, words), output);
  return { box: h("div", { class: "slider" }, head, input), follow };
}

/** How many times the forces of the valve are those that were last given by other means than their slider. */
function factor() {
  const { states } = data.tables.load;
  if (parts.base === null || JSON.stringify(states) !== parts.mine) Object.assign(parts, { base: states, factor: 1, mine: JSON.stringify(states) });
  return parts.factor;
}

/** The case with the forces of the valve so many times as great. */
function pushed(times) {
  factor();
  const grown = Object.entries(parts.base ?? {}).map(([name, given]) => {
    const found = quantity(given);
    if (!found) return [name, given];
    const value = plainNumber(found.value * times, 6);
    return [name, found.unit ? `${value} ${found.unit}` : value];
  });
  const states = Object.fromEntries(grown);
  Object.assign(parts, { factor: times, mine: JSON.stringify(states) });
  return withKey(data.tables, FORCES, states);
}
