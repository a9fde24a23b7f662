// Pictures of the steady motions: the curve and its level, the branches, the load at the blow, the multipliers.

import { post } from "./api.js";
import { Chart, PHASES, span } from "./chart.js";
import { theme } from "./colours.js";
import { h, latest, settled } from "./dom.js";
import { angle, number, scaleOf } from "./format.js";
import { chosen, data, view } from "./state.js";

const EDGE = 1.6; // how far the panel of the multipliers reaches; what lies beyond is drawn at its edge
const parts = {};
let branches = null;

export function orbitCharts() {
  parts.phase = new Chart("Impact phases: where the curve meets the level");
  parts.branch = new Chart("Impact phase against the load factor");
  parts.load = new Chart("The load, and the moment of impact");
  parts.circle = new Chart("Multipliers: what becomes of a disturbance", { kind: "square" });
  const card = (chart) => h("div", { class: "card" }, chart.figure);
  return h("div", { class: "grid" }, card(parts.phase), card(parts.branch), card(parts.load), card(parts.circle));
}

export function drawOrbitCharts(quick) {
  phases(quick);
  loads(quick);
  circle(quick);
  branch();
}

const shapeOf = (index, stable) => {
  const full = fullOf(index);
  return full && !full.admissible ? "cross" : stable ? "disc" : "ring";
};

/** The full answer of an orbit, once it has come. */
export function fullOf(index) {
  const full = data.steady?.periods?.[0]?.orbits ?? [];
  return full.length === data.quick?.orbits.length ? full[index] : null;
}

/** The orbits as points: a disc is stable, a ring unstable, a cross cannot happen; the one looked at is larger. */
function points(quick, x, y) {
  const { kinds } = theme();
  const now = chosen()?.number;
  const names = { disc: "stable", ring: "unstable", cross: "not possible" };
  return quick.orbits.map((orbit, i) => {
    const shape = shapeOf(i, orbit.stable);
    return {
      type: "points",
      x: [x(orbit)],
      y: [y(orbit)],
      shape,
      name: names[shape],
      colour: shape === "disc" ? kinds[2] : kinds[1],
      size: now === i + 1 ? 8 : 6,
    };
  });
}

function phases(quick) {
  if (!quick?.curve) return parts.phase.draw(empty(parts.phase.spec));
  const { ink, kinds } = theme();
  const { phase, rigid_velocity: velocity } = quick.curve;
  const [low, high] = span([velocity]);
  const reach = high - low;
  const level = quick.level;
  const near = level > low - reach && level < high + reach ? span([velocity, [level]]) : [low, high];
  const items = [
    { type: "line", x: phase, y: velocity, colour: ink, width: 2.4, name: "rigid velocity under the load, v_f" },
    { type: "level", at: level, colour: kinds[0], dash: [8, 5], name: "level c" },
    { type: "label", x: 2 * Math.PI, y: level, align: "right", text: `c = ${number(level)}`, colour: kinds[0] },
    ...points(
      quick,
      (o) => o.phase,
      () => level,
    ),
  ];
  const words = `The curve v_f over the phase of the load with its level ${number(level)}: ${quick.orbits.length} steady motions`;
  parts.phase.draw({
    x: { label: "phase of the load, rad", from: 0, to: 2 * Math.PI, ticks: PHASES },
    y: { label: "v_f, dimensionless", from: near[0], to: near[1] },
    items,
    about: words,
  });
}

const empty = (spec) =>
  spec ? { ...spec, items: [] } : { x: { label: "", from: 0, to: 1 }, y: { label: "", from: 0, to: 1 }, items: [] };

function loads(quick) {
  if (!quick?.curve) return parts.load.draw(empty(parts.load.spec));
  const { ink, kinds } = theme();
  const { phase, load } = quick.curve;
  const force = data.info?.scales?.force_N;
  const scale = force ? scaleOf(Math.max(...load.map(Math.abs)) * force, "N") : { factor: 1, unit: "" };
  const k = (force ?? 1) * scale.factor;
  const values = load.map((value) => value * k);
  const [from, to] = span([values, [0]]);
  const wave = quick.orbits[0]?.waveform;
  const items = [
    wave && {
      type: "band",
      from: wave.force_lower * k,
      to: wave.force_upper * k,
      colour: kinds[2],
      alpha: 0.22,
      name: "stable if the blow falls here (rigid, undamped)",
    },
    { type: "level", at: 0, colour: ink, width: 1 },
    { type: "line", x: phase, y: values, colour: ink, width: 2.4, name: "load" },
    ...points(
      quick,
      (o) => o.phase,
      (o) => o.waveform.force * k,
    ),
  ].filter(Boolean);
  const words = quick.orbits.map(
    (o, i) =>
      `motion ${i + 1} strikes at ${angle(o.phase)} where the load is ${number(o.waveform.force * k)} ${scale.unit}`,
  );
  parts.load.draw({
    x: { label: "phase of the load, rad", from: 0, to: 2 * Math.PI, ticks: PHASES },
    y: { label: scale.unit ? `load, ${scale.unit}` : "load p, dimensionless", from, to },
    items,
    about: `The load over its period; ${words.join("; ")}`,
  });
}

function circle(quick) {
  const { kinds, muted } = theme();
  const found = chosen();
  const values = found?.quick.multipliers?.values ?? [];
  const held = values.map(([re, im]) => {
    const size = Math.hypot(re, im);
    const cut = Math.min(size, EDGE * 0.97) / (size || 1);
    return [re * cut, im * cut, size];
  });
  const inside = held.filter(([, , size]) => size < 1);
  const outside = held.filter(([, , size]) => size >= 1);
  const some = (list, shape, colour, name, size) =>
    list.length && { type: "points", x: list.map((v) => v[0]), y: list.map((v) => v[1]), shape, colour, name, size };
  const items = [
    { type: "level", at: 0, colour: muted, width: 0.7 },
    { type: "level", at: 0, axis: "x", colour: muted, width: 0.7 },
    { type: "circle", radius: 1, colour: muted, width: 2 },
    some(inside, "dot", kinds[2], "inside: dies out", 4),
    some(outside, "ring", kinds[1], "outside: grows", 6),
  ].filter(Boolean);
  const largest = found?.quick.multipliers?.largest;
  const words = found
    ? `Multipliers of motion ${found.number} on the unit circle; the largest has modulus ${number(largest)}`
    : "No multipliers";
  if (largest) items.push({ type: "label", x: -EDGE, y: EDGE, dx: 8, dy: 18, text: `largest ${number(largest)}` });
  const axis = {
    from: -EDGE,
    to: EDGE,
    ticks: [
      [-1, "−1"],
      [0, "0"],
      [1, "1"],
    ],
  };
  parts.circle.draw({
    x: { ...axis, label: "real" },
    y: { ...axis, label: "imaginary" },
    equal: true,
    items,
    about: words,
  });
  if (quick === null) parts.circle.draw(empty(parts.circle.spec));
}

/** Ask for the branches when the case has come to rest. */
export const wantBranches = settled(
  () => view.panel === "orbits" && data.quick && data.tables && askBranches({ tables: data.tables, m: view.m }),
  60,
);

const askBranches = latest(
  ({ tables, m }) => post("curves", { case: tables, periods: m, points: 2, branches: 160 }),
  (found) => {
    branches = found.branches;
    branch();
  },
  () => {
    branches = null;
  },
);

function branch() {
  if (!branches || view.panel !== "orbits") return;
  const { kinds, ink } = theme();
  const { load_factor: factor, phase, reduced_stable: stable } = branches;
  const torn = (list) =>
    list.map((value, i) =>
      i && value !== null && list[i - 1] !== null && Math.abs(value - list[i - 1]) > Math.PI ? null : value,
    ); // over 2π
  const keep = (list, good, wish) =>
    list.map((value, i) =>
      value !== null && (good[i] === wish || good[i - 1] === wish || good[i + 1] === wish) ? value : null,
    );
  const items = phase.map(torn).flatMap((list, i) => [
    {
      type: "line",
      x: factor,
      y: keep(list, stable[i], false),
      colour: kinds[1],
      width: 2,
      dash: [6, 4],
      name: "unstable",
    },
    {
      type: "line",
      x: factor,
      y: list.map((value, j) => (stable[i][j] ? value : null)),
      colour: kinds[2],
      width: 3.5,
      name: "stable",
    },
  ]);
  const now = data.quick?.load_factor ?? branches.now;
  if (now !== null)
    items.push({
      type: "level",
      at: now,
      axis: "x",
      colour: ink,
      dash: [2, 3],
      width: 1.5,
      name: "the present load factor",
    });
  if (data.quick)
    items.push(
      ...points(
        data.quick,
        () => now,
        (o) => o.phase,
      ).map((item) => ({ ...item, name: "" })),
    );
  const values = factor.filter((v) => v !== null);
  parts.branch.draw({
    x: {
      label: "load factor p₀/p₁",
      from: Math.min(...values, now ?? Infinity),
      to: Math.max(...values, now ?? -Infinity),
    },
    y: { label: "impact phase, rad", from: 0, to: 2 * Math.PI, ticks: PHASES },
    items,
    about: "Impact phases of the steady motions against the load factor; both branches meet in the fold",
  });
}
