// The Fourier coefficients of a load, one row a harmonic.

import { $$, h } from "../core/dom.js";
import { typed } from "./fields.js";
import { problemOf } from "./form_fields.js";
import { data, setKey } from "../core/state.js";

/** A field with all coefficients; what a link has in their place, which may be anything, is told of by the server. */
export function coefficients(found) {
  const pairs = Array.isArray(found) ? found : [];
  const change = (k, part) => (event) => {
    const value = typed(event.target.value);
    const next = pairsNow().map((pair, i) =>
      i === k ? [0, 1].map((j) => (j === part ? (value ?? 0) : (pair?.[j] ?? 0))) : pair,
    );
    setKey("load.coefficients", next);
  };
  const box = (k, part) =>
    h("input", {
      type: "text",
      "data-coefficient": `${k},${part}`,
      "aria-label": `coefficient ${k}, ${part ? "imaginary" : "real"} part`,
      oninput: change(k, part),
      ".disabled": k === 0 && part === 1,
    });
  const row = (_, k) => [h("span", {}, k ? `p${sub(k)}` : "p₀, mean"), box(k, 0), box(k, 1)];
  const add = () => setKey("load.coefficients", [...pairsNow(), [0, 0]]);
  const drop = () => setKey("load.coefficients", pairsNow().slice(0, -1));
  return h(
    "div",
    { class: "field" },
    h(
      "div",
      { class: "coefficients" },
      h("span", {}),
      h("span", { class: "small muted" }, "real"),
      h("span", { class: "small muted" }, "imaginary"),
      pairs.map(row),
    ),
    h(
      "div",
      { class: "row" },
      h("button", { type: "button", onclick: add }, "Add a harmonic"),
      h("button", { type: "button", onclick: drop, ".disabled": pairs.length < 3 }, "Remove the last"),
    ),
    problemOf("load.coefficients"),
  );
}

const pairsNow = () => (Array.isArray(data.tables.load.coefficients) ? data.tables.load.coefficients : []);

const sub = (k) => [...String(k)].map((c) => "₀₁₂₃₄₅₆₇₈₉"[Number(c)]).join("");

/** The numbers from the tables; the one that is being typed into is left alone. */
export function fillCoefficients(form) {
  for (const input of $$("input[data-coefficient]", form)) {
    if (input === document.activeElement) continue;
    const [k, part] = input.dataset.coefficient.split(",").map(Number);
    input.value = String(data.tables.load.coefficients?.[k]?.[part] ?? "");
  }
}
