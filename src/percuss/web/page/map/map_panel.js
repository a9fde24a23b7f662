// The stability plane: verdicts as an image, the exact fold and flip curves over it, the design as a point that can be
// dragged, clicked to another place, or moved by the arrow keys.

import { blowsInset } from "./blows_inset.js";
import { Chart } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { post, problemsOf, saidOf } from "../core/api.js";
import { div, framed, h, latest, problem, put, settled } from "../core/dom.js";
import { number, plainNumber, si } from "../core/format.js";
import { axis, keptRanges, labelOf, parameter, ready, startChoices, told } from "./map_axes.js";
import { followedItems, followedRow, stopFollowed, wantFollowed } from "./map_followed.js";
import { curves, level, wanted } from "./map_levels.js";
import { cellAt, content, legends, picture } from "./map_picture.js";
import { heldAt, present, rangeText, withKey } from "../core/moves.js";
import { effect, signal, whenever } from "../core/signals.js";
import { data, drag, locked, move, show, switchesItself, uptodate, view } from "../core/state.js";
import { during } from "../core/under_way.js";

export const defaults = {
  x: "", // its axes; those that its kind of hammer has first
  y: "",
  xr: "", // ranges of the axes "from:to", empty for the server's
  yr: "",
  q: "verdict",
  curves: 0, // 1: with what happens to the motion of the head, followed
};

/** @typedef {import("./map_axes.js").Axis} Axis */
/** @typedef {import("./map_axes.js").Which} Which */
/** @typedef {import("./map_levels.js").Wanted} Wanted */
/** A place in the plane. @typedef {{ x: number, y: number }} Place */

const TITLE = "Plane of two parameters";

const chart = new Chart(TITLE, { kind: "map", role: "application", about: TITLE });
const { canvas } = chart;
const readout = h("p", { class: "small", id: "map-readout", "aria-live": "polite" });
const status = h("p", { class: "small muted", id: "map-status", role: "status" });
const bar = h("progress", { max: 1, value: 0, id: "map-progress", "aria-label": "Progress of the finer map" });
const tip = h("div", { class: "tip", id: "map-tip", hidden: true });
/** Of what is finer than the first view. @type {AbortController | null} */
let asking = null;
/** The latest map. */
const plane = signal(/** @type {import("./map_picture.js").Plane | null} */ (null));
let key = ""; // of the map that is wanted
const lines = signal(/** @type {import("./map_levels.js").Curve[]} */ ([]));
let dragging = false;
let since = 0; // the last change of the case that made the map another

/** @param {HTMLElement} place */
export function startMap(place) {
  Object.assign(canvas, { tabIndex: 0, id: "map" });
  bar.hidden = true;
  const above = div("axes");
  const below = div("axes across");
  const progress = div("map-status", status, bar);
  const words = div("map-words", readout, progress, followedRow());
  put(place, div("axes-row", above, chart.saving), chart.figure, below, chart.key, words);
  chart.figure.append(tip, blowsInset());
  startChoices(above, below);
  pointer();
  whenever(
    () => data.changed,
    (changed) => {
      if (moveOnly()) return;
      since = changed;
      stopFollowed();
    },
  );
  effect(() => void (ready() && compute()));
  effect(repaint, framed);
}

/** The latest answer, from which a late one is known: of a machine that switches itself, its cycle. */
const answered = () => (switchesItself() ? data.machine : data.quick);

/** Whether the last change of the case moved along the map's own axes: the map is the same then. */
const moveOnly = () =>
  data.info &&
  data.moved?.every(
    (/** @type {string} */ name) => (name === axis("x").name || name === axis("y").name) && name !== "load.scale",
  );

/** Ask for the map of the case as it is now, unless that is under way or there. */
function compute() {
  if (!data.about || !answered() || data.problems.length) return;
  const [x, y] = [axis("x"), axis("y")];
  if (x.name === y.name) return put(status, "Choose two different parameters.");
  const map = wanted(x, y, Math.min(since, answered().changed)); // a late answer has the tables of its own change
  if (uptodate() && !data.moved?.length) wantFollowed(x, y, since);
  if (map.key === key) return;
  key = map.key;
  for (const part of ["coarse", "fine", "curves"]) delete canvas.dataset[part];
  asking?.abort();
  asking = null;
  coarse(map);
}

/** The first view; while one is under way, only the latest of the others waits. */
const coarse = latest(
  async (/** @type {Wanted} */ map) => {
    const { value } = await level(map, map.sides[0], 0, new AbortController().signal).next();
    return value;
  },
  (/** @type {any} */ found, map) => {
    lines.value = [];
    take(found, map, null);
    canvas.dataset.coarse = String(found.nx);
    if (map.key === key) during("map", finer(map, found.cost)).catch(failed);
  },
  failed,
);

/** @param {any} error */
function failed(error) {
  if (error.name === "AbortError") return;
  key = "";
  bar.hidden = true;
  const words = problemsOf(error).map((one) => saidOf(one).join(""));
  put(status, problem({ message: words.join("; ") }));
}

/** Finer and finer, and the curves; where cells take long, some points of the curves first.
 * @param {Wanted} map @param {number} cost */
async function finer(map, cost) {
  asking = new AbortController();
  const { signal } = asking;
  const exact = curves(map, signal);
  const last = map.sides[map.sides.length - 1];
  const slow = cost * last * last > 1000;
  bar.hidden = false;
  bar.value = 0;
  put(status, "Finer …");
  if (slow) await draw(exact);
  for (const side of map.sides.slice(1)) {
    const under = plane.value;
    for await (const found of level(map, side, cost, signal)) {
      take(found, map, found.rows < found.ny ? under : null);
      bar.value = found.rows / found.ny;
      put(status, `${number(100 * bar.value, 2)} % of ${found.nx} × ${found.ny} cells`);
    }
    if (side === last) canvas.dataset.fine = String(plane.value?.nx);
  }
  bar.hidden = true;
  put(status, `${plane.value?.nx} × ${plane.value?.ny} cells${switchesItself() ? ", each of a rigid piston" : ""}.`);
  while (await draw(exact));
}

/** The next points of the curves; false when there are no more. @param {ReturnType<typeof curves>} exact */
async function draw(exact) {
  const { value, done } = await exact.next();
  if (value) lines.value = value;
  canvas.dataset.curves = String(lines.value.length);
  return !done;
}

/** @param {import("./map_picture.js").Level} found
 * @param {Wanted} map @param {import("./map_picture.js").Plane | null} under */
function take(found, { x, y, version, kind }, under) {
  const { nx, ny, rows } = found;
  const image = { canvas: null, colours: null, looks: [], used: new Set(), hatches: [] };
  const latest = { x, y, under, version, nx, ny, rows, ...image, ...content(found, kind, under) };
  if (under) {
    under.under = null; // of three one on top of the other the lowest is out of sight
    Object.assign(under, { low: latest.low, high: latest.high });
    picture(under);
  }
  picture(latest);
  plane.value = latest;
}

/** Whether a map's axis is this one: over another range its picture would be wrong.
 * @param {Axis} one @param {Axis} other */
const like = (one, other) =>
  one.name === other.name && one.unit === other.unit && one.from === other.from && one.to === other.to;

/** Whether the latest map is over the axes that are wanted now. @param {Axis} x @param {Axis} y */
const shownHere = (x, y) => {
  const map = plane.value;
  return Boolean(map?.canvas && like(map.x, x) && like(map.y, y));
};

/** Whether it is of the case as it is now, but for a move along its axes. @param {Axis} x @param {Axis} y */
const ofNow = (x, y) => shownHere(x, y) && Number(plane.value?.version) >= since;

/** Where the design stands in the plane. @returns {Place | null} */
function design() {
  if (!data.tables) return null;
  const [x, y] = [axis("x").name, axis("y").name].map((name) => (name === "m" ? view.m : present(data, name)));
  return x === undefined || y === undefined ? null : { x, y };
}

function repaint() {
  if (!ready()) return;
  const [x, y] = [axis("x"), axis("y")];
  const map = plane.value;
  if (map && map.colours !== theme()) picture(map);
  const items = [
    ...legends(map, theme()),
    ...(ofNow(x, y) ? lines.value.map(line) : []),
    ...followedItems(x),
    pinnedAt(x, y),
    marked(x, y),
  ];
  chart.draw({
    x: { label: "", from: x.from, to: x.to },
    y: { label: "", from: y.from, to: y.to },
    items: items.filter(Boolean),
    image: map && shownHere(x, y) ? { ...imageOf(map), smooth: false, faded: !ofNow(x, y) } : null,
    about: `Map over ${labelOf(x)} and ${labelOf(y)}; arrow keys move the design`,
  });
}

/** @param {import("./map_picture.js").Plane} plane */
const imageOf = ({ canvas, hatches, under }) => ({ canvas, hatches, under });

/** @param {import("./map_levels.js").Curve} curve */
function line({ kind, x, y }) {
  const fold = kind === "fold";
  const name = fold ? "fold: no motion above" : "flip: period doubling";
  return { type: "line", x, y, colour: theme().ink, width: 2.4, dash: fold ? [] : [7, 5], name };
}

/** A design. @param {Place} at @param {number} size @param {string} colour @param {string} name */
const diamond = ({ x, y }, size, colour, name) => ({
  type: "points",
  x: [x],
  y: [y],
  shape: "diamond",
  size,
  colour,
  name,
});

/** The design that is pinned as A. @param {Axis} x @param {Axis} y */
function pinnedAt(x, y) {
  const at = data.pinned?.values;
  if (!at || !Number.isFinite(at[x.name]) || !Number.isFinite(at[y.name])) return null;
  return diamond({ x: at[x.name], y: at[y.name] }, 8, theme().accent, "A");
}

/** The present design as a point, and in words below. @param {Axis} x @param {Axis} y */
function marked(x, y) {
  const here = design();
  if (!here) return null;
  const place = `${told(x, here.x)}, ${told(y, here.y)}: ${answered()?.changed === data.changed ? verdict() : "…"}`;
  const map = plane.value;
  const cell = map?.kind === "families" && ofNow(x, y) ? cellAt(map, here) : "";
  const found = cell ? ` A simulation finds ${cell} there.` : "";
  put(readout, `${place}.${found}`);
  canvas.dataset.design = `${here.x},${here.y}`;
  blowsInset().className = here.x < (x.from + x.to) / 2 ? "right" : "left"; // the corner that the design is not in
  return diamond(here, 9, theme().dark ? "#ffffff" : "#101820", "the present design");
}

/** How far the design may move along either axis until it meets a curve: the nearest.
 * @returns {(Axis & { kind: string, value: number, far: number, label: string, now: number }) | null} */
export function nearestEdge() {
  if (!ready()) return null;
  const [x, y] = [axis("x"), axis("y")];
  const here = design();
  if (!here || !ofNow(x, y) || x.whole || y.whole) return null;
  /** @type {[Axis, Which, Which][]} */
  const ways = [
    [x, "x", "y"],
    [y, "y", "x"],
  ];
  /** @type {ReturnType<typeof nearestEdge>} */
  let nearest = null;
  for (const curve of lines.value)
    for (let i = 1; i < curve.x.length; i++) {
      if (![curve.x[i - 1], curve.x[i], curve.y[i - 1], curve.y[i]].every(Number.isFinite)) continue;
      for (const [along, own, other] of ways) {
        const [a, b] = [curve[other][i - 1] - here[other], curve[other][i] - here[other]];
        if (a * b > 0 || a === b) continue;
        const value = curve[own][i - 1] + (a / (a - b)) * (curve[own][i] - curve[own][i - 1]);
        const far = Math.abs(value - here[own]) / (along.to - along.from);
        if (!(far < (nearest?.far ?? Infinity))) continue;
        const label = parameter(along.name)?.label ?? along.name;
        nearest = { ...along, kind: curve.kind, value, far, label, now: here[own] };
      }
    }
  return nearest;
}

/** What the present design does, in few words. */
function verdict() {
  if (switchesItself()) return data.machine.answer.outcome;
  const { orbits } = data.quick;
  if (!orbits.length) return "no steady motion";
  return orbits.some((/** @type {any} */ { stable }) => stable) ? "stable" : "unstable";
}

function pointer() {
  const go = framed((/** @type {PointerEvent} */ event) => {
    const at = chart.at(event, true); // dragged out of the map, the design stays at its edge
    if (at) goTo(at);
  });
  canvas.addEventListener("click", (/** @type {any} */ event) => {
    if (event.pointerType === "touch" && chart.at(event)) go(event);
  });
  canvas.addEventListener("pointerdown", (event) => {
    if (!chart.at(event) || (event.pointerType === "touch" && !onDesign(event))) return; // a finger scrolls
    dragging = true;
    canvas.setPointerCapture(event.pointerId);
    go(event);
  });
  canvas.addEventListener("touchstart", (event) => void (onDesign(event.touches[0]) && event.preventDefault()), {
    passive: false,
  });
  const looked = framed(hover);
  canvas.addEventListener("pointermove", (event) => (dragging ? go(event) : looked(event)));
  canvas.addEventListener("pointerleave", () => looked(null));
  const zoomed = framed(zoom);
  canvas.addEventListener("wheel", (event) => {
    const at = chart.at(event);
    if (!at || event.ctrlKey) return;
    event.preventDefault();
    zoomed(at, event.deltaY);
  });
  canvas.addEventListener("dblclick", () => show({ xr: "", yr: "" }));
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (dragging = false));
  canvas.addEventListener("keydown", (event) => {
    const step = ARROWS[event.key];
    if (!step) return;
    event.preventDefault();
    const share = event.shiftKey ? 0.05 : 0.01;
    const here = design();
    if (!here) return;
    const next = (/** @type {Which} */ which, /** @type {number} */ k) => {
      const { from, to, whole } = axis(which);
      return here[which] + k * (whole ? 1 : share * (to - from));
    };
    goTo({ x: next("x", step[0]), y: next("y", step[1]) }, step);
  });
}

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Whether a finger begins on the diamond. @param {{ clientX: number, clientY: number }} touch */
function onDesign({ clientX, clientY }) {
  const { frame } = chart;
  const { scale } = theme();
  const here = design();
  if (!frame || !here) return false;
  const box = canvas.getBoundingClientRect();
  const [x, y] = [(clientX - box.left) / scale, (clientY - box.top) / scale];
  return Math.hypot(x - frame.px(here.x), y - frame.py(here.y)) < 26;
}

/** The wheel brings the point under it nearer, or farther away; a double click shows the whole plane again.
 * @param {Place} at @param {number} turned */
function zoom(at, turned) {
  const ratio = turned < 0 ? 0.8 : 1.25;
  const range = (/** @type {Which} */ which) => {
    const { from, to, unit, whole } = axis(which);
    if (whole) return view[`${which}r`];
    const ends = [from, to].map((end) => plainNumber(at[which] + (end - at[which]) * ratio, 5));
    return rangeText(from >= 0 ? Math.max(ends[0], 0) : ends[0], ends[1], unit);
  };
  show({ xr: range("x"), yr: range("y") });
}

/** What stands in the cell under the pointer, beside it: of a motion the exact label.
 * @param {PointerEvent | null} event */
function hover(event) {
  const at = event && !dragging ? chart.at(event) : null;
  const [x, y] = [axis("x"), axis("y")];
  const cell = at && plane.value && ofNow(x, y) ? cellAt(plane.value, at) : "";
  tip.hidden = !cell;
  if (!at || !cell || switchesItself()) ghost(null);
  else ghost({ [x.name]: plainNumber(at.x, 6), [y.name]: plainNumber(at.y, 6) });
  if (!event || !at || !cell) return;
  put(tip, h("strong", {}, cell), h("br"), `${told(x, at.x, 3)}, ${told(y, at.y, 3)}`);
  const box = canvas.getBoundingClientRect();
  const [x0, y0] = [event.clientX - box.left, canvas.offsetTop + event.clientY - box.top];
  const side =
    x0 > box.width / 2 ? { left: "auto", right: `${box.width - x0 + 14}px` } : { left: `${x0 + 14}px`, right: "auto" };
  Object.assign(tip.style, side, { top: `${y0 + 14}px` }); // on the side where there is room
}

/** The motion at a point of the map, beside the present one; with its verdict. */
const ghost = settled((/** @type {Record<string, number> | null} */ values) => {
  const movable = values && Object.keys(values).every((name) => name === "m" || parameter(name)?.movable);
  if (!movable || !data.tables) return showGhost(null);
  askGhost(values);
}, 90);

const askGhost = latest(
  (/** @type {Record<string, number>} */ { m, ...values }) =>
    post("quick", { case: data.tables, periods: m ?? view.m, values, curve: 0, multipliers: false }),
  (found) => showGhost(tip.hidden ? null : found),
  () => showGhost(null),
);

/** @param {Record<string, any> | null} found */
function showGhost(found) {
  const orbit = found?.orbits.find((/** @type {any} */ { stable }) => stable) ?? found?.orbits[0];
  data.ghost = orbit && found?.motion ? { model: found.motion, orbit } : null;
  if (!orbit) return;
  const energy = orbit.si ? `, ${si(orbit.si.blow_energy_J, "J", 3)}` : "";
  tip.append(h("br"), `${orbit.stable ? "stable" : "unstable"}${energy}`);
}

/** The design put there, as far as its tables can say it.
 * @param {Place} at @param {[number, number]} [step] */
function goTo(at, step = [1, 1]) {
  /** @type {Record<string, number>} */
  const values = {};
  let refused = "";
  for (const [i, which] of /** @type {const} */ (["x", "y"]).entries()) {
    const { name, from, to } = axis(which);
    const value = Math.min(Math.max(at[which], Math.min(from, to)), Math.max(from, to));
    if (step[i] === 0 || locked(name)) continue;
    if (name === "m") show({ m: Math.max(1, Math.round(value)) });
    else if (parameter(name)?.movable) values[name] = plainNumber(value, 6);
    else refused = labelOf({ name });
  }
  if (refused)
    put(readout, `The ${refused} of this case cannot be changed by itself: change the load on the Case panel.`);
  if (!Object.keys(values).length) return;
  if (!switchesItself()) return move(values);
  show(keptRanges()); // the server's move with the values
  let { tables } = data;
  for (const [name, value] of Object.entries(values)) {
    const { unit } = parameter(name);
    tables = withKey(tables, heldAt(tables, name), unit ? `${value} ${unit}` : value);
  }
  drag(tables, Object.keys(values));
}
