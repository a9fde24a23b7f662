// One blow, resolved by waves: striker, tool and rock in slow motion, the force, and where the energy goes.

import { postBinary, problemsOf, saidOf } from "../core/api.js";
import { button, facts, h, latest, put, select } from "../core/dom.js";
import { counted, number, percent, si, withUnit } from "../core/format.js";
import { effect, whenever } from "../core/signals.js";
import { data, isHeld, show, view } from "../core/state.js";
import { tr } from "../core/words.js";
import { themeNow } from "../pictures/colours.js";
import { Player } from "../motion/player.js";
import { blowCharts, blowUnits, drawBlow, followBlow, tellShares } from "./blow_charts.js";
import { blowSliders, followBlowSliders } from "./blow_sliders.js";
import { BlowStage } from "./blow_stage.js";

/** @typedef {import("./blow_stage.js").Blow} Blow */
/** What is asked: which part of the blow, in what size; `again` goes on where the one before was, `since` is when a slider
 * moved, `key` tells the questions of cases apart.
 * @typedef {{ key: string, again: boolean, tables: any, show: string, since?: number, size: Record<string, any> }} Question */

/** @type {[string, string][]} */
const SHOWN = [
  ["start", "its start: 300 µs, or 6 transits"],
  ["contact", "until it has parted"],
  ["window", "all that was followed"],
];

/** @type {Record<string, any>} */
const parts = { key: "", again: false };
/** @type {BlowStage} */
let stage;
/** @type {Player} */
let player;

/** What of it stands on the screen while its drawer is open. */
export const blowScene = () => (parts.scene ??= madeScene());

function madeScene() {
  const canvas = h("canvas", { id: "blow-stage", role: "img", "aria-label": "Striker and tool" });
  parts.scale = h("p", { class: "small muted", id: "blow-scale" });
  stage = new BlowStage(canvas, parts.scale, { painted, ended: () => player.stop() });
  player = new Player(stage, {
    id: "blow-",
    about: "Time in the blow",
    slow: "blowSlow",
    moved: pace,
    least: 1,
    most: 60,
  });
  parts.shown = select("Show", SHOWN, view.blowShow, (blowShow) => show({ blowShow }), { id: "blow-show" });
  const step = (/** @type {number} */ by) => player.seek(stage.frame + by);
  const line = player.rows(parts.shown);
  player.time.after(
    button("◂", () => step(-1), { id: "blow-back", "aria-label": "One step back" }),
    button("▸", () => step(1), { id: "blow-forth", "aria-label": "One step on" }),
  );
  return {
    stage: [h("div", { class: "stage", id: "blow-in-sight" }, canvas), line],
    toggle: () => player.toggle(),
    step,
  };
}

/** @param {HTMLElement} panel */
export function start(panel) {
  blowScene();
  parts.sentence = h("p", { id: "blow-sentence", role: "status" });
  parts.notes = h("p", { class: "small muted", id: "blow-notes" });
  parts.problem = h("div", { role: "alert", id: "blow-problem" });
  parts.facts = h("div", { class: "card", id: "blow-facts" });
  put(panel, parts.sentence, parts.notes, parts.problem, blowCharts(), blowSliders(moved), parts.facts, parts.scale);
  effect(want);
  whenever(themeNow, () => stage.blow && (drawBlow(stage.blow, parts.units), stage.seek(stage.frame)));
}

function want() {
  if (view.panel !== "blow" || isHeld()) return player.stop();
  if (!data.tables) return;
  followBlowSliders();
  parts.shown.querySelector("select").value = view.blowShow;
  const key = JSON.stringify([data.changed, view.blowShow]);
  if (key === parts.key) return;
  const question = { key, again: parts.again, tables: data.tables, show: view.blowShow };
  parts.key = key;
  parts.again = false;
  const isStart = question.show === "start";
  if (isStart) picture({ ...question, size: { whole: false } }); // need not wait for the end of the blow
  whole({ ...question, size: isStart ? { frames: 2, cells: 2 } : {} });
}

/** A slider has moved: the picture at once, in fewer cells; what the end of the blow tells comes when it rests.
 * @param {any} tables */
function moved(tables) {
  const size = { whole: false, frames: 121, cells: 80 };
  parts.again = true;
  picture({ key: "", again: true, tables, show: view.blowShow, since: performance.now(), size });
}

const ask = (/** @type {Question} */ { tables, show: part, size }) =>
  postBinary("blow", { case: tables, show: part, ...size });
const picture = latest(ask, drawn, failed);
const whole = latest(
  ask,
  (blow, question) => {
    if (question.key !== parts.key) return;
    if (question.show !== "start") drawn(blow, question);
    words(blow);
    data.blow = { changed: JSON.parse(question.key)[0], contacts: blow.answer.contacts.length };
  },
  (error, question) => {
    if (question.show === "start" && error.status === 422) return; // the picture has told it
    if (question.key === parts.key) failed(error, question);
  },
);

/** @param {Blow} blow @param {Question} question */
function drawn(blow, { key, again, since }) {
  const { canvas } = stage;
  parts.units = blowUnits(blow);
  put(parts.problem);
  stage.show(blow, again && stage.length ? stage.frame / stage.length : 0);
  player.scrub.max = String(stage.length);
  drawBlow(blow, parts.units);
  pace();
  stage.seek(stage.frame);
  if (!again && view.panel === "blow") player.begin();
  if (since) canvas.dataset.wait = String(performance.now() - since); // from the slider to the frame
  if (key) canvas.dataset.key = key;
}

/** @param {any} error @param {Question} question */
function failed(error, { key }) {
  if (error.status !== 422 && key === parts.key) parts.key = ""; // the same question may be answered later
  player.stop();
  put(parts.sentence, "");
  const before = stage.blow && stage.canvas.dataset.key !== key;
  put(
    parts.problem,
    problemsOf(error).map((one) => h("p", { class: "note bad" }, saidOf(one))),
    before && h("p", { class: "small muted" }, "What is shown below is still the blow of the case before."),
  );
}

function painted() {
  const { blow, frame } = stage;
  if (!blow) return;
  followBlow(blow, parts.units, frame);
  player.tellMoment(blow.arrays.t[frame], parts.units, 4, frame);
}

/** How slowly it is shown, as the view has it. */
function pace() {
  stage.seconds = Number(view.blowSlow);
  if (!stage.blow) return;
  const slower = stage.seconds / stage.blow.end;
  const words = stage.blow.units === "SI" ? `1/${number(slower, 2)} speed` : `${number(1 / slower, 2)} rad/s`;
  player.tellPace(stage.seconds / 100, words);
}

/** @param {Blow} blow */
function words(blow) {
  put(parts.sentence, blow.sentence);
  const notes = blow.notes.map((/** @type {string} */ note) => `${note[0].toUpperCase()}${note.slice(1)}.`);
  put(parts.notes, notes.join(" "));
  stage.canvas.setAttribute("aria-label", tr(`Striker, tool and rock with the waves in them. ${blow.sentence}`));
  tellShares(blow);
  put(parts.facts, h("h2", {}, "The whole blow"), facts(factsOf(blow)));
}

/** @param {Blow} blow */
function factsOf({ answer, units, waves, velocity_from: from, energy_before: before }) {
  const sized = units === "SI";
  const told = (/** @type {number} */ value, /** @type {string} */ unit) => (sized ? si(value, unit) : number(value));
  const speed = (/** @type {number} */ value) => (sized ? withUnit(value, "m/s") : number(value));
  const duration = answer.contact_duration;
  const peaks = (/** @type {string} */ of, /** @type {any[]} */ list = []) =>
    list.length
      ? ["compression", "tension"].map((what) => [
          `greatest ${what} in the ${of}`,
          told(Math.max(...list.map((peak) => peak[what])), "Pa"),
        ])
      : [];
  return [
    ["speed before", `${speed(answer.mean_velocity_before)}, ${from}`],
    ["speed after, as a whole", speed(answer.mean_velocity_after)],
    ["effective restitution R", number(answer.effective_restitution)],
    [
      "contacts",
      `${counted(answer.contacts.length, "contact")}, ${sized ? si(duration, "s") : withUnit(duration, "rad")} from first to last`,
    ],
    ["impulse", sized ? withUnit(answer.impulse, "N·s") : number(answer.impulse)],
    ["energy before", told(before, "J")],
    ...peaks("striker", answer.peaks_of_striker),
    ...peaks("tool", answer.peaks_of_rod),
    ...(answer.rock_work === undefined
      ? []
      : [
          ["work on the rock", `${told(answer.rock_work, "J")}, ${percent(answer.efficiency)}`],
          ["penetration that remains", told(answer.residual_penetration, "m")],
        ]),
    ["the computation ended", answer.outcome_in_words],
    ["waves", waves],
  ];
}
