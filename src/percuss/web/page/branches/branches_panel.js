// Branches: the steady motion followed through a parameter, with all that happens on the way. A click on a branch shows
// and sounds the motion there; the place can be dragged along it, or moved by the arrow keys.

import { post } from "../core/api.js";
import { Chart, span } from "../pictures/chart.js";
import { along, askedRange, beginning, branchChoices, rests, rising } from "./branches_choices.js";
import { eventTable, orbitList } from "./branches_events.js";
import { motionCard, noMotion, pauseBranch, showMotion, toggleBranch } from "./branches_motion.js";
import { everyRow, impossible, others, stopEvery, wantEvery } from "./branches_every.js";
import { diagram, spotted } from "./branches_picture.js";
import { branchesOf } from "./branches_rows.js";
import { settledDots, settledHeights, settledRow, stopSettled, wantSettled } from "./branches_settled.js";
import { ASIDE, RISING, placeAt, placeNear, placeOf, rowAt } from "./branches_walk.js";
import { framed, h, latest, put, settled } from "../core/dom.js";
import { plainNumber, withUnit } from "../core/format.js";
import { present } from "../core/moves.js";
import { REST, chosen, data, isHeld, modesInWords, move, on, show, switchesItself, view } from "../core/state.js";

const NEAR = 40; // pixels within which a click takes the branch
const parts = {};
let key = "";
let drawn = { followed: [], others: [], thin: [] };
let branches = []; // all that can be looked at: what was followed, then the others of the diagram
let asked = null; // the question it answers: {tables, along, modes}
let spot = null; // {branch, along}
let since = 0; // the last change of the case that is not a move through the parameter
let dragging = false;

export function start(section) {
  parts.chart = new Chart("Branches of motions", { kind: "map", role: "application", about: "Branches of motions" });
  const { canvas } = parts.chart;
  Object.assign(canvas, { tabIndex: 0, id: "branches" });
  parts.choice = h("div", { class: "row" });
  parts.readout = h("p", { class: "small", id: "branches-readout", "aria-live": "polite" });
  parts.status = h("p", { class: "small muted", id: "branches-status", role: "status" });
  parts.events = h("div", { class: "card scroll", id: "branches-events" });
  parts.found = h("div", { class: "card scroll", id: "branches-found" });
  put(
    section,
    h("div", { class: "card" }, parts.choice),
    parts.found,
    h("div", { class: "grid" }, h("div", { class: "card" }, parts.chart.figure, parts.readout, everyRow(more), settledRow(repaint), parts.status), motionCard(carry)),
    parts.events,
  );
  pointer(canvas);
  section.addEventListener("keydown", keys);
  on("tables", () => {
    if (!moveOnly()) {
      since = data.changed;
      stopAll(); // of another hammer: sliders come first
    }
  });
  on("info view quick", () => ready() && (branchChoices(parts.choice, search), want(), placed()));
  on("view", () => view.panel !== "branches" && (pauseBranch(), stopAll()));
  on("tables quick view theme", repaint);
  document.addEventListener("visibilitychange", () => document.hidden && pauseBranch());
}

const stopAll = () => (stopEvery(), stopSettled());

const ready = () => view.panel === "branches" && Boolean(data.info) && Boolean(data.info.system) !== switchesItself();

/** Whether the last change of the case moved through the parameter of the diagram: that stays the same. */
const moveOnly = () => data.info && data.moved?.length === 1 && data.moved[0] === along().name && view.panel === "branches";

/** Ask for the branches of the case as it is now, unless they are under way or there. */
const want = settled(() => {
  if (!ready() || data.problems.length || (data.quick ?? data.machine)?.changed !== data.changed) return;
  const axis = along();
  const begin = beginning();
  const now = JSON.stringify([since, axis.name, axis.from, axis.to, view.begin || [view.m, view.orbit], view.depth, view.bmodes]);
  if (now === key) return simulated();
  if (!begin) return nothing("There is no steady motion to begin with: choose another one under “Other motions”, or move a slider.");
  key = now;
  put(parts.status, "Following …");
  askBranches({ tables: data.tables, axis, begin, depth: rests(begin) ? 0 : view.depth, modes: view.bmodes, now });
}, REST);

const askBranches = latest(
  ({ tables, axis, begin, depth, modes }) =>
    post("follow", { case: tables, along: askedRange(axis), orbit: begin, switch: depth, modes }),
  (found, question) => {
    if (question.now !== key) return;
    asked = question;
    spot = null;
    renew(branchesOf(found));
    const { dataset } = parts.chart.canvas;
    dataset.branches = drawn.followed.map(({ label }) => label).join();
    const stopped = drawn.followed.some(({ points }) => points.some(({ type }) => type === "stopped"));
    put(parts.status, stopped ? "It took too long: this is what was followed so far." : `${modes(question.modes)} Click on a branch, drag along it, or use the arrow keys.`);
    placed();
    simulated();
    repaint();
  },
  (error, question) => {
    if (question.now !== key) return;
    if (error.status !== 422) key = ""; // the same question would be refused again
    nothing(h("span", { class: "problem", role: "alert" }, error.message));
  },
);

const modes = (n) => (n || isHeld() ? `With ${modesInWords(n)}.` : "Of a rigid bar.");

/** Other branches are those that were followed. */
function renew(followed) {
  drawn = { followed, others: others(followed), thin: impossible() };
  branches = [...drawn.followed, ...drawn.others];
  if (branches.length) asked ??= { tables: data.tables, axis: along(), modes: view.bmodes };
  if (spot && !branches[spot.branch]) spot = null;
  parts.chart.canvas.dataset.others = String(drawn.others.length);
  eventTable(parts.events, drawn, asked?.axis, goTo);
}

/** There are more branches in the diagram, or none any more. */
function more() {
  renew(drawn.followed);
  placed();
  repaint();
}

function nothing(words) {
  asked = spot = null;
  renew([]);
  delete parts.chart.canvas.dataset.branches;
  put(parts.readout);
  put(parts.status, words);
  if (!branches.length) noMotion("");
  simulated();
  placed();
  repaint();
}

/** All branches, and simulations over what the diagram shows, where they are wanted. */
function simulated() {
  if (view.panel !== "branches") return; // an answer that comes late asks for nothing more
  const { name, unit, from, to } = askedRange(along());
  const question = { name, unit, modes: view.bmodes, now: since };
  wantEvery({ ...question, from, to });
  const seen = view.alongr || view.every || !branches.length ? { from, to } : reached();
  wantSettled({ ...question, from: Math.max(from, seen.from), to: Math.min(to, seen.to) });
}

/* the orbits of another label */

const search = latest(
  (label) => (put(parts.status, `Searching ${rests(label) ? label : `z=${label}`} …`), post("orbits", { case: data.tables, label, modes: view.bmodes })),
  (found) => (put(parts.status, ""), orbitList(parts.found, found, (begin) => (put(parts.found), show({ begin, spot: "" })))),
  (error) => put(parts.status, h("span", { class: "problem", role: "alert" }, error.message)),
);

/* the place that is looked at */

/** The place of the address; without one, that of the present design. */
function placed() {
  if (!asked || dragging || !branches.length) return;
  const now = spot && kept();
  if (view.spot && view.spot === now) return;
  const [value, phase] = view.spot.split(",").map(Number);
  const design = { value: present(data, asked.axis.name) ?? asked.axis.from, phase: phaseNow() ?? 0 };
  const wish = view.spot && Number.isFinite(value) && Number.isFinite(phase) ? { value, phase } : design;
  const place = placeNear(branches, wish.value, wish.phase, asked.axis.to - asked.axis.from || 1);
  if (!spot || place.branch !== spot.branch || Math.abs(place.along - spot.along) > 1e-9) look(place, false);
}

/** The impact phase of the motion of the head. */
const phaseNow = () => chosen()?.quick.phase_b77 ?? chosen()?.quick.phase;

/** The place as the address keeps it. */
function kept() {
  const { value, times } = rowAt(branches[spot.branch], spot.along);
  const turn = 2 * Math.PI;
  return `${plainNumber(value, 6)},${plainNumber(((times[0] % turn) + turn) % turn, 6)}`;
}

/** Look at a place: its motion plays; the address keeps it when the user has chosen it. */
function look(place, told = true) {
  if (!place || !asked) return;
  spot = { branch: place.branch, along: place.along };
  const branch = branches[spot.branch];
  const row = rowAt(branch, spot.along);
  showMotion({ tables: asked.tables, along: asked.axis, row, motion: branch.label, periods: branch.periods, modes: asked.modes });
  tell(branch, row);
  over();
  if (told) show({ spot: kept() });
}

function tell(branch, row) {
  const { label, unit, name } = asked.axis;
  const stable = row.stable === null ? "at the border of stability" : row.stable ? "stable" : "unstable";
  put(parts.readout, `${branch.label} at ${name === asked.axis.name ? label.replace(/ \[.*/, "") : name} = ${withUnit(row.value, unit, 5)}: ${stable}.`);
  parts.chart.canvas.dataset.spot = `${spot.branch},${spot.along}`;
}

const over = () => parts.chart.over(spotted(branches, spot, rising()));

function goTo(branch, point) {
  look(placeOf(branches, branch, point));
  parts.chart.canvas.scrollIntoView({ block: "nearest" });
}

/** The hammer moved to the value of the place. */
const carry = (value) => asked && move({ [asked.axis.name]: plainNumber(value, 6) });

/* the picture */

const repaint = framed(() => {
  if (!ready()) return;
  const axis = asked?.axis ?? along();
  const now = present(data, axis.name);
  const up = rising();
  const height = { phase: phaseNow(), speed: chosen()?.quick.impact_velocity }[up];
  const design = now === undefined ? null : { x: now, y: height ?? null };
  const range = view.alongr || view.every || !branches.length ? askedRange(axis) : reached(now);
  const settled = { dots: settledDots(up), heights: settledHeights(up) };
  parts.chart.draw(diagram(drawn, { label: axis.label, from: range.from, to: range.to, isSI: data.machine?.units === "SI" }, up, design, settled));
  const { canvas, frame, spec, scale } = parts.chart;
  if (design) canvas.dataset.design = `${design.x}`;
  if (frame) {
    const { left, right, top, bottom } = frame;
    const pixels = (...list) => list.map((one) => one * scale);
    canvas.dataset.frame = JSON.stringify({ x: [...pixels(left, right), spec.x.from, spec.x.to], y: [...pixels(top, bottom), spec.y.from, spec.y.to] });
  }
  over();
});

/** How far the branches reach, and the present design, with some room. */
function reached(now = undefined) {
  const [from, to] = span([branches.flatMap(({ rows }) => rows.map(({ value }) => value)), now === undefined ? [] : [now]], 0.03);
  return { from, to };
}

function pointer(canvas) {
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: (event.clientX - box.left) / parts.chart.scale, y: (event.clientY - box.top) / parts.chart.scale };
  };
  const place = (event, only) => placeAt(branches, RISING[rising()], parts.chart.frame, at(event), only);
  const drag = framed((event) => dragging && look(place(event, spot.branch)));
  const near = (event) => {
    if (!branches.length || !parts.chart.at(event)) return null;
    const found = place(event);
    return found.far > NEAR ? null : found;
  };
  canvas.addEventListener("click", (event) => event.pointerType === "touch" && look(near(event)));
  canvas.addEventListener("pointerdown", (event) => {
    const found = event.pointerType === "touch" ? null : near(event); // a finger that swipes moves the page
    if (!found) return;
    dragging = true;
    canvas.setPointerCapture(event.pointerId);
    look(found);
  });
  canvas.addEventListener("pointermove", drag);
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (dragging = false));
}

function keys(event) {
  if (event.key === " " && !event.target.closest("button, select, input:not([type=range])")) {
    event.preventDefault();
    return toggleBranch();
  }
  if (event.target !== parts.chart.canvas || !spot) return;
  const { branch, along: here } = spot;
  const last = branches[branch].rows.length - 1;
  const step = event.shiftKey ? 2 : 0.25;
  const next = branches.length - 1;
  const to = {
    ArrowRight: () => ({ branch, along: Math.min(here + step, last - ASIDE) }),
    ArrowLeft: () => ({ branch, along: Math.max(here - step, ASIDE) }),
    Home: () => ({ branch, along: ASIDE }),
    End: () => ({ branch, along: last - ASIDE }),
    ArrowUp: () => ({ branch: Math.min(branch + 1, next), along: branch < next ? 0.5 : here }),
    ArrowDown: () => ({ branch: Math.max(branch - 1, 0), along: branch > 0 ? 0.5 : here }),
  }[event.key];
  if (!to) return;
  event.preventDefault();
  look(to());
}
