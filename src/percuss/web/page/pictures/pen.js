// @ts-check
// The pen of a canvas: as many pixels as the screen has, in units that grow with the text of the page.

import { theme } from "./colours.js";

/** The pen of a cleared canvas of so many css pixels, with the width and the height in its units.
 * @param {HTMLCanvasElement} canvas @param {number[]} box @param {number} [most] pixels of the screen for one of css */
export function penOf(canvas, box, most = 2) {
  const ratio = Math.min(window.devicePixelRatio || 1, most);
  const [wide, high] = box.map((size) => Math.round(size * ratio));
  if (canvas.width !== wide || canvas.height !== high) Object.assign(canvas, { width: wide, height: high });
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  const { scale } = theme();
  const [width, height] = box.map((size) => size / scale);
  pen.setTransform(ratio * scale, 0, 0, ratio * scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}
