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

  /** What a stage has shown; `length` is in metres, `period` in the time of the stage, `levels` are behind the wall, in bar
   * lengths. @param {import("./live_stage.js").LiveStage} stage
   * @param {{ shown: boolean, length?: number | null, period: number, name: string, levels?: { at: number }[] }} how */
  follow(stage, { shown, length: metre, period, name, levels = [] }) {
    this.figure.hidden = !shown;
    this.other.hidden = shown;
    const now = performance.now();
    if (!shown || now - this.told < EVERY) return;
    this.told = now;
    const length = metre ? scaleOf(stage.deepest * metre, "m") : { factor: 1, unit: "" };
    const k = (metre ?? 1) * length.factor;
    const { accent, bad, kinds, muted } = theme();
    const low = -1.06 * stage.deepest * k;
    /** @param {import("./live_stage.js").Past[]} past @param {number} at @param {Record<string, any>} looks */
    const line = (past, at, looks) => {
      const [x, y] = [past.map((one) => (one.at - at) / period), past.map((one) => one.gap * k)];
      return { type: "line", x, y, ...looks };
    };
    const ghosts = [...stage.ghosts.values()].map((one) =>
      line(one.past, one.now, { colour: one.name === "A" ? accent : muted, dash: [5, 4], width: 1.6, name: one.name }),
    );
    const inside = stage.past.map(({ at, gap }) => ({ at, gap: gap > 0 ? gap : Number.NaN }));
    const through = { colour: bad, width: 3, name: "inside the wall: not possible" };
    this.chart.draw({
      x: { label: name, from: -PERIODS, to: 0.05, ticks: [-8, -6, -4, -2, 0].map((n) => [n, String(-n)]) },
      y: { label: inUnit("gap", length.unit), from: low, to: -0.12 * low },
      items: [
        { type: "level", at: 0, colour: muted, width: 3, name: "the wall" },
        ...levels
          .filter(({ at }) => -at * k > low)
          .map(({ at }) => ({ type: "level", at: -at * k, colour: kinds[3], dash: [6, 4], name: "ports" })),
        ...ghosts,
        line(stage.past, stage.now, { colour: kinds[0], width: 2, name: "striking end" }),
        ...(stage.past.some(({ gap }) => gap > 1e-6) ? [line(inside, stage.now, through)] : []),
      ],
    });
  }
}
