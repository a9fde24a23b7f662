// Files that become a case: TOML, and measured histories of the load.

import { post, problemsOf, saidOf, upload } from "../core/api.js";
import { $, $$, facts, h, put } from "../core/dom.js";
import { number, percent, withUnit } from "../core/format.js";
import { data, setTables, show, view } from "../core/state.js";
import { during } from "../core/under_way.js";
import { takeBlows } from "../drawers/hammer_panel.js";

const RECORDINGS = [".csv", ".txt", ".tsv", ".dat", ".mat", ".wav", ".h5", ".hdf5", ".tdms"];
const parts = {};
let refused = { problems: [], change: 0 };

/** What was wrong with the last file, until the case is another. */
export const fileProblems = () => (refused.change === data.changed ? refused.problems : []);

export const fileName = () =>
  (data.tables?.title || "case")
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-")
    .replace(/^-+|-+$/g, "") || "case";

/** The card with the files; `told` is called when a file was refused. */
export function filesCard(told) {
  parts.told = told;
  const toml = h("input", {
    type: "file",
    id: "upload-toml",
    accept: [".toml", ...RECORDINGS].join(),
    multiple: true,
    onchange: pickedCase,
  });
  const history = h("input", {
    type: "file",
    id: "upload-history",
    accept: RECORDINGS.join(),
    onchange: () => readHistory(),
  });
  droppable();
  const extra = (name, label, hint) =>
    h("label", { class: "pick" }, label, h("input", { type: "text", "data-history": name, placeholder: hint }));
  parts.history = h("div", { id: "history-report", "aria-live": "polite" });
  parts.options = h(
    "div",
    { class: "fields" },
    extra("area", "Piston area", "for a pressure: 6.5 cm^2"),
    extra("unit", "Unit", "when the header has none: MPa"),
    extra("column", "Column", "name or number"),
    extra("time_column", "Time column", "name or number"),
    extra("sample_rate", "Sample rate", "without times: 50 kHz"),
    extra("opposing_column", "Column for the opposing face", "when there is one: name or number"),
    extra("opposing_area", "Opposing area", "for its pressure: 4 cm^2"),
    extra("from", "From", "start of the record: 0.2 s"),
    extra("to", "To", "end of the record: 1.5 s"),
    extra("frequency", "Frequency", "found when empty"),
    extra("harmonics", "Harmonics", "found when empty"),
    extra("force_scale", "Force scale", "for a dimensionless case: 1 kN"),
  );
  return h(
    "div",
    { class: "card" },
    h("h2", {}, "Files"),
    h("p", {}, h("label", { for: "upload-toml" }, "A case as TOML; if it names a recording, pick both files"), h("br"), toml),
    h("p", { class: "small muted" }, "Files can also be dropped anywhere on the page."),
    h(
      "p",
      {},
      h("label", { for: "upload-history" }, "A measured load (CSV and others), used as the load of this case"),
      h("br"),
      history,
    ),
    h(
      "details",
      {},
      h("summary", {}, "How the recording is read"),
      parts.options,
      h("button", { type: "button", onclick: () => readHistory() }, "Read it again"),
    ),
    parts.history,
  );
}

const isCase = (file) => /\.toml$/i.test(file.name);

async function pickedCase(event) {
  await take([...event.target.files]);
  event.target.value = "";
}

/** Files dropped anywhere become the case, or its load. */
function droppable() {
  const files = (event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragover", (event) => files(event) && event.preventDefault());
  addEventListener("drop", (event) => {
    if (!files(event)) return;
    event.preventDefault(); // else the browser would leave the page for the file
    take([...event.dataTransfer.files]);
  });
}

/** Whether a table tells of blows, a row each, and not of a load over time. */
async function tellsBlows(file) {
  if (!file || !/\.(csv|txt|tsv)$/i.test(file.name)) return false;
  return /(rebound|impact|striking)[_ ]?(speed|velocity)/i.test(await file.slice(0, 400).text());
}

/** A case, a case with its recording, or a recording for the case that is there. */
const take = (files) => during("case", taken(files));

async function taken(files) {
  const [cases, recordings] = [files.filter(isCase), files.filter((file) => !isCase(file))];
  if (!files.length) return;
  if (recordings.length && !(await tellsBlows(recordings[0]))) show({ panel: "case", tall: 1 }); // how it was read is told there
  if (cases.length > 1 || recordings.length > 1) {
    refuse([{ key: "", message: "several cases or several recordings at once", remedy: "pick one case and the recording that it names" }]);
  } else if (cases.length) {
    await readCase(cases[0], recordings[0] ?? null);
  } else if (await tellsBlows(recordings[0])) {
    return takeBlows(await recordings[0].text(), recordings[0].name);
  } else {
    const bag = new DataTransfer(); // as if it had been picked there: "Read it again" finds it
    bag.items.add(recordings[0]);
    $("#upload-history").files = bag.files;
    await readHistory();
  }
}

async function readCase(file, record) {
  try {
    const found = record ? await readRecorded(file, record) : await post("case", { toml: await file.text() });
    Object.assign(data, { base: null, physical: null });
    Object.assign(view, { machine: "", orbit: 0 });
    setTables(found.tables, found);
    show({});
    put(parts.history, found.history ? recording(found.history, found.notes) : "");
  } catch (error) {
    refuse(problemsOf(error));
  }
}

/** A case file and its recording, in one request: the bytes of the one and then those of the other. */
async function readRecorded(file, record) {
  const words = new URLSearchParams({ name: record.name, toml_bytes: String(file.size) });
  return upload(`case/recorded?${words}`, new Blob([file, record]));
}

function refuse(problems) {
  show({ panel: "case", tall: 1 });
  refused = { problems, change: data.changed };
  parts.told();
}

async function readHistory() {
  const file = $("#upload-history").files[0];
  if (!file) return put(parts.history, h("p", { class: "problem" }, "Choose a file first."));
  const words = new URLSearchParams({ name: file.name });
  const kept = data.tables.load;
  for (const input of $$("input[data-history]", parts.options))
    if (input.value.trim()) words.set(input.dataset.history, input.value.trim());
  if (!words.has("area") && kept?.area && data.tables.bar) words.set("area", kept.area);
  try {
    const found = await upload(`history?${words}`, file);
    put(parts.history, recording(found.report, found.notes));
    setTables({ ...data.tables, load: found.load });
    parts.history.scrollIntoView({ block: "nearest" });
  } catch (error) {
    const list = problemsOf(error);
    put(
      parts.history,
      list.map((p) => h("p", { class: "problem", role: "alert" }, saidOf(p))),
    );
    parts.history.scrollIntoView({ block: "nearest" }); // a refusal out of sight is none
  }
}

/** What was found in a recording. */
export function recording(report, notes = []) {
  const rows = [
    ["cycles used", number(report.cycles)],
    ["frequency", `${withUnit(report.frequency, "Hz", 5)} (${report.frequency_given ? "given" : "found"})`],
    ["cycle lengths vary by", percent(report.jitter)],
    ["cycles scatter about their mean", percent(report.scatter)],
    ["drift", percent(report.drift)],
    ["harmonics up to", number(report.harmonics)],
    ["not captured by them", percent(report.residual)],
  ];
  const words = [...notes, ...(report.warnings ?? [])].map((text) => h("p", { class: "note warn" }, text));
  return [h("h3", {}, "The recording"), facts(rows), words];
}
