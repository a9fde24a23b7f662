// The address bar holds the whole state: the view and what the case changes in its machine, as readable words.
//   #panel=map&machine=mini-breaker&load.mean=800 N&contact.restitution=0.3

import { settled } from "./dom.js";
import { DEFAULTS, data, machineTables, on, view } from "./state.js";
import { valueAt, withKey } from "./moves.js";

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

const keysOf = (tables) => [
  ...(tables.title === undefined ? [] : ["title"]),
  ...TABLES.flatMap((table) => Object.keys(tables[table] ?? {}).map((name) => `${table}.${name}`)),
];

function differences(tables, base) {
  const found = [];
  for (const key of keysOf(tables)) {
    const text = written(valueAt(tables, key));
    if (text !== written(valueAt(base, key))) found.push([key, text]);
  }
  for (const key of keysOf(base)) if (valueAt(tables, key) === undefined) found.push([key, ""]);
  return found;
}

const written = (value) => (typeof value === "string" ? value : JSON.stringify(value));

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
 * without a case in the address the one that is `served`, else the machine `fallback`. */
export async function fromAddress(text, fallback, served) {
  const words = new URLSearchParams(text.replace(/^#/, ""));
  const keys = [];
  Object.assign(view, DEFAULTS);
  for (const [name, value] of words) {
    if (name in DEFAULTS) view[name] = typeof DEFAULTS[name] === "number" ? whole(value, DEFAULTS[name]) : value;
    else if (name === "title" || TABLES.includes(name.split(".")[0])) keys.push([name, value]);
  }
  let info = null;
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
  for (const [key, value] of keys) tables = withKey(tables, key, value === "" ? undefined : read(key, value));
  for (const table of TABLES) {
    const inside = tables[table];
    if (inside && !Object.keys(inside).length) delete tables[table];
  }
  return { info, tables };
}

function whole(text, otherwise) {
  const value = Number.parseInt(text, 10);
  return Number.isSafeInteger(value) && value >= 0 ? value : otherwise;
}

let mine = "";

/** Keep the address true; browsers allow few changes a second, so a slider's moves are written when it rests. */
export function keepAddress() {
  on("view tables", settled(writeAddress, 180));
}

export function writeAddress() {
  if (!data.tables) return;
  const text = `#${address()}`;
  if (text === location.hash) return;
  mine = text;
  const before = new URLSearchParams(location.hash.slice(1));
  const same = ["panel", "machine"].every((name) => (before.get(name) ?? DEFAULTS[name]) === view[name]);
  if (!same && location.hash) history.pushState(null, "", text); // Back leads to the panel, and the machine, before
  else history.replaceState(null, "", text);
}

/** Tell when the user changes the address, or goes back. */
export function followAddress(changed) {
  const look = () => {
    if (location.hash !== mine) {
      mine = location.hash;
      changed(location.hash);
    }
  };
  addEventListener("hashchange", look);
  addEventListener("popstate", look);
}
