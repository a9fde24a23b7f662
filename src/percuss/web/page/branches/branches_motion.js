// The motion at a place of a branch: the bar in slow motion with each blow heard, and what there is to say of the orbit.

import { postBinary } from "../core/api.js";
import { $, h, latest, put } from "../core/dom.js";
import { angle, counted, number, si, withUnit } from "../core/format.js";
import { unitsOf } from "../motion/motion_charts.js";
import { paceOf, Player } from "../motion/player.js";
import { follow, heardAs, hush, lag } from "../motion/sound.js";
import { shapeOfCase } from "../motion/shape.js";
import { Stage } from "../motion/stage.js";
import { data, isHeld, mover, switchesItself, view } from "../core/state.js";
import { tr } from "../core/words.js";

const USUAL = 2.5; // seconds that a load period is shown for at first
const LONGEST = 120;
const FRAMES = 160; // of a load period
const parts = {};
let motion = null;
let units = null;

/** The card with the stage; `carry` moves the hammer to a value of the parameter. */
export function motionCard(carry) {
  const canvas = h("canvas", { id: "branches-stage", role: "img", "aria-label": "What moves, and the wall" });
  parts.stage = new Stage(canvas, { ticked, struck, stopped: hush, lag });
  parts.player = new Player(parts.stage, { id: "branches-", about: "Time in the cycle", slow: "branchSlow", paced: pace });
  parts.status = h("p", { class: "small muted", id: "branches-motion-status", role: "status" });
  parts.facts = h("dl", { class: "figures", id: "branches-facts" });
  parts.carry = h(
    "button",
    { type: "button", id: "branches-carry", ".disabled": true, onclick: () => motion && carry(motion.asked.value) },
    "Move the hammer here",
  );
  parts.rows = h("div", {}, parts.player.rows());
  return h("div", { class: "card stage" }, canvas, parts.rows, parts.facts, h("div", { class: "row" }, parts.carry, parts.status));
}

export const toggleBranch = () => parts.player.toggle();
export const pauseBranch = () => parts.player.stop();

/** Nothing is shown any more; `words` say why. */
export function noMotion(words) {
  motion = null;
  parts.stage.motion = null;
  parts.player.stop();
  parts.stage.canvas.getContext("2d").clearRect(0, 0, parts.stage.canvas.width, parts.stage.canvas.height);
  put(parts.facts);
  put(parts.status, words);
  parts.carry.disabled = true;
}

/** Show the motion of a row of a branch, as soon as the one before has come; of a machine, its figures. */
export function showMotion(question) {
  parts.stage.canvas.hidden = parts.rows.hidden = switchesItself();
  if (switchesItself()) return cycleFacts(question);
  askMotion(question);
}

const askMotion = latest(
  ({ tables, along, row, periods, modes }) =>
    postBinary("follow/motion", {
      case: tables,
      name: along.name,
      unit: along.unit,
      value: row.value,
      ...(row.releases ? { release: row.releases[0] } : { times: row.times }),
      periods,
      modes,
      frames: Math.min(2000, FRAMES * periods + 1),
      places: 33,
      end_points: Math.min(20000, 400 * periods),
    }),
  (found, question) => {
    motion = Object.assign(found, { asked: { value: question.row.value, movable: question.along.movable } });
    take(question);
  },
  (error) => noMotion(h("span", { class: "problem", role: "alert" }, error.message)),
);

function take({ tables, along, row }) {
  units = unitsOf(motion);
  put(parts.status, "");
  parts.carry.disabled = !along.movable;
  put(parts.carry, `Move the ${isHeld() ? "structure" : "hammer"} here`);
  parts.stage.show(motion, force(), tables === data.tables ? shapeOfCase() : undefined);
  pace();
  facts(along, row);
  const { canvas } = parts.stage;
  const many = `${counted(motion.orbit.impacts.length, "blow")}${motion.label.startsWith("chatter") ? " and a chatter" : ""}`;
  canvas.setAttribute("aria-label", tr(`The ${mover()} and the wall: ${motion.label}, ${many} in a cycle`));
  Object.assign(canvas.dataset, { label: motion.label, value: String(row.value) });
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches && view.panel === "branches") parts.player.begin();
}

/** The load as a share of its greatest value, by phase: of the motion's own system. */
function force() {
  const { load } = motion.arrays;
  const most = Math.max(...load.map(Math.abs)) || 1;
  return (phase) => {
    const share = (((phase / (2 * Math.PI)) % 1) + 1) % 1;
    return load[Math.round(share * (load.length - 1))] / most;
  };
}

function facts({ label, unit }, { value }) {
  const { orbit, blows } = motion;
  const hits = blows.filter(({ kind }) => kind === "impact");
  const list = (items) => items.slice(0, 4).join(", ") + (items.length > 4 ? ", …" : "");
  const largest = orbit.multipliers ? Math.max(...orbit.multipliers.map(([re, im]) => Math.hypot(re, im))) : Infinity;
  const energies = hits.map((blow) => (blow.energy_J === null ? number(blow.energy, 3) : si(blow.energy_J, "J", 3)));
  const speeds = hits.map((blow) =>
    blow.impact_velocity_m_s === null ? number(blow.impact_velocity, 3) : withUnit(blow.impact_velocity_m_s, "m/s", 3),
  );
  const rows = [
    ["motion", motion.label],
    [label, withUnit(value, unit, 5)],
    [`largest multiplier ${number(largest, 3)}`, orbit.stable ? "stable" : "unstable"],
    [orbit.impacts.length > 1 ? "impact phases" : "impact phase", orbit.impacts.length > 1 ? list(orbit.impacts.map(({ phase }) => number(phase, 4))) : angle(orbit.impacts[0].phase)],
    ...(orbit.rest_phase === undefined ? [] : [["comes to rest at", angle(orbit.rest_phase)], ["is let go at", angle(orbit.release_phase)]]),
    ["striking speed", list(speeds)],
    ["delivered by each blow", list(energies)],
    ["heard", "–"],
  ];
  tell(rows);
}

const tell = (rows) =>
  put(
    parts.facts,
    rows.map(([name, text]) => h("div", {}, h("dd", { id: name === "heard" ? "branches-heard" : null }, text), h("dt", {}, name))),
  );

/** What there is to say of a machine's cycle; it plays in the panel Machine once the hammer has been moved there. */
function cycleFacts({ tables, along: { label, unit, movable }, row, motion: name }) {
  const speeds = row.speeds.map((speed) => (data.machine?.units === "SI" ? withUnit(speed, "m/s", 3) : number(speed, 3)));
  const stable = row.stable === null ? "at the border" : row.stable ? "stable" : "unstable";
  parts.player.stop();
  motion = { asked: { value: row.value, movable } };
  tell([
    [`motion, ${stable}`, name],
    [label, withUnit(row.value, unit, 5)],
    ["striking speed", speeds.slice(0, 4).join(", ") + (speeds.length > 4 ? ", …" : "")],
    ["period of the cycle", data.machine?.units === "SI" ? withUnit(1000 * row.period, "ms", 4) : number(row.period, 4)],
    ...(data.machine?.units === "SI" ? [["blows", withUnit(row.speeds.length / row.period, "1/s", 4)]] : []),
  ]);
  put(parts.status, tables === data.tables ? "" : "The case has changed since.");
  put(parts.carry, "Move the hammer here");
  parts.carry.disabled = !movable;
  Object.assign(parts.stage.canvas.dataset, { label: name, value: String(row.value) });
}

/** How long a load period is shown, as the view has it; the same whatever the label, so that periods can be heard. */
function pace() {
  if (!motion) return;
  const real = motion.time_scale_s ? 2 * Math.PI * motion.time_scale_s : 1;
  const { share, seconds } = paceOf(view.branchSlow, { real, usual: USUAL / 2, longest: LONGEST });
  parts.stage.rate = (2 * Math.PI) / seconds;
  const slower = seconds / real;
  const words = slower < 1.01 ? "real time" : `${number(slower, 2)} times slower`;
  parts.player.tellPace(share, motion.time_scale_s ? words : `${number(seconds, 2)} s per load period`);
}

function ticked(time) {
  if (!motion) return;
  follow(parts.stage, motion.first_mode_Hz);
  parts.player.tellMoment(time, units);
}

function struck(event) {
  const about = { frequency: motion.first_mode_Hz, energy: event.energy_J, share: parts.stage.share(event) };
  const place = $("#branches-heard");
  if (place) put(place, heardAs(about));
  const { dataset } = parts.stage.canvas;
  dataset.blows = String(Number(dataset.blows ?? 0) + 1);
}
