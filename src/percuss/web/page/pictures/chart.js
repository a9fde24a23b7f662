// Charts on a canvas, drawn in well under a millisecond each so that a slider repaints them all within its frame.
// A chart is told what to draw by a plain object:
//   x, y   {label, from, to, ticks?: [[value, text]]}      equal: true for one scale on both
//   image  {canvas, under, smooth, faded}                                drawn over the whole plane, first row at the bottom
//   items  line {x, y, colour, dash?, width?}, points {x, y, shape, colour, size?, under?: below the lines}, band {from, to, colour} (in y),
//          level {at, axis?, colour, dash?}, circle {radius}, label {x, y, text}

import { h, put } from "../core/dom.js";
import { theme } from "./colours.js";
import { layout, mark, paint, swatch } from "./chart_pen.js";
import { data } from "../core/state.js";
import { tr } from "../core/words.js";

export const PHASES = [0, 0.5, 1, 1.5, 2].map((i) => [i * Math.PI, ["0", "π/2", "π", "3π/2", "2π"][2 * i]]);

const charts = new Map();

/** Tells charts when they come into sight; those that are not are not painted. */
const sight = new IntersectionObserver(
  (entries) => {
    for (const { target, isIntersecting } of entries) {
      const chart = charts.get(target);
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
  /** A figure with its caption, its canvas and its legend; `about` says in words what is drawn. */
  constructor(title, { kind = "", about = "", role = "img" } = {}) {
    this.title = title;
    this.canvas = h("canvas", { role, "aria-label": about || title });
    this.key = h("ul", { class: "legend" });
    this.caption = h("span", {}, title);
    const kinds = ["svg", "png", "csv"].map((kind) => h("button", { type: "button", onclick: () => this.save(kind) }, kind.toUpperCase()));
    this.saving = h("details", { class: "menu save" }, h("summary", { "aria-label": `Save: ${title}`, title: "Save the picture, or its numbers" }, "⤓"), h("div", { class: "sheet" }, kinds));
    this.figure = h(
      "figure",
      { class: `chart ${kind}` },
      h("figcaption", {}, this.caption, this.saving),
      this.canvas,
      this.key,
    );
    this.spec = null;
    this.legend = "";
    this.drawn = 0;
    this.box = [0, 0]; // kept, for asking the canvas makes the browser lay the page out at once
    this.seen = false;
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.repaint();
    }).observe(this.canvas);
    sight.observe(this.canvas);
    charts.set(this.canvas, this);
  }

  /** Draw this: at once, or when the chart comes into sight. */
  draw(spec) {
    this.spec = spec;
    this.above = null;
    if (spec.about) this.canvas.setAttribute("aria-label", tr(spec.about));
    this.legends(spec.items);
    this.repaint();
  }

  /** Hand it over as a file: a picture with its legend, or its numbers. */
  async save(kind) {
    const { save } = await import("./export.js");
    this.saving.open = false;
    if (this.spec) await save(this, kind, { name: data.tables?.title ?? "" });
  }

  repaint() {
    const { canvas, spec } = this;
    const [width, height] = this.box;
    this.stale = !this.seen;
    if (!spec || !width || !height || this.stale) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 3);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d", { alpha: true });
    this.scale = theme().scale;
    pen.setTransform(ratio * this.scale, 0, 0, ratio * this.scale, 0, 0);
    pen.clearRect(0, 0, width / this.scale, height / this.scale);
    this.frame = layout(pen, spec, width / this.scale, height / this.scale);
    paint(pen, spec, this.frame);
    this.drawn += 1;
    canvas.dataset.drawn = String(this.drawn);
    this.still = null;
    if (this.above) this.over(...this.above);
  }

  /** Points drawn over the picture as it stands, many times a second. @param {any[]} points @param {number | null} [line] */
  over(points, line = null) {
    const { canvas, frame } = this;
    this.above = [points, line]; // for a later repaint of the same picture
    if (!frame || !this.box[0] || !this.seen) return;
    const pen = canvas.getContext("2d");
    if (!this.still) {
      this.still = document.createElement("canvas");
      this.still.width = canvas.width;
      this.still.height = canvas.height;
      this.still.getContext("2d").drawImage(canvas, 0, 0);
      this.covered = [];
    }
    this.uncover(pen);
    if (line !== null) {
      this.covered.push([frame.px(line) - 2, frame.top - 2, 4, frame.bottom - frame.top + 4]);
      pen.strokeStyle = theme().accent;
      pen.lineWidth = 1.5;
      pen.setLineDash([]);
      pen.beginPath();
      (pen.moveTo(frame.px(line), frame.top), pen.lineTo(frame.px(line), frame.bottom));
      pen.stroke();
    }
    for (const [x, y, colour] of points) {
      if (!Number.isFinite(y)) continue;
      mark(pen, "disc", frame.px(x), frame.py(y), 6, colour);
      this.covered.push([frame.px(x) - 9, frame.py(y) - 9, 18, 18]);
    }
  }

  /** The picture again where points had been drawn over it, and only there. */
  uncover(pen) {
    const ratio = (this.canvas.width / this.box[0]) * this.scale;
    pen.save();
    pen.setTransform(1, 0, 0, 1, 0, 0);
    for (const [x, y, width, height] of this.covered) {
      const from = [Math.max(Math.floor(x * ratio), 0), Math.max(Math.floor(y * ratio), 0)];
      const size = [
        Math.min(Math.ceil(width * ratio) + 1, this.still.width - from[0]),
        Math.min(Math.ceil(height * ratio) + 1, this.still.height - from[1]),
      ];
      if (size[0] <= 0 || size[1] <= 0) continue;
      pen.clearRect(...from, ...size);
      pen.drawImage(this.still, ...from, ...size, ...from, ...size);
    }
    pen.restore();
    this.covered = [];
  }

  /** The point of the plane under a pointer event; beside the plane null, unless the pointer may be `anywhere`. */
  at(event, anywhere = false) {
    if (!this.frame) return null;
    const box = this.canvas.getBoundingClientRect();
    const { left, right, top, bottom, toX, toY } = this.frame;
    const px = (event.clientX - box.left) / this.scale;
    const py = (event.clientY - box.top) / this.scale;
    const inside = px >= left - 8 && px <= right + 8 && py >= top - 8 && py <= bottom + 8;
    return inside || anywhere ? { x: toX(px), y: toY(py) } : null;
  }

  legends(items) {
    const named = keyed(items);
    const now = JSON.stringify(named.map((item) => [item.name, item.colour, item.hatch, item.shape, item.dash, theme().dark]));
    if (now === this.legend) return;
    this.legend = now;
    put(
      this.key,
      named.map((item) => h("li", {}, swatch(item), item.name)),
    );
  }
}

/** The items that a legend tells: the first of each name. */
export const keyed = (items) => items.filter(({ name }, i) => name && items.findIndex((item) => item.name === name) === i);

/** The least and the greatest of some lists, with a margin; a flat one gets room. */
export function span(lists, margin = 0.08) {
  let low = Infinity;
  let high = -Infinity;
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
