// The address bar holds the whole state: the view and what the case changes in its machine, as readable words.
//   #panel=map&machine=mini-breaker&load.mean=800 N&contact.restitution=0.3

import { settled } from "./dom.js";
import { effect, signal } from "./signals.js";
import { DEFAULTS, data, machineTables, view } from "./state.js";
import { inOwnUnit, valueAt, withKey } from "./moves.js";

const TABLES = ["system", "bar", "body", "contact", "load", "tool", "rock", "blow", "start", "simulation"];

/** The state as the text behind the #. */
export function address() {
  const words = new URLSearchParams();
  for (const [name, value] of Object.entries(view)) {
    if (String(value) !== String(DEFAULTS[name])) words.set(name, String(value));
  }
  for (const [key, value] of differences(data.tables ?? {}, view.machine ? (data.base ?? {}) : {}))
    words.set(key, value);
  // readable: these characters need no escape in a fragment
  return words
    .toString()
    .replaceAll("%5B", "[")
    .replaceAll("%5D", "]")
    .replaceAll("%2C", ",")
    .replaceAll("%2F", "/")
    .replaceAll("%3A", ":");
}

/** @typedef {import("./moves.js").Tables} Tables */

const keysOf = (/** @type {Tables} */ tables) => [
  ...(tables.title === undefined ? [] : ["title"]),
  ...TABLES.flatMap((table) => Object.keys(tables[table] ?? {}).map((name) => `${table}.${name}`)),
];

/** What one case has other than another: [key, its text, the other's text], "" for none. @param {Tables} tables @param {Tables} base
 * @returns {[key: string, text: string, other: string][]} */
export function differences(tables, base) {
  /** @type {[string, string, string][]} */
  const found = [];
  for (const key of keysOf(tables)) {
    const [text, other] = [tables, base].map((one) => written(valueAt(one, key)) ?? "");
    if (text !== other) found.push([key, text, other]);
  }
  for (const key of keysOf(base))
    if (valueAt(tables, key) === undefined) found.push([key, "", written(valueAt(base, key))]);
  return found;
}

const written = (/** @type {any} */ value) => (typeof value === "string" ? value : JSON.stringify(value));

/** @param {string} key @param {string} text */
function read(key, text) {
  if (key === "title") return text;
  if (/^([-+.\d]|\[|\{|true$|false$)/.test(text)) {
    try {
      return JSON.parse(text);
    } catch {
      return text; // "341 mm"
    }
  }
  return text;
}

/** Read the address into `view`. The case that it stands for, {info?, tables}, with `info` when a machine is behind it;
 * without a case in the address the one that is `served`, else the machine `fallback`; `base` is the case before the
 * changes that the address tells, of an own case the one that its step of the history keeps. @param {string} text @param {string} fallback @param {() => Promise<any>} served */
export async function fromAddress(text, fallback, served) {
  const words = new URLSearchParams([location.search.slice(1), text.replace(/^#/, "")].filter(Boolean).join("&"));
  /** @type {[string, string][]} */
  const keys = [];
  Object.assign(view, DEFAULTS);
  for (const [name, value] of words) {
    if (name in DEFAULTS) view[name] = typeof DEFAULTS[name] === "number" ? whole(value, DEFAULTS[name]) : value;
    else if (name === "title" || TABLES.includes(name.split(".")[0])) keys.push([name, value]);
  }
  let info = null;
  /** @type {Tables} */
  let tables = {};
  if (!view.machine && !keys.length) {
    const own = await served();
    if (own) ({ tables } = own);
    else view.machine = fallback;
  }
  if (view.machine) {
    info = await machineTables(view.machine);
    tables = info.tables;
  }
  const plain = keys.some(([key]) => key.startsWith("system.")); // the dimensionless form of a machine has no units
  for (const [key, value] of keys) {
    const given = value === "" ? undefined : read(key, value);
    tables = withKey(tables, key, plain ? given : inOwnUnit(given, valueAt(tables, key)));
  }
  for (const table of TABLES) {
    const inside = tables[table];
    if (inside && !Object.keys(inside).length) delete tables[table];
  }
  return { info, tables, base: info?.tables ?? (history.state?.base === undefined ? tables : history.state.base) };
}

/** @param {string} text @param {number} otherwise */
function whole(text, otherwise) {
  const value = Number.parseInt(text, 10);
  return Number.isSafeInteger(value) && value >= 0 ? value : otherwise;
}

let mine = ""; // the address that the page itself has written
let step = 0; // of the designs that Back goes through
let last = 0; // the latest of them
let gesture = 0; // counts what the user does: a drag, a key, a click
let told = { gesture: 0, design: "" };

/** Whether there is a design to go back to, and one to go forth to. */
export const undone = signal({ back: false, forth: false });

export const undo = () => step > 0 && history.back();
export const redo = () => step < last && history.forward();

const tellSteps = () => (undone.value = { back: step > 0, forth: step < last });

/** The part of the address that is the design; the rest is how it is looked at. */
const designOf = (/** @type {string} */ text) =>
  [...new URLSearchParams(text.replace(/^#/, ""))]
    .filter(([name]) => ["machine", "m", "title"].includes(name) || TABLES.includes(name.split(".")[0]))
    .join("&");

/** Whether an event begins a gesture: letting a slider go ends one, and what is typed into a field is one. @param {any} event */
function begins({ type, target, key, repeat }) {
  if (type === "change") return target.type !== "range";
  const typed = type === "keydown" && /^(text|number|textarea)$/.test(target.type);
  return !repeat && (!typed || /^(Arrow|Enter)/.test(key));
}

/** Number the entry of the browser's history that is shown. */
const keepStep = (/** @type {number} */ number) =>
  history.replaceState({ ...history.state, step: (step = number) }, "");

/** Keep the address true; browsers allow few changes a second, so a slider's moves are written when it rests. */
export function keepAddress() {
  for (const kind of ["pointerdown", "keydown", "change", "drop"])
    addEventListener(kind, (event) => (gesture += begins(event) ? 1 : 0), true);
  keepStep(history.state?.step ?? 0);
  last = Math.max(step, Number(sessionStorage.getItem("percuss-steps") ?? 0));
  told = { gesture, design: designOf(location.hash || `#${address()}`) };
  tellSteps();
  effect(writeAddress, (write) => settled(write, 180));
}

/** Each design is a step of the browser's own history, one a gesture: Back, and undo, lead to the one before. */
export function writeAddress() {
  if (!data.tables) return;
  const text = `#${address()}`;
  if (text === location.hash) return;
  mine = text;
  const design = designOf(text);
  const another = design !== told.design && gesture !== told.gesture && location.hash;
  if (another) last = step += 1;
  if (design !== told.design) told = { gesture, design };
  const base = view.machine ? undefined : data.base;
  history[another ? "pushState" : "replaceState"]({ step, base }, "", text);
  sessionStorage.setItem("percuss-steps", String(last));
  tellSteps();
}

/** Tell when the user changes the address, or goes back. @param {(hash: string) => void} changed */
export function followAddress(changed) {
  const look = () => {
    if (location.hash === mine) return;
    mine = location.hash;
    if (history.state) ({ step } = history.state);
    else keepStep((last = step + 1)); // an address that was typed
    told = { gesture, design: designOf(mine) };
    tellSteps();
    changed(location.hash);
  };
  addEventListener("hashchange", look);
  addEventListener("popstate", look);
}
