// Branches as rows that can be drawn and walked along: what happens on them is put in as rows of its own.

export const TURN = 2 * Math.PI;

/** An angle taken into −π … π. */
export const around = (angle) => angle - TURN * Math.round(angle / TURN);

/** A phase of the load, 0 … 2π. */
export const phaseOf = (time) => ((time % TURN) + TURN) % TURN;

/** All branches of an answer, with what happens put in as rows of its own: {label, periods, rows, points, paths}. */
export function branchesOf(answer) {
  return [answer, ...answer.switched].map(made);
}

/** A point with the phases of its blows in the cycle of a machine, which has no load to have phases of. */
function phased(point) {
  const { impacts, period } = point.orbit ?? {};
  if (!period || !impacts?.length) return point;
  return { ...point, orbit: { ...point.orbit, impacts: impacts.map(({ time, speed, phase }) => ({ speed, phase: phase ?? (TURN * time) / period })) } };
}

function made(answer) {
  const one = { ...answer, points: answer.points.map(phased) };
  const rows = one.branch.release_phases ? restingRows(one) : rowsOf(one);
  return { label: one.label, periods: Number(one.label.split("/")[1]), points: one.points, rows, paths: pathsOf(rows) };
}

/** A branch of a diagram, whose points tell their impacts otherwise. */
export function tracedBranch({ label, branch, points }) {
  const impacts = ({ phases, speeds }) => phases.map((phase, j) => ({ phase, speed: speeds[j] }));
  return made({ label, branch, points: points.map((point) => ({ ...point, orbit: { impacts: impacts(point) } })) });
}

/** The rows of a branch of cycles with rest: its two ends are its first and its last row. */
function restingRows({ branch, points }) {
  const rows = branch.value.map((value, i) => ({
    value,
    times: branch.times[i],
    speeds: branch.speeds[i],
    stable: true,
    legs: branch.impacts[i],
    releases: branch.release_phases[i],
    rests: branch.rest_phases[i],
  }));
  rows[0].point = points[0];
  if (rows.length > 1) rows.at(-1).point = points[1];
  return rows;
}

const sum = (list) => list.reduce((total, n) => total + n, 0);

/** How many impacts of a row follow each release; of an orbit without rest all of them belong together. */
const legsOf = ({ legs, times }) => legs ?? [times.length];

/** Each impact along a branch: its number in every row, -1 where a chatter has been summed before it. */
function pathsOf(rows) {
  const number = ({ legs, times }, leg, n) => {
    const own = legsOf({ legs, times });
    return n < own[leg] ? sum(own.slice(0, leg)) + n : -1;
  };
  return legsOf(rows[0]).flatMap((_, leg) => {
    const most = Math.max(...rows.map((row) => legsOf(row)[leg]));
    return Array.from({ length: most }, (_, n) => rows.map((row) => number(row, leg, n)));
  });
}

/** The rows of a branch of orbits; of a machine that switches its own valve the times are phases of its cycle. */
function rowsOf({ branch, points }) {
  const { cycle_times: periods } = branch;
  const rows = branch.value.map((value, i) => ({
    value,
    times: periods ? branch.phases[i] : branch.times[i],
    speeds: branch.speeds[i],
    stable: branch.stable[i],
    period: periods?.[i],
  }));
  let from = 0;
  for (const point of points) {
    if (!point.orbit?.impacts.length) continue; // nothing to be marked
    const { segment, share } = nearest(rows, point, from);
    const row = matched(between(rows[segment], rows[segment + 1] ?? rows[segment], share), point);
    const known = [segment, segment + 1].find((i) => rows[i] && near(rows[i], row));
    if (known !== undefined) rows[known] = { ...rows[known], point, stable: BORDERS.has(point.type) ? null : rows[known].stable };
    else rows.splice(segment + 1, 0, row);
    from = known ?? segment + 1;
  }
  return rows;
}

const BORDERS = new Set(["fold", "flip", "neimark_sacker", "branch_point", "nonsmooth_fold"]);

const near = (one, other) =>
  Math.abs(one.value - other.value) < 1e-9 * (1 + Math.abs(one.value)) && Math.abs(around(one.times[0] - other.times[0])) < 1e-6;

/** The stretch between two rows, from `from` on, that a point lies on. */
function nearest(rows, point, from) {
  let best = { segment: Math.max(rows.length - 2, 0), share: 1, far: Infinity };
  for (let i = from; i + 1 < rows.length; i++) {
    const [a, b] = [rows[i], rows[i + 1]];
    const reach = b.value - a.value;
    const share = reach ? Math.min(Math.max((point.value - a.value) / reach, 0), 1) : 0.5;
    const { times, value } = between(a, b, share);
    const apart = point.orbit.impacts.map(({ phase }) => Math.min(...times.map((t) => Math.abs(around(t - phase)))));
    const far = Math.max(...apart) + Math.abs(value - point.value) / (Math.abs(reach) || 1);
    if (far < best.far) best = { segment: i, share, far };
  }
  return best;
}

/** A row at a point, its impacts in the order of the row that it is beside. */
function matched(row, point) {
  const { impacts } = point.orbit;
  const closest = row.times.map((time) => {
    const apart = impacts.map(({ phase }) => Math.abs(around(phase - time)));
    return impacts[apart.indexOf(Math.min(...apart))];
  });
  return {
    value: point.value,
    times: row.times.map((time, j) => time + around(closest[j].phase - time)),
    speeds: closest.map(({ speed }) => speed),
    stable: null, // a border
    point,
  };
}

/** The row between two others, with the impacts that both have. */
export function between(a, b, share) {
  const mixed = (one, other) => one + share * (other - one);
  const row = (pairs) => ({
    value: mixed(a.value, b.value),
    times: pairs.map(([j, k]) => mixed(a.times[j], b.times[k])),
    speeds: pairs.map(([j, k]) => mixed(a.speeds[j], b.speeds[k])),
    period: a.period && mixed(a.period, b.period),
    stable: stableBetween(a, b),
  });
  if (!a.legs) return row(a.times.map((_, j) => [j, j]));
  const legs = a.legs.map((n, leg) => Math.min(n, b.legs[leg]));
  const first = (row, leg) => sum(row.legs.slice(0, leg));
  const pairs = legs.flatMap((n, leg) => Array.from({ length: n }, (_, i) => [first(a, leg) + i, first(b, leg) + i]));
  const turned = (list, others) => list.map((phase, i) => phaseOf(phase + share * around(others[i] - phase)));
  return { ...row(pairs), legs, releases: turned(a.releases, b.releases), rests: turned(a.rests, b.rests) };
}

/** Whether what lies between two rows is stable. */
export const stableBetween = (a, b) => a.stable ?? b.stable ?? true;

const NEAR = 0.02; // rad, within which two walks along one branch may be apart

/** Whether a branch is another one, or a part of it: by its orbits at three places. */
export function sameBranch(other, one) {
  if (other.label !== one.label) return false;
  return [0.25, 0.5, 0.75].every((share) => {
    const row = one.rows[Math.floor(share * (one.rows.length - 1))];
    const told = ({ times, releases }) => releases ?? times; // what follows a release is told by its phase
    return crossings(other, row.value).some((found) => alike(told(found), told(row)) && alike(told(row), told(found)));
  });
}

const alike = (times, others) => times.every((time) => others.some((one) => Math.abs(around(one - time)) < NEAR));

/** The rows at which a branch has a value of the parameter. */
function crossings({ rows }, value) {
  const found = [];
  for (let i = 0; i + 1 < rows.length; i++) {
    const [a, b] = [rows[i].value - value, rows[i + 1].value - value];
    if (a === 0 || a * b < 0 || b === 0) found.push(between(rows[i], rows[i + 1], a === b ? 0 : a / (a - b)));
  }
  return found;
}
