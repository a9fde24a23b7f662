// What stands on the screen: a bar under a load, a machine that switches itself, or one blow by its waves; each with its
// stage, the strip of its last periods, and the picture that tells why. The rest of it is in the drawers.

import { $, div, h } from "../core/dom.js";
import { effect } from "../core/signals.js";
import { DEFAULTS, data, isHeld, switchesItself, view } from "../core/state.js";
import { during } from "../core/under_way.js";
import { defaults as ofMap } from "../map/map_panel.js";
import { defaults as ofMotion, startMotion } from "../motion/motion_panel.js";
import { whyOfOrbits } from "../orbits/orbits_panel.js";

/** What a scene puts on the screen, into the drawer of all motions, and what plays it.
 * @typedef {{ stage: any, strip?: any, why?: any, details?: HTMLElement, toggle: () => void,
 *   step?: (way: number) => void }} Scene */

/** @type {Record<string, Scene>} */
const scenes = {};
/** The scenes that are loaded when they are first in sight. @type {Record<string, () => Promise<() => Scene>>} */
const LATER = {
  machine: async () => (await import("../machine/machine_panel.js")).startMachine,
  blow: async () => (await import("../blow/blow_panel.js")).blowScene,
};
const MACHINE = { machineSlow: "", machineShow: "cycle" };

/** What the drawer of all motions tells of them. */
export const detailsOfScenes = div("stack");

/** Which of them is in sight. */
const shown = () => (view.panel === "blow" && !isHeld() ? "blow" : switchesItself() ? "machine" : "motion");

/** @param {string} name @param {Scene} scene */
function place(name, scene) {
  scenes[name] = scene;
  for (const [where, what] of Object.entries({ stage: scene.stage, strip: scene.strip, why: scene.why }))
    if (what) $(`#${where}-place`).append(h("div", { class: "scene", "data-scene": name }, what));
  if (scene.details) detailsOfScenes.append(scene.details);
}

/** The scene in sight, which may have to be loaded first. @param {string} name */
async function bring(name) {
  const load = LATER[name];
  delete LATER[name];
  if (load) {
    const make = await during("scene", load());
    place(name, make());
  }
  const now = shown();
  for (const one of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("body [data-scene]")))
    one.hidden = one.dataset.scene !== now;
  for (const [one, { details }] of Object.entries(scenes))
    if (details) details.hidden = (one === "machine") !== switchesItself();
}

export function startScenes() {
  Object.assign(DEFAULTS, ofMotion, MACHINE, ofMap);
  Object.assign(view, DEFAULTS);
  const held = div("fill"); // the phase portrait of a structure, which has no band of its load
  const { portrait, portraits, ...motion } = startMotion();
  const why = whyOfOrbits();
  place("motion", { ...motion, why: [why, held] });
  effect(() => {
    if (!data.tables) return;
    const now = shown();
    document.documentElement.dataset.scene = now;
    bring(now);
    why.hidden = isHeld();
    held.hidden = !isHeld();
    (isHeld() ? held : portraits).prepend(portrait);
  });
  addEventListener("keydown", keys);
}

/** Space plays and pauses, and the arrow keys step a blow, wherever nothing else wants them. @param {KeyboardEvent} event */
function keys(event) {
  const target = /** @type {Element} */ (event.target);
  if (event.defaultPrevented || target.closest("button, select, summary, a, textarea, input:not([type=range])")) return;
  const { toggle, step } = scenes[shown()] ?? {};
  const way =
    !target.closest("input, [role=application]") &&
    /** @type {Record<string, number>} */ ({ ArrowLeft: -1, ArrowRight: 1 })[event.key];
  if (event.key === " ") toggle?.();
  else if (way && step) step(way);
  else return;
  event.preventDefault();
}
