// A machine over its cycle: position, force and velocity with a running mark; its work as a loop; energy and rate over
// the pressure with the present point.

import { h } from "../core/dom.js";
import { inUnit, number, scaleOf, si } from "../core/format.js";
import { placeIn, valueIn } from "../core/rising.js";
import { Chart, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";

/** A machine as the server tells it: its answer, and its motion as arrays. @typedef {Record<string, any>} Machine */
/** @typedef {import("../motion/player.js").Unit} Unit */
/** Factors and units in which a machine is told.
 * @typedef {{ time: Unit, length: Unit, force: Unit, speed: Unit, energy: Unit, rate: Unit }} Units */

/** @type {Record<string, Chart>} */
const charts = {};
/** The latest over the pressure; null before there is one. @type {any} */
let curve;

const TITLES = {
  position: "Centre of the piston over time",
  force: "Force on the piston, positive toward the wall",
  velocity: "Velocity, positive toward the wall",
  loop: "Force over position: the loop is the work of a cycle",
  energy: "Blow energy over the pressure",
  rate: "Blow rate over the pressure",
};

export function machineCharts() {
  for (const [name, title] of Object.entries(TITLES)) charts[name] = new Chart(title);
  const figures = ["energy", "rate", "force", "velocity"].map((name) => charts[name].figure);
  const rest = h("div", { class: "grid", id: "machine-charts" }, figures);
  return { strip: charts.position.figure, why: charts.loop.figure, rest };
}

/** @param {Machine} machine @returns {Units} */
export function machineUnits({ units, arrays, forces, answer, scales }) {
  const plain = { k: 1, name: "" };
  if (units !== "SI") return { time: plain, length: plain, force: plain, speed: plain, energy: plain, rate: plain };
  const sized = (/** @type {number} */ size, /** @type {string} */ unit) => {
    const { factor: k, unit: name } = scaleOf(size, unit);
    return { k, name };
  };
  const stroke = (answer.stroke ?? 0) * scales.length_m;
  return {
    time: sized(Math.min((answer.period ?? 0) * scales.time_s, 0.9), "s"),
    length: sized(Math.min(stroke || 1e-3, 0.9), "m"),
    force: sized(Math.max(...(arrays.force ?? forces).map(Math.abs)), "N"),
    speed: { k: 1, name: "m/s" },
    energy: sized(answer.si?.blow_energy_J ?? 1, "J"),
    rate: { k: 60, name: "1/min" },
  };
}

/** @param {Machine} motion @param {Units} units */
export function drawMachine(motion, { time, length, force, speed }) {
  const { arrays, started } = motion;
  if (!arrays.t) return;
  const { kinds } = theme();
  const [t, place, forces, speeds] = [
    scaled(arrays.t, time.k),
    scaled(arrays.centre, length.k),
    scaled(arrays.force, force.k),
    scaled(arrays.velocity, speed.k),
  ];
  const x = {
    label: inUnit(started ? "time after the start" : "time after the blow", time.name),
    from: 0,
    to: t[t.length - 1],
  };
  const low = Math.min(...place);
  position(motion, { time, length }, x, { type: "line", x: t, y: place, colour: kinds[0], name: "centre" }, 1.15 * low);
  over(charts.force, x, inUnit("force", force.name), { x: t, y: forces, colour: kinds[0] });
  over(charts.velocity, x, inUnit("velocity", speed.name), {
    x: scaled(arrays.velocity_t, time.k),
    y: speeds,
    colour: kinds[1],
  });
  const along = { label: inUnit("position", length.name), from: 1.06 * low, to: -0.06 * low || 1 };
  over(charts.loop, along, inUnit("force", force.name), { x: place, y: forces, colour: kinds[0] });
}

/** @param {ArrayLike<number>} values @param {number} factor */
const scaled = (values, factor) => Array.from(values, (value) => value * factor);

/** A line over an axis, and the level 0. @param {Chart} chart @param {any} x @param {string} label
 * @param {{ x: number[], y: number[], colour: string }} line */
function over(chart, x, label, line) {
  const [from, to] = span([line.y, [0]]);
  const items = [
    { type: "level", at: 0, colour: theme().ink },
    { type: "line", ...line },
  ];
  chart.draw({ x, y: { label, from, to }, items });
}

/** @param {Machine} motion @param {{ time: Unit, length: Unit }} units @param {any} x @param {any} line
 * @param {number} low where the plane ends */
function position(motion, { length, time }, x, line, low) {
  const { arrays, answer, scales, units } = motion;
  const { kinds, ink, surface } = theme();
  const [meters, seconds] = [scales?.length_m ?? 1, scales?.time_s ?? 1];
  const ports = answer.machine.ports.flatMap((/** @type {any} */ { behind, to }, /** @type {number} */ i) => {
    const at = -behind * meters * length.k;
    if (behind === null || at < low) return []; // it is never reached
    const label = { type: "label", x: 0.62 * x.to, y: at, text: `port ${i + 1} → ${to}`, dy: at > 0.1 * low ? 14 : -6 };
    return [
      { type: "level", at, colour: kinds[3], dash: [6, 4], name: "ports" },
      { ...label, colour: kinds[3] },
    ];
  });
  const marks = (/** @type {{ time: number }[]} */ events, /** @type {Record<string, any>} */ look) => {
    const times = events.map((one) => one.time * seconds);
    const y = times.map((at) => valueIn(arrays.centre, placeIn(arrays.t, at)) * length.k);
    return { type: "points", x: scaled(times, time.k), y, size: 5, ...look };
  };
  const stroke = answer.stroke * meters;
  charts.position.draw({
    x,
    y: { label: inUnit("position", length.name), from: low, to: -0.12 * low || 1 },
    items: [
      { type: "level", at: 0, colour: ink, name: "tool or wall" },
      ...ports,
      line,
      marks(answer.ports, { shape: "ring", colour: kinds[3], name: "port passed" }),
      marks(answer.valve, { shape: "diamond", colour: kinds[1], name: "valve switches" }),
      marks(answer.blows, { shape: "disc", colour: kinds[4] ?? surface, name: "blow" }),
    ],
    about: `Position over the cycle: a stroke of ${units === "SI" ? si(stroke, "m", 3) : number(stroke, 3)}`,
  });
}

/** Keep the curve of an answer that has one, and the pressure that it belongs to. @param {Machine} motion */
export function keepCurve(motion) {
  const { more } = motion;
  if (!more || curve?.more === more) return;
  /** @type {Record<string, number | null>[]} */
  const rows = more.pressure_curve;
  const base = atPresent(more, more.si);
  const values = (/** @type {"energy" | "rate"} */ key) =>
    rows.map(({ [key]: change }) => (change === null ? null : (base[key] ?? NaN) * (1 + change)));
  curve = rows.length && {
    more,
    changed: motion.changed,
    push: pushOf(motion),
    bar: barOf(motion),
    body: bodyOf(more.modes),
    factors: rows.map((row) => row.pressure),
    energy: values("energy"),
    rate: values("rate"),
  };
}

/** The greatest force of the valve, which grows with the pressure. @param {Machine} machine */
const pushOf = ({ answer }) =>
  Math.max(.../** @type {number[]} */ (Object.values(answer.machine.states)).map((force) => Math.abs(force)));

/** The pressure of the supply; null where there is none. @param {Machine} machine @returns {number | null} */
const barOf = ({ pressure_Pa: pressure }) => (pressure ? pressure / 1e5 : null);

const bodyOf = (/** @type {number} */ modes) => (modes ? `${modes} elastic modes` : "rigid piston");

/** Energy and rate of a cycle, in SI where it has figures in SI; null where there is none. @param {any} cycle
 * @param {any} figures @returns {{ energy: number | null, rate: number | null }} */
function atPresent(cycle, figures) {
  if (!cycle?.blows.length) return { energy: null, rate: null };
  const most = Math.max(...cycle.blows.map((/** @type {any} */ { energy }) => energy));
  return {
    energy: figures?.blow_energy_J ?? most,
    rate: figures?.blow_rate_Hz ?? cycle.blows.length / cycle.period,
  };
}

/** Energy and rate over the pressure, the present point, and that of a rigid piston beside it once the elastic one is
 * known; the curve may be that of a moment ago. @param {Machine} motion @param {Units} units */
export function drawCurve(motion, units) {
  const { kinds, ink, muted } = theme();
  const { modes, more, runs, answer, changed } = motion;
  const now = runs ? atPresent(answer, answer.si) : null;
  const rigid = modes ? atPresent(more?.rigid, more?.rigid_si) : null;
  const bar = barOf(motion);
  const here = bar ?? (curve ? pushOf(motion) / curve.push : 1);
  const per = bar ? (curve?.bar ?? bar) : 1;
  const fresh = curve?.changed === changed;
  const look = fresh ? { dash: [] } : { dash: [5, 4], colour: muted };
  const x = {
    label: bar ? "pressure of the supply [bar]" : "forces of the valve, relative",
    from: Math.min(0.5 * per, 0.95 * here),
    to: Math.max(1.5 * per, 1.05 * here),
  };
  const draw = (/** @type {"energy" | "rate"} */ key, /** @type {string} */ colour) => {
    const { k, name: unit } = units[key];
    const points = [
      { value: rigid?.[key], shape: "ring", size: 10, name: "now, rigid piston" },
      { value: now?.[key], shape: "diamond", size: 7, name: `now, ${bodyOf(modes)}` },
    ].flatMap(({ value, ...point }) =>
      Number.isFinite(value) ? [{ type: "points", x: [here], y: [Number(value) * k], colour: ink, ...point }] : [],
    );
    const ys = (curve?.[key] ?? []).map((/** @type {number | null} */ one) => (one === null ? null : one * k));
    const name = `${curve?.body}${fresh ? "" : ", of a moment ago"}`;
    const xs = curve && scaled(curve.factors, per);
    const items = [...(curve ? [{ type: "line", x: xs, y: ys, colour, ...look, name }] : []), ...points];
    const [, to] = span([ys, ...points.map(({ y }) => y), [0]], 0.08);
    const about = `blow ${key} over the pressure: ${items.map((item) => item.name).join(", ")}`;
    charts[key].draw({ x, y: { label: inUnit(`blow ${key}`, unit), from: 0, to }, items, about });
  };
  draw("energy", kinds[4]);
  draw("rate", kinds[0]);
}

/** The present moment on the charts. @param {Machine} motion @param {Units} units @param {number} time */
export function followMachine({ arrays }, units, time) {
  if (!arrays.t) return;
  for (const name of ["position", "force", "velocity"]) charts[name].over([], time * units.time.k);
}
