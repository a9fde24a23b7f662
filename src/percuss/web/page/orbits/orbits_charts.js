// Pictures of the steady motions: the curve and its level, the branches, the load at the blow, the multipliers.

import { Chart, PHASES, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { h } from "../core/dom.js";
import { angle, counted, inUnit, number, scaleOf } from "../core/format.js";
import { branchChart, drawBranches } from "./orbits_branches.js";
import { chosen, data } from "../core/state.js";

const EDGE = 1.6; // how far the panel of the multipliers reaches; what lies beyond is drawn at its edge
const parts = {};

export function orbitCharts() {
  parts.phase = new Chart("Impact phases: where the curve meets the level");
  parts.load = new Chart("The load, and the moment of impact");
  parts.circle = new Chart("Multipliers: how a disturbance grows or dies out", { kind: "square" });
  const card = (chart) => h("div", { class: "card" }, chart.figure);
  const charts = [parts.phase, branchChart(points), parts.load, parts.circle];
  return h("div", { class: "grid" }, charts.map(card));
}

export function drawOrbitCharts(quick) {
  phases(quick);
  loads(quick);
  circle(quick);
  drawBranches();
  parts.phase.canvas.dataset.change = String(quick?.changed ?? -1); // which change of the case is drawn
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

/** Where the motion is on the curves of B77's law, also when its blows take time by another law. */
const onTheCurve = (orbit) => orbit.phase_b77 ?? orbit.phase;

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
      onTheCurve,
      () => level,
    ),
  ];
  const found = counted(quick.orbits.length, "steady motion");
  const words = `The curve v_f over the phase of the load with its level ${number(level)}: ${found}`;
  parts.phase.draw({
    x: { label: inUnit("phase of the load", "rad"), from: 0, to: 2 * Math.PI, ticks: PHASES },
    y: { label: inUnit("v_f", "dimensionless"), from: near[0], to: near[1] },
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
      onTheCurve,
      (o) => o.waveform.force * k,
    ),
  ].filter(Boolean);
  const words = quick.orbits.map(
    (o, i) =>
      `motion ${i + 1} strikes at ${angle(o.phase)} where the load is ${number(o.waveform.force * k)} ${scale.unit}`,
  );
  parts.load.draw({
    x: { label: inUnit("phase of the load", "rad"), from: 0, to: 2 * Math.PI, ticks: PHASES },
    y: { label: inUnit(scale.unit ? "load" : "load p", scale.unit || "dimensionless"), from, to },
    items,
    about: `The load over its period; ${words.join("; ")}`,
  });
}

function circle(quick) {
  const { ink, kinds, muted } = theme();
  const found = chosen();
  const rigid = found?.quick.multipliers?.rigid ?? [];
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
    some(
      rigid.map((i) => held[i]).filter(Boolean),
      "ring",
      ink,
      "the two of the rhythm",
      9,
    ),
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
}
