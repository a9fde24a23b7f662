// Places on branches: a place is the number of a branch and how far along its rows it is.

import { TURN, around, between, phaseOf, shareOf } from "./branches_rows.js";

/** @typedef {import("./branches_rows.js").Row} Row */
/** @typedef {import("./branches_rows.js").Branch} Branch */
/** @typedef {{ branch: number, along: number, far?: number }} Place */
/** What is drawn up the plane of a row: one value for each impact. @typedef {(row: Row) => number[]} Rising */

/** How far from the end of a branch, in rows, one is still well on it. */
export const ASIDE = 0.03;

/** What can be drawn up the plane. @type {Record<string, Rising>} */
export const RISING = {
  phase: ({ times }) => times.map(phaseOf),
  speed: ({ speeds }) => speeds,
  period: ({ times, period = Number.NaN }) => times.map(() => period),
};

/** The row at a place, `along` in rows. @param {Branch} branch @param {number} along */
export function rowAt({ rows }, along) {
  const i = Math.min(Math.max(Math.floor(along), 0), rows.length - 1);
  return along > i && rows[i + 1] ? between(rows[i], rows[i + 1], along - i) : rows[i];
}

/** The stretches of a branch in the plane: impact `path` from row `i` to the next, from one height to the other. There is
 * none where the impact is not in both rows, and where a phase goes round.
 * @param {{ rows: Row[], paths: number[][] }} branch @param {Rising} rising */
export function stretches({ rows, paths }, rising) {
  const heights = rows.map(rising);
  return paths.flatMap((path, number) =>
    rows.slice(1).flatMap((_, i) => {
      if (path[i] < 0 || path[i + 1] < 0) return [];
      const [from, to] = [heights[i][path[i]], heights[i + 1][path[i + 1]]];
      return rising === RISING.phase && Math.abs(to - from) > Math.PI ? [] : [{ path: number, i, from, to }];
    }),
  );
}

/** The place under a point of the picture, `far` in pixels; of one branch only, or of all.
 * @param {Branch[]} branches @param {Rising} rising @param {any} frame @param {{ x: number, y: number }} point
 * @param {number | null} [only] @returns {Place & { far: number }} */
export function placeAt(branches, rising, frame, { x, y }, only = null) {
  let best = { branch: 0, along: 0, far: Infinity };
  for (const [branch, one] of branches.entries()) {
    if (only !== null && branch !== only) continue;
    for (const { i, from, to } of stretches(one, rising)) {
      const [x0, y0] = [frame.px(one.rows[i].value), frame.py(from)];
      const [dx, dy] = [frame.px(one.rows[i + 1].value) - x0, frame.py(to) - y0];
      const long = dx * dx + dy * dy;
      const share = shareOf((x - x0) * dx + (y - y0) * dy, 0, long);
      const far = Math.hypot(x0 + share * dx - x, y0 + share * dy - y);
      if (far < best.far) best = { branch, along: i + share, far };
    }
  }
  return best;
}

/** The place nearest to a value and a phase of the first impact, as a link keeps them.
 * @param {Branch[]} branches @param {number} value @param {number} phase @param {number} reach @returns {Place} */
export function placeNear(branches, value, phase, reach) {
  let best = { branch: 0, along: 0, far: Infinity };
  for (const [branch, { rows }] of branches.entries())
    for (let i = 0; i + 1 < rows.length || i === 0; i++) {
      const [a, b] = [rows[i], rows[i + 1] ?? rows[i]];
      const share = shareOf(value, a.value, b.value);
      const row = between(a, b, share);
      const far = Math.abs(around(row.times[0] - phase)) / TURN + Math.abs(row.value - value) / reach;
      if (far < best.far) best = { branch, along: i + share, far };
    }
  return best;
}

/** The place of what happens at a point; just beside it where there is no orbit on the other side.
 * @param {Branch[]} branches @param {number} branch @param {any} point @returns {Place | null} */
export function placeOf(branches, branch, point) {
  const { rows } = branches[branch];
  const i = rows.findIndex((row) => row.point === point);
  if (i < 0) return null;
  const beside = i === 0 ? ASIDE : i === rows.length - 1 || point.type.endsWith("fold") ? -ASIDE : 0;
  return { branch, along: Math.max(i + beside, 0) };
}
