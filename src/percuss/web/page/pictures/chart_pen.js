// The pen of the charts: axes, lines, points, bands, and the samples of the legend.

import { number } from "../core/format.js";
import { theme } from "./colours.js";
import { fillHatch, hatched } from "./hatch.js";
import { tr } from "../core/words.js";

const FONT = "12.5px system-ui, sans-serif";

export function swatch(item) {
  const canvas = document.createElement("canvas");
  canvas.width = 52;
  canvas.height = 24;
  canvas.setAttribute("aria-hidden", "true");
  canvas.className = "swatch";
  const pen = canvas.getContext("2d");
  pen.scale(2, 2);
  sample(pen, item);
  return canvas;
}

/** What an item looks like, for the legend: 26 by 12. */
export function sample(pen, item) {
  if (item.type === "band") {
    pen.globalAlpha = item.alpha ?? 0.25;
    pen.fillStyle = item.colour;
    pen.fillRect(2, 1, 22, 10);
  } else if (item.type === "patch") {
    pen.fillStyle = item.colour;
    pen.fillRect(2, 1, 22, 10);
    fillHatch(pen, item.hatch, 2, 1, 22, 10, 2);
  } else if (item.type === "points") {
    mark(pen, item.shape, 13, 6, Math.min(item.size ?? 5, item.shape === "diamond" ? 3.8 : 4.6), item.colour);
  } else {
    stroke(pen, item);
    pen.beginPath();
    pen.moveTo(1, 6);
    pen.lineTo(25, 6);
    pen.stroke();
  }
}

/** Ticks at round numbers. */
function roundTicks(from, to, wanted) {
  const span = to - from;
  if (!(span > 0)) return [];
  const raw = span / Math.max(wanted, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.999);
  const found = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + step * 1e-9; i++)
    found.push(Number((i * step).toPrecision(12)));
  return found.map((value) => [value, number(value, 6)]);
}

export function layout(pen, spec, width, height) {
  pen.font = FONT;
  const bottom = height - (spec.x.label ? 40 : 22);
  const top = 10;
  const ticksY = spec.y.ticks ?? roundTicks(spec.y.from, spec.y.to, (bottom - top) / 45);
  const widest = Math.max(0, ...ticksY.map(([, text]) => pen.measureText(tr(text)).width));
  let left = Math.ceil(widest) + (spec.y.label ? 30 : 10);
  let right = width - 12;
  let low = bottom;
  let high = top;
  if (spec.equal) {
    const side = Math.min(right - left, bottom - top);
    left += (right - left - side) / 2;
    right = left + side;
    high = top + (bottom - top - side) / 2;
    low = high + side;
  }
  const { x, y } = spec;
  const kx = (right - left) / (x.to - x.from || 1);
  const ky = (low - high) / (y.to - y.from || 1);
  return {
    left,
    right,
    top: high,
    bottom: low,
    ticksY,
    ticksX: x.ticks ?? roundTicks(x.from, x.to, (right - left) / 75),
    px: (value) => left + (value - x.from) * kx,
    py: (value) => low - (value - y.from) * ky,
    toX: (px) => x.from + (px - left) / kx,
    toY: (py) => y.from + (low - py) / ky,
  };
}

export function paint(pen, spec, frame) {
  const colours = theme();
  const { left, right, top, bottom, px, py } = frame;
  if (spec.image) image(pen, spec.image, frame);
  grid(pen, spec, frame, colours);
  pen.save();
  pen.beginPath();
  pen.rect(left - 1, top - 1, right - left + 2, bottom - top + 2);
  pen.clip();
  for (const item of spec.items) if (item.under) marks(pen, item, frame);
  for (const item of spec.items) if (item.type !== "points" && item.type !== "label") draw(pen, item, frame);
  pen.restore();
  for (const item of spec.items) {
    if (item.type === "points" && !item.under) {
      marks(pen, item, frame);
    } else if (item.type === "label") {
      pen.fillStyle = item.colour ?? colours.ink;
      pen.textAlign = item.align ?? "left";
      pen.fillText(tr(item.text), px(item.x) + (item.dx ?? 6), py(item.y) + (item.dy ?? -6));
    }
  }
}

function marks(pen, item, { left, right, top, bottom, px, py }) {
  for (let i = 0; i < item.x.length; i++) {
    const x = px(item.x[i]);
    const y = py(item.y[i]);
    if (x < left - 1 || x > right + 1 || y < top - 1 || y > bottom + 1 || Number.isNaN(y)) continue;
    mark(pen, item.shape, x, y, item.size ?? 6, item.colours?.[i] ?? item.colour);
  }
}

/** Cells about their values: the outermost reach half a cell beyond the plane. */
function image(pen, shown, { left, right, top, bottom }) {
  const [width, height] = [right - left, bottom - top];
  pen.imageSmoothingEnabled = shown.smooth;
  pen.save();
  pen.beginPath();
  pen.rect(left, top, width, height);
  pen.clip();
  pen.globalAlpha = shown.faded ? 0.4 : 1;
  pen.translate(left, top);
  const place = (into, cells) => {
    const [across, up] = [width / Math.max(cells.width - 1, 1), height / Math.max(cells.height - 1, 1)];
    into.translate(0, height);
    into.scale(1, -1);
    into.drawImage(cells, -across / 2, -up / 2, across * cells.width, up * cells.height);
  };
  for (const one of [shown.under, shown].filter(Boolean)) {
    pen.save();
    place(pen, one.canvas);
    pen.restore();
    if (!one.hatches?.length) continue;
    const layer = hatched(one, width, height, pen.getTransform().a, place);
    pen.drawImage(layer, 0, 0, width, height);
  }
  pen.restore();
}

function grid(pen, spec, frame, colours) {
  const { left, right, top, bottom, px, py, ticksX, ticksY } = frame;
  pen.lineWidth = 1;
  pen.strokeStyle = colours.line;
  pen.fillStyle = colours.muted;
  pen.font = FONT;
  pen.beginPath();
  if (!spec.image) {
    for (const [value] of ticksX) (pen.moveTo(half(px(value)), top), pen.lineTo(half(px(value)), bottom));
    for (const [value] of ticksY) (pen.moveTo(left, half(py(value))), pen.lineTo(right, half(py(value))));
  }
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
  pen.translate(left - Math.max(0, ...ticksY.map(([, text]) => pen.measureText(tr(text)).width)) - 18, (top + bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText(tr(spec.y.label), 0, 0);
  pen.restore();
  pen.textBaseline = "alphabetic";
}

const half = (value) => Math.round(value) + 0.5;

function stroke(pen, item) {
  pen.strokeStyle = item.colour ?? theme().muted;
  pen.lineWidth = item.width ?? 2;
  pen.lineJoin = "round";
  pen.setLineDash(item.dash ?? []);
}

function draw(pen, item, frame) {
  const { left, right, top, bottom, px, py } = frame;
  if (item.type === "band") {
    pen.globalAlpha = item.alpha ?? 0.25;
    pen.fillStyle = item.colour;
    pen.fillRect(left, py(item.to), right - left, py(item.from) - py(item.to));
    pen.globalAlpha = 1;
    return;
  }
  if (item.type === "patch") return;
  stroke(pen, item);
  pen.beginPath();
  if (item.type === "level") {
    if (item.axis === "x") (pen.moveTo(px(item.at), top), pen.lineTo(px(item.at), bottom));
    else (pen.moveTo(left, py(item.at)), pen.lineTo(right, py(item.at)));
  } else if (item.type === "circle") {
    pen.ellipse(px(0), py(0), px(item.radius) - px(0), py(0) - py(item.radius), 0, 0, 2 * Math.PI);
  } else {
    polyline(pen, item, px, py);
  }
  pen.stroke();
  pen.setLineDash([]);
}

/** A line with gaps where a value is null or not a number. */
function polyline(pen, { x, y }, px, py) {
  let up = true;
  for (let i = 0; i < x.length; i++) {
    const a = x[i];
    const b = y[i];
    if (a === null || b === null || Number.isNaN(a) || Number.isNaN(b)) up = true;
    else if (up) (pen.moveTo(px(a), py(b)), (up = false));
    else pen.lineTo(px(a), py(b));
  }
}

/** Shapes tell apart what colours tell apart: disc stable, ring unstable, cross not possible, diamond the design, square
 * a fold, triangle a flip, plus a corner. */
export function mark(pen, shape, x, y, size, colour) {
  const colours = theme();
  pen.setLineDash([]);
  pen.beginPath();
  if (shape === "cross" || shape === "plus") {
    const [far, near] = shape === "cross" ? [size, size] : [1.3 * size, 0];
    pen.strokeStyle = colour;
    pen.lineWidth = 2.4;
    (pen.moveTo(x - far, y - near), pen.lineTo(x + far, y + near));
    (pen.moveTo(x - near, y + far), pen.lineTo(x + near, y - far));
    pen.stroke();
    return;
  }
  if (shape === "diamond")
    (pen.moveTo(x, y - size * 1.4),
      pen.lineTo(x + size * 1.1, y),
      pen.lineTo(x, y + size * 1.4),
      pen.lineTo(x - size * 1.1, y),
      pen.closePath());
  else if (shape === "square") pen.rect(x - 0.9 * size, y - 0.9 * size, 1.8 * size, 1.8 * size);
  else if (shape === "triangle")
    (pen.moveTo(x, y - 1.2 * size),
      pen.lineTo(x + 1.1 * size, y + 0.8 * size),
      pen.lineTo(x - 1.1 * size, y + 0.8 * size),
      pen.closePath());
  else pen.arc(x, y, size, 0, 2 * Math.PI);
  pen.fillStyle = shape === "ring" ? colours.surface : colour;
  pen.fill();
  if (shape === "dot") return;
  pen.lineWidth = shape === "ring" ? 2.4 : 1.6;
  pen.strokeStyle = shape === "ring" ? colour : colours.surface;
  pen.stroke();
}
