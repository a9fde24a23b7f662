// The diagram: branches over a parameter, solid where stable and dashed where not, with what happens on them.

import { PHASES, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { inUnit, number } from "../core/format.js";
import { stableBetween } from "./branches_rows.js";
import { RISING, rowAt, stretch } from "./branches_walk.js";

/** What can be drawn up the plane, with its unit in SI where the machine has one. */
export const UP = {
  phase: { label: "impact phase", unit: "rad" },
  speed: { label: "striking speed", unit: "dimensionless", si: "m/s" },
  period: { label: "period of the cycle", unit: "dimensionless", si: "s" },
};

/** What happens on a branch: its words, and its mark where it has one. */
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

/**
 * What to draw: `branches` are {followed, others, thin}, `along` is {label, from, to}, `design` {x, y} or null, `simulated`
 * what simulations settle on.
 */
export function diagram(branches, along, up, design, simulated) {
  const { items: lines, heights } = drawn(branches, up);
  const { ink } = theme();
  const items = [...simulated.dots, ...lines];
  if (design) {
    items.push({ type: "level", at: design.x, axis: "x", colour: ink, dash: [2, 3], width: 1.5, name: "the present design" });
    if (design.y !== null) items.push({ type: "points", x: [design.x], y: [design.y], shape: "diamond", size: 8, colour: ink });
  }
  const [low, high] = span([heights, simulated.heights]);
  const round = up === "phase" && (!heights.length || high - low > Math.PI);
  const y = round ? { from: 0, to: 2 * Math.PI, ticks: PHASES } : { from: low, to: high };
  return {
    x: along,
    y: { label: inUnit(UP[up].label, (along.isSI && UP[up].si) || UP[up].unit), ...y },
    items,
    about: `${UP[up].label} over ${along.label}: ${words(branches)}. Arrow keys move along a branch.`,
  };
}

const words = ({ followed, others }) => [...followed.map(told), ...(others.length ? [`${others.length} other branches`] : [])].join("; ");

let kept = { of: [] }; // the last lines: a slider that moves the design leaves them as they are

function drawn({ followed, others, thin }, up) {
  const of = [followed, others, thin, up, theme()];
  if (of.every((one, i) => one === kept.of[i])) return kept;
  const rising = RISING[up];
  const { kinds, ink, muted } = theme();
  const labels = [...new Set([...followed, ...others].map(({ label }) => label))];
  const colour = ({ label }) => kinds[labels.indexOf(label)] ?? muted;
  const name = ({ label }) => (labels.indexOf(label) < kinds.length ? `${label}, stable` : "other labels, stable");
  const items = [
    ...followed.map((branch) => ({ type: "line", x: [], y: [], colour: colour(branch), width: FOLLOWED.stable, name: name(branch) })),
    ...thin.flatMap((branch) => thinLines(branch, rising, muted)),
    ...others.flatMap((branch) => linesOf({ ...branch, name: name(branch) }, rising, colour(branch), OTHER)),
    ...followed.flatMap((branch) => linesOf(branch, rising, colour(branch), FOLLOWED)),
    ...(up === "phase" ? followed.flatMap((branch) => restLines(branch, ink)) : []),
    ...marks(followed, rising, ink, FOLLOWED.mark),
    ...marks(others, rising, ink, OTHER.mark),
  ];
  const heights = [...followed, ...others].flatMap(({ rows }) => rows.flatMap(rising));
  kept = { of, items, heights };
  return kept;
}

const told = ({ label, points }) =>
  `${label}, ${points.map(({ type, value }) => `${EVENTS[type]?.words ?? type} at ${number(value)}`).join(", ")}`;

/** One line for each impact and each stretch of equal stability, torn where a phase goes round. */
function linesOf({ label, name = `${label}, stable`, rows, paths }, rising, colour, look) {
  const heights = rows.map(rising);
  const lines = { stable: { x: [], y: [] }, unstable: { x: [], y: [] } };
  for (const [j, path] of paths.entries())
    for (const [kind, line] of Object.entries(lines)) {
      for (let i = 0; i + 1 < rows.length; i++) {
        if (stableBetween(rows[i], rows[i + 1]) !== (kind === "stable")) continue;
        const ends = stretch(heights, path, i, rising);
        if (!ends) continue;
        const joins = line.x.length && line.last === `${i},${j}`;
        if (!joins) (line.x.push(null, rows[i].value), line.y.push(null, ends[0]));
        (line.x.push(rows[i + 1].value), line.y.push(ends[1]));
        line.last = `${i + 1},${j}`;
      }
    }
  const item = (line, more) => line.x.length && { type: "line", x: line.x, y: line.y, colour, ...more };
  return [
    item(lines.unstable, { width: look.unstable, dash: look.dash, name: "dashed: unstable" }),
    item(lines.stable, { width: look.stable, name }),
  ].filter(Boolean);
}

/** Roots of the equations beyond an end, whatever their stability: no motions. */
function thinLines(branch, rising, colour) {
  const rows = branch.rows.map((row) => ({ ...row, stable: false }));
  return linesOf({ ...branch, rows }, rising, colour, { ...OTHER, unstable: 0.7, dash: [] }).map((line) => ({ ...line, name: "thin: not possible" }));
}

/** Between which phases a cycle with rest lies on the wall: from when it comes to rest to when it is let go. */
function restLines({ rows }, colour) {
  if (!rows[0].rests) return [];
  const lines = [
    ["rests", "comes to rest", [2, 3]],
    ["releases", "is let go", [9, 3, 2, 3]],
  ];
  return lines.map(([name, words, dash]) => {
    const line = { type: "line", x: [], y: [], colour, width: 1.4, dash, name: words };
    for (const leg of rows[0][name].keys())
      for (const [i, row] of rows.entries()) {
        const torn = i > 0 && Math.abs(row[name][leg] - rows[i - 1][name][leg]) > Math.PI;
        if (i === 0 || torn) (line.x.push(null), line.y.push(null));
        (line.x.push(row.value), line.y.push(row[name][leg]));
      }
    return line;
  });
}

/** Events by kind, so that the legend tells each once. */
function marks(branches, rising, colour, size) {
  const kinds = new Map();
  for (const { rows } of branches)
    for (const row of rows) {
      const event = row.point && EVENTS[row.point.type];
      if (!event?.shape) continue;
      const held = kinds.get(event.words) ?? { x: [], y: [], shape: event.shape };
      for (const height of rising(row)) (held.x.push(row.value), held.y.push(height));
      kinds.set(event.words, held);
    }
  return [...kinds].map(([name, { x, y, shape }]) => ({ type: "points", x, y, shape, colour, name, size: shape === "cross" ? 0.9 * size : size }));
}

/** The points of a place, to be drawn over the picture. */
export function spotted(branches, spot, up) {
  if (!spot || !branches[spot.branch]) return [];
  const row = rowAt(branches[spot.branch], spot.along);
  return RISING[up](row).map((height) => [row.value, height, theme().accent]);
}
