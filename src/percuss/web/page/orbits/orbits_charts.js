// Pictures of the steady motions: the curve and its level, the branches over the load factor, the load at the blow, the
// multipliers.

import { strands } from "../branches/branches_picture.js";
import { RISING } from "../branches/branches_walk.js";
import { post } from "../core/api.js";
import { div, latest } from "../core/dom.js";
import { angle, counted, inUnit, number, scaleOf } from "../core/format.js";
import { whenever } from "../core/signals.js";
import { chosen, data, fullOrbits, isHeld, uptodate, view } from "../core/state.js";
import { Chart, PHASES, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";

/** @typedef {Record<string, any>} Quick */
/** @typedef {Record<string, any>} Orbit */

const EDGE = 1.6; // how far the panel of the multipliers reaches; what lies beyond is drawn at its edge
const TURN = { from: 0, to: 2 * Math.PI, ticks: PHASES };
/** @type {Record<string, Chart>} */
const charts = {};

export function orbitCharts() {
  charts.phase = new Chart("Impact phases: where the curve meets the level");
  charts.load = new Chart("The load, and the moment of impact");
  charts.branches = new Chart("Impact phase against the load factor");
  charts.circle = new Chart("Multipliers: how a disturbance grows or dies out", { kind: "square" });
  const { phase, load, branches, circle } = charts;
  return { why: load.figure, rest: div("grid", phase.figure, branches.figure, circle.figure) };
}

/** The load at the moment of impact always; the others while they are in sight. @param {Quick | null} quick @param {boolean} inSight */
export function drawOrbitCharts(quick, inSight) {
  if (quick?.curve) loads(quick);
  else clear(charts.load);
  if (!inSight) return;
  if (quick?.curve) phases(quick);
  else clear(charts.phase);
  circle();
  drawBranches();
  charts.phase.canvas.dataset.change = String(quick?.changed ?? -1); // which change of the case is drawn
}

const NOTHING = { x: { label: "", from: 0, to: 1 }, y: { label: "", from: 0, to: 1 } };

/** @param {Chart} chart */
const clear = (chart) => chart.draw({ ...(chart.spec ?? NOTHING), items: [] });

/** Where the motion is on the curves of B77's law, also when its blows take time by another law. @param {Orbit} orbit @returns {number} */
const onTheCurve = (orbit) => orbit.phase_b77 ?? orbit.phase;

/** The orbits as points: a disc is stable, a ring unstable, a cross cannot happen; the one looked at is larger.
 * @param {Quick} quick @param {(orbit: Orbit) => number} x @param {(orbit: Orbit) => number} y @returns {any[]} */
function points(quick, x, y) {
  const { kinds } = theme();
  const now = chosen()?.number;
  const full = fullOrbits();
  return quick.orbits.map((/** @type {Orbit} */ orbit, /** @type {number} */ i) => {
    const [shape, name] =
      full[i]?.admissible === false
        ? ["cross", "not possible"]
        : orbit.stable
          ? ["disc", "stable"]
          : ["ring", "unstable"];
    const look = { shape, name, colour: kinds[shape === "disc" ? 2 : 1], size: now === i + 1 ? 8 : 6 };
    return { type: "points", x: [x(orbit)], y: [y(orbit)], ...look };
  });
}

/** @param {Quick} quick */
function phases(quick) {
  const { ink, kinds } = theme();
  const { curve, level, orbits } = quick;
  const { phase, rigid_velocity: velocity } = curve;
  const [low, high] = span([velocity]);
  const reach = high - low;
  const near = level > low - reach && level < high + reach ? span([velocity, [level]]) : [low, high];
  charts.phase.draw({
    x: { label: inUnit("phase of the load", "rad"), ...TURN },
    y: { label: inUnit("v_f", "dimensionless"), from: near[0], to: near[1] },
    items: [
      { type: "line", x: phase, y: velocity, colour: ink, width: 2.4, name: "rigid velocity under the load, v_f" },
      { type: "level", at: level, colour: kinds[0], dash: [8, 5], name: "level c" },
      { type: "label", x: TURN.to, y: level, align: "right", text: `c = ${number(level)}`, colour: kinds[0] },
      ...points(quick, onTheCurve, () => level),
    ],
    about: `The curve v_f over the phase of the load with its level ${number(level)}: ${counted(orbits.length, "steady motion")}`,
  });
}

/** @param {Quick} quick */
function loads(quick) {
  const { ink, kinds } = theme();
  const { phase, load } = quick.curve;
  const force = data.info?.scales?.force_N;
  const scale = force ? scaleOf(Math.max(...load.map(Math.abs)) * force, "N") : { factor: 1, unit: "" };
  const k = (force ?? 1) * scale.factor;
  const values = load.map((/** @type {number} */ value) => value * k);
  const [from, to] = span([values, [0]]);
  const wave = quick.orbits[0]?.waveform;
  const band = { type: "band", from: wave?.force_lower * k, to: wave?.force_upper * k, colour: kinds[2], alpha: 0.22 };
  const forceAt = (/** @type {Orbit} */ orbit) => orbit.waveform.force * k;
  const words = quick.orbits.map(
    (/** @type {Orbit} */ orbit, /** @type {number} */ i) =>
      `motion ${i + 1} strikes at ${angle(orbit.phase)} where the load is ${number(forceAt(orbit))} ${scale.unit}`,
  );
  charts.load.draw({
    x: { label: inUnit("phase of the load", "rad"), ...TURN },
    y: { label: inUnit(scale.unit ? "load" : "load p", scale.unit || "dimensionless"), from, to },
    items: [
      ...(wave ? [{ ...band, name: "stable if the blow falls here (rigid, undamped)" }] : []),
      { type: "level", at: 0, colour: ink, width: 1 },
      { type: "line", x: phase, y: values, colour: ink, width: 2.4, name: "load" },
      ...points(quick, onTheCurve, forceAt),
    ],
    about: `The load over its period; ${words.join("; ")}`,
  });
}

/** The multipliers of the motion that is looked at. */
function circle() {
  const { ink, kinds, muted } = theme();
  const found = chosen();
  const { largest, ...more } = found?.quick.multipliers ?? {};
  const [rigid, values] = [more.rigid ?? [], more.values ?? []]; // null until the drawer is open
  /** @type {{ x: number, y: number, inside: boolean }[]} */
  const held = values.map((/** @type {number[]} */ [re, im]) => {
    const size = Math.hypot(re, im);
    const cut = Math.min(size, EDGE * 0.97) / (size || 1);
    return { x: re * cut, y: im * cut, inside: size < 1 };
  });
  const some = (/** @type {typeof held} */ list, /** @type {Record<string, any>} */ look) =>
    list.length ? [{ type: "points", x: list.map(({ x }) => x), y: list.map(({ y }) => y), ...look }] : [];
  const axis = { from: -EDGE, to: EDGE, ticks: ["−1", "0", "1"].map((text, i) => [i - 1, text]) };
  charts.circle.draw({
    x: { ...axis, label: "real" },
    y: { ...axis, label: "imaginary" },
    equal: true,
    items: [
      { type: "level", at: 0, colour: muted, width: 0.7 },
      { type: "level", at: 0, axis: "x", colour: muted, width: 0.7 },
      { type: "circle", radius: 1, colour: muted, width: 2 },
      ...some(
        held.filter(({ inside }) => inside),
        { shape: "dot", colour: kinds[2], name: "inside: dies out", size: 4 },
      ),
      ...some(
        held.filter(({ inside }) => !inside),
        { shape: "ring", colour: kinds[1], name: "outside: grows", size: 6 },
      ),
      ...some(rigid.map((/** @type {number} */ i) => held[i]).filter(Boolean), {
        shape: "ring",
        colour: ink,
        name: "the two of the rhythm",
        size: 9,
      }),
      ...(largest ? [{ type: "label", x: -EDGE, y: EDGE, dx: 8, dy: 18, text: `largest ${number(largest)}` }] : []),
    ],
    about: found
      ? `Multipliers of motion ${found.number} on the unit circle; the largest has modulus ${number(largest)}`
      : "No multipliers",
  });
}

/* the impact phases of all steady motions against the load factor */

/** @type {any} */
let branches = null;
let branched = -1; // the change of the case whose branches are shown

/** Ask for the branches when the case has come to rest; along the load factor they stay as they are. */
export function wantBranches() {
  if (view.panel !== "orbits" || isHeld() || !uptodate() || branched === data.changed) return;
  askBranches({ tables: data.tables, m: view.m, changed: data.changed });
}

whenever(
  () => data.changed,
  (changed) => {
    const along = data.moved?.length === 1 && data.moved[0] === "load_factor";
    if (along && branched === changed - 1 && data.quick?.load_factor <= branches.load_factor.at(-1)) branched = changed;
  },
);

const askBranches = latest(
  (/** @type {{ tables: any, m: number, changed: number }} */ { tables, m }) =>
    post("curves", { case: tables, periods: m, points: 2, branches: 160 }),
  (found, { changed }) => {
    branches = found.branches;
    branched = changed;
    drawBranches();
  },
  () => {
    branches = null;
    branched = -1;
  },
);

function drawBranches() {
  if (!branches || view.panel !== "orbits") return;
  const { kinds, ink } = theme();
  const { load_factor: factors, phase: phases, reduced_stable: stables } = branches;
  const lines = phases.flatMap((/** @type {(number | null)[]} */ phase, /** @type {number} */ k) => {
    const rows = phase.map((one, i) => ({ value: factors[i], times: [one ?? NaN], speeds: [], stable: stables[k][i] }));
    const paths = [phase.map((one, i) => (one === null || factors[i] === null ? -1 : 0))];
    const { stable, unstable } = strands({ rows, paths }, RISING.phase);
    return [
      { ...unstable, colour: kinds[1], width: 2, dash: [6, 4], name: "unstable" },
      { ...stable, colour: kinds[2], width: 3.5, name: "stable" },
    ];
  });
  const now = data.quick?.load_factor ?? branches.now;
  const design = { type: "level", at: now, axis: "x", colour: ink, dash: [2, 3], width: 1.5 };
  const orbits = data.quick ? points(data.quick, () => now, onTheCurve) : [];
  const known = factors.filter((/** @type {number | null} */ one) => one !== null);
  const [from, to] = [Math.min(...known, now ?? Infinity), Math.max(...known, now ?? -Infinity)];
  charts.branches.draw({
    x: { label: "load factor p₀/p₁", from, to },
    y: { label: inUnit("impact phase", "rad"), ...TURN },
    items: [
      ...lines,
      ...(now === null ? [] : [{ ...design, name: "the present load factor" }]),
      ...orbits.map((item) => ({ ...item, name: "" })),
    ],
    about: "Impact phases of the steady motions against the load factor; both branches meet in the fold",
  });
}
