// The fields of the case form: what each key is called and what may stand there. The server checks what is typed.

export const BAR = [
  ["bar.length", "Length", "from the driven to the striking end, as 341 mm"],
  ["bar.diameter", "Diameter", "of a solid round bar; or give the area"],
  ["bar.area", "Cross-section", "as 18.9 cm^2; or give the diameter"],
  ["bar.youngs_modulus", "Young's modulus", "steel, 210 GPa, when empty"],
  ["bar.density", "Density", "steel, 7850 kg/m^3, when empty"],
  ["bar.damping_ratio", "Damping ratio", "share of critical damping of every elastic mode; 0.001 when empty"],
  ["bar.drag", "Drag", "instead: force per velocity and length, N*s/m^2"],
];

export const CONTACT = [
  ["contact.restitution", "Restitution R", "0 to 1; or give the receiving area"],
  ["contact.receiving_area", "Receiving area", "of a long struck rod of the same material"],
  ["contact.strain", "Strain at the impact", "kept or reversed; reversed when empty"],
];

export const SYSTEM = [
  ["system.s", "Wave speed s", "C/(LΩ)"],
  ["system.d", "Damping d", "D/(MΩ)"],
  ["system.restitution", "Restitution R", "0 to 1"],
  ["system.strain", "Strain at the impact", "kept or reversed; kept when empty"],
];

const SI_ONLY = [
  ["load.frequency", "Frequency", "of the fundamental, as 60 Hz or 402 blows/min"],
  ["load.area", "Piston area", "that a pressure acts on; leave empty for forces"],
];

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
  fourier: [["load.unit", "Unit of the coefficients", "as kN or bar"]],
};

export const KINDS = [
  ["harmonic", "mean + cosine"],
  ["square", "square wave"],
  ["fourier", "Fourier coefficients"],
];

export function loadFields(kind, si) {
  const own = (LOADS[kind] ?? []).filter(([key]) => si || key !== "load.unit");
  return si ? [...own, ...SI_ONLY] : own;
}

export const TITLE = [["title", "Title", "free text"]];

export const START = [
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
];

/** A load of another kind in the numbers of the present one. */
export function otherLoad(load, kind, si) {
  const kept = si
    ? { ...(load.frequency && { frequency: load.frequency }), ...(load.area && { area: load.area }) }
    : {};
  const unit = unitOf(load);
  const mean = load.mean ?? (load.coefficients ? joined(load.coefficients[0][0], unit) : joined(0.4, unit));
  const amplitude =
    load.amplitude ??
    (load.coefficients ? joined(Math.hypot(...(load.coefficients[1] ?? [1, 0])), unit) : joined(1, unit));
  if (kind === "harmonic") return { kind, mean, amplitude, ...kept };
  if (kind === "square") return { kind, amplitude, kappa: 1.2, ...kept };
  const numberOf = (text) => (typeof text === "number" ? text : Number.parseFloat(text));
  const coefficients = [
    [numberOf(mean), 0],
    [numberOf(amplitude), 0],
  ];
  return { kind, coefficients, ...(si && { unit: unit || "N" }), ...kept };
}

const joined = (value, unit) => (unit ? `${Number(value.toPrecision(5))} ${unit}` : Number(value.toPrecision(5)));

function unitOf(load) {
  if (load.unit) return load.unit;
  const text = String(load.amplitude ?? "");
  return text.replace(/^[-+\d.eE\s]+/, "");
}

const LISTS = /modal_(displacement|velocity)$/;

/** What a field's text stands for: a number, a list for some keys, else the text; undefined when empty. */
export function typed(text, key = "") {
  const clean = text.trim().replaceAll("−", "-");
  if (clean === "") return undefined;
  if (LISTS.test(key)) return clean.split(/[\s,;]+/).map((part) => typed(part) ?? part);
  const plain = /^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$/.test(clean) && Number.isFinite(Number(clean));
  return plain ? Number(clean) : clean; // 1e400 is no number of JSON: the server is told the text
}
