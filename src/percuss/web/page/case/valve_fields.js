// The fields of a load that the piston switches, and such a load in the place of a clocked one, and back.

import { joined, meanAndAmplitude, otherLoad, unitOf } from "./fields.js";
import { field, problemOf } from "./form_fields.js";
import { h } from "../core/dom.js";
import { plainNumber } from "../core/format.js";
import { steps } from "../core/moves.js";
import { data } from "../core/state.js";

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

/** The keys that a load of this kind has fields for. */
export function valveKeys(load) {
  const found = load.pressure === undefined ? [] : ["load.pressure"];
  for (const [name, given] of Object.entries(load.states ?? {})) {
    const areas = given !== null && typeof given === "object";
    const sides = load.chambers ? Object.keys(load.chambers) : ["front", "rear"];
    for (const side of areas ? sides : [""]) found.push(`load.states.${name}${side && `.${side}`}`);
  }
  (Array.isArray(load.ports) ? load.ports : []).forEach((port, i) => {
    const edge = port?.speed === undefined ? "behind" : "speed";
    const own = port?.on ? ["on", "to", "delay"] : [edge, ...OF_PORTS, ...(port?.reads === undefined ? [] : ["reads"])];
    for (const name of own) found.push(`load.ports[${i}].${name}`);
  });
  const oil = Object.keys(load.chambers ?? {}).map((name) => `load.chambers.${name}.area`);
  (Array.isArray(load.orifices) ? load.orifices : []).forEach((_, i) => oil.push(`load.orifices[${i}].drop`, `load.orifices[${i}].at`));
  if (load.supply?.flow !== undefined) oil.push("load.supply.flow");
  const gas = load.chamber?.volume === undefined ? "stiffness" : "volume";
  return [...found, ...oil, "load.chamber.force", `load.chamber.${gas}`, ...ALWAYS];
}

export function valveFields(load) {
  const rows = valveKeys(load).map((key) => field([key, ...words(key)]));
  const tables = ["load.states", "load.ports", "load.chamber"].map(problemOf);
  const hint = "The piston switches the states by the ports that it passes; no clock. Answered in the panel Machine.";
  return [h("p", { class: "hint small muted" }, hint), tables, h("div", { class: "fields" }, rows)];
}

/** [label, hint] of a key. */
function words(key) {
  const [, first, second, third] = steps(key);
  const own = HINTS[third ?? second ?? first];
  if (first === "ports") return [`Port ${Number(second) + 1}: ${own[0]}`, own[1]];
  if (first === "chambers") return [`Chamber ${second}: area`, "on which its pressure acts"];
  if (first === "orifices") {
    const { chamber, to } = data.tables.load.orifices[Number(second)];
    return [`Passage ${chamber} – ${to}: ${third}`, third === "at" ? "the flow that takes this drop" : "of the pressure, at a flow"];
  }
  if (first === "supply") return ["Flow of the pump", "the pressure is what results"];
  if (first !== "states") return own;
  if (third && data.tables.load.chambers) return [`State ${second}: chamber ${third}`, "supply or tank"];
  return third ? [`State ${second}: ${own[0]}`, own[1]] : [`State ${second}`, "its force, positive toward the wall"];
}

/** A valve in the place of a clocked load: it pulls and pushes as hard, and its ports are a tenth of the bar apart. */
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

/** A clocked load in the place of a valve: between its least and its greatest force, at the rate at which it runs. */
export function clockedLoad(kind, si, answer) {
  const machine = answer && (answer.units === "SI") === si ? answer : null; // it may be that of a moment ago
  const forces = machine?.forces ?? (si ? [-1000, 1000] : [-1, 1]);
  const [most, least] = [Math.max(...forces), Math.min(...forces)];
  const unit = si ? "N" : "";
  const rate = machine?.answer.si?.blow_rate_Hz ?? 10;
  const load = { kind: "harmonic", mean: joined((most + least) / 2, unit), amplitude: joined((most - least) / 2, unit) };
  return otherLoad({ ...load, ...(si && { frequency: `${plainNumber(rate)} Hz` }) }, kind, si, 0);
}
