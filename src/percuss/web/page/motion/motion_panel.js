// The motion: the bar in slow motion, its striking end over time, its phase portrait and the impacts as points; of a
// steady motion, or of a simulation from any start. Each blow is heard when sound is on.

import { postBinary } from "../core/api.js";
import { $, framed, h, latest, put, settled } from "../core/dom.js";
import { counted, number, plainNumber, si, withUnit } from "../core/format.js";
import { blowsOf, drawCharts, followCharts, motionCharts, unitsOf } from "./motion_charts.js";
import { begin, knobs, moment, player, stop, toggle } from "./motion_player.js";
import { sourceCard, sourceProblems, sources } from "./motion_source.js";
import { setStart } from "./motion_start.js";
import { asked, chosen, data, isHeld, mover, on, show, switchesItself, tell, uptodate, view } from "../core/state.js";
import { follow, heardAs, hush, lag } from "./sound.js";
import { Stage } from "./stage.js";

export const panel = {
  name: "motion",
  title: "Motion",
  defaults: {
    source: "orbit",
    window: "settled",
    slow: "",
    grow: "1",
    cycles: 1,
    zoom: 0, // periods of the first elastic mode that are shown after the begin; 0: the whole stretch
  },
  needs: { curve: 121, multipliers: false },
  clocked: "Steady motions and starts under a clocked load are shown here; this machine has no clock. Its cycle plays in the panel Machine.",
  start: startMotion,
};

const parts = {};
let motion = null;
let units = null;
let key = "";

function startMotion(panel) {
  const canvas = h("canvas", { id: "stage", role: "img", "aria-label": "What moves, and the wall" });
  parts.stage = new Stage(canvas, { ticked, struck, stopped: hush, lag });
  parts.facts = h("dl", { class: "figures", id: "motion-facts" });
  parts.status = h("p", { class: "small muted", id: "motion-status", role: "status" });
  put(
    panel,
    sourceCard((words) => put(parts.status, words)),
    h("div", { class: "card stage" }, canvas, player(parts.stage), parts.status, instantaneous()),
    h("div", { class: "card" }, parts.facts),
    motionCharts(startThere),
  );
  panel.addEventListener("keydown", keys);
  on("info", () => (sources(), want()));
  on("quick", () => motion && (parts.stage.force = force()));
  on("quick steady tables", want);
  on("tables", () => switchesItself() && stop());
  on("problems", () => view.panel === "motion" && data.problems.length && sourceProblems(data.problems));
  on("view", () => (view.panel === "motion" ? (sources(), want(), knobs()) : parts.stage.pause()));
  on("theme", () => (motion && drawCharts(motion, units), parts.stage.draw()));
  document.addEventListener("visibilitychange", () => document.hidden && parts.stage.pause());
}

/** What this motion leaves out, and where it is shown. */
const instantaneous = () =>
  h(
    "p",
    { class: "small muted", id: "motion-instant" },
    "The contact takes no time here: each blow is instantaneous. ",
    h("button", { type: "button", class: "link", onclick: () => show({ panel: "blow" }) }, "See one blow by its waves"),
  );

function keys(event) {
  if (event.key !== " " || event.target.closest("button, select, input:not([type=range])")) return;
  event.preventDefault();
  toggle();
}

const want = settled(() => {
  if (view.panel !== "motion" || data.problems.length || !uptodate()) return;
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
  if (view.source === "orbit" && !number_) {
    stop();
    return put(
      parts.status,
      `There is no steady motion to show. Choose “From a start” to see what the ${mover()} does instead.`,
    );
  }
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
  parts.stage.show(motion, force(), data.info?.bar?.sections);
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
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches && view.panel === "motion") begin();
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
  if (motion) follow(parts.stage, motion.first_mode_Hz);
  (parts.stage.playing ? cursor : shown)(time); // within a frame of its own while it plays
}

function struck(event) {
  const place = $("#heard");
  const about = { frequency: motion.first_mode_Hz, energy: event.energy_J, share: parts.stage.share(event) };
  if (place) put(place, heardAs(about));
  parts.stage.canvas.dataset.blows = String(Number(parts.stage.canvas.dataset.blows ?? 0) + 1);
}

function cursor(time) {
  if (!motion || view.panel !== "motion") return;
  moment(time, units);
  followCharts(motion, units, time);
}
