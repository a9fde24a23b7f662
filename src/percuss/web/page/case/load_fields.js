// The fields of a load by its Fourier coefficients, one row a harmonic, and of one that the piston switches; such a load
// in the place of a clocked one, and back.

import { joined, meanAndAmplitude, otherLoad, typed, unitOf } from "./fields.js";
import { field, input, problemOf } from "./form_fields.js";
import { button, div, h } from "../core/dom.js";
import { plainNumber } from "../core/format.js";
import { steps } from "../core/moves.js";
import { data, setKey } from "../core/state.js";

/** @typedef {import("./fields.js").Load} Load */

/** A field with all coefficients; what a link has in their place, which may be anything, is told of by the server.
 * @param {any} found */
export function coefficients(found) {
  const listed = (/** @type {any} */ one) => (Array.isArray(one) ? one : []);
  const now = () => listed(data.tables.load.coefficients);
  const pairs = listed(found);
  const set = (/** @type {any[]} */ next) => setKey("load.coefficients", next);
  const box = (/** @type {number} */ k, /** @type {number} */ part) => {
    const label = `coefficient ${k}, ${part ? "imaginary" : "real"} part`;
    const key = `load.coefficients[${k}][${part}]`;
    return input(key, { "aria-label": label, ".disabled": k === 0 && part === 1 }, (text) => typed(text) ?? 0);
  };
  const name = (/** @type {number} */ k) => [...String(k)].map((c) => "₀₁₂₃₄₅₆₇₈₉"[Number(c)]).join("");
  const head = (/** @type {string} */ words) => h("span", { class: "small muted" }, words);
  return div(
    "field",
    div(
      "coefficients",
      [h("span"), head("real"), head("imaginary")],
      pairs.map((_, k) => [h("span", {}, k ? `p${name(k)}` : "p₀, mean"), box(k, 0), box(k, 1)]),
    ),
    div(
      "row",
      button("Add a harmonic", () => set([...now(), [0, 0]])),
      button("Remove the last", () => set(now().slice(0, -1)), { ".disabled": pairs.length < 3 }),
    ),
    problemOf("load.coefficients"),
  );
}

/** @type {Record<string, [string, string]>} */
const HINTS = {
  pressure: ["Pressure", "of the supply, as 160 bar; without it states are forces"],
  start_state: ["State at the start", "the first one when empty"],
  room: ["Room", "how far behind the wall the piston can go; without limit when empty"],
  force: ["Gas: force", "toward the wall, with the piston at the tool"],
  stiffness: ["Gas: stiffness", "growth of that force on the way back"],
  front: ["area in front", "the pressure pushes the piston back"],
  rear: ["area behind", "the pressure pushes the piston toward the wall"],
  behind: ["place", "of its edge, behind the wall"],
  speed: ["speed", "at which it is passed, between blows"],
  side: ["side", "back or front: where it is uncovered"],
  to: ["demands", "a state by its name"],
  delay: ["delay", "from the demand to the change; 0 when empty"],
  volume: ["volume of the gas", "behind the piston, with the bar at the wall"],
  reads: ["reads", "centre, or a place on the bar from 0 to 1"],
  on: ["on", "impact: each blow demands"],
};
const ALWAYS = ["load.start_state", "load.room"];
const OF_PORTS = ["side", "to", "delay"];

/** The keys that a load of this kind has fields for. @param {Load} load @returns {string[]} */
export function valveKeys(load) {
  const found = load.pressure === undefined ? [] : ["load.pressure"];
  for (const [name, given] of Object.entries(load.states ?? {})) {
    const areas = given !== null && typeof given === "object";
    const sides = load.chambers ? Object.keys(load.chambers) : ["front", "rear"];
    for (const side of areas ? sides : [""]) found.push(`load.states.${name}${side && `.${side}`}`);
  }
  (Array.isArray(load.ports) ? load.ports : []).forEach((/** @type {any} */ port, /** @type {number} */ i) => {
    const edge = port?.speed === undefined ? "behind" : "speed";
    const own = port?.on ? ["on", "to", "delay"] : [edge, ...OF_PORTS, ...(port?.reads === undefined ? [] : ["reads"])];
    for (const name of own) found.push(`load.ports[${i}].${name}`);
  });
  const oil = Object.keys(load.chambers ?? {}).map((name) => `load.chambers.${name}.area`);
  (Array.isArray(load.orifices) ? load.orifices : []).forEach((/** @type {any} */ _, /** @type {number} */ i) =>
    oil.push(`load.orifices[${i}].drop`, `load.orifices[${i}].at`),
  );
  if (load.supply?.flow !== undefined) oil.push("load.supply.flow");
  const gas = load.chamber?.volume === undefined ? "stiffness" : "volume";
  return [...found, ...oil, "load.chamber.force", `load.chamber.${gas}`, ...ALWAYS];
}

/** @param {Load} load */
export function valveFields(load) {
  const rows = valveKeys(load).map((key) => field([key, ...words(key)]));
  const tables = ["load.states", "load.ports", "load.chamber"].map(problemOf);
  const hint = "The piston switches the states by the ports that it passes; no clock. Answered in the panel Machine.";
  return [h("p", { class: "hint small muted" }, hint), tables, div("fields", rows)];
}

/** The label and the hint of a key. @param {string} key @returns {[string, string]} */
function words(key) {
  const [, first, second, third] = steps(key);
  const own = HINTS[third ?? second ?? first];
  if (first === "ports") return [`Port ${Number(second) + 1}: ${own[0]}`, own[1]];
  if (first === "chambers") return [`Chamber ${second}: area`, "on which its pressure acts"];
  if (first === "orifices") {
    const { chamber, to } = data.tables.load.orifices[Number(second)];
    return [
      `Passage ${chamber} – ${to}: ${third}`,
      third === "at" ? "the flow that takes this drop" : "of the pressure, at a flow",
    ];
  }
  if (first === "supply") return ["Flow of the pump", "the pressure is what results"];
  if (first !== "states") return own;
  if (third && data.tables.load.chambers) return [`State ${second}: chamber ${third}`, "supply or tank"];
  return third ? [`State ${second}: ${own[0]}`, own[1]] : [`State ${second}`, "its force, positive toward the wall"];
}

/** A valve in the place of a clocked load: it pulls and pushes as hard, and its ports are a tenth of the bar apart.
 * @param {Load} load @param {boolean} si @param {Record<string, any> | null} info @returns {Load} */
export function valveLoad(load, si, info) {
  const [mean, amplitude] = meanAndAmplitude(load, info?.system?.load_factor ?? 0.4);
  const unit = si ? unitOf(load) || "N" : "";
  const place = si ? joined(100 * (info?.bar?.length_m ?? 0.5), "mm") : 0.1;
  const pull = Math.min(mean - amplitude, -0.1 * Math.abs(mean + amplitude)); // else it would lie on the wall for ever
  return {
    kind: "valve",
    states: { return: joined(pull, unit), power: joined(mean + amplitude, unit) },
    ports: [
      { behind: place, side: "back", to: "power" },
      { on: "impact", to: "return" },
    ],
  };
}

/** A clocked load in the place of a valve: between its least and its greatest force, at the rate at which it runs.
 * @param {string} kind @param {boolean} si @param {Record<string, any> | null} answer */
export function clockedLoad(kind, si, answer) {
  const machine = answer && (answer.units === "SI") === si ? answer : null; // it may be that of a moment ago
  const forces = machine?.forces ?? (si ? [-1000, 1000] : [-1, 1]);
  const [most, least] = [Math.max(...forces), Math.min(...forces)];
  const unit = si ? "N" : "";
  const rate = machine?.answer.si?.blow_rate_Hz ?? 10;
  const load = {
    kind: "harmonic",
    mean: joined((most + least) / 2, unit),
    amplitude: joined((most - least) / 2, unit),
  };
  return otherLoad({ ...load, ...(si && { frequency: `${plainNumber(rate)} Hz` }) }, kind, si, 0);
}
