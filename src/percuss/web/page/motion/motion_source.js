// Where a motion comes from: a steady motion, or a simulation from a start.

import { saveFile } from "../core/api.js";
import { h, put, select } from "../core/dom.js";
import { fillStart, kindOf, startFields, startProblems } from "./motion_start.js";
import { data, fileName, isHeld, setTables, show, view } from "../core/state.js";

const parts = {};

/** The card with the choices; `said` is where it is told what happens to the file. */
export function sourceCard(said) {
  parts.said = said;
  parts.source = h("div", { class: "card", id: "motion-source" });
  return parts.source;
}

/** Where the motion comes from: a steady motion or a start, as the case's own table [start] has it. */
export function sources() {
  const steady = view.source === "orbit";
  const start = data.tables?.start ?? {};
  const now = JSON.stringify([
    view.source,
    view.window,
    view.cycles,
    view.zoom,
    Boolean(data.tables?.bar),
    isHeld(),
    data.tables?.simulation?.modes,
    kindOf(start),
    start.random,
  ]);
  if (parts.source.dataset.key === now) return fillStart(parts.source, start);
  parts.source.dataset.key = now;
  const pick = (source, text) =>
    h(
      "button",
      { type: "button", "aria-pressed": String(view.source === source), onclick: () => show({ source }) },
      text,
    );
  const segments = h(
    "div",
    { class: "segments", role: "group", "aria-label": "Which motion" },
    pick("orbit", "Steady motion"),
    pick("start", "From a start"),
  );
  const cycles = select(
    "Show",
    [1, 2, 4, 8, 16, 32].map((n) => [
      n,
      n === 1
        ? steady
          ? "one blow's period"
          : "one load period"
        : `${n} ${steady ? "blows' periods" : "load periods"}`,
    ]),
    view.cycles,
    (n) => show({ cycles: Number(n) }),
    { id: "cycles" },
  );
  const zoom = select(
    "Part",
    [
      [0, "all of it"],
      [4, "4 rings of the first mode"],
      [12, "12 rings of the first mode"],
      [40, "40 rings of the first mode"],
    ],
    view.zoom,
    (n) => show({ zoom: Number(n), slow: "" }),
    { id: "zoom-part" },
  );
  put(
    parts.source,
    h("div", { class: "row" }, segments, cycles, zoom, steady ? null : simulation(start)),
    steady ? null : h("div", { class: "row start", id: "start-form" }, startFields(start, sources), keep()),
  );
  fillStart(parts.source, start);
}

/** Problems of the start beside its fields; what has no field there is told below the picture. */
export const sourceProblems = (problems) => startProblems(parts.source, problems);

function simulation(start) {
  const modes = select(
    isHeld() ? "Modes, at most" : "Elastic modes",
    [0, 8, 16, 32, 64].filter((n) => n || !isHeld()).map((n) => [n, n ? String(n) : "0: rigid"]),
    data.tables?.simulation?.modes ?? 32,
    (n) => setSimulation({ modes: Number(n) }),
    { id: "simulation-modes" },
  );
  const stretch = [
    ["start", "from the start"],
    ["settled", "what it settles on"],
  ];
  return [
    select("Stretch", stretch, view.window, (window) => show({ window }), { id: "window" }),
    modes,
  ];
}

const keep = () => h("button", { type: "button", id: "motion-file", onclick: save }, "Save as NetCDF");

const setSimulation = (changes) => setTables({ ...data.tables, simulation: { ...data.tables.simulation, ...changes } });

function save() {
  put(parts.said, "Computing the whole motion …");
  saveFile("simulate/file", { case: data.tables }, `${fileName()}.nc`, parts.said);
}
