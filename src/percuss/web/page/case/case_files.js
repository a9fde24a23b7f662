// Files that become a case: TOML, and measured histories of the load.

import { post, problemsOf, saidOf, upload } from "../core/api.js";
import { button, div, facts, h, labelled, put } from "../core/dom.js";
import { number, percent, withUnit } from "../core/format.js";
import { signal } from "../core/signals.js";
import { data, setTables, show, view } from "../core/state.js";
import { during } from "../core/under_way.js";
import { takeBlows } from "../drawers/hammer_panel.js";

/** @typedef {import("../core/api.js").Problem} Problem */

const RECORDINGS = [".csv", ".txt", ".tsv", ".dat", ".mat", ".wav", ".h5", ".hdf5", ".tdms"];
const history = h("input", {
  type: "file",
  id: "upload-history",
  accept: RECORDINGS.join(),
  onchange: () => readHistory(),
});
const report = h("div", { id: "history-report", "aria-live": "polite" });
/** How a recording is read. @type {HTMLInputElement[]} */
const options = [];

const refused = signal({ problems: /** @type {Problem[]} */ ([]), change: 0 });

/** What was wrong with the last file, until the case is another. */
export const fileProblems = () => (refused.value.change === data.changed ? refused.value.problems : []);

/** The card with the files, which can also be dropped anywhere. */
export function filesCard() {
  const accept = [".toml", ...RECORDINGS].join();
  const picked = async () => {
    await take([...(toml.files ?? [])]);
    toml.value = "";
  };
  const toml = h("input", { type: "file", id: "upload-toml", accept, multiple: true, onchange: picked });
  const has = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragover", (event) => has(event) && event.preventDefault());
  addEventListener("drop", (event) => {
    if (!has(event)) return;
    event.preventDefault(); // else the browser would leave the page for the file
    take([...(event.dataTransfer?.files ?? [])]);
  });
  const option = (/** @type {string} */ name, /** @type {string} */ label, /** @type {string} */ hint) => {
    const input = h("input", { type: "text", "data-history": name, placeholder: hint });
    options.push(input);
    return labelled(label, input);
  };
  const fields = div(
    "fields",
    option("area", "Piston area", "for a pressure: 6.5 cm^2"),
    option("unit", "Unit", "when the header has none: MPa"),
    option("column", "Column", "name or number"),
    option("time_column", "Time column", "name or number"),
    option("sample_rate", "Sample rate", "without times: 50 kHz"),
    option("opposing_column", "Column for the opposing face", "when there is one: name or number"),
    option("opposing_area", "Opposing area", "for its pressure: 4 cm^2"),
    option("from", "From", "start of the record: 0.2 s"),
    option("to", "To", "end of the record: 1.5 s"),
    option("frequency", "Frequency", "found when empty"),
    option("harmonics", "Harmonics", "found when empty"),
    option("force_scale", "Force scale", "for a dimensionless case: 1 kN"),
  );
  const picker = (/** @type {HTMLInputElement} */ input, /** @type {string} */ words) =>
    h("p", {}, h("label", { for: input.id }, words), h("br"), input);
  return div(
    "card",
    h("h2", {}, "Files"),
    picker(toml, "A case as TOML; if it names a recording, pick both files"),
    h("p", { class: "small muted" }, "Files can also be dropped anywhere on the page."),
    picker(history, "A measured load (CSV and others), used as the load of this case"),
    h(
      "details",
      {},
      h("summary", {}, "How the recording is read"),
      fields,
      button("Read it again", () => readHistory()),
    ),
    report,
  );
}

/** Whether a table tells of blows, a row each, and not of a load over time. @param {File} file */
async function tellsBlows(file) {
  if (!/\.(csv|txt|tsv)$/i.test(file.name)) return false;
  return /(rebound|impact|striking)[_ ]?(speed|velocity)/i.test(await file.slice(0, 400).text());
}

/** A case, a case with its recording, or a recording for the case that is there. @param {File[]} files */
const take = (files) => during("case", taken(files));

/** @param {File[]} files */
async function taken(files) {
  const isCase = (/** @type {File} */ { name }) => /\.toml$/i.test(name);
  const [cases, recordings] = [files.filter(isCase), files.filter((file) => !isCase(file))];
  if (!files.length) return;
  const blows = recordings.length > 0 && (await tellsBlows(recordings[0]));
  if (recordings.length && !blows) show({ panel: "case", tall: 1 }); // how it was read is told there
  if (cases.length > 1 || recordings.length > 1) {
    const remedy = "pick one case and the recording that it names";
    refuse([{ key: "", message: "several cases or several recordings at once", remedy }]);
  } else if (cases.length) {
    await readCase(cases[0], recordings[0]);
  } else if (blows) {
    takeBlows(await recordings[0].text(), recordings[0].name);
  } else {
    const bag = new DataTransfer(); // as if it had been picked there: "Read it again" finds it
    bag.items.add(recordings[0]);
    history.files = bag.files;
    await readHistory();
  }
}

/** @param {File} file @param {File} [record] the recording that it names */
async function readCase(file, record) {
  try {
    const words = new URLSearchParams({ name: record?.name ?? "", toml_bytes: String(file.size) });
    const found = record // the bytes of the one and then those of the other
      ? await upload(`case/recorded?${words}`, new Blob([file, record]))
      : await post("case", { toml: await file.text() });
    Object.assign(data, { base: found.tables, physical: null });
    Object.assign(view, { machine: "", orbit: 0 });
    setTables(found.tables, found);
    put(report, found.history ? recording(found.history, found.notes) : "");
  } catch (error) {
    refuse(problemsOf(error));
  }
}

/** @param {Problem[]} problems */
function refuse(problems) {
  show({ panel: "case", tall: 1 });
  refused.value = { problems, change: data.changed };
}

async function readHistory() {
  const file = history.files?.[0];
  if (!file) return put(report, h("p", { class: "problem" }, "Choose a file first."));
  const words = new URLSearchParams({ name: file.name });
  const kept = data.tables.load;
  for (const { dataset, value } of options) if (value.trim()) words.set(dataset.history ?? "", value.trim());
  if (!words.has("area") && kept?.area && data.tables.bar) words.set("area", kept.area);
  try {
    const found = await upload(`history?${words}`, file);
    put(report, recording(found.report, found.notes));
    setTables({ ...data.tables, load: found.load });
  } catch (error) {
    put(
      report,
      problemsOf(error).map((one) => h("p", { class: "problem", role: "alert" }, saidOf(one))),
    );
  }
  report.scrollIntoView({ block: "nearest" }); // a refusal out of sight is none
}

/** What was found in a recording. @param {Record<string, any>} report @param {string[]} [notes] */
export const recording = (report, notes = []) => [
  h("h3", {}, "The recording"),
  facts([
    ["cycles used", number(report.cycles)],
    ["frequency", `${withUnit(report.frequency, "Hz", 5)} (${report.frequency_given ? "given" : "found"})`],
    ["cycle lengths vary by", percent(report.jitter)],
    ["cycles scatter about their mean", percent(report.scatter)],
    ["drift", percent(report.drift)],
    ["harmonics up to", number(report.harmonics)],
    ["not captured by them", percent(report.residual)],
  ]),
  [...notes, ...(report.warnings ?? [])].map((text) => h("p", { class: "note warn" }, text)),
];
