// What it means in joules, hertz, metres per second and megapascals, as cards; and the report as one file.

import { saveFile } from "../core/api.js";
import { button, div, h, put } from "../core/dom.js";
import { angle, number, percent, scaleOf } from "../core/format.js";
import { effect } from "../core/signals.js";
import {
  chosen,
  data,
  fileName,
  fullAnswer,
  isHeld,
  obstacleOf,
  reasonOf,
  switchesItself,
  view,
} from "../core/state.js";
import { language } from "../core/words.js";

/** @typedef {NonNullable<ReturnType<typeof chosen>>} Found */
/** @typedef {Record<string, any>} Answer */

/** @param {HTMLElement} place */
export function start(place) {
  const head = div("card");
  const cards = h("div", { class: "cards", id: "report-cards" });
  const rest = h("div", { class: "card", id: "report-rest" });
  const status = h("p", { class: "small muted", role: "status", id: "report-status" });
  const simulated = h("input", { type: "checkbox", id: "report-simulated" });
  const save = async (/** @type {string} */ paper) => {
    for (const one of buttons) one.disabled = true;
    put(status, "Writing the report …");
    const body = { case: data.tables, periods: [view.m], simulate: simulated.checked, paper, language };
    await saveFile("report", body, `${fileName()}.${paper ? "pdf" : "html"}`, status);
    for (const one of buttons) one.disabled = false;
  };
  const buttons = [
    button("Report as HTML", () => save(""), { class: "main", id: "report-download" }),
    button("PDF, A4", () => save("a4"), { id: "report-pdf" }),
    button("PDF, Letter", () => save("letter"), { id: "report-letter" }),
  ];
  const tick = h("label", { class: "row middle" }, simulated, "include a simulation from the case's start");
  const words =
    "One file with the answer, a drawing, the figures and the blow, to print and sign; readable without this server.";
  const files = div("card", div("row middle", buttons, tick), h("p", { class: "small muted" }, words), status);
  put(place, head, cards, rest, files);
  effect(() => {
    if (view.panel !== "report" || !data.tables) return;
    const ownReport = switchesItself() || isHeld(); // all that there is to tell stands in the report
    const found = ownReport ? null : chosen();
    put(head, found ? headOf(found) : ownReport ? headOfOther() : headOfNone());
    put(cards, found && found.quick.impact_velocity > 0 && cardsOf(found));
    put(rest, !ownReport && restOf(fullAnswer()?.rest, found));
  });
}

const title = () => data.tables.title ?? "The case";

const headOfOther = () => [
  h("h2", {}, title()),
  h("p", {}, "All figures of its motion and a picture of it are in the report."),
];

const headOfNone = () => [
  h("h2", {}, "No steady motion to report"),
  h("p", {}, data.problems.length ? "See the problem above." : "The headline says what would have to change."),
];

/** @param {Found} found */
function headOf(found) {
  const { full, quick, number: k } = found;
  const rate = view.m === 1 ? "every load period" : `in ${view.m} load periods`;
  const obstacle = obstacleOf(found);
  const possible = full ? (obstacle ? `It is not possible: the end ${obstacle}.` : "It is possible.") : "";
  const ringing = full && full.margin_ringing !== null ? `, ringing margin ${number(full.margin_ringing)}` : "";
  const margins = full ? `; rhythm margin ${number(full.margin_rhythm)}${ringing}` : "";
  return [
    h("h2", {}, `${title()}: motion ${k}, one blow ${rate}`),
    h("p", {}, `At ${angle(quick.phase)} of the load. ${possible} Verdict: ${reasonOf(found)}${margins}.`),
    data.info && h("p", { class: "small" }, `Contact: ${data.info.laws.contact}. Damping: ${data.info.laws.damping}.`),
  ];
}

/** The figures of a motion in SI; a dimensionless case has no joules. @param {Found} found */
const cardsOf = ({ quick, full }) =>
  full?.si ? data.about.cards.map((/** @type {Answer} */ row) => figure(full.si, row)) : plain(quick, full);

/** @param {string} name
 * @param {string} value @param {string} unit @param {string} about @param {Record<string, any>} [attributes] */
const card = (name, value, unit, about, attributes = {}) =>
  h(
    "div",
    { class: "card", ...attributes },
    div("name", name),
    div("value", value, unit && h("small", {}, unit)),
    div("small muted", about),
  );

const SCALED = new Set(["J", "W", "m", "Pa", "s", "N"]);

/** A figure as the server describes it; one without a unit is a share. @param {Answer} si @param {Answer} figure */
function figure(si, { key, label, meaning, unit, factor }) {
  const value = si[key] ?? null;
  const shown = unit === "" ? { factor: 100, unit: "%" } : { factor, unit };
  const scale = value !== null && SCALED.has(unit) ? scaleOf(value * factor, unit) : { factor: 1, unit: shown.unit };
  const text = value === null ? "–" : number(value * shown.factor * scale.factor);
  const own = { "data-figure": key, "data-value": value };
  return card(label[0].toUpperCase() + label.slice(1), text, scale.unit, meaning, own);
}

/** @param {Answer} quick @param {Answer | null | undefined} full */
const plain = (quick, full) => [
  card("Impact phase", number(quick.phase), "", "rad of the load"),
  card("Striking speed", number(quick.impact_velocity), "", "u_t(1, 0⁻), the striking end"),
  card("Rigid speed", number(quick.rigid_velocity), "", "of the rigid motion"),
  card("Blow energy", number(quick.blow_energy), "", "times M L³ Ω²"),
  card("Energy in, per blow", number(full?.energy.input), "", "from the load"),
  card("Energy to damping", number(full?.energy.damping), "", "per blow"),
  card("Energy to the blow", number(full?.energy.impact), "", "per blow"),
  card("Stability margin", number((full ?? quick).margin), "", "1 minus the largest multiplier"),
];

/** Whether the bar may lie at rest on the wall, and where the energy of the motion goes.
 * @param {Answer | undefined} rest @param {Found | null} motion */
function restOf(rest, motion) {
  if (!rest) return h("p", { class: "muted" }, "…");
  const force = data.info?.scales?.force_N;
  const inUnits = (/** @type {number | null} */ least) => {
    if (least === null) return "minus infinity (resonance)";
    const value = force ? scaleOf(least * force, "N") : { factor: 1, unit: "" };
    return `${number(least * (force ?? 1) * value.factor)} ${value.unit}`.trim();
  };
  const [least, load] = [inUnits(rest.least_contact_force), inUnits(rest.quasi_static)];
  const words = rest.held_by_waves
    ? `Possible only with every wave in the bar: with them the contact force never falls below ${least}, but the load itself falls to ${load}. A simulation goes by the load and lets the bar go there.`
    : rest.possible
      ? `Possible: with the waves in the bar the contact force never falls below ${least} (the load itself not below ${load}).`
      : rest.lifted_by_waves
        ? `Not possible: waves in the bar let the contact force fall to ${least} and lift the end off briefly (for 2L/C), though the load itself never falls below ${load}.`
        : `Not possible: with the waves in the bar the contact force would fall to ${least} (the load itself to ${load}), so the load pulls the bar off.`;
  const { warnings = [], energy } = motion?.full ?? {};
  const share = (/** @type {number} */ part) => percent(part / energy.input);
  return [
    h("h3", {}, "Lying at rest on the wall"),
    h("p", {}, words),
    rest.note && h("p", {}, `${rest.note}.`),
    energy &&
      h(
        "p",
        {},
        `The energy put in per blow goes to the blow (${share(energy.impact)}) and to damping (${share(energy.damping)}).`,
      ),
    warnings.map((/** @type {string} */ text) => h("p", { class: "note warn" }, text)),
  ];
}
