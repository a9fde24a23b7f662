// A pen with the methods of a canvas that chart_pen.js and hatch.js draw with, whose strokes become elements of an SVG:
// one painter for both. Pictures, and areas filled with a pattern, are embedded as PNG.

import { ownCanvas } from "./pen.js";

const NS = "http://www.w3.org/2000/svg";
const PIXELS = 2; // of an embedded picture per unit of length

/** @typedef {Record<string, string | number | undefined>} Attributes */

/** @param {string} tag @param {Attributes} attributes */
function element(tag, attributes) {
  const found = /** @type {SVGElement} */ (document.createElementNS(NS, tag));
  for (const [name, value] of Object.entries(attributes))
    if (value !== undefined) found.setAttribute(name, String(value));
  return found;
}

/** Short, and finer than any screen. @param {number} value */
const short = (value) => Number(value.toFixed(3));

export class SvgPen {
  /** @param {number} width @param {number} height */
  constructor(width, height) {
    const box = { xmlns: NS, width, height, viewBox: `0 0 ${width} ${height}` };
    this.root = element("svg", { ...box, "stroke-miterlimit": 10 });
    this.real = ownCanvas(1, 1).pen;
    this.path = "";
    this.clips = 0;
    /** What `save` keeps: all that stands below. @type {Partial<SvgPen>[]} */
    this.kept = [];
    this.into = this.root;
    this.matrix = new DOMMatrix();
    this.globalAlpha = 1;
    /** @type {string | CanvasPattern} */
    this.fillStyle = "#000";
    this.strokeStyle = "#000";
    this.lineWidth = 1;
    this.lineJoin = "miter";
    /** @type {number[]} */
    this.dash = [];
    this.font = "10px sans-serif";
    this.textAlign = "start";
    /** @type {CanvasTextBaseline} */
    this.textBaseline = "alphabetic";
    this.imageSmoothingEnabled = true;
  }

  toString() {
    return new XMLSerializer().serializeToString(this.root);
  }

  // ---- State

  save() {
    const { root, real, path, clips, kept, ...state } = this;
    kept.push({ ...state, matrix: DOMMatrix.fromMatrix(this.matrix) });
  }

  restore() {
    Object.assign(this, this.kept.pop());
  }

  /** @param {number} x @param {number} y */
  translate(x, y) {
    this.matrix.translateSelf(x, y);
  }

  /** @param {number} angle in radians */
  rotate(angle) {
    this.matrix.rotateSelf((angle * 180) / Math.PI);
  }

  /** @param {number} x @param {number} y */
  scale(x, y) {
    this.matrix.scaleSelf(x, y);
  }

  /** From units to the pixels that embedded pictures should have. */
  getTransform() {
    return new DOMMatrix().scale(PIXELS).multiply(this.matrix);
  }

  /** @param {number[]} dash */
  setLineDash(dash) {
    this.dash = dash;
  }

  // ---- Paths, in the units of the transform that holds when they are drawn

  beginPath() {
    this.path = "";
  }

  closePath() {
    this.path += "Z";
  }

  /** @param {number} x @param {number} y */
  moveTo(x, y) {
    this.path += `M${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y */
  lineTo(x, y) {
    this.path += `${this.path ? "L" : "M"}${short(x)} ${short(y)}`;
  }

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  rect(x, y, width, height) {
    this.path += `M${short(x)} ${short(y)}h${short(width)}v${short(height)}h${short(-width)}Z`;
  }

  /** @param {number} x @param {number} y @param {number} radius @param {number} from @param {number} to */
  arc(x, y, radius, from, to) {
    this.ellipse(x, y, radius, radius, 0, from, to);
  }

  /** Clockwise on the screen, as angles grow; in two halves, for an arc of SVG cannot be a whole turn.
   * @param {number} x @param {number} y @param {number} rx @param {number} ry @param {number} turned
   * @param {number} from @param {number} to */
  ellipse(x, y, rx, ry, turned, from, to) {
    const at = (/** @type {number} */ angle) => {
      const [a, b] = [rx * Math.cos(angle), ry * Math.sin(angle)];
      const [cos, sin] = [Math.cos(turned), Math.sin(turned)];
      return `${short(x + a * cos - b * sin)} ${short(y + a * sin + b * cos)}`;
    };
    const radii = `A${short(rx)} ${short(ry)} ${short((turned * 180) / Math.PI)} 0 1`;
    const whole = Math.abs(to - from) >= 2 * Math.PI - 1e-9;
    this.path += `${this.path && !this.path.endsWith("Z") ? "L" : "M"}${at(from)}`;
    this.path += `${radii} ${at((from + to) / 2)}${radii} ${at(to)}${whole ? "Z" : ""}`;
  }

  stroke() {
    if (!this.path) return;
    const { strokeStyle, lineWidth, lineJoin, dash } = this;
    const line = { stroke: strokeStyle, "stroke-width": lineWidth, "stroke-linejoin": lineJoin };
    this.add("path", { d: this.path, fill: "none", ...line, "stroke-dasharray": dash.join(" ") || undefined });
  }

  fill() {
    if (this.path && typeof this.fillStyle === "string") this.add("path", { d: this.path, fill: this.fillStyle });
  }

  /** What is drawn until the next `restore` is seen only within the path. */
  clip() {
    const id = `clip-${++this.clips}`;
    const clip = element("clipPath", { id });
    clip.append(element("path", { d: this.path, ...this.placed() }));
    const group = element("g", { "clip-path": `url(#${id})` });
    this.into.append(clip, group);
    this.into = group;
  }

  // ---- Areas, pictures, text

  /** @param {number} x @param {number} y @param {number} width @param {number} height */
  fillRect(x, y, width, height) {
    const [left, top] = [Math.min(x, x + width), Math.min(y, y + height)];
    const [across, down] = [Math.abs(width), Math.abs(height)];
    const place = { x: short(left), y: short(top), width: short(across), height: short(down) };
    if (typeof this.fillStyle === "string") return this.add("rect", { ...place, fill: this.fillStyle });
    const { canvas, pen } = ownCanvas(Math.ceil(across * PIXELS) / PIXELS, Math.ceil(down * PIXELS) / PIXELS, PIXELS);
    pen.translate(-left, -top);
    pen.fillStyle = this.fillStyle;
    pen.fillRect(left, top, across, down);
    this.drawImage(canvas, left, top, across, down);
  }

  /** @param {CanvasImageSource} tile @param {string} repeat */
  createPattern(tile, repeat) {
    return this.real.createPattern(tile, repeat);
  }

  /** @param {HTMLCanvasElement} canvas @param {number} x @param {number} y @param {number} [width] @param {number} [height] */
  drawImage(canvas, x, y, width = canvas.width, height = canvas.height) {
    const place = { x: short(x), y: short(y), width: short(width), height: short(height) };
    const enlarged = Math.abs(width) > canvas.width; // cells keep their edges; what has pixels enough is left to the reader
    const sharp = enlarged && !this.imageSmoothingEnabled ? "pixelated" : undefined;
    const looks = { preserveAspectRatio: "none", "image-rendering": sharp };
    this.add("image", { href: canvas.toDataURL("image/png"), ...place, ...looks });
  }

  /** @param {string} text */
  measureText(text) {
    this.real.font = this.font;
    this.real.textBaseline = this.textBaseline;
    return this.real.measureText(text);
  }

  /** @param {string} text @param {number} x @param {number} y */
  fillText(text, x, y) {
    const high = this.measureText(text).fontBoundingBoxAscent;
    this.real.textBaseline = "alphabetic"; // readers of SVG differ in all other baselines
    const down = this.real.measureText(text).fontBoundingBoxAscent - high;
    const font = /^(?:(bold|\d+) )?([\d.]+)px (.+)$/.exec(this.font) ?? [];
    const anchor = { center: "middle", right: "end", end: "end" }[this.textAlign] ?? "start";
    const looks = { "font-weight": font[1], "font-size": font[2], "font-family": font[3] };
    const place = { x: short(x), y: short(y + down), "text-anchor": anchor };
    this.add("text", { ...place, ...looks, fill: String(this.fillStyle) }).textContent = text;
  }

  // ---- Elements

  /** @param {string} tag @param {Attributes} attributes */
  add(tag, attributes) {
    const opacity = this.globalAlpha === 1 ? undefined : this.globalAlpha;
    const found = element(tag, { ...attributes, opacity, ...this.placed() });
    this.into.append(found);
    return found;
  }

  /** @returns {Record<string, string>} */
  placed() {
    const { a, b, c, d, e, f, isIdentity } = this.matrix;
    return isIdentity
      ? {}
      : { transform: `matrix(${[a, b, c, d, e, f].map((one) => Number(one.toPrecision(9))).join(" ")})` };
  }
}
