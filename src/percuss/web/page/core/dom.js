// Small helpers for building the page. Text only ever enters as text nodes: nothing from a case becomes markup.

import { begun } from "./under_way.js";

export const $ = (selector, root = document) => root.querySelector(selector);
export const $$ = (selector, root = document) => [...root.querySelectorAll(selector)];

/** An element: attributes (class, data-x, aria-x …), properties by a leading dot, listeners by `on`, then children. */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name.startsWith(".")) element[name.slice(1)] = value;
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  append(element, children);
  return element;
}

function append(element, children) {
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : document.createTextNode(String(child)));
  }
}

/** The children of an element, replaced; an equal text is left alone so that screen readers do not say it twice. The
 * focus goes from a child to the new one of the same name: nobody at the keyboard loses their place. */
export function put(element, ...children) {
  if (children.length === 1 && typeof children[0] === "string") {
    if (element.textContent !== children[0]) element.textContent = children[0];
    return element;
  }
  const here = document.activeElement;
  const name = here !== element && element.contains(here) ? nameOf(here) : "";
  element.replaceChildren();
  append(element, children);
  if (name && !element.contains(document.activeElement))
    $$(here.tagName, element)
      .find((one) => nameOf(one) === name)
      ?.focus({ preventScroll: true });
  return element;
}

const nameOf = (element) => element.id || element.textContent || element.getAttribute("aria-label");

/** A file handed to the user's own downloads, without any server path. */
export function download(blob, name) {
  const link = h("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** A labelled select. */
export function select(label, options, value, onchange, attributes = {}) {
  const box = h(
    "select",
    { ...attributes, onchange: (event) => onchange(event.target.value) },
    options.map(([key, text]) => h("option", { value: key, selected: String(key) === String(value) }, text)),
  );
  return h("label", { class: "pick" }, h("span", {}, label), box);
}

const due = new Set();

/** A function that runs at most once a frame, with its latest arguments. */
export function framed(action) {
  let latest = [];
  let end = null;
  const run = () => due.delete(run) && (end(), action(...latest));
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

/** A function that runs once the next frame is out, at most once a frame: for words beside a picture one waits for. */
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

/** A function that waits until nobody has called it for a while. */
export function settled(action, milliseconds) {
  let timer = 0;
  let end = null;
  return (...args) => {
    clearTimeout(timer);
    end ??= begun("rest");
    timer = setTimeout(() => {
      end();
      end = null;
      action(...args);
    }, milliseconds);
  };
}

/** Only the latest question counts: one is under way, at most one waits; `ask` gets an abort signal. */
export function latest(ask, answered, failed) {
  let busy = false;
  let waiting = null;
  const go = async (question) => {
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
