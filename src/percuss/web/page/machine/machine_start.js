// Which motion of a machine is shown: its cycle, or how it comes to it from a start, which can be typed or drawn.

import { typed } from "../case/fields.js";
import { postBinary, problemsOf, said } from "../core/api.js";
import { button, div, fieldOf, h, latest, put, segments } from "../core/dom.js";
import { plainNumber } from "../core/format.js";
import { signal } from "../core/signals.js";
import { data, setStart, show, view } from "../core/state.js";

/** [label, hint] of the keys of a start. @type {Record<string, [string, string]>} */
const FIELDS = {
  position: ["Starts behind the tool", "−39 mm, or in bar lengths; 0 at the tool"],
  velocity: ["with a speed toward it", "2 m/s; 0 when empty"],
};

/** `last`: the last machine that there was. @type {Record<string, any>} */
const parts = { asked: -1, last: null };
/** The last start-up that came. */
const started = signal(/** @type {import("./machine_charts.js").Machine | null} */ (null));

/** The choice and the fields of a start. */
export function machineSource() {
  const pick = (/** @type {string} */ machineShow, /** @type {string} */ text) =>
    button(text, () => show({ machineShow }), { id: `machine-of-${machineShow}` });
  parts.picks = { cycle: pick("cycle", "Cycle"), start: pick("start", "From a start") };
  parts.problem = h("p", { class: "problem", role: "alert", id: "machine-start-problem" });
  parts.inputs = {};
  const fields = Object.entries(FIELDS).map(([key, [label, hint]]) => {
    const id = `machine-start-${key}`;
    const about = { "aria-describedby": `${id}-hint machine-start-problem`, spellcheck: "false", autocomplete: "off" };
    const onchange = (/** @type {any} */ { target }) => setStart(startWith(key, typed(target.value, key)));
    parts.inputs[key] = h("input", { type: "text", id, size: 9, onchange, ...about });
    return fieldOf(parts.inputs[key], label, hint, null, "start");
  });
  const draw = button("Draw a start", drawStart, { id: "machine-start-draw" });
  parts.form = div("row start", fields, draw, parts.problem);
  return { picks: segments("Which motion", Object.values(parts.picks)), form: parts.form };
}

/** The start with another key; one by modes gives way to a place and a speed. @param {string} key @param {any} value */
function startWith(key, value) {
  const { position = 0, velocity, time } = data.tables.start ?? {};
  return { position, velocity, time, [key]: value };
}

/** A start that is as likely anywhere within the stroke, at up to the striking speed either way; dimensionless. */
function drawStart() {
  const { answer, scales } = parts.last ?? {};
  const fastest = Math.max(...(answer?.blows ?? []).map((/** @type {any} */ { speed }) => speed), 0) || 1;
  const speed = plainNumber((2 * Math.random() - 1) * fastest * (scales?.speed_m_s ?? 1), 4);
  const position = plainNumber(-Math.random() * (answer?.stroke || 1), 4);
  setStart({ position, velocity: data.tables.bar ? `${speed} m/s` : speed });
}

export const fromStart = () => view.machineShow === "start";

/** The start-up of the case as it is now, or null until it is there; asks for it.
 * @returns {import("./machine_charts.js").Machine | null} */
export function startUp() {
  for (const [shown, pick] of Object.entries(parts.picks))
    pick.setAttribute("aria-pressed", String(fromStart() === (shown === "start")));
  parts.form.hidden = !fromStart();
  if (data.machine) parts.last = data.machine;
  if (!fromStart()) return null;
  for (const [key, input] of Object.entries(parts.inputs))
    if (input !== document.activeElement) input.value = String(data.tables.start?.[key] ?? "");
  if (parts.asked !== data.changed) ask({ tables: data.tables, count: (parts.asked = data.changed) });
  return started.value?.changed === data.changed ? started.value : null;
}

const ask = latest(
  (/** @type {{ tables: any, count: number }} */ { tables }) => postBinary("machine/start", { case: tables }),
  (found, { count }) => {
    put(parts.problem);
    started.value = Object.assign(found, { changed: count, cycles: found.answer.blows.length || 1, started: true });
  },
  (error, { count }) => {
    if (error.status !== 422) parts.asked = -1; // the same question may be answered later
    if (count === data.changed) put(parts.problem, problemsOf(error).map(said).join(" "));
  },
);
