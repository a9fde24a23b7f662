// Striker, tool and rock with the waves in them: the colour and the curve below are the stress, on the scale that is told.

import { signed, theme } from "./colours.js";
import { put } from "./dom.js";
import { number, si } from "./format.js";

const MARGIN = 16;
const APART = 7; // pixels between the faces while they are apart
const END = 54; // pixels for what is at the far end

export class BlowStage {
  /** On a canvas; `note` says how it is drawn. */
  constructor(canvas, note) {
    this.canvas = canvas;
    this.note = note;
    this.blow = null;
    this.frame = 0;
    this.box = [0, 0];
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(canvas);
  }

  show(blow) {
    this.blow = blow;
    const { arrays } = blow;
    this.most = 0;
    for (const values of [arrays.striker_stress, arrays.rod_stress ?? []])
      for (const value of values) this.most = Math.max(this.most, Math.abs(value));
    const bodies = blow.rod ? [blow.striker, blow.rod] : [blow.striker];
    [this.own, this.rod = []] = thicknesses(bodies);
  }

  draw() {
    const { canvas, blow } = this;
    const [width, height] = this.box;
    if (!blow || !width || !height) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const pen = canvas.getContext("2d");
    const { scale } = theme();
    pen.setTransform(ratio * scale, 0, 0, ratio * scale, 0, 0);
    pen.clearRect(0, 0, width / scale, height / scale);
    this.paint(pen, width / scale, height / scale);
    put(this.note, this.magnified(width / scale, height / scale));
  }

  /** Pixels of a length and of a thickness: both are to scale, the thickness on a larger one where bars are slender. */
  scales(width, height) {
    const { striker, rod } = this.blow;
    const long = sum(striker.lengths) + (rod ? sum(rod.lengths) : 0);
    const along = (width - 2 * MARGIN - APART - END) / long;
    const thick = Math.max(...this.own, ...this.rod);
    const across = Math.min((0.36 * height) / thick, Math.max(along, (0.26 * height) / thick));
    return { along, across };
  }

  paint(pen, width, height) {
    const colours = theme();
    const { blow, frame } = this;
    const { along, across } = this.scales(width, height);
    const mid = height * 0.27;
    const face = MARGIN + sum(blow.striker.lengths) * along;
    const apart = blow.arrays.touching[frame] === 0;
    const struck = face + APART;
    const own = apart ? 0 : APART; // while they touch no gap is between the faces
    const base = height * 0.68;
    const tall = height * 0.16;
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    pen.beginPath();
    (pen.moveTo(MARGIN, base), pen.lineTo(width - MARGIN, base));
    pen.stroke();
    const place = { mid, along, across, base, tall };
    this.body(pen, "striker", blow.striker, this.own, MARGIN + own, place, colours);
    let end = struck;
    if (blow.rod) end = this.body(pen, "rod", blow.rod, this.rod, struck, place, colours);
    this.far(pen, end, mid, height, colours);
    this.words(pen, width, height, colours, { apart, face, mid });
  }

  /** The cells of a body in their colours, its outline, and its stress as a curve; where it ends. */
  body(pen, name, { lengths }, thick, left, { mid, along, across, base, tall }, colours) {
    const edges = this.blow.arrays[`${name}_edges`];
    const stress = this.blow.arrays[`${name}_stress`];
    const count = edges.length - 1;
    const first = this.frame * count;
    const most = this.most || 1;
    let section = 0;
    let until = lengths[0];
    for (let j = 0; j < count; j++) {
      while (section < lengths.length - 1 && edges[j] > until - 1e-6 * until) until += lengths[++section];
      const tallness = thick[section] * across;
      pen.fillStyle = signed(stress[first + j] / most);
      const from = Math.floor(left + edges[j] * along); // whole pixels: else neighbours show through each other
      pen.fillRect(from, mid - tallness / 2, Math.ceil(left + edges[j + 1] * along) - from, tallness);
    }
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.2;
    let x = left;
    lengths.forEach((length, i) => {
      const tallness = thick[i] * across;
      pen.strokeRect(x, mid - tallness / 2, length * along, tallness);
      x += length * along;
    });
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 1.8;
    pen.beginPath();
    for (let j = 0; j < count; j++) {
      const y = base - (stress[first + j] / most) * tall;
      (pen.lineTo(left + edges[j] * along, y), pen.lineTo(left + edges[j + 1] * along, y));
    }
    pen.stroke();
    return x;
  }

  /** What is at the far end: a wall, rock, a support, nothing, or the rest of an endless rod. */
  far(pen, x, mid, height, colours) {
    const end = this.blow.rod ? this.blow.rod.end : "wall";
    pen.font = "12.5px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.strokeStyle = pen.fillStyle = colours.muted;
    pen.lineWidth = 1.2;
    const half = height * 0.2;
    if (end === "infinite") {
      pen.beginPath();
      for (const k of [0, 1, 2]) (pen.moveTo(x + 6 + 8 * k, mid - 6), pen.lineTo(x + 12 + 8 * k, mid), pen.lineTo(x + 6 + 8 * k, mid + 6));
      pen.stroke();
    } else if (end !== "free") {
      pen.fillRect(x, mid - half, 3, 2 * half);
      pen.beginPath();
      for (let y = mid - half; y < mid + half - 8; y += 9) {
        if (end === "rock") (pen.moveTo(x + 5, y), pen.lineTo(x + 16, y + 4), pen.lineTo(x + 9, y + 9), pen.lineTo(x + 24, y + 9));
        else (pen.moveTo(x + 3, y), pen.lineTo(x + 18, y + 9));
      }
      pen.stroke();
    }
    const name = { infinite: "endless", free: "free", fixed: "fixed", rock: "rock", wall: "wall" }[end];
    pen.fillText(name, x + 4, mid + half + 14);
  }

  words(pen, width, height, colours, { apart, face, mid }) {
    pen.font = "12.5px system-ui, sans-serif";
    pen.fillStyle = colours.muted;
    pen.textAlign = face > 90 ? "right" : "left";
    pen.fillText(apart ? "apart" : "in contact", face > 90 ? face : MARGIN, mid + height * 0.2 + 14);
    pen.textAlign = "left";
    const sized = this.blow.units === "SI";
    const most = sized ? si(this.most, "Pa", 3) : number(this.most, 3);
    const y = height - 16;
    const [from, to] = [`compression −${most}`, `+${most} tension${sized ? "" : " (force)"}`];
    const [before, behind] = [from, to].map((text) => pen.measureText(text).width + 8);
    const left = MARGIN + before;
    const bar = Math.max(20, Math.min(120, width - left - behind - MARGIN));
    pen.fillText(from, MARGIN, y + 10);
    pen.fillText(to, left + bar + 8, y + 10);
    for (let i = 0; i < bar; i++) {
      pen.fillStyle = signed((2 * i) / bar - 1);
      pen.fillRect(left + i, y, 1.5, 10);
    }
  }

  /** How thickness is drawn beside length, in words. */
  magnified(width, height) {
    if (!this.blow.striker.areas) return "Thickness shows impedance; the sizes are not known.";
    const { along, across } = this.scales(width, height);
    const larger = across / along;
    return `Lengths to scale; thickness to scale${larger > 1.05 ? `, ×${number(larger, 2)} beside the lengths` : ""}, of round bars of the same area.`;
  }
}

const sum = (values) => values.reduce((total, value) => total + value, 0);

/** Of each body the diameters of round sections of these areas; without sizes the roots of the impedances, as shares of
 * the striker's length. */
const thicknesses = (bodies) => {
  const most = Math.max(...bodies.flatMap((body) => body.impedances));
  const thin = 0.15 * sum(bodies[0].lengths);
  return bodies.map(({ areas, impedances }) =>
    areas
      ? areas.map((area) => 2 * Math.sqrt(area / Math.PI))
      : impedances.map((own) => thin * Math.sqrt(own / most)),
  );
};
