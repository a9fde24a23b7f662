// Sliders of a machine that switches itself: keys of its case, in the place of those of a clocked load.

import { plainNumber, quantity } from "../core/format.js";
import { valueAt, withKey } from "../core/moves.js";
import { data, drag } from "../core/state.js";

/** @typedef {import("./sliders.js").Sliding} Sliding */

const FORCES = "load.states"; // all of them, where there is no pressure

/** What there are sliders for, with ranges about the values of the case. */
export function machineSliders() {
  const { load, contact, system, bar } = data.tables;
  /** @type {Sliding[]} */
  const found = [];
  const number = (/** @type {string} */ name) => quantity(valueAt(data.tables, name));
  const add = (/** @type {Pick<Sliding, "name" | "label" | "low" | "high" | "unit"> & Partial<Sliding>} */ one) =>
    found.push({
      least: 0,
      now: () => number(one.name)?.value ?? 0,
      put: (value) => drag(withKey(data.tables, one.name, one.unit ? `${value} ${one.unit}` : value)),
      ...one,
    });
  const share = (/** @type {string} */ name, /** @type {string} */ label, from = 0.25, to = 2) => {
    const { value, unit } = number(name) ?? { value: 0, unit: "" };
    if (value > 0) add({ name, label, low: from * value, high: to * value, unit });
  };
  const few = (/** @type {any} */ list) => (Array.isArray(list) ? list.slice(0, 4) : []);
  if (number("load.supply.flow")) share("load.supply.flow", "Flow of the pump");
  else if (number("load.pressure")) share("load.pressure", "Pressure");
  else
    add({ name: FORCES, label: "Forces of the valve", low: 0.25, high: 2, unit: "×", base: 1, now: factor, put: push });
  few(load.ports).forEach((port, i) => {
    const name = port?.on === "impact" ? `Blow → ${port.to}` : `Port ${i + 1} → ${port?.to}`;
    const key = `load.ports[${i}]`;
    share(`${key}.behind`, `${name}: place`);
    share(`${key}.speed`, `${name}: speed`);
    const delay = number(`${key}.delay`);
    const unit = delay?.unit || (bar ? "ms" : "");
    const high = delay && delay.value > 0 ? 4 * delay.value : bar ? (unit === "s" ? 0.01 : 10) : 1;
    add({ name: `${key}.delay`, label: `${name}: delay`, low: 0, high, unit });
  });
  for (const name of Object.keys(load.chambers ?? {}))
    share(`load.chambers.${name}.area`, `Chamber ${name}: area`, 0.5, 1.5);
  few(load.orifices).forEach((passage, i) =>
    share(`load.orifices[${i}].drop`, `Passage ${passage?.chamber} – ${passage?.to}: drop`, 0, 3),
  );
  const restitution = `${contact ? "contact" : "system"}.restitution`;
  if (number(restitution) && !(contact ?? system).law)
    add({ name: restitution, label: "Restitution R", low: 0, high: 0.95, unit: "" });
  share("load.chamber.force", "Gas: force at the tool");
  share("load.chamber.stiffness", "Gas: stiffness");
  share("load.chamber.volume", "Gas: volume", 0.5, 2);
  return found;
}

/** The forces of the valve as they were last given by other means than their slider, and what that has made of them. */
const forces = { base: /** @type {Record<string, any>} */ ({}), mine: "", factor: 1 };

/** How many times the forces are what they were. */
function factor() {
  const base = valueAt(data.tables, FORCES) ?? {};
  if (JSON.stringify(base) !== forces.mine) Object.assign(forces, { base, factor: 1, mine: JSON.stringify(base) });
  return forces.factor;
}

/** The case with forces so many times as great. @param {number} times */
function push(times) {
  factor();
  const grown = Object.entries(forces.base).map(([name, given]) => {
    const found = quantity(given);
    if (!found) return [name, given];
    const value = plainNumber(found.value * times, 6);
    return [name, found.unit ? `${value} ${found.unit}` : value];
  });
  const states = Object.fromEntries(grown);
  Object.assign(forces, { factor: times, mine: JSON.stringify(states) });
  drag(withKey(data.tables, FORCES, states));
}
