// The drawers: questions beside the screen. One opens over the strip and the reasons; pressed again, over all but the
// verdict and the stage. Lessons and the report open from the head, whole.

import { $, button, div, h, put } from "../core/dom.js";
import { effect } from "../core/signals.js";
import { data, isHeld, know, show, switchesItself, view } from "../core/state.js";
import { during } from "../core/under_way.js";
import { tr } from "../core/words.js";

/** What a drawer is: its name in the address, its title, the module that fills it; where it belongs, for which cases.
 * @typedef {{ name: string, title: string, load: () => Promise<{ start: (place: HTMLElement) => void }>, place?: "head",
 *   early?: boolean, clocked?: boolean, free?: boolean, defaults?: Record<string, unknown>, needs?: import("../core/state.js").Needs }} Panel */

/** @param {Panel} panel */
const applies = ({ clocked, free }) => !(clocked && switchesItself()) && !(free && isHeld());

/** Start them; what is returned fetches their modules, so that one that is opened is there at once.
 * @param {Panel[]} panels */
export function startDrawers(panels) {
  know(panels);
  const drawer = $("#drawer");
  const shut = () => show({ panel: "", tall: 0 });
  const closing = { class: "icon", id: "drawer-close", "aria-label": "Close", title: "Close (Esc)" };
  const grow = button("", () => show({ tall: view.tall ? 0 : 1 }), { class: "icon", id: "drawer-tall" });
  const title = h("h2", { id: "drawer-title" });
  const sections = panels.map(({ name }) =>
    h("section", { class: "panel", id: `panel-${name}`, "aria-labelledby": "drawer-title", hidden: true }),
  );
  put(drawer, div("drawer-head", title, grow, button("✕", shut, closing)), div("drawer-body", sections));
  const fill = (/** @type {number} */ i) => filled(panels[i], sections[i]);
  panels.forEach((panel, i) => effect(() => void (isWanted(panel) && fill(i))));
  const ahead = (/** @type {number} */ i) => (panels[i].early ? fill(i) : void panels[i].load().catch(() => {}));
  $("#drawers").append(...panels.filter(({ place }) => !place).map(opener));
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !view.panel || event.defaultPrevented) return;
    const { panel } = view;
    shut();
    $(`#tab-${panel}`)?.focus();
  });
  effect(() => {
    const now = panels.find(({ name }) => name === view.panel);
    const open = Boolean(now && data.tables && applies(now));
    const tall = open && (view.tall || now?.place) ? "tall" : open ? "half" : "";
    drawer.hidden = !open;
    document.documentElement.dataset.embed = String(view.embed);
    $("#screen").dataset.drawer = tall;
    put(title, now?.title ?? "");
    grow.hidden = Boolean(now?.place);
    put(grow, view.tall ? "▾" : "▴");
    grow.setAttribute("aria-label", tr(view.tall ? "Smaller" : "Larger"));
    panels.forEach((panel, i) => {
      sections[i].hidden = panel !== now;
      const tab = $(`#tab-${panel.name}`);
      tab.hidden = Boolean(data.tables) && !applies(panel);
      tab.setAttribute("aria-expanded", String(open && panel === now));
    });
  });
  return () => panels.forEach((_, i) => whenIdle(() => ahead(i)));
}

/** Whether something in the view is the drawer's. @param {Panel} panel */
const isWanted = ({ name, defaults = {} }) =>
  view.panel === name || Object.entries(defaults).some(([key, value]) => view[key] !== value);

/** @type {Set<string>} */
const loaded = new Set();

/** A drawer with what is in it, once. @param {Panel} panel @param {HTMLElement} section */
async function filled({ name, load }, section) {
  if (loaded.has(name)) return;
  loaded.add(name);
  try {
    const { start } = await during("drawer", load());
    start(section);
  } catch (error) {
    reportError(error);
    put(section, h("p", { class: "note bad" }, "This part of the page could not be loaded. Load the page again."));
  }
}

/** When there is nothing else to do; not every browser can tell. @param {() => void} action */
const whenIdle = (action) =>
  "requestIdleCallback" in globalThis ? requestIdleCallback(action) : setTimeout(action, 200);

/** The button of a drawer: pressed, it opens; again, it grows; again, it closes. @param {Panel} panel */
export function opener({ name, title, place }) {
  const press = () => {
    if (view.panel !== name) show({ panel: name, tall: 0 });
    else if (view.tall || place) show({ panel: "", tall: 0 });
    else show({ tall: 1 });
  };
  return button(title, press, { id: `tab-${name}`, "aria-controls": "drawer", "aria-expanded": "false" });
}
