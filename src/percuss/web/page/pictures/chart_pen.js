// The pen of the charts: axes, lines, points, bands, and the samples of the legend.

import { number } from "../core/format.js";
import { theme } from "./colours.js";
import { fillHatch, hatched } from "./hatch.js";
import { FONT, ownCanvas, path, strokeLines } from "./pen.js";
import { tr } from "../core/words.js";

/** A pen of a canvas, or one that makes an SVG. @typedef {any} Pen */
/** @typedef {{ label: string, from: number, to: number, ticks?: any[][] }} Axis */
/** What is drawn in a chart:
 *   line {x, y, colour, dash?, width?}, points {x, y, shape, colour, colours?, size?, under?: below the lines},
 *   band {from, to, colour} (in y), level {at, axis?, colour, dash?}, circle {radius}, label {x, y, text},
 *   patch {colour, hatch} (in the legend alone); what has a name is in the legend.
 * @typedef {{ type: string, name?: string, x?: any, y?: any, colour?: string, [more: string]: any }} Item */
/** Cells over the whole plane, the first row at the bottom, with the hatches of some, and others under them.
 * @typedef {{ canvas: HTMLCanvasElement | null, hatches?: { hatch: string, canvas: HTMLCanvasElement }[], smooth?: boolean,
 *   under?: Cells | null, faded?: boolean }} Cells */
/** A chart as it is to be drawn; `equal`: one scale on both axes.
 * @typedef {{ x: Axis, y: Axis, items: Item[], equal?: boolean, about?: string, image?: Cells | null }} Spec */
/** @typedef {ReturnType<typeof layout>} Frame */

/** What an item looks like, as a picture for the legend. @param {Item} item */
export function swatch(item) {
  const { canvas, pen } = ownCanvas(26, 12, 2, { class: "swatch", "aria-hidden": "true" });
  sample(pen, item);
  return canvas;
}

/** What an item looks like, for the legend: 26 by 12. @param {Pen} pen @param {Item} item */
export function sample(pen, item) {
  if (item.type === "band" || item.type === "patch") {
    if (item.type === "band") pen.globalAlpha = item.alpha ?? 0.25;
    pen.fillStyle = item.colour;
    pen.fillRect(2, 1, 22, 10);
    fillHatch(pen, item.hatch, 2, 1, 22, 10, 2);
  } else if (item.type === "points") {
    mark(pen, item.shape, 13, 6, Math.min(item.size ?? 5, item.shape === "diamond" ? 3.8 : 4.6), item.colour ?? "");
  } else {
    stroke(pen, item);
    path(pen, [[1, 6, 25, 6]]);
    pen.stroke();
  }
}

/** Ticks at round numbers. @param {Axis} axis @param {number} wanted @returns {[number, string][]} */
function ticksOf({ from, to, ticks }, wanted) {
  if (ticks) return /** @type {[number, string][]} */ (ticks);
  const raw = (to - from) / Math.max(wanted, 1);
  if (!(raw > 0)) return [];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 2.5, 5].find((k) => k * power >= raw * 0.999) ?? 10);
  /** @type {[number, string][]} */
  const found = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + step * 1e-9; i++) {
    const value = Number((i * step).toPrecision(12));
    found.push([value, number(value, 6)]);
  }
  return found;
}

/** Where the plane of a chart lies in its picture, and what is where in it.
 * @param {Pen} pen @param {Spec} spec @param {number} width @param {number} height */
export function layout(pen, { x, y, equal }, width, height) {
  pen.font = FONT;
  let [top, bottom] = [10, height - (x.label ? 40 : 22)];
  const ticksY = ticksOf(y, (bottom - top) / 45);
  const widest = Math.max(0, ...ticksY.map(([, text]) => pen.measureText(tr(text)).width));
  let [left, right] = [Math.ceil(widest) + (y.label ? 30 : 10), width - 12];
  if (equal) {
    const side = Math.min(right - left, bottom - top);
    left += (right - left - side) / 2;
    right = left + side;
    top += (bottom - top - side) / 2;
    bottom = top + side;
  }
  const kx = (right - left) / (x.to - x.from || 1);
  const ky = (bottom - top) / (y.to - y.from || 1);
  return {
    ...{ left, right, top, bottom, widest, ticksY, ticksX: ticksOf(x, (right - left) / 75) },
    px: (/** @type {number} */ value) => left + (value - x.from) * kx,
    py: (/** @type {number} */ value) => bottom - (value - y.from) * ky,
    toX: (/** @type {number} */ px) => x.from + (px - left) / kx,
    toY: (/** @type {number} */ py) => y.from + (bottom - py) / ky,
  };
}

/** @param {Pen} pen @param {Spec} spec @param {Frame} frame */
export function paint(pen, spec, frame) {
  const { left, right, top, bottom, px, py } = frame;
  if (spec.image) image(pen, spec.image, frame);
  grid(pen, spec, frame);
  pen.save();
  pen.beginPath();
  pen.rect(left - 1, top - 1, right - left + 2, bottom - top + 2);
  pen.clip();
  for (const item of spec.items) if (item.under) marks(pen, item, frame);
  for (const item of spec.items) draw(pen, item, frame);
  pen.restore();
  for (const item of spec.items) {
    if (item.type === "points" && !item.under) {
      marks(pen, item, frame);
    } else if (item.type === "label") {
      pen.fillStyle = item.colour ?? theme().ink;
      pen.textAlign = item.align ?? "left";
      pen.fillText(tr(item.text), px(item.x) + (item.dx ?? 6), py(item.y) + (item.dy ?? -6));
    }
  }
}

/** @param {Pen} pen @param {Item} item @param {Frame} frame */
function marks(pen, item, { left, right, top, bottom, px, py }) {
  for (let i = 0; i < item.x.length; i++) {
    const x = px(item.x[i]);
    const y = py(item.y[i]);
    if (x < left - 1 || x > right + 1 || y < top - 1 || y > bottom + 1 || Number.isNaN(y)) continue;
    mark(pen, item.shape, x, y, item.size ?? 6, item.colours?.[i] ?? item.colour ?? "");
  }
}

/** Cells about their values: the outermost reach half a cell beyond the plane.
 * @param {Pen} pen @param {Cells} shown @param {Frame} frame */
function image(pen, shown, { left, right, top, bottom }) {
  const [width, height] = [right - left, bottom - top];
  pen.imageSmoothingEnabled = shown.smooth;
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.globalAlpha = shown.faded ? 0.4 : 1;
  pen.translate(left, top);
  const place = (/** @type {Pen} */ into, /** @type {HTMLCanvasElement} */ cells) => {
    const [across, up] = [width / Math.max(cells.width - 1, 1), height / Math.max(cells.height - 1, 1)];
    into.save();
    into.translate(0, height);
    into.scale(1, -1);
    into.drawImage(cells, -across / 2, -up / 2, across * cells.width, up * cells.height);
    into.restore();
  };
  for (const { canvas, hatches } of shown.under ? [shown.under, shown] : [shown]) {
    if (canvas) place(pen, canvas);
    if (!canvas || !hatches?.length) continue;
    const layer = hatched({ canvas, hatches }, width, height, pen.getTransform().a, place);
    pen.drawImage(layer, 0, 0, width, height);
  }
  pen.restore();
}

/** @param {Pen} pen @param {Spec} spec @param {Frame} frame */
function grid(pen, spec, { left, right, top, bottom, widest, px, py, ticksX, ticksY }) {
  const { line, muted } = theme();
  pen.lineWidth = 1;
  pen.strokeStyle = line;
  pen.fillStyle = muted;
  pen.font = FONT;
  const across = ticksY.map(([value]) => [left, half(py(value)), right, half(py(value))]);
  const down = ticksX.map(([value]) => [half(px(value)), top, half(px(value)), bottom]);
  path(pen, spec.image ? [] : [...down, ...across]);
  pen.rect(half(left), half(top), Math.round(right - left), Math.round(bottom - top));
  pen.stroke();
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const [value, text] of ticksX) pen.fillText(tr(text), px(value), bottom + 5);
  pen.fillText(tr(spec.x.label), (left + right) / 2, bottom + 22);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const [value, text] of ticksY) pen.fillText(tr(text), left - 6, py(value));
  pen.save();
  pen.translate(left - widest - 18, (top + bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText(tr(spec.y.label), 0, 0);
  pen.restore();
  pen.textBaseline = "alphabetic";
}

/** @param {number} value */
const half = (value) => Math.round(value) + 0.5;

/** @param {Pen} pen @param {Item} item */
function stroke(pen, item) {
  pen.strokeStyle = item.colour ?? theme().muted;
  pen.lineWidth = item.width ?? 2;
  pen.lineJoin = "round";
  pen.setLineDash(item.dash ?? []);
}

/** What is drawn within the plane. @param {Pen} pen @param {Item} item @param {Frame} frame */
function draw(pen, item, { left, right, top, bottom, px, py }) {
  if (["points", "label", "patch"].includes(item.type)) return;
  if (item.type === "band") {
    pen.globalAlpha = item.alpha ?? 0.25;
    pen.fillStyle = item.colour;
    pen.fillRect(left, py(item.to), right - left, py(item.from) - py(item.to));
    pen.globalAlpha = 1;
    return;
  }
  stroke(pen, item);
  pen.beginPath();
  if (item.type === "level") {
    const [x, y] = [px(item.at), py(item.at)];
    path(pen, [item.axis === "x" ? [x, top, x, bottom] : [left, y, right, y]]);
  } else if (item.type === "circle") {
    pen.ellipse(px(0), py(0), px(item.radius) - px(0), py(0) - py(item.radius), 0, 0, 2 * Math.PI);
  } else {
    let up = true; // there are gaps where a value is null or not a number
    for (let i = 0; i < item.x.length; i++) {
      const [a, b] = [item.x[i], item.y[i]];
      if (a === null || b === null || Number.isNaN(a) || Number.isNaN(b)) up = true;
      else if (up) (pen.moveTo(px(a), py(b)), (up = false));
      else pen.lineTo(px(a), py(b));
    }
  }
  pen.stroke();
  pen.setLineDash([]);
}

/** Marks of strokes, about the point and for a size of 1. @type {Record<string, number[][]>} */
const CROSSED = { cross: [[-1, -1, 1, 1], [-1, 1, 1, -1]], plus: [[-1.3, 0, 1.3, 0], [0, 1.3, 0, -1.3]] }; // prettier-ignore
/** Corners of areas. @type {Record<string, number[]>} */
const CORNERS = {
  diamond: [0, -1.4, 1.1, 0, 0, 1.4, -1.1, 0],
  square: [-0.9, -0.9, 0.9, -0.9, 0.9, 0.9, -0.9, 0.9],
  triangle: [0, -1.2, 1.1, 0.8, -1.1, 0.8],
};

/** Shapes tell apart what colours tell apart: disc stable, ring unstable, cross not possible, diamond the design, square
 * a fold, triangle a flip, plus a corner.
 * @param {Pen} pen @param {string} shape @param {number} x @param {number} y @param {number} size @param {string} colour */
export function mark(pen, shape, x, y, size, colour) {
  const placed = (/** @type {number[]} */ line) => line.map((one, i) => (i % 2 ? y : x) + size * one);
  pen.setLineDash([]);
  if (CROSSED[shape]) return strokeLines(pen, colour, 2.4, ...CROSSED[shape].map(placed));
  const { surface } = theme();
  path(pen, CORNERS[shape] ? [placed(CORNERS[shape])] : []);
  if (CORNERS[shape]) pen.closePath();
  else pen.arc(x, y, size, 0, 2 * Math.PI);
  pen.fillStyle = shape === "ring" ? surface : colour;
  pen.fill();
  if (shape === "dot") return;
  pen.lineWidth = shape === "ring" ? 2.4 : 1.6;
  pen.strokeStyle = shape === "ring" ? colour : surface;
  pen.stroke();
}
