// All branches of the diagram, of the motions that searches find at some values of the parameter: told while they come in.

import { Part } from "./branches_stream.js";
import { sameBranch, tracedBranch } from "./branches_rows.js";
import { h, put, select } from "../core/dom.js";
import { percent } from "../core/format.js";
import { data, show, view } from "../core/state.js";

const UP_TO = ["1/1", "2/2", "3/3", "4/4"];
let part = null;
let box = null;
let every = []; // branches
let thin = []; // what is no motion, beyond their ends

/** The choice and the progress below the diagram; `changed` is called when there are more branches. */
export function everyRow(changed) {
  const told = (found, done) => {
    every = [...(found?.branches ?? []), ...(found?.rest_branches ?? [])].map(tracedBranch);
    thin = (found?.impossible ?? []).map(tracedBranch);
    const many = `${every.length} ${every.length === 1 ? "branch" : "branches"}`;
    if (found) put(part.words, done ? `Found: ${many}.` : `${percent(found.done, 2)}, ${many}`);
    box.dataset.found = String(every.length);
    changed();
  };
  part = new Part({ id: "branches-every", begun: "Searching for branches …", told });
  const options = [["", "those followed"], ...UP_TO.map((label) => [label, `all up to z=${label}`])];
  const choice = select("Branches", options, view.every, (label) => show({ every: label }), { id: "branches-up-to" });
  box = choice.querySelector("select");
  return h("div", { class: "row middle map-status" }, choice, part.bar, part.words);
}

/** Trace them through a parameter's range, unless that is under way or there; `now` tells cases apart. */
export function wantEvery({ name, unit, from, to, modes, now }) {
  box.value = UP_TO.includes(view.every) ? view.every : "";
  const key = box.value ? JSON.stringify([now, name, from, to, modes, box.value]) : "";
  const sizes = { values: 2, starts: 0, runs: 0, impacts: 2000, modes, up_to: box.value };
  part.want(key, { case: data.tables, along: { name, unit, from, to }, ...sizes });
}

/** Nothing is traced any more. */
export const stopEvery = () => part.stop();

/** Those that are not among the branches that were followed. */
export const others = (followed) => every.filter((one) => !followed.some((other) => sameBranch(other, one)));

/** What is drawn thin: no motions. */
export const impossible = () => thin;
