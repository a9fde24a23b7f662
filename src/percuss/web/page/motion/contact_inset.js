// The contact under a magnifying glass, over the stage: the bounces before the last rest on the wall, gap over the time
// that was left, both by powers of ten. There each bounce is the one before moved along: R times as long, R² times as high.

import { theme } from "../pictures/colours.js";
import { ownCanvas } from "../pictures/pen.js";
import { tr } from "../core/words.js";

const [WIDTH, HEIGHT] = [230, 100];
const [LEFT, TOP, FOOT] = [8, 20, 18];

/** @typedef {{ time: number, kind: string, speed: number, chatter?: boolean }} Happening */

const about = { id: "contact-inset", role: "img", "aria-label": "The contact, magnified", hidden: true };
const { canvas, pen } = ownCanvas(WIDTH, HEIGHT, 2, about);
/** @type {Happening[]} */
let impacts = [];
/** @type {{ end: number, impacts: Happening[] } | null} */
let last = null;

/** The inset, for the stage to lie over. */
export const contactInset = () => canvas;

/** @param {boolean} whether */
export function showContact(whether) {
  if (canvas.hidden === !whether) return;
  canvas.hidden = !whether;
  impacts = [];
  last = null;
  draw();
}

/** @param {Happening} event */
export function contactHappened(event) {
  if (canvas.hidden) return;
  if (event.kind === "impact") impacts = [...impacts.slice(-40), event];
  else if (event.kind === "release") impacts = [];
  else if (event.kind === "rest" && impacts.length > 1) {
    last = { end: event.time, impacts };
    impacts = [];
    draw();
  }
}

/** Gap of a flight between two impacts under a constant push: a parabola that leaves and meets the wall. */
function flights() {
  if (!last) return [];
  const { end, impacts: all } = last;
  return all.slice(0, -1).map((from, i) => {
    const long = all[i + 1].time - from.time;
    const speed = all[i + 1].speed;
    return Array.from({ length: 41 }, (_, k) => {
      const share = 0.004 + (0.992 * k) / 40;
      return { left: end - from.time - share * long, gap: speed * long * share * (1 - share) };
    });
  });
}

function draw() {
  if (canvas.hidden) return;
  const { surface, muted, ink, kinds } = theme();
  pen.fillStyle = surface;
  pen.fillRect(0, 0, WIDTH, HEIGHT);
  pen.strokeStyle = muted;
  pen.strokeRect(0.5, 0.5, WIDTH - 1, HEIGHT - 1);
  pen.font = "10.5px system-ui, sans-serif";
  pen.fillStyle = ink;
  const curves = flights().filter((one) => one.every(({ left, gap }) => left > 0 && gap > 0));
  pen.fillText(tr(curves.length ? "the contact before the last rest" : "the contact: no rest yet"), LEFT, 13);
  canvas.dataset.bounces = String(curves.length);
  canvas.setAttribute("aria-label", tr(`The contact, magnified: ${curves.length} bounces before the rest`));
  if (!curves.length) return;
  const points = curves.flat();
  const [longest, shortest] = [points[0].left, Math.max(points[points.length - 1].left, 1e-12)].map(Math.log10);
  const highest = Math.log10(Math.max(...points.map(({ gap }) => gap)));
  const lowest = Math.log10(Math.min(...curves.map((one) => Math.max(...one.map(({ gap }) => gap))))) - 1;
  const x = (/** @type {number} */ left) =>
    LEFT + ((longest - Math.log10(left)) / (longest - shortest)) * (WIDTH - 2 * LEFT);
  const y = (/** @type {number} */ gap) =>
    TOP + ((highest - Math.log10(gap)) / (highest - lowest)) * (HEIGHT - TOP - FOOT);
  pen.lineWidth = 1.6;
  pen.strokeStyle = kinds[1];
  for (const one of curves) {
    pen.beginPath();
    for (const { left, gap } of one) pen.lineTo(x(left), Math.min(y(gap), HEIGHT - FOOT));
    pen.stroke();
  }
  pen.fillStyle = muted;
  pen.fillText(tr("gap ↑, time left →, both logarithmic"), LEFT, HEIGHT - 6);
}
