// The strip below the stage: the gap of the striking end over the last eight periods, as it comes.

import { inUnit, scaleOf } from "../core/format.js";
import { Chart } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";

const PERIODS = 8;
const EVERY = 30; // ms

export class Strip {
  /** @param {string} id @param {HTMLElement} other what stands there while a motion from a start is shown */
  constructor(id, other) {
    this.other = other;
    this.chart = new Chart("The last eight periods", { about: "The striking end over the last eight periods" });
    this.chart.canvas.id = id;
    this.figure = this.chart.figure;
    this.figure.hidden = true;
    this.told = 0;
  }

  /** What a stage has shown; `length` is in metres, `period` in the time of the stage, `levels` are {at, text} behind the
   * wall, in bar lengths. */
  follow(stage, { shown, length: metre, period, name, levels = [] }) {
    this.figure.hidden = !shown;
    this.other.hidden = shown;
    const now = performance.now();
    if (!shown || now - this.told < EVERY) return;
    this.told = now;
    const length = metre ? scaleOf(stage.deepest * metre, "m") : { factor: 1, unit: "" };
    const k = (metre ?? 1) * length.factor;
    const { accent, bad, kinds, muted } = theme();
    const line = (past, at) => ({ type: "line", x: past.map((one) => (one.at - at) / period), y: past.map((one) => one.gap * k) });
    const low = -1.06 * stage.deepest * k;
    this.chart.draw({
      x: { label: name, from: -PERIODS, to: 0.05, ticks: [-8, -6, -4, -2, 0].map((n) => [n, String(-n)]) },
      y: { label: inUnit("gap", length.unit), from: low, to: -0.12 * low },
      items: [
        { type: "level", at: 0, colour: muted, width: 3, name: "the wall" },
        ...levels.filter(({ at }) => -at * k > low).map(({ at }) => ({ type: "level", at: -at * k, colour: kinds[3], dash: [6, 4], name: "ports" })),
        ...[...stage.ghosts.values()].map((one) => ({ ...line(one.past, one.now), colour: one.name === "A" ? accent : muted, dash: [5, 4], width: 1.6, name: one.name })),
        { ...line(stage.past, stage.now), colour: kinds[0], width: 2, name: "striking end" },
        ...(stage.past.some(({ gap }) => gap > 1e-6) ? [{ ...line(stage.past.map((one) => ({ ...one, gap: one.gap > 0 ? one.gap : Number.NaN })), stage.now), colour: bad, width: 3, name: "inside the wall: not possible" }] : []),
      ],
    });
  }
}
