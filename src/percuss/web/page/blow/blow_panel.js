// One blow, resolved by waves: striker, tool and rock in slow motion, the force, and where the energy goes.

import { postBinary, problemsOf, saidOf } from "../core/api.js";
import { blowCharts, blowUnits, drawBlow, followBlow, tellShares } from "./blow_charts.js";
import { blowPlayer, pauseBlow, playBlow, stepBlow, toggleBlow } from "./blow_player.js";
import { blowSliders, followBlowSliders } from "./blow_sliders.js";
import { BlowStage } from "./blow_stage.js";
import { facts, h, latest, put, select } from "../core/dom.js";
import { counted, number, percent, si, withUnit } from "../core/format.js";
import { data, isHeld, on, show, view } from "../core/state.js";
import { tr } from "../core/words.js";

const SHOWN = [
  ["start", "its start: 300 µs, or 6 transits"],
  ["contact", "until it has parted"],
  ["window", "all that was followed"],
];

const parts = { key: "", again: false };

/** What of it stands on the screen while its drawer is open. */
export const blowScene = () => (parts.scene ??= madeScene());

function madeScene() {
  const canvas = h("canvas", { id: "blow-stage", role: "img", "aria-label": "Striker and tool" });
  parts.scale = h("p", { class: "small muted", id: "blow-scale" });
  parts.stage = new BlowStage(canvas, parts.scale);
  parts.shown = select("Show", SHOWN, view.blowShow, (blowShow) => show({ blowShow }), { id: "blow-show" });
  return { stage: [h("div", { class: "stage", id: "blow-in-sight" }, canvas), blowPlayer(painted, parts.shown)], toggle: toggleBlow, step: stepBlow };
}

export function start(panel) {
  blowScene();
  parts.sentence = h("p", { id: "blow-sentence", role: "status" });
  parts.notes = h("p", { class: "small muted", id: "blow-notes" });
  parts.problem = h("div", { role: "alert", id: "blow-problem" });
  parts.facts = h("div", { class: "card", id: "blow-facts" });
  put(panel, parts.sentence, parts.notes, parts.problem, blowCharts(), blowSliders(moved), parts.facts, parts.scale);
  on("tables view", want);
  on("theme", () => parts.blow && (drawBlow(parts.blow, parts.units), painted(parts.stage.frame)));
  document.addEventListener("visibilitychange", () => document.hidden && pauseBlow());
}

function want() {
  if (view.panel !== "blow" || isHeld()) return pauseBlow();
  if (!data.tables) return;
  followBlowSliders();
  parts.shown.querySelector("select").value = view.blowShow;
  const key = JSON.stringify([data.changed, view.blowShow]);
  if (key === parts.key) return;
  const question = { key, again: parts.again, tables: data.tables, show: view.blowShow, since: 0 };
  parts.key = key;
  parts.again = false;
  if (question.show === "start") picture({ ...question, size: { whole: false } }); // need not wait for the end of the blow
  whole({ ...question, size: question.show === "start" ? { frames: 2, cells: 2 } : {} });
}

/** A slider has moved: the picture at once, in fewer cells; what the end of the blow tells comes when it rests. */
function moved(tables) {
  const size = { whole: false, frames: 121, cells: 80 };
  parts.again = true;
  picture({ key: "", again: true, tables, show: view.blowShow, since: performance.now(), size });
}

const ask = ({ tables, show: part, size }) => postBinary("blow", { case: tables, show: part, ...size });
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

function drawn(blow, { key, again, since }) {
  const { canvas } = parts.stage;
  parts.blow = blow;
  parts.units = blowUnits(blow);
  put(parts.problem);
  parts.stage.show(blow);
  drawBlow(blow, parts.units);
  playBlow(blow, parts.units, again);
  if (since) canvas.dataset.wait = String(performance.now() - since); // from the slider to the frame
  if (key) canvas.dataset.key = key;
}

function failed(error, { key }) {
  if (error.status !== 422 && key === parts.key) parts.key = ""; // the same question may be answered later
  pauseBlow();
  put(parts.sentence, "");
  const lines = problemsOf(error).map(saidOf);
  const before = parts.blow && parts.stage.canvas.dataset.key !== key;
  put(
    parts.problem,
    lines.map((line) => h("p", { class: "note bad" }, line)),
    before && h("p", { class: "small muted" }, "What is shown below is still the blow of the case before."),
  );
}

function painted(frame) {
  parts.stage.frame = frame;
  parts.stage.draw();
  followBlow(parts.blow, parts.units, frame);
  parts.stage.canvas.dataset.frame = String(frame);
}

function words(blow) {
  put(parts.sentence, blow.sentence);
  put(parts.notes, blow.notes.map((note) => `${note[0].toUpperCase()}${note.slice(1)}.`).join(" "));
  parts.stage.canvas.setAttribute("aria-label", tr(`Striker, tool and rock with the waves in them. ${blow.sentence}`));
  tellShares(blow);
  put(parts.facts, h("h2", {}, "The whole blow"), facts(factsOf(blow)));
}

function factsOf({ answer, units, waves, velocity_from: from, energy_before: before }) {
  const sized = units === "SI";
  const told = (value, unit) => (sized ? si(value, unit) : number(value));
  const speed = (value) => (sized ? withUnit(value, "m/s") : number(value));
  const time = (value) => (sized ? si(value, "s") : withUnit(value, "rad"));
  const [own, rod] = ["peaks_of_striker", "peaks_of_rod"].map((name) => answer[name] ?? []);
  const greatest = (peaks, what) => told(Math.max(...peaks.map((peak) => peak[what])), sized ? "Pa" : "");
  const rows = [
    ["speed before", `${speed(answer.mean_velocity_before)}, ${from}`],
    ["speed after, as a whole", speed(answer.mean_velocity_after)],
    ["effective restitution R", number(answer.effective_restitution)],
    ["contacts", `${counted(answer.contacts.length, "contact")}, ${time(answer.contact_duration)} from first to last`],
    ["impulse", sized ? withUnit(answer.impulse, "N·s") : number(answer.impulse)],
    ["energy before", told(before, "J")],
    ["greatest compression in the striker", greatest(own, "compression")],
    ["greatest tension in the striker", greatest(own, "tension")],
  ];
  if (rod.length) rows.push(["greatest compression in the tool", greatest(rod, "compression")], ["greatest tension in the tool", greatest(rod, "tension")]);
  if (answer.rock_work !== undefined)
    rows.push(
      ["work on the rock", `${told(answer.rock_work, "J")}, ${percent(answer.efficiency)}`],
      ["penetration that remains", sized ? si(answer.residual_penetration, "m") : number(answer.residual_penetration)],
    );
  rows.push(["the computation ended", answer.outcome_in_words]);
  rows.push(["waves", waves]);
  return rows;
}
