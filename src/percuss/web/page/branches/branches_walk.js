// Places on branches: a place is the number of a branch and how far along its rows it is.

import { TURN, around, between, phaseOf } from "./branches_rows.js";

/** How far from the end of a branch, in rows, one is still well on it. */
export const ASIDE = 0.03;

/** What is drawn up the plane of a row of a branch: one value for each impact. */
export const RISING = {
  phase: ({ times }) => times.map(phaseOf),
  speed: ({ speeds }) => speeds,
  period: ({ times, period }) => times.map(() => period),
};

/** The row at a place, `along` in rows. */
export function rowAt({ rows }, along) {
  const i = Math.min(Math.max(Math.floor(along), 0), rows.length - 1);
  const share = along - i;
  return share > 0 && rows[i + 1] ? between(rows[i], rows[i + 1], share) : rows[i];
}

/** Both heights of an impact beside a row; null where it is not in both rows, and where a phase goes round. */
export function stretch(heights, path, i, rising) {
  if (path[i] < 0 || path[i + 1] < 0) return null;
  const ends = [heights[i][path[i]], heights[i + 1][path[i + 1]]];
  return rising === RISING.phase && Math.abs(ends[1] - ends[0]) > Math.PI ? null : ends;
}

/** The place under a point of the picture: {branch, along, far}, `far` in pixels; of one branch only, or of all. */
export function placeAt(branches, rising, frame, { x, y }, only = null) {
  let best = { branch: 0, along: 0, far: Infinity };
  for (const [branch, { rows, paths }] of branches.entries()) {
    if (only !== null && branch !== only) continue;
    const heights = rows.map(rising);
    for (const path of paths)
      for (let i = 0; i + 1 < rows.length; i++) {
        const ends = stretch(heights, path, i, rising);
        if (!ends) continue;
        const from = [frame.px(rows[i].value), frame.py(ends[0])];
        const to = [frame.px(rows[i + 1].value), frame.py(ends[1])];
        const { share, far } = foot(from, to, [x, y]);
        if (far < best.far) best = { branch, along: i + share, far };
      }
  }
  return best;
}

/** The point of a stretch that is nearest to another one. */
function foot([x0, y0], [x1, y1], [x, y]) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const long = dx * dx + dy * dy;
  const share = long ? Math.min(Math.max(((x - x0) * dx + (y - y0) * dy) / long, 0), 1) : 0;
  return { share, far: Math.hypot(x0 + share * dx - x, y0 + share * dy - y) };
}

/** The place nearest to a value and a phase of the first impact, as a link keeps them. */
export function placeNear(branches, value, phase, reach) {
  let best = { branch: 0, along: 0, far: Infinity };
  for (const [branch, { rows }] of branches.entries())
    for (let i = 0; i + 1 < rows.length || i === 0; i++) {
      const [a, b] = [rows[i], rows[i + 1] ?? rows[i]];
      const long = b.value - a.value;
      const share = long ? Math.min(Math.max((value - a.value) / long, 0), 1) : 0;
      const row = between(a, b, share);
      const apart = Math.abs(around(row.times[0] - phase)) / TURN + Math.abs(row.value - value) / reach;
      if (apart < best.far) best = { branch, along: i + share, far: apart };
    }
  return best;
}

/** The place of what happens at a point; just beside it where there is no orbit on the other side. */
export function placeOf(branches, branch, point) {
  const { rows } = branches[branch];
  const i = rows.findIndex((row) => row.point === point);
  if (i < 0) return null;
  const beside = i === 0 ? ASIDE : i === rows.length - 1 || point.type.endsWith("fold") ? -ASIDE : 0;
  return { branch, along: Math.max(i + beside, 0) };
}
