// Small helpers for building the page. Text only ever enters as text nodes: nothing from a case becomes markup.

import { begun } from "./under_way.js";
import { tr } from "./words.js";

/** The element of a selector, which is there. @param {string} selector @param {ParentNode} [root] */
export const $ = (selector, root = document) => /** @type {HTMLElement} */ (root.querySelector(selector));
/** @param {string} selector @param {ParentNode} [root] @returns {HTMLElement[]} */
export const $$ = (selector, root = document) => [
  .../** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll(selector)),
];

/** What goes into an element: nodes, texts, lists of them; what is missing or false is left out.
 * @typedef {Node | string | number | boolean | null | undefined | any[]} Child */

/** An element: attributes (class, data-x, aria-x …), properties by a leading dot, listeners by `on`, then children.
 * @template {keyof HTMLElementTagNameMap} T @param {T} tag @param {Record<string, any>} [attributes]
 * @param {Child[]} children @returns {HTMLElementTagNameMap[T]} */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name.startsWith(".")) Object.assign(element, { [name.slice(1)]: value });
    else element.setAttribute(name, value === true ? "" : SAID.has(name) ? tr(String(value)) : String(value));
  }
  append(element, children);
  return element;
}

/** A box: an element of a class around others. @param {string} name @param {Child[]} children */
export const div = (name, ...children) => h("div", { class: name }, ...children);

/** Attributes with words in them. */
const SAID = new Set(["title", "aria-label", "aria-valuetext", "placeholder", "label", "alt"]);

/** Whether the words of an element stay as they are: code, and what a person has written. @param {Element} element */
const isVerbatim = (element) => Boolean(element.closest("pre, code, textarea, [translate=no]"));

/** @param {Element} element @param {Child[]} children */
function append(element, children) {
  const said = isVerbatim(element) ? String : (/** @type {any} */ child) => tr(String(child));
  for (const child of /** @type {Child[]} */ (children.flat(Infinity))) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : document.createTextNode(said(child)));
  }
}

/** The children of an element, replaced; an equal text is left alone so that screen readers do not say it twice. The
 * focus goes from a child to the new one of the same name: nobody at the keyboard loses their place.
 * @template {Element} E @param {E} element @param {Child[]} children */
export function put(element, ...children) {
  if (children.length === 1 && typeof children[0] === "string") {
    const text = isVerbatim(element) ? children[0] : tr(children[0]);
    if (element.textContent !== text) element.textContent = text;
    return element;
  }
  const here = document.activeElement;
  const name = here && here !== element && element.contains(here) ? nameOf(here) : "";
  element.replaceChildren();
  append(element, children);
  if (here && name && !element.contains(document.activeElement))
    $$(here.tagName, element)
      .find((one) => nameOf(one) === name)
      ?.focus({ preventScroll: true });
  return element;
}

/** @param {Element} element */
const nameOf = (element) => element.id || element.textContent || element.getAttribute("aria-label");

/** A file handed to the user's own downloads, without any server path. @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** What a menu offers: what each choice stands for, and its text. @typedef {(string | number)[][]} Options */

/** A menu. @param {Options} options @param {string | number} value
 * @param {(value: string) => void} onchange @param {Record<string, any>} [attributes] */
export function menu(options, value, onchange, attributes = {}) {
  const one = (/** @type {Options[number]} */ [key, text]) =>
    h("option", { value: key, selected: String(key) === String(value) }, text);
  const box = h("select", { ...attributes, onchange: () => onchange(box.value) }, options.map(one));
  return box;
}

/** A menu with its label above it. @param {string} label @param {Parameters<typeof menu>} of */
export const select = (label, ...of) => labelled(label, menu(...of));

/** A control with its label above it. @param {string} label @param {Child} control @param {Child[]} more */
export const labelled = (label, control, ...more) => h("label", { class: "pick" }, h("span", {}, label), control, more);

/** A field: a control with its label, its hint and what is below it; `start` is the class of those in a row.
 * @param {HTMLElement} control @param {string} label @param {Child} hint @param {Child} [below] @param {"" | "start"} [start] */
export const fieldOf = (control, label, hint, below, start = "") =>
  h(
    "div",
    { class: `field ${start}`.trim() },
    h("label", { for: control.id, class: start ? "small muted" : null }, label),
    control,
    h("div", { class: "hint", id: `${control.id}-hint` }, hint),
    below,
  );

/** A button. @param {string} text @param {() => void} onclick @param {Record<string, any>} [attributes] */
export const button = (text, onclick, attributes = {}) => h("button", { type: "button", ...attributes, onclick }, text);

/** Buttons beside each other, of which one is pressed. @param {string} label @param {Child[]} buttons */
export const segments = (label, ...buttons) =>
  h("div", { class: "segments", role: "group", "aria-label": label }, buttons);

/** A list of facts: what each is called, and what it is. @param {(Child[] | false | null | undefined)[]} rows */
export const facts = (rows) =>
  h(
    "dl",
    { class: "facts" },
    rows.map((row) => row && [h("dt", {}, row[0]), h("dd", {}, row[1])]),
  );

/** A table: its heads, and rows of cells, or of a `tr` and `td` of their own. @param {Child[]} heads
 * @param {(Child[] | HTMLTableRowElement)[]} rows @param {Record<string, any>} [attributes] */
export function table(heads, rows, attributes = {}) {
  const cell = (/** @type {Child} */ one) => (one instanceof HTMLTableCellElement ? one : h("td", {}, one));
  const row = (/** @type {Child[] | Node} */ one) => (one instanceof Node ? one : h("tr", {}, one.map(cell)));
  const head = heads.map((one) => (one === "" ? h("td") : h("th", { scope: "col" }, one)));
  return h("table", attributes, head.length > 0 && h("thead", {}, h("tr", {}, head)), h("tbody", {}, rows.map(row)));
}

/** What went wrong, in words that are read out. @param {{ message: string }} error */
export const problem = ({ message }) => h("span", { class: "problem", role: "alert" }, message);

/** Whether things may move by themselves. */
export const movesByItself = () => !matchMedia("(prefers-reduced-motion: reduce)").matches;

/** @type {Set<() => void>} */
const due = new Set();

/** A function that runs at most once a frame, with its latest arguments. @template {any[]} A
 * @param {(...given: A) => void} action @returns {(...given: A) => void} */
export function framed(action) {
  /** @type {any} */
  let latest = [];
  let end = () => {};
  const run = () => void (due.delete(run) && (end(), action(.../** @type {A} */ (latest))));
  return (...args) => {
    latest = args;
    if (due.has(run)) return;
    due.add(run);
    end = begun("frame");
    requestAnimationFrame(run);
  };
}

/** Run what waits for a frame, for there will be none: the page is about to be printed. */
export const flushFrames = () => [...due].forEach((run) => run());

/** A function that runs once the next frame is out, at most once a frame: for words beside a picture one waits for.
 * @param {() => void} action */
export function afterFrame(action) {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    const end = begun("frame");
    requestAnimationFrame(() =>
      setTimeout(() => {
        waiting = false;
        end();
        action();
      }),
    );
  };
}

/** A function that waits until nobody has called it for a while. @template {any[]} A
 * @param {(...given: A) => void} action @param {number} milliseconds @returns {(...given: A) => void} */
export function settled(action, milliseconds) {
  let timer = 0;
  /** @type {(() => void) | null} */
  let end = null;
  return (...args) => {
    clearTimeout(timer);
    end ??= begun("rest");
    timer = setTimeout(() => {
      end?.();
      end = null;
      action(...args);
    }, milliseconds);
  };
}

/** Only the latest question counts: one is under way, at most one waits. @template Q, R
 * @param {(question: Q) => Promise<R>} ask @param {(answer: R, question: Q) => void} answered
 * @param {(error: any, question: Q) => void} failed @returns {(question: Q) => void} */
export function latest(ask, answered, failed) {
  let busy = false;
  /** @type {{ question: Q } | null} */
  let waiting = null;
  const go = async (/** @type {Q} */ question) => {
    busy = true;
    try {
      answered(await ask(question), question);
    } catch (error) {
      failed(error, question);
    }
    busy = false;
    if (waiting) {
      const next = waiting;
      waiting = null;
      go(next.question);
    }
  };
  return (question) => {
    if (busy) waiting = { question };
    else go(question);
  };
}
