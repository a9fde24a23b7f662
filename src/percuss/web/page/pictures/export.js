// A chart as a file: a picture with its title, its legend, the name of the case and the date, or the numbers it shows.

import { download } from "../core/dom.js";
import { keyed } from "./chart.js";
import { layout, paint, sample } from "./chart_pen.js";
import { theme } from "./colours.js";
import { FONT, ownCanvas } from "./pen.js";
import { SvgPen } from "./svg_pen.js";
import { tr } from "../core/words.js";

/** @typedef {import("./chart_pen.js").Item} Item */
/** @typedef {import("./chart_pen.js").Spec} Spec */
/** @typedef {{ title: string, spec: Spec | null }} Chart */
/** What is said of a picture beside its title: the name of its case, the date.
 * @typedef {{ name?: string, date?: string, width?: number, height?: number }} About */

const EDGE = 16;
const ROW = 20;
const DENSITY = 2; // pixels of a PNG per unit of length

const today = () => new Date().toLocaleDateString("sv"); // as ISO 8601 has it, where the reader is

/** The rows of the legend, each item with the place of its sample.
 * @param {any} pen @param {Spec} spec @param {number} width */
function rowsOf(pen, spec, width) {
  pen.font = FONT;
  let [x, row] = [EDGE, 0];
  const places = keyed(spec.items).map((item) => {
    const needed = 34 + pen.measureText(tr(item.name ?? "")).width + 18;
    if (x > EDGE && x + needed > width - EDGE) [x, row] = [EDGE, row + 1];
    const place = { item, x, row };
    x += needed;
    return place;
  });
  return { places, count: places.length ? row + 1 : 0 };
}

/** The whole picture by a pen of a canvas, or one that makes an SVG.
 * @param {any} pen @param {Chart & { spec: Spec }} chart @param {Required<About>} about */
function compose(pen, { title, spec }, { name, date, width, height }) {
  const colours = theme();
  pen.fillStyle = colours.surface;
  pen.fillRect(0, 0, width, height);
  const legend = rowsOf(pen, spec, width);
  pen.fillStyle = colours.ink;
  pen.font = "600 16px system-ui, sans-serif";
  pen.fillText(tr(title), EDGE, 28);
  pen.font = FONT;
  pen.fillStyle = colours.muted;
  pen.fillText(tr([name, date].filter(Boolean).join(" · ")), EDGE, 48);
  const [top, bottom] = [60, height - EDGE - ROW * legend.count];
  pen.save();
  pen.translate(0, top);
  paint(pen, spec, layout(pen, spec, width - EDGE, bottom - top));
  pen.restore();
  for (const { item, x, row } of legend.places) {
    const y = bottom + ROW * row + 6;
    pen.save();
    pen.translate(x, y - 1);
    sample(pen, item);
    pen.restore();
    pen.font = FONT;
    pen.fillStyle = colours.ink;
    pen.textAlign = "left";
    pen.fillText(tr(item.name ?? ""), x + 34, y + 10);
  }
}

/** @param {Chart} chart @param {About} about @returns {[Chart & { spec: Spec }, Required<About>]} */
function complete(chart, { name = "", date = today(), width = 960, height = chart.spec?.equal ? 960 : 600 }) {
  const { title, spec } = chart;
  if (!spec) throw new Error(`${title}: nothing is drawn yet`);
  return [
    { title, spec },
    { name, date, width, height },
  ];
}

/** The chart as the text of an SVG. @param {Chart} chart @param {About} [about] */
export function svg(chart, about = {}) {
  const [drawn, whole] = complete(chart, about);
  const pen = new SvgPen(whole.width, whole.height);
  compose(pen, drawn, whole);
  return String(pen);
}

/** The chart as a PNG, twice as many pixels as its width and height.
 * @param {Chart} chart @param {About} [about] @returns {Promise<Blob>} */
export function png(chart, about = {}) {
  const [drawn, whole] = complete(chart, about);
  const { canvas, pen } = ownCanvas(whole.width, whole.height, DENSITY);
  compose(pen, drawn, whole);
  return new Promise((done, failed) =>
    canvas.toBlob((blob) => (blob ? done(blob) : failed(new Error("the browser made no picture"))), "image/png"),
  );
}

/** The lines and points of a chart as CSV: two columns of each, named and with the units of the axes; a gap is empty.
 * @param {Spec} spec */
export function csv({ x, y, items }) {
  const shown = items.filter(({ type }) => type === "line" || type === "points");
  const columns = shown.flatMap((item, i) => {
    const name = item.name || `${item.type} ${i + 1}`;
    return [
      [[name, x.label].filter(Boolean).join(": "), ...item.x],
      [[name, y.label].filter(Boolean).join(": "), ...item.y],
    ];
  });
  const cell = (/** @type {unknown} */ value) => {
    const text = value === undefined || value === null || Number.isNaN(value) ? "" : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const count = Math.max(0, ...columns.map(({ length }) => length));
  return Array.from({ length: count }, (_, i) => `${columns.map((column) => cell(column[i])).join(",")}\r\n`).join("");
}

/** Hand a chart to the user as a file, named by its case and its title.
 * @param {Chart} chart @param {"svg" | "png" | "csv"} kind @param {About} [about] */
export async function save(chart, kind, about = {}) {
  const [{ title, spec }] = complete(chart, about);
  const words = [about.name, title].filter(Boolean).join(" ").normalize("NFKD").replace(/\p{M}/gu, "");
  const name = words
    .toLowerCase()
    .replace(/[^\p{L}\p{N}]+/gu, "-")
    .replace(/^-|-$/g, "");
  if (kind === "png") return download(await png(chart, about), `${name}.png`);
  const [text, type] = kind === "csv" ? [csv(spec), "text/csv"] : [svg(chart, about), "image/svg+xml"];
  download(new Blob([text], { type }), `${name}.${kind}`);
}
