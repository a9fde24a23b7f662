// While the server compiles its kernels, as it does once on a machine: what waits for that, and how far it is.

import { get } from "../core/api.js";
import { $, h, put } from "../core/dom.js";

const PARTS = {
  multipliers: "curves and maps of stability",
  motions: "simulated motions",
  blows: "blows resolved by waves",
  machines: "machines that switch themselves",
  orbits: "branches",
};
const PATIENCE = 3000; // ms; kernels that were compiled before are loaded by then

/** Say so until it is done; `about` is what the server told of itself when the page was opened. */
export async function watchPreparing(about) {
  const box = $("#preparing");
  const begun = performance.now();
  const bar = h("progress", { max: about.kernels?.length ?? 1, "aria-label": "Parts compiled" });
  const told = h("span", {});
  put(box, bar, " ", told);
  while (about.preparing.length) {
    await new Promise((done) => setTimeout(done, PATIENCE));
    try {
      about = await get("about");
    } catch {
      break; // the next question of the page tells what is wrong
    }
    box.hidden = !about.preparing.length;
    if (box.hidden) continue;
    bar.value = done(about);
    put(told, words(about, begun));
  }
  box.hidden = true;
}

const done = ({ kernels, preparing }) => kernels.length - preparing.length;

function words(about, begun) {
  const [now, ...later] = about.preparing.map((part) => PARTS[part] ?? part);
  const minutes = Math.floor((performance.now() - begun) / 60000);
  const since = minutes ? ` for ${minutes} min here` : "";
  const rest = later.length ? ` Then come ${later.join(", ")}.` : "";
  return (
    `The simulator is being compiled${since}, once on this machine: a minute, or several where it is busy. ` +
    `${done(about)} of ${about.kernels.length} parts are done; now ${now}.${rest} Steady motions are available already.`
  );
}
