// The pen of a canvas, as many pixels as the screen has, in units that grow with the text of the page; and what stages draw
// with it.

import { h } from "../core/dom.js";
import { tr } from "../core/words.js";
import { signed, theme } from "./colours.js";

/** @typedef {CanvasRenderingContext2D} Pen */
/** Through points: x, y, x, y … @typedef {number[]} Line */

export const FONT = "12.5px system-ui, sans-serif";

/** A canvas of so many pixels, at `ratio` of them for each of its own units, and its pen.
 * @param {number} width @param {number} height @param {number} [ratio] @param {Record<string, any>} [attributes] */
export function ownCanvas(width, height, ratio = 1, attributes = {}) {
  const [wide, high] = [width, height].map((size) => Math.max(Math.round(size * ratio), 1));
  const canvas = h("canvas", { ...attributes, width: wide, height: high });
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  pen.scale(ratio, ratio);
  return { canvas, pen };
}

/** The pen of a cleared canvas of so many css pixels, with the width and the height in its units.
 * @param {HTMLCanvasElement} canvas @param {number[]} box @param {number} [most] pixels of the screen for one of css */
export function penOf(canvas, box, most = 2) {
  const ratio = Math.min(window.devicePixelRatio || 1, most);
  const [wide, high] = box.map((size) => Math.round(size * ratio));
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const pen = /** @type {Pen} */ (canvas.getContext("2d"));
  const { scale } = theme();
  const [width, height] = box.map((size) => size / scale);
  pen.setTransform(ratio * scale, 0, 0, ratio * scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

/** The path of some lines. @param {Pen} pen @param {Line[]} lines */
export function path(pen, lines) {
  pen.beginPath();
  for (const line of lines)
    for (let i = 0; i < line.length; i += 2)
      if (i) pen.lineTo(line[i], line[i + 1]);
      else pen.moveTo(line[i], line[i + 1]);
}

/** @param {Pen} pen @param {string} colour @param {number} width @param {Line[]} lines */
export function strokeLines(pen, colour, width, ...lines) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  path(pen, lines);
  pen.stroke();
}

/** An arrow along a row, and its head alone. @param {Pen} pen @param {string} colour @param {number} tail
 * @param {number} tip @param {number} y @param {number} [head] */
export function arrow(pen, colour, tail, tip, y, head = 8) {
  const back = tip > tail ? -head : head;
  strokeLines(pen, colour, 3, [tail, y, tip + 0.6 * back, y]);
  arrowHead(pen, colour, tip, y, back, 6);
}

/** @param {Pen} pen @param {string} colour @param {number} x @param {number} y @param {number} back @param {number} half */
export function arrowHead(pen, colour, x, y, back, half) {
  pen.fillStyle = colour;
  path(pen, [[x, y, x + back, y - half, x + back, y + half]]);
  pen.fill();
}

/** The scale of strain or stress: its colours between its ends in words. @param {Pen} pen @param {[string, string]} ends
 * @param {number} x @param {number} y @param {number} bar how long it is */
export function signedScale(pen, [from, to], x, y, bar) {
  const left = x + pen.measureText(tr(from)).width + 8;
  pen.textAlign = "left";
  pen.fillStyle = theme().muted;
  pen.fillText(tr(from), x, y + 10);
  pen.fillText(tr(to), left + bar + 8, y + 10);
  for (let i = 0; i < bar; i++) {
    pen.fillStyle = signed((2 * i) / bar - 1);
    pen.fillRect(left + i, y, 1.5, 10);
  }
}
