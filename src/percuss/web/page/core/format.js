// How numbers are written: enough digits to work with, a thin space before the unit, a real minus sign.

const THIN = "\u202f";

/** A number with so many significant digits; null and what is not finite as a dash. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(Number(value.toPrecision(digits)));
  if (size >= 1e6 || size < 1e-4) {
    const [head, power] = value.toExponential(Math.max(digits - 2, 1)).split("e");
    return minus(`${head}·10${superscript(Number(power))}`);
  }
  const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  let text = Number(value.toPrecision(digits)).toFixed(Math.min(places, 10));
  if (text.includes(".")) text = text.replace(/\.?0+$/, "");
  return minus(text);
}

const minus = (text) => text.replace(/^-/, "−");

function superscript(power) {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return [...String(power)].map((c) => (c === "-" ? "⁻" : digits[Number(c)])).join("");
}

export const withUnit = (value, unit, digits = 4) => `${number(value, digits)}${unit ? THIN + unit : ""}`;

/** A quantity before its unit, as on every axis: "stress [MPa]". */
export const inUnit = (name, unit) => (unit ? `${name} [${unit}]` : name);

const LADDER = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
  [1e-9, "n"],
];

/** The factor and the unit with prefix in which a number of this size reads best. */
export function scaleOf(size, unit) {
  const magnitude = Math.abs(size);
  if (!magnitude || !Number.isFinite(magnitude)) return { factor: 1, unit };
  const [factor, prefix] = LADDER.find(([limit]) => magnitude >= limit * 0.9999) ?? LADDER.at(-1);
  return { factor: 1 / factor, unit: prefix + unit };
}

/** A quantity in SI with a prefix that suits it: 5700 J → 5.7 kJ. */
export function si(value, unit, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const scale = scaleOf(value, unit);
  return withUnit(value * scale.factor, scale.unit, digits);
}

/** "1 start", "2 starts". */
export const counted = (count, word) => {
  const text = Number.isInteger(count) ? String(count) : number(count, 4);
  return `${text} ${word}${text === "1" ? "" : "s"}`;
};

/** An angle in radians and degrees. */
export const angle = (phase) => `${number(phase)}${THIN}rad (${number((phase * 180) / Math.PI)}°)`;

export const percent = (share, digits = 3) => withUnit(share * 100, "%", digits);

/** "341 mm" → {value: 341, unit: "mm"}; a plain number has the unit "". */
export function quantity(text) {
  if (typeof text === "number") return { value: text, unit: "" };
  const found = /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$/.exec(String(text ?? ""));
  return found ? { value: Number(found[1]), unit: found[2] } : null;
}

/** A number as it is written into a case: short, exact enough for a slider, never in words. */
export function plainNumber(value, digits = 4) {
  return Number(value.toPrecision(digits));
}
