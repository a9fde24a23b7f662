// Where a motion comes from: a steady motion, or a simulation from a start.

import { postFile } from "./api.js";
import { fileName } from "./case_files.js";
import { download, h, put, select } from "./dom.js";
import { typed } from "./fields.js";
import { data, setTables, show, view } from "./state.js";

const parts = {};

/** The card with the choices; `said` shows what happens to the file. */
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
    Object.keys(start).join(),
    start.random,
  ]);
  if (parts.source.dataset.key === now) return fill(start);
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
      [4, "4 rings of the bar"],
      [12, "12 rings of the bar"],
      [40, "40 rings of the bar"],
    ],
    view.zoom,
    (n) => show({ zoom: Number(n), slow: "" }),
    { id: "zoom-part" },
  );
  put(parts.source, h("div", { class: "row" }, segments, cycles, zoom, steady ? null : simulation(start)));
  fill(start);
}

function simulation(start) {
  const kind = start.random ?? (start.orbit ? "orbit" : "own");
  const kinds = [
    ["own", "chosen"],
    ["rigid", "random"],
    ["still", "random, at rest"],
    ["ringing", "random, ringing"],
  ];
  const change = (value) => setStart(value === "own" ? undefined : { random: value, seed: start.seed ?? 1 });
  const box = (name, label) =>
    h(
      "label",
      { class: "pick" },
      h("span", {}, label),
      h("input", {
        type: "text",
        size: 9,
        "data-start": name,
        id: `start-${name}`,
        onchange: (event) => setStart({ ...data.tables.start, [name]: typed(event.target.value) }),
      }),
    );
  const own = [box("position", "Position"), box("velocity", "Velocity"), box("time", "Load phase, rad")];
  const modes = select(
    "Elastic modes",
    [0, 8, 16, 32, 64].map((n) => [n, n ? String(n) : "0: rigid"]),
    data.tables?.simulation?.modes ?? 32,
    (n) => setSimulation({ modes: Number(n) }),
    { id: "simulation-modes" },
  );
  return [
    select(
      "Stretch",
      [
        ["start", "from the start"],
        ["settled", "what it settles on"],
      ],
      view.window,
      (window) => show({ window }),
      { id: "window" },
    ),
    select("Start", kinds, kind, change, { id: "start-kind" }),
    kind === "own" ? own : box("seed", "Seed"),
    modes,
    h("button", { type: "button", id: "motion-file", onclick: save }, "Save as NetCDF"),
  ];
}

function fill(start) {
  for (const input of parts.source.querySelectorAll("input[data-start]")) {
    if (input !== document.activeElement) input.value = String(start[input.dataset.start] ?? "");
  }
}

export function setStart(start) {
  const clean = start && Object.fromEntries(Object.entries(start).filter(([, value]) => value !== undefined));
  const rest = { ...data.tables };
  delete rest.start;
  setTables(clean && Object.keys(clean).length ? { ...rest, start: clean } : rest);
  sources();
}

const setSimulation = (changes) => setTables({ ...data.tables, simulation: { ...data.tables.simulation, ...changes } });

async function save() {
  parts.said("Computing the whole motion …");
  try {
    const { blob, name } = await postFile("simulate/file", { case: data.tables }, `${fileName()}.nc`);
    download(blob, name);
    parts.said(`Saved as ${name}.`);
  } catch (error) {
    parts.said(h("span", { class: "problem" }, error.message));
  }
}
