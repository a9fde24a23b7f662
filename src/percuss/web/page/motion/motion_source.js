// Where a motion comes from: a steady motion, or a simulation from a start as the case's table [start] has it: at rest,
// moving, with modes, on a steady motion, or random.

import { said, saveFile } from "../core/api.js";
import { $, $$, button, div, fieldOf, h, put, segments, select } from "../core/dom.js";
import { effect, whenever } from "../core/signals.js";
import { chosen, data, fileName, isHeld, setStart, setTables, show, view } from "../core/state.js";
import { typed } from "../case/fields.js";

/** The table [start]. @typedef {Record<string, any>} Start */

/** The kinds of starts: what each is called, and its keys. @type {Record<string, [string, string[]]>} */
const KINDS = {
  rest: ["at rest", ["position", "time"]],
  moving: ["moving", ["position", "velocity", "time"]],
  modal: ["with modes", ["modal_displacement", "modal_velocity", "time"]],
  orbit: ["on a steady motion", ["orbit", "periods", "position", "velocity"]],
  random: ["random", ["random", "seed", "time"]],
};

/** A field: its label, its hint in SI and in plain numbers, its width in characters.
 * @typedef {[string, string, string, number]} Field */

/** @type {Record<string, Field>} */
const FIELDS = {
  position: ["Position", "0 at the wall; −20 mm, or in bar lengths", "0 at the wall; in bar lengths", 9],
  velocity: ["Velocity", "toward the wall; 2 m/s, or in lengths per radian", "toward the wall; lengths per radian", 9],
  time: ["Load phase", "rad, or a time as 1.2 ms; 0 when empty", "rad; 0 when empty", 9],
  modal_displacement: ["Modes, displacement", "u₀, u₁, … in bar lengths", "u₀, u₁, … in bar lengths", 18],
  modal_velocity: ["Modes, velocity", "u₀′, u₁′, … in lengths per radian", "u₀′, u₁′, … in lengths per radian", 18],
  orbit: ["Motion", "1, 2 … as in the table of orbits", "1, 2 … as in the table of orbits", 5],
  periods: ["Load periods per blow", "1 when empty", "1 when empty", 5],
  seed: ["Seed", "the same seed gives the same start", "the same seed gives the same start", 7],
};
/** Beside a steady motion. @type {Record<string, Field>} */
const DISTURBANCE = {
  position: ["Moved off by", "0 when empty; −1 mm, or in bar lengths", "0 when empty; in bar lengths", 9],
  velocity: [
    "Pushed by",
    "toward the wall; 0.1 m/s, or in lengths per radian",
    "toward the wall; lengths per radian",
    9,
  ],
};
/** @type {Record<string, string>} */
const DRAWN = { rigid: "rigid", still: "rigid, at rest", ringing: "ringing" };

const card = h("div", { class: "card", id: "motion-source" });
const startNow = () => data.tables?.start ?? {};

/** The card with the choices; what happens to a file is told in `status`. @param {HTMLElement} status */
export function sourceCard(status) {
  const shape = () => {
    const { bar, simulation } = data.tables;
    const kind = kindOf(startNow());
    const start = [kind, keysOf(kind, startNow()), startNow().random];
    return [view.source, view.window, view.cycles, view.zoom, Boolean(bar), isHeld(), simulation?.modes, start];
  };
  whenever(
    () => data.tables && shape(),
    () => (build(status), fillStart()),
  );
  effect(() => data.tables && fillStart());
  return card;
}

/** @param {HTMLElement} status */
function build(status) {
  const steady = view.source === "orbit";
  const one = (/** @type {string} */ source, /** @type {string} */ text) =>
    button(text, () => show({ source }), { "aria-pressed": String(view.source === source) });
  const stretch = (/** @type {number} */ n) => {
    if (n === 1) return steady ? "one blow's period" : "one load period";
    return `${n} ${steady ? "blows' periods" : "load periods"}`;
  };
  const cycles = [1, 2, 4, 8, 16, 32].map((n) => [n, stretch(n)]);
  const zooms = [0, 4, 12, 40].map((n) => [n, n ? `${n} rings of the first mode` : "all of it"]);
  const save = () => {
    put(status, "Computing the whole motion …");
    saveFile("simulate/file", { case: data.tables }, `${fileName()}.nc`, status);
  };
  const choices = [
    segments("Which motion", one("orbit", "Steady motion"), one("start", "From a start")),
    select("Show", cycles, view.cycles, (n) => show({ cycles: Number(n) }), { id: "cycles" }),
    select("Part", zooms, view.zoom, (n) => show({ zoom: Number(n), slow: "" }), { id: "zoom-part" }),
  ];
  put(
    card,
    div("row", choices, !steady && simulation()),
    !steady &&
      h(
        "div",
        { class: "row start", id: "start-form" },
        startFields(),
        button("Save as NetCDF", save, { id: "motion-file" }),
      ),
  );
}

function simulation() {
  const held = isHeld();
  const modes = [0, 8, 16, 32, 64].filter((n) => n || !held).map((n) => [n, n ? String(n) : "0: rigid"]);
  const now = data.tables.simulation;
  const set = (/** @type {string} */ n) =>
    setTables({ ...data.tables, simulation: { ...data.tables.simulation, modes: Number(n) } });
  const windows = [
    ["start", "from the start"],
    ["settled", "what it settles on"],
  ];
  return [
    select("Stretch", windows, view.window, (window) => show({ window }), { id: "window" }),
    select(held ? "Modes, at most" : "Elastic modes", modes, now?.modes ?? 32, set, { id: "simulation-modes" }),
  ];
}

/** @param {Start} start */
function kindOf(start) {
  if (start.random !== undefined) return "random";
  if (start.orbit !== undefined || start.periods !== undefined) return "orbit";
  if (start.modal_displacement !== undefined || start.modal_velocity !== undefined) return "modal";
  return start.velocity === undefined ? "rest" : "moving";
}

/** What a start of a kind begins with; what the one before has in common with it is kept.
 * @param {string} kind @param {Start} start @returns {Start} */
function begun(kind, start) {
  const time = start.time === undefined || kind === "orbit" ? {} : { time: start.time };
  const { position = -1, velocity = 0 } = start.orbit === undefined ? start : {}; // beside it they are a disturbance
  if (kind === "rest") return { position, ...time };
  if (kind === "moving") return { position, velocity, ...time };
  if (kind === "modal") return { modal_displacement: [-0.5, 0.001], ...time };
  if (kind === "orbit") return { orbit: chosen()?.number ?? 1, periods: view.m };
  return { random: "rigid", seed: start.seed ?? 1, ...time };
}

/** The keys of a kind that have a field; a disturbance is of the whole bar unless a file gives its modes.
 * @param {string} kind @param {Start} start */
function keysOf(kind, start) {
  const modes = start.modal_displacement !== undefined || start.modal_velocity !== undefined;
  return kind === "orbit" && modes ? ["orbit", "periods", ...KINDS.modal[1].slice(0, 2)] : KINDS[kind][1];
}

/** The fields of the present start. */
function startFields() {
  const start = startNow();
  const kind = kindOf(start);
  const kinds = Object.entries(KINDS).map(([name, [text]]) => [name, text]);
  const set = (/** @type {string} */ key, /** @type {any} */ value) => setStart({ ...startNow(), [key]: value });
  const drawn = () =>
    select("Drawn", Object.entries(DRAWN), start.random, (name) => set("random", name), { id: "start-random" });
  const field = (/** @type {string} */ key) => {
    const [label, si, plain, size] = (kind === "orbit" && DISTURBANCE[key]) || FIELDS[key];
    const id = `start-${key}`;
    const about = { "aria-describedby": `${id}-hint ${id}-problem`, spellcheck: "false", autocomplete: "off" };
    const onchange = () => set(key, typed(input.value, key));
    const input = h("input", { type: "text", id, size, "data-start": key, ...about, onchange });
    const below = h("div", { class: "problem", id: `${id}-problem` });
    return fieldOf(input, label, data.tables.bar ? si : plain, below, "start");
  };
  return [
    select("Start", kinds, kind, (name) => setStart(begun(name, startNow())), { id: "start-kind" }),
    keysOf(kind, start).map((key) => (key === "random" ? drawn() : field(key))),
  ];
}

const inputs = () => /** @type {HTMLInputElement[]} */ ($$("input[data-start]", card));

/** The fields from the table; the one that is being typed into is left alone. */
function fillStart() {
  for (const input of inputs()) {
    const value = startNow()[input.dataset.start ?? ""];
    if (input !== document.activeElement) input.value = Array.isArray(value) ? value.join(", ") : String(value ?? "");
  }
}

/** Each problem of the start beside its field. True when every one has found its place.
 * @param {import("../core/api.js").Problem[]} problems */
export function sourceProblems(problems) {
  const beside = Map.groupBy(problems, ({ key }) => key.replace(/^start\./, "").replace(/\[.*$/, ""));
  for (const input of inputs()) {
    const own = beside.get(input.dataset.start ?? "");
    put($(`#${input.id}-problem`, card), (own ?? []).map(said).join(" "));
    if (own) input.setAttribute("aria-invalid", "true");
    else input.removeAttribute("aria-invalid");
  }
  return problems.length > 0 && [...beside.keys()].every((key) => $(`#start-${key}-problem`, card));
}
