// Branches as rows that can be drawn and walked along: what happens on them is put in as rows of its own.

/** An orbit of a branch: its impacts, and of a cycle with rest how many follow each release. What happens there is its
 * `point`; at a border its stability is null.
 * @typedef {{ value: number, times: number[], speeds: number[], stable: boolean | null, period?: number, legs?: number[],
 *   releases?: number[], rests?: number[], point?: Record<string, any> }} Row */
/** `paths`: each impact along it, its number in every row, -1 where it is not in one.
 * @typedef {{ label: string, periods: number, rows: Row[], points: Record<string, any>[], paths: number[][] }} Branch */
/** @typedef {Record<string, any>} Answer */

export const TURN = 2 * Math.PI;

/** An angle taken into −π … π. @param {number} angle */
export const around = (angle) => angle - TURN * Math.round(angle / TURN);

/** A phase of the load, 0 … 2π. @param {number} time */
export const phaseOf = (time) => ((time % TURN) + TURN) % TURN;

/** All branches of an answer. @param {Answer} answer @returns {Branch[]} */
export const branchesOf = (answer) => [answer, ...answer.switched].map(made);

/** @param {Answer} answer @returns {Branch} */
function made({ label, branch, points: told }) {
  const points = told.map(phased);
  const rows = rowsOf(branch);
  if (rows[0].legs) {
    rows[0].point = points[0]; // the two ends of a branch with rest
    if (rows.length > 1) rows[rows.length - 1].point = points[1];
  } else placePoints(rows, points);
  return { label, periods: Number(label.split("/")[1]), points, rows, paths: pathsOf(rows) };
}

/** A branch of a diagram, whose points tell their impacts otherwise. @param {Answer} answer @returns {Branch} */
export function tracedBranch({ label, branch, points }) {
  const impacts = (/** @type {any} */ { phases, speeds }) =>
    phases.map((/** @type {number} */ phase, /** @type {number} */ j) => ({ phase, speed: speeds[j] }));
  return made({
    label,
    branch,
    points: points.map((/** @type {any} */ point) => ({ ...point, orbit: { impacts: impacts(point) } })),
  });
}

/** A point with the phases of its blows in the cycle of a machine, which has no load to have phases of. @param {any} point */
function phased(point) {
  const { impacts, period } = point.orbit ?? {};
  if (!period || !impacts?.length) return point;
  const placed = impacts.map((/** @type {any} */ { time, speed, phase }) => ({
    speed,
    phase: phase ?? (TURN * time) / period,
  }));
  return { ...point, orbit: { ...point.orbit, impacts: placed } };
}

/** The rows of a branch; of a machine that switches its own valve the times are phases of its cycle.
 * @param {Record<string, any[]>} branch @returns {Row[]} */
function rowsOf(branch) {
  const { cycle_times: periods, release_phases: releases } = branch;
  return branch.value.map((value, i) => ({
    value,
    times: (periods ? branch.phases : branch.times)[i],
    speeds: branch.speeds[i],
    stable: releases ? true : branch.stable[i],
    period: periods?.[i],
    ...(releases && { legs: branch.impacts[i], releases: releases[i], rests: branch.rest_phases[i] }),
  }));
}

const sum = (/** @type {number[]} */ list) => list.reduce((total, n) => total + n, 0);

/** How many impacts of a row follow each release; of an orbit without rest all of them belong together. @param {Row} row */
const legsOf = ({ legs, times }) => legs ?? [times.length];

/** Each impact along a branch; it is in no row where a chatter has been summed before it. @param {Row[]} rows */
function pathsOf(rows) {
  return legsOf(rows[0]).flatMap((_, leg) =>
    Array.from({ length: Math.max(...rows.map((row) => legsOf(row)[leg])) }, (_, n) =>
      rows.map((row) => (n < legsOf(row)[leg] ? sum(legsOf(row).slice(0, leg)) + n : -1)),
    ),
  );
}

const BORDERS = new Set(["fold", "flip", "neimark_sacker", "branch_point", "nonsmooth_fold"]);

/** What happens on a branch of orbits, as rows. @param {Row[]} rows @param {Record<string, any>[]} points */
function placePoints(rows, points) {
  let from = 0;
  for (const point of points) {
    if (!point.orbit?.impacts.length) continue; // nothing to be marked
    const { segment, share } = nearest(rows, point, from);
    const row = matched(between(rows[segment], rows[segment + 1] ?? rows[segment], share), point);
    const known = [segment, segment + 1].find((i) => rows[i] && near(rows[i], row));
    if (known === undefined) rows.splice(segment + 1, 0, row);
    else rows[known] = { ...rows[known], point, stable: BORDERS.has(point.type) ? null : rows[known].stable };
    from = known ?? segment + 1;
  }
}

/** @param {Row} one @param {Row} other */
const near = (one, other) =>
  Math.abs(one.value - other.value) < 1e-9 * (1 + Math.abs(one.value)) &&
  Math.abs(around(one.times[0] - other.times[0])) < 1e-6;

/** How far a value is from one to another, 0 to 1. @param {number} value @param {number} from @param {number} to */
export const shareOf = (value, from, to, flat = 0) =>
  from === to ? flat : Math.min(Math.max((value - from) / (to - from), 0), 1);

/** The stretch between two rows, from `from` on, that a point lies on.
 * @param {Row[]} rows @param {any} point @param {number} from */
function nearest(rows, point, from) {
  let best = { segment: Math.max(rows.length - 2, 0), share: 1, far: Infinity };
  for (let i = from; i + 1 < rows.length; i++) {
    const [a, b] = [rows[i], rows[i + 1]];
    const share = shareOf(point.value, a.value, b.value, 0.5);
    const { times, value } = between(a, b, share);
    const apart = point.orbit.impacts.map((/** @type {any} */ { phase }) =>
      Math.min(...times.map((t) => Math.abs(around(t - phase)))),
    );
    const far = Math.max(...apart) + Math.abs(value - point.value) / (Math.abs(b.value - a.value) || 1);
    if (far < best.far) best = { segment: i, share, far };
  }
  return best;
}

/** A row at a point, its impacts in the order of the row that it is beside. @param {Row} row @param {any} point
 * @returns {Row} */
function matched({ times }, point) {
  const { impacts } = point.orbit;
  const closest = times.map((time) => {
    const apart = impacts.map((/** @type {any} */ { phase }) => Math.abs(around(phase - time)));
    return impacts[apart.indexOf(Math.min(...apart))];
  });
  return {
    value: point.value,
    times: times.map((time, j) => time + around(closest[j].phase - time)),
    speeds: closest.map(({ speed }) => speed),
    stable: null, // a border
    point,
  };
}

/** The row between two others, with the impacts that both have. @param {Row} a @param {Row} b @param {number} share
 * @returns {Row} */
export function between(a, b, share) {
  const mixed = (/** @type {number} */ one, /** @type {number} */ other) => one + share * (other - one);
  const [own, others] = [legsOf(a), legsOf(b)];
  const legs = own.map((n, leg) => Math.min(n, others[leg]));
  const pairs = legs.flatMap((n, leg) =>
    Array.from({ length: n }, (_, i) => [sum(own.slice(0, leg)) + i, sum(others.slice(0, leg)) + i]),
  );
  const row = {
    value: mixed(a.value, b.value),
    times: pairs.map(([j, k]) => mixed(a.times[j], b.times[k])),
    speeds: pairs.map(([j, k]) => mixed(a.speeds[j], b.speeds[k])),
    period: a.period && mixed(a.period, b.period ?? a.period),
    stable: stableBetween(a, b),
  };
  if (!a.legs) return row;
  const turned = (/** @type {number[]} */ list = [], /** @type {number[]} */ next = []) =>
    list.map((phase, i) => phaseOf(phase + share * around(next[i] - phase)));
  return { ...row, legs, releases: turned(a.releases, b.releases), rests: turned(a.rests, b.rests) };
}

/** Whether what lies between two rows is stable. @param {Row} a @param {Row} b */
export const stableBetween = (a, b) => a.stable ?? b.stable ?? true;

const NEAR = 0.02; // rad, within which two walks along one branch may be apart

/** Whether a branch is another one, or a part of it: by its orbits at three places.
 * @param {Branch} other @param {Branch} one */
export function sameBranch(other, one) {
  const told = (/** @type {Row} */ { times, releases }) => releases ?? times; // what follows a release is told by its phase
  return (
    other.label === one.label &&
    [0.25, 0.5, 0.75].every((share) => {
      const row = one.rows[Math.floor(share * (one.rows.length - 1))];
      return crossings(other, row.value).some(
        (found) => alike(told(found), told(row)) && alike(told(row), told(found)),
      );
    })
  );
}

/** @param {number[]} times @param {number[]} others */
const alike = (times, others) => times.every((time) => others.some((one) => Math.abs(around(one - time)) < NEAR));

/** The rows at which a branch has a value of the parameter. @param {Branch} branch @param {number} value */
const crossings = ({ rows }, value) =>
  rows.slice(1).flatMap((next, i) => {
    const [a, b] = [rows[i].value - value, next.value - value];
    return a * b <= 0 ? [between(rows[i], next, a === b ? 0 : a / (a - b))] : [];
  });
