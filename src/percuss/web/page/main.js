// The page's start: theme, sound, tabs, the catalogue, and the state from the address.

import { get, takeToken } from "./core/api.js";
import { followAddress, fromAddress, keepAddress, writeAddress } from "./core/address.js";
import { isElsewhere, tellOthers } from "./clocked.js";
import { forPaper, forgetTheme, usePalette } from "./pictures/colours.js";
import { $, $$, flushFrames, h, put } from "./core/dom.js";
import { startHeadline } from "./screen/headline.js";
import { PANELS } from "./panels.js";
import { watchPreparing } from "./screen/preparing.js";
import { startSliders } from "./screen/sliders.js";
import { setSound, soundOn } from "./motion/sound.js";
import { DEFAULTS, data, know, on, pickMachine, setTables, show, tell, view, wish } from "./core/state.js";
import { during } from "./core/under_way.js";

const FIRST = "mini-breaker";
const THEMES = ["auto", "light", "dark"];

function toast(text) {
  const box = $("#toast");
  put(box, text);
  box.classList.add("on");
  setTimeout(() => box.classList.remove("on"), 3500);
}

/* theme */

function setTheme(name) {
  if (name === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = name;
  localStorage.setItem("percuss-theme", name);
  put($("#theme"), `Theme: ${name}`);
  forgetTheme();
  tell("theme");
}

function startTheme() {
  const kept = localStorage.getItem("percuss-theme");
  setTheme(THEMES.includes(kept) ? kept : "auto");
  $("#theme").addEventListener("click", () => {
    const now = document.documentElement.dataset.theme ?? "auto";
    setTheme(THEMES[(THEMES.indexOf(now) + 1) % THEMES.length]);
  });
  addEventListener("beforeprint", () => paper(true));
  addEventListener("afterprint", () => paper(false));
  for (const wish of ["(prefers-color-scheme: dark)", "(min-width: 1800px)"])
    matchMedia(wish).addEventListener("change", () => {
      forgetTheme();
      tell("theme");
    });
}

/** Paper is light: what is drawn is drawn anew for it, and again for the screen. */
function paper(whether) {
  forPaper(whether);
  tell("theme");
  flushFrames();
}

/* panels and their tabs */

function startPanels() {
  know(PANELS);
  const tab = ({ name, title }) =>
    h("button", { role: "tab", type: "button", id: `tab-${name}`, "aria-controls": `panel-${name}` }, title);
  const section = ({ name }) =>
    h("section", { role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}`, hidden: true });
  $("#tabs").append(...PANELS.map(tab));
  $("#panels").append(...PANELS.map(section));
  startTabs();
  for (const panel of PANELS) {
    const place = $(`#panel-${panel.name}`);
    panel.start(place);
    tellOthers(place, panel);
  }
}

function startTabs() {
  for (const tab of $$("[role=tab]")) tab.addEventListener("click", () => show({ panel: tab.id.slice(4) }));
  $("#tabs").addEventListener("keydown", (event) => {
    const tabs = $$("[role=tab]:not([hidden])");
    const now = tabs.findIndex((tab) => tab.id === `tab-${view.panel}`);
    const next = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: tabs.length - 1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    const tab = tabs[(next + tabs.length) % tabs.length];
    show({ panel: tab.id.slice(4) });
    tab.focus();
  });
  on("view tables", paintTabs);
}

let painted = "";

function paintTabs() {
  if (!$(`#tab-${CSS.escape(view.panel)}`)) view.panel = DEFAULTS.panel;
  for (const tab of $$("[role=tab]")) {
    const here = tab.id === `tab-${view.panel}`;
    tab.setAttribute("aria-selected", String(here));
    tab.tabIndex = here ? 0 : -1;
    tab.hidden = !here && data.tables && isElsewhere(PANELS.find(({ name }) => tab.id === `tab-${name}`));
    $(`#panel-${tab.id.slice(4)}`).hidden = !here;
  }
  if (view.panel === painted) return;
  painted = view.panel;
  const tab = $(`#tab-${view.panel}`); // on a narrow screen the row of tabs scrolls
  const row = $("#tabs");
  row.scrollLeft = tab.offsetLeft - (row.clientWidth - tab.offsetWidth) / 2;
}

/* tools */

function startTools() {
  $("#sound").addEventListener("click", async () => {
    await setSound(!soundOn());
    $("#sound").setAttribute("aria-pressed", String(soundOn()));
    put($("#sound"), soundOn() ? "Sound on" : "Sound off");
  });
  $("#share").addEventListener("click", async () => {
    writeAddress();
    try {
      await navigator.clipboard.writeText(location.href);
      toast("Copied: the link reproduces this view.");
    } catch {
      toast("The address bar holds the link; this browser does not let a page copy it.");
    }
  });
  $("#machine").addEventListener("change", (event) => {
    if (event.target.value) pickMachine(event.target.value).catch(failed);
  });
  on("view info", paintMachines);
}

function paintMachines() {
  const box = $("#machine");
  const key = JSON.stringify([view.machine, data.machines.length]);
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  const option = (value, text) => h("option", { value, selected: value === view.machine }, text);
  put(
    box,
    !view.machine && option("", "a case of your own"),
    data.machines.map((m) => option(m.name, m.title)),
    h("optgroup", { label: "Structures" }, data.structures.map((m) => option(m.name, m.title))),
  );
}

/* the state */

let server = null;
/** What the server is; its palette is taken with it. */
const about = () => (server ??= get("about").then((found) => (usePalette(found.palette), found)));

async function load(address) {
  const served = async () => ((await about()).case ? get("case") : null);
  const newest = wish();
  const [{ info, tables }] = await Promise.all([fromAddress(address, FIRST, served), about()]);
  if (!newest()) return;
  data.base = info?.tables ?? null;
  data.physical = null;
  setTables(tables, info ?? data.info);
  tell("view");
}

function failed(error) {
  data.problems = error.problems ?? [{ key: "", value: null, message: String(error.message ?? error), remedy: "" }];
  tell("problems");
  delete $("#machine").dataset.key; // a machine that did not come is not the one that is shown
  paintMachines();
}

async function start() {
  takeToken();
  startTheme();
  startPanels();
  startHeadline();
  startSliders();
  startTools();
  view.panel = new URLSearchParams(location.hash.slice(1)).get("panel") ?? DEFAULTS.panel;
  paintTabs();
  try {
    const catalogue = get("machines");
    const case_ = load(location.hash).catch(failed); // a link may name a machine that there is not
    data.about = await about();
    watchPreparing(data.about);
    Object.assign(data, await catalogue); // machines and structures
    await case_;
    paintMachines();
    tell("view");
  } catch (error) {
    failed(error);
  }
  keepAddress();
  writeAddress();
  followAddress((hash) => load(hash).catch(failed));
  document.documentElement.dataset.ready = "1";
}

during("start", start());
