// While the server compiles its kernels, as it does once on a machine: what waits for that, and what does not.

import { get } from "./api.js";
import { $, put } from "./dom.js";

const WORDS =
  "The simulator is being compiled; this happens once on this machine and takes up to a minute. " +
  "Steady motions are available already; curves, stability maps and simulated motions follow.";
const PATIENCE = 3000; // ms; kernels that were compiled before are loaded by then

/** Say so until it is done; `about` is what the server told of itself when the page was opened. */
export async function watchPreparing(about) {
  const box = $("#preparing");
  while (!about.ready) {
    await new Promise((done) => setTimeout(done, PATIENCE));
    try {
      about = await get("about");
    } catch {
      break; // the next question of the page tells what is wrong
    }
    if (!about.ready && box.hidden) {
      box.hidden = false;
      put(box, WORDS);
    }
  }
  box.hidden = true;
}
