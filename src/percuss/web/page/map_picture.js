// The image of a map: verdicts and words as flat colours, sizes as a ramp.

import { span } from "./chart.js";
import { ramp, rgb, theme } from "./colours.js";
import { withUnit } from "./format.js";

const VERDICTS = ["no steady motion", "steady motion, unstable", "stable steady motion"];

/** One number a cell: a code for verdicts and words, a value for the rest. */
export function content({ arrays, quantities }, kind) {
  const [first, second] = kind.quantities;
  if (second)
    return { codes: arrays[first].map((n, i) => (n > 0 ? (arrays[second][i] === 1 ? 2 : 1) : 0)), words: VERDICTS };
  if (quantities[first].words) return { codes: arrays[first], words: quantities[first].words, many: true };
  const values = arrays[first];
  const [low, high] = span([values], 0);
  return { values, low: first.includes("margin") ? Math.max(low, -1) : low, high, unit: quantities[first].unit ?? "" };
}

const word = ([red, green, blue]) => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
const RAMP = Uint32Array.from({ length: 256 }, (_, i) => word(ramp(i / 255)));

/** The image of a map, one pixel a cell, the first row at the bottom of the plane; rows to come are left clear. */
export function picture(plane) {
  const { nx, ny, rows, codes, values, low, high } = plane;
  const canvas = document.createElement("canvas");
  canvas.width = nx;
  canvas.height = ny;
  const pen = canvas.getContext("2d");
  const image = pen.createImageData(nx, ny);
  const pixels = new Uint32Array(image.data.buffer);
  const colours = theme();
  plane.palette = plane.many
    ? [...colours.kinds, ...colours.kinds]
    : [colours["map-none"], colours["map-unstable"], colours["map-stable"]];
  const palette = plane.palette.map((colour) => word(rgb(colour)));
  const none = word(rgb(colours["map-none"]));
  const scale = 255 / (high - low || 1);
  for (let i = 0; i < nx * rows; i++) {
    if (codes) pixels[i] = codes[i] >= 0 ? palette[codes[i] % palette.length] : none;
    else if (Number.isFinite(values[i])) pixels[i] = RAMP[Math.min(Math.max((values[i] - low) * scale, 0), 255) | 0];
    else pixels[i] = none;
  }
  pen.putImageData(image, 0, 0);
  plane.canvas = canvas;
}

/** What its colours mean. */
export function legends(plane, colours) {
  if (!plane?.canvas) return [];
  if (plane.codes) {
    plane.used ??= new Set(plane.codes); // once for a plane: there are tens of thousands of them, and a move redraws
    return plane.words
      .map((name, i) => ({ type: "patch", name, colour: plane.palette[i % plane.palette.length], i }))
      .filter(({ i }) => plane.used.has(i));
  }
  const step = (plane.high - plane.low) / 200 || 1;
  const rounded = (value) => Math.round(value / step) * step;
  const patch = (share) =>
    `#${ramp(share)
      .map((v) => v.toString(16).padStart(2, "0"))
      .join("")}`;
  const steps = [0, 0.25, 0.5, 0.75, 1].map((share) => ({
    type: "patch",
    name: withUnit(rounded(plane.low + share * (plane.high - plane.low)), plane.unit, 3),
    colour: patch(share),
  }));
  return [...steps, { type: "patch", name: "none", colour: colours["map-none"] }];
}
