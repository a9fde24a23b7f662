// Colours that people with any colour vision can tell apart: Okabe and Ito's set for kinds, a cividis-like ramp for
// sizes, a blue–grey–orange ramp for signed values. What colour says is said by shape or text as well.

let cache = null;
const NAMES = [
  "ink",
  "muted",
  "line",
  "surface",
  "sunken",
  "accent",
  "good",
  "bad",
  "warn",
  "map-none",
  "map-unstable",
  "map-stable",
];

/** Whether the page is dark: as the switch says, else as the system has it. */
export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

/** The colours of the present theme and the size of its text, read from the style sheet once. */
export function theme() {
  if (cache) return cache;
  const style = getComputedStyle(document.documentElement);
  const dark = isDark();
  const get = (name) => {
    const text = style.getPropertyValue(`--${name}`).trim();
    const pair = /^light-dark\(\s*(#\w+)\s*,\s*(#\w+)\s*\)$/.exec(text);
    return pair ? pair[dark ? 2 : 1] : text;
  };
  cache = Object.fromEntries(NAMES.map((name) => [name, get(name)]));
  cache.kinds = [1, 2, 3, 4, 5, 6].map((i) => get(`kind-${i}`));
  cache.dark = dark;
  cache.scale = Number.parseFloat(style.fontSize) / 16 || 1; // drawings grow with the text
  return cache;
}

export function forgetTheme() {
  cache = null;
}

const CIVIDIS = [
  [0, 34, 78],
  [18, 53, 112],
  [59, 73, 108],
  [87, 93, 109],
  [112, 113, 115],
  [138, 134, 120],
  [165, 156, 116],
  [195, 179, 105],
  [225, 204, 85],
  [254, 232, 56],
];

const SIGNED_LIGHT = [
  [5, 48, 97],
  [33, 102, 172],
  [67, 147, 195],
  [146, 197, 222],
  [222, 226, 230],
  [253, 190, 120],
  [230, 126, 34],
  [185, 84, 10],
  [112, 46, 0],
];
const SIGNED_DARK = [
  [120, 190, 255],
  [72, 150, 225],
  [45, 110, 180],
  [40, 78, 122],
  [66, 74, 84],
  [122, 78, 36],
  [184, 104, 30],
  [236, 138, 40],
  [255, 190, 110],
];

function table(stops) {
  const found = new Uint8ClampedArray(256 * 3);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (stops.length - 1);
    const j = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c++) found[3 * i + c] = stops[j][c] + (at - j) * (stops[j + 1][c] - stops[j][c]);
  }
  return found;
}

const RAMP = table(CIVIDIS);
const LIGHT = table(SIGNED_LIGHT);
const DARK = table(SIGNED_DARK);

const place = (share) => 3 * Math.round(255 * Math.min(1, Math.max(0, share)));

/** [r, g, b] of a share 0 to 1, dark blue to yellow. */
export function ramp(share) {
  const i = place(share);
  return [RAMP[i], RAMP[i + 1], RAMP[i + 2]];
}

/** The css colour of a signed share −1 to 1: blue (compression) through grey to orange (tension). */
export function signed(share) {
  const values = theme().dark ? DARK : LIGHT;
  const i = place((share + 1) / 2);
  return `rgb(${values[i]},${values[i + 1]},${values[i + 2]})`;
}

/** [r, g, b] of a css colour as #rrggbb. */
export function rgb(colour) {
  const value = parseInt(colour.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}
