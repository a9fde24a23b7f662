// The machine that switches itself: piston, ports and valve in slow motion, its cycle as curves, energy and rate over the
// pressure; or what keeps it from running.

import { saidOf } from "../core/api.js";
import { div, facts, framed, h, put, table } from "../core/dom.js";
import { number, percent, si, withUnit } from "../core/format.js";
import { effect } from "../core/signals.js";
import { data, switchesItself, unhurried, view } from "../core/state.js";
import { tr } from "../core/words.js";
import { forgetBlows, tellBlow } from "../map/blows_inset.js";
import { Player } from "../motion/player.js";
import { onCycle } from "../motion/settled.js";
import { heardAs } from "../motion/sound.js";
import { Strip } from "../motion/strip.js";
import { theme } from "../pictures/colours.js";
import { drawCurve, drawMachine, followMachine, keepCurve, machineCharts, machineUnits } from "./machine_charts.js";
import { MachineStage } from "./machine_stage.js";
import { fromStart, machineSource, startUp } from "./machine_start.js";

/** @typedef {import("./machine_charts.js").Machine} Machine */

const DRAWN =
  "The arrow is the force, and the tint is on the side that pushes. A thick line: the port is uncovered by the mark on the piston. The spool travels while an order waits for its delay.";

const USUAL = 1.2; // seconds that a cycle takes at first
const LONGEST = 60;

/** `drawn`: the motion on the stage, which may be a start-up; `curve`: the machine of the curves over the pressure.
 * @type {Record<string, any>} */
const parts = { drawn: null };
/** @type {MachineStage} */
let stage;
/** @type {Player} */
let player;

/** What of it stands on the screen, and what in the drawer of all motions. */
export function startMachine() {
  const canvas = h("canvas", { id: "machine-stage", role: "img", "aria-label": "Piston, ports and valve" });
  stage = new MachineStage(canvas, { ticked, struck });
  player = new Player(stage, { id: "machine-", about: "Time in the cycle", slow: "machineSlow", moved: pace });
  parts.sentence = h("p", { id: "machine-sentence", role: "status" });
  parts.obstacle = h("div", { id: "machine-obstacle", role: "alert" });
  parts.scale = h("p", { class: "small muted", id: "machine-scale" });
  parts.facts = h("div", { class: "card", id: "machine-facts" });
  const { strip, why, rest } = machineCharts();
  parts.strip = new Strip("machine-strip", strip);
  parts.moving = [parts.scale, why, rest, parts.facts];
  const { picks, form } = machineSource();
  effect(() => void (data.machine && keepCurve(data.machine))); // whether the panel is in sight or not
  effect(want);
  effect(words, unhurried);
  const choice = div("row middle", picks);
  const details = [choice, form, parts.sentence, parts.scale, rest, parts.facts];
  return {
    stage: [h("div", { class: "stage", id: "machine-in-sight" }, canvas, parts.obstacle), player.rows()],
    strip: [strip, parts.strip.figure],
    why,
    toggle: () => player.toggle(),
    details: h("div", { class: "stack", id: "machine-details" }, details),
  };
}

const inSight = () => switchesItself() && view.panel !== "blow";

function want() {
  const machine = data.machine;
  if (!inSight() || !machine) player.stop();
  if (!inSight()) return;
  if (!machine)
    return void put(
      parts.obstacle,
      data.problems.map((/** @type {any} */ one) => h("p", { class: "note bad" }, saidOf(one))),
    );
  const started = startUp();
  if (fromStart() && !started) return;
  const shown = started ?? machine;
  for (const part of parts.moving) part.hidden = !shown.arrays.t;
  const colours = theme();
  const same = parts.drawn === shown && parts.sections === data.info && parts.colours === colours;
  if (same && parts.curve === machine) return;
  Object.assign(parts, { drawn: shown, curve: machine, sections: data.info, colours });
  drawCurve(machine, machineUnits(machine));
  if (!same) draw(shown);
}

/** @param {Machine} motion */
function draw(motion) {
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
  pace();
  mark(stage.time);
  const { canvas } = stage;
  canvas.setAttribute("aria-label", tr(`Piston, ports and valve. ${motion.sentence ?? motion.answer.outcome}`));
  const { changed, modes, label, more } = motion;
  Object.assign(canvas.dataset, {
    change: String(changed),
    modes: String(modes),
    label: label ?? "",
    whole: String(Boolean(more)),
  });
  if (!motion.arrays.t && !stage.live) return player.stop();
  player.begin();
}

/** How fast the cycle is shown, as the view has it; dimensionless, real time is a second a cycle. */
function pace() {
  const { motion, period } = stage;
  if (!motion) return;
  const one = (stage.length || period) / (motion.cycles ?? 1); // of the blows from a start each counts as a cycle
  const real = motion.scales ? one : 1;
  const span = { real, usual: USUAL, longest: Math.max(LONGEST, 2 * real) };
  stage.rate = one / player.paced(view.machineSlow, span, motion.scales ? "" : "cycle");
}

/** The present moment, on the player, the strip, and the curves of the cycle. @param {number} time */
function mark(time) {
  if (!parts.units) return;
  const { scales, answer, motion } = parts.drawn;
  player.tellMoment(time, parts.units);
  parts.strip.follow(stage, {
    shown: !fromStart() && Boolean(motion),
    length: scales?.length_m,
    period: stage.period,
    name: "cycles ago",
    levels: answer.machine.ports.flatMap((/** @type {any} */ { behind }) => (behind === null ? [] : [{ at: behind }])),
  });
  if (stage.exact) followMachine(parts.drawn, parts.units, time);
}

const cursor = (/** @type {number} */ time) => inSight() && mark(time);
const cursorLater = framed(cursor);

/** @param {number} time */
function ticked(time) {
  stage.sounds(data.info?.bar?.first_mode_Hz, data.machine?.scales?.energy_J);
  (stage.playing ? cursor : cursorLater)(time); // within a frame of its own while it plays
}

let last = 0; // the moment of the blow before

/** A blow, in the inset by the time since the one before, half a turn for a whole cycle, and its speed.
 * @param {{ speed?: number }} blow */
function struck({ speed = data.machine?.answer.blows[0]?.speed }) {
  const since = stage.now - last;
  last = stage.now;
  if (speed && stage.period) tellBlow({ phase: Math.min(since / stage.period, 1.9) * Math.PI, speed });
}

/* words */

function words() {
  const machine = data.machine;
  if (!inSight() || !machine) return;
  const { answer, runs, modes, more, scales } = machine;
  const body = modes ? `with ${modes} elastic modes` : "with a rigid piston; elastic modes follow when nothing moves";
  const waits = runs && !more ? "Margins, what changes it and the curves over the pressure take some seconds." : "";
  const said = machine.sentence ?? "The machine runs with one blow a cycle.";
  const started = startUp();
  put(parts.sentence, started ? `${started.sentence} ` : "", `${said} Computed ${body}. ${waits}`);
  const remedy = answer.failed_condition?.remedy;
  const needed = remedy && h("p", { class: "note bad" }, h("strong", {}, "What would be needed: "), `${remedy}.`);
  put(parts.obstacle, runs ? notes(more ?? answer) : needed);
  const rest = more && [margins(more.margins, scales), changes(more)];
  put(parts.facts, answer.period ? [h("h2", {}, "The cycle"), facts(figures(machine)), rest] : null);
}

/** @param {{ warnings?: string[] }} answer */
const notes = ({ warnings = [] }) =>
  warnings.map((text) => h("p", { class: "note warn" }, `${text[0].toUpperCase()}${text.slice(1)}.`));

/** @param {Machine} machine */
function figures({ answer, scales }) {
  const { si: own, period, stroke, duty, work_per_cycle: work, multipliers } = answer;
  const oil = own?.oil_flow_l_per_min;
  const rows = own
    ? [
        ["blow energy", si(own.blow_energy_J, "J")],
        ["striking speed", withUnit(own.impact_velocity_m_s, "m/s")],
        ["blow rate", `${withUnit(own.blow_rate_Hz, "Hz")}, ${withUnit(own.blow_rate_per_min, "1/min")}`],
        ["stroke", si(own.stroke_m, "m")],
        [
          "oil",
          oil === null
            ? "give the pressure of the supply"
            : `${withUnit(oil, "l/min")}, ${withUnit(own.oil_per_cycle_cm3, "cm³")} a cycle`,
        ],
        ["power in, delivered", `${withUnit(own.input_power_kW, "kW")}, ${withUnit(own.delivered_power_kW, "kW")}`],
        ["of the energy of a blow", "the rebound brings a part back, which is in neither power"],
      ]
    : [
        ["period", number(period)],
        ["stroke", number(stroke)],
        ["work a cycle", number(work)],
      ];
  const frequency = scales && data.info?.bar ? data.info.bar.first_mode_Hz : null;
  return [
    ...rows,
    ["power stroke, share of the cycle", percent(duty)],
    ["multiplier", number(Math.hypot(...(multipliers[0] ?? [0, 0])))],
    ["heard", heardAs({ frequency, energy: own?.blow_energy_J, share: 1 })],
  ];
}

/** @param {any} found @param {any} scales */
function margins(found, scales) {
  if (!found) return null;
  const { return_time: falls, latest_return: latest, beyond, chamber_to_run: run, chamber_to_start: start } = found;
  const from = (/** @type {number} */ value) => {
    const time = scales ? si(Math.abs(value) * scales.time_s, "s") : number(Math.abs(value));
    return value < 0 ? `${time} before the blow` : `${time} after it`;
  };
  const most = (/** @type {number} */ value) => `${number(value, 3)} times as much at most`;
  return [
    h("h3", {}, "Margins, of a rigid piston"),
    facts([
      ["the force falls", from(falls)],
      ["at the latest", latest === null ? "no limit was met" : `${from(latest)}, then ${beyond}`],
      run !== null && ["gas of the chamber, to run", most(run)],
      start !== null && ["to start from rest", most(start)],
    ]),
  ];
}

/** @param {any} more */
function changes({ sensitivities, modes }) {
  if (!sensitivities.length) return null;
  const told = (/** @type {number | null} */ value) =>
    value === null ? "stops" : `${value < 0 ? "−" : "+"}${number(Math.abs(100 * value), 3)} %`;
  const rows = sensitivities.map((/** @type {any} */ one) => [named(one.parameter), told(one.energy), told(one.rate)]);
  return [
    h("h3", {}, `What changes it, ${modes ? `with ${modes} elastic modes` : "of a rigid piston"}`),
    table(["10 % more of", "blow energy", "blow rate"], rows, { id: "machine-changes" }),
  ];
}

/** "ports[0].behind" → "port 1: place". @param {string} parameter */
function named(parameter) {
  const found = /^ports\[(\d+)\]\.(behind|speed|delay)$/.exec(parameter);
  return found ? `port ${Number(found[1]) + 1}: ${found[2] === "behind" ? "place" : found[2]}` : parameter;
}
