// Sliders of the quantities that decide most, as the server lists them with the case.

import { $, afterFrame, h, put } from "../core/dom.js";
import { number, plainNumber, withUnit } from "../core/format.js";
import { followMachineSliders, machineSliderNames, machineSliders } from "../machine/machine_sliders.js";
import { present } from "../core/moves.js";
import { data, move, on, show, switchesItself, view } from "../core/state.js";

const rows = new Map();
let built = "";
let ofMachine = false; // whether they are those of a machine that switches itself

export function startSliders() {
  on("info", build);
  const later = afterFrame(follow);
  on("tables", () => (switchesItself() || ofMachine ? build() : follow()));
  on("quick view", later);
}

/** Every slider anew when the case has other ones; the ranges stay as long as the names and the units do. */
function build() {
  const own = switchesItself();
  const sliding = (!own && data.info?.parameters?.filter((p) => p.slides)) || [];
  const names = own ? machineSliderNames() : sliding.map((p) => `${p.name} ${p.unit}`);
  const key = `${view.machine}|${Boolean(data.tables?.system)}|${own}|${names.join()}`;
  if (key === built) return own ? followMachineSliders() : follow();
  built = key;
  ofMachine = own;
  rows.clear();
  for (const parameter of sliding) rows.set(parameter.name, slider(parameter));
  const boxes = own ? machineSliders() : [...[...rows.values()].map((row) => row.box), periods()];
  const open = matchMedia("(min-width: 861px)").matches;
  put($("#controls"), h("details", { open }, h("summary", {}, h("h2", {}, "Sliders")), boxes));
  follow();
}

function slider({ name, label, meaning, unit, low, high, value }) {
  const id = `slide-${name.replace(".", "-")}`;
  const title = label[0].toUpperCase() + label.slice(1);
  const range = { low, high: Math.max(high, (value ?? 0) * 1.0001) };
  const step = (range.high - range.low) / 1000;
  const output = h("output", { for: id });
  const input = h("input", {
    type: "range",
    id,
    min: range.low,
    max: range.high,
    step,
    title: meaning || title,
    oninput: (event) => move({ [name]: Math.max(plainNumber(Number(event.target.value)), range.low) }),
  });
  const ends = h(
    "div",
    { class: "ends", "aria-hidden": "true" },
    h("span", {}, number(range.low, 3)),
    h("span", {}, withUnit(range.high, unit, 3)),
  );
  const box = h(
    "div",
    { class: "slider" },
    h("div", { class: "head" }, h("label", { for: id }, title), output),
    input,
    ends,
  );
  return { box, input, output, unit, name };
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
    onchange: (event) => {
      event.target.value = view.m; // what was no such number
      event.target.removeAttribute("aria-invalid");
    },
  });
  return h("label", { class: "pick" }, "Load periods per blow, m: 1 to 100", input);
}

function follow() {
  if (!data.tables) return;
  for (const { name, input, output, unit } of rows.values()) {
    const value = present(data, name);
    if (value === undefined || value === null) continue;
    if (value > Number(input.max)) input.max = value;
    if (document.activeElement !== input || Math.abs(Number(input.value) - value) > Number(input.step))
      input.value = value;
    const words = withUnit(value, unit);
    if (output.textContent === words) continue;
    output.textContent = words;
    input.setAttribute("aria-valuetext", words);
  }
  const input = $("#periods");
  if (input && document.activeElement !== input) input.value = view.m;
}
