// What it means in joules, hertz, metres per second and megapascals, as cards; and the report as one file.

import { postFile } from "../core/api.js";
import { fileName } from "../case/case_files.js";
import { download, h, put } from "../core/dom.js";
import { angle, number, percent, scaleOf } from "../core/format.js";
import { chosen, data, isHeld, obstacleOf, on, reasonOf, switchesItself, view } from "../core/state.js";

const parts = {};

export function start(panel) {
  parts.head = h("div", { class: "card" });
  parts.cards = h("div", { class: "cards", id: "report-cards" });
  parts.rest = h("div", { class: "card", id: "report-rest" });
  parts.button = h(
    "button",
    { type: "button", class: "main", id: "report-download", onclick: () => save("") },
    "Report as HTML",
  );
  parts.paper = h("button", { type: "button", id: "report-pdf", onclick: () => save("a4") }, "PDF, A4");
  parts.letter = h("button", { type: "button", id: "report-letter", onclick: () => save("letter") }, "PDF, Letter");
  parts.simulated = h("input", { type: "checkbox", id: "report-simulated" });
  parts.status = h("p", { class: "small muted", role: "status", id: "report-status" });
  const tick = h("label", { class: "row middle" }, parts.simulated, "include a simulation from the case's start");
  put(
    panel,
    parts.head,
    parts.cards,
    parts.rest,
    h(
      "div",
      { class: "card" },
      h("div", { class: "row middle" }, parts.button, parts.paper, parts.letter, tick),
      h(
        "p",
        { class: "small muted" },
        "One file with the answer, a drawing, the figures and the blow, to print and sign; readable without this server.",
      ),
      parts.status,
    ),
  );
  on("tables steady quick view info", paint);
}

async function save(paper) {
  const buttons = [parts.button, parts.paper, parts.letter];
  for (const button of buttons) button.disabled = true;
  put(parts.status, "Writing the report …");
  try {
    const body = { case: data.tables, periods: [view.m], simulate: parts.simulated.checked, paper };
    const { blob, name } = await postFile("report", body, `${fileName()}.${paper ? "pdf" : "html"}`);
    download(blob, name);
    put(parts.status, `Saved as ${name}, ${number(blob.size / 1000, 3)} kB.`);
  } catch (error) {
    put(parts.status, h("span", { class: "problem" }, error.message));
  }
  for (const button of buttons) button.disabled = false;
}

const marginsOf = (full) => {
  if (!full) return "";
  const ringing = full.margin_ringing === null ? "" : `, ringing margin ${number(full.margin_ringing)}`;
  return `; rhythm margin ${number(full.margin_rhythm)}${ringing}`;
};

const SCALED = new Set(["J", "W", "m", "Pa", "s", "N"]);

function paint() {
  if (view.panel !== "report") return;
  if (switchesItself() || isHeld()) {
    put(parts.head, h("h2", {}, data.tables.title ?? "The case"), h("p", {}, "All figures of its motion and a picture of it are in the report."));
    put(parts.cards);
    return put(parts.rest);
  }
  const found = chosen();
  if (!found) {
    put(
      parts.head,
      h("h2", {}, "No steady motion to report"),
      h("p", {}, data.problems.length ? "See the problem above." : "The headline says what would have to change."),
    );
    put(parts.cards);
    return rest();
  }
  const { full, quick, number: k } = found;
  const title = `${data.tables.title ?? "The case"}: motion ${k}, one blow ${view.m === 1 ? "every load period" : `in ${view.m} load periods`}`;
  const obstacle = obstacleOf(found);
  const possible = full ? (obstacle ? `It is not possible: the end ${obstacle}.` : "It is possible.") : "";
  put(
    parts.head,
    h("h2", {}, title),
    h(
      "p",
      {},
      `At ${angle(quick.phase)} of the load. ${possible} Verdict: ${reasonOf(found)}${marginsOf(full)}.`,
    ),
    data.info && h("p", { class: "small" }, `Contact: ${data.info.laws.contact}. Damping: ${data.info.laws.damping}.`),
  );
  const strikes = quick.impact_velocity > 0;
  put(parts.cards, strikes && (full?.si ? data.about.cards.map((row) => card(full.si, row)) : plain(found)));
  rest();
}

/** A figure as the server describes it; one without a unit is a share. */
function card(si, { key, label, meaning, unit, factor }) {
  const value = si[key];
  const known = value !== null && value !== undefined;
  const shown = unit === "" ? { factor: 100, unit: "%" } : { factor, unit };
  const scale = known && SCALED.has(unit) ? scaleOf(value * factor, unit) : { factor: 1, unit: shown.unit };
  const text = known ? number(value * shown.factor * scale.factor) : "–";
  return h(
    "div",
    { class: "card", "data-figure": key, "data-value": known ? value : null },
    h("div", { class: "name" }, label[0].toUpperCase() + label.slice(1)),
    h("div", { class: "value" }, text, h("small", {}, scale.unit)),
    h("div", { class: "small muted" }, meaning),
  );
}

/** A dimensionless case has no joules; these are its figures. */
function plain({ quick, full }) {
  const rows = [
    ["Impact phase", quick.phase, "rad of the load"],
    ["Striking speed", quick.impact_velocity, "u_t(1, 0⁻), the striking end"],
    ["Rigid speed", quick.rigid_velocity, "of the rigid motion"],
    ["Blow energy", quick.blow_energy, "times M L³ Ω²"],
    ["Energy in, per blow", full?.energy.input, "from the load"],
    ["Energy to damping", full?.energy.damping, "per blow"],
    ["Energy to the blow", full?.energy.impact, "per blow"],
    ["Stability margin", (full ?? quick).margin, "1 minus the largest multiplier"],
  ];
  return rows.map(([name, value, about]) =>
    h(
      "div",
      { class: "card" },
      h("div", { class: "name" }, name),
      h("div", { class: "value" }, number(value)),
      h("div", { class: "small muted" }, about),
    ),
  );
}

function rest() {
  const found = data.steady?.rest;
  if (!found) return put(parts.rest, h("p", { class: "muted" }, "…"));
  const force = data.info?.scales?.force_N;
  const inUnits = (least) => {
    if (least === null) return "minus infinity (resonance)";
    const value = force ? scaleOf(least * force, "N") : { factor: 1, unit: "" };
    return `${number(least * (force ?? 1) * value.factor)} ${value.unit}`.trim();
  };
  const [least, load] = [inUnits(found.least_contact_force), inUnits(found.quasi_static)];
  const words = found.held_by_waves
    ? `Possible only with every wave in the bar: with them the contact force never falls below ${least}, but the load itself falls to ${load}. A simulation goes by the load and lets the bar go there.`
    : found.possible
    ? `Possible: with the waves in the bar the contact force never falls below ${least} (the load itself not below ${load}).`
    : found.lifted_by_waves
      ? `Not possible: waves in the bar let the contact force fall to ${least} and lift the end off briefly (for 2L/C), though the load itself never falls below ${load}.`
      : `Not possible: with the waves in the bar the contact force would fall to ${least} (the load itself to ${load}), so the load pulls the bar off.`;
  const warnings = (chosen()?.full?.warnings ?? []).map((text) => h("p", { class: "note warn" }, text));
  const energy = chosen()?.full?.energy;
  const closes =
    energy &&
    `The energy put in per blow goes to the blow (${percent(energy.impact / energy.input)}) and to damping (${percent(energy.damping / energy.input)}).`;
  put(parts.rest, h("h3", {}, "Lying at rest on the wall"), h("p", {}, words), found.note && h("p", {}, `${found.note}.`), closes && h("p", {}, closes), warnings);
}
