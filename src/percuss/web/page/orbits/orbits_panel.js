// The steady motions: where their phases come from, how they branch with the load, what the load does at the blow, and
// what becomes of a disturbance.

import { button, div, facts, h, put, settled, table } from "../core/dom.js";
import { angle, number, si } from "../core/format.js";
import { effect } from "../core/signals.js";
import {
  REST,
  chosen,
  data,
  fullOrbits,
  isHeld,
  obstacleOf,
  reasonOf,
  show,
  switchesItself,
  unhurried,
  view,
} from "../core/state.js";
import { detailsOfScenes } from "../screen/scenes.js";
import { drawOrbitCharts, orbitCharts, wantBranches } from "./orbits_charts.js";

/** @typedef {Record<string, any>} Orbit */

/** @type {Record<string, HTMLElement>} */
const parts = {};

/** The load at the blow, which stands on the screen. */
export function whyOfOrbits() {
  const { why, rest } = orbitCharts();
  parts.charts = rest;
  effect(pictures); // at once: a slider waits for them
  return why;
}

/** @param {HTMLElement} section */
export function start(section) {
  parts.table = h("div", { class: "scroll", id: "orbit-table" });
  parts.about = h("div", { id: "orbit-about" });
  parts.own = div("stack", parts.table, parts.charts, parts.about);
  put(section, parts.own, detailsOfScenes);
  effect(() => (parts.own.hidden = switchesItself() || isHeld()));
  effect(words, unhurried);
  effect(wantBranches, (want) => settled(want, REST));
}

const pictures = () =>
  void (data.about && !switchesItself() && !isHeld() && drawOrbitCharts(data.quick, view.panel === "orbits"));

/** What the words are of: they stay while it is the same, and with them the place at the keyboard. @type {any[]} */
let told = [];

function words() {
  if (view.panel !== "orbits" || isHeld() || switchesItself()) return;
  const { quick, steady, problems } = data;
  const found = chosen();
  const now = [quick, steady, problems, found?.number];
  if (told.length && now.every((one, i) => one === told[i])) return;
  told = now;
  const waits = problems.length ? "No answer: see the problem above." : "…";
  put(parts.table, quick ? orbitTable(quick, found?.number) : h("p", { class: "muted" }, waits));
  put(parts.about, found ? about(found) : h("p", { class: "muted" }, "There is no steady motion to describe."));
}

const HEADS = [
  "Motion",
  "Impact phase",
  "Possible",
  "Verdict",
  "Rhythm",
  "Ringing",
  "Load at impact over mean",
  "Blow",
];

/** @param {Record<string, any>} quick @param {number} [now] */
function orbitTable({ m, orbits, blow_alone: alone = [] }, now) {
  const answers = fullOrbits();
  const rows = orbits.map((/** @type {Orbit} */ orbit, /** @type {number} */ i) => {
    const full = answers[i];
    const { ratio, lower, upper } = orbit.waveform;
    const isChosen = now === i + 1;
    const press = () => show({ orbit: i + 1 });
    const energy = orbit.si ? si(orbit.si.blow_energy_J, "J") : number(orbit.blow_energy);
    const cells = [
      button(`${i + 1}`, press, { "aria-pressed": String(isChosen) }),
      phases(orbit),
      full ? (full.admissible ? "yes" : `no: ${obstacleOf({ quick: orbit, full })}`) : "…",
      reasonOf({ quick: orbit, full }),
      margin(full, orbit, "margin_rhythm"),
      margin(full, orbit, "margin_ringing"),
      `${number(ratio, 4)} (stable between ${number(lower, 3)} and ${number(upper, 3)})`,
      orbit.impact_velocity > 0 ? energy : "–",
    ];
    const numbers = [4, 5, 7];
    const row = cells.map((cell, j) => h("td", { class: numbers.includes(j) ? "n" : "" }, cell));
    return h("tr", { class: isChosen ? "chosen" : "" }, row);
  });
  return [
    h("h2", {}, `Steady motions with one impact ${m === 1 ? "every load period" : `in ${m} load periods`}`),
    rows.length ? table(HEADS, rows) : h("p", {}, `There is none: ${data.about.reasons["no motion"]}.`),
    alone.map((/** @type {string[]} */ lines) => h("p", {}, `Besides, ${lines.join("; ")}.`)),
  ];
}

/** The impact phase, or that of the force of a blow that takes time with B77's beside it. @param {Orbit} orbit */
const phases = ({ phase, phase_b77: b77 }) =>
  b77 === undefined ? angle(phase) : `${angle(phase)} (B77 ${angle(b77)})`;

/** One of the two margins, which come with the full answer; a rigid bar has no ringing.
 * @param {Orbit | undefined} full @param {Orbit} orbit @param {string} which */
function margin(full, orbit, which) {
  const value = (full ?? orbit)[which];
  return value === null ? (full ? "–" : "…") : number(value, 4);
}

/** The motion that is looked at. @param {NonNullable<ReturnType<typeof chosen>>} found */
function about({ number: which, quick, full }) {
  const { lower, upper, ratio, stable } = quick.waveform;
  const { moduli, sigma } = quick.reduced;
  const rule = `At the moment of impact the load is ${number(ratio)} of its mean. A rigid, undamped bar sustains the motion while this ratio lies between ${number(lower)} (flip) and ${number(upper)} (fold): here it ${stable ? "does" : "does not"}.`;
  const notes = [full?.disagreement, ...(full?.warnings ?? [])].filter(Boolean);
  return [
    h("h2", {}, `Motion ${which} in detail`),
    h("p", {}, rule),
    facts([
      ["impact phase", phases(quick)],
      ["largest multiplier, reduced criterion", number(Math.max(...moduli))],
      ["largest multiplier, with elastic modes", number(quick.multipliers?.largest)],
      ["σ, the bar's elasticity in the criterion", number(sigma)],
      ["proved", full ? (full.proven ? "yes, with all modes" : "not proved: the omitted modes leave it open") : "…"],
    ]),
    (quick.blow ?? []).map((/** @type {string} */ text) => h("p", {}, text)),
    notes.map((text) => h("p", { class: "note warn" }, text)),
  ];
}
