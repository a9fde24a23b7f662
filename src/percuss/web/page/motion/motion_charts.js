// Pictures of a motion: the striking end over time, its phase portrait, and every impact as a point.

import { Chart, PHASES, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { once } from "./stage.js";
import { counted, inUnit, scaleOf } from "../core/format.js";
import { placeIn, valueIn } from "../core/rising.js";

/** A motion of the server. @typedef {import("./stage.js").Motion} Motion */
/** @typedef {import("./player.js").Unit} Unit */
/** @typedef {{ length: Unit, time: Unit, speed: Unit }} Units */
/** @typedef {Float32Array | Float64Array} Values */

/** @type {Record<"history" | "portrait" | "poincare", Chart>} */
const charts = {
  history: new Chart("The striking end over time"),
  portrait: new Chart("Phase portrait: speed over distance; click to start there"),
  poincare: new Chart("Each impact: its phase and its speed"),
};

/** The figures of the three charts; a click into the phase portrait tells `picked` its point.
 * @param {(at: { x: number, y: number }) => void} picked */
export function motionCharts(picked) {
  const { history, portrait, poincare } = charts;
  const { canvas } = portrait;
  canvas.id = "portrait";
  canvas.style.cursor = "crosshair";
  canvas.addEventListener("click", (event) => {
    const at = portrait.at(event);
    if (at) picked(at);
  });
  return { history: history.figure, portrait: portrait.figure, poincare: poincare.figure };
}

/** The blows of the stretch that is shown; one at its end is the one at its beginning again, and counts once.
 * @param {Motion} motion @returns {any[]} */
export function blowsOf({ begin, end, period, blows }) {
  const struck = blows.filter((/** @type {any} */ { kind }) => kind === "impact");
  return period ? once(struck, end - begin) : struck;
}

/** In what the motion is told: factors from its plain numbers, and their units.
 * @param {Motion} motion @returns {Units} */
export function unitsOf(motion) {
  const { arrays } = motion;
  const metre = motion.length_scale_m;
  const second = motion.time_scale_s;
  const deepest = Math.max(
    ...Array.from(arrays.end_gap, (/** @type {number} */ v) => (Number.isFinite(v) ? Math.abs(v) : 0)),
  );
  const length = metre ? scaleOf(deepest * metre, "m") : { factor: 1, unit: "" };
  const time = second ? scaleOf((motion.end - motion.begin) * second, "s") : { factor: 1, unit: "rad" };
  return {
    length: { k: (metre ?? 1) * length.factor, name: length.unit },
    time: { k: (second ?? 1) * time.factor, name: time.unit },
    speed: { k: metre && second ? metre / second : 1, name: metre ? "m/s" : "" },
  };
}

/** @param {string} name @param {Unit} unit */
const labelOf = (name, unit) => inUnit(name, unit.name);
/** @param {Values} list @param {number} k */
const times = (list, k) => Float64Array.from(list, (value) => value * k);

/** The pictures of a motion. @param {Motion} motion @param {Units} units */
export function drawCharts(motion, units) {
  const { kinds, muted } = theme();
  const { arrays } = motion;
  const t = times(arrays.end_t, units.time.k);
  const gap = times(arrays.end_gap, units.length.k);
  const speed = times(arrays.end_velocity, units.speed.k);
  /** @type {{ time: number, impact_velocity: number }[]} */
  const struckAt = motion.blows.filter((/** @type {any} */ b) => b.kind === "impact" || b.kind === "chatter");
  const [low] = span([gap]);
  const wall = { type: "level", at: 0, colour: muted, width: 3, name: "the wall" };
  const disc = { type: "points", shape: "disc", colour: kinds[1], size: 5 };
  const at0 = struckAt.map(() => 0);
  const marks = { ...disc, x: struckAt.map(({ time }) => time * units.time.k), y: at0, name: "blow" };
  const x = { label: labelOf("time", units.time), from: 0, to: (motion.end - motion.begin) * units.time.k || 1 };
  const distance = { label: labelOf("distance from the wall", units.length), from: low, to: -low * 0.12 };
  charts.history.draw({
    x,
    y: distance,
    items: [wall, { type: "line", x: t, y: gap, colour: kinds[0], width: 2, name: "striking end" }, marks],
    about: `Distance of the striking end from the wall over time, ${counted(blowsOf(motion).length, "blow")}`,
  });
  const [vLow, vHigh] = span([speed]);
  const speeds = struckAt.map(({ impact_velocity: one }) => one * units.speed.k);
  const hits = { ...disc, x: at0, y: speeds, name: "just before a blow" };
  charts.portrait.draw({
    x: distance,
    y: { label: labelOf("speed", units.speed), from: vLow, to: vHigh },
    items: [
      { ...wall, axis: "x" },
      { type: "line", x: gap, y: speed, colour: kinds[0], width: 1.6, name: "striking end" },
      hits,
    ],
    about: "Phase portrait: speed of the striking end over its distance from the wall",
  });
  const { poincare_phase: phase, poincare_velocity: velocity, poincare_settled: settledAt } = motion.arrays;
  const v = times(velocity, units.speed.k);
  const some = (/** @type {boolean} */ settled) => {
    const isOne = (/** @type {any} */ _, /** @type {number} */ i) => (settledAt[i] === 1) === settled;
    return { x: phase.filter(isOne), y: v.filter(isOne) };
  };
  const [from, to] = span([v]);
  const items = [
    { type: "points", ...some(false), shape: "dot", size: 2.5, colour: kinds[5], name: "on the way" },
    { type: "points", ...some(true), shape: "disc", size: 5, colour: kinds[1], name: "settled" },
  ].filter((item) => item.x.length);
  charts.poincare.draw({
    x: { label: inUnit("phase of the load at the impact", "rad"), from: 0, to: 2 * Math.PI, ticks: PHASES },
    y: { label: labelOf("striking speed", units.speed), from, to },
    items,
    about: `Poincaré points of ${phase.length} impacts`,
  });
}

/** The present moment, drawn over the pictures. @param {Motion} motion @param {Units} units @param {number} time */
export function followCharts(motion, units, time) {
  const { end_t: t, end_gap: gap, end_velocity: speed } = motion.arrays;
  const at = placeIn(t, time);
  const [x, far, fast] = [time * units.time.k, valueIn(gap, at) * units.length.k, valueIn(speed, at) * units.speed.k];
  const colour = theme().accent;
  charts.history.over([[x, far, colour]], x);
  charts.portrait.over([[far, fast, colour]]);
}
