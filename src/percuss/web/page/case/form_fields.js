// A field of the case form: its label, its input or its choice, its hint and its problem, all by the key that it sets.

import { $$, h, put } from "../core/dom.js";
import { typed } from "./fields.js";
import { steps, valueAt } from "../core/moves.js";
import { data, setKey } from "../core/state.js";

export const idOf = (key) => `field-${steps(key).join("-")}`;

/** Where the problems of a key are told; an element, empty as long as there are none. */
export const problemOf = (key) => h("div", { class: "problem", id: `${idOf(key)}-problem`, "data-of": key });

/** A text input for a key; `list` makes a list of what is typed. */
export function input(key, attributes = {}, list = false) {
  const value = (text) => (key === "title" ? text || undefined : typed(text, key, list));
  return h("input", {
    type: "text",
    id: idOf(key),
    "data-key": key,
    spellcheck: "false",
    oninput: (event) => setKey(key, value(event.target.value)),
    ...attributes,
  });
}

export function field([key, label, hint, list]) {
  return framed(key, label, input(key, { "aria-describedby": describedBy(key) }, list), hint);
}

/** A choice of [value, words]; a present value that is none of them is offered, too. */
export function choice(key, label, options, present, change, hint) {
  const own = options.some(([value]) => String(value) === String(present)) ? options : [[present, present], ...options];
  const box = h(
    "select",
    { id: idOf(key), "aria-describedby": describedBy(key), onchange: (event) => change(event.target.value) },
    own.map(([value, words]) => h("option", { value, selected: String(value) === String(present) }, words)),
  );
  return framed(key, label, box, hint);
}

const describedBy = (key) => `${idOf(key)}-hint ${idOf(key)}-problem`;

const framed = (key, label, control, hint) =>
  h(
    "div",
    { class: "field" },
    h("label", { for: idOf(key) }, label),
    control,
    h("div", { class: "hint", id: `${idOf(key)}-hint` }, h("code", {}, steps(key).at(-1)), ": ", hint),
    problemOf(key),
  );

/** The fields from the tables; the one that is being typed into is left alone. */
export function fill(form) {
  for (const control of $$("[data-key]", form)) {
    if (control === document.activeElement) continue;
    const value = valueAt(data.tables, control.dataset.key);
    const text = value === undefined || value === null ? "" : Array.isArray(value) ? value.join(", ") : String(value);
    if (control.value !== text) control.value = text;
  }
}

/** Each problem beside its field, or that of the table around it; the problems without one are given back. */
export function tellProblems(form, problems, said) {
  const places = new Map($$("[data-of]", form).map((place) => [place.dataset.of, place]));
  const beside = new Map();
  const general = [];
  for (const problem of problems) {
    let { key } = problem;
    while (key && !places.has(key)) key = key.replace(/(^|\.|\[)[^.[]*$/, "");
    if (key) beside.set(key, [...(beside.get(key) ?? []), problem]);
    else general.push(problem);
  }
  for (const [key, place] of places) {
    const words = (beside.get(key) ?? []).map(said).join(" ");
    put(place, words);
    const control = document.getElementById(idOf(key));
    if (control) words ? control.setAttribute("aria-invalid", "true") : control.removeAttribute("aria-invalid");
  }
  return general;
}
