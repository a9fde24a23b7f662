// Branches as rows that can be drawn and walked along: a place on one is its number and how far along its rows it is.

const TURN = 2 * Math.PI;

/** How far from the end of a branch, in rows, one is still well on it. */
export const ASIDE = 0.03;

/** An angle taken into −π … π. */
const around = (angle) => angle - TURN * Math.round(angle / TURN);

/** A phase of the load, 0 … 2π. */
const phaseOf = (time) => ((time % TURN) + TURN) % TURN;

/** What is drawn up the plane of a row of a branch: one value for each impact. */
export const RISING = {
  phase: ({ times }) => times.map(phaseOf),
  speed: ({ speeds }) => speeds,
};

/** All branches of an answer, with what happens put in as rows of its own: {label, periods, rows, points, paths}. */
export function branchesOf(answer) {
  return [answer, ...answer.switched].map((one) => {
    const rows = one.branch.release_phases ? restingRows(one) : rowsOf(one);
    return { label: one.label, periods: Number(one.label.split("/")[1]), points: one.points, rows, paths: pathsOf(rows) };
  });
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

function rowsOf({ branch, points }) {
  const rows = branch.value.map((value, i) => ({
    value,
    times: branch.times[i],
    speeds: branch.speeds[i],
    stable: branch.stable[i],
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

const BORDERS = new Set(["fold", "flip", "neimark_sacker", "nonsmooth_fold"]);

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
function between(a, b, share) {
  const mixed = (one, other) => one + share * (other - one);
  const row = (pairs) => ({
    value: mixed(a.value, b.value),
    times: pairs.map(([j, k]) => mixed(a.times[j], b.times[k])),
    speeds: pairs.map(([j, k]) => mixed(a.speeds[j], b.speeds[k])),
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
