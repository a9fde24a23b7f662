// The stability plane: verdicts as an image, the exact fold and flip curves over it, the design as a point that can be
// dragged, clicked to another place, or moved by the arrow keys.

import { blowsInset } from "./blows_inset.js";
import { Chart } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { post, saidOf } from "../core/api.js";
import { framed, h, latest, put, settled } from "../core/dom.js";
import { number, plainNumber, si } from "../core/format.js";
import { axis, choices, keptRanges, labelOf, parameter, told } from "./map_axes.js";
import { followedItems, followedRow, stopFollowed, wantFollowed } from "./map_followed.js";
import { curves, level, wanted } from "./map_levels.js";
import { cellAt, content, legends, picture } from "./map_picture.js";
import { heldAt, present, rangeText, withKey } from "../core/moves.js";
import { data, drag, locked, move, on, show, switchesItself, tell, uptodate, view } from "../core/state.js";
import { during } from "../core/under_way.js";

export const defaults = {
  x: "", // its axes; those that its kind of hammer has first
  y: "",
  xr: "", // ranges of the axes "from:to", empty for the server's
  yr: "",
  q: "verdict",
  curves: 0, // 1: with what happens to the motion of the head, followed
};

const parts = {};
let asking = null; // the abort controller of what is finer than the first view
let plane = null; // the latest map: {x, y, nx, ny, codes or values, under}
let lines = [];
let dragging = false;
let since = 0; // the last change of the case that made the map another

export function startMap(place) {
  parts.chart = new Chart("Plane of two parameters", { kind: "map", role: "application", about: "Plane of two parameters" });
  parts.chart.canvas.tabIndex = 0;
  parts.chart.canvas.id = "map";
  parts.readout = h("p", { class: "small", id: "map-readout", "aria-live": "polite" });
  parts.status = h("p", { class: "small muted", id: "map-status", role: "status" });
  parts.bar = h("progress", { max: 1, value: 0, id: "map-progress", "aria-label": "Progress of the finer map" });
  parts.bar.hidden = true;
  parts.choice = { above: h("div", { class: "axes" }), below: h("div", { class: "axes across" }) };
  const below = h("div", { class: "map-status" }, parts.status, parts.bar);
  put(place, h("div", { class: "axes-row" }, parts.choice.above, parts.chart.saving), parts.chart.figure, parts.choice.below, parts.chart.key, h("div", { class: "map-words" }, parts.readout, below, followedRow(repaint)));
  parts.tip = h("div", { class: "tip", id: "map-tip", hidden: true });
  parts.chart.figure.append(parts.tip, blowsInset());
  pointer(parts.chart.canvas);
  on("tables", () => {
    if (moveOnly()) return;
    since = data.changed;
    stopFollowed();
  });
  on("info view quick machine", () => ready() && (choices(parts.choice), compute()));
  on("theme", () => (plane && picture(plane), repaint()));
  on("tables quick machine view steady pinned", repaint);
}

/** Whether the panel is in sight, and what is known of the case is known of this kind of case. */
const ready = () => Boolean(data.info) && Boolean(data.info.system) !== switchesItself();

/** The latest answer, from which a late one is known: of a machine that switches itself, its cycle. */
const answered = () => (switchesItself() ? data.machine : data.quick);

/** Whether the last change of the case moved along the map's own axes: the map is the same then. */
const moveOnly = () =>
  data.info && data.moved?.every((name) => (name === axis("x").name || name === axis("y").name) && name !== "load.scale");

/** Ask for the map of the case as it is now, unless that is under way or there. */
function compute() {
  if (!data.about || !answered() || data.problems.length) return;
  const x = axis("x");
  const y = axis("y");
  if (x.name === y.name) return put(parts.status, "Choose two different parameters.");
  const map = wanted(x, y, Math.min(since, answered().changed)); // a late answer has the tables of its own change
  if (uptodate() && !data.moved?.length) wantFollowed(x, y, since);
  if (map.key === parts.key) return;
  parts.key = map.key;
  for (const part of ["coarse", "fine", "curves"]) delete parts.chart.canvas.dataset[part];
  asking?.abort();
  asking = null;
  coarse(map);
}

/** The first view; while one is under way, only the latest of the others waits. */
const coarse = latest(
  async (map) => {
    const { value } = await level(map, map.sides[0], 0, new AbortController().signal).next();
    return value;
  },
  (found, map) => {
    lines = [];
    take(found, map, null);
    parts.chart.canvas.dataset.coarse = String(found.nx);
    if (map.key === parts.key) during("map", finer(map, found.cost)).catch(failed);
  },
  failed,
);

function failed(error) {
  if (error.name === "AbortError") return;
  parts.key = "";
  parts.bar.hidden = true;
  const words = error.problems?.map((p) => saidOf(p).join("")).join("; ");
  put(parts.status, h("span", { class: "problem" }, words || error.message));
}

/** Finer and finer, and the curves; where cells take long, some points of the curves first. */
async function finer(map, cost) {
  asking = new AbortController();
  const { signal } = asking;
  const exact = curves(map, signal);
  const last = map.sides.at(-1);
  const slow = cost * last * last > 1000;
  parts.bar.hidden = false;
  parts.bar.value = 0;
  put(parts.status, "Finer …");
  if (slow) await draw(exact);
  for (const side of map.sides.slice(1)) {
    const under = plane;
    for await (const found of level(map, side, cost, signal)) {
      take(found, map, found.rows < found.ny ? under : null);
      const share = found.rows / found.ny;
      parts.bar.value = share;
      put(parts.status, `${number(100 * share, 2)} % of ${found.nx} × ${found.ny} cells`);
    }
    if (side === last) parts.chart.canvas.dataset.fine = String(plane.nx);
  }
  parts.bar.hidden = true;
  put(parts.status, `${plane.nx} × ${plane.ny} cells${switchesItself() ? ", each of a rigid piston" : ""}.`);
  while (await draw(exact));
}

/** The next points of the curves; false when there are no more. */
async function draw(exact) {
  const { value, done } = await exact.next();
  if (value) lines = value;
  tell("edges");
  parts.chart.canvas.dataset.curves = String(lines.length);
  repaint();
  return !done;
}

function take(found, { x, y, version, kind }, under) {
  plane = { x, y, under, version, nx: found.nx, ny: found.ny, rows: found.rows, ...content(found, kind, under) };
  if (under) {
    under.under = null; // of three one on top of the other the lowest is out of sight
    Object.assign(under, { low: plane.low, high: plane.high });
    picture(under);
  }
  picture(plane);
  repaint();
}

/** Whether a map's axis is this one: over another range its picture would be wrong. */
const like = (one, other) => ["name", "unit", "from", "to"].every((part) => one[part] === other[part]);

/** Whether the latest map is over the axes that are wanted now. */
const shownHere = (x, y) => Boolean(plane?.canvas && like(plane.x, x) && like(plane.y, y));

/** Whether it is of the case as it is now, but for a move along its axes. */
const ofNow = (x, y) => shownHere(x, y) && plane.version >= since;

/** Where the design stands in the plane. */
function design() {
  const at = (which) => {
    const { name } = axis(which);
    if (name === "m") return view.m;
    return data.tables ? present(data, name) : undefined;
  };
  return { x: at("x"), y: at("y") };
}

const repaint = framed(() => {
  if (!ready()) return;
  const x = axis("x");
  const y = axis("y");
  const same = shownHere(x, y);
  const items = [...legends(plane, theme()), ...(ofNow(x, y) ? lines.map(line) : []), ...followedItems(x), pinnedAt(x, y), marked(x, y)];
  parts.chart.draw({
    x: { label: "", from: x.from, to: x.to },
    y: { label: "", from: y.from, to: y.to },
    items: items.filter(Boolean),
    image: same ? { canvas: plane.canvas, hatches: plane.hatches, under: plane.under, smooth: false, faded: !ofNow(x, y) } : null,
    about: `Map over ${labelOf(x)} and ${labelOf(y)}; arrow keys move the design`,
  });
});

const line = ({ kind, x, y }) => ({
  type: "line",
  x,
  y,
  colour: theme().ink,
  width: 2.4,
  dash: kind === "fold" ? [] : [7, 5],
  name: kind === "fold" ? "fold: no motion above" : "flip: period doubling",
});

/** The design that is pinned as A. */
function pinnedAt(x, y) {
  const at = data.pinned?.values;
  if (!at || !Number.isFinite(at[x.name]) || !Number.isFinite(at[y.name])) return null;
  return { type: "points", x: [at[x.name]], y: [at[y.name]], shape: "diamond", size: 8, colour: theme().accent, name: "A" };
}

/** The present design as a point, and in words below. */
function marked(x, y) {
  const here = design();
  if (here.x === undefined || here.y === undefined) return null;
  const place = `${told(x, here.x)}, ${told(y, here.y)}: ${answered()?.changed === data.changed ? verdict() : "…"}`;
  const cell = plane?.kind === "families" && ofNow(x, y) ? cellAt(plane, here) : "";
  const found = cell ? ` A simulation finds ${cell} there.` : "";
  put(parts.readout, `${place}.${found}`);
  parts.chart.canvas.dataset.design = `${here.x},${here.y}`;
  blowsInset().className = here.x < (x.from + x.to) / 2 ? "right" : "left"; // the corner that the design is not in
  const colour = theme().dark ? "#ffffff" : "#101820";
  return { type: "points", x: [here.x], y: [here.y], shape: "diamond", size: 9, colour, name: "the present design" };
}

/** How far the design may move along either axis until it meets a curve: {name, unit, label, value, kind}, the nearest. */
export function nearestEdge() {
  if (!ready()) return null;
  const [x, y] = [axis("x"), axis("y")];
  if (!ofNow(x, y) || x.whole || y.whole) return null;
  const here = design();
  const found = [];
  for (const { kind, x: xs, y: ys } of lines)
    for (let i = 1; i < xs.length; i++) {
      if ([xs[i - 1], xs[i], ys[i - 1], ys[i]].some((value) => value === null || !Number.isFinite(value))) continue;
      const cross = (along, across, own, other, at) => {
        const [a, b] = [other[i - 1] - at, other[i] - at];
        if (a * b > 0 || a === b) return;
        const value = own[i - 1] + (a / (a - b)) * (own[i] - own[i - 1]);
        found.push({ ...along, kind, value, far: Math.abs(value - here[across]) / (along.to - along.from) });
      };
      cross(x, "x", xs, ys, here.y);
      cross(y, "y", ys, xs, here.x);
    }
  const nearest = found.sort((a, b) => a.far - b.far)[0];
  return nearest ? { ...nearest, label: parameter(nearest.name)?.label ?? nearest.name, now: here[nearest.name === x.name ? "x" : "y"] } : null;
}

/** What the present design does, in few words. */
function verdict() {
  if (switchesItself()) return data.machine.answer.outcome;
  const { orbits } = data.quick;
  return orbits.some((orbit) => orbit.stable) ? "stable" : orbits.length ? "unstable" : "no steady motion";
}

function pointer(canvas) {
  const go = framed((event) => {
    const at = parts.chart.at(event, true); // dragged out of the map, the design stays at its edge
    if (at) goTo(at);
  });
  canvas.addEventListener("click", (event) => event.pointerType === "touch" && parts.chart.at(event) && go(event));
  canvas.addEventListener("pointerdown", (event) => {
    if (!parts.chart.at(event) || (event.pointerType === "touch" && !onDesign(event))) return; // a finger scrolls
    dragging = true;
    canvas.setPointerCapture(event.pointerId);
    go(event);
  });
  canvas.addEventListener("touchstart", (event) => onDesign(event.touches[0]) && event.preventDefault(), { passive: false });
  const looked = framed(hover);
  canvas.addEventListener("pointermove", (event) => (dragging ? go(event) : looked(event)));
  canvas.addEventListener("pointerleave", () => looked(null));
  const zoomed = framed(zoom);
  canvas.addEventListener("wheel", (event) => {
    const at = parts.chart.at(event);
    if (!at || event.ctrlKey) return;
    event.preventDefault();
    zoomed(at, event.deltaY);
  });
  canvas.addEventListener("dblclick", () => show({ xr: "", yr: "" }));
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (dragging = false));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const share = event.shiftKey ? 0.05 : 0.01;
    const here = design();
    const next = (which, k) => {
      const { from, to, whole } = axis(which);
      return here[which] + k * (whole ? 1 : share * (to - from));
    };
    goTo({ x: next("x", step[0]), y: next("y", step[1]) }, step);
  });
}

/** Whether a finger begins on the diamond. */
function onDesign({ clientX, clientY }) {
  const { frame, scale, canvas } = parts.chart;
  const here = design();
  if (!frame || here.x === undefined || here.y === undefined) return false;
  const box = canvas.getBoundingClientRect();
  const [x, y] = [(clientX - box.left) / scale, (clientY - box.top) / scale];
  return Math.hypot(x - frame.px(here.x), y - frame.py(here.y)) < 26;
}

/** The wheel brings the point under it nearer, or farther away; a double click shows the whole plane again. */
function zoom(at, turned) {
  const ratio = turned < 0 ? 0.8 : 1.25;
  const ranges = ["x", "y"].map((which) => {
    const { from, to, unit, whole } = axis(which);
    if (whole) return [`${which}r`, view[`${which}r`]];
    const ends = [from, to].map((end) => plainNumber(at[which] + (end - at[which]) * ratio, 5));
    const low = axis(which).least ?? -Infinity;
    return [`${which}r`, rangeText(Math.max(ends[0], from >= 0 ? Math.max(low, 0) : low), ends[1], unit)];
  });
  show(Object.fromEntries(ranges));
}

/** What stands in the cell under the pointer, beside it: of a motion the exact label. */
function hover(event) {
  const at = event && !dragging ? parts.chart.at(event) : null;
  const [x, y] = [axis("x"), axis("y")];
  const cell = at && ofNow(x, y) ? cellAt(plane, at) : "";
  parts.tip.hidden = !cell;
  if (!cell || switchesItself()) ghost(null);
  else ghost({ [x.name]: plainNumber(at.x, 6), [y.name]: plainNumber(at.y, 6) });
  if (!cell) return;
  const place = `${told(x, at.x, 3)}, ${told(y, at.y, 3)}`;
  put(parts.tip, h("strong", {}, cell), h("br"), place);
  const box = parts.chart.canvas.getBoundingClientRect();
  const left = event.clientX - box.left;
  const right = left > box.width / 2; // on the side where there is room
  Object.assign(parts.tip.style, {
    left: right ? "auto" : `${left + 14}px`,
    right: right ? `${box.width - left + 14}px` : "auto",
    top: `${parts.chart.canvas.offsetTop + event.clientY - box.top + 14}px`,
  });
}

/** The motion at a point of the map, beside the present one; with its verdict. */
const ghost = settled((values) => {
  const movable = values && Object.keys(values).every((name) => name === "m" || parameter(name)?.movable);
  if (!movable || !data.tables) return told_(null);
  askGhost({ values });
}, 90);

const askGhost = latest(
  ({ values: { m, ...values } }) => post("quick", { case: data.tables, periods: m ?? view.m, values, curve: 0, multipliers: false }),
  (found) => told_(parts.tip.hidden ? null : found),
  () => told_(null),
);

function told_(found) {
  const orbit = found?.orbits.find(({ stable }) => stable) ?? found?.orbits[0];
  data.ghost = orbit && found.motion ? { model: found.motion, orbit } : null;
  tell("ghost");
  if (!orbit) return;
  const energy = orbit.si ? `, ${si(orbit.si.blow_energy_J, "J", 3)}` : "";
  parts.tip.append(h("br"), `${orbit.stable ? "stable" : "unstable"}${energy}`);
}

/** The value of a key as a case has it. */
const withUnitOf = (name, value) => (parameter(name).unit ? `${value} ${parameter(name).unit}` : value);

/** The design put there, as far as its tables can say it. */
function goTo(at, step = [1, 1]) {
  const values = {};
  let refused = "";
  for (const [i, which] of ["x", "y"].entries()) {
    const { name, from, to } = axis(which);
    const value = Math.min(Math.max(at[which], Math.min(from, to)), Math.max(from, to));
    if (step[i] === 0 || locked(name)) continue;
    if (name === "m") show({ m: Math.max(1, Math.round(value)) });
    else if (parameter(name)?.movable) values[name] = plainNumber(value, 6);
    else refused = labelOf({ name });
  }
  if (refused)
    put(parts.readout, `The ${refused} of this case cannot be changed by itself: change the load on the Case panel.`);
  if (!Object.keys(values).length) return;
  if (!switchesItself()) return move(values);
  show(keptRanges()); // the server's move with the values
  const written = (tables, [name, value]) => withKey(tables, heldAt(tables, name), withUnitOf(name, value));
  drag(Object.entries(values).reduce(written, data.tables), Object.keys(values));
}
