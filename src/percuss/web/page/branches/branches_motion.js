// The motion at a place of a branch: the bar in slow motion with each blow heard, and what there is to say of the orbit.

import { postBinary } from "../core/api.js";
import { $, button, div, h, latest, problem, put } from "../core/dom.js";
import { angle, counted, few, number, si, withUnit } from "../core/format.js";
import { data, isHeld, mover, switchesItself, view } from "../core/state.js";
import { tr } from "../core/words.js";
import { unitsOf } from "../motion/motion_charts.js";
import { Player } from "../motion/player.js";

import { follow, heardAs, hush, lag } from "../motion/sound.js";
import { pushOf, shapeOfCase, Stage } from "../motion/stage.js";

/** A place: the row of a branch, of a motion with such a label, and the case that the branch is of.
 * @typedef {{ tables: any, along: import("./branches_choices.js").Axis, row: import("./branches_rows.js").Row,
 *   motion: string, periods: number, modes: number }} Place */

const USUAL = 1.25; // seconds that a load period is shown for at first
const LONGEST = 120;
const FRAMES = 160; // of a load period

/** @type {Record<string, any>} */
const parts = {};
/** The motion that is shown. @type {any} */
let motion = null;
/** @type {any} */
let units = null;

/** The card with the stage; `carry` moves the hammer to a value of the parameter. @param {(value: number) => void} carry */
export function motionCard(carry) {
  const canvas = h("canvas", { id: "branches-stage", role: "img", "aria-label": "What moves, and the wall" });
  parts.stage = new Stage(canvas, { ticked, struck, stopped: hush, lag });
  parts.player = new Player(parts.stage, {
    id: "branches-",
    about: "Time in the cycle",
    slow: "branchSlow",
    moved: pace,
  });
  parts.status = h("p", { class: "small muted", id: "branches-motion-status", role: "status" });
  parts.facts = h("dl", { class: "figures", id: "branches-facts" });
  const id = { id: "branches-carry", ".disabled": true };
  parts.carry = button("Move the hammer here", () => carry(parts.value), id);
  parts.rows = h("div", {}, parts.player.rows());
  const below = div("row", parts.carry, parts.status);
  return div("card stage", canvas, parts.rows, parts.facts, below);
}

export const toggleBranch = () => parts.player.toggle();
export const pauseBranch = () => parts.player.stop();

/** Nothing is shown any more; `words` say why. @param {string | Node} words */
export function noMotion(words) {
  const { canvas } = parts.stage;
  parts.stage.motion = motion = null;
  pauseBranch();
  canvas.getContext("2d").clearRect(0, 0, canvas.width, canvas.height);
  put(parts.facts);
  put(parts.status, words);
  parts.carry.disabled = true;
}

/** Show the motion of a place, as soon as the one before has come; of a machine, whose cycle plays in the panel Machine
 * once the hammer has been moved there, its figures. @param {Place} place */
export function showMotion(place) {
  parts.stage.canvas.hidden = parts.rows.hidden = switchesItself();
  if (!switchesItself()) return askMotion(place);
  pauseBranch();
  motion = null;
  told(place, place.motion, cycleFacts(place));
  put(parts.status, place.tables === data.tables ? "" : "The case has changed since.");
}

const askMotion = latest(
  (/** @type {Place} */ { tables, along: { name, unit }, row, periods, modes }) =>
    postBinary("follow/motion", {
      case: tables,
      name,
      unit,
      value: row.value,
      ...(row.releases ? { release: row.releases[0] } : { times: row.times }),
      periods,
      modes,
      frames: Math.min(2000, FRAMES * periods + 1),
      places: 33,
      end_points: Math.min(20000, 400 * periods),
    }),
  (found, place) => {
    motion = found;
    units = unitsOf(motion);
    put(parts.status, "");
    parts.stage.show(motion, pushOf(motion.arrays.load), place.tables === data.tables ? shapeOfCase() : undefined);
    pace();
    told(place, motion.label, facts(place));
    const chatter = motion.label.startsWith("chatter") ? " and a chatter" : "";
    const many = `${counted(motion.orbit.impacts.length, "blow")}${chatter}`;
    const words = tr(`The ${mover()} and the wall: ${motion.label}, ${many} in a cycle`);
    parts.stage.canvas.setAttribute("aria-label", words);
    if (view.panel === "branches") parts.player.begin();
  },
  (error) => noMotion(problem(error)),
);

/** What is shown has another label, place and figures. @param {Place} place @param {string} label
 * @param {string[][]} rows */
function told({ along, row }, label, rows) {
  parts.value = row.value;
  parts.carry.disabled = !along.movable;
  put(parts.carry, `Move the ${isHeld() ? "structure" : "hammer"} here`);
  Object.assign(parts.stage.canvas.dataset, { label, value: String(row.value) });
  put(
    parts.facts,
    rows.map(([name, text, id]) => h("div", {}, h("dd", { id }, text), h("dt", {}, name))),
  );
}

/** @param {Place} place @returns {string[][]} */
function facts({ along: { label, unit }, row: { value } }) {
  const { orbit, blows } = motion;
  const { impacts, multipliers, rest_phase: rest } = orbit;
  const hits = blows.filter((/** @type {any} */ { kind }) => kind === "impact");
  const sizes = (multipliers ?? [[Infinity, 0]]).map((/** @type {number[]} */ one) => Math.hypot(...one));
  const energies = hits.map((/** @type {any} */ { energy, energy_J: joule }) =>
    joule === null ? number(energy, 3) : si(joule, "J", 3),
  );
  const speeds = hits.map((/** @type {any} */ { impact_velocity: speed, impact_velocity_m_s: metres }) =>
    metres === null ? number(speed, 3) : withUnit(metres, "m/s", 3),
  );
  const phases = impacts.map((/** @type {any} */ { phase }) => number(phase, 4));
  return [
    ["motion", motion.label],
    [label, withUnit(value, unit, 5)],
    [`largest multiplier ${number(Math.max(...sizes), 3)}`, orbit.stable ? "stable" : "unstable"],
    impacts.length > 1 ? ["impact phases", few(phases)] : ["impact phase", angle(impacts[0].phase)],
    ...(rest === undefined
      ? []
      : [
          ["comes to rest at", angle(rest)],
          ["is let go at", angle(orbit.release_phase)],
        ]),
    ["striking speed", few(speeds)],
    ["delivered by each blow", few(energies)],
    ["heard", "–", "branches-heard"],
  ];
}

/** @param {Place} place @returns {string[][]} */
function cycleFacts({ along: { label, unit }, row, motion: name }) {
  const isSI = data.machine?.units === "SI";
  const stable = row.stable === null ? "at the border" : row.stable ? "stable" : "unstable";
  const period = row.period ?? Number.NaN;
  return [
    [`motion, ${stable}`, name],
    [label, withUnit(row.value, unit, 5)],
    ["striking speed", few(row.speeds.map((speed) => (isSI ? withUnit(speed, "m/s", 3) : number(speed, 3))))],
    ["period of the cycle", isSI ? withUnit(1000 * period, "ms", 4) : number(period, 4)],
    ...(isSI ? [["blows", withUnit(row.speeds.length / period, "1/s", 4)]] : []),
  ];
}

/** How long a load period is shown, as the view has it; the same whatever the label, so that periods can be heard. */
function pace() {
  if (!motion) return;
  const second = motion.time_scale_s;
  const real = second ? 2 * Math.PI * second : 1;
  const span = { real, usual: USUAL, longest: LONGEST };
  parts.stage.rate = (2 * Math.PI) / parts.player.paced(view.branchSlow, span, second ? "" : "period");
}

/** @param {number} time */
function ticked(time) {
  if (!motion) return;
  follow(parts.stage, motion.first_mode_Hz);
  parts.player.tellMoment(time, units);
}

/** @param {any} blow */
function struck(blow) {
  const share = parts.stage.share(blow);
  put($("#branches-heard"), heardAs({ frequency: motion.first_mode_Hz, energy: blow.energy_J, share }));
}
