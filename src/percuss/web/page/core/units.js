// Quantities as people read and type them: any unit of the right kind, three systems of units to show them in, and how
// numbers look. What the package itself takes for a unit stands in units.py; the factors are the same.

/** @typedef {"SI" | "practical" | "US"} System */
/** @typedef {{ error: string, remedy: string, value?: undefined }} Refused */
/** @typedef {{ value: number, unit: string, error?: undefined, remedy?: undefined }} Quantity */

// ---- Units: a factor, and the powers of metre, kilogram, second and radian

/** @typedef {{ factor: number, powers: number[] }} Size */

/** Units by others. Cycles, blows and turns are plain numbers, so that a frequency counts them: 60 rpm is 1 Hz.
 * @type {Record<string, [number, string]>} */
const DEFINED = {
  N: [1, "kg*m/s^2"],
  Pa: [1, "N/m^2"],
  J: [1, "N*m"],
  W: [1, "J/s"],
  Hz: [1, "1/s"],
  l: [1, "dm^3"],
  L: [1, "dm^3"],
  t: [1e3, "kg"],
  bar: [1e5, "Pa"],
  atm: [101325, "Pa"],
  sec: [1, "s"],
  min: [60, "s"],
  h: [3600, "s"],
  kgf: [9.80665, "N"],
  in: [0.0254, "m"],
  inch: [1, "in"],
  '"': [1, "in"],
  ft: [0.3048, "m"],
  lb: [0.45359237, "kg"],
  lbs: [1, "lb"],
  lbf: [4.4482216152605, "N"],
  kip: [1e3, "lbf"],
  psi: [1, "lbf/in^2"],
  ksi: [1e3, "psi"],
  "ft*lb": [1, "ft*lbf"], // nobody means a mass by it
  "ft*lbs": [1, "ft*lbf"],
  hp: [550, "ft*lbf/s"],
  gal: [231, "in^3"],
  gpm: [1, "gal/min"],
  rpm: [1, "1/min"],
  bpm: [1, "1/min"],
  "rad/s": [0.5 / Math.PI, "Hz"],
  "°": [Math.PI / 180, "rad"],
  deg: [1, "°"],
  "%": [1e-2, "1"],
  "‰": [1e-3, "1"],
  strain: [1, "1"],
  ε: [1, "1"],
  microstrain: [1e-6, "1"],
  blow: [1, "1"],
  blows: [1, "1"],
  rev: [1, "1"],
};

/** @type {Record<string, Size>} */
const BASE = {
  1: { factor: 1, powers: [0, 0, 0, 0] },
  m: { factor: 1, powers: [1, 0, 0, 0] },
  g: { factor: 1e-3, powers: [0, 1, 0, 0] },
  s: { factor: 1, powers: [0, 0, 1, 0] },
  rad: { factor: 1, powers: [0, 0, 0, 1] },
};

const PREFIXED = new Set(["m", "g", "s", "N", "Pa", "J", "W", "Hz", "l", "L", "bar", "rad", "ε", "strain"]);
/** @type {Record<string, number>} */
const PREFIXES = { G: 1e9, M: 1e6, k: 1e3, h: 1e2, da: 10, d: 0.1, c: 1e-2, m: 1e-3, u: 1e-6, n: 1e-9 };

/** One spelling: µ is u, powers are ^n, products are *, no blanks; that of units.py.
 * @param {string} unit */
function tidy(unit) {
  return unit
    .trim()
    .replace(/[µμ]/g, "u")
    .replace(
      /[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+/g,
      (power) => `^${[...power].map((c) => (c === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c))).join("")}`,
    )
    .replace("**", "^")
    .replace("″", '"')
    .replace(/\s*([*/^·⋅×])\s*/g, "$1")
    .replace(/(?<=[A-Za-z])[.-](?=[A-Za-z])/g, "*")
    .replace(/[·⋅×\s]+/g, "*")
    .replace(/([A-Za-z])(-?\d)/g, "$1^$2");
}

/** @type {Map<string, Size | null>} */
const sizes = new Map();

/** What a unit is of; null for one that is not known. @param {string} unit @returns {Size | null} */
function sizeOf(unit) {
  const kept = sizes.get(unit);
  if (kept !== undefined) return kept;
  const name = tidy(unit) || "1";
  const tokens =
    Object.hasOwn(DEFINED, name) || Object.hasOwn(BASE, name)
      ? [name]
      : (name.match(/\^-?\d+|[*/()]|[^*/()^]+/g) ?? []);
  const found = tokens.join("") === name ? product(tokens) : null;
  if (sizes.size < 1000) sizes.set(unit, found);
  return found;
}

/** @param {string} name @returns {Size | null} */
function atom(name) {
  if (Object.hasOwn(BASE, name)) return BASE[name];
  if (Object.hasOwn(DEFINED, name)) {
    const [factor, other] = DEFINED[name];
    return times({ factor, powers: [0, 0, 0, 0] }, sizeOf(other), 1);
  }
  const prefix = Object.keys(PREFIXES).find((one) => name.startsWith(one) && PREFIXED.has(name.slice(one.length)));
  if (!prefix) return null;
  return times({ factor: PREFIXES[prefix], powers: [0, 0, 0, 0] }, atom(name.slice(prefix.length)), 1);
}

/** @param {Size | null} a @param {Size | null} b @param {number} power @returns {Size | null} */
const times = (a, b, power) =>
  a && b && { factor: a.factor * b.factor ** power, powers: a.powers.map((one, i) => one + power * b.powers[i]) };

/** The product that begins a list of tokens, up to a bracket that it does not open; the tokens are used up.
 * @param {string[]} tokens @param {number} depth @returns {Size | null} */
function product(tokens, depth = 0) {
  /** @type {Size | null} */
  let found = BASE[1];
  for (let sign = 1; found;) {
    const token = tokens.shift() ?? "";
    const one = token === "(" ? product(tokens, depth + 1) : /^[*/)^]?$/.test(token[0] ?? "") ? null : atom(token);
    const power = tokens[0]?.startsWith("^") ? Number(tokens.shift()?.slice(1)) : 1;
    found = times(found, one, sign * power);
    const next = tokens.shift();
    if (next === undefined || next === ")") return (next === ")") === depth > 0 ? found : null;
    if (next !== "*" && next !== "/") return null;
    sign = next === "/" ? -1 : 1;
  }
  return null;
}

/** A number in another unit of the same kind; NaN where it is of another. @param {number} value @param {string} from
 * @param {string} to */
export function converted(value, from, to) {
  if (from === to) return value;
  const [a, b] = [sizeOf(from), sizeOf(to)];
  if (!a || !b || String(a.powers) !== String(b.powers)) return Number.NaN;
  return Number(((value * a.factor) / b.factor).toPrecision(15)); // 341 mm are 0.341 m, not 0.34100000000000003
}

/** As a unit is printed: N·s/m², µm, °. @param {string} unit */
export function printed(unit) {
  return tidy(unit)
    .replace(/\^(-?\d+)/g, (_, power) => superscript(power))
    .replaceAll("*", "·")
    .replace(/\bu(?=\p{L})/gu, "µ")
    .replace(/^deg$/, "°");
}

// ---- Kinds of quantities

/** @typedef {{ words: string, units: string, example: number, SI: string, practical: string, US: string }} Kind */

/** Each kind in words, the units it is usually written in, an example in SI, and the unit of each system. Of kinds with
 * one dimension, that which lists a unit has it: a pressure is in bar, a stress in MPa.
 * @type {Record<string, Kind>} */
export const KINDS = {
  length: kind("a length", "m mm cm dm km um in inch ft", 0.32, "m", "mm", "in"),
  area: kind("an area", "m^2 mm^2 cm^2 dm^2 in^2 ft^2", 6.5e-4, "m^2", "cm^2", "in^2"),
  volume: kind("a volume", "m^3 l L dm^3 cm^3 mm^3 ml in^3 ft^3 gal", 4e-4, "m^3", "l", "in^3"),
  mass: kind("a mass", "kg g t lb", 5, "kg", "kg", "lb"),
  density: kind("a density", "kg/m^3 g/cm^3 kg/dm^3 kg/l t/m^3 lb/in^3 lb/ft^3", 7850, "kg/m^3", "kg/m^3", "lb/in^3"),
  force: kind("a force", "N mN daN kN MN lbf kgf kip", 2500, "N", "kN", "lbf"),
  pressure: kind("a pressure", "Pa hPa kPa bar mbar atm psi kgf/cm^2 N/m^2", 1.6e7, "Pa", "bar", "psi"),
  stress: kind("a stress", "MPa N/mm^2 ksi", 2e8, "Pa", "MPa", "ksi"),
  modulus: kind("a modulus", "GPa kN/mm^2", 2.1e11, "Pa", "GPa", "ksi"),
  velocity: kind("a speed", "m/s mm/s cm/s m/min km/h ft/s ft/min in/s", 10, "m/s", "m/s", "ft/s"),
  frequency: kind("a frequency", "Hz mHz kHz MHz 1/s s^-1 rad/s rev/min rpm", 40, "Hz", "Hz", "Hz"),
  "blow rate": kind("a frequency", "blows/min 1/min min^-1 bpm", 40, "Hz", "blows/min", "blows/min"),
  time: kind("a time", "s ms us ns sec min h", 0.02, "s", "ms", "ms"),
  flow: kind(
    "a flow",
    "m^3/s l/min L/min l/s cm^3/s m^3/h m^3/min dm^3/min gpm gal/min in^3/s ft^3/min",
    2.2e-3,
    "m^3/s",
    "l/min",
    "gpm",
  ),
  energy: kind("an energy", "J kJ MJ mJ N*m kN*m ft*lbf in*lbf", 310, "J", "J", "ft*lbf"),
  power: kind("a power", "W kW MW mW J/s hp ft*lbf/s", 8000, "W", "kW", "hp"),
  stiffness: kind(
    "a stiffness",
    "N/m kN/m MN/m GN/m N/mm kN/mm MN/mm N/um mN/m mN/mm mN/um lbf/in kip/in",
    4e8,
    "N/m",
    "kN/mm",
    "lbf/in",
  ),
  compliance: kind(
    "a volume per pressure",
    "m^3/Pa cm^3/bar l/bar cm^3/MPa l/MPa mm^3/Pa in^3/psi",
    2.5e-11,
    "m^3/Pa",
    "cm^3/bar",
    "in^3/psi",
  ),
  dashpot: kind("a damping", "N*s/m kN*s/m N/(m/s) kg/s N*s/mm lbf*s/in", 4000, "N*s/m", "kN*s/m", "lbf*s/in"),
  damping: kind(
    "a damping per length",
    "N*s/m^2 kN*s/m^2 N/m/(m/s) Pa*s kg/(m*s) kg/m/s lbf*s/in^2",
    40,
    "N*s/m^2",
    "N*s/m^2",
    "lbf*s/in^2",
  ),
  attenuation: kind("an attenuation", "1/m m^-1 1/km 1/mm 1/ft", 0.004, "1/m", "1/m", "1/ft"),
  "specific energy": kind(
    "an energy per volume",
    "J/m^3 kJ/m^3 MJ/m^3 GJ/m^3 J/cm^3 J/mm^3",
    2.2e8,
    "J/m^3",
    "MJ/m^3",
    "ksi",
  ),
  angle: kind("an angle", "rad mrad ° deg", 1, "rad", "°", "°"),
  strain: kind("a strain", "m/m mm/m um/m strain microstrain ustrain ε mε uε", 2.5e-4, "um/m", "um/m", "um/m"),
  dimensionless: kind("a plain number", "1 % ‰", 0.36, "", "%", "%"),
};

/** @param {string} words @param {string} units @param {number} example @param {string} SI @param {string} practical
 * @param {string} US @returns {Kind} */
function kind(words, units, example, SI, practical, US) {
  return { words, units, example, SI, practical, US };
}

/** The kind of quantity that is written in a unit; "" for a unit that is not known. @param {string} unit */
export function kindOf(unit) {
  const name = tidy(unit) || "1";
  const kinds = Object.entries(KINDS);
  const listed = kinds.find(([, { units }]) => ` ${units} `.includes(` ${name} `));
  const powers = String(sizeOf(unit)?.powers);
  const [found] = listed ?? kinds.find(([, { SI }]) => String(sizeOf(SI)?.powers) === powers) ?? [""];
  return name === "1" || name === "%" ? "dimensionless" : found;
}

/** A value in the unit of a system. The kind is that of its unit unless it is named: "blow rate" makes 40 Hz into
 * 2400 blows/min. A unit that is not known, and a plain number, stay as they are.
 * @param {number} value @param {string} unit @param {System} [system] @param {string} [kind] @returns {Quantity} */
export function shown(value, unit, system = "practical", kind = kindOf(unit)) {
  const wanted = kind === "dimensionless" ? unit : (KINDS[kind]?.[system] ?? unit);
  const found = converted(value, unit, wanted);
  return Number.isNaN(found) ? { value, unit } : { value: found, unit: wanted };
}

// ---- How numbers look

export const THIN = "\u202f";
const COMMA = new Set(["de", "sv"]);

/** A number with so many significant digits; null and what is not finite as a dash.
 * @param {number | null | undefined} value @param {number} [digits] @returns {string} */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const rounded = Number(value.toPrecision(digits));
  const size = Math.abs(rounded);
  let text;
  if (size >= 1e6 || size < 1e-4) {
    const [head, power] = value.toExponential(Math.max(digits - 2, 1)).split("e");
    text = `${head}·10${superscript(String(Number(power)))}`;
  } else {
    text = rounded.toFixed(Math.min(Math.max(0, digits - 1 - Math.floor(Math.log10(size))), 10));
    if (text.includes(".")) text = text.replace(/\.?0+$/, "");
  }
  return text.replace(/^-/, "−");
}

/** @param {string} power */
const superscript = (power) => [...power].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");

/** A number with the unit behind it. @param {string} text @param {string} unit */
function joined(text, unit) {
  const name = printed(unit);
  return text + (["", "1"].includes(name) ? "" : name === "°" ? name : THIN + name);
}

// ---- What is typed

/** The mark that groups thousands in a language: one alone before three digits may be a decimal mark as well.
 * @type {Record<string, string>} */
const GROUPS = { en: ",", de: "." };
/** Digits before a decimal mark: "1 050", "1'050", "1,050,000", "1,050" before a point, or with the marks changed. */
const WHOLE =
  /^(?:\d{1,3}(?:(?:[ ']\d{3})+(?!\d)|(?:,\d{3})+(?=\.)|(?:\.\d{3})+(?=,)|([,.])\d{3}(?:\1\d{3})+(?!\d))|\d*)/;
const POWER = /^(?:[eE]([+-]?\d+)|\s*[·*×]\s*10(?:\^?([+-]?\d+)|([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)))/;

/** @param {string} error @param {string} remedy @returns {Refused} */
const refused = (error, remedy) => ({ error, remedy });

/** @param {string} text */
const normal = (text) =>
  text
    .replace(/[\s\u202f\u2009\u00a0]+/g, " ")
    .replace(/[−‒]|^ ?–/g, "-")
    .replace(/[’_]/g, "'")
    .trim();

/** The number at the beginning of a text, and what follows it; null where it begins otherwise.
 * @param {string} text @param {string} language @returns {{ value: number, rest: string } | Refused | null} */
function leading(text, language) {
  const sign = /^[+-]? ?/.exec(text)?.[0] ?? "";
  const whole = WHOLE.exec(text.slice(sign.length))?.[0] ?? "";
  const fraction = /^[.,]\d*/.exec(text.slice((sign + whole).length))?.[0] ?? "";
  const tail = text.slice((sign + whole + fraction).length);
  if (!/\d/.test(whole + fraction)) return null;
  const digits = whole.replace(/[ '.,]/g, "");
  if (fraction[0] === GROUPS[language] && /^[1-9]\d{0,2}$/.test(whole) && fraction.length === 4) {
    const meant = `${digits}${fraction[0] === "," ? "." : ","}${fraction.slice(1)}`;
    const other = digits + fraction.slice(1);
    return refused(`“${whole}${fraction}” may mean ${meant} or ${other}`, `write ${other} or ${meant}`);
  }
  const power = POWER.exec(tail) ?? [""];
  const exponent = power[1] ?? power[2] ?? (power[3] ? tidy(power[3]).slice(1) : "0");
  const value = Number(`${sign.trim()}${digits || "0"}.${fraction.slice(1) || "0"}e${exponent}`);
  return { value, rest: tail.slice(power[0].length).trim() };
}

/** What a person has typed into a field for a number in a unit, in that unit: a bare number has it already. The error
 * says what is wrong, the remedy what to write instead.
 * @param {string} text @param {string} unit @param {string} [language] @returns {Quantity | Refused} */
export function read(text, unit, language = "en") {
  const typed = normal(text);
  const found = leading(typed, language);
  if (!found)
    return refused(typed ? `“${typed}” does not begin with a number` : "there is no number", wanted(unit, language));
  if ("error" in found) return found;
  const { value, rest } = found;
  if (!Number.isFinite(value)) return refused(`“${typed}” is too large a number`, wanted(unit, language));
  if (!rest || tidy(rest) === tidy(unit)) return { value, unit };
  const meant = alike(rest, unit);
  if (meant) return refused(`“${printed(rest)}” is not a unit known here`, `did you mean ${printed(meant)}?`);
  const size = sizeOf(rest);
  if (!size) return refused(`“${rest}” is not a unit known here`, wanted(unit, language));
  const same = converted(value, rest, unit);
  if (Number.isFinite(same)) return { value: same, unit };
  const kinds = [rest, unit].map((one) => KINDS[kindOf(one)]?.words ?? "another quantity");
  return refused(`“${typed}” is ${kinds[0]}, and ${kinds[1]} is needed`, wanted(unit, language));
}

/** What a number in a unit could be. @param {string} unit */
function example(unit) {
  const { example: value, SI } = KINDS[kindOf(unit)] ?? { example: 1, SI: unit };
  return converted(value, SI, unit);
}

/** @param {string} unit @param {string} language */
function wanted(unit, language) {
  const [value, known] = [example(unit), KINDS[kindOf(unit)]];
  const other = known && [known.practical, known.SI, known.US].find((one) => one !== unit);
  const told = (/** @type {number} */ one, /** @type {string} */ name) => {
    const text = number(one, 3);
    return joined(COMMA.has(language) ? text.replace(".", ",") : text, name);
  };
  const same = other === undefined ? "" : ` or ${told(converted(value, unit, other), other)}`;
  return `write ${known?.words ?? "a number"}, such as ${told(value, unit)}${same}`;
}

/** A usual unit of the kind of another that is written like this one but for its capitals: mPa is hardly meant.
 * @param {string} written @param {string} unit */
function alike(written, unit) {
  const name = tidy(written);
  const powers = String(sizeOf(unit)?.powers);
  const kinds = Object.values(KINDS).filter(({ SI }) => String(sizeOf(SI)?.powers) === powers);
  const units = kinds.flatMap(({ units }) => units.split(" "));
  return units.includes(name) ? undefined : units.find((one) => one.toLowerCase() === name.toLowerCase());
}
