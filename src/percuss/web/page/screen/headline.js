// The answer first: whether the hammer sustains its motion, why, and what it delivers; one line, always as high.

import { $, h, put, settled } from "../core/dom.js";
import { number, plainNumber, si, withUnit } from "../core/format.js";
import { nearestEdge } from "../map/map_panel.js";
import { chosen, data, isHeld, move, obstacleOf, on, reasonOf, show, switchesItself, unhurried, view } from "../core/state.js";
import { plays, playedFigures, playedVerdict } from "./headline_played.js";
import { machineFigures, machineVerdict } from "./headline_machine.js";

export function startHeadline() {
  on("quick steady machine problems view info played edges pinned", unhurried(paint));
}

let last = "";

/** The verdict in its place: [kind of the badge, its text, the words], the rows of figures, and what there is to choose. */
function paint() {
  const found = answer();
  if (!found) return;
  const [[kind, text, words, ways = []], rows, choice] = found;
  const key = JSON.stringify([kind, text, words, ways, rows, choice, data.info?.clock, pinnedFigures()]);
  if (key === last) return; // nothing new to say
  last = key;
  put(
    $("#headline"),
    h(
      "div",
      { class: "verdict" },
      h("span", { class: `badge ${kind}`, id: "verdict" }, text),
      h("div", { class: "words" }, h("p", { id: "reason", title: words }, words), ways.map(way), clock(), choice && orbits(choice)),
    ),
    h("dl", { class: "figures" }, rows.map(figure)),
  );
  say(`${text}. ${words}`);
}

/** A place that the verdict names: pressed, the design goes there. */
const way = ({ words, name, value }) =>
  h("button", { type: "button", class: "link way", onclick: () => move({ [name]: plainNumber(value, 5) }) }, `${words} ▸`);

/** What is read aloud, once it has come to rest. */
const say = settled((words) => put($("#verdict-said"), words), 700);

function answer() {
  if (data.problems.length) {
    const words = data.problems.map((p) => [p.key && `${p.key}: `, p.message, p.remedy && ` — ${p.remedy}`].filter(Boolean).join(""));
    return [["bad", "No answer", words.join(" ")], []];
  }
  if (switchesItself()) return data.machine && [machineVerdict(), machineFigures()];
  if (!data.quick) return null;
  if (plays()) return [playedVerdict(), playedFigures()];
  const found = chosen();
  if (!found) return [none(), []];
  const all = data.quick.orbits;
  return [verdict(found), figures(found), all.length > 1 ? { now: found.number, stable: all.map((orbit) => orbit.stable) } : null];
}

/** What the verdict takes for granted of a load that switches as a valve does, or where it turns on the load's clock. */
function clock() {
  if (switchesItself() || !data.quick) return null;
  if (data.quick.clocked) return h("p", { class: "small", id: "clock" }, ` ${data.quick.clocked}`);
  const note = data.info?.clock;
  const words = " The load switches as a valve does: judged as if it kept time by itself; a valve would re-time it.";
  return note && h("p", { class: "small muted", id: "clock", title: note }, words);
}

function verdict(found) {
  const { stable } = found.quick;
  const obstacle = obstacleOf(found);
  if (obstacle) return ["bad", "Not possible", `This steady motion cannot happen: the end ${obstacle}. Its stability: ${reasonOf(found)}.`];
  const often = view.m === 1 ? "One blow every period" : `One blow in ${view.m} periods`;
  const share = 1 - (found.full ?? found.quick).margin; // of a disturbance that is left after a blow
  const known = Number.isFinite(share);
  const sure = stable && data.steady?.uncertainty ? ` ${data.steady.uncertainty.sentence}` : "";
  if (!stable) return ["bad", "Unstable", `${often}; ${known && share > 1 ? `a hair's breadth grows ${number(share, 3)} × a blow` : reasonOf(found)}.`, edge("stable from")];
  const blows = known && share > 0 ? Math.max(1, Math.ceil(Math.log(0.01) / Math.log(share))) : 1;
  return ["good", "Stable", `${often}; ${known ? `settles in ${blows === 1 ? "one blow" : `${number(blows)} blows`}` : reasonOf(found)}.${sure}`, edge("stable until")];
}

/** Where the nearest curve of the map is met. */
function edge(words) {
  const found = nearestEdge();
  if (!found || (words === "stable from" && found.kind === "fold")) return [];
  return [{ words: `${words} ${found.label} ${withUnit(found.value, found.unit, 3)}`, name: found.name, value: found.value }];
}

function none() {
  const { m, nearest, note } = data.quick;
  const ways = ["load_factor", "restitution"]
    .filter((name) => nearest?.[name] !== null && nearest?.[name] !== undefined)
    .map((name) => ({ words: `exists from ${name === "restitution" ? "R" : "a load factor of"} ${number(nearest[name], 3)}`, name, value: name === "restitution" ? nearest[name] * 1.001 : nearest[name] * 0.999 }));
  const often = m === 1 ? "every load period" : `in ${m} load periods`;
  return ["bad", "No steady motion", `No steady motion has one impact ${often}. ${note || "The mean load is too great for its alternating part."}`, ways];
}

const FIRST = ["blow_energy_J", "blow_rate_Hz", "impact_velocity_m_s", "peak_stress_MPa", "percussive_power_kW"];

/** What a figure of the report is called, its value in a unit without a prefix, and this unit. */
function inUnit(key, value) {
  const { label, unit, factor } = data.about.cards.find((card) => card.key === key);
  return [label, value === null ? null : value * factor, unit];
}

function figures({ quick, full }) {
  const si = quick.si;
  const cells = si
    ? (isHeld() ? FIRST.filter((key) => key in si) : FIRST).map((key) => inUnit(key, si[key] ?? (full?.si ? (full.si[key] ?? Number.NaN) : null)))
    : [
        ["blow energy", quick.blow_energy, ""],
        ["striking speed", quick.impact_velocity, ""],
        ["impact phase [rad]", quick.phase, ""],
      ];
  if (!(quick.impact_velocity > 0))
    for (const cell of cells) if (cell[0] !== "impact phase [rad]") cell[1] = Number.NaN; // there is no blow
  return cells;
}

function figure([name, value, unit]) {
  if (value === null) return h("div", {}, h("dd", {}, "…"), h("dt", {}, name));
  const [told, inUnits] = (SCALED.has(unit) ? si : withUnit)(value, unit, 3).split("\u202f");
  const other = pinnedFigures()?.find(([one, , own]) => one === name && own === unit)?.[1];
  const more = other ? 100 * (value / other - 1) : Number.NaN;
  const beside = Number.isFinite(more) ? ` ${more < 0 ? "−" : "+"}${number(Math.abs(more), 2)} %` : "";
  return h("div", {}, h("dd", {}, told, inUnits && h("small", {}, inUnits)), h("dt", {}, name, beside && h("span", { class: "beside" }, beside)));
}

const SCALED = new Set(["J", "W", "Pa"]);

/** The figures of the design that is pinned as A. */
const pinnedFigures = () => data.pinned?.figures;

/** Those of the present design, to be pinned: [name, value, unit]. */
export const presentFigures = () => answer()?.[1] ?? [];

function orbits({ now, stable }) {
  const button = (good, i) => {
    const label = `Motion ${i + 1} of ${stable.length}, ${good ? "stable" : "unstable"}`;
    return h("button", { type: "button", "aria-pressed": String(now === i + 1), "aria-label": label, title: label, onclick: () => show({ orbit: i + 1 }) }, String(i + 1));
  };
  return h("span", { class: "segments", role: "group", "aria-label": "Which steady motion" }, stable.map(button));
}
