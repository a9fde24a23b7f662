// The motion: the bar in slow motion, its striking end over time, its phase portrait and the impacts as points; of a
// steady motion, or of a simulation from any start. Each blow is heard when sound is on.

import { postBinary } from "../core/api.js";
import { $, framed, h, latest, put, settled } from "../core/dom.js";
import { counted, number, plainNumber, si, withUnit } from "../core/format.js";
import { blowsOf, drawCharts, followCharts, motionCharts, unitsOf } from "./motion_charts.js";
import { begin, knobs, moment, player, stop, stretch, toggle } from "./motion_player.js";
import { sourceCard, sourceProblems, sources } from "./motion_source.js";
import { setStart } from "./motion_start.js";
import { asked, chosen, data, isHeld, mover, obstacleOf, on, show, switchesItself, tell, uptodate, view } from "../core/state.js";
import { heardAs } from "./sound.js";
import { contactHappened, contactInset, showContact } from "./contact_inset.js";
import { LiveStage } from "./live_stage.js";
import { shapeOfCase } from "./shape.js";
import { Strip } from "./strip.js";
import { forgetBlows, tellBlow } from "../map/blows_inset.js";
import { theme } from "../pictures/colours.js";

export const defaults = {
  source: "orbit",
  window: "settled",
  slow: "",
  grow: "1",
  cycles: 1,
  contact: 0, // 1: the contact is magnified over the stage
  zoom: 0, // periods of the first elastic mode that are shown after the begin; 0: the whole stretch
};

const parts = {};
let motion = null;
let units = null;
let key = "";

/** What of it stands on the screen, and what in the drawer of all motions. */
export function startMotion() {
  const canvas = h("canvas", { id: "stage", role: "img", "aria-label": "What moves, and the wall" });
  parts.stage = new LiveStage(canvas, { ticked, struck, happened: contactHappened });
  parts.facts = h("dl", { class: "figures", id: "motion-facts" });
  parts.status = h("p", { class: "small muted", id: "motion-status", role: "status" });
  const { history, portrait, poincare } = motionCharts(startThere);
  const portraits = h("div", { class: "grid" }, portrait, poincare);
  parts.strip = new Strip("strip", history);
  on("info", () => (sources(), want()));
  on("quick", law);
  on("pinned", pinned);
  on("ghost", () => parts.stage.beside("there", data.ghost?.model, data.ghost?.orbit));
  grab(canvas);
  on("quick steady tables", want);
  on("tables", () => switchesItself() && stop());
  on("problems", () => data.problems.length && sourceProblems(data.problems));
  on("view", () => showContact(Boolean(view.contact)));
  on("view", () => (parts.strip.follow(parts.stage, stripOf()), inSight() ? (sources(), another(), want(), knobs()) : parts.stage.pause()));
  on("theme", () => (motion && drawCharts(motion, units), parts.stage.draw()));
  document.addEventListener("visibilitychange", () => document.hidden && parts.stage.pause());
  return {
    stage: [h("div", { class: "stage" }, canvas, contactInset()), player(parts.stage)],
    strip: [history, parts.strip.figure],
    toggle,
    portrait,
    portraits,
    details: h(
      "div",
      { class: "stack", id: "motion-details" },
      sourceCard(parts.status),
      parts.status,
      h("div", { class: "row" }, stretch()),
      parts.facts,
      portraits,
      instantaneous(),
    ),
  };
}

let [hammer, shownOrbit, ruled] = ["", "", -1]; // which hammer the stage has, which of its motions, and of which change its law is

/** The law of the present case, under which the hammer goes on from where it is; another hammer begins on its motion. */
function law() {
  const { quick } = data;
  if (!quick || !inSight() || view.source !== "orbit") return;
  const { stage } = parts;
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
    if (data.begin.state) begun();
  }
  another();
  const now = chosen()?.quick; // an unstable motion goes on as a dashed line, and the hammer leaves it
  stage.beside("unstable", now && !now.stable ? quick.motion : null, now);
  knobs();
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) begin();
}

/** Another motion was chosen: the hammer is put on it, and a hair's breadth beside it where it cannot stay. */
function another() {
  const found = chosen();
  const one = [hammer, view.m, view.orbit].join();
  if (!found || !parts.stage.live || one === shownOrbit || view.source !== "orbit") return;
  shownOrbit = one;
  const { quick: orbit } = found;
  const { restitution } = data.quick;
  parts.stage.beside("unstable", orbit.stable ? null : data.quick.motion, orbit);
  if (orbit.stable) parts.stage.put({ gap: 0, velocity: -restitution * orbit.impact_velocity, phase: orbit.phase });
  else parts.stage.leave(orbit, restitution);
}

/** A scene has a place of its own for the hammer, in sight of the motion that it is about. */
function begun() {
  parts.stage.put(data.begin.state);
  shownOrbit = [hammer, view.m, view.orbit].join();
}

/** The design that is pinned as A moves beside the present one. */
const pinned = () => parts.stage.beside("A", data.pinned?.model, data.pinned?.orbit);

/** The bar taken by the hand, and let go. */
function grab(canvas) {
  const { stage } = parts;
  let last = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    const k = theme().scale;
    const scale = stage.scales(box.width / k, box.height / k);
    return { x: (event.clientX - box.left) / k, scale, when: performance.now() };
  };
  const gapOf = ({ x, scale }) => (x - last.offset - scale.wall) / scale.travel;
  canvas.addEventListener("pointerdown", (event) => {
    if (!stage.live || !stage.edges) return;
    const now = at(event);
    if (now.x < stage.edges[0] - 6 || now.x > stage.edges[1] + 6) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    last = { ...now, offset: now.x - stage.edges[1], speed: 0 };
    stage.held = true;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    const now = at(event);
    const gone = Math.max((now.when - last.when) / 1000, 1e-3) * stage.rate;
    const speed = Math.min(Math.max((now.x - last.x) / now.scale.travel / gone, -1), 1);
    stage.hold(gapOf(now));
    last = { ...now, offset: last.offset, speed };
  });
  for (const end of ["pointerup", "pointercancel"])
    canvas.addEventListener(end, (event) => {
      if (!last) return;
      stage.held = false;
      stage.hold(gapOf(at(event)), last.speed);
      last = null;
    });
}

/** Whether it is what the screen shows. */
const inSight = () => !switchesItself() && view.panel !== "blow";

/** What this motion leaves out, and where it is shown. */
const instantaneous = () =>
  h(
    "p",
    { class: "small muted", id: "motion-instant" },
    "The contact takes no time here: each blow is instantaneous. ",
    h("button", { type: "button", class: "link", onclick: () => show({ panel: "blow" }) }, "See one blow by its waves"),
  );

const want = settled(() => {
  if (!inSight() || data.problems.length || !uptodate()) return;
  const number_ = chosen()?.number;
  const now = JSON.stringify([
    data.changed,
    view.m,
    view.source,
    view.source === "orbit" ? number_ : view.window,
    view.cycles,
    view.zoom,
  ]);
  if (now === key) return;
  key = now;
  if (view.source === "orbit" && !number_)
    return put(parts.status, `There is no steady motion: what plays is what the ${mover()} does instead.`);
  const from = view.source === "orbit" ? { orbit: number_ } : { show: view.window };
  const rings = view.zoom && data.info ? { window: [0, (view.zoom * 2 * Math.PI) / data.info.first_mode] } : {};
  put(parts.status, "Computing …");
  const body = {
    ...asked(),
    ...from,
    ...rings,
    cycles: view.cycles,
    frames: Math.min(2000, 1200 + 100 * view.cycles),
    places: 33,
    end_points: Math.min(20000, 1500 * view.cycles),
  };
  askMotion({ body, change: data.changed });
}, 60);

const askMotion = latest(
  ({ body }) => postBinary("motion", body),
  (found, { change }) => {
    motion = found;
    sourceProblems(data.problems); // of a later start, when this is a late answer to the one before
    take();
    data.played = { motion: { label: motion.label, summary: motion.summary }, change };
    tell("played");
    parts.stage.canvas.dataset.change = String(change); // of the case, as it is drawn
  },
  (error) => {
    data.played = null;
    tell("played");
    if (error.status !== 422) key = ""; // the same question would be refused again
    stop();
    if (sourceProblems(error.problems ?? [])) return put(parts.status, "See the start above.");
    put(parts.status, h("span", { class: "problem", role: "alert" }, error.message));
  },
);

function take() {
  const { arrays } = motion;
  units = unitsOf(motion);
  const steady = motion.source === "orbit" ? chosen() : null;
  if (!steady) parts.stage.show(motion, force(), shapeOfCase());
  else if (obstacleOf(steady)) {
    parts.stage.beside("unstable", null);
    parts.stage.show(motion, force(), shapeOfCase());
  }
  else if (steady.quick.stable) parts.stage.settle(motion, force(), shapeOfCase(), steady.quick);
  knobs();
  drawCharts(motion, units);
  facts();
  parts.stage.canvas.setAttribute(
    "aria-label",
    `The ${mover()} and the wall: ${motion.label}, ${counted(blowsOf(motion).length, "blow")} in view`,
  );
  parts.stage.canvas.dataset.label = motion.label;
  $("#motion-instant").hidden = isHeld(); // no blow of it is resolved by waves
  parts.stage.canvas.dataset.modes = String(motion.modes);
  const steps = `${arrays.displacement.shape[0]} frames of ${arrays.x.length} places, ${isHeld() ? counted(motion.modes, "mode") : `${motion.modes} elastic modes`}`;
  const leaves =
    motion.source === "orbit" && !kept()
      ? `This steady motion is unstable: the least disturbance grows, and the ${isHeld() ? "structure" : "hammer"} leaves the motion. Choose “From a start” to see what it does instead. `
      : "";
  put(parts.status, `${leaves}${steps}. Space plays and pauses; the arrow keys on the time slider step.`);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches && inSight()) begin();
}

/** The load as a share of its greatest value, by phase, from the curve that the server gave. */
function force() {
  const load = data.quick?.curve?.load;
  if (!load) return null;
  const most = Math.max(...load.map(Math.abs)) || 1;
  return (phase) => {
    const share = ((phase % (2 * Math.PI)) + 2 * Math.PI) % (2 * Math.PI);
    return load[Math.round((share / (2 * Math.PI)) * (load.length - 1))] / most;
  };
}

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

function facts() {
  const { label, outcome } = motion;
  const length = motion.end - motion.begin;
  const seconds = length * (motion.time_scale_s ?? 1);
  const struck = blowsOf(motion);
  const last = struck.filter((b) => b.kind === "impact").at(-1);
  const time = motion.time_scale_s ? si(seconds, "s", 3) : withUnit(seconds, "rad", 3);
  const rows = [
    ["motion", label],
    outcome ? ["the simulation ended", ENDS[outcome] ?? outcome] : ["steady motion", kept() ? "stable" : "unstable"],
    ["shown", `${time}, ${counted(length / (2 * Math.PI), "load period")}`],
    ["blows in view", String(struck.length)],
    [
      "delivered by the last blow",
      last
        ? last.energy_J !== null && last.energy_J !== undefined
          ? si(last.energy_J, "J")
          : number(last.energy)
        : "–",
    ],
    [
      isHeld() ? "first mode" : "first elastic mode",
      motion.first_mode_Hz ? si(motion.first_mode_Hz, "Hz", 3) : `${number(motion.first_mode, 3)} per rad`,
    ],
    ["heard", "–"],
  ];
  put(
    parts.facts,
    rows.map(([name, value]) =>
      h("div", {}, h("dd", { id: name === "heard" ? "heard" : null }, value), h("dt", {}, name)),
    ),
  );
}

/** A simulation from a point of the phase portrait, at the moment of the load that is shown. */
function startThere({ x, y }) {
  if (!motion) return;
  const turn = 2 * Math.PI;
  const phase = (((motion.load_phase + parts.stage.time) % turn) + turn) % turn;
  const position = Math.min(0, plainNumber(x / units.length.k));
  setStart({ position, velocity: plainNumber(y / units.speed.k), time: plainNumber(phase) });
  show({ source: "start", window: "start", cycles: Math.max(view.cycles, 8), zoom: 0 });
}

const shown = framed(cursor);

function ticked(time) {
  parts.stage.sounds(data.info?.bar?.first_mode_Hz ?? motion?.first_mode_Hz, data.info?.scales?.energy_J);
  parts.strip.follow(parts.stage, stripOf());
  tellLabel();
  (parts.stage.playing ? cursor : shown)(time); // within a frame of its own while it plays
}

let labelled = 0;

/** What goes on is told a few times a second, when it is of the present law. */
function tellLabel() {
  const { live, exact } = parts.stage;
  const when = performance.now();
  if (when - labelled < 250 || ruled !== data.changed || !live) return;
  labelled = when;
  data.label = exact ? (motion?.label ?? "") : live.label();
  data.blows = exact || !live.struck ? [] : live.blows.slice(-live.struck).map(({ speed }) => speed);
}

function struck(event) {
  const { stage } = parts;
  if (event.speed !== undefined) tellBlow(event);
  else if (motion) tellBlow({ phase: motion.load_phase + event.time, speed: event.impact_velocity });
  const place = $("#heard");
  const scale = data.info?.scales?.energy_J;
  const energy = event.energy_J ?? (scale ? event.energy * scale : null);
  const about = { frequency: data.info?.bar?.first_mode_Hz ?? motion?.first_mode_Hz, energy, share: stage.share(event) };
  if (place) put(place, heardAs(about));
  stage.canvas.dataset.blows = String(Number(stage.canvas.dataset.blows ?? 0) + 1);
}

function cursor(time) {
  if (!inSight()) return;
  moment(time, units ?? PLAIN_UNITS);
  if (motion && parts.stage.exact) followCharts(motion, units, time);
}

/** How the strip tells what the stage has shown. */
const stripOf = () => ({ shown: view.source === "orbit", length: data.info?.scales?.length_m, period: TURN, name: "periods of the load ago" });

const TURN = 2 * Math.PI;
const PLAIN_UNITS = { time: { k: 1, name: "rad" } };
