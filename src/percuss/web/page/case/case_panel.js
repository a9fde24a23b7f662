// The case: every value with its unit and its problem beside it, files in and out, SI or dimensionless.

import { post, said, saidOf } from "../core/api.js";
import { download, facts, h, put, select } from "../core/dom.js";
import { number, si, withUnit } from "../core/format.js";
import { fileName, fileProblems, filesCard, recording } from "./case_files.js";
import { struckNow, whatIsStruck } from "../blow/blow_target.js";
import { coefficients, fillCoefficients } from "./coefficients.js";
import { BAR, CONTACT, HELD, KINDS, MODES, MOUNTED, SHARED, START, SYSTEM, TITLE, loadFields, otherLoad, struckFields } from "./fields.js";
import { field, fill, problemOf, tellProblems } from "./form_fields.js";
import { chosenLaws, dampingFields, placeField, strainField } from "./law_choices.js";
import { sectioned, sectionsTable, toolTable, uniformOrSections } from "./sections_table.js";
import { data, on, setTables, view } from "../core/state.js";
import { clockedLoad, valveFields, valveKeys, valveLoad } from "./valve_fields.js";

let shape = "";
const parts = {};

export function start(panel) {
  parts.form = h("form", {
    class: "grid",
    id: "case-form",
    onsubmit: (event) => event.preventDefault(),
    autocomplete: "off",
  });
  parts.facts = h("div", { class: "card" });
  parts.files = filesCard(problems);
  parts.general = h("div", { role: "alert", id: "case-problems" });
  parts.before = h("p", { class: "note", id: "case-before" });
  put(
    panel,
    h("div", { class: "card row middle" }, h("h2", { class: "grow" }, "The case"), form(), tools()),
    parts.general,
    parts.before,
    parts.form,
    parts.facts,
  );
  const seen = (action) => () => view.panel === "case" && action();
  on("tables info view", seen(build));
  on("problems view", seen(problems));
  on("info", whatFollows);
}

/** Which form: SI, or plain numbers. */
function form() {
  const button = (id, text, press) => h("button", { type: "button", id, onclick: press }, text);
  parts.si = button("form-si", "SI", toPhysical);
  parts.plain = button("form-plain", "Dimensionless", toPlain);
  return h("div", { class: "segments", role: "group", "aria-label": "Form of the case" }, parts.si, parts.plain);
}

async function toPlain() {
  const { tables, changed } = data;
  if (!tables?.bar) return;
  const info = await told();
  if (!info?.plain || data.changed !== changed) return;
  data.physical = tables;
  setTables(info.plain);
}

/** The case as it is now, as the server tells it: `data.info` may be that of a moment ago. Nothing when it is refused. */
async function told() {
  try {
    return await post("case", { case: data.tables });
  } catch (error) {
    put(parts.general, h("p", { class: "note bad" }, error.message));
    return null;
  }
}

/** The tables in SI to go back to: those of before, else those of the machine. */
const physical = () => data.physical ?? (data.base?.bar ? data.base : null);

function toPhysical() {
  if (!data.tables?.bar && physical()) setTables(physical());
}

function tools() {
  return h(
    "div",
    { class: "row" },
    h("button", { type: "button", id: "case-download", onclick: save }, "Download TOML"),
  );
}

async function save() {
  const info = await told();
  if (info) download(new Blob([info.toml], { type: "application/toml" }), `${fileName()}.toml`);
}

function build() {
  const tables = data.tables;
  if (!tables) return;
  parts.si.setAttribute("aria-pressed", String(!tables.system));
  parts.plain.setAttribute("aria-pressed", String(Boolean(tables.system)));
  parts.si.disabled = Boolean(tables.system) && !physical();
  parts.plain.disabled = Boolean(tables.body) && !tables.system; // its numbers are those of its own kind
  parts.si.title = parts.si.disabled
    ? "A dimensionless case has no scales: pick a machine, or upload a case in SI"
    : "";
  const back = tables.system && physical();
  parts.before.hidden = !back;
  const words = "SI brings back the machine as it was: changes made in this form are not carried over.";
  put(parts.before, back ? words : "");
  const { kind, coefficients: pairs } = tables.load ?? {};
  const own = kind === "valve" && valveKeys(tables.load);
  const now = JSON.stringify([Boolean(tables.bar), tables.body?.kind, Boolean(tables.system), kind, pairs?.length, own, ...chosenLaws(tables), ...toolShape(tables)]);
  if (now !== shape) {
    shape = now;
    const own = tables.body ? held(tables) : [tables.bar ? inSI(tables) : inPlainNumbers(tables), blow(tables)];
    put(parts.form, own, simulation());
    problems();
  }
  fill(parts.form);
  fillCoefficients(parts.form);
}

function inSI(tables) {
  const sizes = sectioned(tables) ? SHARED : BAR;
  return [
    group("Bar", uniformOrSections(tables), fields([...TITLE, ...sizes].map(field), dampingFields(tables))),
    load(tables),
    sectioned(tables) && sectionsTable(tables),
    h("div", { class: "stack" }, group("Contact", fields(CONTACT.map(field), strainField(tables))), parts.files),
  ];
}

function inPlainNumbers(tables) {
  const inside = [[...TITLE, ...SYSTEM].map(field), dampingFields(tables), strainField(tables)];
  return [
    h("div", { class: "stack" }, group("System", uniformOrSections(tables), fields(inside)), parts.files),
    load(tables),
    sectioned(tables) && sectionsTable(tables),
  ];
}

/** A structure that is held; a bar on a spring is described by its file. */
function held(tables) {
  const { kind } = tables.body;
  const words = kind === "modes" ? "A structure told by a table of its modes." : "A mass or a bar on a spring and a dashpot, at its driven end.";
  const mass = tables.system ? [] : [["body.mass", "Mass", "of a rigid mass, as 2 kg"]];
  const own = kind === "modes" ? MODES : [...MOUNTED, ...(tables.bar ? [] : mass)];
  const wall = [tables.system ? SYSTEM.at(-1) : CONTACT[0]];
  return [
    h("div", { class: "stack" }, group("Structure", h("p", { class: "hint small muted" }, words), fields([...TITLE, ...HELD, ...own, ...wall].map(field))), parts.files),
    load(tables),
  ];
}

const group = (title, ...inside) => h("fieldset", {}, h("legend", {}, title), inside);
const fields = (...inside) => h("div", { class: "fields" }, inside);

function simulation() {
  const words = "For the motion from a start. When empty: at rest, one bar length off the wall.";
  return group("Simulation", h("p", { class: "hint small muted" }, words), fields(START.map(field)));
}

/** What is struck in one blow, resolved by waves. */
function blow(tables) {
  const struck = struckNow(tables);
  const own = group(
    "One blow",
    h("p", { class: "hint small muted" }, "What the bar strikes, for the panel Blow."),
    h("div", { class: "row" }, whatIsStruck("field-struck")),
    ["tool.kind", "tool.end", "tool", "rock", "blow"].map(problemOf),
    fields(struckFields(tables, struck).map(field)),
  );
  return [own, tables.bar && tables.tool?.sections !== undefined && toolTable(tables)];
}

const toolShape = (tables) => [
  struckNow(tables),
  Boolean(tables.rock),
  tables.tool?.sections !== undefined,
  Array.isArray(tables.tool?.sections) && tables.tool.sections.length,
];

function load(tables) {
  const kind = tables.load?.kind ?? "harmonic";
  const si = !tables.system;
  const change = (value) => setTables({ ...data.tables, load: changedLoad(data.tables, value) });
  const kinds = tables.body ? KINDS.filter(([name]) => name !== "valve") : KINDS;
  const known = kinds.some(([name]) => name === kind) ? kinds : [[kind, kind], ...kinds];
  const pick = select("Kind", known, kind, change, { id: "field-load-kind" });
  return group(
    "Load",
    h("div", { class: "row" }, pick),
    problemOf("load.kind"),
    kind === "fourier" && coefficients(tables.load.coefficients),
    kind === "valve" ? valveFields(tables.load) : fields(loadFields(kind, si).map(field), placeField(tables)),
  );
}

/** The load as one of another kind. */
function changedLoad({ load: now, system }, kind) {
  const si = !system;
  if (now.kind === "valve") return clockedLoad(kind, si, data.machine);
  if (kind === "valve") return valveLoad(now, si, data.info);
  return otherLoad(now, kind, si, data.info?.system?.load_factor);
}

/** Each problem beside its field; those of no field above the form. */
function problems() {
  const ofFile = fileProblems().map((problem) => ({ ...problem, message: `In the file: ${problem.message}` }));
  const general = tellProblems(parts.form, [...data.problems, ...ofFile], said);
  const refused = ofFile.length > 0 && "The file was not accepted; the previous case is kept.";
  put(
    parts.general,
    refused && h("p", { class: "note bad" }, refused),
    general.map((p) => h("p", { class: "note bad" }, saidOf(p))),
  );
}

function whatFollows() {
  const { info } = data;
  if (!info) return;
  const { bar, first_mode: mode } = info;
  const system = info.system ?? info.plain.system; // of a machine that switches itself, with a second as unit of time
  const clocked = Boolean(info.system);
  const rows = [
    info.body?.kind === "modes" || info.body?.kind === "mounted"
      ? ["modes", number(info.body.frequencies.length)]
      : ["wave speed s", number(system.s)],
    system.gap !== undefined && ["gap", number(system.gap)],
    system.d !== undefined && system.d !== null && ["damping d", number(system.d)],
    ["restitution R", number(system.restitution)],
    clocked && ["load factor p₀/p₁", number(system.load_factor)],
    ["damping", info.laws.damping],
    ["contact", info.laws.contact],
    clocked && ["load periods per period of the first mode", number(1 / mode)],
  ].filter(Boolean);
  const machine = bar && [
    ["mass", si(bar.mass_kg * 1000, "g")],
    ["length", si(bar.length_m, "m")],
    ["cross-section", bar.sections.map(({ area_m2: own }) => withUnit(own * 1e4, "cm²")).join(", ")],
    ["wave speed", withUnit(bar.wave_speed_m_s, "m/s")],
    ["first elastic mode", si(bar.first_mode_Hz, "Hz")],
    ["contact time", withUnit(bar.contact_time_us, "µs")],
  ];
  const part = (title, what) => h("div", {}, h("h3", {}, title), what);
  put(
    parts.facts,
    h("h2", {}, "What follows from the case"),
    h(
      "div",
      { class: "grid" },
      machine && part("The machine", facts(machine)),
      part("In plain numbers", facts(rows)),
      info.history && h("div", {}, recording(info.history, info.notes)),
    ),
  );
}
