// What engineers ask of the whole hammer: the best one, what tolerances do to it, others beside it, its numbers by
// measured blows, and its fatigue. Each answer is a sentence, its pictures and its tables, as a command gives them.

import { Refusal, stream } from "../core/api.js";
import { differences } from "../core/address.js";
import { h, put, select } from "../core/dom.js";
import { data, on, setTables, show, view } from "../core/state.js";

const QUESTIONS = {
  design: { name: "the best hammer within ranges", fields: ["goal", "vary", "limits", "hammers", "plane"] },
  tolerance: { name: "what tolerances do to it", fields: ["vary", "hammers"] },
  compare: { name: "beside others", fields: ["beside"] },
  identify: { name: "its numbers from measured blows", fields: ["blows", "vary", "given"] },
  fatigue: { name: "how long its steel lasts", fields: [] },
};

/** What stands in the fields of ranges by question: how one is written, and what an empty field means. */
const RANGES = {
  design: { label: "What may vary, a line each", example: "bar.length=300:400mm", put: (one) => `${one.name}=${spread(one)}` },
  tolerance: {
    label: "Tolerances, a line each; none: those of the case, or the usual ones of a drawing",
    example: "load.pressure=±10bar",
    put: (one) => `${one.name}=±5%`,
  },
  identify: {
    label: "What is to be found, a line each; none: R and the pressure or the scale of the load",
    example: "contact.restitution",
    put: (one) => one.name,
  },
};

const parts = {};
const typed = { vary: {}, limits: "", beside: "", given: "", hammers: 600, figure: "rock_power", greatest: true, plane: false };
let running = null; // the abort controller of the question under way
let answered = null; // the tables that the shown answer is of
let blows = "";
let blowsOf = ""; // the name of their file

export function start(panel) {
  parts.form = h("form", { id: "hammer-form", onsubmit: (event) => (event.preventDefault(), run()) });
  parts.bar = h("progress", { max: 1, value: 0, "aria-label": "Progress", id: "hammer-progress" });
  parts.status = h("p", { role: "status", id: "hammer-status" }, "Every hammer that is looked at has its own cycle, oil, blow and rock.");
  parts.problem = h("p", { class: "problem", role: "alert", id: "hammer-problem" });
  parts.answer = h("div", { id: "hammer-answer" });
  put(
    panel,
    h("div", { class: "card" }, h("h2", {}, "Questions about the whole hammer"), parts.form, parts.problem),
    h("div", { class: "card" }, parts.bar, parts.status, parts.answer),
  );
  on("view info", () => view.panel === "hammer" && build());
  on("tables", changed);
  on("pinned tables", besideA);
}

let ofA = ""; // the line that stands for the design that is pinned

/** The design that is pinned as A is the first of the others. */
function besideA() {
  const { tables } = data.pinned ?? {};
  const line = tables ? differences(tables, data.tables).map(([key, value]) => `${key}=${value}`).join(", ") : "";
  if (line === ofA) return;
  const others = typed.beside.split("\n").filter((one) => one && one !== ofA);
  ofA = line;
  typed.beside = [line, ...others].filter(Boolean).join("\n");
  const area = document.getElementById("hammer-beside");
  if (area) area.value = typed.beside;
}

/** Measured blows, picked or dropped anywhere: the question is which numbers fit them. */
export function takeBlows(text, name) {
  blows = text;
  blowsOf = name;
  show({ panel: "hammer", ask: "identify" });
  const place = document.getElementById("hammer-blows-of");
  if (place) put(place, name);
}

const question = () => (view.ask in QUESTIONS ? view.ask : "design");

/** A range of ten per cent about what the case has, in the unit of the case. */
function spread({ value, low, high, unit }) {
  const [from, to] = value ? [0.9 * value, 1.1 * value].sort((a, b) => a - b) : [low, high];
  const digits = (x) => String(Number(x.toPrecision(4)));
  return `${digits(from)}:${digits(to)}${unit ? ` ${unit}` : ""}`;
}

function build() {
  if (!data.about || !data.info) return;
  const key = JSON.stringify([question(), data.info.parameters.map(({ name }) => name)]);
  if (parts.form.dataset.built === key) return;
  parts.form.dataset.built = key;
  const { fields } = QUESTIONS[question()];
  parts.go = h("button", { type: "submit", class: "main", id: "hammer-run" }, "Answer");
  parts.cancel = h("button", { type: "button", id: "hammer-cancel", ".disabled": true, onclick: () => running?.abort() }, "Cancel");
  const questions = Object.entries(QUESTIONS).map(([name, { name: words }]) => [name, words]);
  put(
    parts.form,
    h("div", { class: "row" }, select("Question", questions, question(), (ask) => show({ ask }), { id: "hammer-question" })),
    fields.map((field) => FIELDS[field]()),
    h("div", { class: "row" }, parts.go, parts.cancel),
  );
  busy(Boolean(running));
}

/** Lines of text, and a choice that adds one. */
function lines(id, label, example, value, keep, add) {
  const area = h("textarea", { id, rows: 3, placeholder: example, spellcheck: "false", ".value": value, oninput: () => keep(area.value) });
  const more = (line) => {
    area.value = [area.value.trimEnd(), line].filter(Boolean).join("\n");
    keep(area.value);
    area.focus();
  };
  const adding = add && select(add.label, [["", "…"], ...add.options], "", (name) => name && more(add.line(name)), { id: `${id}-add` });
  return h("div", { class: "lines" }, h("label", { class: "pick" }, h("span", {}, label), area), adding);
}

const FIELDS = {
  goal: () =>
    h(
      "div",
      { class: "row" },
      select("The", [["most", "most"], ["least", "least"]], typed.greatest ? "most" : "least", (word) => (typed.greatest = word === "most"), { id: "hammer-sense" }),
      select("Figure", data.about.figures.map(({ name, label }) => [name, label]), typed.figure, (name) => (typed.figure = name), { id: "hammer-figure" }),
    ),
  vary: () => {
    const ask = question();
    const { label, example, put: line } = RANGES[ask];
    const options = data.info.parameters.filter(({ name }) => name.includes(".")).map(({ name, label: words }) => [name, `${words} (${name})`]);
    const one = (name) => line(data.info.parameters.find((known) => known.name === name));
    return lines("hammer-vary", label, example, typed.vary[ask] ?? "", (text) => (typed.vary[ask] = text), { label: "Add a number", options, line: one });
  },
  limits: () =>
    lines("hammer-limits", "Limits, a line each", "steel.stress<400MPa", typed.limits, (text) => (typed.limits = text), {
      label: "Add a limit",
      options: data.about.figures.map(({ name, label }) => [name, label]),
      line: (name) => `${name}<`,
    }),
  hammers: () =>
    h(
      "label",
      { class: "pick" },
      h("span", {}, "Hammers, about"),
      h("input", { type: "number", id: "hammer-hammers", min: 20, max: 10000, step: 1, ".value": String(typed.hammers), onchange: (event) => (typed.hammers = Math.min(10000, Math.max(20, Math.round(Number(event.target.value)) || 600))) }),
    ),
  plane: () =>
    h(
      "label",
      { class: "row middle" },
      h("input", { type: "checkbox", id: "hammer-plane", ".checked": typed.plane, onchange: (event) => (typed.plane = event.target.checked) }),
      "with a map of the first two ranges: which hammers keep the limits",
    ),
  beside: () =>
    lines("hammer-beside", "Others, a line each: a machine, or other numbers of the case", "contact.restitution=0.3", typed.beside, (text) => (typed.beside = text), {
      label: "Add a machine",
      options: data.machines.map(({ name, title }) => [name, title ?? name]),
      line: (name) => name,
    }),
  given: () =>
    lines("hammer-given", "What is only given, and how far it may be off, a line each", "bar.diameter=±0.2mm", typed.given, (text) => (typed.given = text)),
  blows: () =>
    h(
      "label",
      { class: "pick" },
      h("span", {}, "Measured blows, a row each, as CSV: time [s], rebound speed [m/s], …"),
      h("input", { type: "file", id: "hammer-blows", accept: ".csv,.txt,text/csv", onchange: async ({ target: { files } }) => takeBlows((await files[0]?.text()) ?? "", files[0]?.name ?? "") }),
      h("span", { id: "hammer-blows-of" }, blowsOf),
    ),
};

const rows = (text) => text.split("\n").map((line) => line.trim()).filter(Boolean);

function asked() {
  const ask = question();
  const { fields } = QUESTIONS[ask];
  const body = { case: data.tables, question: ask };
  if (fields.includes("vary")) body.vary = rows(typed.vary[ask] ?? "");
  if (ask === "design") Object.assign(body, { figure: typed.figure, greatest: typed.greatest, limits: rows(typed.limits), plane: typed.plane });
  if (fields.includes("hammers")) body.hammers = typed.hammers;
  if (ask === "compare") body.beside = rows(typed.beside);
  if (ask === "identify") Object.assign(body, { blows, given: rows(typed.given) });
  return body;
}

async function run() {
  if (running) return;
  const body = asked();
  running = new AbortController();
  answered = null;
  busy(true);
  put(parts.problem);
  put(parts.answer);
  parts.bar.value = 0;
  put(parts.status, "Starting …");
  try {
    await stream("hammer", body, (event, found) => heard(event, found, body), running.signal);
    if (!answered) put(parts.status, "Not answered.");
  } catch (error) {
    const cancelled = error.name === "AbortError";
    if (!cancelled) put(parts.problem, error.message);
    put(parts.status, cancelled ? "Cancelled." : "Not answered.");
  }
  running = null;
  busy(false);
}

function heard(event, found, body) {
  if (event === "error") return put(parts.problem, new Refusal(0, found.problems).message);
  parts.bar.value = event === "done" ? 1 : found.done;
  if (event === "progress") return put(parts.status, found.told);
  answered = body.case;
  put(parts.status, "Answered.");
  put(
    parts.answer,
    h("p", { class: `note ${found.tone}`, id: "hammer-summary" }, found.summary),
    found.case && h("button", { type: "button", id: "hammer-take", onclick: () => setTables(found.case.tables, found.case) }, "Take these numbers"),
    found.pictures.map(({ svg, caption }) => picture(svg, caption)),
    found.sections.map(section),
  );
}

/** A picture of the server: as an image, nothing in it can act. */
const picture = (svg, caption) =>
  h("figure", {}, h("img", { src: URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" })), alt: caption }), h("figcaption", { class: "small muted" }, caption));

const section = ({ heading, columns, rows: cells }) => [
  h("h3", {}, heading),
  h(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": heading },
    h(
      "table",
      {},
      columns.length > 0 && h("thead", {}, h("tr", {}, columns.map((name) => h("th", { scope: "col" }, name)))),
      h("tbody", {}, cells.map(([first, ...rest]) => h("tr", {}, h("th", { scope: "row" }, first), rest.map((text) => h("td", {}, text))))),
    ),
  ),
];

function busy(on_) {
  if (!parts.go) return;
  parts.go.disabled = on_;
  parts.cancel.disabled = !on_;
}

/** Another case: what is shown is of the case before. */
function changed() {
  running?.abort();
  if (answered && answered !== data.tables) put(parts.status, "The case has changed since: this is the answer for the case before.");
}
