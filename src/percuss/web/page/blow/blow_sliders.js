// Sliders for the sizes of striker and tool, the rock, and the speed: keys of the case.

import { div, h, put, settled } from "../core/dom.js";
import { plainNumber, quantity, withUnit } from "../core/format.js";
import { steps, valueAt, withKey } from "../core/moves.js";
import { whenever } from "../core/signals.js";
import { data, setTables, view } from "../core/state.js";
import { tr } from "../core/words.js";
import { struckNow, whatIsStruck } from "./blow_target.js";

/** @typedef {import("../core/moves.js").Tables} Tables */

const SIZES = ["length", "diameter", "area", "bore"];

/** @type {{ follow: () => void }[]} */
let rows = [];
/** What the sliders have moved since the case was last set. @type {Record<string, any>} */
let moves = {};
/** @type {(tables: Tables) => void} */
let told = () => {};

/** The card; `moved` is told the case as the sliders have it, at once; all other panels, when they rest. The sliders are
 * others when their keys or units are. @param {(tables: Tables) => void} moved */
export function blowSliders(moved) {
  told = moved;
  const card = h("div", { class: "card", id: "blow-sliders" });
  const keys = () =>
    keysOf(data.tables).map(([key, words]) => [key, words, quantity(valueAt(data.tables, key))?.unit ?? ""]);
  whenever(
    () => view.panel === "blow" && data.tables && [keys(), struckNow(data.tables)],
    () => {
      const made = keys().map(([key, words, unit]) => slider(key, words, unit));
      rows = made;
      put(
        card,
        h("h2", {}, "Striker, tool and rock"),
        div("row", whatIsStruck("blow-struck")),
        div(
          "grid sizes",
          made.map(({ box }) => box),
        ),
      );
    },
  );
  return card;
}

/** The values of the sliders. */
export const followBlowSliders = () => rows.forEach(({ follow }) => follow());

/** What may be 0, up to so much in SI where it is. @type {[RegExp, number][]} */
const FROM_0 = [
  [/^feed\.force$/, 2e4],
  [/^feed\.damping$/, 1e5],
  [/\.attenuation$/, 0.02],
];

/** @type {Record<string, number>} */
const PREFIXES = { k: 1e-3, M: 1e-6 };

/** [least, greatest, step] of a slider that begins at a quantity: round numbers. @param {string} key @param {number} value
 * @param {string} unit */
function rangeFor(key, value, unit) {
  if (key === "rock.unloading_ratio") return [0.05, 1, 0.01];
  const [, most] = FROM_0.find(([pattern]) => pattern.test(key)) ?? [];
  if (most === undefined) return [0.25, 2, 0.005].map((part) => part * value);
  const top = 2 * value || most * (PREFIXES[unit[0]] ?? 1);
  return [0, top, top / 400];
}

/** [key, words] of what there is a slider for. @param {Tables} tables @returns {[string, string][]} */
function keysOf(tables) {
  const { bar, system, tool, feed } = tables;
  const all = (/** @type {any} */ list) => /** @type {any[]} */ (Array.isArray(list) ? list : []);
  const sized = (/** @type {string} */ table, /** @type {string} */ who) =>
    SIZES.map((name) => [`${table}.${name}`, `${who}: ${name}`]);
  const several = (/** @type {string} */ table, /** @type {any} */ list, /** @type {string} */ who) =>
    all(list).flatMap((_, i) => sized(`${table}.sections[${i}]`, list.length > 1 ? `${who} ${i + 1}` : who));
  const numbered = (/** @type {string} */ name, /** @type {string} */ words) =>
    all(system?.[name]).map((_, i) => [`system.${name}[${i}]`, `Striker ${i + 1}: ${words}`]);
  const attenuation = (/** @type {any} */ _, /** @type {number} */ i) => [
    `tool.sections[${i}].attenuation`,
    `Tool${tool.sections.length > 1 ? ` ${i + 1}` : ""}: attenuation α`,
  ];
  const found = [
    ...sized("bar", "Striker"),
    ...several("bar", bar?.sections, "Striker"),
    ...numbered("impedances", "impedance"),
    ...numbered("transit_times", "transit time"),
    ...several("tool", tool?.sections, "Tool"),
    ["tool.impedance", "Tool: impedance, over that of the bar's end"],
    ...all(tool?.sections).map(attenuation),
    ["feed.force", feed?.of === "machine" ? "Feed: force on the machine" : "Feed: force"],
    ["feed.damping", "Feed: dashpot of the recoil damper"],
    ["rock.stiffness", "Rock: stiffness K₁"],
    ["rock.unloading_ratio", "Rock: unloading ratio γ"],
    ["blow.velocity", "Speed of the blow"],
  ];
  return /** @type {[string, string][]} */ (found.filter(([key]) => quantity(valueAt(tables, key))));
}

/** @param {string} key @param {string} words @param {string} unit */
function slider(key, words, unit) {
  const id = `blow-slide-${steps(key).join("-")}`;
  const now = () => quantity(valueAt(data.tables, key))?.value;
  const [min, max, step] = rangeFor(key, now() ?? 0, unit);
  const output = h("output", { for: id });
  const say = (/** @type {number} */ value) => {
    const text = withUnit(value, unit);
    put(output, text);
    input.setAttribute("aria-valuetext", tr(text));
  };
  const oninput = () => {
    const value = plainNumber(Math.min(Math.max(Number(input.value), min), max));
    moves[key] = unit ? `${value} ${unit}` : value;
    told(movedTables());
    rest();
    say(value);
  };
  const input = h("input", { type: "range", id, min, max, step, oninput });
  const follow = () => {
    const value = now();
    if (value === undefined || key in moves) return;
    input.max = String(Math.max(value, Number(input.max)));
    input.min = String(Math.min(value, Number(input.min)));
    if (document.activeElement !== input || Math.abs(Number(input.value) - value) > Number(input.step))
      input.value = String(value);
    say(value);
  };
  follow();
  const head = div("head", h("label", { for: id }, words), output);
  return { box: div("slider", head, input), follow };
}

/** The case with what the sliders have moved since it was last set. @returns {Tables} */
const movedTables = () =>
  Object.entries(moves).reduce((found, [key, value]) => withKey(found, key, value), data.tables);

const rest = settled(() => {
  const tables = movedTables();
  moves = {};
  setTables(tables);
}, 200);
