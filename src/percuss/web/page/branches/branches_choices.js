// What is followed, through which parameter and how far: the row of choices above the diagram.

import { button, div, h, labelled, put, select } from "../core/dom.js";
import { inUnit } from "../core/format.js";
import { present, rangeOf, rangeText } from "../core/moves.js";
import { rangeEnds } from "../core/range_ends.js";
import { effect, whenever } from "../core/signals.js";
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

/** Whether the drawer is in sight, and what is known of the case is known of this kind of case. */
export const ready = () => view.panel === "branches" && data.info && Boolean(data.info.system) !== switchesItself();

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

/** The choices in a row, made anew only when there is another one; `searched` is told the label of another motion.
 * @param {HTMLElement} row @param {(label: string) => void} searched */
export function startChoices(row, searched) {
  const names = () => known().map(({ name, label }) => [name, label]);
  const modes = () => MODES.filter((n) => n || !isHeld());
  /** @type {ReturnType<typeof rangeEnds>} */
  let ends;
  const pick = (
    /** @type {string} */ id,
    /** @type {string} */ label,
    /** @type {any[]} */ options,
    /** @type {any} */ now,
  ) => select(label, options, now, PICKED[id] ?? ((name) => name && searched(name)), { id: `branches-${id}` });
  const build = () => {
    const problem = h("p", { class: "problem", role: "alert", id: "branches-range-problem" });
    ends = rangeEnds({
      id: "branches",
      about: "of the parameter",
      range: along,
      keeps: "the diagram",
      digits: 6,
      problem,
      taken: (from, to, unit) => show({ along: along().name, alongr: rangeText(from, to, unit) }),
    });
    const other = [...LABELS.map((name) => [name, `z=${name}`]), ...RESTING.map((name) => [name, name])];
    const begun = `from ${rests(view.begin) ? "" : "z="}${view.begin.replace(/:phases.*/, "")}`;
    const through = pick("along", "Through", names(), along().name);
    const ways = heights().map((name) => [name, UP[name].label]);
    const depths = DEPTHS.map((n) => [n, n ? `${n} deep` : "no"]);
    const sizes = modes().map((n) => [n, n ? String(n) : "0: rigid"]);
    put(
      row,
      div("axis", through, labelled("from", ends.from), labelled("to", ends.to)),
      pick("up", "Up", ways, rising()),
      pick("depth", "Go on at flips", depths, view.depth),
      pick("modes", isHeld() ? "Modes, at most" : "Elastic modes", sizes, view.bmodes),
      pick("search", "Other motions", [["", "z=p/n …"], ...other], ""),
      view.begin && [
        h("span", { class: "small", id: "branches-begin" }, begun),
        button("The head's motion", () => show({ begin: "", spot: "" })),
      ],
      problem,
    );
  };
  whenever(() => ready() && [names(), along().name, rising(), view.depth, view.bmodes, view.begin, modes()], build);
  effect(() => ready() && ends.fill());
}

/** @type {Record<string, (value: string) => void>} */
const PICKED = {
  along: (name) => show({ along: name, alongr: "", spot: "" }),
  up: (up) => show({ up }),
  depth: (depth) => show({ depth: Number(depth) }),
  modes: (n) => show({ bmodes: Number(n) }),
};
