// Play and pause a machine, and how slowly it is shown: from real time to a minute a cycle.

import { number } from "../core/format.js";
import { paceOf, Player } from "../motion/player.js";
import { view } from "../core/state.js";

const USUAL = 3; // seconds that a cycle takes at first
const LONGEST = 60;
let player = null;

/** The rows below the stage. */
export function machinePlayer(stage) {
  player = new Player(stage, { id: "machine-", about: "Time in the cycle", slow: "machineSlow", paced: machinePace });
  return player.rows();
}

export const toggleMachine = () => player.toggle();
export const beginMachine = () => player.begin();
export const pauseMachine = () => player.stop();
export const machineMoment = (time, units) => player.tellMoment(time, units);

/** How fast the cycle is shown, as the view has it; dimensionless, real time is a second a cycle. */
export function machinePace() {
  const { motion, length } = player.stage;
  if (!motion || !(length > 0)) return;
  const one = length / (motion.cycles ?? 1); // of the blows from a start each counts as a cycle
  const real = motion.scales ? one : 1;
  const { share, seconds } = paceOf(view.machineSlow, { real, usual: USUAL, longest: Math.max(LONGEST, 2 * real) });
  player.stage.rate = one / seconds;
  const slower = seconds / real;
  const each = `${number(seconds, 2)} s per cycle`;
  const words = slower < 1.01 ? "real time" : `${number(slower, 2)} times slower, ${each}`;
  player.tellPace(share, motion.scales ? words : each);
}
