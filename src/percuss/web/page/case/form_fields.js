// A field of the case form: its label, its input or its choice, its hint and its problem, all by the key that it sets.

import { said } from "../core/api.js";
import { $$, fieldOf, h, menu, put, settled } from "../core/dom.js";
import { typed } from "./fields.js";
import { steps, valueAt } from "../core/moves.js";
import { setKey } from "../core/state.js";

const TYPING = 350; // ms without a key after which what is typed counts

/** @param {string} key */
export const idOf = (key) => `field-${steps(key).join("-")}`;

/** Where the problems of a key are told; an element, empty as long as there are none. @param {string} key */
export const problemOf = (key) => h("div", { class: "problem", id: `${idOf(key)}-problem`, "data-of": key });

/** A text input for a key; `read` makes a value of what is typed.
 * @param {string} key @param {Record<string, any>} attributes @param {(text: string) => any} [read] */
export function input(key, attributes, read = (text) => typed(text, key)) {
  let typing = false;
  const onchange = () => {
    typing = false;
    setKey(key, read(control.value));
  };
  const rested = settled(() => typing && onchange(), TYPING); // half a number is no value; what counts, counts once
  const oninput = () => {
    typing = true;
    rested();
  };
  const own = { type: "text", id: idOf(key), "data-key": key, spellcheck: "false" };
  const control = h("input", { ...own, oninput, onchange, ...attributes });
  return control;
}

/** A field of text. @param {import("./fields.js").Field} field */
export function field([key, label, hint, list]) {
  const read = (/** @type {string} */ text) => (key === "title" ? text || undefined : typed(text, key, list));
  return framed(key, label, input(key, { "aria-describedby": describedBy(key) }, read), hint);
}

/** A choice of [value, words]; a present value that is none of them is offered, too.
 * @param {string} key @param {string} label @param {import("../core/dom.js").Options} options @param {any} present
 * @param {(value: string) => void} change @param {string} hint */
export function choice(key, label, options, present, change, hint) {
  const own = options.some(([value]) => String(value) === String(present)) ? options : [[present, present], ...options];
  const box = menu(own, present, change, { id: idOf(key), "aria-describedby": describedBy(key) });
  return framed(key, label, box, hint);
}

/** @param {string} key */
const describedBy = (key) => `${idOf(key)}-hint ${idOf(key)}-problem`;

/** @param {string} key @param {string} label @param {HTMLElement} control @param {string} hint */
const framed = (key, label, control, hint) =>
  fieldOf(control, label, [h("code", {}, steps(key).at(-1)), ": ", hint], problemOf(key));

/** The fields from the tables; the one that is being typed into is left alone.
 * @param {HTMLElement} form @param {any} tables */
export function fill(form, tables) {
  for (const control of /** @type {HTMLInputElement[]} */ ($$("[data-key]", form))) {
    if (control === document.activeElement) continue;
    const value = valueAt(tables, control.dataset.key ?? "");
    const text = Array.isArray(value) ? value.join(", ") : String(value ?? "");
    if (control.value !== text) control.value = text;
  }
}

/** Each problem beside its field, or that of the table around it; the problems without one are given back.
 * @param {HTMLElement} form @param {import("../core/api.js").Problem[]} problems */
export function tellProblems(form, problems) {
  const places = new Map($$("[data-of]", form).map((place) => [place.dataset.of ?? "", place]));
  const placeOf = (/** @type {string} */ key) => {
    while (key && !places.has(key)) key = key.replace(/(^|\.|\[)[^.[]*$/, "");
    return key;
  };
  const beside = Map.groupBy(problems, ({ key }) => placeOf(key));
  for (const [key, place] of places) {
    const words = (beside.get(key) ?? []).map(said).join(" ");
    put(place, words);
    const control = document.getElementById(idOf(key));
    if (words) control?.setAttribute("aria-invalid", "true");
    else control?.removeAttribute("aria-invalid");
  }
  return beside.get("") ?? [];
}
