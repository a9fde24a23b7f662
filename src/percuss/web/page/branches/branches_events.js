// What happens on the branches, each with its sentence and a way there; and the orbits that a search has found.

import { button, h, put, table } from "../core/dom.js";
import { angle, few, number, withUnit } from "../core/format.js";
import { switchesItself } from "../core/state.js";
import { EVENTS } from "./branches_picture.js";

/** @typedef {import("./branches_rows.js").Branch} Branch */
/** @typedef {import("./branches_choices.js").Axis} Axis */
/** Leads to a point of a branch, by its number. @typedef {(branch: number, point: any) => void} Go */

/** The table of what happens on the branches that were followed, and on request on the others.
 * @param {HTMLElement} card @param {{ followed: Branch[], others: Branch[] }} branches @param {Axis} axis @param {Go} go */
export function eventTable(card, { followed, others }, axis, go) {
  const main = followed.length ? [h("h2", {}, "What happens on the way"), events(followed, 0, axis, go)] : [];
  const open = card.querySelector("details")?.open;
  put(card, main, others.length ? more(others, followed.length, axis, go, open) : null);
}

/** The table of the others, which is made when it is opened: there can be hundreds of rows.
 * @param {Branch[]} others @param {number} first @param {Axis} axis @param {Go} go @param {boolean} [open] */
function more(others, first, axis, go, open) {
  const many = others.reduce((total, { points }) => total + points.length, 0);
  const which = others.length === 1 ? "branch" : `${others.length} branches`;
  const words = h("summary", {}, `What happens on the other ${which}: ${many} points`);
  const box = h("details", { id: "branches-more", open }, words);
  box.addEventListener(
    "toggle",
    () => box.open && box.children.length === 1 && box.append(events(others, first, axis, go)),
  );
  return box;
}

/** @param {Branch[]} branches @param {number} first @param {Axis} axis @param {Go} go */
function events(branches, first, { label, unit, name }, go) {
  const sentence = (/** @type {string} */ told) =>
    // the server's, with the parameter as the page calls it
    ["# =", "smaller #", "greater #"].reduce(
      (text, place) => text.replaceAll(place.replace("#", name), place.replace("#", label)),
      told,
    );
  const rows = branches.flatMap((branch, i) =>
    branch.points.map((point) => {
      const words = EVENTS[point.type]?.words ?? point.type;
      const place = withUnit(point.value, unit, 7);
      const about = `Go to ${words} of ${branch.label} at ${place}`;
      const open = button(place, () => go(first + i, point), { "aria-label": about });
      const cells = [open, branch.label, words, sentence(point.beyond)];
      return h(
        "tr",
        { "data-event": point.type },
        cells.map((cell) => h("td", {}, cell)),
      );
    }),
  );
  return table([label, "Motion", "Event", "Beyond it"], rows);
}

/** The orbits of a label; `begin` is told which is to be followed.
 * @param {HTMLElement} card @param {Record<string, any>} found @param {(name: string) => void} begin */
export function orbitList(card, found, begin) {
  const label = found.label.replace("z=", "");
  const rest = found.label === label; // chatter/n or rest/n
  const rows = found.orbits.map((/** @type {any} */ orbit, /** @type {number} */ i) => {
    const { impacts } = orbit;
    return [
      button("Follow", () => begin(`${label}:${i + 1}`), { "aria-label": `Follow ${found.label}, number ${i + 1}` }),
      few(
        impacts.map((/** @type {any} */ { phase, time }) =>
          phase !== undefined && impacts.length === 1 ? angle(phase) : number(phase ?? time),
        ),
      ),
      few(impacts.map((/** @type {any} */ { speed }) => number(speed))),
      ...(rest ? [number(orbit.rest_phase), number(orbit.release_phase)] : []),
      orbit.stable ? "stable" : "unstable",
    ];
  });
  const [blows, speeds] = switchesItself()
    ? ["Blows in the cycle", "Striking speeds"]
    : ["Impact phases [rad]", "Striking speeds, dimensionless"];
  const heads = ["", blows, speeds, ...(rest ? ["At rest from [rad]", "Let go at [rad]"] : []), "Verdict"];
  const share = (/** @type {number} */ value) => `${number(100 * value, 2)} %`;
  const missing = `${found.tries} tries; the share that a search of this size may miss: ${share(found.unseen)}, at most ${share(found.unseen_bound)}.`;
  put(
    card,
    h("h2", {}, `Motions ${found.label}`),
    rows.length ? table(heads, rows) : h("p", {}, "None was found."),
    h("p", { class: "small muted" }, found.complete ? "These are all." : missing),
  );
}
