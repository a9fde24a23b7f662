// The motion: the bar in slow motion, its striking end over time, its phase portrait and the impacts as points; of a
// steady motion, or of a simulation from any start. Each blow is heard when sound is on.

import { postBinary } from "../core/api.js";
import { button, div, framed, h, labelled, latest, problem, put, settled } from "../core/dom.js";
import { counted, number, plainNumber, si, withUnit } from "../core/format.js";
import { effect, signal, whenever } from "../core/signals.js";
import {
  asked,
  chosen,
  data,
  isHeld,
  mover,
  obstacleOf,
  setStart,
  show,
  switchesItself,
  uptodate,
  view,
} from "../core/state.js";
import { forgetBlows, tellBlow } from "../map/blows_inset.js";
import { contactHappened, contactInset, showContact } from "./contact_inset.js";
import { grab, LiveStage } from "./live_stage.js";
import { blowsOf, drawCharts, followCharts, motionCharts, unitsOf } from "./motion_charts.js";
import { sourceCard, sourceProblems } from "./motion_source.js";
import { Player } from "./player.js";
import { heardAs } from "./sound.js";
import { pushOf, shapeOfCase } from "./stage.js";
import { Strip } from "./strip.js";

export const defaults = {
  source: "orbit",
  window: "settled",
  slow: "",
  grow: "1",
  cycles: 1,
  contact: 0, // 1: the contact is magnified over the stage
  zoom: 0, // periods of the first elastic mode that are shown after the begin; 0: the whole stretch
};

const TURN = 2 * Math.PI;
const USUAL = 0.8; // seconds that a load period takes at first: slow enough to look, fast enough to hear its rhythm

const canvas = h("canvas", { id: "stage", role: "img", "aria-label": "What moves, and the wall" });
const stage = new LiveStage(canvas, { ticked, struck, happened: contactHappened });
const player = new Player(stage, { about: "Time in the motion", slow: "slow", moved: knobs });
const charts = motionCharts(startThere);
const strip = new Strip("strip", charts.history);
const oninput = () => (show({ grow: grow.value }), knobs(), stage.draw());
const grow = h("input", { type: "range", id: "grow", min: 0, max: 4, step: 0.05, oninput });
const grown = h("span", { class: "small muted", id: "grown" });
const facts = h("dl", { class: "figures", id: "motion-facts" });
const heard = h("dd", { id: "heard" }, "–");
const status = h("p", { class: "small muted", id: "motion-status", role: "status" });
/** What this motion leaves out, and where it is shown. */
const instantaneous = h(
  "p",
  { class: "small muted", id: "motion-instant" },
  "The contact takes no time here: each blow is instantaneous. ",
  button("See one blow by its waves", () => show({ panel: "blow" }), { class: "link" }),
);
/** What the server has told of the motion, and its units. */
const told = signal(
  /** @type {{ motion: import("./stage.js").Motion, units: import("./motion_charts.js").Units } | null} */ (null),
);
let key = ""; // of the motion that is wanted
let hammer = ""; // that the stage has
let shownOrbit = ""; // which of its motions
let ruled = -1; // of which change of the case its law is

/** What of it stands on the screen, and what in the drawer of all motions. */
export function startMotion() {
  const { history, portrait, poincare } = charts;
  const portraits = div("grid", portrait, poincare);
  whenever(() => data.quick?.changed, law);
  effect(() => stage.beside("A", data.pinned?.model, data.pinned?.orbit));
  effect(() => stage.beside("there", data.ghost?.model, data.ghost?.orbit));
  grab(stage);
  effect(want, (run) => settled(run, 60));
  effect(() => void (data.problems.length && sourceProblems(data.problems)));
  effect(() => {
    if (!data.tables) return;
    showContact(Boolean(view.contact));
    followStrip();
    if (!inSight()) return player.stop();
    another();
    knobs();
  });
  effect(() => void (told.value && drawCharts(told.value.motion, told.value.units)));
  const stretch = [labelled("Stretch", grow), grown];
  const details = [sourceCard(status), status, div("row", stretch), facts, portraits, instantaneous];
  return {
    stage: [div("stage", canvas, contactInset()), player.rows()],
    strip: [history, strip.figure],
    toggle: () => player.toggle(),
    portrait,
    portraits,
    details: h("div", { class: "stack", id: "motion-details" }, details),
  };
}

/** Whether it is what the screen shows. */
const inSight = () => !switchesItself() && view.panel !== "blow";

/** The pace and the stretch as the view has them: a load period takes from real time (or a second) to minutes. */
function knobs() {
  if (!stage.there) return;
  const second = data.info?.scales?.time_s;
  const real = second ? TURN * second : 1;
  const part = TURN / stage.length; // of a zoom that lasts some seconds, a load period takes hours
  const span = view.zoom ? { usual: 8 * part, longest: 30 * part } : { usual: Math.max(USUAL, real), longest: 120 };
  stage.rate = TURN / player.paced(view.slow, { real, ...span }, data.info?.scales ? "" : "period");
  stage.grow = Number(view.grow) || 0;
  if (document.activeElement !== grow) grow.value = view.grow;
  put(grown, stage.magnified());
}

// ---- The live motion

/** The law of the present case, under which the hammer goes on; another hammer begins on its motion. */
function law() {
  const { quick } = data;
  if (!quick || !inSight() || view.source !== "orbit") return;
  stage.force = force();
  const one = [view.machine, view.lesson, view.scene, data.begin.count, isHeld()].join();
  if (quick.changed === ruled && one === hammer) return;
  ruled = quick.changed;
  if (one !== hammer) stage.forget();
  stage.under(quick.motion);
  stage.looks(shapeOfCase(), stage.places);
  if (one !== hammer || !stage.live) {
    hammer = one;
    shownOrbit = "";
    forgetBlows();
    if (data.begin.state) {
      stage.put(data.begin.state); // a scene has a place of its own, in sight of the motion that it is about
      shownOrbit = orbitNow();
    }
  }
  another();
  const now = chosen()?.quick; // an unstable motion goes on as a dashed line, and the hammer leaves it
  stage.beside("unstable", now && !now.stable ? quick.motion : null, now);
  knobs();
  player.begin();
}

const orbitNow = () => [hammer, view.m, view.orbit].join();

/** Another motion was chosen: the hammer is put on it, and a hair's breadth beside it where it cannot stay. */
function another() {
  const orbit = /** @type {any} */ (chosen()?.quick);
  if (!orbit || !stage.live || orbitNow() === shownOrbit || view.source !== "orbit") return;
  shownOrbit = orbitNow();
  const { restitution, motion: model } = data.quick;
  stage.beside("unstable", orbit.stable ? null : model, orbit);
  if (orbit.stable) stage.put({ gap: 0, velocity: -restitution * orbit.impact_velocity, phase: orbit.phase });
  else stage.leave(orbit, restitution);
}

/** The load that is drawn, from the curve that the server gave. */
const force = () => pushOf(data.quick?.curve?.load);

// ---- The motion of the server

function want() {
  if (!inSight() || data.problems.length || !uptodate()) return;
  const orbit = chosen()?.number;
  const steady = view.source === "orbit";
  const of = steady ? { orbit } : { show: view.window };
  const now = JSON.stringify([data.changed, view.m, of, view.cycles, view.zoom]);
  if (now === key) return;
  key = now;
  if (steady && !orbit)
    return put(status, `There is no steady motion: what plays is what the ${mover()} does instead.`);
  put(status, "Computing …");
  const body = {
    ...asked(),
    ...of,
    ...(view.zoom && data.info && { window: [0, (view.zoom * TURN) / data.info.first_mode] }),
    cycles: view.cycles,
    frames: Math.min(2000, 1200 + 100 * view.cycles),
    places: 33,
    end_points: Math.min(20000, 1500 * view.cycles),
  };
  askMotion({ body, change: data.changed });
}

const askMotion = latest(
  (/** @type {{ body: Record<string, any>, change: number }} */ { body }) => postBinary("motion", body),
  (found, { change }) => {
    sourceProblems(data.problems); // of a later start, when this is a late answer to the one before
    take(found);
    data.played = { motion: { label: found.label, summary: found.summary }, change };
    canvas.dataset.change = String(change); // of the case, as it is drawn
  },
  (error) => {
    data.played = null;
    if (error.status !== 422) key = ""; // the same question would be refused again
    player.stop();
    put(status, sourceProblems(error.problems ?? []) ? "See the start above." : problem(error));
  },
);

/** @param {import("./stage.js").Motion} found */
function take(found) {
  told.value = { motion: found, units: unitsOf(found) };
  const { arrays, modes, label } = found;
  const steady = found.source === "orbit" ? chosen() : null;
  const possible = steady && !obstacleOf(steady);
  if (steady && !possible) stage.beside("unstable", null);
  if (!possible) stage.show(found, force(), shapeOfCase());
  else if (steady.quick.stable) stage.settle(found, force(), shapeOfCase(), steady.quick);
  knobs();
  fillFacts(found);
  const blows = counted(blowsOf(found).length, "blow");
  canvas.setAttribute("aria-label", `The ${mover()} and the wall: ${label}, ${blows} in view`);
  Object.assign(canvas.dataset, { label, modes });
  instantaneous.hidden = isHeld(); // no blow of it is resolved by waves
  const words = isHeld() ? counted(modes, "mode") : `${modes} elastic modes`;
  const steps = `${arrays.displacement.shape[0]} frames of ${arrays.x.length} places, ${words}`;
  const leaves =
    found.source === "orbit" && !kept()
      ? `This steady motion is unstable: the least disturbance grows, and the ${isHeld() ? "structure" : "hammer"} leaves the motion. Choose “From a start” to see what it does instead. `
      : "";
  put(status, `${leaves}${steps}. Space plays and pauses; the arrow keys on the time slider step.`);
  if (inSight()) player.begin();
}

/** @type {Record<string, string>} */
const ENDS = {
  periodic: "when it repeated",
  rest: "at rest for good",
  departed: "off the wall for good",
  impacts: "after the impacts asked for",
  time: "after the time asked for",
  work: "after the work allowed",
  unresolved: "when it was released a second time in the same state",
};

/** Whether the steady motion that is shown is stable. */
const kept = () => Boolean(chosen()?.quick.stable);

/** @param {import("./stage.js").Motion} motion */
function fillFacts({ label, outcome, begin, end, time_scale_s: second, first_mode_Hz, first_mode, ...motion }) {
  const struck = blowsOf({ begin, end, ...motion });
  const last = struck[struck.length - 1];
  const energy = last && (last.energy_J ?? null) !== null ? si(last.energy_J, "J") : number(last?.energy);
  const time = second ? si((end - begin) * second, "s", 3) : withUnit(end - begin, "rad", 3);
  const mode = first_mode_Hz ? si(first_mode_Hz, "Hz", 3) : `${number(first_mode, 3)} per rad`;
  put(heard, "–");
  const rows = [
    ["motion", label],
    outcome ? ["the simulation ended", ENDS[outcome] ?? outcome] : ["steady motion", kept() ? "stable" : "unstable"],
    ["shown", `${time}, ${counted((end - begin) / TURN, "load period")}`],
    ["blows in view", String(struck.length)],
    ["delivered by the last blow", energy],
    [isHeld() ? "first mode" : "first elastic mode", mode],
  ];
  const cells = rows.map(([name, value]) => h("div", {}, h("dd", {}, value), h("dt", {}, name)));
  put(facts, cells, h("div", {}, heard, h("dt", {}, "heard")));
}

/** A simulation from a point of the phase portrait, at the moment of the load that is shown.
 * @param {{ x: number, y: number }} at */
function startThere({ x, y }) {
  if (!told.value) return;
  const { motion, units } = told.value;
  const phase = (((motion.load_phase + stage.time) % TURN) + TURN) % TURN;
  const position = Math.min(0, plainNumber(x / units.length.k));
  setStart({ position, velocity: plainNumber(y / units.speed.k), time: plainNumber(phase) });
  show({ source: "start", window: "start", cycles: Math.max(view.cycles, 8), zoom: 0 });
}

// ---- As it plays

const pitch = () => data.info?.bar?.first_mode_Hz ?? told.value?.motion.first_mode_Hz;

/** @param {number} time */
function ticked(time) {
  stage.sounds(pitch(), data.info?.scales?.energy_J);
  followStrip();
  tellLabel();
  (stage.playing ? cursor : shown)(time); // within a frame of its own while it plays
}

/** @param {number} time */
function cursor(time) {
  if (!inSight()) return;
  const { time: unit } = told.value?.units ?? { time: { k: 1, name: "rad" } };
  player.tellMoment(time, { time: unit }, unit.k * stage.length < 0.1 ? 5 : 3);
  if (told.value && stage.exact) followCharts(told.value.motion, told.value.units, time);
}

const shown = framed(cursor);

let toldAt = 0; // when its label was

/** What goes on is told a few times a second, when it is of the present law. */
function tellLabel() {
  const { live, exact } = stage;
  const when = performance.now();
  if (when - toldAt < 250 || ruled !== data.changed || !live) return;
  toldAt = when;
  data.label = exact ? (told.value?.motion.label ?? "") : live.label();
  data.blows = exact || !live.struck ? [] : live.blows.slice(-live.struck).map(({ speed }) => speed);
}

/** @param {any} event */
function struck(event) {
  if (event.speed !== undefined) tellBlow(event);
  else if (told.value) tellBlow({ phase: told.value.motion.load_phase + event.time, speed: event.impact_velocity });
  const scale = data.info?.scales?.energy_J;
  const energy = event.energy_J ?? (scale ? event.energy * scale : null);
  put(heard, heardAs({ frequency: pitch(), energy, share: stage.share(event) }));
}

/** The strip tells what the stage has shown. */
function followStrip() {
  const how = { shown: view.source === "orbit", length: data.info?.scales?.length_m, period: TURN };
  strip.follow(stage, { ...how, name: "periods of the load ago" });
}
