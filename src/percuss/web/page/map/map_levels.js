// How a map comes: coarse at once, then finer. What takes long comes in strips of rows, and the curves some points at a
// time, with room between them for the answer to a slider; a change of the hammer ends it.

import { post, postBinary } from "../core/api.js";
import { parameter, shown } from "./map_axes.js";
import { data, isHeld, switchesItself, view } from "../core/state.js";

/** @typedef {import("./map_axes.js").Axis} Axis */
/** @typedef {import("./map_picture.js").Level} Level */
/** A map that is wanted: what is asked, in which steps, and a key that tells it from others.
 * @typedef {{ key: string, version: number, kind: import("./map_axes.js").Shown, x: Axis, y: Axis, sides: number[],
 *   body: Record<string, any> }} Wanted */
/** What a strip had, rows or points, and the milliseconds that it took. @typedef {[number, number]} Took */

const STRIP = 250; // ms that one request may take
const POINTS = 24; // of a curve at first, before the steps are halved

/** The map that is wanted now. @param {Axis} x @param {Axis} y @param {number} version @returns {Wanted} */
export function wanted(x, y, version) {
  const kind = shown();
  const { quantities, body: own } = kind;
  const fast = new Set(
    data.about.quantities.filter((/** @type {any} */ one) => one.fast).map((/** @type {any} */ one) => one.name),
  );
  const plane = [x, y].every(({ name }) => parameter(name)?.plane);
  const byArrays = plane && quantities.every((name) => fast.has(name));
  const { cells, slow_cells: slow } = data.about.limits;
  const most = Math.floor(Math.sqrt(byArrays ? cells : slow));
  const reduced = byArrays && !quantities.some((name) => name === "stable" || name === "margin");
  const sides = switchesItself() ? [16, most] : reduced ? [50, most] : byArrays ? [16, 60, most] : [8, 24, most];
  const body = { case: data.tables, quantities, ...own, ...(!switchesItself() && { periods: view.m }) };
  return { key: JSON.stringify([x, y, quantities, view.m, version]), version, kind, x, y, sides, body };
}

/** The values of an axis in `count` steps; a whole number steps by one. @param {Axis} axis @param {number} count */
function valuesOf({ from, to, whole }, count) {
  const steps = whole ? Math.round(to - from) : count - 1;
  return Array.from({ length: steps + 1 }, (_, i) => (whole ? from + i : from + ((to - from) * i) / steps));
}

/** @param {Axis} axis @param {number[]} values */
const asked = ({ name, unit }, values) => ({ name, ...(unit && { unit }), values });

/** One level of a map, in strips from below: yields {nx, ny, rows, cost, arrays, quantities}, the last with all rows.
 * `cost` is what a cell takes in milliseconds, as far as the level before has told; 0: all in one request.
 * @param {Wanted} map @param {number} side @param {number} cost @param {AbortSignal} signal */
export async function* level(map, side, cost, signal) {
  const x = valuesOf(map.x, side);
  const y = valuesOf(map.y, side);
  /** @type {Level} */
  const found = { nx: x.length, ny: y.length, rows: 0, cost, arrays: {}, quantities: {} };
  /** @type {Took[]} */
  const strips = [];
  while (found.rows < y.length) {
    const count = cost ? rowsOfNext(strips, cost * x.length) : y.length;
    const part = y.slice(found.rows, found.rows + count);
    const strip = await postBinary("map", { ...map.body, x: asked(map.x, x), y: asked(map.y, part) }, signal);
    join(found, strip, x.length);
    found.rows += part.length;
    found.cost = Math.max(strip.milliseconds, 1) / (part.length * x.length);
    strips.push([part.length, strip.milliseconds]);
    yield found;
    await quiet(signal);
  }
}

/** Rows of the next strip, or points of a curve, at most twice those of the last: it takes `STRIP`, or twice what a
 * strip takes however few rows it has. Both are read off a line through the strips so far; before there are any, `row`
 * is what a row takes. @param {Took[]} strips @param {number} row */
export function rowsOfNext(strips, row) {
  if (!strips.length) return Math.max(1, Math.floor(STRIP / row));
  const last = strips[strips.length - 1][0];
  const mean = (/** @type {(took: Took) => number} */ value) =>
    strips.reduce((sum, strip) => sum + value(strip), 0) / strips.length;
  const [rows, time] = [mean(([n]) => n), mean(([, ms]) => ms)];
  const spread = mean(([n]) => (n - rows) ** 2);
  if (!spread) return Math.min(2 * last, Math.max(last + 1, Math.floor((last * STRIP) / time)));
  const slope = Math.min(Math.max(mean(([n, ms]) => (n - rows) * (ms - time)) / spread, 0), time / rows);
  const fixed = time - slope * rows;
  return Math.max(1, Math.min(2 * last, Math.floor((Math.max(STRIP, 2 * fixed) - fixed) / slope)));
}

/** A strip put onto those below it; words are numbered by every answer anew.
 * @param {Level} found @param {any} strip @param {number} nx */
function join(found, strip, nx) {
  for (const [name, values] of /** @type {[string, Float32Array][]} */ (Object.entries(strip.arrays))) {
    found.arrays[name] ??= new Float32Array(nx * found.ny).fill(Number.NaN);
    const { words } = strip.quantities[name];
    const about = (found.quantities[name] ??= { ...strip.quantities[name], words: words?.slice() });
    const number = words?.map((/** @type {string} */ word) => {
      if (!about.words.includes(word)) about.words.push(word);
      return about.words.indexOf(word);
    });
    const place = nx * found.rows;
    for (let i = 0; i < values.length; i++)
      found.arrays[name][place + i] = number ? (number[values[i]] ?? -1) : values[i];
  }
}

/** Until no move of the design waits for its answer. @param {AbortSignal} signal */
async function quiet(signal) {
  do {
    await new Promise((done) => setTimeout(done, 0));
    if (signal.aborted) throw new DOMException("another map is wanted", "AbortError");
  } while (Object.keys(data.moving).length);
}

/** The exact curves, halving the steps: yields lists of {kind, x, y}; a plane without such curves has none.
 * @param {Wanted} map @param {AbortSignal} signal */
export async function* curves(map, signal) {
  const { x, y, body } = map;
  if (switchesItself() || isHeld() || x.whole || y.whole || body.quantities.includes("label")) return;
  /** @type {Map<string, Curve>} */
  const found = new Map();
  const shares = halvings(4 * POINTS);
  /** @type {Took[]} */
  const strips = [];
  for (let done = 0; done < shares.length; done += strips[strips.length - 1][0]) {
    const part = shares.slice(done, done + rowsOfNext(strips, STRIP / 2)).sort((a, b) => a - b);
    const values = part.map((share) => x.from + share * (x.to - x.from));
    const begun = performance.now();
    const plane = { x: asked(x, values), y: { name: y.name, from: y.from, to: y.to } };
    const asks = { case: body.case, periods: body.periods, criterion: "reduced", kinds: ["fold", "flip"] };
    const strip = await post("boundaries", { ...asks, ...plane }, signal);
    strips.push([part.length, performance.now() - begun]);
    for (const curve of strip.curves) add(found, curve);
    yield [...found.values()];
    await quiet(signal);
  }
}

/** Shares 0 to 1: POINTS + 1 of them, then those between, and between again. @param {number} most */
function halvings(most) {
  const shares = Array.from({ length: POINTS + 1 }, (_, i) => i / POINTS);
  for (let count = 2 * POINTS; count <= most; count *= 2)
    shares.push(...Array.from({ length: count / 2 }, (_, i) => (2 * i + 1) / count));
  return shares;
}

/** An exact curve: what it is of, and its points in order.
 * @typedef {{ kind: string, points: number[][], x: number[], y: number[] }} Curve */

/** @param {Map<string, Curve>} found @param {{ kind: string, branch: number, x: number[], y: number[] }} curve */
function add(found, { kind, branch, x, y }) {
  const key = `${kind} ${branch}`;
  const points = (found.get(key)?.points ?? []).concat(x.map((value, i) => [value, y[i]])).sort((a, b) => a[0] - b[0]);
  found.set(key, { kind, points, x: points.map(([at]) => at), y: points.map(([, at]) => at) });
}
