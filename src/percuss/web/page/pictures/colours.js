// The colours of the present theme. What things and motions look like comes from the server's palette (/api/about), from
// which reports and pictures are drawn as well; surfaces and text are the style sheet's. What colour says is said by
// shape, hatch or text as well.

let cache = null;
let palette = null;
let onPaper = false;
const NAMES = ["ink", "muted", "line", "surface", "sunken", "accent", "good", "bad", "warn"];

/** The kinds that lines and dots of the families are drawn in: the hues of their cells, seen where they are thin. */
const LINES = [null, 0, 5, 4, 3, 1];

/** Take the server's palette; before it nothing is drawn. */
export function usePalette(given) {
  palette = given;
  cache = null;
  given.kinds.forEach(({ light, dark }, i) =>
    document.documentElement.style.setProperty(`--kind-${i + 1}`, `light-dark(${light}, ${dark})`),
  );
}

/** Whether the page is dark: as the switch says, else as the system has it; paper is never. */
export function isDark() {
  if (onPaper) return false;
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

/** Whether what is drawn next is for paper. */
export function forPaper(whether) {
  onPaper = whether;
  cache = null;
}

/** The colours of the present theme and the size of its text, read once. */
export function theme() {
  if (cache) return cache;
  const style = getComputedStyle(document.documentElement);
  const dark = isDark();
  const get = (name) => {
    const text = style.getPropertyValue(`--${name}`).trim();
    const pair = /^light-dark\(\s*(#\w+)\s*,\s*(#\w+)\s*\)$/.exec(text);
    return pair ? pair[dark ? 2 : 1] : text;
  };
  const of = (colour) => (dark ? colour.dark : colour.light);
  cache = Object.fromEntries(NAMES.map((name) => [name, get(name)]));
  cache.kinds = palette.kinds.map(of);
  cache.verdicts = Object.fromEntries(Object.entries(palette.verdicts).map(([name, colour]) => [name, of(colour)]));
  cache.families = palette.families.map((family, i) => ({
    ...family,
    colour: of(family.colour),
    line: cache.kinds[LINES[i]] ?? of(family.colour),
  }));
  cache.strain = table(palette.strain.map(of));
  cache.stability = table(palette.stability.map(of));
  cache.shares = table(palette.shares);
  cache.sign = palette.sign;
  cache.dark = dark;
  cache.scale = Number.parseFloat(style.fontSize) / 16 || 1; // drawings grow with the text
  return cache;
}

export function forgetTheme() {
  cache = null;
}

/** The family of a found motion, by its label: the first whose pattern fits, as the server has them. */
export function familyOf(label) {
  return palette.families.findIndex(({ pattern }) => new RegExp(`^(?:${pattern})`).test(label));
}

/** Shares of ink in the shades that tell the labels of a family apart; its other labels have the last. */
const SHADES = [0, 0.3, 0.5, 0.65];

/** Looks of lines by the labels of motions, {colour, name}: the hue tells the family, a shade of it the label. */
export function looksOfLabels(labels) {
  const { families, ink } = theme();
  const many = families.map(() => 0);
  const lookOf = (label) => {
    const family = familyOf(label);
    const shade = Math.min(many[family]++, SHADES.length - 1);
    const mixed = rgb(families[family].line).map((part, i) => Math.round(part + SHADES[shade] * (rgb(ink)[i] - part)));
    return { colour: `rgb(${mixed})`, name: shade < SHADES.length - 1 ? label : families[family].name };
  };
  return new Map(labels.map((label) => [label, lookOf(label)]));
}

/** 256 colours of a ramp between its stops. */
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

/** [r, g, b] of a share 0 to 1 on a ramp of the theme. */
export function ramp(values, share) {
  const i = 3 * Math.round(255 * Math.min(1, Math.max(0, share)));
  return [values[i], values[i + 1], values[i + 2]];
}

/** The css colour of a signed share −1 to 1: blue (compression, negative) through grey to orange (tension). */
export const signed = (share) => `rgb(${ramp(theme().strain, (share + 1) / 2).join()})`;

/** [r, g, b] of a css colour as #rrggbb. */
export function rgb(colour) {
  const value = parseInt(colour.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}
