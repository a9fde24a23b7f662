// @ts-check
// What is followed, through which parameter and how far: the row of choices above the diagram.

import { $, $$, button, h, labelled, put, select } from "../core/dom.js";
import { inUnit, plainNumber } from "../core/format.js";
import { isRange, present, rangeOf, rangeText } from "../core/moves.js";
import { chosen, data, isHeld, show, switchesItself, view } from "../core/state.js";
import { UP } from "./branches_picture.js";

const MODES = [0, 4, 8, 16, 32];
const DEPTHS = [0, 1, 2, 3, 4, 5, 6];
const LABELS = ["1/1", "1/2", "1/3", "2/1", "2/2", "2/3", "3/1", "3/2", "4/1"];
const RESTING = ["chatter/1", "chatter/2", "rest/1", "rest/2"];

/** A parameter with a range; `movable` when a slider can have it.
 * @typedef {{ name: string, unit: string, label: string, from: number, to: number, movable: boolean }} Axis */

/** Whether a label is of a motion with rest. @param {string} label */
export const rests = (label) => /^(chatter|rest)\//.test(label);

/** What can be drawn up the plane: the impacts of a machine have no phase of a load, its cycle has a period. */
const heights = () => Object.keys(UP).filter((name) => name !== (switchesItself() ? "phase" : "period"));

/** What is drawn up it. @returns {string} */
export const rising = () => (heights().includes(view.up) ? view.up : heights()[0]);

/** The parameters that an orbit can be followed through. @returns {any[]} */
const known = () => data.info.parameters.filter((/** @type {any} */ { name, value }) => name !== "m" && value !== null);

/** The parameter of the diagram. @returns {Axis} */
export function along() {
  const wanted = [view.along, "load_factor", "load.supply.flow", "load.pressure"];
  const found = wanted.map((wish) => known().find(({ name }) => name === wish)).find(Boolean) ?? known()[0];
  const { name, unit, label, low, high, movable } = found;
  const [from, to] = rangeOf(view.alongr, unit) ?? [low, high];
  return { name, unit, from, to, movable, label: inUnit(label, unit) };
}

/** What `percuss follow` is asked to begin with: the motion of the head of the page, unless another one is named.
 * @returns {string} */
export function beginning() {
  if (view.begin) return view.begin;
  if (switchesItself()) return "1/1";
  const found = chosen();
  return found ? `1/${view.m}:phases=${found.quick.phase_b77 ?? found.quick.phase}` : "";
}

/** The range that is asked for: the server begins at the present design, which must be within. @param {Axis} axis */
export function askedRange({ name, unit, from, to }) {
  const now = present(data, name) ?? from;
  return { name, unit, from: Math.min(from, now), to: Math.max(to, now) };
}

/** The row, made anew only when there is another choice; `searched` is told the label of another motion.
 * @param {HTMLElement} row @param {(label: string) => void} searched */
export function branchChoices(row, searched) {
  if (!data.info) return;
  const axis = along();
  const names = known().map(({ name, label }) => [name, label]);
  const modes = MODES.filter((n) => n || !isHeld());
  const key = JSON.stringify([names, axis.name, rising(), view.depth, view.bmodes, view.begin, modes]);
  if (row.dataset.key === key) return fill(row, axis);
  row.dataset.key = key;
  const pick = (
    /** @type {string} */ id,
    /** @type {string} */ label,
    /** @type {any[]} */ options,
    /** @type {any} */ now,
  ) => select(label, options, now, PICKED[id] ?? ((name) => name && searched(name)), { id: `branches-${id}` });
  const other = [...LABELS.map((name) => [name, `z=${name}`]), ...RESTING.map((name) => [name, name])];
  const begun = `from ${rests(view.begin) ? "" : "z="}${view.begin.replace(/:phases.*/, "")}`;
  put(
    row,
    h("div", { class: "axis" }, pick("along", "Through", names, axis.name), edge("from", axis), edge("to", axis)),
    pick(
      "up",
      "Up",
      heights().map((name) => [name, UP[name].label]),
      rising(),
    ),
    pick(
      "depth",
      "Go on at flips",
      DEPTHS.map((n) => [n, n ? `${n} deep` : "no"]),
      view.depth,
    ),
    pick(
      "modes",
      isHeld() ? "Modes, at most" : "Elastic modes",
      modes.map((n) => [n, n ? String(n) : "0: rigid"]),
      view.bmodes,
    ),
    pick("search", "Other motions", [["", "z=p/n …"], ...other], ""),
    view.begin && [
      h("span", { class: "small", id: "branches-begin" }, begun),
      button("The head's motion", () => show({ begin: "", spot: "" })),
    ],
    h("p", { class: "problem", role: "alert", id: "branches-range-problem" }),
  );
}

/** @type {Record<string, (value: string) => void>} */
const PICKED = {
  along: (name) => show({ along: name, alongr: "", spot: "" }),
  up: (up) => show({ up }),
  depth: (depth) => show({ depth: Number(depth) }),
  modes: (n) => show({ bmodes: Number(n) }),
};

/** @param {"from" | "to"} end @param {Axis} axis */
function edge(end, axis) {
  const onchange = (/** @type {any} */ { target }) => {
    const inputs = $$("#branches-from, #branches-to").map((input) => /** @type {HTMLInputElement} */ (input));
    const [from, to] = inputs.map(({ valueAsNumber }) => valueAsNumber);
    const taken = isRange(from, to);
    for (const input of inputs) input.setAttribute("aria-invalid", String(!taken && input === target));
    const words = "A range must go from a number to a greater one; the diagram keeps the previous range.";
    put($("#branches-range-problem"), taken ? "" : words);
    if (taken) show({ along: along().name, alongr: rangeText(from, to, along().unit) });
  };
  const now = { type: "number", step: "any", ".value": String(plainNumber(axis[end], 6)), onchange };
  const about = { "aria-label": `${end}, of the parameter`, "aria-describedby": "branches-range-problem" };
  const input = h("input", { ...now, ...about, id: `branches-${end}`, "data-end": end });
  return labelled(end, input);
}

/** The ends as they are now; one that is typed into, and one that was not taken, are left alone.
 * @param {HTMLElement} row @param {Record<string, any>} axis */
function fill(row, axis) {
  for (const input of /** @type {NodeListOf<HTMLInputElement>} */ (row.querySelectorAll("input[data-end]"))) {
    if (input === document.activeElement || input.getAttribute("aria-invalid") === "true") continue;
    const value = String(plainNumber(axis[input.dataset.end ?? ""], 6));
    if (input.value !== value) input.value = value;
  }
}
