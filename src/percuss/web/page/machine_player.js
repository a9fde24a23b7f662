// Play and pause a machine, the slider of its time, and how slowly it is shown: from real time to a minute a cycle.

import { h, put } from "./dom.js";
import { number, withUnit } from "./format.js";
import { show, view } from "./state.js";

const USUAL = 3; // seconds that a cycle takes at first
const LONGEST = 60;
const parts = { told: 0 };

/** The rows below the stage. */
export function machinePlayer(stage) {
  parts.stage = stage;
  parts.play = h("button", { type: "button", class: "main", id: "machine-play", onclick: toggleMachine }, "Play");
  parts.scrub = h("input", {
    type: "range",
    id: "machine-scrub",
    min: 0,
    max: 1000,
    step: 1,
    "aria-label": "Time in the cycle",
    oninput: (event) => ((parts.held = true), pauseMachine(), stage.seek((stage.length * event.target.value) / 1000)),
  });
  parts.time = h("output", { class: "time", for: "machine-scrub" }, "–");
  parts.slowly = h("output", { for: "machine-slow" });
  parts.slow = h("input", {
    type: "range",
    id: "machine-slow",
    min: 0,
    max: 100,
    step: 1,
    oninput: (event) => (show({ machineSlow: event.target.value }), machinePace()),
  });
  return [
    h("div", { class: "play" }, parts.play, parts.scrub, parts.time),
    h(
      "div",
      { class: "knobs" },
      h("label", { class: "pick" }, h("span", {}, "Slow motion: ", parts.slowly), parts.slow),
    ),
  ];
}

export function toggleMachine() {
  parts.held = parts.stage.playing;
  if (parts.stage.playing) return pauseMachine();
  play();
}

/** A machine has come: it plays by itself unless the user has paused. */
export const beginMachine = () => !parts.held && !parts.stage.playing && play();

function play() {
  if (!(parts.stage.length > 0)) return;
  parts.stage.play();
  put(parts.play, "Pause");
}

export function pauseMachine() {
  if (parts.stage.playing) parts.stage.pause();
  put(parts.play, "Play");
}

/** How fast the cycle is shown, as the view has it; dimensionless, real time is a second a cycle. */
export function machinePace() {
  const { motion, length } = parts.stage;
  if (!motion || !(length > 0)) return;
  const one = length / (motion.cycles ?? 1); // of the blows from a start each counts as a cycle
  const real = motion.scales ? one : 1;
  const longest = Math.max(LONGEST, 2 * real);
  const usual = Math.log(Math.max(USUAL, real) / real) / Math.log(longest / real);
  const share = view.machineSlow === "" ? usual : Math.min(Math.max(Number(view.machineSlow) / 100 || 0, 0), 1);
  const seconds = real * (longest / real) ** share;
  parts.stage.rate = one / seconds;
  if (document.activeElement !== parts.slow) parts.slow.value = 100 * share;
  const slower = seconds / real;
  const words = !motion.scales
    ? `${number(seconds, 2)} s per cycle`
    : slower < 1.01
      ? "real time"
      : `${number(slower, 2)} times slower, ${number(seconds, 2)} s per cycle`;
  put(parts.slowly, words);
  parts.slow.setAttribute("aria-valuetext", words);
}

/** The present moment on the time slider and in digits. */
export function machineMoment(time, units) {
  const { stage, scrub } = parts;
  if (document.activeElement !== scrub || stage.playing) scrub.value = stage.length ? (1000 * time) / stage.length : 0;
  const now = performance.now();
  if (stage.playing && now - parts.told < 100) return; // nobody reads digits that change with every frame
  parts.told = now;
  const words = withUnit(time * units.time.k, units.time.name, 4);
  put(parts.time, words);
  scrub.setAttribute("aria-valuetext", words);
}
