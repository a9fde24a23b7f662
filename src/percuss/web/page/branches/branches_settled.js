// What simulations settle on over the parameter of the diagram, as dots below the branches: told while they come in.

import { Part } from "./branches_stream.js";
import { familyOf, theme } from "../pictures/colours.js";
import { h, put } from "../core/dom.js";
import { percent } from "../core/format.js";
import { data, show, view } from "../core/state.js";

const VALUES = 160;
const IMPACTS = 1000;
const DOT = 1.6; // pixels
let part = null;
let box = null;
let settled = []; // {value, label, phases, speeds}

/** The switch and the progress below the diagram; `repaint` is called when there are more dots. */
export function settledRow(repaint) {
  const told = (found, done) => {
    settled = found?.settled ?? [];
    if (found) tell(done, found.done);
    repaint();
  };
  part = new Part({ id: "branches-settled", begun: "Simulating …", told });
  box = h("input", { type: "checkbox", id: "branches-simulate", onchange: (event) => show({ settled: Number(event.target.checked) }) });
  const label = h("label", { class: "check" }, box, " what simulations settle on, as dots");
  return h("div", { class: "row middle map-status" }, label, part.bar, part.words);
}

function tell(done, share) {
  const labels = [...new Set(settled.map(({ label }) => label))];
  const found = `Found: ${labels.slice(0, 8).join(", ")}${labels.length > 8 ? " …" : ""}.`;
  put(part.words, done ? found : percent(share, 2));
  box.dataset.found = labels.join();
}

/** Simulate over a parameter's range, unless that is under way or there; `now` tells cases apart. */
export function wantSettled({ name, unit, from, to, modes, now }) {
  box.checked = Boolean(view.settled);
  const key = view.settled ? JSON.stringify([now, name, from, to, modes]) : "";
  part.want(key, { case: data.tables, along: { name, unit, from, to }, modes, values: VALUES, impacts: IMPACTS });
}

/** Nothing is simulated any more. */
export const stopSettled = () => part.stop();

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
