// The machine that switches itself: piston, ports and valve in slow motion, its cycle as curves, energy and rate over the
// pressure; or what keeps it from running.

import { saidOf } from "../core/api.js";
import { facts, framed, h, put } from "../core/dom.js";
import { number, percent, si, withUnit } from "../core/format.js";
import { drawCurve, drawMachine, followMachine, keepCurve, machineCharts, machineUnits } from "./machine_charts.js";
import { beginMachine, machineMoment, machinePace, machinePlayer, pauseMachine, toggleMachine } from "./machine_player.js";
import { machineSource, fromStart, startUp } from "./machine_start.js";
import { MachineStage } from "./machine_stage.js";
import { forgetBlows, tellBlow } from "../map/blows_inset.js";
import { onCycle } from "../motion/settled.js";
import { Strip } from "../motion/strip.js";
import { heardAs } from "../motion/sound.js";
import { data, on, switchesItself, unhurried, view } from "../core/state.js";
import { tr } from "../core/words.js";

const DRAWN =
  "The arrow is the force, and the tint is on the side that pushes. A thick line: the port is uncovered by the mark on the piston. The spool travels while an order waits for its delay.";

const parts = { drawn: null };

/** What of it stands on the screen, and what in the drawer of all motions. */
export function startMachine() {
  const canvas = h("canvas", { id: "machine-stage", role: "img", "aria-label": "Piston, ports and valve" });
  parts.stage = new MachineStage(canvas, { ticked, struck });
  parts.sentence = h("p", { id: "machine-sentence", role: "status" });
  parts.obstacle = h("div", { id: "machine-obstacle", role: "alert" });
  parts.scale = h("p", { class: "small muted", id: "machine-scale" });
  parts.facts = h("div", { class: "card", id: "machine-facts" });
  const { strip, why, rest } = machineCharts();
  const line = machinePlayer(parts.stage);
  parts.strip = new Strip("machine-strip", strip);
  parts.moving = [parts.scale, why, rest, parts.facts];
  const { picks, form } = machineSource(() => (want(), words()));
  const told = unhurried(words);
  on("machine", () => (keep(), want(), told()));
  on("tables problems", want);
  on("view info", () => (want(), words()));
  on("theme", () => ((parts.drawn = null), want()));
  document.addEventListener("visibilitychange", () => document.hidden && pauseMachine());
  return {
    stage: [h("div", { class: "stage", id: "machine-in-sight" }, canvas, parts.obstacle), line],
    strip: [strip, parts.strip.figure],
    why,
    toggle: toggleMachine,
    details: h("div", { class: "stack", id: "machine-details" }, h("div", { class: "row middle" }, picks), form, parts.sentence, parts.scale, rest, parts.facts),
  };
}

/** The curve over the pressure is kept whether the panel is in sight or not. */
const keep = () => data.machine && keepCurve(data.machine);

const shownNow = () => switchesItself() && view.panel !== "blow";

function want() {
  if (!shownNow()) return pauseMachine();
  const motion = data.machine;
  if (!motion) {
    pauseMachine();
    const lines = data.problems.map(saidOf);
    return put(parts.obstacle, lines.map((line) => h("p", { class: "note bad" }, line)));
  }
  const started = startUp();
  if (fromStart() && !started) return;
  const shown = started ?? motion;
  for (const part of parts.moving) part.hidden = !shown.arrays.t;
  if (parts.drawn === shown && parts.curve === motion && parts.sections === data.info) return;
  const same = parts.drawn === shown && parts.sections === data.info;
  Object.assign(parts, { drawn: shown, curve: motion, sections: data.info });
  drawCurve(motion, machineUnits(motion));
  if (!same) draw(shown);
}

function draw(motion) {
  const { stage } = parts;
  parts.units = machineUnits(motion);
  const sections = data.info?.tables?.load?.kind === "valve" ? data.info.bar?.sections : null;
  if (motion.started || !motion.motion) stage.show(motion, sections);
  else {
    const another = parts.hammer !== view.machine;
    parts.hammer = view.machine;
    if (another) {
      stage.forget();
      forgetBlows();
    }
    if (parts.ruled !== motion.changed) {
      const { valve, restitution } = motion.motion;
      const begun = motion.answer.blows.length ? onCycle(valve, restitution, motion.answer) : { gap: -0.1 };
      stage.under(motion.motion, another ? begun : undefined);
      parts.ruled = motion.changed;
    }
    stage.settle(motion, sections);
  }
  put(parts.scale, `${stage.magnified()} ${DRAWN}`);
  drawMachine(motion, parts.units);
  machinePace();
  mark(stage.time);
  const { canvas } = stage;
  canvas.setAttribute("aria-label", tr(`Piston, ports and valve. ${motion.sentence ?? motion.answer.outcome}`));
  Object.assign(canvas.dataset, {
    change: String(motion.changed),
    modes: String(motion.modes),
    whole: String(Boolean(motion.more)),
    label: motion.label ?? "",
  });
  if (!motion.arrays.t && !stage.live) return pauseMachine();
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) beginMachine();
}

const mark = (time) => {
  if (!parts.units) return;
  machineMoment(time, parts.units);
  parts.strip.follow(parts.stage, stripOf());
  if (parts.stage.exact) followMachine(parts.drawn, parts.units, time);
};

/** How the strip tells what the stage has shown, with the ports. */
function stripOf() {
  const { scales, answer, motion } = parts.drawn;
  const levels = answer.machine.ports.filter(({ behind }) => behind !== null).map(({ behind }) => ({ at: behind }));
  return { shown: !fromStart() && Boolean(motion), length: scales?.length_m, period: parts.stage.period, name: "cycles ago", levels };
}

const cursor = (time) => shownNow() && mark(time);
const shown = framed(cursor);

function ticked(time) {
  parts.stage.sounds(data.info?.bar?.first_mode_Hz, data.machine?.scales?.energy_J);
  (parts.stage.playing ? cursor : shown)(time); // within a frame of its own while it plays
}

let last = 0; // the moment of the blow before

/** A blow, in the inset by the time since the one before, half a turn for a whole cycle, and its speed. */
function struck({ speed }) {
  const { stage } = parts;
  const since = stage.now - last;
  last = stage.now;
  const own = speed ?? data.machine?.answer.blows[0]?.speed;
  if (own && stage.period) tellBlow({ phase: Math.min(since / stage.period, 1.9) * Math.PI, speed: own });
  const { dataset } = parts.stage.canvas;
  dataset.blows = String(Number(dataset.blows ?? 0) + 1);
}

/* words */

function words() {
  const motion = data.machine;
  if (!shownNow() || !switchesItself() || !motion) return;
  const { answer, runs, modes, more } = motion;
  const body = modes ? `with ${modes} elastic modes` : "with a rigid piston; elastic modes follow when nothing moves";
  const waits = more ? "" : "Margins, what changes it and the curves over the pressure take some seconds.";
  const started = startUp();
  put(parts.sentence, started ? `${started.sentence} ` : "", `${motion.sentence ?? "The machine runs with one blow a cycle."} Computed ${body}. ${runs ? waits : ""}`);
  put(parts.obstacle, runs ? notes(more ?? answer) : obstacle(motion));
  put(parts.facts, answer.period ? [figures(motion), more && margins(more, motion.scales), more && changes(more)] : null);
}

const notes = ({ warnings = [] }) => warnings.map((text) => h("p", { class: "note warn" }, `${text[0].toUpperCase()}${text.slice(1)}.`));

/** What keeps it from running, and what would be needed. */
function obstacle({ answer }) {
  const { failed_condition: failed } = answer;
  if (!failed) return null;
  const { remedy } = failed;
  return h("p", { class: "note bad" }, h("strong", {}, `What would be needed: `), `${remedy}.`);
}

function figures({ answer, scales }) {
  const { si: own, period, stroke, duty, work_per_cycle: work } = answer;
  const plain = (value) => number(value);
  const rows = own
    ? [
        ["blow energy", si(own.blow_energy_J, "J")],
        ["striking speed", withUnit(own.impact_velocity_m_s, "m/s")],
        ["blow rate", `${withUnit(own.blow_rate_Hz, "Hz")}, ${withUnit(own.blow_rate_per_min, "1/min")}`],
        ["stroke", si(own.stroke_m, "m")],
        ["oil", own.oil_flow_l_per_min === null ? "give the pressure of the supply" : `${withUnit(own.oil_flow_l_per_min, "l/min")}, ${withUnit(own.oil_per_cycle_cm3, "cm³")} a cycle`],
        ["power in, delivered", `${withUnit(own.input_power_kW, "kW")}, ${withUnit(own.delivered_power_kW, "kW")}`],
        ["of the energy of a blow", "the rebound brings a part back, which is in neither power"],
      ]
    : [
        ["period", plain(period)],
        ["stroke", plain(stroke)],
        ["work a cycle", plain(work)],
      ];
  const frequency = scales && data.info?.bar ? data.info.bar.first_mode_Hz : null;
  return [
    h("h2", {}, "The cycle"),
    facts([
      ...rows,
      ["power stroke, share of the cycle", percent(duty)],
      ["multiplier", number(Math.hypot(...(answer.multipliers[0] ?? [0, 0])))],
      ["heard", heardAs({ frequency, energy: own?.blow_energy_J, share: 1 })],
    ]),
  ];
}

function margins({ margins: found }, scales) {
  if (!found) return null;
  const time = (value) => (scales ? si(value * scales.time_s, "s") : number(value));
  const from = (value) => (value < 0 ? `${time(-value)} before the blow` : `${time(value)} after it`);
  const rows = [
    ["the force falls", from(found.return_time)],
    ["at the latest", found.latest_return === null ? "no limit was met" : `${from(found.latest_return)}, then ${found.beyond}`],
    found.chamber_to_run !== null && ["gas of the chamber, to run", `${number(found.chamber_to_run, 3)} times as much at most`],
    found.chamber_to_start !== null && ["to start from rest", `${number(found.chamber_to_start, 3)} times as much at most`],
  ].filter(Boolean);
  return [h("h3", {}, "Margins, of a rigid piston"), facts(rows)];
}

function changes({ sensitivities, modes }) {
  if (!sensitivities.length) return null;
  const told = (value) => (value === null ? "stops" : `${value < 0 ? "−" : "+"}${number(Math.abs(100 * value), 3)} %`);
  const head = ["10 % more of", "blow energy", "blow rate"];
  return [
    h("h3", {}, `What changes it, ${modes ? `with ${modes} elastic modes` : "of a rigid piston"}`),
    h(
      "table",
      { id: "machine-changes" },
      h("thead", {}, h("tr", {}, head.map((text) => h("th", { scope: "col" }, text)))),
      h("tbody", {}, sensitivities.map((one) => h("tr", {}, [named(one.parameter), told(one.energy), told(one.rate)].map((text) => h("td", {}, text))))),
    ),
  ];
}

/** "ports[0].behind" → "port 1: place". */
function named(parameter) {
  const found = /^ports\[(\d+)\]\.(behind|speed|delay)$/.exec(parameter);
  return found ? `port ${Number(found[1]) + 1}: ${found[2] === "behind" ? "place" : found[2]}` : parameter;
}
