import { Chart } from "/static/pictures/chart.js";
import { usePalette } from "/static/pictures/colours.js";
import { csv, png, save, svg } from "/static/pictures/export.js";

/** @typedef {typeof import("./checks.js")} Checks */
/** @typedef {import("/static/pictures/export.js").Spec} Spec */

usePalette((await (await fetch("/api/about")).json()).palette);

const ABOUT = { name: "Drifter <7> & Co", date: "2026-11-27" };

/** A canvas of cells, as maps have them. @param {string} colour */
function cells(colour) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 4;
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  pen.fillStyle = colour;
  pen.fillRect(0, 0, 2, 4);
  return canvas;
}

/** A chart with everything that a chart may hold. @returns {{ title: string, spec: Spec }} */
function everything() {
  const t = Array.from({ length: 101 }, (_, i) => i / 30);
  const y = t.map((one, i) => (i === 50 ? null : Math.sin(one) / 3));
  const points = { type: "points", x: [0.1, 1 / 3, 2], y: [0.1, -0.2, 0.3], colour: "#aa0000" };
  const shapes = ["disc", "dot", "ring", "cross", "plus", "diamond", "square", "triangle"];
  return {
    title: 'Displacement, "a" & <b>',
    spec: {
      x: { label: "time [ms]", from: 0, to: 4 },
      y: { label: "displacement [mm], down", from: -0.5, to: 0.5 },
      image: { canvas: cells("#336699"), hatches: [{ hatch: "/", canvas: cells("#ffffff") }], smooth: false },
      items: [
        { type: "line", name: "striking end", x: t, y, colour: "#0055aa" },
        { type: "line", name: "wall", x: [0, 4], y: [0, 0], colour: "#888888", dash: [6, 4] },
        ...shapes.map((shape) => ({ ...points, shape, name: `impacts, ${shape}`, size: 5 })),
        { type: "band", name: "measured", from: -0.1, to: 0.1, colour: "#008800" },
        { type: "level", name: "design", at: 1.5, axis: "x", colour: "#000000" },
        { type: "circle", name: "unit circle", radius: 0.3 },
        { type: "patch", name: "stable", colour: "#223344", hatch: "x" },
        { type: "label", x: 1, y: 0.2, text: "a > b" },
      ],
    },
  };
}

/** @param {string} text */
function parsed(text) {
  const found = new DOMParser().parseFromString(text, "image/svg+xml");
  if (found.querySelector("parsererror")) throw new Error(String(found.documentElement.textContent));
  return found;
}

/** @param {Checks} t */
export function an_svg_names_all_that_it_shows(t) {
  const chart = everything();
  const found = parsed(svg(chart, ABOUT));
  const texts = [...found.querySelectorAll("text")].map((one) => one.textContent);
  const names = chart.spec.items.map((item) => item.name ?? item.text);
  for (const name of [chart.title, "Drifter <7> & Co · 2026-11-27", chart.spec.x.label, chart.spec.y.label, ...names])
    t.equal(texts.filter((text) => text === name).length, 1, String(name));
  t.ok(!/NaN|undefined|Infinity/.test(found.documentElement.outerHTML), "numbers only");
}

/** @param {Checks} t */
export function an_svg_has_every_point(t) {
  const { title, spec } = everything();
  const count = (/** @type {Spec["items"]} */ items) => {
    const paths = [...parsed(svg({ title, spec: { ...spec, items } })).querySelectorAll("path")].map(
      (path) => path.getAttribute("d") ?? "",
    );
    return { paths: paths.length, steps: paths.join("").match(/[ML]/g)?.length ?? 0 };
  };
  const empty = count([]);
  const [line, , disc] = spec.items.map((item) => ({ ...item, name: "" }));
  t.equal(count([line]).steps - empty.steps, 100, "101 places, one of them a gap");
  t.equal(count([disc]).paths - empty.paths, 2 * 3, "area and edge of three discs");
}

/** The places of an SVG are those of the plane. @param {Checks} t */
export function a_line_of_an_svg_lies_where_its_numbers_say(t) {
  const spec = {
    x: { label: "x", from: 0, to: 10 },
    y: { label: "y", from: 0, to: 1 },
    items: [{ type: "line", x: [0, 5, 10], y: [0, 0.5, 1], colour: "#123456" }],
  };
  const d =
    parsed(svg({ title: "t", spec }))
      .querySelector('path[stroke="#123456"]')
      ?.getAttribute("d") ?? "";
  const [a, b, c] = d
    .split(/[ML]/)
    .slice(1)
    .map((pair) => pair.split(" ").map(Number));
  t.close(b[0], (a[0] + c[0]) / 2, 1e-4);
  t.close(b[1], (a[1] + c[1]) / 2, 1e-4);
  t.ok(c[0] > a[0] && c[1] < a[1], "right and up");
}

/** The one painter by both pens: the SVG, drawn by the browser, is the PNG but for the edges of strokes.
 * @param {Checks} t */
export async function an_svg_looks_like_the_png(t) {
  const chart = everything();
  const [a, b] = await Promise.all([
    pixels(new Blob([svg(chart, ABOUT)], { type: "image/svg+xml" })),
    pixels(await png(chart, ABOUT)),
  ]);
  let off = 0;
  for (let i = 0; i < a.length; i += 4)
    if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 90) off++;
  t.ok(off < 1000, `${off} of ${a.length / 4} pixels differ`);
}

/** @param {Blob} blob */
async function pixels(blob) {
  const image = new Image();
  image.src = URL.createObjectURL(blob);
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [1920, 1200];
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { willReadFrequently: true }));
  pen.drawImage(image, 0, 0, 1920, 1200);
  return pen.getImageData(0, 0, 1920, 1200).data;
}

/** @param {Checks} t */
export async function a_png_has_its_size_and_is_not_blank(t) {
  const blob = await png(everything(), { ...ABOUT, width: 700, height: 500 });
  const image = await createImageBitmap(blob);
  t.equal([blob.type, image.width, image.height], ["image/png", 1400, 1000]);
  t.ok(new Set(new Uint32Array((await pixels(blob)).buffer)).size > 100, "colours");
}

/** @param {Checks} t */
export function numbers_of_a_csv_are_those_of_the_chart(t) {
  const { spec } = everything();
  const [head, ...rows] = csv(spec).trimEnd().split("\r\n");
  t.ok(head.startsWith('striking end: time [ms],"striking end: displacement [mm], down",wall: time [ms],'), head);
  const cells = rows.map((row) => row.split(","));
  t.equal(rows.length, 101);
  const found = (/** @type {number} */ column) =>
    cells.map((row) => row[column]).map((text) => (text === "" ? null : Number(text)));
  const [line, , disc] = spec.items;
  t.equal(found(0), line.x);
  t.equal(found(1), line.y);
  t.equal(found(4).slice(0, 3), disc.x);
  t.ok(
    found(5)
      .slice(3)
      .every((value) => value === null),
    "what is shorter ends",
  );
  t.equal(csv({ ...spec, items: [] }), "");
}

/** @param {Checks} t */
export async function a_chart_is_saved_under_the_names_of_its_case_and_itself(t) {
  const [names, chart] = [/** @type {string[]} */ ([]), new Chart("Force over time")];
  chart.draw(everything().spec);
  const click = HTMLAnchorElement.prototype.click;
  HTMLAnchorElement.prototype.click = function () {
    names.push(this.download);
  };
  try {
    for (const kind of /** @type {const} */ (["svg", "png", "csv"])) await save(chart, kind, { name: "Überhammer 7" });
  } finally {
    HTMLAnchorElement.prototype.click = click;
  }
  t.equal(
    names,
    ["svg", "png", "csv"].map((kind) => `uberhammer-7-force-over-time.${kind}`),
  );
}
