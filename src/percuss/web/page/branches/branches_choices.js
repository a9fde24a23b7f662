// What is followed, through which parameter and how far: the row of choices above the diagram.

import { $, $$, h, put, select } from "../core/dom.js";
import { inUnit, plainNumber } from "../core/format.js";
import { isRange, present, rangeOf, rangeText } from "../core/moves.js";
import { chosen, data, isHeld, show, switchesItself, view } from "../core/state.js";
import { UP } from "./branches_picture.js";

const MODES = [0, 4, 8, 16, 32];
const DEPTHS = [0, 1, 2, 3, 4, 5, 6];
const LABELS = ["1/1", "1/2", "1/3", "2/1", "2/2", "2/3", "3/1", "3/2", "4/1"];
const RESTING = ["chatter/1", "chatter/2", "rest/1", "rest/2"];

/** Whether a label is of a motion with rest. */
export const rests = (label) => /^(chatter|rest)\//.test(label);

/** What can be drawn up the plane: the impacts of a machine have no phase of a load, its cycle has a period. */
const heights = () => Object.keys(UP).filter((name) => name !== (switchesItself() ? "phase" : "period"));

/** What is drawn up it. */
export const rising = () => (heights().includes(view.up) ? view.up : heights().at(0));

/** The parameters that an orbit can be followed through. */
const known = () => data.info.parameters.filter(({ name, value }) => name !== "m" && value !== null);

/** The parameter of the diagram with its range: {name, label, unit, from, to, movable}. */
export function along() {
  const named = [view.along, "load_factor", "load.supply.flow", "load.pressure"].map((wanted) => known().find(({ name }) => name === wanted));
  const found = named.find(Boolean) ?? known()[0];
  const { name, unit, low, high, movable } = found;
  const [from, to] = rangeOf(view.alongr, unit) ?? [low, high];
  return { name, unit, from, to, movable, label: inUnit(found.label, unit) };
}

/** What `percuss follow` is asked to begin with: the motion of the head of the page, unless another one is named. */
export function beginning() {
  if (view.begin) return view.begin;
  if (switchesItself()) return "1/1";
  const found = chosen();
  return found ? `1/${view.m}:phases=${found.quick.phase_b77 ?? found.quick.phase}` : "";
}

/** The range that is asked for: the server begins at the present design, which must be within. */
export function askedRange({ name, unit, from, to }) {
  const now = present(data, name);
  const held = now === undefined ? [] : [now];
  return { name, unit, from: Math.min(from, ...held), to: Math.max(to, ...held) };
}

/** The row, made anew only when there is another choice. */
export function branchChoices(row, searched) {
  if (!data.info) return;
  const axis = along();
  const key = JSON.stringify([known().map(({ name }) => name), axis.name, rising(), view.depth, view.bmodes, view.begin, isHeld(), switchesItself()]);
  if (row.dataset.key === key) return fill(row, axis);
  row.dataset.key = key;
  const names = known().map(({ name, label }) => [name, label]);
  const depths = DEPTHS.map((n) => [n, n ? `${n} deep` : "no"]);
  put(
    row,
    h(
      "div",
      { class: "axis" },
      select("Through", names, axis.name, (name) => show({ along: name, alongr: "", spot: "" }), { id: "branches-along" }),
      edge("from", axis),
      edge("to", axis),
    ),
    select("Up", heights().map((name) => [name, UP[name].label]), rising(), (up) => show({ up }), { id: "branches-up" }),
    select("Go on at flips", depths, view.depth, (depth) => show({ depth: Number(depth) }), { id: "branches-depth" }),
    select(isHeld() ? "Modes, at most" : "Elastic modes", MODES.filter((n) => n || !isHeld()).map((n) => [n, n ? String(n) : "0: rigid"]), view.bmodes, (n) => show({ bmodes: Number(n) }), { id: "branches-modes" }),
    begins(searched),
    h("p", { class: "problem", role: "alert", id: "branches-range-problem" }),
  );
}

/** Where to begin: the motion of the head, or one of those that a search finds. */
function begins(searched) {
  const named = view.begin && h("span", { class: "small", id: "branches-begin" }, `from ${rests(view.begin) ? "" : "z="}${view.begin.replace(/:phases.*/, "")}`);
  const back = view.begin && h("button", { type: "button", onclick: () => show({ begin: "", spot: "" }) }, "The head's motion");
  const label = select("Other motions", [["", "z=p/n …"], ...LABELS.map((name) => [name, `z=${name}`]), ...RESTING.map((name) => [name, name])], "", (name) => name && searched(name), { id: "branches-search" });
  return [label, named, back];
}

function edge(end, axis) {
  const id = `branches-${end}`;
  const commit = (event) => {
    const inputs = ["from", "to"].map((name) => $(`#branches-${name}`));
    const [from, to] = inputs.map((input) => (input.value === "" ? Number.NaN : Number(input.value)));
    const taken = isRange(from, to);
    for (const input of inputs) input.setAttribute("aria-invalid", String(!taken && input === event.target));
    const words = "A range must go from a number to a greater one; the diagram keeps the previous range.";
    put($("#branches-range-problem"), taken ? "" : words);
    if (taken) show({ along: along().name, alongr: rangeText(from, to, along().unit) });
  };
  const input = { type: "number", step: "any", id, "data-end": end, ".value": String(plainNumber(axis[end], 6)), onchange: commit };
  const about = { "aria-label": `${end}, of the parameter`, "aria-describedby": "branches-range-problem" };
  return h("label", { class: "pick" }, h("span", {}, end), h("input", { ...input, ...about }));
}

/** The ends as they are now; one that is typed into, and one that was not taken, are left alone. */
function fill(row, axis) {
  for (const input of $$("input[data-end]", row)) {
    if (input === document.activeElement || input.getAttribute("aria-invalid") === "true") continue;
    const value = String(plainNumber(axis[input.dataset.end], 6));
    if (input.value !== value) input.value = value;
  }
}
