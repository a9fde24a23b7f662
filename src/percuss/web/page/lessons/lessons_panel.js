// The lessons: a list, and a strip above every panel while one is under way.

import { $, h, put } from "../core/dom.js";
import { LESSONS } from "./lessons.js";
import { DEFAULTS, data, on, pickMachine, setTables, show, view } from "../core/state.js";

export const panel = {
  name: "lessons",
  title: "Lessons",
  defaults: {
    lesson: 0,
    scene: 0, // of the lesson, from 1
  },
  start: startLessons,
};

const CHOOSE = "Press a scene: it sets the case and the panel, and says what to try.";

function startLessons(panel) {
  const item = (lesson, i) =>
    h(
      "li",
      { class: "card lesson" },
      h("div", { class: "no", "aria-hidden": "true" }, i + 1),
      h("h3", {}, lesson.title),
      h("p", { class: "muted" }, lesson.goal),
      h(
        "div",
        {},
        h(
          "button",
          { type: "button", class: "main", "aria-label": `Begin lesson ${i + 1}`, onclick: () => begin(i + 1) },
          "Begin",
        ),
      ),
    );
  put(
    panel,
    h(
      "div",
      { class: "card" },
      h("h2", {}, "Nine lessons"),
      h(
        "p",
        { class: "muted" },
        "Each takes a few minutes. The lessons use the ordinary panels: change anything, and return to a scene whenever you like.",
      ),
    ),
    h("ol", { class: "lessons" }, LESSONS.map(item)),
  );
  on("view", strip);
}

async function begin(number) {
  show({ lesson: number, scene: 0 });
  await play(0);
  $("#lesson-strip").scrollIntoView({ block: "nearest" });
}

/** A scene: its case and its view; a link with the lesson in it comes back to it. */
async function play(index) {
  const { view: wish, case: tables, machine, start } = LESSONS[view.lesson - 1].scenes[index];
  const { lesson, machine: before } = view;
  Object.assign(view, DEFAULTS, { machine: before, lesson, scene: index + 1, ...wish });
  if (machine) await pickMachine(machine);
  else {
    Object.assign(data, { base: null, physical: null });
    view.machine = "";
    setTables(start ? { ...tables, start, simulation: { modes: 0, impacts: 1500 } } : tables);
  }
  show({});
}

const leave = () => show({ lesson: 0, scene: 0, panel: "lessons" });

function strip() {
  const box = $("#lesson-strip");
  const lesson = LESSONS[view.lesson - 1];
  box.hidden = !lesson || view.panel === "lessons";
  const key = JSON.stringify([view.lesson, view.scene, box.hidden]);
  if (box.hidden || box.dataset.key === key) return;
  box.dataset.key = key;
  const button = (one, i) =>
    h(
      "button",
      { type: "button", "aria-pressed": String(i + 1 === view.scene), onclick: () => play(i) },
      `${i + 1}. ${one.show}`,
    );
  put(
    box,
    h("h2", {}, `Lesson ${view.lesson}: ${lesson.title}`),
    h("p", { class: "muted" }, lesson.goal),
    h("div", { class: "try", role: "group", "aria-label": "Scenes" }, lesson.scenes.map(button)),
    h("p", { id: "lesson-words", "aria-live": "polite" }, lesson.scenes[view.scene - 1]?.say ?? CHOOSE),
    h(
      "div",
      { class: "row" },
      view.lesson < LESSONS.length &&
        h("button", { type: "button", onclick: () => begin(view.lesson + 1) }, "Next lesson"),
      h("button", { type: "button", onclick: leave }, "Leave the lesson"),
    ),
  );
}
