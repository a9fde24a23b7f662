// The sliders of what decides most: each a number that can be typed, what it slides over, whose ends can be typed too,
// and a tick at what the machine had.

import { $, afterFrame, h, put } from "../core/dom.js";
import { plainNumber, quantity, typedQuantity, withUnit } from "../core/format.js";
import { heldAt, present, steps, valueAt } from "../core/moves.js";
import { data, locked, move, on, show, switchesItself, view } from "../core/state.js";
import { machineSliders } from "./machine_sliders.js";
import { tr } from "../core/words.js";

const IN_SIGHT = 7; // the others are under "more"

let rows = [];
let built = "";

export function startSliders() {
  on("info", build);
  const later = afterFrame(follow);
  on("tables", () => (switchesItself() === (built[0] === "m") && !switchesItself() ? follow() : build()));
  on("quick machine view", later);
}

/** What there are sliders for: of a machine that switches itself keys of its case, else what the server lists.
 * Each {name, label, meaning, unit, low, high, now(), base(), put(value)}. */
function sliding() {
  if (switchesItself()) return machineSliders();
  return (data.info?.parameters ?? [])
    .filter((one) => one.slides)
    .map((one) => ({
      ...one,
      high: Math.max(one.high, (one.value ?? 0) * 1.0001),
      now: () => present(data, one.name),
      base: () => (one.dimensionless ? null : baseOf(one.name, one.unit)),
      put: (value) => move({ [one.name]: value }),
    }));
}

/** What the machine had, in the slider's unit. */
export function baseOf(name, unit) {
  const found = quantity(valueAt(data.base ?? {}, heldAt(data.base ?? {}, name)));
  return found?.unit === unit ? found.value : null;
}

/** Every slider anew when the case has other ones; the ranges stay as long as the names and the units do. */
function build() {
  if (!data.tables) return;
  const own = sliding();
  const key = `${switchesItself() ? "m" : "c"}|${view.machine}|${Boolean(data.tables.system)}|${own.map((one) => `${one.name} ${one.unit}`).join()}`;
  if (key === built) return follow();
  built = key;
  rows = own.map(slider);
  const boxes = rows.map((row) => row.box);
  const rest = [boxes.slice(IN_SIGHT), switchesItself() ? [] : periods()].flat();
  const more =
    rest.length > 0 &&
    h(
      "details",
      { id: "more-sliders", open: matchMedia("(min-height: 900px)").matches },
      h("summary", {}, "more"),
      rest,
    );
  put($("#controls"), h("h2", { class: "hidden-words" }, "Sliders"), boxes.slice(0, IN_SIGHT), more);
  follow();
}

function slider(one) {
  const { name, label, meaning, unit } = one;
  const id = `slide-${steps(name).join("-")}`;
  const title = label[0].toUpperCase() + label.slice(1);
  const input = h("input", {
    type: "range",
    id,
    min: one.low,
    max: one.high,
    step: (one.high - one.low) / 1000,
    title: meaning || title,
    "aria-label": title,
  });
  const tick = h("span", { class: "tick", hidden: true });
  const problem = h("div", { class: "problem", role: "alert", id: `${id}-problem` });
  const field = h("input", {
    type: "text",
    id: `${id}-value`,
    spellcheck: "false",
    autocomplete: "off",
    "aria-describedby": `${id}-problem`,
    title:
      "Type a value with or without a unit; arrows 1 %, Shift 10 %, Alt 0.1 %; double click: as the machine had it",
  });
  const set = (value) => one.put(plainNumber(value));
  const back = () => {
    const base = one.base();
    if (base !== null && base !== undefined) set(base);
  };
  input.addEventListener("input", () => set(Math.max(Number(input.value), Number(input.min))));
  for (const part of [input, field]) {
    part.addEventListener("keydown", (event) => stepped(event, one, set));
    part.addEventListener("dblclick", back);
  }
  field.addEventListener("change", () => {
    const found = typedQuantity(field.value, unit);
    put(problem, found.error ? [found.error, found.remedy].filter(Boolean).join(" — ") : "");
    field.toggleAttribute("aria-invalid", Boolean(found.error));
    if (found.error) return field.setAttribute("aria-invalid", "true");
    set(found.value);
    field.value = tr(withUnit(found.value, unit)); // in its own unit, whatever was typed
  });
  field.addEventListener("focus", () => field.select());
  const end = (which, other) => {
    const box = h("input", {
      type: "text",
      class: "end",
      "aria-label": `${title}: ${which === "min" ? "from" : "to"}`,
      ".value": ended(input[which], unit),
    });
    box.addEventListener("change", () => {
      const found = typedQuantity(box.value, unit);
      const good =
        !found.error && (which === "min" ? found.value < Number(input[other]) : found.value > Number(input[other]));
      if (good) {
        input[which] = found.value;
        input.step = (Number(input.max) - Number(input.min)) / 1000;
      }
      box.value = ended(input[which], unit);
      row.follow();
    });
    return box;
  };
  const [low, high] = [end("min", "max"), end("max", "min")];
  const row = {
    box: h(
      "div",
      { class: "slider" },
      h("div", { class: "head" }, h("label", { for: field.id }, title), field),
      h("div", { class: "track" }, low, h("div", { class: "track-of" }, input, tick), high),
      problem,
    ),
    follow() {
      const value = one.now();
      if (value === undefined || value === null) return;
      if (value > Number(input.max)) ((input.max = value), (high.value = ended(value, unit)));
      if (value < Number(input.min)) ((input.min = value), (low.value = ended(value, unit)));
      if (document.activeElement !== input || Math.abs(Number(input.value) - value) > Number(input.step))
        input.value = value;
      const base = one.base();
      const share =
        base === null || base === undefined ? -1 : (base - Number(input.min)) / (Number(input.max) - Number(input.min));
      tick.hidden = !(share >= 0 && share <= 1);
      tick.style.left = `calc(8px + ${share} * (100% - 16px))`; // the middle of the thumb goes from 8px to 8px
      input.disabled = field.disabled = locked(name);
      const words = tr(withUnit(value, unit));
      input.setAttribute("aria-valuetext", words);
      if (document.activeElement !== field && field.getAttribute("aria-invalid") !== "true" && field.value !== words)
        field.value = words;
    },
  };
  return row;
}

const ended = (value, unit) => tr(withUnit(Number(value), unit, 3));

/** Arrow keys: 1 %, with Shift 10 %, with Alt 0.1 %; of a whole slider where it stands at 0. */
function stepped(event, one, set) {
  const sign = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key];
  const field = event.target.type === "text";
  if (!sign || (field && !["ArrowUp", "ArrowDown"].includes(event.key))) return;
  event.preventDefault();
  const now = one.now() ?? 0;
  const share = event.shiftKey ? 0.1 : event.altKey ? 0.001 : 0.01;
  const size = Math.abs(now) > 1e-9 * (one.high - one.low) ? Math.abs(now) : one.high - one.low;
  const next = now + sign * share * size;
  set(one.least === undefined ? next : Math.max(next, one.least));
  if (field) event.target.value = tr(withUnit(now + sign * share * size, one.unit));
}

function periods() {
  const change = (event) => {
    const value = Number(event.target.value);
    const good = Number.isInteger(value) && value >= 1 && value <= 100;
    event.target.setAttribute("aria-invalid", String(!good));
    if (good) show({ m: value, orbit: 0 });
  };
  const input = h("input", {
    type: "number",
    id: "periods",
    min: 1,
    max: 100,
    step: 1,
    ".value": String(view.m),
    oninput: change,
  });
  input.addEventListener("change", () => {
    input.value = view.m; // what was no such number
    input.removeAttribute("aria-invalid");
  });
  return [h("label", { class: "pick" }, "Load periods per blow, m", input)];
}

function follow() {
  if (!data.tables) return;
  for (const row of rows) row.follow();
  const input = $("#periods");
  if (input && document.activeElement !== input) input.value = view.m;
}
