// The diagram: branches over a parameter, solid where stable and dashed where not, with what happens on them.

import { PHASES, span } from "../pictures/chart.js";
import { looksOfLabels, theme } from "../pictures/colours.js";
import { inUnit, number } from "../core/format.js";
import { stableBetween } from "./branches_rows.js";
import { RISING, rowAt, stretches } from "./branches_walk.js";

/** @typedef {import("./branches_rows.js").Branch} Branch */
/** @typedef {import("./branches_walk.js").Rising} Rising */
/** @typedef {import("../pictures/chart_pen.js").Item} Item */
/** @typedef {{ followed: Branch[], others: Branch[], thin: Branch[] }} Drawn */

/** What can be drawn up the plane, with its unit in SI where the machine has one.
 * @type {Record<string, { label: string, unit: string, si?: string }>} */
export const UP = {
  phase: { label: "impact phase", unit: "rad" },
  speed: { label: "striking speed", unit: "dimensionless", si: "m/s" },
  period: { label: "period of the cycle", unit: "dimensionless", si: "s" },
};

/** What happens on a branch: its words, and its mark where it has one. @type {Record<string, { words: string, shape: string }>} */
export const EVENTS = {
  fold: { words: "fold", shape: "square" },
  flip: { words: "flip: period doubling", shape: "triangle" },
  neimark_sacker: { words: "Neimark–Sacker", shape: "ring" },
  branch_point: { words: "another branch crosses", shape: "ring" },
  corner: { words: "corner where two events meet", shape: "plus" },
  nonsmooth_fold: { words: "fold where two events meet", shape: "square" },
  grazing_touch: { words: "end: touches the wall between impacts", shape: "cross" },
  grazing_impact_dies: { words: "end: an impact dies", shape: "cross" },
  impacts_coalesce: { words: "end: two impacts meet", shape: "cross" },
  sticking: { words: "end: stays on the wall", shape: "cross" },
  load_stops_pushing: { words: "end: the load stops pushing", shape: "cross" },
  resonance: { words: "end: resonance", shape: "cross" },
  period_halving: { words: "begins at a flip", shape: "" },
  parameter_end: { words: "the parameter goes no further", shape: "" },
  limit: { words: "end of the range", shape: "" },
  closed: { words: "closes", shape: "" },
  onset: { words: "end: the chatter meets the next release", shape: "cross" },
  release_lost: { words: "end: the load no longer lets go", shape: "cross" },
  label_changes: { words: "end: other rests come between", shape: "cross" },
  order_lost: { words: "end: two events of the valve change places", shape: "cross" },
  port_not_reached: { words: "end: turns just at a port", shape: "cross" },
  turning_at_port: { words: "end: turns just before another port", shape: "cross" },
  pressure_gone: { words: "end: the pressure is gone", shape: "cross" },
  stall: { words: "end: comes to a standstill", shape: "cross" },
  stopped: { words: "stopped here", shape: "cross" },
  lost: { words: "lost here", shape: "cross" },
};

/** Looks of the lines: those that were followed stand out from the others. */
const FOLLOWED = { stable: 3, unstable: 1.8, dash: [6, 4], mark: 5 };
const OTHER = { stable: 1.7, unstable: 1.1, dash: [4, 3], mark: 3.4 };

/** The family of a label of a machine's cycle is that of the same count of blows. @param {string} label */
export const motionOf = (label) => label.replace(/^(runs|double blow) /, "").replace(/^(?=\d)/, "z=");

/** What to draw: `along` is the parameter, `design` the present place in it, `dots` what simulations settle on.
 * @param {Drawn} branches @param {{ label: string, from: number, to: number, isSI: boolean }} along @param {string} up
 * @param {{ x: number, y: number | null } | null} design @param {Item[]} dots */
export function diagram(branches, along, up, design, dots) {
  const { items: lines, heights } = drawn(branches, up);
  const { ink } = theme();
  const items = [...dots, ...lines];
  if (design) {
    const level = { type: "level", at: design.x, axis: "x", colour: ink, dash: [2, 3], width: 1.5 };
    items.push({ ...level, name: "the present design" });
    if (design.y !== null)
      items.push({ type: "points", x: [design.x], y: [design.y], shape: "diamond", size: 8, colour: ink });
  }
  const [low, high] = span([heights, ...dots.map(({ y }) => y)]);
  const round = up === "phase" && (!heights.length || high - low > Math.PI);
  const y = round ? { from: 0, to: 2 * Math.PI, ticks: PHASES } : { from: low, to: high };
  const { label, unit, si } = UP[up];
  const { followed, others } = branches;
  const words = [...followed.map(told), ...(others.length ? [`${others.length} other branches`] : [])].join("; ");
  return {
    x: along,
    y: { label: inUnit(label, (along.isSI && si) || unit), ...y },
    items,
    about: `${label} over ${along.label}: ${words}. Arrow keys move along a branch.`,
  };
}

/** @param {Branch} branch */
const told = ({ label, points }) =>
  `${label}, ${points.map(({ type, value }) => `${EVENTS[type]?.words ?? type} at ${number(value)}`).join(", ")}`;

/** The last lines: a slider that moves the design leaves them as they are.
 * @type {{ of: any[], items: Item[], heights: number[] }} */
let kept = { of: [], items: [], heights: [] };

/** @param {Drawn} branches @param {string} up */
function drawn({ followed, others, thin }, up) {
  const of = [followed, others, thin, up, theme()];
  if (kept.of.length && of.every((one, i) => one === kept.of[i])) return kept;
  const rising = RISING[up];
  const { ink, muted } = theme();
  const all = [...followed, ...others];
  const looks = looksOfLabels([...new Set(all.map(({ label }) => motionOf(label)))]);
  const lookOf = (/** @type {Branch} */ { label }) => {
    const look = looks.get(motionOf(label));
    return { colour: look?.colour, name: `${look?.name === motionOf(label) ? label : look?.name}, stable` };
  };
  const items = [
    ...followed.map((one) => ({ type: "line", x: [], y: [], ...lookOf(one), width: FOLLOWED.stable })), // in the legend
    ...thin.flatMap((branch) => {
      const { stable, unstable } = strands(branch, rising);
      const lines = [stable, unstable].filter(({ x }) => x.length);
      return lines.map((line) => ({ ...line, colour: muted, width: 0.7, name: "thin: not possible" }));
    }),
    ...others.flatMap((branch) => linesOf(branch, rising, lookOf(branch), OTHER)),
    ...followed.flatMap((branch) => linesOf(branch, rising, lookOf(branch), FOLLOWED)),
    ...(up === "phase" ? followed.flatMap((branch) => restLines(branch, ink)) : []),
    ...marks(followed, rising, ink, FOLLOWED.mark),
    ...marks(others, rising, ink, OTHER.mark),
  ];
  kept = { of, items, heights: all.flatMap(({ rows }) => rows.flatMap(rising)) };
  return kept;
}

/** A branch as a stable and an unstable line, torn where a phase goes round.
 * @param {{ rows: Branch["rows"], paths: number[][] }} branch @param {Rising} rising */
export function strands(branch, rising) {
  const line = () => ({
    type: "line",
    x: /** @type {(number | null)[]} */ ([]),
    y: /** @type {(number | null)[]} */ ([]),
    end: "",
  });
  const lines = { stable: line(), unstable: line() };
  for (const { path, i, from, to } of stretches(branch, rising)) {
    const [row, next] = [branch.rows[i], branch.rows[i + 1]];
    const own = lines[stableBetween(row, next) ? "stable" : "unstable"];
    if (own.end !== `${path} ${i}`) (own.x.push(null, row.value), own.y.push(null, from));
    (own.x.push(next.value), own.y.push(to));
    own.end = `${path} ${i + 1}`;
  }
  return lines;
}

/** @param {Branch} branch @param {Rising} rising @param {{ colour?: string, name: string }} look @param {typeof OTHER} widths @returns {Item[]} */
function linesOf(branch, rising, { colour, name }, widths) {
  const { stable, unstable } = strands(branch, rising);
  return [
    { ...unstable, colour, width: widths.unstable, dash: widths.dash, name: "dashed: unstable" },
    { ...stable, colour, width: widths.stable, name },
  ].filter(({ x }) => x.length);
}

/** Between which phases a cycle with rest lies on the wall: from when it comes to rest to when it is let go.
 * @param {Branch} branch @param {string} colour @returns {Item[]} */
function restLines({ rows }, colour) {
  const line = (
    /** @type {"rests" | "releases"} */ which,
    /** @type {string} */ name,
    /** @type {number[]} */ dash,
  ) => {
    const phases = rows.map((row) => row[which] ?? []);
    const paths = phases[0].map((_, leg) => phases.map(() => leg));
    const { stable } = strands({ rows: rows.map((row, i) => ({ ...row, times: phases[i] })), paths }, RISING.phase);
    return { ...stable, colour, width: 1.4, dash, name };
  };
  if (!rows[0].rests) return [];
  return [line("rests", "comes to rest", [2, 3]), line("releases", "is let go", [9, 3, 2, 3])];
}

/** Events by kind, so that the legend tells each once.
 * @param {Branch[]} branches @param {Rising} rising @param {string} colour @param {number} size @returns {Item[]} */
function marks(branches, rising, colour, size) {
  /** @type {Map<string, Item>} */
  const kinds = new Map();
  for (const row of branches.flatMap(({ rows }) => rows)) {
    const { words, shape } = EVENTS[row.point?.type] ?? {};
    if (!shape) continue;
    const look = { shape, colour, name: words, size: shape === "cross" ? 0.9 * size : size };
    const held = kinds.get(words) ?? { type: "points", x: [], y: [], ...look };
    for (const height of rising(row)) (held.x.push(row.value), held.y.push(height));
    kinds.set(words, held);
  }
  return [...kinds.values()];
}

/** The points of a place, to be drawn over the picture.
 * @param {Branch[]} branches @param {import("./branches_walk.js").Place | null} spot @param {string} up
 * @returns {import("../pictures/chart.js").Over[]} */
export function spotted(branches, spot, up) {
  if (!spot || !branches[spot.branch]) return [];
  const row = rowAt(branches[spot.branch], spot.along);
  return RISING[up](row).map((height) => [row.value, height, theme().accent]);
}
