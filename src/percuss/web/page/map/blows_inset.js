// The last thirty blows in a corner of the map: their phase and their speed. One dot is a motion with one blow, two take
// turns, and what never repeats fills a curve.

import { switchesItself } from "../core/state.js";
import { theme } from "../pictures/colours.js";
import { ownCanvas } from "../pictures/pen.js";
import { tr } from "../core/words.js";

const KEPT = 30;
const [WIDTH, HEIGHT] = [104, 70];
const TURN = 2 * Math.PI;

/** @typedef {{ phase: number, speed: number }} Blow */

const about = { id: "blows-inset", role: "img", "aria-label": "The last blows: phase and speed" };
const { canvas, pen } = ownCanvas(WIDTH, HEIGHT, 2, about);
/** @type {Blow[]} */
let blows = [];

/** The inset, for the map to put into its corner. */
export const blowsInset = () => canvas;

/** @param {Blow} blow */
export function tellBlow(blow) {
  blows = [...blows.slice(1 - KEPT), blow];
  draw();
}

/** Another hammer: the blows before are not its own. */
export function forgetBlows() {
  blows = [];
  draw();
}

function draw() {
  const { surface, muted, kinds } = theme();
  pen.clearRect(0, 0, WIDTH, HEIGHT);
  if (!blows.length) return;
  pen.globalAlpha = 0.88;
  pen.fillStyle = surface;
  pen.fillRect(0, 0, WIDTH, HEIGHT);
  pen.globalAlpha = 1;
  pen.strokeStyle = muted;
  pen.strokeRect(0.5, 0.5, WIDTH - 1, HEIGHT - 1);
  pen.fillStyle = muted;
  pen.font = "9.5px system-ui, sans-serif";
  pen.fillText(tr(switchesItself() ? "interval → , speed ↑" : "phase → , speed ↑"), 5, HEIGHT - 4);
  const most = Math.max(...blows.map(({ speed }) => speed), 1e-30);
  pen.fillStyle = kinds[1];
  blows.forEach(({ phase, speed }, i) => {
    pen.globalAlpha = 0.25 + (0.75 * (i + 1)) / blows.length;
    pen.beginPath();
    pen.arc(
      5 + ((((phase % TURN) + TURN) % TURN) / TURN) * (WIDTH - 10),
      HEIGHT - 14 - (Math.max(speed, 0) / most) * (HEIGHT - 22),
      2.6,
      0,
      TURN,
    );
    pen.fill();
  });
  pen.globalAlpha = 1;
  canvas.dataset.blows = String(blows.length);
}
