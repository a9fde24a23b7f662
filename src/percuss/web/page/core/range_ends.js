// Two fields for the ends of a range, which can be typed in any unit of its kind.

import { h, put } from "./dom.js";
import { number, plainNumber } from "./format.js";
import { isRange } from "./moves.js";
import { read } from "./units.js";
import { language, tr } from "./words.js";

/** @typedef {{ from: number, to: number, unit: string }} Range */

/** The fields; `fill` brings them up to date, but for one that is being typed into, and one that was not taken. Their ids
 * begin with `id`, `about` says what they are of, `range` what it is now, `keeps` where a previous one is kept, as is said
 * in `problem`; `taken` is told another one.
 * @param {{ id: string, about: string, range: () => Range, keeps: string, problem: HTMLElement,
 *   taken: (from: number, to: number, unit: string) => void, digits?: number }} given */
export function rangeEnds({ id, about, range, keeps, problem, taken, digits = 4 }) {
  const commit = (/** @type {HTMLInputElement} */ changed) => {
    const { unit } = range();
    const [low, high] = [from, to].map((input) =>
      plainNumber(read(input.value, unit, language).value ?? Number.NaN, digits),
    );
    const isOne = isRange(low, high);
    for (const input of [from, to]) input.setAttribute("aria-invalid", String(!isOne && input === changed));
    const words = `A range must go from a number to a greater one; ${keeps} keeps the previous range.`;
    put(problem, isOne ? "" : words);
    if (isOne) taken(low, high, unit);
  };
  const told = (/** @type {number} */ value) => tr(number(value, digits));
  const field = (/** @type {"from" | "to"} */ end) => {
    const own = { type: "text", class: "end", id: `${id}-${end}`, spellcheck: "false", autocomplete: "off" };
    const input = h("input", {
      ...own,
      "aria-label": `${end}, ${about}`,
      "aria-describedby": problem.id,
      ".value": told(range()[end]),
      onchange: () => commit(input),
    });
    return input;
  };
  const [from, to] = [field("from"), field("to")];
  const fill = () => {
    const now = range();
    for (const [input, value] of /** @type {const} */ ([
      [from, now.from],
      [to, now.to],
    ])) {
      if (input === document.activeElement || input.getAttribute("aria-invalid") === "true") continue;
      if (input.value !== told(value)) input.value = told(value);
    }
  };
  return { from, to, fill };
}
