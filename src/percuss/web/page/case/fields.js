// The fields of the case form: what each key is called and what may stand there. The server checks what is typed.

import { plainNumber, quantity } from "../core/format.js";

/** A field: its key, its label, what may stand there, and whether that is a list.
 * @typedef {[string, string, string, boolean?]} Field */
/** A load as it is written in a case. @typedef {Record<string, any>} Load */

/** The fields by what they are of; of a structure that is held what a table of modes has not is left out.
 * @type {Record<string, Field[]>} */
export const FIELDS = {
  title: [["title", "Title", "free text"]],
  bar: [
    ["bar.length", "Length", "from the driven to the striking end, as 341 mm"],
    ["bar.diameter", "Diameter", "of a solid round bar; or give the area"],
    ["bar.area", "Cross-section", "as 18.9 cm^2; or give the diameter"],
    ["bar.youngs_modulus", "Young's modulus", "steel, 210 GPa, when empty"],
    ["bar.density", "Density", "steel, 7850 kg/m^3, when empty"],
  ],
  contact: [
    ["contact.restitution", "Restitution R", "0 to 1; or give the receiving area"],
    ["contact.receiving_area", "Receiving area", "of a long struck rod of the same material"],
  ],
  system: [
    ["system.s", "Wave speed s", "C/(LΩ)"],
    ["system.restitution", "Restitution R", "0 to 1"],
  ],
  held: [["body.gap", "Gap", "from the contact to the wall without any force; negative where the wall presses"]],
  mounted: [
    ["body.spring", "Spring", "its stiffness; in SI as 20 kN/m"],
    ["body.dashpot", "Dashpot", "its force per velocity; none when empty"],
  ],
  modes: [
    ["body.omega", "Frequencies", "of the modes, in radians per radian of the load, or rad/s in SI", true],
    ["body.damping", "Dampings", "2ζω of each mode", true],
    ["body.contact", "Modes at the contact", "normalised to the modal mass 1", true],
    ["body.drive", "Modes at the load", "the same where the load acts", true],
  ],
  clock: [
    ["load.frequency", "Frequency", "of the fundamental, as 60 Hz or 402 blows/min"],
    ["load.area", "Piston area", "that a pressure acts on; leave empty for forces"],
  ],
  start: [
    ["start.position", "Position", "of the bar: 0 at the wall, negative off it; as -1 (bar lengths) or -3 cm"],
    ["start.velocity", "Velocity", "toward the wall"],
    ["start.modal_displacement", "Modes, displacement", "instead: u₀, u₁, … in bar lengths"],
    ["start.modal_velocity", "Modes, velocity", "u₀′, u₁′, … in bar lengths per radian"],
    ["start.time", "Load phase", "at the start, in rad, or a time"],
    ["start.orbit", "Steady motion", "instead: just after the blow of motion 1, 2 …"],
    ["start.periods", "Load periods per blow", "with a steady motion; 1 when empty"],
    ["start.random", "Random", "instead: rigid, still or ringing"],
    ["start.seed", "Seed", "of the random start"],
    ["simulation.modes", "Elastic modes", "0: a rigid bar; 32 when empty"],
    ["simulation.impacts", "Impacts", "at most; 2000 when empty"],
    ["simulation.time", "Time", "at most, in rad, or as 2 s"],
    ["simulation.tolerance", "Tolerance", "for calling a motion periodic; 1e-9 when empty"],
  ],
  speed: [["blow.velocity", "Speed", "of the bar toward the tool, for one blow; that of the steady motion when empty"]],
  impedance: [["tool.impedance", "Impedance", "over that of the bar's last section"]],
  bit: [["tool.bit_mass", "Mass at its end", "of a bit too short to be a section; none when empty"]],
  gap: [["tool.gap", "Gap", "between the faces when the blow begins; none when empty"]],
  rock: [
    ["rock.stiffness", "Stiffness K₁ of the rock", "force per penetration while it grows, as 100 kN/mm"],
    [
      "rock.unloading_ratio",
      "Unloading ratio γ",
      "0 to 1: share of the penetration that the rock gives back; 1 when empty",
    ],
  ],
};

/** @type {Record<string, Field[]>} */
const LOADS = {
  harmonic: [
    ["load.mean", "Mean", "positive toward the wall"],
    ["load.amplitude", "Amplitude", "of the cosine"],
    ["load.harmonic", "Harmonic", "multiple of the fundamental; 1 when empty"],
  ],
  square: [
    ["load.amplitude", "Amplitude", "the load pushes with this force, then pulls with it"],
    ["load.kappa", "κ", "0 to 2: the load pushes for κ/2 of each period"],
    ["load.harmonics", "Harmonics", "Fourier coefficients kept; 64 when empty"],
  ],
  steps: [
    ["load.breaks", "Phases of the jumps", "in radians, increasing, from 0 to less than 2π: 0, 1.9", true],
    ["load.values", "Values", "the load from each of these phases to the next: 1, -1", true],
    ["load.unit", "Unit of the values", "as kN or bar"],
    ["load.harmonics", "Harmonics", "Fourier coefficients kept; 64 when empty"],
  ],
  fourier: [["load.unit", "Unit of the coefficients", "as kN or bar"]],
};

export const KINDS = [
  ["harmonic", "mean + cosine"],
  ["square", "square wave"],
  ["steps", "steps"],
  ["fourier", "Fourier coefficients"],
  ["valve", "valve, switched by the piston"],
];

/** The fields of a clocked load. @param {string} kind @param {boolean} si */
export function loadFields(kind, si) {
  const own = (LOADS[kind] ?? []).filter(([key]) => si || key !== "load.unit");
  return si ? [...own, ...FIELDS.clock] : own;
}

/** Of what is struck in one blow, and how fast. @param {Record<string, any>} tables @param {string} struck */
export function struckFields({ tool, rock, bar }, struck) {
  const { impedance, bit, gap, rock: ofRock, speed } = FIELDS;
  const own = bar ? ["free", "rock"].includes(struck) && bit : struck !== "wall" && impedance;
  return [...((tool && own) || []), ...(tool ? gap : []), ...(rock ? ofRock : []), ...speed];
}

/** A load of another kind in the numbers of the present one, whose load factor tells the mean in the same unit.
 * @param {Load} load @param {string} kind @param {boolean} si @param {number} [factor] @returns {Load} */
export function otherLoad(load, kind, si, factor) {
  const { frequency, area, at } = load;
  const kept = { ...(si && frequency && { frequency }), ...(si && area && { area }), ...(at && { at }) };
  const unit = unitOf(load);
  const [mean, amplitude] = meanAndAmplitude(load, factor ?? 0.4);
  if (kind === "harmonic") return { kind, mean: joined(mean, unit), amplitude: joined(amplitude, unit), ...kept };
  if (kind === "square") return { kind, amplitude: joined(amplitude, unit), kappa: 1.2, ...kept };
  const inUnit = si && { unit: unit || "N" };
  if (kind === "fourier")
    return { kind, coefficients: [mean, amplitude].map((part) => [plainNumber(part, 5), 0]), ...inUnit, ...kept };
  const square = load.kind === "square"; // which is a load of two steps
  const push = square ? (load.kappa ?? 1) * Math.PI : Math.PI;
  const [high, low] = square ? [amplitude, -amplitude] : [mean + amplitude, mean - amplitude];
  const [breaks, values] = [
    [0, push],
    [high, low],
  ].map((pair) => pair.map((part) => plainNumber(part, 8)));
  return { kind, breaks, values, ...inUnit, ...kept };
}

/** @param {Load} load @param {number} factor */
export function meanAndAmplitude({ mean, amplitude = 1, coefficients, values }, factor) {
  if (coefficients) return [coefficients[0]?.[0] ?? 0, Math.hypot(...(coefficients[1] ?? [1, 0]))];
  if (Array.isArray(values)) {
    const [most, least] = [Math.max(...values), Math.min(...values)];
    return [(most + least) / 2, (most - least) / 2];
  }
  const [own, size] = [quantity(mean), quantity(amplitude) ?? { value: 1, unit: "" }];
  return [own?.unit === size.unit ? own.value : factor * size.value, size.value];
}

/** @param {number} value @param {string} unit */
export const joined = (value, unit) => (unit ? `${plainNumber(value, 5)} ${unit}` : plainNumber(value, 5));

/** @param {Load} load @returns {string} */
export function unitOf(load) {
  if (load.unit) return load.unit;
  const text = String(load.amplitude ?? "");
  return text.replace(/^[-+\d.eE\s]+/, "");
}

const SHARES = /restitution|ratio|kappa|efficiency$/; // keys of plain numbers that may be typed as a share
const LISTS = /modal_(displacement|velocity)$/;

/** What a field's text stands for: a number, a list for some keys, else the text; undefined when empty.
 * @param {string} text @param {string} [key] @param {boolean} [list] @returns {any} */
export function typed(text, key = "", list = LISTS.test(key)) {
  const clean = text.trim().replaceAll("−", "-");
  if (clean === "") return undefined;
  if (list) return clean.split(/[\s,;]+/).map((part) => typed(part) ?? part);
  const point = clean.replace(/^([-+]?\d*),(\d+)/, "$1.$2"); // 0,36
  const share = /^([-+]?[\d.eE+-]+)\s*%$/.exec(point);
  if (share && Number.isFinite(Number(share[1])) && SHARES.test(key))
    return Number((Number(share[1]) / 100).toPrecision(12));
  const plain = /^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$/.test(point) && Number.isFinite(Number(point));
  return plain ? Number(point) : point; // 1e400 is no number of JSON: the server is told the text
}
