// A chart in a large window that can be zoomed, read point by point and saved as a picture. Plotly is served from the
// installed Python package and loaded only when it is asked for.

import { $, h, put } from "../core/dom.js";
import { hatched } from "./hatch.js";

let loading = null;

function plotly() {
  loading ??= new Promise((done, failed) => {
    const script = h("script", { src: "/static/plotly.min.js" });
    script.addEventListener("load", () => done(window.Plotly));
    script.addEventListener("error", () => {
      loading = null;
      failed(new Error("The charting library did not load: pip install plotly, then start the server again."));
    });
    document.head.append(script);
  });
  return loading;
}

export async function enlarge(chart) {
  const dialog = $("#zoom");
  const place = h("div", { class: "picture" }, "Loading …");
  const close = h("button", { type: "button", onclick: () => dialog.close() }, "Close");
  put(dialog, h("div", { class: "row middle" }, h("h2", { class: "grow" }, chart.title), close), place);
  dialog.showModal();
  try {
    const Plotly = await plotly();
    put(place);
    await Plotly.newPlot(place, traces(chart.spec), layout(chart.spec), { responsive: true, displaylogo: false });
    dialog.addEventListener("close", () => Plotly.purge(place), { once: true });
  } catch (error) {
    put(place, h("p", { class: "problem", role: "alert" }, error.message));
  }
}

const SYMBOLS = { disc: "circle", dot: "circle", ring: "circle-open", cross: "x-thin-open", plus: "cross-thin-open", diamond: "diamond" };

function traces(spec) {
  const found = [];
  for (const item of spec.items) {
    const about = { name: item.name ?? "", showlegend: Boolean(item.name) };
    if (item.type === "line") {
      const line = { color: item.colour, width: item.width ?? 2, dash: item.dash?.length ? "dash" : "solid" };
      found.push({ ...about, type: "scatter", mode: "lines", x: [...item.x], y: [...item.y], line });
    } else if (item.type === "points") {
      const marker = {
        color: item.colours ?? item.colour,
        symbol: SYMBOLS[item.shape] ?? "circle",
        size: 2 * (item.size ?? 6),
      };
      found.push({ ...about, type: "scatter", mode: "markers", x: [...item.x], y: [...item.y], marker });
    }
  }
  return found;
}

function layout(spec) {
  const shapes = spec.items.flatMap((item) => {
    if (item.type === "band")
      return [
        {
          type: "rect",
          xref: "paper",
          x0: 0,
          x1: 1,
          y0: item.from,
          y1: item.to,
          fillcolor: item.colour,
          opacity: 0.2,
          line: { width: 0 },
        },
      ];
    if (item.type === "circle")
      return [
        {
          type: "circle",
          x0: -item.radius,
          x1: item.radius,
          y0: -item.radius,
          y1: item.radius,
          line: { color: "#666666" },
        },
      ];
    if (item.type !== "level") return [];
    const line = { color: item.colour, width: 1.5, dash: "dash" };
    return item.axis === "x"
      ? [{ type: "line", yref: "paper", y0: 0, y1: 1, x0: item.at, x1: item.at, line }]
      : [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: item.at, y1: item.at, line }];
  });
  const axis = ({ label, from, to, ticks }) => ({
    title: { text: label },
    range: [from, to],
    automargin: true,
    ...(ticks ? { tickvals: ticks.map(([value]) => value), ticktext: ticks.map(([, text]) => text) } : {}),
  });
  const images = spec.image ? [plane(spec)] : [];
  const yaxis = spec.equal ? { ...axis(spec.y), scaleanchor: "x" } : axis(spec.y);
  const legend = { orientation: "h", x: 0, y: -0.14, yanchor: "top" }; // below, as on the page: a phone has no room beside
  const margin = { t: 36, r: 20, l: 20, b: 20 };
  return { xaxis: axis(spec.x), yaxis, shapes, images, legend, margin, template: "none", font: { size: 15 } };
}

/** The image of a map; its outermost cells reach half a cell beyond the axes. */
function plane({ image, x, y }) {
  const { width, height } = image.canvas;
  const step = [(x.to - x.from) / Math.max(width - 1, 1), (y.to - y.from) / Math.max(height - 1, 1)];
  const place = { x: x.from - step[0] / 2, y: y.to + step[1] / 2, sizex: step[0] * width, sizey: step[1] * height };
  return { source: upright(image), xref: "x", yref: "y", ...place, sizing: "stretch", layer: "below" };
}

/** The image with its first row at the top and its hatches, as a data address. */
function upright(image) {
  const { width: nx, height: ny } = image.canvas;
  const [width, height] = [1200, 800];
  const turned = document.createElement("canvas");
  turned.width = width;
  turned.height = height;
  const pen = turned.getContext("2d");
  pen.imageSmoothingEnabled = false;
  const place = (into, cells) => {
    into.translate(0, height);
    into.scale(1, -1);
    into.drawImage(cells, 0, 0, nx, ny, 0, 0, width, height);
  };
  pen.save();
  place(pen, image.canvas);
  pen.restore();
  if (image.hatches?.length) pen.drawImage(hatched({ ...image }, width, height, 1, place), 0, 0);
  return turned.toDataURL();
}
