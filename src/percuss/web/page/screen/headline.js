// The answer first: what the hammer delivers, whether it can sustain it, and why.

import { $, h, put } from "../core/dom.js";
import { number, scaleOf } from "../core/format.js";
import { machineFigures, machineKey, machineVerdict } from "./headline_machine.js";
import { playedFigures, playedKey, playedVerdict, plays } from "./headline_played.js";
import { chosen, data, isHeld, obstacleOf, on, reasonOf, show, switchesItself, unhurried, view } from "../core/state.js";

export function startHeadline() {
  on("quick steady machine problems view info played", unhurried(paint));
}

function paint() {
  const box = $("#headline");
  const key = JSON.stringify([
    data.changed,
    Boolean(data.steady),
    data.quick?.changed,
    view.orbit,
    data.problems,
    data.info?.title,
    data.info?.clock,
    ...playedKey(),
    ...machineKey(),
  ]);
  if (box.dataset.key === key) return; // nothing new to say
  box.dataset.key = key;
  const title = h("p", { class: "title" }, data.tables?.title || data.info?.title || "Untitled case");
  if (data.problems.length) {
    const words = data.problems.map((p) =>
      h("p", {}, [p.key && `${p.key}: `, p.message, p.remedy && ` — ${p.remedy}`]),
    );
    put(
      box,
      h("div", { class: "verdict" }, h("div", { class: "row middle" }, title, badge("bad", "No answer")), words),
    );
    return;
  }
  if (switchesItself()) return data.machine && told(title, machineVerdict(), machineFigures());
  if (!data.quick) return;
  if (plays()) return told(title, playedVerdict(), playedFigures());
  const found = chosen();
  const [mark, words] = found ? verdict(found) : none();
  put(
    box,
    h("div", { class: "verdict" }, h("div", { class: "row middle" }, title, mark), words, clock(), orbits()),
    found && figures(found),
  );
}

/** A verdict and figures as rows. */
function told(title, [kind, text, words], rows) {
  const row = h("div", { class: "row middle" }, title, badge(kind, text));
  const cells = rows.map(([name, value, unit]) => figure(name, value, unit));
  put($("#headline"), h("div", { class: "verdict" }, row, words), h("dl", { class: "figures" }, cells));
}

/** What the verdict takes for granted of a load that switches as a valve does, or where it turns on the load's clock. */
function clock() {
  if (data.quick.clocked) return h("p", { class: "small", id: "clock" }, data.quick.clocked);
  const note = data.info?.clock;
  if (!note) return null;
  const words =
    "The load switches as a valve does. Stability is judged as if the load kept time by itself; a valve would re-time it.";
  return h("p", { class: "small muted", id: "clock", title: note }, words);
}

const badge = (kind, text) => h("span", { class: `badge ${kind}`, id: "verdict" }, text);

function verdict(found) {
  const { stable } = found.quick;
  const obstacle = obstacleOf(found);
  if (obstacle) {
    return [
      badge("bad", "Not possible"),
      h("p", {}, `This steady motion cannot happen: the end ${obstacle}. Its stability: ${reasonOf(found)}.`),
    ];
  }
  return [
    badge(stable ? "good" : "bad", stable ? "Stable" : "Unstable"),
    h("p", { id: "reason" }, sentence(reasonOf(found)), stable && data.steady?.uncertainty ? ` ${data.steady.uncertainty.sentence}` : ""),
  ];
}

function none() {
  const { m, nearest, note } = data.quick;
  const near =
    nearest &&
    [
      nearest.load_factor !== null && `a load factor of ${number(nearest.load_factor)}`,
      nearest.restitution !== null && `a restitution of ${number(nearest.restitution)}`,
    ].filter(Boolean);
  const words =
    note || "The mean load is too great for its alternating part.";
  const way = near?.length ? ` One would exist from ${near.join(" or ")}.` : "";
  return [
    badge("bad", "No steady motion"),
    h(
      "p",
      { id: "reason" },
      `No steady motion has one impact ${m === 1 ? "every load period" : `in ${m} load periods`}. ${words}${way}`,
    ),
  ];
}

const sentence = (text) => (text ? text[0].toUpperCase() + text.slice(1) + "." : "");

const FIRST = ["blow_energy_J", "blow_rate_Hz", "impact_velocity_m_s", "percussive_power_kW", "peak_stress_MPa"];

/** What a figure of the report is called, its value in a unit without a prefix, and this unit. */
function inUnit(key, value) {
  const { label, unit, factor } = data.about.cards.find((card) => card.key === key);
  return [label, value === null ? null : value * factor, unit];
}

function figures({ quick, full }) {
  const si = quick.si;
  const cells = si
    ? (isHeld() ? FIRST.filter((key) => key in si) : FIRST).map((key) => inUnit(key, si[key] ?? (full?.si ? (full.si[key] ?? Number.NaN) : null)))
    : [
        ["blow energy", quick.blow_energy, ""],
        ["striking speed", quick.impact_velocity, ""],
        ["impact phase [rad]", quick.phase, ""],
      ];
  if (!(quick.impact_velocity > 0))
    for (const cell of cells) if (cell[0] !== "impact phase [rad]") cell[1] = Number.NaN; // there is no blow
  cells.push(...(isHeld() ? [["margin of stability", quick.margin, ""]] : margins(full ?? quick, Boolean(full))));
  return h(
    "dl",
    { class: "figures" },
    cells.map(([name, value, unit]) => figure(name, value, unit)),
  );
}

/** Of the rhythm, and of the ringing of a bar that rings, which is known with the full answer. */
const margins = ({ margin_rhythm: rhythm, margin_ringing: ringing }, known) =>
  [["rhythm margin", rhythm, ""], !(known && ringing === null) && ["ringing margin", ringing, ""]].filter(Boolean);

function figure(name, value, unit) {
  if (value === null) return h("div", {}, h("dd", {}, "…"), h("dt", {}, name));
  const scale = unit === "J" || unit === "W" || unit === "Pa" ? scaleOf(value, unit) : { factor: 1, unit };
  return h(
    "div",
    {},
    h("dd", {}, number(value * scale.factor, 4), unit && h("small", {}, scale.unit)),
    h("dt", {}, name),
  );
}

function orbits() {
  const all = data.quick.orbits;
  if (all.length < 2) return null;
  const now = chosen().number;
  const button = (orbit, i) => {
    const label = `Motion ${i + 1} of ${all.length}, ${orbit.stable ? "stable" : "unstable"}`;
    const props = {
      type: "button",
      "aria-pressed": now === i + 1 ? "true" : "false",
      "aria-label": label,
      title: label,
    };
    return h("button", { ...props, onclick: () => show({ orbit: i + 1 }) }, `Motion ${i + 1}`);
  };
  return h("div", { class: "segments", role: "group", "aria-label": "Which steady motion" }, all.map(button));
}
