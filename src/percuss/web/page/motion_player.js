// Play and pause, the time slider, slow motion and the stretch: the row below the stage.

import { h, put } from "./dom.js";
import { number, withUnit } from "./format.js";
import { show, view } from "./state.js";

const parts = { told: 0 };

/** The row below the stage. */
export function player(stage) {
  parts.stage = stage;
  parts.play = h("button", { type: "button", class: "main", id: "play", onclick: toggle }, "Play");
  parts.scrub = h("input", {
    type: "range",
    id: "scrub",
    min: 0,
    max: 1000,
    step: 1,
    "aria-label": "Time in the motion",
    oninput: (event) => ((parts.held = true), stop(), parts.stage.seek((parts.stage.length * event.target.value) / 1000)),
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

/** Play, or pause, as the user wants it; a motion that comes later stays as the one before was left. */
export function toggle() {
  parts.held = parts.stage.playing;
  if (parts.stage.playing) return stop();
  play();
}

/** A motion has come: it plays by itself unless the user has paused. */
export const begin = () => !parts.held && !parts.stage.playing && play();

function play() {
  parts.stage.play();
  put(parts.play, "Pause");
}

export function stop() {
  parts.stage.pause();
  put(parts.play, "Play");
}

/** How long a load period is shown, in seconds: from real time (or a second) to minutes, evenly in ratios. */
function pace() {
  const { motion } = parts.stage;
  const real = motion?.time_scale_s ? 2 * Math.PI * motion.time_scale_s : 1;
  const chosenShare = view.slow === "" ? null : Number(view.slow) / 100;
  const part = (2 * Math.PI) / parts.stage.length; // of a zoom that lasts some seconds, a load period takes hours
  const longest = view.zoom ? 30 * part : 120;
  const usual = Math.log(Math.max(view.zoom ? 8 * part : 2.5, real) / real) / Math.log(longest / real);
  const share = chosenShare ?? Math.min(Math.max(usual, 0), 1);
  return { share, seconds: real * (longest / real) ** share, real };
}

/** The pace and the stretch as the view has them. */
export function knobs() {
  const { motion } = parts.stage;
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
    : `${number(seconds, 2)} s per load period`;
  put(parts.slowly, words);
  put(parts.grown, parts.stage.magnified());
}

/** The present moment on the time slider and in digits. */
export function moment(time, units) {
  const { stage, scrub } = parts;
  if (document.activeElement !== scrub || stage.playing) scrub.value = stage.length ? (1000 * time) / stage.length : 0;
  const now = performance.now();
  if (stage.playing && now - parts.told < 100) return; // nobody reads digits that change with every frame
  parts.told = now;
  const small = units.time.k * stage.length < 0.1 ? 5 : 3;
  const words = withUnit(time * units.time.k, units.time.name, small);
  put(parts.time, words);
  scrub.setAttribute("aria-valuetext", words);
}
