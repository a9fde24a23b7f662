// What engineers ask of the whole hammer: the best one, what tolerances do to it, others beside it, its numbers by
// measured blows, and its fatigue. Each answer is a sentence, its pictures and its tables, as a command gives them.

import { differences } from "../core/address.js";
import { button, div, h, labelled, put, select, table } from "../core/dom.js";
import { effect, whenever } from "../core/signals.js";
import { data, setTables, show, view } from "../core/state.js";
import { LongQuestion } from "./long_question.js";

/** @typedef {{ name: string, value: number, low: number, high: number, unit: string, label: string }} Parameter */

/** The questions: their fields; and, where there are ranges, how one is written, and what an empty field means.
 * @type {Record<string, { name: string, fields: string[], label?: string, example?: string,
 *   range?: (one: any) => string }>} */
const QUESTIONS = {
  design: {
    name: "the best hammer within ranges",
    fields: ["goal", "vary", "limits", "hammers", "plane"],
    label: "What may vary, a line each",
    example: "bar.length=300:400mm",
    range: (one) => `${one.name}=${spread(one)}`,
  },
  tolerance: {
    name: "what tolerances do to it",
    fields: ["vary", "hammers"],
    label: "Tolerances, a line each; none: those of the case, or the usual ones of a drawing",
    example: "load.pressure=±10bar",
    range: ({ name }) => `${name}=±5%`,
  },
  compare: { name: "beside others", fields: ["beside"] },
  identify: {
    name: "its numbers from measured blows",
    fields: ["blows", "vary", "given"],
    label: "What is to be found, a line each; none: R and the pressure or the scale of the load",
    example: "contact.restitution",
    range: ({ name }) => name,
  },
  fatigue: { name: "how long its steel lasts", fields: [] },
};

const question = new LongQuestion(
  "hammer",
  "Answer",
  "Every hammer that is looked at has its own cycle, oil, blow and rock.",
);
const answer = h("div", { id: "hammer-answer" });
const blowsOf = h("span", { id: "hammer-blows-of" }); // the name of their file
/** What is chosen; the fields of lines, of ranges by question. */
const chosen = { figure: "rock_power", greatest: true, hammers: 600, plane: false, blows: "" };
/** @type {Record<string, string>} */
const texts = {};
/** The tables that the shown answer is of. @type {any} */
let answered = null;

/** @param {HTMLElement} place */
export function start(place) {
  const onsubmit = (/** @type {Event} */ event) => (event.preventDefault(), run());
  const form = h("form", { id: "hammer-form", onsubmit });
  put(
    place,
    div("card", h("h2", {}, "Questions about the whole hammer"), form, question.problem),
    div("card", question.bar, question.status, answer),
  );
  const names = () => data.info.parameters.map((/** @type {Parameter} */ { name }) => name);
  whenever(
    () => view.panel === "hammer" && data.about && data.info && [asking(), names()],
    () => {
      const questions = Object.entries(QUESTIONS).map(([name, { name: words }]) => [name, words]);
      const pick = select("Question", questions, asking(), (ask) => show({ ask }), { id: "hammer-question" });
      const fields = QUESTIONS[asking()].fields.map((name) => FIELDS[name]());
      put(form, div("row", pick), fields, div("row", question.go, question.cancel));
    },
  );
  effect(() => {
    const { tables } = data;
    question.running?.abort();
    if (answered && answered !== tables)
      put(question.status, "The case has changed since: this is the answer for the case before.");
  });
  let ofA = ""; // the line that stands for the design that is pinned: the first of the others
  effect(() => {
    const { tables } = data.pinned ?? {};
    const changes = tables ? differences(tables, data.tables) : [];
    const line = changes.map(([key, value]) => `${key}=${value}`).join(", ");
    if (line === ofA) return;
    const others = rows("beside").filter((one) => one !== ofA);
    ofA = line;
    texts.beside = [line, ...others].filter(Boolean).join("\n");
    const area = /** @type {HTMLTextAreaElement | null} */ (document.getElementById("hammer-beside"));
    if (area) area.value = texts.beside;
  });
}

const asking = () => (view.ask in QUESTIONS ? view.ask : "design");
/** The lines of a field. @param {string} name */
const rows = (name) => (texts[name] ?? "").split("\n").flatMap((line) => line.trim() || []);

/** Measured blows, picked or dropped anywhere: the question is which numbers fit them.
 * @param {string} text @param {string} name */
export function takeBlows(text, name) {
  chosen.blows = text;
  put(blowsOf, name);
  show({ panel: "hammer", ask: "identify" });
}

/** A range of ten per cent about what the case has, in the unit of the case. @param {Parameter} parameter */
function spread({ value, low, high, unit }) {
  const [from, to] = value ? [0.9 * value, 1.1 * value].sort((a, b) => a - b) : [low, high];
  const digits = (/** @type {number} */ x) => String(Number(x.toPrecision(4)));
  return `${digits(from)}:${digits(to)}${unit ? ` ${unit}` : ""}`;
}

/** A field of lines of text, and a choice that adds one.
 * @param {string} name @param {string} label @param {string} example
 * @param {{ label: string, options: import("../core/dom.js").Options, line: (name: string) => string }} [add]
 * @param {string} [kept] */
function lines(name, label, example, add, kept = name) {
  const id = `hammer-${name}`;
  const keep = () => (texts[kept] = area.value);
  const own = { id, rows: 3, placeholder: example, spellcheck: "false", ".value": texts[kept] ?? "" };
  const area = h("textarea", { ...own, oninput: keep });
  const more = (/** @type {string} */ one) => {
    if (!one || !add) return;
    area.value = [area.value.trimEnd(), add.line(one)].filter(Boolean).join("\n");
    keep();
    area.focus();
  };
  const adding = add && select(add.label, [["", "…"], ...add.options], "", more, { id: `${id}-add` });
  return div("lines", labelled(label, area), adding);
}

/** @returns {import("../core/dom.js").Options} */
const figures = () => data.about.figures.map((/** @type {any} */ { name, label }) => [name, label]);

/** @param {number} size */
const whole = (size) => Math.min(10000, Math.max(20, Math.round(size) || 600));

/** The controls of the fields, by name. @type {Record<string, () => HTMLElement>} */
const FIELDS = {
  goal: () => {
    const sense = (/** @type {string} */ word) => (chosen.greatest = word === "most");
    const figure = (/** @type {string} */ name) => (chosen.figure = name);
    const senses = ["most", "least"].map((word) => [word, word]);
    return div(
      "row",
      select("The", senses, chosen.greatest ? "most" : "least", sense, { id: "hammer-sense" }),
      select("Figure", figures(), chosen.figure, figure, { id: "hammer-figure" }),
    );
  },
  vary: () => {
    const { label = "", example = "", range = String } = QUESTIONS[asking()];
    const known = new Map(data.info.parameters.map((/** @type {Parameter} */ one) => [one.name, one]));
    const keys = [...known.values()].filter(({ name }) => name.includes("."));
    const options = keys.map((one) => [one.name, `${one.label} (${one.name})`]);
    const line = (/** @type {string} */ name) => range(known.get(name));
    return lines("vary", label, example, { label: "Add a number", options, line }, `vary ${asking()}`);
  },
  limits: () => {
    const add = { label: "Add a limit", options: figures(), line: (/** @type {string} */ name) => `${name}<` };
    return lines("limits", "Limits, a line each", "steel.stress<400MPa", add);
  },
  hammers: () => {
    const own = {
      type: "number",
      id: "hammer-hammers",
      min: 20,
      max: 10000,
      step: 1,
      ".value": String(chosen.hammers),
    };
    const input = h("input", { ...own, onchange: () => (chosen.hammers = whole(Number(input.value))) });
    return labelled("Hammers, about", input);
  },
  plane: () => {
    const onchange = () => (chosen.plane = tick.checked);
    const tick = h("input", { type: "checkbox", id: "hammer-plane", ".checked": chosen.plane, onchange });
    const words = "with a map of the first two ranges: which hammers keep the limits";
    return h("label", { class: "row middle" }, tick, words);
  },
  beside: () => {
    const options = data.machines.map((/** @type {any} */ { name, title }) => [name, title ?? name]);
    const add = { label: "Add a machine", options, line: String };
    const label = "Others, a line each: a machine, or other numbers of the case";
    return lines("beside", label, "contact.restitution=0.3", add);
  },
  given: () => lines("given", "What is only given, and how far it may be off, a line each", "bar.diameter=±0.2mm"),
  blows: () => {
    const onchange = async () => takeBlows((await input.files?.[0]?.text()) ?? "", input.files?.[0]?.name ?? "");
    const input = h("input", { type: "file", id: "hammer-blows", accept: ".csv,.txt,text/csv", onchange });
    const label = "Measured blows, a row each, as CSV: time [s], rebound speed [m/s], …";
    return labelled(label, input, blowsOf);
  },
};

/** What a field adds to the question. @param {string} name */
function bodyOf(name) {
  if (name === "goal") return { figure: chosen.figure, greatest: chosen.greatest };
  if (name === "vary") return { vary: rows(`vary ${asking()}`) };
  return { [name]: name in chosen ? /** @type {any} */ (chosen)[name] : rows(name) };
}

async function run() {
  if (question.running) return;
  const body = { case: data.tables, question: asking() };
  Object.assign(body, ...QUESTIONS[asking()].fields.map(bodyOf));
  answered = null;
  put(answer);
  const how = await question.ask("hammer", body, (event, found) => {
    if (event === "progress") return put(question.status, found.told);
    answered = body.case;
    put(question.status, "Answered.");
    const take = () => setTables(found.case.tables, found.case);
    put(
      answer,
      h("p", { class: `note ${found.tone}`, id: "hammer-summary" }, found.summary),
      found.case && button("Take these numbers", take, { id: "hammer-take" }),
      found.pictures.map(picture),
      found.sections.map(section),
    );
  });
  if (how !== "answered") put(question.status, how === "cancelled" ? "Cancelled." : "Not answered.");
}

/** A picture of the server: as an image, nothing in it can act. @param {{ svg: string, caption: string }} picture */
const picture = ({ svg, caption }) =>
  h(
    "figure",
    {},
    h("img", { src: URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" })), alt: caption }),
    h("figcaption", { class: "small muted" }, caption),
  );

/** @param {{ heading: string, columns: string[], rows: string[][] }} section */
const section = ({ heading, columns, rows: cells }) => [
  h("h3", {}, heading),
  h(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": heading },
    table(
      columns,
      cells.map(([first, ...rest]) => [h("th", { scope: "row" }, first), ...rest]),
    ),
  ),
];
