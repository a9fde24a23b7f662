// The head of the page: which machine, what was changed in it, undo and redo, the places, sound, theme, links and files.

import { differences, redo, undo, undone } from "../core/address.js";
import { $, button, div, flushFrames, h, labelled, menu, put, select } from "../core/dom.js";
import { quantity, system, useSystem, withUnit } from "../core/format.js";
import { valueAt } from "../core/moves.js";
import { effect, flush } from "../core/signals.js";
import { chosen, data, pickMachine, presentValues, setKey, setTables, show, view } from "../core/state.js";
import { setSound, soundOn } from "../motion/sound.js";
import { forPaper, forgetTheme } from "../pictures/colours.js";
import { opener } from "./drawers.js";
import { presentFigures } from "./headline.js";
import { shareMenu } from "./share.js";
import { LANGUAGES, language, tr, useLanguage } from "../core/words.js";

const THEMES = ["auto", "light", "dark"];

/** @param {string} text */
export function toast(text) {
  const box = $("#toast");
  put(box, text);
  box.classList.add("on");
  setTimeout(() => box.classList.remove("on"), 3500);
}

/** @param {import("./drawers.js").Panel[]} panels @param {(error: unknown) => void} failed */
export function startHeader(panels, failed) {
  const icon = (
    /** @type {string} */ id,
    /** @type {string} */ sign,
    /** @type {string} */ label,
    /** @type {() => void} */ press,
  ) => button(sign, press, { class: "icon", id, title: label, "aria-label": label });
  const pick = (/** @type {string} */ name) => name && pickMachine(name).catch(failed);
  const machine = menu([], "", pick, { id: "machine", "aria-label": "Machine" });
  const changes = h(
    "details",
    { class: "menu", id: "changes" },
    h("summary", {}, "● changed"),
    h("ul", { class: "sheet" }),
  );
  const steps = [icon("undo", "↶", "Undo (Ctrl+Z)", undo), icon("redo", "↷", "Redo (Ctrl+Y)", redo)];
  const reset = button("Reset", () => restore(failed), { id: "reset", title: "The machine as it was" });
  const keeping = { id: "pin", title: "Keep the present design as A, and compare with it" };
  const pin = button("Pin A", pinned, keeping);
  const explore = button("Explore", () => show({ panel: "", tall: 0, lesson: 0, scene: 0 }), { id: "explore" });
  const places = h(
    "nav",
    { class: "places", "aria-label": "Places" },
    explore,
    panels.filter(({ place }) => place).map(opener),
  );
  const sound = icon("sound", "♪", "Sound: hear each blow", async () => {
    await setSound(!soundOn());
    sound.setAttribute("aria-pressed", String(soundOn()));
  });
  sound.setAttribute("aria-pressed", "false");
  const theme = icon("theme", "◐", "Theme", () =>
    setTheme(THEMES[(THEMES.indexOf(chosenTheme()) + 1) % THEMES.length]),
  );
  const systems = [
    ["practical", "practical: mm, bar"],
    ["SI", "SI"],
    ["US", "US: in, psi"],
  ];
  const languages = h(
    "select",
    { id: "language", onchange: () => useLanguage(languages.value) },
    Object.entries(LANGUAGES).map(([value, name]) =>
      h("option", { value, lang: value, translate: "no", selected: value === language }, name),
    ),
  );
  const settings = h(
    "details",
    { class: "menu", id: "settings" },
    h(
      "summary",
      { title: "Language and units" },
      h("span", { translate: "no" }, language === "en" ? "Aa" : language.toUpperCase()),
    ),
    div("sheet column", labelled("Language", languages), select("Units", systems, system, useSystem, { id: "units" })),
  );
  const files = button("Files", () => show({ panel: "case", tall: 1 }), { id: "files" });
  const share = shareMenu();
  $("#top").append(
    machine,
    changes,
    div("steps", steps, reset, pin),
    places,
    div("tools", settings, sound, theme, share, files),
  );
  startTheme();
  addEventListener("keydown", keys);
  effect(() => {
    const names = JSON.stringify([view.machine, data.machines.length, !view.machine && data.tables?.title]);
    if (machine.dataset.key === names && machine.value === view.machine) return; // one that did not come is not shown
    machine.dataset.key = names;
    const option = (/** @type {string} */ value, /** @type {string} */ text) =>
      h("option", { value, selected: value === view.machine }, text);
    put(
      machine,
      !view.machine && option("", data.tables?.title || "a case of your own"),
      data.machines.map((/** @type {any} */ m) => option(m.name, m.title)),
      h(
        "optgroup",
        { label: "Structures" },
        data.structures.map((/** @type {any} */ m) => option(m.name, m.title)),
      ),
    );
  });
  effect(() => {
    const list = changed();
    changes.hidden = !list.length;
    reset.disabled = !list.length;
    if (!list.length) changes.open = false;
    put(/** @type {HTMLElement} */ (changes.lastElementChild), list.map(one));
  });
  effect(() => {
    const { back, forth } = undone.value;
    steps[0].disabled = !back;
    steps[1].disabled = !forth;
    pin.setAttribute("aria-pressed", String(Boolean(data.pinned)));
    put(pin, data.pinned ? "A ✕" : "Pin A");
    explore.setAttribute("aria-current", String(!panels.some(({ place, name }) => place && name === view.panel)));
  });
}

/** Keep the present design as A, or let A go. */
function pinned() {
  const now = data.pinned
    ? null
    : {
        tables: data.tables,
        values: presentValues(),
        figures: presentFigures(),
        model: data.quick?.motion,
        orbit: chosen()?.quick,
      };
  data.pinned = now;
  if (now) toast("A is kept: move on, and compare. The table stands under “Design and tolerance”, beside others.");
}

/** What the case has other than the machine that it was made from: [key, now, before]. */
export const changed = () => (data.tables && data.base ? differences(data.tables, data.base) : []);

/** @param {string[]} change */
function one([key, now, before]) {
  const name = data.info?.parameters.find((/** @type {any} */ p) => p.name === key)?.label ?? key;
  const back = button(short(before), () => setKey(key, valueAt(data.base ?? {}, key)), { class: "link" });
  return h("li", {}, name, ": ", short(now), " (was ", back, ")");
}

/** What a key has, a number with as many digits as can be read. @param {string} text */
function short(text) {
  const found = quantity(text);
  return found ? withUnit(found.value, found.unit, 6) : text || "none";
}

/** @param {(error: unknown) => void} failed */
function restore(failed) {
  if (view.machine) return pickMachine(view.machine).catch(failed);
  setTables(data.base);
}

/** @param {KeyboardEvent} event */
function keys(event) {
  const typing = /** @type {HTMLElement} */ (event.target).closest?.("input:not([type=range]), textarea");
  if (!(event.ctrlKey || event.metaKey) || typing) return;
  const press =
    event.key === "z" && !event.shiftKey
      ? undo
      : event.key === "y" || (event.key.toLowerCase() === "z" && event.shiftKey)
        ? redo
        : null;
  if (!press) return;
  event.preventDefault();
  press();
}

/* theme */

const chosenTheme = () => document.documentElement.dataset.theme ?? "auto";

/** @param {string} name */
function setTheme(name) {
  if (name === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = name;
  localStorage.setItem("percuss-theme", name);
  const label = `Theme: ${name}`;
  $("#theme").setAttribute("aria-label", tr(label));
  $("#theme").title = tr(label);
  forgetTheme();
}

function startTheme() {
  const kept = localStorage.getItem("percuss-theme") ?? "";
  setTheme(THEMES.includes(kept) ? kept : "auto");
  addEventListener("beforeprint", () => paper(true));
  addEventListener("afterprint", () => paper(false));
  for (const wish of ["(prefers-color-scheme: dark)", "(min-width: 1800px)", "(forced-colors: active)"])
    matchMedia(wish).addEventListener("change", forgetTheme);
}

/** Paper is light: what is drawn is drawn anew for it, and again for the screen. @param {boolean} whether */
function paper(whether) {
  forPaper(whether);
  flush();
  flushFrames();
}
