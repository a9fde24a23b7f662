// What happens to the motion of the head, or to that which the panel Branches begins with, followed through both
// parameters of the map: curves over its colours.

import { beginning } from "../branches/branches_choices.js";
import { EVENTS } from "../branches/branches_picture.js";
import { Part } from "../branches/branches_stream.js";
import { theme } from "../pictures/colours.js";
import { div, h, put } from "../core/dom.js";
import { percent } from "../core/format.js";
import { present } from "../core/moves.js";
import { signal } from "../core/signals.js";
import { data, isHeld, modesInWords, show, switchesItself, view } from "../core/state.js";

/** @typedef {import("./map_axes.js").Axis} Axis */

/** @type {Record<string, number[]>} */
const DASHES = {
  fold: [],
  nonsmooth_fold: [],
  flip: [7, 5],
  period_halving: [7, 5],
  neimark_sacker: [2, 4],
  corner: [1, 3],
  grazing_touch: [11, 4, 2, 4],
  grazing_impact_dies: [5, 3],
  onset: [9, 3, 2, 3],
  release_lost: [3, 6],
};
const ENDS = new Set([
  "limit",
  "closed",
  "stopped",
  "lost",
  "impacts_coalesce",
  "load_stops_pushing",
  "parameter_end",
  "endless_chatter",
  "unpressed",
]);
const box = h("input", { type: "checkbox", id: "map-follow", onchange: () => show({ curves: Number(box.checked) }) });
const motion = h("span", {}, "this motion"); // its words
/** @type {any} */
let part = null;
/** Curves, as the server tells them. */
const found = signal(/** @type {any[]} */ ([]));

/** The switch and the progress below the map. */
export function followedRow() {
  const told = (/** @type {any} */ answer, /** @type {boolean} */ done) => {
    found.value = answer?.curves ?? [];
    if (answer) put(part.words, done ? words() : percent(answer.done, 2));
    box.dataset.found = found
      .peek()
      .map(({ type }) => type)
      .join();
  };
  part = new Part({ id: "map-followed", path: "follow/curves", begun: "Following …", told });
  const label = h("label", { class: "check" }, box, " what happens to ", motion, ", as curves");
  return div("row middle map-status", label, part.bar, part.words);
}

function words() {
  const all = found.peek();
  const cut = all.some(({ points }) => points.some((/** @type {any} */ one) => one.type === "stopped"));
  if (!all.length) return "Nothing happens to it on the lines through the design.";
  const curves = all.length === 1 ? "One curve" : `${all.length} curves`;
  const of = view.bmodes || isHeld() ? `with ${modesInWords(view.bmodes)}` : "of a rigid bar";
  return `${curves}, ${of}${cut ? "; what took too long is cut off" : ""}.`;
}

/** Follow them over the plane, unless that is under way or there; `since` tells hammers apart.
 * @param {Axis} x @param {Axis} y @param {number} since */
export function wantFollowed(x, y, since) {
  box.checked = Boolean(view.curves);
  box.disabled = switchesItself() || Boolean(x.whole || y.whole);
  const orbit = beginning();
  put(motion, view.begin ? view.begin.replace(/^(?=\d)/, "z=").replace(/:phases.*/, "") : "this motion");
  const key =
    view.curves && orbit && !box.disabled
      ? JSON.stringify([since, x, y, view.begin || [view.m, view.orbit], view.bmodes])
      : "";
  part.want(key, { case: data.tables, x: range(x), y: range(y), orbit, modes: view.bmodes });
}

/** A range that holds the design, from which the motion is followed. @param {Axis} axis */
function range({ name, unit, from, to }) {
  const now = present(data, name) ?? from;
  return { name, unit, from: Math.min(from, now), to: Math.max(to, now) };
}

/** Nothing is followed any more. */
export const stopFollowed = () => part.stop();

/** Lines, without what is no orbit otherwise, and rings at what happens on them. @param {Axis} x @returns {any[]} */
export function followedItems(x) {
  const { accent } = theme();
  const lines = found.value.map(({ type, parameters, curve }) => {
    const across = parameters.indexOf(x.name);
    const at = (/** @type {number} */ k) =>
      curve.values.map((/** @type {number[]} */ pair, /** @type {number} */ i) => (curve.is_orbit[i] ? pair[k] : null));
    const name = `${/** @type {any} */ (EVENTS)[type]?.words.replace("end: ", "") ?? type}, followed`;
    return {
      type: "line",
      x: at(across),
      y: at(1 - across),
      colour: accent,
      width: 2.4,
      dash: DASHES[type] ?? [3, 3],
      name,
    };
  });
  const rings = found.value.flatMap(({ parameters, points }) => {
    const across = parameters.indexOf(x.name);
    const special = points.filter((/** @type {any} */ { type }) => !ENDS.has(type));
    return special.map((/** @type {any} */ { type, values }) => {
      const name = `meets here: ${type.replace("with_", "").replaceAll("_", " ")}`;
      return {
        type: "points",
        x: [values[across]],
        y: [values[1 - across]],
        shape: "ring",
        size: 5,
        colour: accent,
        name,
      };
    });
  });
  return [...lines, ...rings];
}
