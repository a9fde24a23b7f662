// Play, pause and step a blow; the slider of its time, and how slowly it is shown.

import { h, put } from "../core/dom.js";
import { number, withUnit } from "../core/format.js";
import { show, view } from "../core/state.js";
import { tr } from "../core/words.js";

const parts = { playing: false, held: false };

/** The rows below the stage, with a choice of what is shown; `painted(frame)` draws a frame. */
export function blowPlayer(painted, choice) {
  parts.painted = painted;
  const button = (id, words, label, press) =>
    h("button", { type: "button", id, "aria-label": label, onclick: press }, words);
  parts.play = h("button", { type: "button", class: "main", id: "blow-play", "aria-label": "Play", onclick: toggleBlow }, "▶");
  parts.scrub = h("input", {
    type: "range",
    id: "blow-scrub",
    min: 0,
    max: 1,
    step: 1,
    "aria-label": "Time in the blow",
    oninput: (event) => (halt(), paint(Number(event.target.value))),
  });
  parts.time = h("output", { class: "time", for: "blow-scrub" }, "–");
  parts.slowly = h("output", { for: "blow-slow" });
  parts.slow = h("input", {
    type: "range",
    id: "blow-slow",
    min: 1,
    max: 60,
    step: 1,
    oninput: (event) => (show({ blowSlow: Number(event.target.value) }), pace()),
  });
  const steps = [button("blow-back", "◂", "One step back", () => stepBlow(-1)), button("blow-forth", "▸", "One step on", () => stepBlow(1))];
  const slowly = h("label", { class: "pace" }, h("span", { class: "hidden-words" }, "Slow motion"), parts.slow, parts.slowly);
  return h("div", { class: "play" }, parts.play, parts.scrub, parts.time, steps, slowly, choice);
}

/** Another blow; it begins anew unless it is one that a slider has changed. */
export function playBlow(blow, units, again) {
  const share = parts.last ? parts.now / parts.last : 0;
  parts.blow = blow;
  parts.units = units;
  parts.last = blow.arrays.t.length - 1;
  parts.scrub.max = parts.last;
  const now = again ? Math.round(share * parts.last) : 0;
  pace();
  paint(now);
  if (!again && !parts.held && view.panel === "blow" && !matchMedia("(prefers-reduced-motion: reduce)").matches) start();
}

function start() {
  if (!parts.blow || parts.playing) return;
  parts.playing = true;
  says("Pause", "▮▮");
  if (parts.now >= parts.last) parts.now = 0;
  let before = performance.now();
  let place = parts.now;
  const go = (time) => {
    if (!parts.playing) return;
    place += ((time - before) / (1000 * view.blowSlow)) * parts.last;
    before = time;
    if (place >= parts.last) return (paint(parts.last), pauseBlow());
    if (Math.floor(place) !== parts.now) paint(Math.floor(place));
    requestAnimationFrame(go);
  };
  requestAnimationFrame(go);
}

export function pauseBlow() {
  parts.playing = false;
  says("Play", "▶");
}

function says(words, sign) {
  put(parts.play, sign);
  parts.play.setAttribute("aria-label", tr(words));
}

/** The user has paused: later blows stay where they are, too. */
const halt = () => ((parts.held = true), pauseBlow());

export function toggleBlow() {
  if (parts.playing) return halt();
  parts.held = false;
  start();
}

export function stepBlow(by) {
  if (!parts.blow) return;
  halt();
  paint(Math.min(Math.max(parts.now + by, 0), parts.last));
}

function pace() {
  parts.slow.value = view.blowSlow;
  if (!parts.blow) return;
  const slower = view.blowSlow / parts.blow.end;
  const words = parts.blow.units === "SI" ? `1/${number(slower, 2)} speed` : `${number(1 / slower, 2)} rad/s`;
  put(parts.slowly, words);
  parts.slow.setAttribute("aria-valuetext", tr(words));
}

function paint(frame) {
  if (!parts.blow) return;
  parts.now = frame;
  parts.painted(frame);
  if (document.activeElement !== parts.scrub || parts.playing) parts.scrub.value = frame;
  const words = withUnit(parts.blow.arrays.t[frame] * parts.units.time.k, parts.units.time.name, 4);
  put(parts.time, words);
  parts.scrub.setAttribute("aria-valuetext", tr(words));
}
