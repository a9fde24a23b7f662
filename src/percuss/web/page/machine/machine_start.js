// Which motion of a machine is shown: its cycle, or how it comes to it from a start, which can be typed or drawn.

import { postBinary, said } from "../core/api.js";
import { h, latest, put } from "../core/dom.js";
import { typed } from "../case/fields.js";
import { plainNumber } from "../core/format.js";
import { setStart } from "../motion/motion_start.js";
import { data, show, view } from "../core/state.js";

const parts = { started: null, asked: -1, last: null }; // the last machine that there was

/** The choice and the fields of a start; `came` is called when another start-up is there, or none can be. */
export function machineSource(came) {
  parts.came = came;
  const pick = (shown, text) =>
    h("button", { type: "button", id: `machine-of-${shown}`, onclick: () => show({ machineShow: shown }) }, text);
  parts.picks = { cycle: pick("cycle", "Cycle"), start: pick("start", "From a start") };
  parts.fields = {
    position: field("position", "Starts behind the tool", "−39 mm, or in bar lengths; 0 at the tool"),
    velocity: field("velocity", "with a speed toward it", "2 m/s; 0 when empty"),
  };
  parts.problem = h("p", { class: "problem", role: "alert", id: "machine-start-problem" });
  const draw = h("button", { type: "button", id: "machine-start-draw", onclick: drawn }, "Draw a start");
  parts.form = h("div", { class: "row start" }, Object.values(parts.fields).map(({ box }) => box), draw, parts.problem);
  const picks = h("div", { class: "segments", role: "group", "aria-label": "Which motion" }, Object.values(parts.picks));
  return { picks, form: parts.form };
}

function field(key, label, hint) {
  const id = `machine-start-${key}`;
  const onchange = (event) => setStart(withKeyOf(key, typed(event.target.value, key)));
  const about = { "aria-describedby": `${id}-hint machine-start-problem`, spellcheck: "false", autocomplete: "off" };
  const input = h("input", { type: "text", id, size: 9, onchange, ...about });
  const own = [h("label", { for: id, class: "small muted" }, label), input, h("div", { class: "hint", id: `${id}-hint` }, hint)];
  return { input, box: h("div", { class: "field start" }, own) };
}

/** The start with another key; one by modes gives way to a place and a speed. */
function withKeyOf(key, value) {
  const { position, velocity, time } = data.tables.start ?? {};
  return { position: position ?? 0, velocity, time, [key]: value };
}

/** A start that is as likely anywhere within the stroke, at up to the striking speed either way; dimensionless. */
function drawn() {
  const { answer, scales } = parts.last ?? {};
  const fastest = Math.max(...(answer?.blows ?? []).map(({ speed }) => speed), 0) || 1;
  const speed = plainNumber((2 * Math.random() - 1) * fastest * (scales?.speed_m_s ?? 1), 4);
  setStart({ position: plainNumber(-Math.random() * (answer?.stroke || 1), 4), velocity: data.tables.bar ? `${speed} m/s` : speed });
}

export const fromStart = () => view.machineShow === "start";

/** The start-up of the case as it is now, or null until it is there; asks for it. */
export function startUp() {
  for (const [shown, button] of Object.entries(parts.picks)) button.setAttribute("aria-pressed", String(fromStart() === (shown === "start")));
  parts.form.hidden = !fromStart();
  if (data.machine) parts.last = data.machine;
  if (!fromStart()) return null;
  for (const [key, { input }] of Object.entries(parts.fields))
    if (input !== document.activeElement) input.value = String(data.tables.start?.[key] ?? "");
  if (parts.asked !== data.changed) {
    parts.asked = data.changed;
    ask({ tables: data.tables, count: data.changed });
  }
  return parts.started?.changed === data.changed ? parts.started : null;
}

const ask = latest(
  ({ tables }) => postBinary("machine/start", { case: tables }),
  (found, { count }) => {
    put(parts.problem);
    parts.started = Object.assign(found, { changed: count, cycles: found.answer.blows.length || 1, started: true });
    parts.came();
  },
  (error, { count }) => {
    if (error.status !== 422) parts.asked = -1; // the same question may be answered later
    if (count === data.changed) put(parts.problem, error.problems?.map((one) => said(one)).join(" ") ?? error.message);
    parts.came();
  },
);
