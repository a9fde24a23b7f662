// The strip below the stage: the gap of the striking end over the last eight periods, as it comes.

import { inUnit, scaleOf } from "../core/format.js";
import { data, view } from "../core/state.js";
import { Chart } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";

const PERIODS = 8;
const TURN = 2 * Math.PI;

export class Strip {
  /** @param {HTMLElement} other what stands there while a motion from a start is shown */
  constructor(other) {
    this.other = other;
    this.chart = new Chart("The last eight periods", { about: "The striking end over the last eight periods of the load" });
    this.chart.canvas.id = "strip";
    this.figure = this.chart.figure;
    this.told = 0;
    this.low = 0;
  }

  /** @param {any} stage */
  follow(stage) {
    const live = view.source === "orbit";
    this.figure.hidden = !live;
    if (this.other) this.other.hidden = live;
    const now = performance.now();
    if (!live || now - this.told < 30) return;
    this.told = now;
    const { past } = stage;
    const metre = data.info?.scales?.length_m;
    const length = metre ? scaleOf(stage.deepest * metre, "m") : { factor: 1, unit: "" };
    const k = (metre ?? 1) * length.factor;
    const [x, y] = [new Float64Array(past.length), new Float64Array(past.length)];
    for (let i = 0; i < past.length; i++) {
      x[i] = (past[i].at - stage.now) / TURN;
      y[i] = past[i].gap * k;
    }
    const { accent, kinds, muted } = theme();
    this.chart.draw({
      x: { label: "periods of the load ago", from: -PERIODS, to: 0.05, ticks: [-8, -6, -4, -2, 0].map((n) => [n, String(-n)]) },
      y: { label: inUnit("gap", length.unit), from: -1.06 * stage.deepest * k, to: 0.12 * stage.deepest * k },
      items: [
        { type: "level", at: 0, colour: muted, width: 3, name: "the wall" },
        ...[...stage.ghosts.values()].map(({ name, past: own, now: at }) => ({
          type: "line",
          x: own.map((one) => (one.at - at) / TURN),
          y: own.map((one) => one.gap * k),
          colour: name === "A" ? accent : muted,
          dash: [5, 4],
          width: 1.6,
          name,
        })),
        { type: "line", x, y, colour: kinds[0], width: 2, name: "striking end" },
      ],
    });
  }
}
