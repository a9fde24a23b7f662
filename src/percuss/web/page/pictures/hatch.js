// Hatches: what tells areas apart without their colours. The names are those of the server's palette.

import { ownCanvas, path } from "./pen.js";

const TILE = 8; // css pixels
const LINE = "rgb(255 255 255 / 85%)";

const RISING = [[-2, 10, 10, -2], [-2, 2, 2, -2], [6, 10, 10, 6]]; // prettier-ignore
const FALLING = [[-2, -2, 10, 10], [6, -2, 10, 2], [-2, 6, 2, 10]]; // prettier-ignore
/** @type {Record<string, number[][]>} */
const STROKES = { "/": RISING, "\\": FALLING, x: [...RISING, ...FALLING], "-": [[0, 4, 8, 4]], ".": [] };

/** @type {Map<string, HTMLCanvasElement>} */
const tiles = new Map();

/** A tile of a hatch at so many pixels a css pixel. @param {string} hatch @param {number} ratio */
function tile(hatch, ratio) {
  const key = `${hatch} ${ratio}`;
  const kept = tiles.get(key);
  if (kept) return kept;
  const { canvas, pen } = ownCanvas(TILE, TILE, Math.max(Math.round(TILE * ratio), TILE / 2) / TILE); // whole pixels
  pen.strokeStyle = pen.fillStyle = LINE;
  path(pen, STROKES[hatch] ?? []);
  pen.stroke();
  if (hatch === ".") {
    pen.arc(TILE / 2, TILE / 2, 1.1, 0, 2 * Math.PI);
    pen.fill();
  }
  tiles.set(key, canvas);
  return canvas;
}

/** Fill a rectangle of a pen, whose unit is a css pixel, with a hatch.
 * @param {any} pen @param {string | undefined} hatch @param {number} x @param {number} y @param {number} width
 * @param {number} height */
export function fillHatch(pen, hatch, x, y, width, height, ratio = 1) {
  if (!hatch) return;
  const made = tile(hatch, ratio);
  const pattern = pen.createPattern(made, "repeat");
  pattern.setTransform(new DOMMatrix().scale(TILE / made.width));
  pen.fillStyle = pattern;
  pen.fillRect(x, y, width, height);
}

/** @type {WeakMap<HTMLCanvasElement, { key: string, canvas: HTMLCanvasElement }>} */
const layers = new WeakMap();

/** The hatches of an image of cells, `width` by `height` css pixels large; made anew only when that is another size.
 * @param {{ canvas: HTMLCanvasElement, hatches: { hatch: string, canvas: HTMLCanvasElement }[] }} image
 * @param {number} width @param {number} height @param {number} ratio
 * @param {(pen: any, cells: HTMLCanvasElement) => void} place draws cells where they belong */
export function hatched(image, width, height, ratio, place) {
  const key = [width, height, ratio].join();
  const kept = layers.get(image.canvas);
  if (kept?.key === key) return kept.canvas;
  const layer = ownCanvas(width, height, ratio);
  layer.pen.resetTransform();
  for (const { hatch, canvas } of image.hatches) {
    const one = ownCanvas(width, height, ratio);
    one.pen.imageSmoothingEnabled = false;
    place(one.pen, canvas);
    one.pen.globalCompositeOperation = "source-in";
    fillHatch(one.pen, hatch, 0, 0, width, height, ratio);
    layer.pen.drawImage(one.canvas, 0, 0);
  }
  layers.set(image.canvas, { key, canvas: layer.canvas });
  return layer.canvas;
}
