// The image of a map: verdicts and families of motions as flat colours, sizes and margins as ramps.

import { span } from "../pictures/chart.js";
import { ownCanvas } from "../pictures/pen.js";
import { familyOf, ramp, rgb, theme } from "../pictures/colours.js";
import { number, si, withUnit } from "../core/format.js";

/** What the server has told of a map so far, from below: rows of cells; `cost` is what one takes in milliseconds.
 * @typedef {{ nx: number, ny: number, rows: number, cost: number, arrays: Record<string, any>,
 *   quantities: Record<string, any> }} Level */
/** @typedef {ReturnType<typeof theme>} Theme */
/** How the cells of a code look, and what they are called.
 * @typedef {{ name: string, colour: string, hatch: string }} Look */
/** What each cell shows: a code for verdicts and words, a value for the rest; `words` is what stands in each cell.
 * @typedef {{ kind: string, codes?: any, words?: string[], labels?: any, values?: any, low: number, high: number,
 *   unit: string }} Content */
/** A map: its axes, its cells, and the image of them; `under` is a coarser one that is seen where rows are to come.
 * @typedef {Content & { x: import("./map_axes.js").Axis, y: import("./map_axes.js").Axis, nx: number, ny: number,
 *   rows: number, version: number, under: Plane | null, canvas: HTMLCanvasElement | null, colours: Theme | null, looks: Look[],
 *   used: Set<number>, hatches: { hatch: string, canvas: HTMLCanvasElement }[] }} Plane */

/** @type {Record<string, string>} */
const VERDICTS = { none: "no steady motion", unstable: "steady motion, unstable", stable: "stable steady motion" };

/** What the cells of an answer show. Of rows over a coarser map of the whole plane, `under`, the range is that of both.
 * @param {Level} level @param {import("./map_axes.js").Shown} kind @param {Plane | null} under @returns {Content} */
export function content({ arrays, quantities }, kind, under) {
  const [first, second] = kind.quantities;
  const values = arrays[first];
  if (second) {
    const code = (/** @type {number} */ n, /** @type {number} */ i) =>
      n > 0 ? (arrays[second][i] === 1 ? 2 : 1) : n >= 0 ? 0 : -1;
    const codes = values.map(code);
    return { ...CODED, kind: "verdicts", codes, words: Object.values(VERDICTS), labels: codes };
  }
  /** @type {string[] | undefined} */
  const words = quantities[first].words;
  if (first === "stall") return { ...CODED, kind: "outcomes", codes: values, words, labels: values };
  if (words) {
    const family = words.map(familyOf); // once a word: a map has many cells and few words
    const codes = values.map((/** @type {number} */ n) => family[n] ?? -1);
    return { ...CODED, kind: "families", codes, words, labels: values };
  }
  const margin = first.includes("margin");
  const [low, high] = span([values, under?.values ?? []], 0);
  const ends = margin ? { low: Math.min(Math.max(low, -1), 0), high: Math.max(high, 0) } : { low, high };
  return { kind: margin ? "margins" : "sizes", values, ...ends, unit: quantities[first].unit ?? "" };
}

const CODED = { low: 0, high: 0, unit: "" };

/** What stands in the cell at a point of the plane, in words; "" beside the plane and where nothing is known yet.
 * @param {Plane} plane @param {{ x: number, y: number }} at */
export function cellAt(plane, { x, y }) {
  const i = Math.round(((x - plane.x.from) / (plane.x.to - plane.x.from)) * (plane.nx - 1));
  const j = Math.round(((y - plane.y.from) / (plane.y.to - plane.y.from)) * (plane.ny - 1));
  if (!(i >= 0 && i < plane.nx && j >= 0 && j < plane.rows)) return "";
  const cell = j * plane.nx + i;
  if (plane.words) return plane.words[plane.labels[cell]] ?? "no value";
  return Number.isFinite(plane.values[cell]) ? sized(plane.values[cell], plane.unit) : "none";
}

/** A value as the legend and the pointer tell it: a stress with its prefix.
 * @param {number} value @param {string} unit @param {number} [digits] */
const sized = (value, unit, digits) => (unit === "Pa" ? si : withUnit)(value, unit, digits);

/** A pixel. @param {number[]} rgb */
const pixel = ([red, green, blue]) => ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;

/** Where a value stands on its ramp, 0 to 1; a margin has its border in the middle, whatever its ends.
 * @param {Content} content @param {number} value */
function shareOf({ kind, low, high }, value) {
  if (kind !== "margins") return (value - low) / (high - low || 1);
  return value < 0 ? 0.5 - 0.5 * Math.min(value / (low || -1), 1) : 0.5 + (0.5 * value) / (high || 1);
}

/** @param {Content} content @param {Theme} colours */
const rampOf = ({ kind }, colours) => (kind === "margins" ? colours.stability : colours.shares);

/** The image of a map, one pixel a cell, the first row at the bottom of the plane; rows to come are left clear.
 * @param {Plane} plane */
export function picture(plane) {
  const { nx, ny, rows, codes, values } = plane;
  const colours = (plane.colours = theme());
  plane.looks = looksOf(plane, colours);
  const flat = plane.looks.map(({ colour }) => pixel(rgb(colour)));
  const shades = Uint32Array.from({ length: 256 }, (_, i) => pixel(ramp(rampOf(plane, colours), i / 255)));
  const none = pixel(rgb(colours.verdicts.none));
  const shade = (/** @type {number} */ i) => {
    if (codes) return codes[i] >= 0 ? flat[codes[i]] : none;
    if (!Number.isFinite(values[i])) return none;
    return shades[Math.min(Math.max(255 * shareOf(plane, values[i]), 0), 255) | 0];
  };
  plane.canvas = cells(nx, ny, rows, shade);
  plane.used = new Set([...new Set(codes), ...(plane.under?.used ?? [])]); // once for a plane: a move redraws it
  plane.hatches = [];
  for (const [i, { hatch }] of plane.looks.entries())
    if (hatch && plane.used.has(i))
      plane.hatches.push({ hatch, canvas: cells(nx, ny, rows, (k) => (codes[k] === i ? 0xffffffff : 0)) });
}

/** What the cells of each code look like and are called; of a machine that does not run by what keeps it from that.
 * @param {Content} content @param {Theme} colours @returns {Look[]} */
function looksOf({ kind, words = [] }, { families, verdicts }) {
  if (kind === "families") return families;
  if (kind !== "outcomes")
    return Object.entries(VERDICTS).map(([verdict, name]) => ({ name, colour: verdicts[verdict], hatch: "" }));
  const n = families.length; // more words than colours: the hatches are others the second time
  const look = (/** @type {number} */ i) => ({
    colour: families[i % n].colour,
    hatch: families[(i + Math.floor(i / n)) % n].hatch,
  });
  return words.map((name, i) => ({ name, ...(i ? look(i) : { colour: verdicts.stable, hatch: "" }) }));
}

/** A canvas with a pixel for each of the first rows of cells.
 * @param {number} nx @param {number} ny @param {number} rows @param {(cell: number) => number} shade */
function cells(nx, ny, rows, shade) {
  const { canvas, pen } = ownCanvas(nx, ny);
  const image = pen.createImageData(nx, ny);
  const pixels = new Uint32Array(image.data.buffer);
  for (let i = 0; i < nx * rows; i++) pixels[i] = shade(i);
  pen.putImageData(image, 0, 0);
  return canvas;
}

/** What its colours mean. @param {Plane | null} plane @param {Theme} colours @returns {any[]} */
export function legends(plane, colours) {
  if (!plane?.canvas) return [];
  if (plane.codes)
    return plane.looks
      .map(({ name, colour, hatch }, i) => ({ type: "patch", name, colour, hatch, i }))
      .filter(({ i }) => plane.used.has(i));
  const step = (plane.high - plane.low) / 200 || 1;
  const rounded = (/** @type {number} */ value) => Math.round(value / step) * step;
  const patch = (/** @type {number} */ share) =>
    `#${ramp(rampOf(plane, colours), share)
      .map((/** @type {number} */ v) => v.toString(16).padStart(2, "0"))
      .join("")}`;
  const at = (/** @type {number} */ share) => {
    if (plane.kind !== "margins") return plane.low + share * (plane.high - plane.low);
    return share < 0.5 ? plane.low * (1 - 2 * share) : plane.high * (2 * share - 1);
  };
  const steps = [0, 0.25, 0.5, 0.75, 1].map((share) => ({
    type: "patch",
    name:
      plane.kind === "margins" && share === 0.5
        ? `${number(0)}: the border of stability`
        : sized(rounded(at(share)), plane.unit, 3),
    colour: patch(share),
  }));
  return [...steps, { type: "patch", name: "none", colour: colours.verdicts.none }];
}
