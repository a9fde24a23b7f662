// What simulations settle on over the parameter of the diagram, as dots below the branches: told while they come in.

import { Refusal, stream } from "./api.js";
import { familyOf, theme } from "./colours.js";
import { h, put } from "./dom.js";
import { percent } from "./format.js";
import { data, show, view } from "./state.js";

const VALUES = 160;
const IMPACTS = 1000;
const DOT = 1.6; // pixels
const parts = {};
let running = null; // the abort controller of the simulations under way
let settled = []; // {value, label, phases, speeds}
let key = "";
let changed = () => {};

/** The switch and the progress below the diagram; `repaint` is called when there are more dots. */
export function settledRow(repaint) {
  changed = repaint;
  parts.box = h("input", { type: "checkbox", id: "branches-simulate", onchange: (event) => show({ settled: Number(event.target.checked) }) });
  parts.bar = h("progress", { max: 1, value: 0, id: "branches-progress", "aria-label": "Progress of the simulations" });
  parts.words = h("span", { class: "small muted", id: "branches-settled", role: "status" });
  parts.bar.hidden = true;
  const label = h("label", { class: "check" }, parts.box, " what simulations settle on, as dots");
  return h("div", { class: "row middle map-status" }, label, parts.bar, parts.words);
}

/** Simulate over a parameter's range, unless that is under way or there; `now` tells cases apart. */
export function wantSettled({ name, unit, from, to, modes, now }) {
  parts.box.checked = Boolean(view.settled);
  const wish = view.settled ? JSON.stringify([now, name, from, to, modes]) : "";
  if (wish === key) return;
  key = wish;
  running?.abort();
  running = null;
  settled = [];
  parts.bar.hidden = true;
  put(parts.words, "");
  changed();
  if (wish) simulate({ case: data.tables, along: { name, unit, from, to }, modes, values: VALUES, impacts: IMPACTS }, wish);
}

/** Nothing is simulated any more. */
export function stopSettled() {
  if (!running) return;
  running.abort();
  key = "";
}

async function simulate(question, wish) {
  const own = (running = new AbortController());
  parts.bar.hidden = false;
  parts.bar.value = 0;
  put(parts.words, "Simulating …");
  try {
    await stream("diagram", question, (event, found) => own === running && take(event, found), own.signal);
    if (own === running && key === wish && !parts.bar.hidden) throw new Refusal(0, [{ key: "", value: null, message: "The server ended the simulations.", remedy: "" }]);
  } catch (error) {
    if (error.name === "AbortError" || own !== running) return;
    parts.bar.hidden = true;
    put(parts.words, h("span", { class: "problem", role: "alert" }, error.message));
  }
  if (own === running) running = null;
}

function take(event, found) {
  if (event === "error") throw new Refusal(422, found.problems);
  settled = found.settled;
  parts.bar.value = found.done;
  parts.bar.hidden = event === "done";
  const labels = [...new Set(settled.map(({ label }) => label))];
  put(parts.words, event === "done" ? `Found: ${labels.slice(0, 8).join(", ")}${labels.length > 8 ? " …" : ""}.` : percent(found.done, 2));
  parts.box.dataset.found = labels.join();
  changed();
}

/** The dots, in the colours of the families of motions. */
export function settledDots(up) {
  const { families } = theme();
  const kinds = new Map();
  for (const { value, label, phases, speeds } of settled) {
    const family = familyOf(label);
    const held = kinds.get(family) ?? { x: [], y: [] };
    for (const height of up === "phase" ? phases : speeds) (held.x.push(value), held.y.push(height));
    kinds.set(family, held);
  }
  return [...kinds]
    .filter(([family, { x }]) => families[family] && x.length)
    .map(([family, { x, y }]) => ({ type: "points", x, y, shape: "dot", size: DOT, under: true, colour: families[family].colour, name: `settled: ${families[family].name}` }));
}

/** How far the dots reach up. */
export const settledHeights = (up) => settled.flatMap(({ phases, speeds }) => (up === "phase" ? phases : speeds));
