// The answer first: whether the hammer sustains its motion, why, and what it delivers; one line, always as high.

import { saidOf } from "../core/api.js";
import { $, button, div, h, put, settled } from "../core/dom.js";
import { number, plainNumber, si, withUnit } from "../core/format.js";
import { whenever } from "../core/signals.js";
import * as state from "../core/state.js";
import { chosen, data, isHeld, reasonOf, switchesItself, view } from "../core/state.js";
import { nearestEdge } from "../map/map_panel.js";
import { machineTold } from "./headline_machine.js";
import { every, playedTold, plays } from "./headline_played.js";

/** A figure: its name, its value or "…" while that is on its way, its unit.
 * @typedef {[name: string, value: number | "…", unit: string]} Figure */
/** A place that the verdict names, and what a parameter is there. @typedef {{ words: string, name: string, value: number }} Way */
/** What the headline tells: the look of the badge and its text, the words beside it, the figures; of a steady motion
 * which of all it is, and whether each is stable; what it takes for granted of the load; the figures to compare with.
 * @typedef {{ kind: "good" | "bad" | "warn", text: string, words: string, ways?: Way[], figures?: Figure[], now?: number,
 *   stable?: boolean[], clock?: { words: string, title?: string } | null, pinned?: Figure[] }} Told */

export function startHeadline() {
  whenever(
    told,
    (now) => {
      put($("#headline"), headline(now));
      say(`${now.text}. ${now.words}`);
    },
    state.unhurried,
  );
}

/** What is read aloud, once it has come to rest. */
const say = settled((/** @type {string} */ words) => put($("#verdict-said"), words), 700);

/** @param {Told} told */
function headline({ kind, text, words, ways = [], figures = [], now, stable = [], clock, pinned }) {
  const go = (/** @type {Way} */ { name, value }) => state.move({ [name]: plainNumber(value, 5) });
  const motions = stable.map((good, i) => {
    const title = `Motion ${i + 1} of ${stable.length}, ${good ? "stable" : "unstable"}`;
    const said = { "aria-pressed": String(now === i + 1), "aria-label": title, title };
    return button(String(i + 1), () => state.show({ orbit: i + 1 }), said);
  });
  const beside = [
    h("p", { id: "reason", title: words }, words),
    ways.map((way) => button(`${way.words} ▸`, () => go(way), { class: "link way" })),
    clock && h("p", { class: clock.title ? "small muted" : "small", id: "clock", title: clock.title }, clock.words),
    motions.length > 1 && h("span", { class: "segments", role: "group", "aria-label": "Which steady motion" }, motions),
  ];
  const badge = h("span", { class: `badge ${kind}`, id: "verdict" }, text);
  const cells = figures.map((one) => figure(one, pinned));
  return [div("verdict", badge, div("words", beside)), h("dl", { class: "figures" }, cells)];
}

/** @param {Figure} figure @param {Figure[]} [pinned] those of A */
function figure([name, value, unit], pinned) {
  const open = () => state.show({ panel: "blow" });
  const label = name === ROCK ? button(`${name} ▸`, open, { class: "link" }) : name;
  if (value === "…") return h("div", {}, h("dd", {}, value), h("dt", {}, label));
  const [told, inUnits] = (["J", "W", "Pa"].includes(unit) ? si : withUnit)(value, unit, 3).split("\u202f");
  const other = pinned?.find(([one, , own]) => one === name && own === unit)?.[1];
  const more = other ? 100 * (value / Number(other) - 1) : Number.NaN;
  const beside = Number.isFinite(more) && ` ${more < 0 ? "−" : "+"}${number(Math.abs(more), 2)} %`;
  const term = h("dt", {}, label, beside && h("span", { class: "beside" }, beside));
  return h("div", {}, h("dd", {}, told, inUnits && h("small", {}, inUnits)), term);
}

/** The figures of the present design, to be pinned. */
export const presentFigures = () => told()?.figures ?? [];

/** @returns {Told | null} */
function told() {
  const pinned = data.pinned?.figures;
  const words = data.problems.map((/** @type {any} */ one) => saidOf(one).filter(Boolean).join("")).join(" ");
  if (words) return { kind: "bad", text: "No answer", words, clock: clock() };
  if (switchesItself()) return data.machine && { ...machineTold(data.machine), pinned };
  if (!data.quick) return null;
  const found = chosen();
  return { ...(plays() ? playedTold() : found ? steady(found) : none(data.quick)), clock: clock(), pinned };
}

/** What the verdict takes for granted of a load that switches as a valve does, or where it turns on the load's clock. */
function clock() {
  if (switchesItself() || !data.quick) return null;
  if (data.quick.clocked) return { words: ` ${data.quick.clocked}` };
  const words = " The load switches as a valve does: judged as if it kept time by itself; a valve would re-time it.";
  return data.info?.clock ? { words, title: data.info.clock } : null;
}

/** @param {NonNullable<ReturnType<typeof chosen>>} found @returns {Told} */
function steady(found) {
  const { quick, full, number: now } = found;
  const all = { figures: figures(found), now, stable: data.quick.orbits.map((/** @type {any} */ one) => one.stable) };
  const obstacle = state.obstacleOf(found);
  if (obstacle) {
    const words = `This steady motion cannot happen: the end ${obstacle}. Its stability: ${reasonOf(found)}.`;
    return { kind: "bad", text: "Not possible", words, ...all };
  }
  const often = view.m === 1 ? "One blow every period" : `One blow in ${view.m} periods`;
  const share = 1 - (full ?? quick).margin; // of a disturbance that is left after a blow
  if (!quick.stable) {
    const why = share > 1 ? `a hair's breadth grows ${number(share, 3)} × a blow` : reasonOf(found);
    return { kind: "bad", text: "Unstable", words: `${often}; ${why}.`, ways: edge("stable from"), ...all };
  }
  const blows = share > 0 ? Math.max(1, Math.ceil(Math.log(0.01) / Math.log(share))) : 1;
  const settles = `settles in ${blows === 1 ? "one blow" : `${number(blows)} blows`}`;
  const sure = state.fullAnswer()?.uncertainty;
  const words = `${often}; ${Number.isFinite(share) ? settles : reasonOf(found)}.${sure ? ` ${sure.sentence}` : ""}`;
  return { kind: "good", text: "Stable", words, ways: edge("stable until"), ...all };
}

/** Where the nearest curve of the map is met. @param {string} words @returns {Way[]} */
function edge(words) {
  const found = nearestEdge();
  if (!found || (words === "stable from" && found.kind === "fold")) return [];
  const { label, name, value, unit } = found;
  return [{ words: `${words} ${label} ${withUnit(value, unit, 3)}`, name, value }];
}

/** @param {Record<string, any>} quick @returns {Told} */
function none({ m, nearest, note }) {
  const exists = (/** @type {string} */ name, /** @type {string} */ words, /** @type {number} */ within) =>
    Number.isFinite(nearest?.[name])
      ? [{ words: `exists from ${words} ${number(nearest[name], 3)}`, name, value: nearest[name] * within }]
      : [];
  const ways = [...exists("load_factor", "a load factor of", 0.999), ...exists("restitution", "R", 1.001)];
  const why = note || "The mean load is too great for its alternating part.";
  const words = `No steady motion has one impact ${every(m)}. ${why}`;
  return { kind: "bad", text: "No steady motion", words, ways };
}

const FIRST = ["blow_energy_J", "blow_rate_Hz", "impact_velocity_m_s", "peak_stress_MPa", "percussive_power_kW"];

/** @param {import("../core/state.js").Chosen} found @returns {Figure[]} */
function figures({ quick, full }) {
  const struck = (/** @type {any} */ value) => (quick.impact_velocity > 0 ? value : Number.NaN);
  if (!quick.si)
    return [
      ["blow energy", struck(quick.blow_energy), ""],
      ["striking speed", struck(quick.impact_velocity), ""],
      ["impact phase [rad]", quick.phase, ""],
    ];
  const found = FIRST.filter((key) => !isHeld() || key in quick.si).map((key) => {
    const { label, unit, factor } = data.about.cards.find((/** @type {any} */ card) => card.key === key);
    const value = quick.si[key] ?? (full?.si ? (full.si[key] ?? Number.NaN) : null);
    /** @type {Figure} */
    const cell = [label, struck(value === null ? "…" : value * factor), unit]; // in a unit without a prefix
    return cell;
  });
  return [...found, ...intoRock(state.fullAnswer())];
}

const ROCK = "into the rock";

/** What a blow puts into the rock, where there is one: it comes with the whole answer. @param {any} answer @returns {Figure[]} */
export const intoRock = (answer) =>
  data.tables.rock
    ? [[ROCK, answer?.transfer === undefined ? "…" : (answer.transfer?.rock_energy ?? Number.NaN), "J"]]
    : [];
