// The force between the faces and on the rock over time, and where the energy is.

import { div, h, put } from "../core/dom.js";
import { inUnit, number, percent, scaleOf, si } from "../core/format.js";
import { Chart, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";

/** @typedef {import("./blow_stage.js").Blow} Blow */
/** @typedef {import("../motion/player.js").Unit} Unit */
/** Factors and units in which a blow is told. @typedef {{ time: Unit, force: Unit }} Units */

const ENERGIES = {
  energy_rigid: "with the striker as a whole",
  energy_vibration: "ringing in the striker",
  energy_rod: "in the tool",
  energy_rock_dissipated: "in the rock, for good",
  energy_rock_stored: "in the rock, springs back",
};

/** @type {Record<string, any>} */
const parts = {};
/** A row for each place that the energy can be in. @type {{ name: string, fill: HTMLElement, text: HTMLElement }[]} */
let bars = [];

export function blowCharts() {
  parts.force = new Chart("Force over time");
  parts.bars = h("div", { class: "shares energies", id: "blow-energies" });
  parts.shares = h("p", { class: "small", id: "blow-shares" });
  const energies = div("card", h("h2", {}, "Where the energy is"), parts.bars, parts.shares);
  return div("grid", div("card", parts.force.figure), energies);
}

/** @param {Blow} blow @returns {Units} */
export function blowUnits({ units, end, arrays }) {
  if (units !== "SI") return { time: { k: 1, name: "rad" }, force: { k: 1, name: "" } };
  const time = scaleOf(end < 2e-3 ? 1e-6 : 1e-3, "s");
  const force = scaleOf(Math.max(...arrays.face_force.map(Math.abs), 1e-30), "N");
  return { time: { k: time.factor, name: time.unit }, force: { k: force.factor, name: force.unit } };
}

/** @param {Blow} blow @param {Units} units */
export function drawBlow(blow, { time, force }) {
  const { kinds } = theme();
  const { arrays } = blow;
  const times = (/** @type {Float32Array} */ list, /** @type {number} */ k) => list.map((value) => value * k);
  const line = (/** @type {string} */ name, /** @type {Record<string, any>} */ look) => {
    const [x, y] = [times(arrays[`${name}_t`], time.k), times(arrays[`${name}_force`], force.k)];
    return { type: "line", x, y, ...look };
  };
  const items = [line("face", { colour: kinds[0], name: "between the faces" })];
  if (arrays.rock_t) items.push(line("rock", { colour: kinds[1], dash: [6, 3], name: "on the rock" }));
  const [from, to] = span(items.map(({ y }) => y));
  parts.force.draw({
    x: { label: inUnit("time", time.name), from: 0, to: blow.end * time.k },
    y: { label: inUnit("force", force.name), from: Math.min(from, 0), to },
    items,
    about: `Force between the faces over time, at most ${told(blow, Math.max(...arrays.face_force), "N")}`,
  });
  const known = (/** @type {string} */ name) =>
    name.includes("rock") ? blow.rod?.rock : name !== "energy_rod" || blow.rod;
  const places = Object.entries(ENERGIES).filter(([name]) => known(name));
  bars = places.map(([name]) => ({ name, fill: div("fill"), text: h("span", { class: "n" }) }));
  put(
    parts.bars,
    bars.map(({ fill, text }, i) => {
      const track = h("div", { class: "track", "aria-hidden": "true" }, fill);
      return div("share", h("span", {}, places[i][1]), track, text);
    }),
  );
}

/** @param {Blow} blow @param {number} value @param {string} unit */
const told = ({ units }, value, unit) => (units === "SI" ? si(value, unit, 3) : number(value, 3));

/** Where the energy of the striker and of the feed is at the end of the window, as shares of the striker's. @param {Blow} blow */
export function tellShares({ answer, energy_before: before }) {
  const held = answer.tool_energy_after === undefined ? 0 : answer.tool_energy_after - answer.tool_energy_before;
  const places = {
    rock: answer.rock_work,
    "returned with the striker": answer.rigid_energy_after,
    "ringing in it": answer.vibration_energy_after,
    steel: answer.steel_loss,
    "recoil damper": answer.recoil_damper_loss - answer.recoil_spring_work,
    joints: answer.joint_loss + answer.joint_energy_change,
    "left in the tool": held,
    "out of the end": answer.energy_out_of_the_end,
  };
  const share = (/** @type {number} */ value) => percent(value / before);
  const found = Object.entries(places).filter(([, value]) => Math.abs(value) > 5e-5 * before);
  const words = found.map(([name, value]) => `${name} ${share(value)}`).join(", ");
  const fed = answer.feed_force_work > 5e-5 * before ? `; the feed adds ${share(answer.feed_force_work)}` : "";
  put(parts.shares, before > 0 ? `At the end of what was followed, of the striker's energy: ${words}${fed}.` : "");
}

/** The present moment on the chart and in the bars. @param {Blow} blow @param {Units} units @param {number} frame */
export function followBlow(blow, { time }, frame) {
  const { arrays } = blow;
  parts.force.over([], arrays.t[frame] * time.k);
  const whole = bars.reduce((sum, { name }) => sum + arrays[name][frame], 0) || 1;
  for (const { name, fill, text } of bars) {
    const value = arrays[name][frame] > 1e-9 * whole ? arrays[name][frame] : 0; // less is rounding
    fill.style.width = `${(100 * value) / whole}%`;
    put(text, `${told(blow, value, "J")} (${percent(value / whole, 2)})`);
  }
}
