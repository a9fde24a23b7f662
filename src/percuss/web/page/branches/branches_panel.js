// Branches: the steady motion followed through a parameter, with all that happens on the way. A click on a branch shows
// and sounds the motion there; the place can be dragged along it, or moved by the arrow keys.

import { post } from "../core/api.js";
import { div, framed, h, latest, problem, put, settled } from "../core/dom.js";
import { plainNumber, withUnit } from "../core/format.js";
import { present } from "../core/moves.js";
import { effect, signal, untracked, whenever } from "../core/signals.js";
import { REST, chosen, data, isHeld, modesInWords, move, show, view } from "../core/state.js";
import { Chart, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { along, askedRange, beginning, ready, rests, rising, startChoices } from "./branches_choices.js";
import { eventTable, orbitList } from "./branches_events.js";
import { everyRows, impossible, others, settledDots, stopAll, wantEvery, wantSettled } from "./branches_every.js";
import { motionCard, noMotion, pauseBranch, showMotion, toggleBranch } from "./branches_motion.js";
import { diagram, spotted } from "./branches_picture.js";
import { branchesOf, phaseOf } from "./branches_rows.js";
import { ASIDE, RISING, placeAt, placeNear, placeOf, rowAt } from "./branches_walk.js";

/** @typedef {import("./branches_rows.js").Branch} Branch */
/** @typedef {import("./branches_walk.js").Place} Place */
/** @typedef {{ tables: any, axis: import("./branches_choices.js").Axis, modes: number }} Question */

const NEAR = 40; // pixels within which a click takes the branch
/** @type {Record<string, any>} */
const parts = {};
/** @type {Chart} */
let chart;
let key = ""; // of the question under way, or answered
/** @type {import("./branches_picture.js").Drawn} */
let drawn = { followed: [], others: [], thin: [] };
/** All that can be looked at: what was followed, then the others of the diagram. @type {Branch[]} */
let branches = [];
/** The question that they answer. */
const asked = signal(/** @type {Question | null} */ (null));
/** @type {Place | null} */
let spot = null;
let since = 0; // the last change of the case that is not a move through the parameter
let dragging = false;

/** @param {HTMLElement} section */
export function start(section) {
  chart = new Chart("Branches of motions", { kind: "map", role: "application", about: "Branches of motions" });
  const { canvas, figure } = chart;
  Object.assign(canvas, { tabIndex: 0, id: "branches" });
  parts.choice = div("row");
  parts.readout = h("p", { class: "small", id: "branches-readout", "aria-live": "polite" });
  parts.status = h("p", { class: "small muted", id: "branches-status", role: "status" });
  parts.events = h("div", { class: "card scroll", id: "branches-events" });
  parts.found = h("div", { class: "card scroll", id: "branches-found" });
  const picture = div(
    "card",
    figure,
    parts.readout,
    everyRows(more, () => repaint()),
    parts.status,
  );
  put(section, div("card", parts.choice), parts.found, div("grid", picture, motionCard(carry)), parts.events);
  pointer(canvas);
  section.addEventListener("keydown", keys);
  whenever(
    () => data.changed,
    (changed) => {
      if (view.panel === "branches" && data.info && data.moved?.length === 1 && data.moved[0] === along().name) return;
      since = changed;
      stopAll(); // of another hammer: sliders come first
    },
  );
  startChoices(parts.choice, search);
  effect(want, (run) => settled(run, REST));
  whenever(
    () => ready() && [view.every, view.settled],
    () => asked.value && simulated(),
  );
  effect(() => void (ready() && placed()));
  effect(() => void (view.panel !== "branches" && (pauseBranch(), stopAll())));
  repaint = effect(paint, framed);
}

/** Ask for the branches of the case as it is now, unless they are under way or there. */
function want() {
  if (!ready() || data.problems.length || (data.quick ?? data.machine)?.changed !== data.changed) return;
  const axis = along();
  const begin = beginning();
  const { depth, bmodes: modes } = view;
  const now = JSON.stringify([since, axis.name, axis.from, axis.to, view.begin || [view.m, view.orbit], depth, modes]);
  if (now === key) return untracked(simulated);
  const words = "There is no steady motion to begin with: choose another one under “Other motions”, or move a slider.";
  if (!begin) return untracked(() => nothing(words));
  key = now;
  put(parts.status, "Following …");
  askBranches({ tables: data.tables, axis, begin, depth: rests(begin) ? 0 : depth, modes, now });
}

const askBranches = latest(
  (/** @type {Question & { begin: string, depth: number, now: string }} */ { tables, axis, begin, depth, modes }) =>
    post("follow", { case: tables, along: askedRange(axis), orbit: begin, switch: depth, modes }),
  (found, question) => {
    if (question.now !== key) return;
    asked.value = question;
    spot = null;
    const followed = branchesOf(found);
    chart.canvas.dataset.branches = followed.map(({ label }) => label).join();
    const stopped = followed.some(({ points }) => points.some(({ type }) => type === "stopped"));
    const { modes } = question;
    const how = modes || isHeld() ? `With ${modesInWords(modes)}.` : "Of a rigid bar.";
    put(
      parts.status,
      stopped
        ? "It took too long: this is what was followed so far."
        : `${how} Click on a branch, drag along it, or use the arrow keys.`,
    );
    renew(followed);
    simulated();
  },
  (error, question) => {
    if (question.now !== key) return;
    if (error.status !== 422) key = ""; // the same question would be refused again
    nothing(problem(error));
  },
);

/** Other branches are those that were followed. @param {Branch[]} followed */
function renew(followed) {
  drawn = { followed, others: others(followed), thin: impossible };
  branches = [...drawn.followed, ...drawn.others];
  if (branches.length) asked.value ??= { tables: data.tables, axis: along(), modes: view.bmodes };
  if (spot && !branches[spot.branch]) spot = null;
  chart.canvas.dataset.others = String(drawn.others.length);
  if (asked.value) eventTable(parts.events, drawn, asked.value.axis, goTo);
  else put(parts.events);
  placed();
  repaint();
}

/** There are more branches in the diagram, or none any more. */
const more = () => renew(drawn.followed);

/** @param {string | Node} words */
function nothing(words) {
  asked.value = spot = null;
  delete chart.canvas.dataset.branches;
  put(parts.readout);
  put(parts.status, words);
  renew([]);
  if (!branches.length) noMotion("");
  simulated();
}

/** All branches, and simulations over what the diagram shows, where they are wanted. */
function simulated() {
  if (view.panel !== "branches") return; // an answer that comes late asks for nothing more
  const whole = askedRange(along());
  const { from, to } = view.alongr || view.every || !branches.length ? whole : reached();
  const question = { ...whole, modes: view.bmodes, now: since };
  wantEvery(question);
  wantSettled({ ...question, from: Math.max(from, whole.from), to: Math.min(to, whole.to) });
}

/* the orbits of another label */

const search = latest(
  (/** @type {string} */ label) => {
    put(parts.status, `Searching ${rests(label) ? label : `z=${label}`} …`);
    return post("orbits", { case: data.tables, label, modes: view.bmodes });
  },
  (found) => {
    put(parts.status, "");
    orbitList(parts.found, found, (begin) => (put(parts.found), show({ begin, spot: "" })));
  },
  (error) => put(parts.status, problem(error)),
);

/* the place that is looked at */

/** The place of the address; without one, that of the present design. */
function placed() {
  if (!asked.value || dragging || !branches.length || (view.spot && spot && view.spot === kept(spot))) return;
  const { name, from, to } = asked.value.axis;
  const [value, phase] = view.spot.split(",").map(Number);
  const isPlace = view.spot && Number.isFinite(value) && Number.isFinite(phase);
  const wish = isPlace ? [value, phase] : [present(data, name) ?? from, phaseNow() ?? 0];
  const place = placeNear(branches, wish[0], wish[1], to - from || 1);
  if (!spot || place.branch !== spot.branch || Math.abs(place.along - spot.along) > 1e-9) look(place, false);
}

/** The impact phase of the motion of the head. @returns {number | undefined} */
const phaseNow = () => chosen()?.quick.phase_b77 ?? chosen()?.quick.phase;

/** A place as the address keeps it. @param {Place} place */
function kept({ branch, along }) {
  const { value, times } = rowAt(branches[branch], along);
  return `${plainNumber(value, 6)},${plainNumber(phaseOf(times[0]), 6)}`;
}

/** Look at a place: its motion plays; the address keeps it when the user has chosen it. @param {Place | null} place */
function look(place, told = true) {
  if (!place || !asked.value) return;
  const { branch, along: here } = place;
  spot = { branch, along: here };
  const { label: motion, periods } = branches[branch];
  const row = rowAt(branches[branch], here);
  const { tables, axis, modes } = asked.value;
  showMotion({ tables, along: axis, row, motion, periods, modes });
  const stable = row.stable === null ? "at the border of stability" : row.stable ? "stable" : "unstable";
  const value = withUnit(row.value, axis.unit, 5);
  put(parts.readout, `${motion} at ${axis.label.replace(/ \[.*/, "")} = ${value}: ${stable}.`);
  chart.canvas.dataset.spot = `${branch},${here}`;
  over();
  if (told) show({ spot: kept(spot) });
}

const over = () => chart.over(spotted(branches, spot, rising()));

/** @param {number} branch @param {any} point */
function goTo(branch, point) {
  look(placeOf(branches, branch, point));
  chart.canvas.scrollIntoView({ block: "nearest" });
}

/** The hammer moved to the value of the place. @param {number} value */
const carry = (value) => asked.value && move({ [asked.value.axis.name]: plainNumber(value, 6) });

/* the picture */

let repaint = () => {};

function paint() {
  if (!ready()) return;
  const axis = asked.value?.axis ?? along();
  const now = present(data, axis.name);
  const up = rising();
  const height = { phase: phaseNow(), speed: chosen()?.quick.impact_velocity }[up];
  const design = now === undefined ? null : { x: now, y: height ?? null };
  const { from, to } = view.alongr || view.every || !branches.length ? askedRange(axis) : reached(now);
  const isSI = data.machine?.units === "SI";
  chart.draw(diagram(drawn, { label: axis.label, from, to, isSI }, up, design, settledDots(up)));
  const { canvas, frame, spec } = chart;
  const { scale } = theme();
  if (design) canvas.dataset.design = `${design.x}`;
  if (frame && spec) {
    const { left, right, top, bottom } = frame;
    const { x, y } = spec;
    const ends = { x: [left * scale, right * scale, x.from, x.to], y: [top * scale, bottom * scale, y.from, y.to] };
    canvas.dataset.frame = JSON.stringify(ends);
  }
  over();
}

/** How far the branches reach, and the present design, with some room. @param {number} [now] */
function reached(now) {
  const values = branches.flatMap(({ rows }) => rows.map(({ value }) => value));
  const [from, to] = span([values, now === undefined ? [] : [now]], 0.03);
  return { from, to };
}

/** @param {HTMLCanvasElement} canvas */
function pointer(canvas) {
  const place = (/** @type {MouseEvent} */ event, /** @type {number} */ only = NaN) => {
    const { frame } = chart;
    const point = chart.at(event, true) ?? { x: NaN, y: NaN };
    const at = { x: frame?.px(point.x) ?? NaN, y: frame?.py(point.y) ?? NaN };
    return placeAt(branches, RISING[rising()], frame, at, Number.isNaN(only) ? null : only);
  };
  const near = (/** @type {MouseEvent} */ event) => {
    const found = branches.length && chart.at(event) ? place(event) : null;
    return found && found.far <= NEAR ? found : null;
  };
  canvas.addEventListener("click", (event) => {
    if (/** @type {PointerEvent} */ (event).pointerType === "touch") look(near(event));
  });
  canvas.addEventListener("pointerdown", (event) => {
    const found = event.pointerType === "touch" ? null : near(event); // a finger that swipes moves the page
    if (!found) return;
    dragging = true;
    canvas.setPointerCapture(event.pointerId);
    look(found);
  });
  const drag = framed((/** @type {PointerEvent} */ event) => dragging && spot && look(place(event, spot.branch)));
  canvas.addEventListener("pointermove", drag);
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (dragging = false));
}

/** @param {any} event */
function keys(event) {
  if (event.key === " " && !event.target.closest("button, select, input:not([type=range])")) {
    event.preventDefault();
    return toggleBranch();
  }
  if (event.target !== chart.canvas || !spot) return;
  const { branch, along: here } = spot;
  const last = branches[branch].rows.length - 1;
  const step = event.shiftKey ? 2 : 0.25;
  /** @type {Record<string, [number, number]>} */
  const ways = {
    ArrowRight: [branch, Math.min(here + step, last - ASIDE)],
    ArrowLeft: [branch, Math.max(here - step, ASIDE)],
    Home: [branch, ASIDE],
    End: [branch, last - ASIDE],
    ArrowUp: branch + 1 < branches.length ? [branch + 1, 0.5] : [branch, here],
    ArrowDown: branch > 0 ? [branch - 1, 0.5] : [branch, here],
  };
  const to = ways[event.key];
  if (!to) return;
  event.preventDefault();
  look({ branch: to[0], along: to[1] });
}
