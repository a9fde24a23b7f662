// The case: every value with its unit and its problem beside it, files in and out, SI or dimensionless.

import { $$, download, h, put, select } from "./dom.js";
import { number, si, withUnit } from "./format.js";
import { fileName, fileProblems, filesCard, list, recording, said } from "./case_files.js";
import { coefficients, fillCoefficients } from "./coefficients.js";
import { BAR, CONTACT, KINDS, START, SYSTEM, TITLE, loadFields, otherLoad, typed } from "./fields.js";
import { valueAt } from "./moves.js";
import { data, on, setKey, setTables, view } from "./state.js";

export const panel = {
  name: "case",
  title: "Case",
  start: startCase,
};

let shape = "";
const parts = {};

function startCase(panel) {
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
  on("info", facts);
}

/** Which form: SI, or plain numbers. */
function form() {
  const button = (id, text, press) => h("button", { type: "button", id, onclick: press }, text);
  parts.si = button("form-si", "SI", toPhysical);
  parts.plain = button("form-plain", "Dimensionless", toPlain);
  return h("div", { class: "segments", role: "group", "aria-label": "Form of the case" }, parts.si, parts.plain);
}

function toPlain() {
  if (!data.tables?.bar || !data.info?.plain) return;
  data.physical = data.tables;
  setTables(data.info.plain);
}

/** The tables in SI to go back to: those of before, else those of the machine. */
const physical = () => data.physical ?? (data.base?.bar ? data.base : null);

function toPhysical() {
  if (!data.tables?.bar && physical()) setTables(physical());
}

function tools() {
  const save = () => download(new Blob([data.info?.toml ?? ""], { type: "application/toml" }), `${fileName()}.toml`);
  return h(
    "div",
    { class: "row" },
    h("button", { type: "button", id: "case-download", onclick: save }, "Download TOML"),
  );
}

function build() {
  const tables = data.tables;
  if (!tables) return;
  parts.si.setAttribute("aria-pressed", String(Boolean(tables.bar)));
  parts.plain.setAttribute("aria-pressed", String(Boolean(tables.system)));
  parts.si.disabled = Boolean(tables.system) && !physical();
  parts.si.title = parts.si.disabled
    ? "A dimensionless case has no scales: pick a machine, or upload a case in SI"
    : "";
  const back = tables.system && physical();
  parts.before.hidden = !back;
  const words = "SI brings back the machine as it was: changes made in this form are not carried over.";
  put(parts.before, back ? words : "");
  const now = JSON.stringify([Boolean(tables.bar), tables.load?.kind, tables.load?.coefficients?.length]);
  if (now !== shape) {
    shape = now;
    const first = tables.bar ? [...TITLE, ...BAR] : [...TITLE, ...SYSTEM];
    const groups = tables.bar
      ? [group("Bar", first), load(tables), h("div", { class: "stack" }, group("Contact", CONTACT), parts.files)]
      : [h("div", { class: "stack" }, group("System", first), parts.files), load(tables)];
    put(parts.form, groups, group("Simulation", START, true));
    problems();
  }
  fill();
}

const group = (title, fields, folded = false) => {
  const inside = h(
    "div",
    { class: "fields" },
    fields.map(([key, label, hint]) => field(key, label, hint)),
  );
  if (!folded) return h("fieldset", {}, h("legend", {}, title), inside);
  return h(
    "fieldset",
    {},
    h("legend", {}, title),
    h("p", { class: "hint small muted" }, "For the motion from a start. When empty: at rest, one bar length off the wall."),
    inside,
  );
};

const idOf = (key) => `field-${key.replaceAll(".", "-")}`;

function field(key, label, hint) {
  const id = idOf(key);
  const input = h("input", {
    type: "text",
    id,
    "data-key": key,
    spellcheck: "false",
    "aria-describedby": `${id}-hint ${id}-problem`,
    oninput: (event) => setKey(key, key === "title" ? event.target.value || undefined : typed(event.target.value, key)),
  });
  return h(
    "div",
    { class: "field" },
    h("label", { for: id }, label),
    input,
    h("div", { class: "hint", id: `${id}-hint` }, h("code", {}, key.split(".").at(-1)), ": ", hint),
    h("div", { class: "problem", id: `${id}-problem` }),
  );
}

function load(tables) {
  const kind = tables.load?.kind ?? "harmonic";
  const inSI = Boolean(tables.bar);
  const change = (value) => setTables({ ...data.tables, load: otherLoad(data.tables.load, value, inSI) });
  const known = KINDS.some(([name]) => name === kind) ? KINDS : [[kind, kind], ...KINDS];
  const pick = select("Kind", known, kind, change, { id: "field-load-kind", "data-key": "load.kind" });
  const inside = h(
    "div",
    { class: "fields" },
    loadFields(kind, inSI).map(([key, label, hint]) => field(key, label, hint)),
  );
  return h(
    "fieldset",
    {},
    h("legend", {}, "Load"),
    h("div", { class: "row" }, pick),
    h("div", { class: "problem", id: "field-load-kind-problem" }),
    kind === "fourier" && coefficients(tables.load.coefficients),
    inside,
  );
}

/** The fields from the tables; the one that is being typed into is left alone. */
function fill() {
  for (const input of $$("input[data-key]", parts.form)) {
    if (input === document.activeElement) continue;
    const value = valueAt(data.tables, input.dataset.key);
    const text = value === undefined || value === null ? "" : Array.isArray(value) ? value.join(", ") : String(value);
    if (input.value !== text) input.value = text;
  }
  fillCoefficients(parts.form);
}

/** Each problem beside its field; those of no field above the form. */
function problems() {
  const beside = new Map();
  const general = [];
  const ofFile = fileProblems().map((problem) => ({ ...problem, message: `In the file: ${problem.message}` }));
  for (const problem of [...data.problems, ...ofFile]) {
    const key = problem.key.replace(/\[.*$/, "");
    if (key && document.getElementById(`${idOf(key)}-problem`)) beside.set(key, [...(beside.get(key) ?? []), problem]);
    else general.push(problem);
  }
  for (const place of $$(".problem[id]", parts.form)) {
    const key = place.id
      .replace(/^field-/, "")
      .replace(/-problem$/, "")
      .replace(/-(?=\w+$)/, ".");
    const words = (beside.get(key) ?? []).map(said).join(" ");
    put(place, words);
    const input = document.getElementById(idOf(key));
    if (input) words ? input.setAttribute("aria-invalid", "true") : input.removeAttribute("aria-invalid");
  }
  const refused = ofFile.length > 0 && "The file was not accepted; the previous case is kept.";
  put(
    parts.general,
    refused && h("p", { class: "note bad" }, refused),
    general.map((p) => h("p", { class: "note bad" }, [p.key && `${p.key}: `, said(p)])),
  );
}

function facts() {
  const { info } = data;
  if (!info) return;
  const { system, bar, first_mode: mode } = info;
  const rows = [
    ["wave speed s", number(system.s)],
    ["damping d", number(system.d)],
    ["restitution R", number(system.restitution)],
    ["load factor p₀/p₁", number(system.load_factor)],
    ["damping", info.laws.damping],
    ["contact", info.laws.contact],
    ["load periods per period of the first mode", number(1 / mode)],
  ];
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
      machine && part("The machine", list(machine)),
      part("In plain numbers", list(rows)),
      info.history && h("div", {}, recording(info.history, info.notes)),
    ),
  );
}
