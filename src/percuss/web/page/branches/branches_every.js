// What searches and simulations find over the whole diagram, told while it comes in: all branches up to a label, and what
// simulations settle on, as dots below the branches.

import { motionOf } from "./branches_picture.js";
import { sameBranch, tracedBranch } from "./branches_rows.js";
import { Part } from "./branches_stream.js";
import { div, h, put, select } from "../core/dom.js";
import { percent } from "../core/format.js";
import { data, show, view } from "../core/state.js";
import { familyOf, theme } from "../pictures/colours.js";

/** @typedef {import("./branches_rows.js").Branch} Branch */
/** @typedef {{ name: string, unit: string, from: number, to: number, modes: number, now: number }} Question */

const UP_TO = ["1/1", "2/2", "3/3", "4/4"];
const DOT = 1.6; // pixels

/** @type {{ every: Part, settled: Part, upTo: HTMLSelectElement, simulate: HTMLInputElement }} */
let parts;
/** @type {Branch[]} */
let every = [];
/** What is no motion, beyond the ends of branches: drawn thin. @type {Branch[]} */
export let impossible = [];
/** @type {{ value: number, label: string, phases: number[], speeds: number[] }[]} */
let settled = [];

/** The choices and the progress below the diagram; `more` is called when there are more branches, `repaint` when dots.
 * @param {() => void} more @param {() => void} repaint */
export function everyRows(more, repaint) {
  const options = /** @type {[string, string][]} */ ([
    ["", "those followed"],
    ...UP_TO.map((label) => [label, `all up to z=${label}`]),
  ]);
  const choice = select("Branches", options, view.every, (label) => show({ every: label }), { id: "branches-up-to" });
  const onchange = (/** @type {any} */ event) => show({ settled: Number(event.target.checked) });
  parts = {
    every: new Part({
      id: "branches-every",
      begun: "Searching for branches …",
      told(found, done) {
        every = [...(found?.branches ?? []), ...(found?.rest_branches ?? [])].map(tracedBranch);
        impossible = (found?.impossible ?? []).map(tracedBranch);
        const many = every.length === 1 ? "1 branch" : `${every.length} branches`;
        if (found) put(parts.every.words, done ? `Found: ${many}.` : `${percent(found.done, 2)}, ${many}`);
        more();
      },
    }),
    settled: new Part({
      id: "branches-settled",
      begun: "Simulating …",
      told(found, done) {
        settled = found?.settled ?? [];
        const labels = [...new Set(settled.map(({ label }) => label))];
        const words = `Found: ${labels.slice(0, 8).join(", ")}${labels.length > 8 ? " …" : ""}.`;
        if (found) put(parts.settled.words, done ? words : percent(found.done, 2));
        repaint();
      },
    }),
    upTo: /** @type {HTMLSelectElement} */ (choice.querySelector("select")),
    simulate: h("input", { type: "checkbox", id: "branches-simulate", onchange }),
  };
  const dots = h("label", { class: "check" }, parts.simulate, " what simulations settle on, as dots");
  const row = (/** @type {HTMLElement} */ control, /** @type {Part} */ { bar, words }) =>
    div("row middle map-status", control, bar, words);
  return [row(choice, parts.every), row(dots, parts.settled)];
}

/** Trace all branches through a parameter's range, unless that is under way or there; `now` tells cases apart.
 * @param {Question} question */
export function wantEvery(question) {
  const up_to = UP_TO.includes(view.every) ? view.every : "";
  parts.upTo.value = up_to;
  want(parts.every, up_to, question, { values: 2, starts: 0, runs: 0, impacts: 2000, up_to });
}

/** Simulate over a parameter's range, unless that is under way or there. @param {Question} question */
export function wantSettled(question) {
  parts.simulate.checked = Boolean(view.settled);
  want(parts.settled, view.settled, question, { values: 160, impacts: 1000 });
}

/** @param {Part} part @param {any} wanted @param {Question} question @param {Record<string, any>} sizes */
function want(part, wanted, { name, unit, from, to, modes, now }, sizes) {
  const asked = { along: { name, unit, from, to }, modes, ...sizes };
  part.want(wanted ? JSON.stringify([now, asked]) : "", { case: data.tables, ...asked });
}

/** Nothing is looked for any more. */
export const stopAll = () => (parts.every.stop(), parts.settled.stop());

/** Those that are not among the branches that were followed. @param {Branch[]} followed */
export const others = (followed) => every.filter((one) => !followed.some((other) => sameBranch(other, one)));

/** The dots, in the colours of the families of motions. @param {string} up */
export function settledDots(up) {
  const { families } = theme();
  /** @type {Map<number, { x: number[], y: number[] }>} */
  const kinds = new Map();
  for (const { value, label, phases, speeds } of settled) {
    const family = familyOf(motionOf(label));
    const held = kinds.get(family) ?? { x: [], y: [] };
    for (const height of { phase: phases, speed: speeds }[up] ?? []) (held.x.push(value), held.y.push(height));
    kinds.set(family, held);
  }
  const look = { type: "points", shape: "dot", size: DOT, under: true };
  return [...kinds]
    .filter(([family, { x }]) => families[family] && x.length)
    .map(([family, dots]) => ({
      ...look,
      ...dots,
      colour: families[family].line,
      name: `settled: ${families[family].name}`,
    }));
}
