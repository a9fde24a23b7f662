// The motion: the bar in slow motion, its striking end over time, its phase portrait and the impacts as points; of a
// steady motion, or of a simulation from any start. Each blow is heard when sound is on.

import { postBinary } from "./api.js";
import { $, framed, h, latest, put, settled } from "./dom.js";
import { number, plainNumber, si, withUnit } from "./format.js";
import { drawCharts, followCharts, motionCharts, unitsOf } from "./motion_charts.js";
import { setStart, sourceCard, sources } from "./motion_source.js";
import { asked, chosen, data, on, show, view } from "./state.js";
import { blow as heard } from "./sound.js";
import { Stage } from "./stage.js";

const parts = {};
let motion = null;
let units = null;
let key = "";

export function startMotion(panel) {
  const canvas = h("canvas", { id: "stage", role: "img", "aria-label": "The bar and the wall" });
  parts.stage = new Stage(canvas, framed(cursor), struck);
  parts.facts = h("dl", { class: "figures", id: "motion-facts" });
  parts.status = h("p", { class: "small muted", id: "motion-status", role: "status" });
  put(
    panel,
    sourceCard((words) => put(parts.status, words)),
    h("div", { class: "card stage" }, canvas, player(), parts.status),
    h("div", { class: "card" }, parts.facts),
    motionCharts(startThere),
  );
  panel.addEventListener("keydown", keys);
  on("info", () => (sources(), want()));
  on("quick steady tables", want);
  on("view", () => (view.panel === "motion" ? (sources(), want(), knobs()) : parts.stage.pause()));
  on("theme", () => (motion && drawCharts(motion, units), parts.stage.draw()));
  document.addEventListener("visibilitychange", () => document.hidden && parts.stage.pause());
}

function player() {
  parts.play = h("button", { type: "button", class: "main", id: "play", onclick: toggle }, "Play");
  parts.scrub = h("input", {
    type: "range",
    id: "scrub",
    min: 0,
    max: 1000,
    step: 1,
    "aria-label": "Time in the motion",
    oninput: (event) => (stop(), parts.stage.seek((parts.stage.length * event.target.value) / 1000)),
  });
  parts.time = h("output", { class: "time", for: "scrub" }, "–");
  parts.slow = h("input", {
    type: "range",
    id: "slow",
    min: 0,
    max: 100,
    step: 1,
    oninput: (event) => (show({ slow: event.target.value }), knobs()),
  });
  parts.slowly = h("output", { for: "slow" });
  parts.grow = h("input", {
    type: "range",
    id: "grow",
    min: 0,
    max: 4,
    step: 0.05,
    oninput: (event) => (show({ grow: event.target.value }), knobs(), parts.stage.draw()),
  });
  parts.grown = h("span", { class: "small muted", id: "grown" });
  const knob = (text, input, output) => h("label", { class: "pick" }, h("span", {}, text, " ", output), input);
  return [
    h("div", { class: "play" }, parts.play, parts.scrub, parts.time),
    h(
      "div",
      { class: "knobs" },
      knob("Slow motion:", parts.slow, parts.slowly),
      knob("Stretch of the bar", parts.grow, ""),
      parts.grown,
    ),
  ];
}

function toggle() {
  if (parts.stage.playing) return stop();
  parts.stage.play();
  put(parts.play, "Pause");
}

function stop() {
  parts.stage.pause();
  put(parts.play, "Play");
}

function keys(event) {
  if (event.key !== " " || event.target.closest("button, select, input:not([type=range])")) return;
  event.preventDefault();
  toggle();
}

/** How long a load period is shown, in seconds: from real time (or a second) to minutes, evenly in ratios. */
function pace() {
  const real = motion?.time_scale_s ? 2 * Math.PI * motion.time_scale_s : 1;
  const chosenShare = view.slow === "" ? null : Number(view.slow) / 100;
  const part = (2 * Math.PI) / parts.stage.length; // of a zoom that lasts some seconds, a load period takes hours
  const longest = view.zoom ? 30 * part : 120;
  const usual = Math.log(Math.max(view.zoom ? 8 * part : 2.5, real) / real) / Math.log(longest / real);
  const share = chosenShare ?? Math.min(Math.max(usual, 0), 1);
  return { share, seconds: real * (longest / real) ** share, real };
}

function knobs() {
  if (!motion) return;
  const { share, seconds, real } = pace();
  parts.stage.rate = (2 * Math.PI) / seconds;
  parts.stage.grow = Number(view.grow) || 0;
  if (document.activeElement !== parts.slow) parts.slow.value = 100 * share;
  if (document.activeElement !== parts.grow) parts.grow.value = view.grow;
  const words = motion.time_scale_s
    ? seconds / real < 1.01
      ? "real time"
      : `${number(seconds / real, 2)} times slower`
    : `${number(seconds, 2)} s a load period`;
  put(parts.slowly, words);
  put(parts.grown, parts.stage.magnified());
}

const want = settled(() => {
  if (view.panel !== "motion" || !data.tables || data.problems.length || !data.quick) return;
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
      "There is no steady motion to show. Choose “From a start” to see what the bar does instead.",
    );
  }
  const from = view.source === "orbit" ? { orbit: number_ } : { show: view.window };
  const rings = view.zoom && data.info ? { window: [0, (view.zoom * 2 * Math.PI) / data.info.first_mode] } : {};
  put(parts.status, "Computing …");
  askMotion({
    ...asked(),
    ...from,
    ...rings,
    cycles: view.cycles,
    frames: Math.min(2000, 1200 + 100 * view.cycles),
    places: 33,
    end_points: Math.min(20000, 1500 * view.cycles),
  });
}, 60);

const askMotion = latest(
  (body) => postBinary("motion", body),
  (found) => {
    motion = found;
    take();
  },
  (error) => {
    key = "";
    stop();
    put(parts.status, h("span", { class: "problem", role: "alert" }, error.message));
  },
);

function take() {
  const { arrays } = motion;
  units = unitsOf(motion);
  parts.stage.show(motion, force());
  knobs();
  drawCharts(motion, units);
  facts();
  parts.stage.canvas.setAttribute(
    "aria-label",
    `The bar and the wall: ${motion.label}, ${motion.blows.length} events in view`,
  );
  parts.stage.canvas.dataset.label = motion.label;
  const steps = `${arrays.displacement.shape[0]} frames of ${arrays.x.length} places, ${motion.modes} elastic modes`;
  put(parts.status, `${steps}. Space plays and pauses; the arrow keys on the time slider step.`);
  if (!parts.stage.playing && !matchMedia("(prefers-reduced-motion: reduce)").matches && view.panel === "motion")
    toggle();
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

function facts() {
  const { label, outcome, blows } = motion;
  const seconds = (motion.end - motion.begin) * (motion.time_scale_s ?? 1);
  const last = blows.filter((b) => b.kind === "impact").at(-1);
  const rows = [
    ["motion", label],
    ["ended by", outcome ?? "steady"],
    ["shown", motion.time_scale_s ? si(seconds, "s", 3) : withUnit(seconds, "rad", 3)],
    ["blows in view", String(blows.filter((b) => b.kind === "impact" || b.kind === "chatter").length)],
    [
      "delivered by the last blow",
      last
        ? last.energy_J !== null && last.energy_J !== undefined
          ? si(last.energy_J, "J")
          : number(last.energy)
        : "–",
    ],
    [
      "first elastic mode",
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

function struck(event, share) {
  const { pitch, loudness } = heard({ frequency: motion.first_mode_Hz, energy: event.energy_J, share });
  const place = $("#heard");
  if (place) put(place, `${si(pitch, "Hz", 3)}, ${number(100 * loudness, 2)} %`);
  parts.stage.canvas.dataset.blows = String(Number(parts.stage.canvas.dataset.blows ?? 0) + 1);
}

function cursor(time) {
  if (!motion || view.panel !== "motion") return;
  const { stage, scrub } = parts;
  if (document.activeElement !== scrub || stage.playing) scrub.value = stage.length ? (1000 * time) / stage.length : 0;
  const small = units.time.k * stage.length < 0.1 ? 5 : 3;
  const words = withUnit(time * units.time.k, units.time.name, small);
  put(parts.time, words);
  scrub.setAttribute("aria-valuetext", words);
  followCharts(motion, units, time);
}
