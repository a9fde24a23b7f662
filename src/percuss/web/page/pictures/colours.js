// The colours of the present theme. What things and motions look like comes from the server's palette (/api/about), from
// which reports and pictures are drawn as well; surfaces and text are the style sheet's. What colour says is said by
// shape, hatch or text as well.

import { signal } from "../core/signals.js";

/** @typedef {{ light: string, dark: string }} Pair */
/** A family of motions: `colour` that of its cells, `line` that of its lines and dots.
 * @typedef {{ name: string, pattern: string, hatch: string, colour: string, line: string }} Family */
/** @typedef {{ kinds: Pair[], verdicts: Record<string, Pair>, strain: Pair[], stability: Pair[],
 *   families: (Pick<Family, "name" | "pattern" | "hatch"> & { colour: Pair })[], shares: string[], sign: string }} Palette */
/** The colours of ramps are 256 of r, g and b; `scale` is the size of the text over the usual one.
 * @typedef {Record<"ink" | "muted" | "line" | "surface" | "sunken" | "accent" | "good" | "bad" | "warn", string> &
 *   { kinds: string[], verdicts: Record<string, string>, families: Family[], strain: Uint8ClampedArray,
 *   stability: Uint8ClampedArray, shares: Uint8ClampedArray, sign: string, dark: boolean, scale: number }} Theme */

/** @type {Theme | null} */
let cache = null;
/** How often the theme has been another one: who draws with it draws anew. */
const changes = signal(0);
/** @type {Palette} */
let palette;
let onPaper = false;
const NAMES = ["ink", "muted", "line", "surface", "sunken", "accent", "good", "bad", "warn"];

/** The kinds that lines and dots of the families are drawn in: the hues of their cells, seen where they are thin. */
const LINES = [-1, 0, 5, 4, 3, 1];

/** Take the server's palette; before it nothing is drawn. @param {Palette} given */
export function usePalette(given) {
  palette = given;
  forgetTheme();
  given.kinds.forEach(({ light, dark }, i) =>
    document.documentElement.style.setProperty(`--kind-${i + 1}`, `light-dark(${light}, ${dark})`),
  );
}

/** The theme is another one. */
export function forgetTheme() {
  cache = null;
  changes.value = changes.peek() + 1;
}

/** Which theme it is, of all that there have been; 0 before the first. */
export const themeNow = () => changes.value;

/** What is drawn next is for paper, which is never dark, or for the screen again. @param {boolean} whether */
export function forPaper(whether) {
  onPaper = whether;
  forgetTheme();
}

/** The colours of the present theme and the size of its text, read once. @returns {Theme} */
export function theme() {
  if (themeNow() && cache) return cache;
  const style = getComputedStyle(document.documentElement);
  const chosen = document.documentElement.dataset.theme; // else as the system has it
  const dark = !onPaper && (chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
  const get = (/** @type {string} */ name) => {
    const text = style.getPropertyValue(`--${name}`).trim();
    const pair = /^light-dark\(\s*(#\w+)\s*,\s*(#\w+)\s*\)$/.exec(text);
    return pair ? pair[dark ? 2 : 1] : text;
  };
  const of = (/** @type {Pair} */ colour) => (dark ? colour.dark : colour.light);
  const kinds = palette.kinds.map(of);
  cache = {
    .../** @type {any} */ (Object.fromEntries(NAMES.map((name) => [name, get(name)]))),
    kinds,
    verdicts: Object.fromEntries(Object.entries(palette.verdicts).map(([name, colour]) => [name, of(colour)])),
    families: palette.families.map((family, i) => ({
      ...family,
      colour: of(family.colour),
      line: kinds[LINES[i]] ?? of(family.colour),
    })),
    strain: table(palette.strain.map(of)),
    stability: table(palette.stability.map(of)),
    shares: table(palette.shares),
    sign: palette.sign,
    dark,
    scale: Number.parseFloat(style.fontSize) / 16 || 1, // drawings grow with the text
  };
  return /** @type {Theme} */ (cache);
}

/** The family of a found motion, by its label: the first whose pattern fits, as the server has them. @param {string} label */
export const familyOf = (label) =>
  palette.families.findIndex(({ pattern }) => new RegExp(`^(?:${pattern})`).test(label));

/** Shares of ink in the shades that tell the labels of a family apart; its other labels have the last. */
const SHADES = [0, 0.3, 0.5, 0.65];

/** Looks of lines by the labels of motions: the hue tells the family, a shade of it the label. @param {string[]} labels */
export function looksOfLabels(labels) {
  const { families, ink } = theme();
  const many = families.map(() => 0);
  const lookOf = (/** @type {string} */ label) => {
    const family = familyOf(label);
    const shade = Math.min(many[family]++, SHADES.length - 1);
    const mixed = rgb(families[family].line).map((part, i) => Math.round(part + SHADES[shade] * (rgb(ink)[i] - part)));
    return { colour: `rgb(${mixed})`, name: shade < SHADES.length - 1 ? label : families[family].name };
  };
  return new Map(labels.map((label) => [label, lookOf(label)]));
}

/** 256 colours of a ramp between its stops. @param {string[]} stops */
function table(stops) {
  const found = new Uint8ClampedArray(256 * 3);
  const parts = stops.map(rgb);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (parts.length - 1);
    const j = Math.min(Math.floor(at), parts.length - 2);
    for (let c = 0; c < 3; c++) found[3 * i + c] = parts[j][c] + (at - j) * (parts[j + 1][c] - parts[j][c]);
  }
  return found;
}

/** [r, g, b] of a share 0 to 1 on a ramp of the theme. @param {ArrayLike<number>} values @param {number} share */
export function ramp(values, share) {
  const i = 3 * Math.round(255 * Math.min(1, Math.max(0, share)));
  return [values[i], values[i + 1], values[i + 2]];
}

/** The css colour of a signed share −1 to 1: blue (compression, negative) through grey to orange (tension).
 * @param {number} share */
export const signed = (share) => `rgb(${ramp(theme().strain, (share + 1) / 2).join()})`;

/** [r, g, b] of a css colour as #rrggbb. @param {string} colour */
export function rgb(colour) {
  const value = parseInt(colour.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}
