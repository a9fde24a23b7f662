// What stands on the screen: a bar under a load, a machine that switches itself, or one blow by its waves; each with its
// stage, the strip of its last periods, and the picture that tells why. The rest of it is in the drawers.

import { blowScene } from "../blow/blow_panel.js";
import { $, h, put } from "../core/dom.js";
import { effect } from "../core/signals.js";
import { DEFAULTS, data, isHeld, switchesItself, view } from "../core/state.js";
import { defaults as ofMachine, startMachine } from "../machine/machine_panel.js";
import { defaults as ofMap } from "../map/map_panel.js";
import { defaults as ofMotion, startMotion } from "../motion/motion_panel.js";
import { whyOfOrbits } from "../orbits/orbits_panel.js";

const scenes = {};

/** Which of them is in sight. */
const shown = () => (view.panel === "blow" && !isHeld() ? "blow" : switchesItself() ? "machine" : "motion");

export function startScenes() {
  Object.assign(DEFAULTS, ofMotion, ofMachine, ofMap);
  Object.assign(view, DEFAULTS);
  Object.assign(scenes, { motion: { ...startMotion(), why: whyOfOrbits() }, machine: startMachine(), blow: blowScene() });
  const held = h("div", { class: "fill" }); // the phase portrait of a structure, which has no band of its load
  scenes.motion.why = [scenes.motion.why, held];
  const place = (name) => Object.entries(scenes).map(([scene, parts]) => parts[name] && h("div", { class: "scene", "data-scene": scene }, parts[name]));
  for (const name of ["stage", "strip", "why"]) put($(`#${name}-place`), place(name));
  effect(() => {
    if (!data.tables) return;
    const now = shown();
    document.documentElement.dataset.scene = now;
    for (const one of document.querySelectorAll("[data-scene]")) if (one !== document.documentElement) one.hidden = one.dataset.scene !== now;
    scenes.motion.details.hidden = switchesItself();
    scenes.machine.details.hidden = !switchesItself();
    scenes.motion.why[0].hidden = isHeld();
    held.hidden = !isHeld();
    (isHeld() ? held : scenes.motion.portraits).prepend(scenes.motion.portrait);
  });
  addEventListener("keydown", keys);
}

/** What the drawer of all motions tells of them. */
export const detailsOfScenes = () => [scenes.motion.details, scenes.machine.details];

/** Space plays and pauses, and the arrow keys step a blow, wherever nothing else wants them. */
function keys(event) {
  if (event.defaultPrevented || event.target.closest("button, select, summary, a, textarea, input:not([type=range])")) return;
  const { toggle, step } = scenes[shown()];
  const way = !event.target.closest("input, [role=application]") && { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === " ") toggle();
  else if (way && step) step(way);
  else return;
  event.preventDefault();
}
