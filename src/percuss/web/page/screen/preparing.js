// While the server compiles its kernels, as it does once on a machine: what waits for that, and how far it is.

import { get } from "../core/api.js";
import { $, h, put } from "../core/dom.js";

/** @type {Record<string, string>} */
const PARTS = {
  multipliers: "curves and maps of stability",
  motions: "simulated motions",
  blows: "blows resolved by waves",
  machines: "machines that switch themselves",
  orbits: "branches",
};
const PATIENCE = 1000; // ms
const FIRST = 3000; // ms; kernels that were compiled before are loaded by then

/** Say so until it is done. @param {any} about what the server told of itself when the page was opened */
export async function watchPreparing(about) {
  const box = $("#preparing");
  const begun = performance.now();
  const bar = h("progress", { max: about.kernels?.length ?? 1, "aria-label": "Parts compiled" });
  const told = h("span");
  put(box, bar, " ", told);
  while (about.preparing.length) {
    await new Promise((done) => setTimeout(done, performance.now() - begun < FIRST ? FIRST : PATIENCE));
    try {
      about = await get("about");
    } catch {
      break; // the next question of the page tells what is wrong
    }
    const { kernels, preparing } = about;
    box.hidden = !preparing.length;
    if (box.hidden) return;
    bar.value = kernels.length - preparing.length;
    const now = PARTS[preparing[0]] ?? preparing[0];
    const seconds = Math.round((performance.now() - begun) / 1000);
    put(
      told,
      `Compiling the simulator, once on this machine: ${bar.value} of ${kernels.length} parts, now ${now}; ${seconds} s so far. Steady motions are there already.`,
    );
  }
  box.hidden = true;
}
