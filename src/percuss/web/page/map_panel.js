// The stability plane: verdicts as an image, the exact fold and flip curves over it, the design as a point that can be
// dragged, clicked to another place, or moved by the arrow keys.

import { post, postBinary } from "./api.js";
import { Chart } from "./chart.js";
import { theme } from "./colours.js";
import { framed, h, put, select, settled } from "./dom.js";
import { number } from "./format.js";
import { content, legends, picture } from "./map_picture.js";
import { present } from "./moves.js";
import { data, move, on, show, view } from "./state.js";

const FAST = new Set(["restitution", "load_factor", "m"]);
const TITLES = {
  restitution: "restitution R",
  load_factor: "load factor p₀/p₁",
  kappa: "κ of the square load",
  s: "wave speed s",
  d: "damping d",
  "load.scale": "load, as a multiple",
};
const SHOWN = {
  verdict: { label: "verdict", quantities: ["orbits", "reduced_stable"] },
  reduced_margin: { label: "stability margin", quantities: ["reduced_margin"] },
  stable: { label: "verdict with elastic modes", quantities: ["orbits", "stable"] },
  margin: { label: "margin with elastic modes", quantities: ["margin"] },
  blow_energy: { label: "blow energy", quantities: ["blow_energy"] },
  impact_velocity: { label: "striking speed", quantities: ["impact_velocity"] },
  power: { label: "percussive power", quantities: ["power"] },
  label: { label: "motion found by simulation", quantities: ["label"], modes: 0 },
};

const parts = {};
let asking = null; // the abort controller of the map under way
let plane = null; // the latest map: {x, y, nx, ny, codes or values, fine}
let curves = null;
let dragging = false;
let version = 0; // counts the changes of the case that change the map

export function startMap(panel) {
  parts.chart = new Chart("Stability plane", { kind: "map", role: "application", about: "Stability plane" });
  parts.chart.canvas.tabIndex = 0;
  parts.chart.canvas.id = "map";
  parts.readout = h("p", { class: "small", id: "map-readout", "aria-live": "polite" });
  parts.status = h("p", { class: "small muted", id: "map-status", role: "status" });
  parts.choice = h("div", { class: "row" });
  put(
    panel,
    h("div", { class: "card" }, parts.choice),
    h("div", { class: "card" }, parts.chart.figure, parts.readout, parts.status),
  );
  pointer(parts.chart.canvas);
  on("info", choices);
  on("tables", () => {
    if (!moveOnly()) version += 1;
    compute();
  });
  on("info", compute);
  on("view", () => view.panel === "map" && (choices(), compute()));
  on("theme", () => (plane && picture(plane), repaint()));
  on("quick steady", repaint);
}

/** Whether the last change of the case moved along the map's own axes: the map is the same then. */
const moveOnly = () => data.moved?.every((name) => (name === view.x || name === view.y) && name !== "load.scale");

const parameter = (name) => data.info?.parameters.find((p) => p.name === name);

function axis(which) {
  const known = parameter(view[which]) ?? data.info.parameters[0];
  const given = /^([-+.\deE]+):([-+.\deE]+)$/.exec(view[`${which}r`]);
  const range = given ? [Number(given[1]), Number(given[2])] : [known.low, known.high];
  const whole = known.name === "m";
  return { name: known.name, unit: known.unit, from: range[0], to: range[1], whole };
}

const labelOf = ({ name, unit }) => `${TITLES[name] ?? name}${unit ? `, ${unit}` : ""}`;

function choices() {
  if (!data.info) return;
  const names = data.info.parameters.map((p) => [p.name, TITLES[p.name] ?? p.name]);
  const key = JSON.stringify([names, view.x, view.y, view.xr, view.yr, view.q]);
  if (parts.choice.dataset.key === key) return;
  parts.choice.dataset.key = key;
  const focus = document.activeElement?.id;
  const edge = (which, end) => {
    const now = axis(which);
    const commit = (event) => {
      const next = { ...now, [end]: Number(event.target.value) };
      if (Number.isFinite(next.from) && Number.isFinite(next.to) && next.from < next.to)
        show({ [`${which}r`]: `${next.from}:${next.to}` });
    };
    return h(
      "label",
      { class: "pick" },
      h("span", {}, end),
      h("input", {
        type: "number",
        step: "any",
        id: `map-${which}-${end}`,
        ".value": String(now[end]),
        onchange: commit,
        size: 8,
      }),
    );
  };
  const group = (which, title) => [
    select(title, names, view[which], (name) => show({ [which]: name, [`${which}r`]: "" }), { id: `map-${which}` }),
    edge(which, "from"),
    edge(which, "to"),
  ];
  const shown = Object.entries(SHOWN).map(([name, { label }]) => [name, label]);
  put(
    parts.choice,
    group("x", "Across"),
    group("y", "Up"),
    select("Colour", shown, view.q, (q) => show({ q }), { id: "map-q" }),
  );
  if (focus?.startsWith("map-")) document.getElementById(focus)?.focus();
}

const compute = settled(() => {
  if (view.panel !== "map" || !data.info || !data.tables || data.problems.length) return;
  const x = axis("x");
  const y = axis("y");
  if (x.name === y.name) return put(parts.status, "Choose two different parameters.");
  const key = JSON.stringify([x, y, view.q, view.m, version]);
  if (key === parts.key) return;
  parts.key = key;
  ask(x, y).catch((error) => {
    if (error.name === "AbortError") return;
    parts.key = "";
    put(parts.status, h("span", { class: "problem" }, error.message));
  });
}, 30);

async function ask(x, y) {
  asking?.abort();
  asking = new AbortController();
  const { signal } = asking;
  const kind = SHOWN[view.q] ?? SHOWN.verdict;
  const fast = FAST.has(x.name) && FAST.has(y.name) && ["verdict", "reduced_margin"].includes(view.q);
  const medium = FAST.has(x.name) && FAST.has(y.name) && ["stable", "margin"].includes(view.q);
  const simulated = view.q === "label";
  const sizes = fast ? [50, 200] : medium ? [16, 60] : simulated ? [6, 14] : [10, 36];
  const body = {
    case: data.tables,
    periods: view.m,
    quantities: kind.quantities,
    ...(simulated ? { modes: 0, impacts: 400 } : {}),
  };
  const begun = performance.now();
  plane = null;
  curves = null;
  put(parts.status, "Computing …");
  const wish = ({ name, unit, from, to, whole }, count) => ({
    name,
    ...(unit && { unit }),
    from,
    to,
    count: whole ? to - from + 1 : count,
  });
  const first = postBinary("map", { ...body, x: wish(x, sizes[0]), y: wish(y, sizes[0]) }, signal);
  take(await first, x, y, kind, false);
  const coarse = performance.now() - begun;
  take(await postBinary("map", { ...body, x: wish(x, sizes[1]), y: wish(y, sizes[1]) }, signal), x, y, kind, true);
  const cells = `${plane.nx} × ${plane.ny} cells`;
  put(
    parts.status,
    `${cells}; first view after ${number(coarse, 2)} ms, all after ${number(performance.now() - begun, 3)} ms.`,
  );
  parts.chart.canvas.dataset.fine = String(plane.nx);
  for (const count of [24, 96]) await boundaries(x, y, count, signal);
}

/** The exact curves; a few points first, for they take longer than the image. */
async function boundaries(x, y, count, signal) {
  if (x.whole || y.whole || view.q === "label" || (count > 24 && !(FAST.has(x.name) && FAST.has(y.name)))) return;
  const body = {
    case: data.tables,
    periods: view.m,
    x: { name: x.name, ...(x.unit && { unit: x.unit }), from: x.from, to: x.to, count },
    y: { name: y.name, ...(y.unit && { unit: y.unit }), from: y.from, to: y.to },
    criterion: "reduced",
    kinds: ["fold", "flip"],
  };
  try {
    curves = (await post("boundaries", body, signal)).curves;
  } catch (error) {
    if (error.name === "AbortError") throw error;
    curves = []; // a plane without such curves is still a map
  }
  parts.chart.canvas.dataset.curves = String(curves.length);
  repaint();
}

function take(found, x, y, kind, fine) {
  const [ny, nx] = found.arrays[kind.quantities[0]].shape;
  plane = { x, y, nx, ny, fine, ...content(found, kind) };
  picture(plane);
  repaint();
}

/** Where the design stands in the plane. */
function design() {
  const at = (which) => {
    const { name } = axis(which);
    if (name === "m") return view.m;
    return data.tables ? present(data, name) : undefined;
  };
  return { x: at("x"), y: at("y") };
}

const repaint = framed(() => {
  if (view.panel !== "map" || !data.info) return;
  const x = axis("x");
  const y = axis("y");
  const colours = theme();
  const items = legends(plane, colours);
  for (const curve of curves ?? []) {
    const fold = curve.kind === "fold";
    items.push({
      type: "line",
      x: curve.x,
      y: curve.y,
      colour: colours.ink,
      width: 2.4,
      dash: fold ? [] : [7, 5],
      name: fold ? "fold: no motion above" : "flip: period doubling",
    });
  }
  const here = design();
  if (here.x !== undefined && here.y !== undefined) {
    const stable = data.quick?.orbits.some((orbit) => orbit.stable);
    items.push({
      type: "points",
      x: [here.x],
      y: [here.y],
      shape: "diamond",
      size: 9,
      colour: colours.dark ? "#ffffff" : "#101820",
      name: "the present design",
    });
    parts.chart.canvas.dataset.design = `${here.x},${here.y}`;
    const words = data.quick ? (stable ? "stable" : data.quick.orbits.length ? "unstable" : "no steady motion") : "";
    put(
      parts.readout,
      `The design stands at ${labelOf(x)} = ${number(here.x)}, ${labelOf(y)} = ${number(here.y)}${words ? `: ${words}` : ""}. Drag it, click anywhere, or use the arrow keys.`,
    );
  }
  const about = `Map over ${labelOf(x)} and ${labelOf(y)}; arrow keys move the design`;
  const image =
    plane?.canvas && plane.x.name === x.name && plane.y.name === y.name
      ? { canvas: plane.canvas, smooth: false }
      : null;
  parts.chart.draw({
    x: { label: labelOf(x), from: x.from, to: x.to },
    y: { label: labelOf(y), from: y.from, to: y.to },
    items,
    image,
    about,
  });
});

function pointer(canvas) {
  const go = framed((event) => {
    const at = parts.chart.at(event);
    if (at) goTo(at);
  });
  canvas.style.cursor = "crosshair";
  canvas.style.touchAction = "none";
  canvas.addEventListener("pointerdown", (event) => {
    if (!parts.chart.at(event)) return;
    dragging = true;
    canvas.setPointerCapture(event.pointerId);
    go(event);
  });
  canvas.addEventListener("pointermove", (event) => dragging && go(event));
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (dragging = false));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const share = event.shiftKey ? 0.05 : 0.01;
    const here = design();
    const x = axis("x");
    const y = axis("y");
    goTo({ x: here.x + step[0] * share * (x.to - x.from), y: here.y + step[1] * share * (y.to - y.from) }, step);
  });
}

/** The design put there, as far as its tables can say it. */
function goTo(at, step = [1, 1]) {
  const values = {};
  let refused = "";
  for (const [i, which] of ["x", "y"].entries()) {
    const { name, from, to } = axis(which);
    const value = Math.min(Math.max(at[which], Math.min(from, to)), Math.max(from, to));
    if (step[i] === 0) continue;
    if (name === "m") show({ m: Math.max(1, Math.round(value)) });
    else if (parameter(name)?.movable) values[name] = value;
    else refused = labelOf({ name });
  }
  if (refused)
    put(parts.readout, `This case cannot take another ${refused} by itself: change its load on the Case panel.`);
  if (Object.keys(values).length) move(values);
}
