// Random starts, followed until their motions are found: the shares of the attractors fill up while they come in.

import { saveFile } from "../core/api.js";
import { $, button, div, h, labelled, put, select } from "../core/dom.js";
import { counted, number, percent } from "../core/format.js";
import { effect } from "../core/signals.js";
import { data, fileName, show, view } from "../core/state.js";
import { LongQuestion } from "./long_question.js";

/** @type {Record<string, string>} */
const DISTRIBUTIONS = { wall: "near the wall", field: "all over, ringing", gentle: "gentle" };

const question = new LongQuestion(
  "experiment",
  "Start",
  "Each start is followed impact by impact until its motion is known.",
  (told) =>
    Object.entries(DISTRIBUTIONS).reduce((text, [name, words]) => text.replaceAll(`'${name}'`, `“${words}”`), told),
);
const shares = h("div", { class: "shares", id: "experiment-shares" });
const files = h(
  "div",
  { class: "row", id: "experiment-files", hidden: true },
  button("Download NetCDF", () => save("nc")),
  button("Download CSV", () => save("csv")),
);
/** The question that the shown result answers; with `first`, where it was ended, the starts that were followed.
 * @type {Record<string, any> | null} */
let finished = null;

/** @param {HTMLElement} place */
export function start(place) {
  const form = h("form", {
    class: "row",
    id: "experiment-form",
    onsubmit: (/** @type {Event} */ event) => (event.preventDefault(), run()),
  });
  const words =
    "Where does the motion end up from a random start? Bars: the share of the starts; dark lines: its 95 % interval.";
  put(
    place,
    div("card", h("h2", {}, "Random starts"), h("p", { class: "muted small" }, words), form, question.problem),
    div("card", question.bar, question.status, shares, files),
  );
  effect(() => {
    if (!data.about) return;
    if (!form.children.length) put(form, fields(), question.go, question.cancel);
    for (const name of ["starts", "distribution", "seed", "emodes"]) {
      const input = /** @type {HTMLInputElement} */ ($(`#experiment-${name}`));
      if (input !== document.activeElement) input.value = String(view[name]); // what is being typed is left alone
    }
  });
  effect(() => {
    if (!data.tables || (!finished && !question.running)) return;
    question.running?.abort();
    if (finished) put(question.status, "The case has changed since: this is the result for the previous case.");
  });
}

function fields() {
  const { limits, distributions } = data.about;
  /** @param {string} name @param {string} label @param {number} min @param {number} max */
  const whole = (name, label, min, max) => {
    const onchange = () => show({ [name]: Math.round(Number(input.value)) || min });
    const input = h("input", { type: "number", id: `experiment-${name}`, min, max, step: 1, onchange });
    return labelled(label, input);
  };
  const drawn = distributions.map((/** @type {string} */ name) => [name, DISTRIBUTIONS[name] ?? name]);
  return [
    whole("starts", `Starts, up to ${number(limits.starts, 6)}`, 1, limits.starts),
    select("Drawn", drawn, view.distribution, (distribution) => show({ distribution }), {
      id: "experiment-distribution",
    }),
    whole("seed", "Seed", 0, 2 ** 31),
    whole("emodes", "Elastic modes, 0: rigid", 0, limits.simulation_modes),
  ];
}

async function run() {
  if (question.running) return;
  const { starts, distribution, seed, emodes } = view;
  const asked = { case: data.tables, starts, distribution, seed, modes: emodes, impacts: null };
  let followed = { done: 0, size: starts };
  finished = null;
  put(shares);
  files.hidden = true;
  const how = await question.ask("experiment", asked, (event, found) => {
    if (event === "progress") {
      followed = found;
      const rest = found.seconds_left ? `, about ${number(Math.ceil(found.seconds_left))} s left` : "";
      put(question.status, `${found.done} of ${counted(found.size, "start")}${rest}.`);
      fillShares(found.shares);
    } else if (event === "done") {
      data.experiment = { starts };
      const all = found.attractors ?? found.shares ?? [];
      put(
        question.status,
        `${counted(found.starts ?? starts, "start")}, all followed; ${counted(all.length, "kind")} of motion.`,
      );
      fillShares(all);
      finished = asked;
      files.hidden = false;
    }
  });
  if (finished) return;
  const { done, size } = followed;
  if (how === "ended early") put(question.problem, "The answer ended early: start the experiment again.");
  const told = how === "cancelled" ? "Cancelled" : done || how === "ended early" ? "Ended early" : "Not started";
  const since = data.tables === asked.case ? "" : " The case has changed since.";
  if (!done) return put(question.status, `${told}: no start was followed.${since}`);
  put(
    question.status,
    `${told}: ${done} of ${counted(size, "start")} were followed; their results can be downloaded.${since}`,
  );
  finished = { ...asked, first: done };
  files.hidden = false;
}

/** @param {any[]} list */
function fillShares(list) {
  const ranked = [...list].sort((a, b) => b.share - a.share);
  put(
    shares,
    ranked.map(({ label, share, interval, low = interval?.[0], high = interval?.[1] }) => {
      const fill = div("fill");
      fill.style.width = `${100 * share}%`;
      const range = div("range");
      if (low !== undefined) Object.assign(range.style, { left: `${100 * low}%`, width: `${100 * (high - low)}%` });
      const within = low === undefined ? "" : ` (${number(100 * low, 3)} to ${number(100 * high, 3)} %)`;
      return h(
        "div",
        { class: "share", "data-label": label },
        h("strong", {}, label),
        h("div", { class: "track", "aria-hidden": "true" }, fill, range),
        h("span", {}, `${percent(share)}${within}`),
      );
    }),
  );
}

/** @param {"nc" | "csv"} format */
function save(format) {
  if (!finished) return;
  put(question.status, "Preparing the file …");
  saveFile("experiment/file", { ...finished, format }, `${fileName()}.${format}`, question.status);
}
