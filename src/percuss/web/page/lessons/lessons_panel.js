// The lessons: a list with what has been reached, and a strip beside the stage while one is under way, always as high.

import { $, button, div, h, put } from "../core/dom.js";
import { quantity } from "../core/format.js";
import { valueAt } from "../core/moves.js";
import { effect, flush, store } from "../core/signals.js";
import {
  DEFAULTS,
  chosen,
  data,
  machineTables,
  presentValues,
  reasonOf,
  setTables,
  show,
  switchesItself,
  view,
  wish,
} from "../core/state.js";
import { forgetTheme } from "../pictures/colours.js";
import { LESSONS, questionOf } from "./lessons.js";

const KEPT = "percuss-lessons";
const FIRST = { key: "", reached: false, said: -1, asking: false, answer: -1 };
/** What the learner has said of the scene in sight, and whether its target is reached. */
const own = store(FIRST);

/** The targets that were reached, as "3.2". @returns {string[]} */
function reachedBefore() {
  try {
    return JSON.parse(localStorage.getItem(KEPT) ?? "[]");
  } catch {
    return []; // none of ours
  }
}

/** @param {HTMLElement} place */
export function start(place) {
  const cards = LESSONS.map((lesson, i) => {
    const named = { class: "main", "aria-label": `Begin lesson ${i + 1}` };
    const done = h("span", { class: "done small muted" });
    const number = h("div", { class: "no", "aria-hidden": "true" }, i + 1);
    return h(
      "li",
      { class: "card lesson" },
      number,
      h("h3", {}, lesson.title),
      h("p", { class: "muted" }, lesson.goal),
      div(
        "row middle",
        button("Begin", () => play(i + 1, 1), named),
        done,
      ),
    );
  });
  put(
    place,
    h(
      "p",
      { class: "muted" },
      "Each takes a few minutes: predict, look, reach the target. Change anything, and come back to a scene whenever you like.",
    ),
    h("ol", { class: "lessons" }, cards),
  );
  effect(() => {
    if (view.panel !== "lessons") return;
    const before = reachedBefore();
    LESSONS.forEach(({ scenes }, i) => {
      const n = scenes.filter((_, k) => before.includes(`${i + 1}.${k + 1}`)).length;
      put($(".done", cards[i]), n === scenes.length ? "✓ done" : n ? `${n} of ${scenes.length} targets` : "");
    });
  });
  effect(strip);
  effect(judge);
  effect(() => {
    const on_ = view.projector && LESSONS[view.lesson - 1] ? "1" : "0";
    if ((document.documentElement.dataset.projector ?? "0") === on_) return;
    document.documentElement.dataset.projector = on_;
    forgetTheme(); // drawings grow with the text
  });
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !view.projector || event.defaultPrevented) return;
    event.preventDefault();
    show({ projector: 0 });
    $("#projector")?.focus();
  });
}

/** A scene: its case and its view; a link with the lesson in it comes back to it. @param {number} lesson @param {number} number */
async function play(lesson, number) {
  const { view: wanted, case: tables, machine } = LESSONS[lesson - 1].scenes[number - 1];
  const newest = wish();
  const found = machine ? await machineTables(machine) : null;
  if (!newest()) return;
  const { projector } = view;
  Object.assign(view, DEFAULTS, { machine: machine ?? "", lesson, scene: number, projector, ...wanted });
  Object.assign(data, {
    base: found?.tables ?? null,
    physical: null,
    label: "",
    blows: [],
    experiment: null,
    blow: null,
  });
  Object.assign(own, FIRST);
  setTables(found?.tables ?? tables, found ?? data.info);
  flush(); // what can be pressed is there
  const { activeElement } = document;
  if (!activeElement || activeElement === document.body || activeElement.closest("#drawer"))
    $("#lesson-ask button")?.focus();
}

const sceneNow = () => LESSONS[view.lesson - 1]?.scenes[view.scene - 1];
const keyNow = () => `${view.lesson}.${view.scene}`;

/** What the page knows by now; null while the answer to the last change is on its way. @returns {import("./lessons.js").Now | null} */
function now() {
  const { changed, tables, quick, machine, experiment, blow } = data;
  const answer = switchesItself() ? machine : quick;
  if (answer?.changed !== changed || data.problems.length) return null;
  const found = switchesItself() ? null : chosen();
  return {
    orbits: quick?.orbits ?? [],
    number: found?.number ?? 0,
    stable: Boolean(found?.quick.stable),
    reason: found ? reasonOf(found) : "",
    m: view.m,
    machine: switchesItself() ? machine : null,
    value: (name) => (name.includes(".") ? quantity(valueAt(tables, name))?.value : presentValues()[name]),
    label: data.label,
    blows: data.blows,
    experiment,
    blow: blow?.changed === changed ? blow : null,
  };
}

/** The target ticks when the state of the page reaches it, and stays so. */
function judge() {
  const [scene, state, key] = [sceneNow(), now(), keyNow()];
  if (!scene || !state || own.key !== key || own.reached || !scene.reached(state)) return;
  own.reached = true;
  const before = reachedBefore();
  if (!before.includes(key)) localStorage.setItem(KEPT, JSON.stringify([...before, key]));
}

const CHOOSE = "Press a scene: it sets the case, and says what to try.";
function strip() {
  const box = $("#lesson-strip");
  const lesson = LESSONS[view.lesson - 1];
  box.hidden = !lesson || view.panel === "lessons";
  const scene = sceneNow();
  if (own.key !== keyNow()) {
    Object.assign(own, FIRST, { key: keyNow() });
    data.begin = { count: data.begin.count + 1, state: scene?.begin ?? null };
  }
  const key = JSON.stringify([own, box.hidden, view.projector]);
  if (box.hidden || box.dataset.key === key) return;
  box.dataset.key = key;
  if (!box.firstChild)
    put(
      box,
      ["head", "look", "ask"].map((name) => h("div", { id: `lesson-${name}` })),
    );
  const before = reachedBefore();
  const number = scene ? view.scene : 0;
  const last = number === lesson.scenes.length;
  const next = last
    ? view.lesson < LESSONS.length
      ? () => play(view.lesson + 1, 1)
      : null
    : () => play(view.lesson, number + 1);
  const tab = (/** @type {import("./lessons.js").Scene} */ one, /** @type {number} */ i) => {
    const ticked = before.includes(`${view.lesson}.${i + 1}`);
    const name = ticked ? `${one.show}, reached` : one.show;
    return button(`${ticked ? "✓" : i + 1} ${one.show}`, () => play(view.lesson, i + 1), {
      "aria-pressed": String(i + 1 === view.scene),
      "aria-label": name,
    });
  };
  put(
    $("#lesson-head"),
    h("h2", { title: lesson.goal }, `${view.lesson} ${lesson.title}`),
    h("div", { class: "try", role: "group", "aria-label": "Scenes" }, lesson.scenes.map(tab)),
    div(
      "try",
      next && button(last ? "Next lesson" : "Next", next, { id: "lesson-next" }),
      button("Projector", () => show({ projector: view.projector ? 0 : 1 }), {
        id: "projector",
        "aria-pressed": String(Boolean(view.projector)),
        title: "Larger, with only verdict, stage and map (Esc leaves)",
      }),
      button("Leave", () => show({ lesson: 0, scene: 0, projector: 0, contact: 0, panel: "lessons" }), {
        "aria-label": "Leave the lesson",
      }),
    ),
  );
  const look = $("#lesson-look");
  if (!look.firstChild)
    put(look, h("p", { id: "lesson-words", "aria-live": "polite" }), h("p", { id: "lesson-target", role: "status" }));
  put($("#lesson-words"), scene?.say ?? CHOOSE);
  put($("#lesson-target"), scene ? `${own.reached ? "✓" : "○"} ${scene.target}` : "");
  $("#lesson-target").dataset.reached = String(own.reached);
  ask(scene, last ? questionOf(lesson.question) : null);
}

/** The prediction before the look, what came of it after, and the question at the end.
 * @param {import("./lessons.js").Scene | undefined} scene @param {import("./lessons.js").Question | null} question */
function ask(scene, question) {
  const box = $("#lesson-ask");
  if (!scene) return put(box);
  const { reached, said, asking, answer } = own;
  const predict = questionOf(scene.predict);
  /** @param {import("./lessons.js").Question} one @param {string} name @param {"said" | "answer"} where */
  const choices = ({ words, choices: list }, name, where) => [
    h("p", {}, h("strong", {}, name), ` ${words}`),
    h(
      "div",
      { class: "try", role: "group", "aria-label": words },
      list.map((choice, i) => button(choice, () => say({ [where]: i }))),
    ),
  ];
  /** @param {import("./lessons.js").Question} one @param {number} pressed */
  const told = ({ choices: list, right, why }, pressed) =>
    h(
      "p",
      { id: "lesson-told", role: "status" },
      h("strong", {}, pressed < 0 ? `${list[right]}: ` : pressed === right ? "Right. " : `No: ${list[right]}. `),
      why,
    );
  if (asking && question) put(box, answer < 0 ? choices(question, "To end with:", "answer") : told(question, answer));
  else if (reached)
    put(
      box,
      told(predict, said),
      question &&
        div(
          "try",
          button("One question", () => say({ asking: true }), { id: "lesson-question" }),
        ),
    );
  else if (said < 0) put(box, choices(predict, "Predict:", "said"));
  else
    put(
      box,
      h("p", { role: "status" }, h("strong", {}, `You say: ${predict.choices[said]}.`), " Now look: reach the target."),
    );
}

/** Something was pressed; who is at the keyboard goes on from there. @param {Partial<typeof FIRST>} change */
function say(change) {
  Object.assign(own, change);
  flush();
  const box = $("#lesson-ask");
  const first = $("button", box) ?? box;
  if (first === box) box.tabIndex = -1;
  first.focus({ preventScroll: true });
}
