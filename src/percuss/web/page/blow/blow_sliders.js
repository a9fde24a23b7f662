// Sliders for the sizes of striker and tool, the rock, and the speed: keys of the case.

import { struckNow, whatIsStruck } from "./blow_target.js";
import { h, put, settled } from "../core/dom.js";
import { plainNumber, quantity, withUnit } from "../core/format.js";
import { steps, valueAt, withKey } from "../core/moves.js";
import { data, setTables } from "../core/state.js";
import { tr } from "../core/words.js";

const WORDS = {
  length: "length",
  diameter: "diameter",
  area: "area",
  bore: "bore",
  impedance: "impedance, over that of the bar's end",
  impedances: "impedance",
  transit_times: "transit time",
};

const parts = { key: "", rows: new Map(), moves: {} };

/** The card; `moved` is told the case as the sliders have it, at once; all other panels, when they rest. */
export function blowSliders(moved) {
  parts.moved = moved;
  parts.box = h("div", { class: "card", id: "blow-sliders" });
  return parts.box;
}

/** The sliders anew when there are other ones, else their values. */
export function followBlowSliders() {
  const keys = keysOf(data.tables ?? {});
  const now = JSON.stringify([keys.map(([key, words]) => [key, words, quantity(valueAt(data.tables, key)).unit]), struckNow(data.tables ?? {})]);
  if (now !== parts.key) {
    parts.key = now;
    parts.rows = new Map(keys.map(([key, words]) => [key, slider(key, words)]));
    put(
      parts.box,
      h("h2", {}, "Striker, tool and rock"),
      h("div", { class: "row" }, whatIsStruck("blow-struck")),
      h("div", { class: "grid sizes" }, [...parts.rows.values()].map((row) => row.box)),
    );
  }
  for (const row of parts.rows.values()) row.follow();
}

/** What may be 0, up to so much in SI where it is. */
const FROM_0 = [[/^feed\.force$/, 2e4], [/^feed\.damping$/, 1e5], [/\.attenuation$/, 0.02]];

/** [least, greatest, step] of a slider that begins at a quantity: round numbers. */
function rangeFor(key, { value, unit }) {
  if (key === "rock.unloading_ratio") return [0.05, 1, 0.01];
  const [, most] = FROM_0.find(([pattern]) => pattern.test(key)) ?? [];
  if (most === undefined) return [0.25, 2, 0.005].map((part) => part * value);
  const top = 2 * value || most * ({ k: 1e-3, M: 1e-6 }[unit[0]] ?? 1);
  return [0, top, top / 400];
}

/** [key, words] of what there is a slider for. */
function keysOf({ bar, system, tool, feed, rock, blow }) {
  const found = [];
  const add = (table, name, words) =>
    quantity(valueAt({ bar, system, tool, feed, rock, blow }, `${table}.${name}`)) && found.push([`${table}.${name}`, words]);
  const sizes = (table, who) => ["length", "diameter", "area", "bore"].forEach((name) => add(table, name, `${who}: ${WORDS[name]}`));
  const several = (table, list, who) =>
    (Array.isArray(list) ? list : []).forEach((_, i) =>
      sizes(`${table}.sections[${i}]`, list.length > 1 ? `${who} ${i + 1}` : who),
    );
  if (bar) sizes("bar", "Striker");
  several("bar", bar?.sections, "Striker");
  for (const name of ["impedances", "transit_times"])
    (Array.isArray(system?.[name]) ? system[name] : []).forEach((_, i) =>
      add("system", `${name}[${i}]`, `Striker ${i + 1}: ${WORDS[name]}`),
    );
  several("tool", tool?.sections, "Tool");
  add("tool", "impedance", `Tool: ${WORDS.impedance}`);
  (Array.isArray(tool?.sections) ? tool.sections : []).forEach((_, i) =>
    add(`tool.sections[${i}]`, "attenuation", `Tool${tool.sections.length > 1 ? ` ${i + 1}` : ""}: attenuation α`),
  );
  add("feed", "force", feed?.of === "machine" ? "Feed: force on the machine" : "Feed: force");
  add("feed", "damping", "Feed: dashpot of the recoil damper");
  add("rock", "stiffness", "Rock: stiffness K₁");
  add("rock", "unloading_ratio", "Rock: unloading ratio γ");
  add("blow", "velocity", "Speed of the blow");
  return found;
}

function slider(key, words) {
  const id = `blow-slide-${steps(key).join("-")}`;
  const begun = quantity(valueAt(data.tables, key));
  const [low, high, step] = rangeFor(key, begun);
  const { unit } = begun;
  const output = h("output", { for: id });
  const input = h("input", {
    type: "range",
    id,
    min: low,
    max: high,
    step,
    oninput: (event) => {
      const value = plainNumber(Math.min(Math.max(Number(event.target.value), low), high));
      parts.moves[key] = unit ? `${value} ${unit}` : value;
      parts.moved(movedTables());
      rest();
      told(value);
    },
  });
  const follow = () => {
    const found = quantity(valueAt(data.tables, key));
    if (!found || key in parts.moves) return;
    if (found.value > Number(input.max)) input.max = found.value;
    if (found.value < Number(input.min)) input.min = found.value;
    if (document.activeElement !== input || Math.abs(Number(input.value) - found.value) > Number(input.step))
      input.value = found.value;
    told(found.value);
  };
  const told = (value) => {
    const text = withUnit(value, unit);
    put(output, text);
    input.setAttribute("aria-valuetext", tr(text));
  };
  const head = h("div", { class: "head" }, h("label", { for: id }, words), output);
  return { box: h("div", { class: "slider" }, head, input), follow };
}

/** The case with what the sliders have moved since it was last set. */
const movedTables = () => Object.entries(parts.moves).reduce((found, [key, value]) => withKey(found, key, value), data.tables);

const rest = settled(() => {
  const tables = movedTables();
  parts.moves = {};
  setTables(tables);
}, 200);
