// Hatches: what tells areas apart without their colours. The names are those of the server's palette.

const TILE = 8; // css pixels
const LINE = "rgb(255 255 255 / 85%)";

const STROKES = {
  "/": [[-2, 10, 10, -2], [-2, 2, 2, -2], [6, 10, 10, 6]],
  "\\": [[-2, -2, 10, 10], [6, -2, 10, 2], [-2, 6, 2, 10]],
  "-": [[0, 4, 8, 4]],
};
STROKES.x = [...STROKES["/"], ...STROKES["\\"]];

const tiles = new Map();

/** A tile of a hatch at so many pixels a css pixel. */
function tile(hatch, ratio) {
  const key = `${hatch} ${ratio}`;
  if (tiles.has(key)) return tiles.get(key);
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = Math.max(Math.round(TILE * ratio), 4);
  const pen = canvas.getContext("2d");
  pen.scale(canvas.width / TILE, canvas.height / TILE);
  pen.strokeStyle = pen.fillStyle = LINE;
  pen.lineWidth = 1;
  pen.beginPath();
  for (const [x, y, toX, toY] of STROKES[hatch] ?? []) (pen.moveTo(x, y), pen.lineTo(toX, toY));
  pen.stroke();
  if (hatch === ".") {
    pen.beginPath();
    pen.arc(TILE / 2, TILE / 2, 1.1, 0, 2 * Math.PI);
    pen.fill();
  }
  tiles.set(key, canvas);
  return canvas;
}

/** Fill a rectangle of a pen, whose unit is a css pixel, with a hatch. */
export function fillHatch(pen, hatch, x, y, width, height, ratio = 1) {
  if (!hatch) return;
  const pattern = pen.createPattern(tile(hatch, ratio), "repeat");
  const made = tile(hatch, ratio).width / TILE;
  pattern.setTransform(new DOMMatrix().scale(1 / made));
  pen.fillStyle = pattern;
  pen.fillRect(x, y, width, height);
}

const layers = new WeakMap();

/** The hatches of an image of cells, `width` by `height` css pixels large; made anew only when that is another size. */
export function hatched(image, width, height, ratio, place) {
  const key = [width, height, ratio].join();
  const kept = layers.get(image.canvas);
  if (kept?.key === key) return kept.canvas;
  const layer = blank(width, height, ratio);
  for (const { hatch, canvas } of image.hatches) {
    const one = blank(width, height, ratio);
    const pen = one.getContext("2d");
    pen.scale(ratio, ratio);
    pen.imageSmoothingEnabled = false;
    pen.save();
    place(pen, canvas);
    pen.restore();
    pen.globalCompositeOperation = "source-in";
    fillHatch(pen, hatch, 0, 0, width, height, ratio);
    layer.getContext("2d").drawImage(one, 0, 0);
  }
  layers.set(image.canvas, { key, canvas: layer });
  return layer;
}

function blank(width, height, ratio) {
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(Math.round(width * ratio), 1);
  canvas.height = Math.max(Math.round(height * ratio), 1);
  return canvas;
}
