// The start of a simulation as the table [start] has it: at rest, moving, with modes, on a steady motion, or random.

import { $$, h, put, select } from "../core/dom.js";
import { typed } from "../case/fields.js";
import { chosen, data, setTables, view } from "../core/state.js";

const KINDS = {
  rest: ["at rest", ["position", "time"]],
  moving: ["moving", ["position", "velocity", "time"]],
  modal: ["with modes", ["modal_displacement", "modal_velocity", "time"]],
  orbit: ["on a steady motion", ["orbit", "periods", "position", "velocity"]],
  random: ["random", ["random", "seed", "time"]],
};

// [label, hint in SI, hint in plain numbers, width in characters]
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
const DISTURBANCE = {
  position: ["Moved off by", "0 when empty; −1 mm, or in bar lengths", "0 when empty; in bar lengths", 9],
  velocity: ["Pushed by", "toward the wall; 0.1 m/s, or in lengths per radian", "toward the wall; lengths per radian", 9],
};
const DRAWN = { rigid: "rigid", still: "rigid, at rest", ringing: "ringing" };

export function kindOf(start) {
  if (start.random !== undefined) return "random";
  if (start.orbit !== undefined || start.periods !== undefined) return "orbit";
  if (start.modal_displacement !== undefined || start.modal_velocity !== undefined) return "modal";
  return start.velocity === undefined ? "rest" : "moving";
}

/** What a start of a kind begins with; what the one before has in common with it is kept. */
function begun(kind, start) {
  const time = start.time === undefined || kind === "orbit" ? {} : { time: start.time };
  const { position = -1, velocity = 0 } = start.orbit === undefined ? start : {}; // beside it they are a disturbance
  if (kind === "rest") return { position, ...time };
  if (kind === "moving") return { position, velocity, ...time };
  if (kind === "modal") return { modal_displacement: [-0.5, 0.001], ...time };
  if (kind === "orbit") return { orbit: chosen()?.number ?? 1, periods: view.m };
  return { random: "rigid", seed: start.seed ?? 1, ...time };
}

/** The keys of a kind that have a field; a disturbance is of the whole bar unless a file gives its modes. */
function keysOf(kind, start) {
  const modes = start.modal_displacement !== undefined || start.modal_velocity !== undefined;
  return kind === "orbit" && modes ? ["orbit", "periods", ...KINDS.modal[1].slice(0, 2)] : KINDS[kind][1];
}

/** The fields of the present start; `changed` is called when it is another one. */
export function startFields(start, changed) {
  const kind = kindOf(start);
  const put_ = (next) => (setStart(next), changed());
  const kinds = Object.entries(KINDS).map(([name, [text]]) => [name, text]);
  const set = (key, value) => put_({ ...data.tables.start, [key]: value });
  return [
    select("Start", kinds, kind, (name) => put_(begun(name, data.tables.start ?? {})), { id: "start-kind" }),
    keysOf(kind, start).map((key) =>
      key === "random"
        ? select("Drawn", Object.entries(DRAWN), start.random, (name) => set("random", name), { id: "start-random" })
        : field(key, set, kind),
    ),
  ];
}

function field(key, set, kind) {
  const [label, si, plain, size] = (kind === "orbit" && DISTURBANCE[key]) || FIELDS[key];
  const id = `start-${key}`;
  const about = { "aria-describedby": `${id}-hint ${id}-problem`, spellcheck: "false", autocomplete: "off" };
  const onchange = (event) => set(key, typed(event.target.value, key));
  return h(
    "div",
    { class: "field start" },
    h("label", { for: id, class: "small muted" }, label),
    h("input", { type: "text", id, size, "data-start": key, ...about, onchange }),
    h("div", { class: "hint", id: `${id}-hint` }, data.tables?.bar ? si : plain),
    h("div", { class: "problem", id: `${id}-problem` }),
  );
}

/** The fields from the table; the one that is being typed into is left alone. */
export function fillStart(card, start) {
  for (const input of $$("input[data-start]", card)) {
    const value = start[input.dataset.start];
    if (input !== document.activeElement) input.value = Array.isArray(value) ? value.join(", ") : String(value ?? "");
  }
}

/** Each problem beside its field. True when every one has found its place. */
export function startProblems(card, problems) {
  const keyOf = (problem) => problem.key.replace(/^start\./, "").replace(/\[.*$/, "");
  for (const input of $$("input[data-start]", card)) {
    const words = problems.filter((problem) => keyOf(problem) === input.dataset.start);
    put(
      document.getElementById(`${input.id}-problem`),
      words.map(({ message, remedy }) => [message, remedy].filter(Boolean).join(" — ")).join(" "),
    );
    input.toggleAttribute("aria-invalid", words.length > 0);
    if (words.length) input.setAttribute("aria-invalid", "true");
  }
  return problems.length > 0 && problems.every((p) => document.getElementById(`start-${keyOf(p)}-problem`));
}

export function setStart(start) {
  const clean = Object.fromEntries(Object.entries(start).filter(([, value]) => value !== undefined));
  const rest = { ...data.tables };
  delete rest.start;
  setTables(Object.keys(clean).length ? { ...rest, start: clean } : rest);
}
