// Random starts, followed until their motions are found: the shares of the attractors fill up while they come in.

import { Refusal, postFile, stream } from "../core/api.js";
import { fileName } from "../case/case_files.js";
import { $, download, h, put, select } from "../core/dom.js";
import { counted, number, percent } from "../core/format.js";
import { data, on, show, view } from "../core/state.js";

const DISTRIBUTIONS = { wall: "near the wall", field: "all over, ringing", gentle: "gentle" };

/** A message of the server with the distributions as they are called here. */
const inPageWords = (text) => Object.entries(DISTRIBUTIONS).reduce((told, [name, words]) => told.replaceAll(`'${name}'`, `“${words}”`), text);

const parts = {};
let running = null; // the abort controller of the experiment under way
let finished = null; // the question that the shown result answers; of one that was cancelled with `first`, its starts
let followed = { done: 0, size: 0 }; // how far the one under way is

export function start(panel) {
  parts.form = h("form", { class: "row", id: "experiment-form", onsubmit: (event) => (event.preventDefault(), run()) });
  parts.bar = h("progress", { max: 1, value: 0, "aria-label": "Progress", id: "experiment-progress" });
  parts.status = h(
    "p",
    { role: "status", id: "experiment-status" },
    "Each start is followed impact by impact until its motion is known.",
  );
  parts.problem = h("p", { class: "problem", role: "alert", id: "experiment-problem" });
  parts.shares = h("div", { class: "shares", id: "experiment-shares" });
  parts.files = h(
    "div",
    { class: "row", id: "experiment-files", hidden: true },
    h("button", { type: "button", onclick: () => save("nc") }, "Download NetCDF"),
    h("button", { type: "button", onclick: () => save("csv") }, "Download CSV"),
  );
  put(
    panel,
    h(
      "div",
      { class: "card" },
      h("h2", {}, "Random starts"),
      h(
        "p",
        { class: "muted small" },
        "Where does the motion end up from a random start? Bars: the share of the starts; dark lines: its 95 % interval.",
      ),
      parts.form,
      parts.problem,
    ),
    h("div", { class: "card" }, parts.bar, parts.status, parts.shares, parts.files),
  );
  on("view", () => view.panel === "experiment" && build());
  on("tables", changed);
}

function build() {
  if (!data.about) return;
  if (parts.form.dataset.built) return fill();
  parts.form.dataset.built = "1";
  const whole = (name, label, least, most) => {
    const id = `experiment-${name}`;
    const change = (event) => show({ [name]: Math.round(Number(event.target.value)) || least });
    return h(
      "label",
      { class: "pick" },
      h("span", {}, label),
      h("input", {
        type: "number",
        id,
        min: least,
        max: most,
        step: 1,
        ".value": String(view[name]),
        onchange: change,
      }),
    );
  };
  const { limits } = data.about;
  parts.go = h("button", { type: "submit", class: "main", id: "experiment-run" }, "Start");
  parts.cancel = h(
    "button",
    { type: "button", id: "experiment-cancel", ".disabled": true, onclick: () => running?.abort() },
    "Cancel",
  );
  put(
    parts.form,
    whole("starts", `Starts, up to ${number(limits.starts, 6)}`, 1, limits.starts),
    select(
      "Drawn",
      data.about.distributions.map((name) => [name, DISTRIBUTIONS[name] ?? name]),
      view.distribution,
      (distribution) => show({ distribution }),
      { id: "experiment-distribution" },
    ),
    whole("seed", "Seed", 0, 2 ** 31),
    whole("emodes", "Elastic modes, 0: rigid", 0, limits.simulation_modes),
    parts.go,
    parts.cancel,
  );
}

/** The fields as a lesson or Back has left the view; the one that is being typed into is left alone. */
function fill() {
  for (const name of ["starts", "distribution", "seed", "emodes"]) {
    const input = $(`#experiment-${name}`);
    if (input !== document.activeElement && input.value !== String(view[name])) input.value = String(view[name]);
  }
}

const question = () => ({
  case: data.tables,
  starts: view.starts,
  distribution: view.distribution,
  seed: view.seed,
  modes: view.emodes,
  impacts: null,
});

async function run() {
  if (running) return;
  const asked = question();
  running = new AbortController();
  const { signal } = running;
  finished = null;
  followed = { done: 0, size: asked.starts };
  busy(true);
  put(parts.problem);
  put(parts.shares);
  parts.files.hidden = true;
  parts.bar.value = 0;
  put(parts.status, "Starting …");
  try {
    await stream("experiment", asked, (event, found) => heard(event, found, asked), signal);
    if (!finished && !parts.problem.textContent) put(parts.problem, "The answer ended early: start the experiment again.");
    if (!finished) kept("Ended early", asked);
  } catch (error) {
    if (error.name !== "AbortError") put(parts.problem, inPageWords(error.message));
    kept(error.name === "AbortError" ? "Cancelled" : followed.done ? "Ended early" : "Not started", asked);
  }
  running = null;
  busy(false);
}

/** What there is of an experiment that did not come to its end: its first starts can be kept. */
function kept(how, asked) {
  const { done, size } = followed;
  const since = data.tables === asked.case ? "" : " The case has changed since.";
  if (!done) return put(parts.status, `${how}: no start was followed.${since}`);
  put(parts.status, `${how}: ${done} of ${counted(size, "start")} were followed; their results can be downloaded.${since}`);
  finished = { ...asked, first: done };
  parts.files.hidden = false;
}

function busy(on_) {
  parts.go.disabled = on_;
  parts.cancel.disabled = !on_;
}

function heard(event, found, asked) {
  if (event === "error") return put(parts.problem, inPageWords(new Refusal(0, found.problems).message));
  if (event === "progress") {
    followed = found;
    parts.bar.value = found.fraction ?? found.done / found.size;
    const rest = found.seconds_left ? `, about ${number(Math.ceil(found.seconds_left))} s left` : "";
    put(parts.status, `${found.done} of ${counted(found.size, "start")}${rest}.`);
    return shares(found.shares);
  }
  if (event !== "done") return;
  finished = asked;
  data.experiment = { starts: asked.starts };
  parts.bar.value = 1;
  parts.files.hidden = false;
  const all = found.attractors ?? found.shares ?? [];
  put(
    parts.status,
    `${counted(found.starts ?? asked.starts, "start")}, all followed; ${counted(all.length, "kind")} of motion.`,
  );
  shares(all);
}

function shares(list) {
  const ranked = [...list].sort((a, b) => b.share - a.share);
  put(
    parts.shares,
    ranked.map((one) => {
      const low = one.low ?? one.interval?.[0];
      const high = one.high ?? one.interval?.[1];
      const fill = h("div", { class: "fill" });
      fill.style.width = `${100 * one.share}%`;
      const range = h("div", { class: "range" });
      if (low !== undefined) Object.assign(range.style, { left: `${100 * low}%`, width: `${100 * (high - low)}%` });
      const words =
        low === undefined
          ? percent(one.share)
          : `${percent(one.share)} (${number(100 * low, 3)} to ${number(100 * high, 3)} %)`;
      return h(
        "div",
        { class: "share", "data-label": one.label },
        h("strong", {}, one.label),
        h("div", { class: "track", "aria-hidden": "true" }, fill, range),
        h("span", {}, words),
      );
    }),
  );
}

async function save(format) {
  if (!finished) return;
  put(parts.status, "Preparing the file …");
  try {
    const { blob, name } = await postFile("experiment/file", { ...finished, format }, `${fileName()}.${format}`);
    download(blob, name);
    put(parts.status, `Saved as ${name}, ${number(blob.size / 1000, 3)} kB.`);
  } catch (error) {
    put(parts.problem, error.message);
  }
}

/** Another case: what is shown is of the case before. */
function changed() {
  if (!finished && !running) return;
  running?.abort();
  if (finished) put(parts.status, "The case has changed since: this is the result for the previous case.");
}
