// The force between the faces and on the rock over time, and where the energy is.

import { Chart, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { h, put } from "../core/dom.js";
import { inUnit, number, percent, scaleOf, si } from "../core/format.js";

const ENERGIES = [
  ["energy_rigid", "with the striker as a whole"],
  ["energy_vibration", "ringing in the striker"],
  ["energy_rod", "in the tool"],
  ["energy_rock_dissipated", "in the rock, for good"],
  ["energy_rock_stored", "in the rock, springs back"],
];

const parts = {};

export function blowCharts() {
  parts.force = new Chart("Force over time");
  parts.bars = h("div", { class: "shares energies", id: "blow-energies" });
  parts.shares = h("p", { class: "small", id: "blow-shares" });
  return h(
    "div",
    { class: "grid" },
    h("div", { class: "card" }, parts.force.figure),
    h("div", { class: "card" }, h("h2", {}, "Where the energy is"), parts.bars, parts.shares),
  );
}

/** Factors and units in which a blow is told. */
export function blowUnits(blow) {
  if (blow.units !== "SI") return { time: { k: 1, name: "rad" }, force: { k: 1, name: "" } };
  const most = Math.max(...blow.arrays.face_force.map(Math.abs), 1e-30);
  const time = scaleOf(blow.end < 2e-3 ? 1e-6 : 1e-3, "s");
  const force = scaleOf(most, "N");
  return { time: { k: time.factor, name: time.unit }, force: { k: force.factor, name: force.unit } };
}

export function drawBlow(blow, units) {
  const { kinds } = theme();
  const { arrays } = blow;
  const line = (name, words, colour, dash) => ({
    type: "line",
    x: arrays[`${name}_t`].map((t) => t * units.time.k),
    y: arrays[`${name}_force`].map((force) => force * units.force.k),
    colour,
    dash,
    name: words,
  });
  const items = [line("face", "between the faces", kinds[0])];
  if (arrays.rock_t) items.push(line("rock", "on the rock", kinds[1], [6, 3]));
  const [from, to] = span(items.map((item) => item.y));
  parts.force.draw({
    x: { label: inUnit("time", units.time.name), from: 0, to: blow.end * units.time.k },
    y: { label: inUnit("force", units.force.name), from: Math.min(from, 0), to },
    items,
    about: `Force between the faces over time, at most ${told(blow, Math.max(...arrays.face_force), "N")}`,
  });
  bars(blow);
}

const told = (blow, value, unit) => (blow.units === "SI" ? si(value, unit, 3) : number(value, 3));

/** Where the energy of the striker and of the feed is at the end of the window, as shares of the striker's. */
export function tellShares({ answer, energy_before: before }) {
  const held = answer.tool_energy_after === undefined ? 0 : answer.tool_energy_after - answer.tool_energy_before;
  const found = [
    ["rock", answer.rock_work],
    ["returned with the striker", answer.rigid_energy_after],
    ["ringing in it", answer.vibration_energy_after],
    ["steel", answer.steel_loss],
    ["recoil damper", answer.recoil_damper_loss - answer.recoil_spring_work],
    ["joints", answer.joint_loss + answer.joint_energy_change],
    ["left in the tool", held],
    ["out of the end", answer.energy_out_of_the_end],
  ].filter(([, value]) => Math.abs(value) > 5e-5 * before);
  const words = found.map(([name, value]) => `${name} ${percent(value / before)}`).join(", ");
  const fed = answer.feed_force_work > 5e-5 * before ? `; the feed adds ${percent(answer.feed_force_work / before)}` : "";
  put(parts.shares, before > 0 ? `At the end of what was followed, of the striker's energy: ${words}${fed}.` : "");
}

/** A row for each place that the energy can be in. */
function bars(blow) {
  parts.rows = ENERGIES.filter(([name]) => (name.includes("rock") ? blow.rod?.rock : name !== "energy_rod" || blow.rod)).map(
    ([name, words]) => ({ name, fill: h("div", { class: "fill" }), text: h("span", { class: "n" }), words }),
  );
  put(
    parts.bars,
    parts.rows.map(({ fill, text, words }) =>
      h("div", { class: "share" }, h("span", {}, words), h("div", { class: "track", "aria-hidden": "true" }, fill), text),
    ),
  );
}

/** The present moment on the chart and in the bars. */
export function followBlow(blow, units, frame) {
  const { arrays } = blow;
  parts.force.over([], arrays.t[frame] * units.time.k);
  const whole = parts.rows.reduce((sum, { name }) => sum + arrays[name][frame], 0) || 1;
  for (const { name, fill, text } of parts.rows) {
    const value = arrays[name][frame] > 1e-9 * whole ? arrays[name][frame] : 0; // less is rounding
    fill.style.width = `${(100 * value) / whole}%`;
    put(text, `${told(blow, value, "J")} (${percent(value / whole, 2)})`);
  }
}
