// Play and pause a motion, slow motion and the stretch of the bar: the rows below the stage.

import { h, put } from "../core/dom.js";
import { number } from "../core/format.js";
import { paceOf, Player } from "./player.js";
import { show, view } from "../core/state.js";

const parts = {};
let own = null;

/** The rows below the stage. */
export function player(stage) {
  own = new Player(stage, { about: "Time in the motion", slow: "slow", paced: knobs });
  const oninput = (event) => (show({ grow: event.target.value }), knobs(), stage.draw());
  parts.grow = h("input", { type: "range", id: "grow", min: 0, max: 4, step: 0.05, oninput });
  parts.grown = h("span", { class: "small muted", id: "grown" });
  return own.rows(h("label", { class: "pick" }, h("span", {}, "Stretch "), parts.grow), parts.grown);
}

export const toggle = () => own.toggle();
export const begin = () => own.begin();
export const stop = () => own.stop();

/** How long a load period is shown, in seconds: from real time (or a second) to minutes. */
function pace() {
  const { motion, length } = own.stage;
  const real = motion.time_scale_s ? 2 * Math.PI * motion.time_scale_s : 1;
  const part = (2 * Math.PI) / length; // of a zoom that lasts some seconds, a load period takes hours
  const span = view.zoom ? { usual: 8 * part, longest: 30 * part } : { usual: 2.5, longest: 120 };
  return { real, ...paceOf(view.slow, { real, ...span }) };
}

/** The pace and the stretch as the view has them. */
export function knobs() {
  const { motion } = own.stage;
  if (!motion) return;
  const { share, seconds, real } = pace();
  own.stage.rate = (2 * Math.PI) / seconds;
  own.stage.grow = Number(view.grow) || 0;
  if (document.activeElement !== parts.grow) parts.grow.value = view.grow;
  const slower = seconds / real < 1.01 ? "real time" : `${number(seconds / real, 2)} times slower`;
  own.tellPace(share, motion.time_scale_s ? slower : `${number(seconds, 2)} s per load period`);
  put(parts.grown, own.stage.magnified());
}

/** The present moment on the time slider and in digits. */
export const moment = (time, units) => own.tellMoment(time, units, units.time.k * own.stage.length < 0.1 ? 5 : 3);
