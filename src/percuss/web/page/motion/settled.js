// What is kept and told of a live motion: its name, and where one begins that is on its cycle.
//
// The name is what the motion is by now, in the words of the package: `z=p/n`, p impacts in n periods of the load; `chatter/n` and
// `rest/n`, with a rest on the wall; `rest` and `departed`, for good. Of a machine that switches itself `runs p/n`, p blows
// and n valve cycles, `double blow p/n`, `runs rest/n`, `runs chatter/n`, `cycles without blow`, and `stalls (…)`. "" while
// it has not settled, and of a motion that never does.
//
// A hammer that leaves the wall at rest leaves it in one state, so two releases at one phase make a cycle. Else the last
// impacts, or changes of the valve, are compared with those some numbers before; a cycle that is part of one that comes back
// is waited for while it still comes nearer, as that of a motion that settles from both sides in turn does.

/** @typedef {{phase: number, speed: number, period: number, time: number, state: string, gap: number, blows: number,
 *   rests: number, chatters: number, orders: number, shape?: number[]}} Mark one impact, change of the valve, or release */
/** @typedef {import("./live.js").Live} Live */
/** @typedef {import("./live.js").Place} Place */
/** @typedef {import("./flight.js").ValveModel} ValveModel */

const TURN = 2 * Math.PI;
export const MARKS = 192; // that are kept
const LONGEST = 32; // impacts, or changes, of a cycle that is told
const ALIKE = 1e-6; // how near a cycle comes back

/** @param {Live} live */
export function nameOf(live) {
  return live.law.valve ? machine(live) : clocked(live);
}

/** @param {Live} live */
function clocked(live) {
  const { law, released, marks } = live;
  if (live.resting && (live.lying ? lies(live) : law.release(live.phase, live.flight.force) === Infinity))
    return "rest";
  if (departed(live)) return "departed";
  const last = released.at(-1);
  if (last && last.at >= 0)
    for (let i = released.length - 2; i >= 0; i--)
      if (released[i].at === last.at) return rested(released[i], last, last.period - released[i].period);
  const speed = fastest(marks);
  const turned = (/** @type {Mark} */ a, /** @type {Mark} */ b) => Math.abs(Math.sin(0.5 * (a.phase - b.phase)));
  const p = cycle(marks, (a, b) => Math.max(2 * turned(a, b), Math.abs(a.speed - b.speed) / speed));
  if (p) {
    const [before, now] = [marks[marks.length - 1 - p], marks[marks.length - 1]];
    const n = periods(before, now);
    if (n) return now.rests > before.rests ? rested(before, now, n) : `z=${p}/${n}`; // else the last bounces of a chatter
  }
  const q = last && law.size > 1 ? cycle(released, (a, b) => Math.max(turned(a, b), unlike(a, b))) : 0;
  if (!last || !q) return "";
  const before = released[released.length - 1 - q];
  return rested(before, last, periods(before, last));
}

/** How far the shapes and velocities in which a structure of several modes was let go are from each other.
 * @param {Mark} a @param {Mark} b */
function unlike({ shape: a = [] }, { shape: b = [] }) {
  const size = Math.max(...a.map(Math.abs), 1e-300);
  return a.reduce((most, one, i) => Math.max(most, Math.abs(one - b[i]) / size), 0);
}

/** Load periods from one mark to the other. @param {Mark} a @param {Mark} b */
const periods = (a, b) => Math.round(b.period - a.period + (b.phase - a.phase) / TURN);

/** The name of a cycle of so many load periods with a rest. @param {Mark} a @param {Mark} b @param {number} n */
const rested = (a, b, n) => `${b.chatters > a.chatters ? "chatter" : "rest"}/${n}`;

/** Whether the wall holds a structure of several modes for good. @param {Live} live */
function lies({ law, lying, since, now, laid }) {
  if (!lying) return false;
  let slowest = Infinity;
  for (let i = 0; i < lying.exponents.length; i += 2) slowest = Math.min(slowest, -lying.exponents[i]);
  if (now - laid > 30 / slowest + 2 * TURN) return true; // its free motion has died out, and a period has gone by since
  if (law.steps) return false;
  let most = lying.steady; // of a pull
  for (let i = 0; i < lying.waved.length; i += 2) most += Math.hypot(lying.waved[i], lying.waved[i + 1]);
  for (let i = 0; i < lying.faded.length; i += 2)
    most += Math.hypot(lying.faded[i], lying.faded[i + 1]) * Math.exp(lying.exponents[i] * since);
  return most < 0;
}

/** @param {Live} live */
function machine(live) {
  const { marks } = live;
  const why = live.stuck ? "on a port" : stalls(live);
  if (why) return `stalls (${why})`;
  const [speed, far] = [fastest(marks), Math.max(...marks.map(({ gap }) => -gap), 0) || 1];
  const apart = (/** @type {Mark} */ a, /** @type {Mark} */ b) =>
    a.state !== b.state || a.orders !== b.orders
      ? Infinity
      : Math.max(Math.abs(a.speed - b.speed) / speed, Math.abs(a.gap - b.gap) / far);
  const p = cycle(marks, apart);
  if (!p) return "";
  const [now, before] = [marks[marks.length - 1], marks[marks.length - 1 - p]];
  const orders = marks.slice(-p).map(({ state }) => state);
  const n = Math.max(...orders.map((state) => orders.filter((other) => other === state).length));
  const blows = now.blows - before.blows;
  if (now.rests > before.rests) return `runs ${now.chatters > before.chatters ? "chatter" : "rest"}/${n}`;
  if (!blows) return "cycles without blow";
  return `${blows >= 2 * n ? "double blow" : "runs"} ${blows}/${n}`;
}

/** @param {Mark[]} marks */
const fastest = (marks) => Math.max(...marks.slice(-2 * LONGEST).map(({ speed }) => Math.abs(speed)), 0) || 1;

/** @typedef {(a: Mark, b: Mark) => number} Apart */

/** How far the last marks, from `end` back, are from those `shift` before. @param {Mark[]} marks @param {number} shift
 * @param {number} end @param {number} size @param {Apart} apart */
function farthest(marks, shift, end, size, apart) {
  let most = 0;
  for (let i = end - size; i < end; i++) most = Math.max(most, apart(marks[i], marks[i - shift]));
  return most;
}

/** The marks of the shortest cycle, 0 when there is none yet. @param {Mark[]} marks @param {Apart} apart */
function cycle(marks, apart) {
  const n = marks.length;
  for (let p = 1; p <= LONGEST && 3 * p <= n; p++) {
    if (farthest(marks, p, n, 2 * p, apart) > ALIKE) continue;
    for (let part = 1; part <= p / 2; part++) {
      if (p % part) continue;
      const off = farthest(marks, part, n, p, apart);
      const before = farthest(marks, part, n - p, p - part, apart);
      if (Number.isFinite(off) && Math.abs(off - before) > 1e-4 * off) return 0;
    }
    return p;
  }
  return 0;
}

/** Whether a hammer under a clock has left for good: it swings, or drifts, where it never reaches the wall.
 * @param {Live} live */
function departed({ law, flight, resting, since, gap }) {
  if (resting) return false;
  let sway = 0;
  for (let i = 0; i < 2 * law.K; i += 2) sway += Math.hypot(flight.waves[i], flight.waves[i + 1]);
  if (law.size > 1 || law.square[0] > 0) {
    let high = sway - law.gap;
    for (let j = 0; j < law.size; j++) {
      const [square, half] = [law.square[j], 0.5 * law.damping[j]];
      const [v, still] = [flight.free[2 * j], (law.drive[j] * flight.force) / square];
      const z = -flight.free[2 * j + 1] / square;
      const lambda = Math.sqrt(square - half * half);
      const fading = lambda > 0 ? Math.hypot(z, (v + half * z) / lambda) * Math.exp(-half * since) : Infinity;
      high += still + Math.min(fading, Math.hypot(z, v / Math.sqrt(square)));
    }
    return !law.steps && high < 0;
  }
  if (law.mean > 0) return false;
  const mean = law.mean * law.drive[0];
  const d = law.damping[0];
  let speed = 0; // of the drift
  if (law.steps) {
    // over a period about the drift the velocity sways by no more than force × 2π
    sway = 2 * Math.PI * Math.PI * law.force;
    speed = flight.at(since)[1] + 2 * Math.PI * law.force;
  } else {
    const fade = Math.exp(-d * since);
    speed = flight.free[0] * fade + (d > 0 ? (mean * (1 - fade)) / d : mean * since);
  }
  let coming = 0;
  if (speed > 0) {
    if (mean === 0 && d === 0) return false;
    coming = d > 0 ? speed / d : (0.5 * speed * speed) / -mean;
  } else if (mean === 0 && speed === 0) return false;
  return gap + coming + 2 * sway < 0;
}

/** Why a machine will never strike or switch again, or "". @param {Live} live */
function stalls({ law, flight, resting, orders, demanded, inside, since, force }) {
  if (orders.length) return "";
  if (resting) return force > 0 ? "on the tool" : "";
  const [y, v] = flight.at(since);
  const [square, d] = [law.square[0], law.damping[0]];
  const push = flight.force;
  let [low, high, slow, fast] = [-Infinity, y, Math.min(v, d > 0 ? push / d : -Infinity), v];
  if (square > 0) {
    const middle = push / square;
    const swing = Math.hypot(y - middle, v / Math.sqrt(square)); // which only becomes less
    [low, high] = [middle - swing, middle + swing];
    [slow, fast] = [-swing * Math.sqrt(square), swing * Math.sqrt(square)];
  } else if (push >= 0) return "";
  else if (v > 0) high = y + (d > 0 ? v / d : (0.5 * v * v) / -push);
  if (high >= 0) return "";
  const ports = law.valve?.ports ?? [];
  const idle = ports.every(({ to, behind, speed, side }, i) => {
    if (to === demanded || !side) return true;
    const [least, most, level] = behind === null ? [slow, fast, speed ?? 0] : [low, high, behind];
    if (inside[i]) return side === "back" ? most < -level : least > (behind === null ? level : -level);
    return side === "back" ? least > -level : most < (behind === null ? level : -level);
  });
  return idle ? (square > 0 ? "in the chamber" : "leaves") : "";
}

/** A machine just after the blow that ends its cycle, as the answer of POST /api/machine has it, to be placed.
 * @param {ValveModel} valve @param {number} restitution
 * @param {{period: number, blows: {time: number, speed: number}[], ports: {port: number, time: number}[],
 *   valve: {time: number, to: string}[]}} cycle @returns {Place} */
export function onCycle(valve, restitution, { period, blows, ports, valve: changes }) {
  const last = blows[blows.length - 1];
  const since = (/** @type {number} */ time) => (((last.time - time) % period) + period) % period; // ago
  const state = changes.reduce((one, other) => (since(other.time) < since(one.time) ? other : one)).to;
  const asked = ports
    .map(({ port, time }) => ({ ago: since(time), ...valve.ports[port] }))
    .sort((a, b) => b.ago - a.ago);
  const orders = asked
    .filter(({ ago, delay }) => delay > ago)
    .map(({ ago, delay, to }) => ({ after: delay - ago, to }));
  return { velocity: -restitution * last.speed, state, demanded: asked.at(-1)?.to, orders };
}
