// The case: every value with its unit and its problem beside it, files in and out, SI or dimensionless.

import { post, saidOf } from "../core/api.js";
import { button, div, download, facts, h, put, segments, select } from "../core/dom.js";
import { number, si, withUnit } from "../core/format.js";
import { effect, whenever } from "../core/signals.js";
import { data, fileName, setTables, view } from "../core/state.js";
import { struckNow, whatIsStruck } from "../blow/blow_target.js";
import { fileProblems, filesCard, recording } from "./case_files.js";
import { coefficients, clockedLoad, valveFields, valveKeys, valveLoad } from "./load_fields.js";
import { FIELDS, KINDS, loadFields, otherLoad, struckFields } from "./fields.js";
import { field, fill, problemOf, tellProblems } from "./form_fields.js";
import { chosenLaws, dampingFields, placeField, strainField } from "./law_choices.js";
import { sectioned, sectionsTable, toolTable, uniformOrSections } from "./sections_table.js";

/** @typedef {import("../core/moves.js").Tables} Tables */
/** @typedef {import("../core/dom.js").Child} Child */

const form = h("form", {
  class: "grid",
  id: "case-form",
  onsubmit: (/** @type {Event} */ event) => event.preventDefault(),
  autocomplete: "off",
});
const general = h("div", { role: "alert", id: "case-problems" }); // problems of no field
/** @type {HTMLElement} */
let files;

/** @param {HTMLElement} place */
export function start(place) {
  const inSI = button("SI", toPhysical, { id: "form-si" });
  const plain = button("Dimensionless", toPlain, { id: "form-plain" });
  const before = h("p", { class: "note", id: "case-before" });
  const follows = div("card");
  files = filesCard();
  put(
    place,
    div(
      "card row middle",
      h("h2", { class: "grow" }, "The case"),
      segments("Form of the case", inSI, plain),
      div("row", button("Download TOML", save, { id: "case-download" })),
    ),
    general,
    before,
    form,
    follows,
  );
  const shown = () => view.panel === "case" && data.tables;
  whenever(() => shown() && shapeOf(data.tables), build);
  effect(() => shown() && fill(form, data.tables));
  effect(() => view.panel === "case" && problems());
  effect(() => void (data.info && put(follows, whatFollows(data.info))));
  effect(() => {
    if (!shown()) return;
    const { system, body } = data.tables;
    inSI.setAttribute("aria-pressed", String(!system));
    plain.setAttribute("aria-pressed", String(Boolean(system)));
    inSI.disabled = Boolean(system) && !physical();
    plain.disabled = Boolean(body) && !system; // its numbers are those of its own kind
    inSI.title = inSI.disabled ? "A dimensionless case has no scales: pick a machine, or upload a case in SI" : "";
    before.hidden = !system || !physical();
    const words = "SI brings back the machine as it was: changes made in this form are not carried over.";
    put(before, before.hidden ? "" : words);
  });
}

async function toPlain() {
  const { tables, changed } = data;
  if (!tables?.bar) return;
  const info = await told();
  if (!info?.plain || data.changed !== changed) return;
  data.physical = tables;
  setTables(info.plain);
}

/** The case as it is now, as the server tells it: `data.info` may be of a moment ago. Nothing when it is refused. */
async function told() {
  try {
    return await post("case", { case: data.tables });
  } catch (/** @type {any} */ error) {
    put(general, h("p", { class: "note bad" }, error.message));
    return null;
  }
}

/** The tables in SI to go back to: those of before, else those of the machine. */
const physical = () => data.physical ?? (data.base?.bar ? data.base : null);

function toPhysical() {
  if (!data.tables?.bar && physical()) setTables(physical());
}

async function save() {
  const info = await told();
  if (info) download(new Blob([info.toml], { type: "application/toml" }), `${fileName()}.toml`);
}

/** What decides which fields there are. @param {Tables} tables */
function shapeOf(tables) {
  const { bar, body, system, load, tool, rock } = tables;
  const ofLoad = [load?.kind, load?.coefficients?.length, load?.kind === "valve" && valveKeys(load)];
  const ofTool = [
    struckNow(/** @type {any} */ (tables)),
    Boolean(rock),
    tool?.sections !== undefined,
    tool?.sections?.length,
  ];
  return [Boolean(bar), body?.kind, Boolean(system), ofLoad, ofTool, chosenLaws(tables)];
}

function build() {
  const { tables } = data;
  const own = tables.body ? held(tables) : [tables.bar ? inSI(tables) : inPlainNumbers(tables), blow(tables)];
  put(form, own, simulation());
  fill(form, tables);
  problems();
}

/** @param {Tables} tables */
function inSI(tables) {
  const sizes = sectioned(tables) ? FIELDS.bar.slice(-2) : FIELDS.bar; // sections have their own
  return [
    group("Bar", uniformOrSections(tables), fields([...FIELDS.title, ...sizes].map(field), dampingFields(tables))),
    load(tables),
    sectioned(tables) && sectionsTable(tables),
    div("stack", group("Contact", fields(FIELDS.contact.map(field), strainField(tables))), files),
  ];
}

/** @param {Tables} tables */
function inPlainNumbers(tables) {
  const inside = [[...FIELDS.title, ...FIELDS.system].map(field), dampingFields(tables), strainField(tables)];
  return [
    div("stack", group("System", uniformOrSections(tables), fields(inside)), files),
    load(tables),
    sectioned(tables) && sectionsTable(tables),
  ];
}

/** A structure that is held; a bar on a spring is described by its file. @param {Tables} tables */
function held(tables) {
  const { system, bar } = tables;
  const modal = tables.body.kind === "modes";
  const words = modal
    ? "A structure told by a table of its modes."
    : "A mass or a bar on a spring and a dashpot, at its driven end.";
  /** @type {import("./fields.js").Field[]} */
  const mass = system || bar ? [] : [["body.mass", "Mass", "of a rigid mass, as 2 kg"]];
  const { title, held, modes, mounted } = FIELDS;
  const wall = system ? FIELDS.system[1] : FIELDS.contact[0];
  const own = [...title, ...held, ...(modal ? modes : [...mounted, ...mass]), wall];
  return [div("stack", group("Structure", hint(words), fields(own.map(field))), files), load(tables)];
}

/** @param {string} title @param {Child[]} inside */
const group = (title, ...inside) => h("fieldset", {}, h("legend", {}, title), inside);
/** @param {Child[]} inside */
const fields = (...inside) => div("fields", inside);
/** @param {string} words */
const hint = (words) => h("p", { class: "hint small muted" }, words);

function simulation() {
  const words = "For the motion from a start. When empty: at rest, one bar length off the wall.";
  return group("Simulation", hint(words), fields(FIELDS.start.map(field)));
}

/** What is struck in one blow, resolved by waves. @param {Tables} tables */
function blow(tables) {
  const own = group(
    "One blow",
    hint("What the bar strikes, for the panel Blow."),
    div("row", whatIsStruck("field-struck")),
    ["tool.kind", "tool.end", "tool", "rock", "blow"].map(problemOf),
    fields(struckFields(tables, struckNow(/** @type {any} */ (tables))).map(field)),
  );
  return [own, tables.bar && tables.tool?.sections !== undefined && toolTable(tables)];
}

/** @param {Tables} tables */
function load(tables) {
  const kind = tables.load?.kind ?? "harmonic";
  const kinds = tables.body ? KINDS.filter(([name]) => name !== "valve") : KINDS;
  const known = kinds.some(([name]) => name === kind) ? kinds : [[kind, kind], ...kinds];
  const change = (/** @type {string} */ value) => setTables({ ...data.tables, load: changedLoad(data.tables, value) });
  return group(
    "Load",
    div("row", select("Kind", known, kind, change, { id: "field-load-kind" })),
    problemOf("load.kind"),
    kind === "fourier" && coefficients(tables.load.coefficients),
    kind === "valve"
      ? valveFields(tables.load)
      : fields(loadFields(kind, !tables.system).map(field), placeField(tables)),
  );
}

/** The load as one of another kind. @param {Tables} tables @param {string} kind */
function changedLoad({ load: now, system }, kind) {
  const inUnits = !system;
  if (now.kind === "valve") return clockedLoad(kind, inUnits, data.machine);
  if (kind === "valve") return valveLoad(now, inUnits, data.info);
  return otherLoad(now, kind, inUnits, data.info?.system?.load_factor);
}

/** Each problem beside its field; those of no field above the form. */
function problems() {
  const ofFile = fileProblems().map((problem) => ({ ...problem, message: `In the file: ${problem.message}` }));
  const others = tellProblems(form, [...data.problems, ...ofFile]);
  const bad = (/** @type {Child} */ words) => h("p", { class: "note bad" }, words);
  const refused = ofFile.length > 0 && bad("The file was not accepted; the previous case is kept.");
  put(
    general,
    refused,
    others.map((one) => bad(saidOf(one))),
  );
}

/** @param {Record<string, any>} info */
function whatFollows({ bar, body, first_mode: mode, system: clock, plain, laws, history, notes }) {
  const system = clock ?? plain.system; // of a machine that switches itself, with a second as unit of time
  const numbers = facts([
    body?.kind === "modes" || body?.kind === "mounted"
      ? ["modes", number(body.frequencies.length)]
      : ["wave speed s", number(system.s)],
    system.gap !== undefined && ["gap", number(system.gap)],
    system.d !== undefined && system.d !== null && ["damping d", number(system.d)],
    ["restitution R", number(system.restitution)],
    clock && ["load factor p₀/p₁", number(system.load_factor)],
    ["damping", laws.damping],
    ["contact", laws.contact],
    clock && ["load periods per period of the first mode", number(1 / mode)],
  ]);
  const areas = () => bar.sections.map((/** @type {any} */ { area_m2: own }) => withUnit(own * 1e4, "cm²")).join(", ");
  const machine = () =>
    facts([
      ["mass", si(bar.mass_kg * 1000, "g")],
      ["length", si(bar.length_m, "m")],
      ["cross-section", areas()],
      ["wave speed", withUnit(bar.wave_speed_m_s, "m/s")],
      ["first elastic mode", si(bar.first_mode_Hz, "Hz")],
      ["contact time", withUnit(bar.contact_time_us, "µs")],
    ]);
  const part = (/** @type {string} */ title, /** @type {Child} */ what) => h("div", {}, h("h3", {}, title), what);
  return [
    h("h2", {}, "What follows from the case"),
    div(
      "grid",
      bar && part("The machine", machine()),
      part("In plain numbers", numbers),
      history && h("div", {}, recording(history, notes)),
    ),
  ];
}
