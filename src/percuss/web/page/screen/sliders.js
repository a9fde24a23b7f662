// The sliders of what decides most: each a number that can be typed, what it slides over, whose ends can be typed too,
// and a tick at what the machine had.

import { said } from "../core/api.js";
import { $, afterFrame, div, h, labelled, put } from "../core/dom.js";
import { plainNumber, quantity, typedQuantity, withUnit } from "../core/format.js";
import { heldAt, present, steps, valueAt } from "../core/moves.js";
import { effect, signal, whenever } from "../core/signals.js";
import { data, locked, move, show, switchesItself, view } from "../core/state.js";
import { machineSliders } from "./machine_sliders.js";
import { tr } from "../core/words.js";

/** What there is a slider for. `least`: it goes no lower by keys; `base`: what the machine had, where that is not what
 * its tables have at the name.
 * @typedef {{ name: string, label: string, meaning?: string, unit: string, low: number, high: number, least?: number,
 *   base?: number | null, now: () => number | null | undefined, put: (value: number) => void }} Sliding */

const IN_SIGHT = 7; // the others are under "more"

const rows = signal(/** @type {{ box: HTMLElement, follow: () => void }[]} */ ([]));
const followAll = () => void (data.tables && rows.value.forEach(({ follow }) => follow()));

/** The ranges stay as long as the names and the units do. */
export function startSliders() {
  whenever(() => data.changed, followAll);
  effect(followAll, afterFrame);
  whenever(
    () => data.tables && [view.machine, Boolean(data.tables.system), sliding().map(({ name, unit }) => [name, unit])],
    () => {
      const own = sliding().map(slider);
      const rest = [...own.slice(IN_SIGHT), ...(switchesItself() ? [] : [periods()])];
      const first = own.slice(0, IN_SIGHT);
      rows.value = [...first, ...rest];
      const boxes = rest.map(({ box }) => box);
      const open = matchMedia("(min-height: 900px)").matches;
      const more = boxes.length > 0 && h("details", { id: "more-sliders", open }, h("summary", {}, "more"), boxes);
      const inSight = first.map(({ box }) => box);
      put($("#controls"), h("h2", { class: "hidden-words" }, "Sliders"), inSight, more);
      followAll();
    },
  );
}

/** Of a machine that switches itself keys of its case, else what the server lists. @returns {Sliding[]} */
function sliding() {
  if (switchesItself()) return machineSliders();
  const listed = (data.info?.parameters ?? []).filter((/** @type {any} */ one) => one.slides);
  return listed.map((/** @type {any} */ one) => ({
    ...one,
    high: Math.max(one.high, (one.value ?? 0) * 1.0001),
    base: one.dimensionless ? null : undefined,
    now: () => present(data, one.name),
    put: (/** @type {number} */ value) => move({ [one.name]: value }),
  }));
}

/** @param {Sliding} one */
function slider({ name, label, meaning, unit, low, high, least = -Infinity, base, now, put: set }) {
  const id = `slide-${steps(name).join("-")}`;
  const title = label[0].toUpperCase() + label.slice(1);
  const range = { min: low, max: high };
  const words = (/** @type {number} */ value, digits = 4) => tr(withUnit(value, unit, digits));
  const before = () => {
    if (base !== undefined) return base;
    const found = quantity(valueAt(data.base ?? {}, heldAt(data.base ?? {}, name)));
    return found?.unit === unit ? found.value : null;
  };
  const input = h("input", { type: "range", id, title: meaning || title, "aria-label": title });
  const tick = h("span", { class: "tick", hidden: true });
  const problem = h("div", { class: "problem", role: "alert", id: `${id}-problem` });
  const field = h("input", {
    type: "text",
    id: `${id}-value`,
    spellcheck: "false",
    autocomplete: "off",
    "aria-describedby": problem.id,
    title:
      "Type a value with or without a unit; arrows 1 %, Shift 10 %, Alt 0.1 %; double click: as the machine had it",
    onfocus: () => field.select(),
    onchange() {
      const { error = "", remedy = "", value } = typedQuantity(field.value, unit);
      put(problem, said({ key: "", message: error, remedy }));
      field.toggleAttribute("aria-invalid", value === undefined);
      if (value === undefined) return field.setAttribute("aria-invalid", "true");
      set(plainNumber(value));
      field.value = words(value); // in its own unit, whatever was typed
    },
  });
  const end = (/** @type {"min" | "max"} */ which) => {
    const box = h("input", {
      type: "text",
      class: "end",
      "aria-label": `${title}: ${which === "min" ? "from" : "to"}`,
      onchange() {
        const { value } = typedQuantity(box.value, unit);
        if (value !== undefined && (which === "min" ? value < range.max : value > range.min)) range[which] = value;
        fit();
        follow();
      },
    });
    return box;
  };
  const ends = [end("min"), end("max")];
  const fit = () => {
    Object.assign(input, { ...range, step: (range.max - range.min) / 1000 });
    ends.forEach((box, i) => (box.value = words([range.min, range.max][i], 3)));
  };
  /** Arrow keys: 1 %, with Shift 10 %, with Alt 0.1 %; of a whole slider where it stands at 0.
   * @param {KeyboardEvent} event */
  const stepped = (event) => {
    const ways =
      event.target === field ? ["ArrowDown", "ArrowUp"] : ["ArrowDown", "ArrowUp", "ArrowLeft", "ArrowRight"];
    const way = ways.indexOf(event.key);
    if (way < 0) return;
    event.preventDefault();
    const [from, whole] = [now() ?? 0, high - low];
    const size = Math.abs(from) > 1e-9 * whole ? Math.abs(from) : whole;
    const next = from + (way % 2 ? 1 : -1) * (event.shiftKey ? 0.1 : event.altKey ? 0.001 : 0.01) * size;
    set(plainNumber(Math.max(next, least)));
    if (event.target === field) field.value = words(next);
  };
  const follow = () => {
    const value = now();
    if (value === undefined || value === null) return;
    if (value > range.max || value < range.min) {
      Object.assign(range, { min: Math.min(value, range.min), max: Math.max(value, range.max) });
      fit();
    }
    if (document.activeElement !== input || Math.abs(Number(input.value) - value) > Number(input.step))
      input.value = String(value);
    const share = ((before() ?? Number.NaN) - range.min) / (range.max - range.min);
    tick.hidden = !(share >= 0 && share <= 1);
    tick.style.left = `calc(8px + ${share} * (100% - 16px))`; // the middle of the thumb goes from 8px to 8px
    input.disabled = field.disabled = locked(name);
    const told = words(value);
    input.setAttribute("aria-valuetext", told);
    if (document.activeElement !== field && field.getAttribute("aria-invalid") !== "true" && field.value !== told)
      field.value = told;
  };
  input.addEventListener("input", () => set(plainNumber(Math.max(Number(input.value), range.min))));
  for (const part of [input, field]) {
    part.addEventListener("keydown", stepped);
    part.addEventListener("dblclick", () => {
      const had = before();
      if (had !== null) set(plainNumber(had));
    });
  }
  fit();
  const head = div("head", h("label", { for: field.id }, title), field);
  const track = div("track", ends[0], div("track-of", input, tick), ends[1]);
  return { box: div("slider", head, track, problem), follow };
}

function periods() {
  const input = h("input", {
    type: "number",
    id: "periods",
    min: 1,
    max: 100,
    step: 1,
    oninput() {
      const value = Number(input.value);
      const good = Number.isInteger(value) && value >= 1 && value <= 100;
      input.setAttribute("aria-invalid", String(!good));
      if (good) show({ m: value, orbit: 0 });
    },
    onchange() {
      input.value = String(view.m); // what was no such number
      input.removeAttribute("aria-invalid");
    },
  });
  const follow = () => void (document.activeElement !== input && (input.value = String(view.m)));
  return { box: labelled("Load periods per blow, m", input), follow };
}
