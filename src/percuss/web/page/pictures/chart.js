// Charts on a canvas, drawn in well under a millisecond each so that a slider repaints them all within its frame.
// A chart is told what to draw by a plain object (chart_pen.js).

import { button, div, h, put } from "../core/dom.js";
import { theme } from "./colours.js";
import { layout, mark, paint, swatch } from "./chart_pen.js";
import { data } from "../core/state.js";
import { ownCanvas, penOf, strokeLines } from "./pen.js";
import { tr } from "../core/words.js";

/** @typedef {import("./chart_pen.js").Item} Item */
/** @typedef {import("./chart_pen.js").Spec} Spec */
/** A point over a picture. @typedef {[x: number, y: number, colour: string]} Over */

/** The ticks of a phase. */
export const PHASES = /** @type {[number, string][]} */ (
  ["0", "π/2", "π", "3π/2", "2π"].map((text, i) => [(i * Math.PI) / 2, text])
);

/** @type {Map<Element, Chart>} */
const charts = new Map();

/** Tells charts when they come into sight; those that are not are not painted. */
const sight = new IntersectionObserver(
  (entries) => {
    for (const { target, isIntersecting } of entries) {
      const chart = /** @type {Chart} */ (charts.get(target));
      chart.seen = isIntersecting;
      if (isIntersecting && chart.stale) chart.repaint();
    }
  },
  { rootMargin: "60px" },
);

addEventListener("beforeprint", () => {
  for (const chart of charts.values()) {
    chart.seen = true;
    chart.repaint();
  }
});

export class Chart {
  /** A figure with its caption, its canvas and its legend; `about` says in words what is drawn.
   * @param {string} title @param {{ kind?: string, about?: string, role?: string }} [options] */
  constructor(title, { kind = "", about = title, role = "img" } = {}) {
    this.title = title;
    this.canvas = h("canvas", { role, "aria-label": about });
    this.key = h("ul", { class: "legend" });
    const kinds = /** @type {const} */ (["svg", "png", "csv"]);
    this.saving = h(
      "details",
      { class: "menu save" },
      h("summary", { "aria-label": `Save: ${title}`, title: "Save the picture, or its numbers" }, "⤓"),
      div(
        "sheet",
        kinds.map((one) => button(one.toUpperCase(), () => this.save(one))),
      ),
    );
    const caption = h("figcaption", {}, h("span", {}, title), this.saving);
    this.figure = h("figure", { class: `chart ${kind}` }, caption, this.canvas, this.key);
    /** @type {Spec | null} */
    this.spec = null;
    /** @type {import("./chart_pen.js").Frame | null} */
    this.frame = null;
    this.legend = "";
    this.drawn = 0;
    this.box = [0, 0]; // kept, for asking the canvas makes the browser lay the page out at once
    this.seen = this.stale = false;
    /** What is over the picture: points, and where a line stands. @type {[Over[], number | null] | null} */
    this.above = null;
    /** The picture without that, and where there is something over it. @type {HTMLCanvasElement | null} */
    this.still = null;
    /** @type {number[][]} */
    this.covered = [];
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.repaint();
    }).observe(this.canvas);
    sight.observe(this.canvas);
    charts.set(this.canvas, this);
  }

  /** Draw this: at once, or when the chart comes into sight. @param {Spec} spec */
  draw(spec) {
    this.spec = spec;
    this.above = null;
    if (spec.about) this.canvas.setAttribute("aria-label", tr(spec.about));
    const named = keyed(spec.items);
    const { dark } = theme();
    const legend = JSON.stringify(named.map((one) => [one.name, one.colour, one.hatch, one.shape, one.dash, dark]));
    if (legend !== this.legend) {
      this.legend = legend;
      put(
        this.key,
        named.map((item) => h("li", {}, swatch(item), item.name)),
      );
    }
    this.repaint();
  }

  /** Hand it over as a file: a picture with its legend, or its numbers. @param {"svg" | "png" | "csv"} kind */
  async save(kind) {
    const { save } = await import("./export.js");
    this.saving.open = false;
    if (this.spec) await save(this, kind, { name: data.tables?.title ?? "" });
  }

  repaint() {
    const { canvas, spec, box } = this;
    this.stale = !this.seen;
    if (!spec || !box[0] || !box[1] || this.stale) return;
    const { pen, width, height } = penOf(canvas, box, 3);
    this.frame = layout(pen, spec, width, height);
    paint(pen, spec, this.frame);
    this.drawn += 1;
    canvas.dataset.drawn = String(this.drawn);
    this.still = null;
    if (this.above) this.over(...this.above);
  }

  /** Points, and a line from top to bottom, drawn over the picture as it stands, many times a second.
   * @param {Over[]} points @param {number | null} [line] */
  over(points, line = null) {
    const { canvas, frame } = this;
    this.above = [points, line]; // for a later repaint of the same picture
    if (!frame || !this.box[0] || !this.seen) return;
    const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    if (this.still) this.uncover(pen, this.still);
    else {
      const still = ownCanvas(canvas.width, canvas.height);
      still.pen.drawImage(canvas, 0, 0);
      this.still = still.canvas;
    }
    this.covered = [];
    const { px, py, top, bottom } = frame;
    if (line !== null) {
      this.covered.push([px(line) - 2, top - 2, 4, bottom - top + 4]);
      pen.setLineDash([]);
      strokeLines(pen, theme().accent, 1.5, [px(line), top, px(line), bottom]);
    }
    for (const [x, y, colour] of points) {
      if (!Number.isFinite(y)) continue;
      mark(pen, "disc", px(x), py(y), 6, colour);
      this.covered.push([px(x) - 9, py(y) - 9, 18, 18]);
    }
  }

  /** The picture again where something is over it, and only there.
   * @param {CanvasRenderingContext2D} pen @param {HTMLCanvasElement} still */
  uncover(pen, still) {
    const ratio = pen.getTransform().a;
    pen.save();
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.beginPath();
    for (const [x, y, width, height] of this.covered)
      pen.rect(
        Math.floor(x * ratio),
        Math.floor(y * ratio),
        Math.ceil(width * ratio) + 1,
        Math.ceil(height * ratio) + 1,
      );
    pen.clip();
    pen.clearRect(0, 0, still.width, still.height);
    pen.drawImage(still, 0, 0);
    pen.restore();
  }

  /** The point of the plane under a pointer event; beside the plane null, unless the pointer may be `anywhere`.
   * @param {{ clientX: number, clientY: number }} event */
  at(event, anywhere = false) {
    if (!this.frame) return null;
    const box = this.canvas.getBoundingClientRect();
    const { left, right, top, bottom, toX, toY } = this.frame;
    const { scale } = theme();
    const [px, py] = [(event.clientX - box.left) / scale, (event.clientY - box.top) / scale];
    const inside = px >= left - 8 && px <= right + 8 && py >= top - 8 && py <= bottom + 8;
    return inside || anywhere ? { x: toX(px), y: toY(py) } : null;
  }
}

/** The items that a legend tells: the first of each name. @param {Item[]} items */
export const keyed = (items) =>
  items.filter(({ name }, i) => name && items.findIndex((item) => item.name === name) === i);

/** The least and the greatest of some lists, with a margin; a flat one gets room.
 * @param {Iterable<Iterable<number | null>>} lists */
export function span(lists, margin = 0.08) {
  let [low, high] = [Infinity, -Infinity];
  for (const list of lists)
    for (const value of list) {
      if (value === null || !Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  if (low > high) return [-1, 1];
  const room = (high - low || Math.abs(high) || 1) * margin;
  return [low - room, high + room];
}
