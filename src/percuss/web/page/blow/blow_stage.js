// Striker, tool and rock with the waves in them: the colour and the curve below are the stress, on the scale that is told.
// What holds the tool is drawn, too: its feed, its joints and its bit.

import { signed, theme } from "../pictures/colours.js";
import { put } from "../core/dom.js";
import { number, si, withUnit } from "../core/format.js";
import { tr } from "../core/words.js";

const MARGIN = 16;
const APART = 7; // pixels between the faces while they are apart
const END = 54; // pixels for what is at the far end
const BIT = 9; // pixels of a bit that is known by its mass
const GAPS = { mass: 0, elastic: 16, contact: 6 }; // pixels between sections at a joint
const FEED_ROW = 14; // where the words above the tool stand
const JOINT_ROW = 29;

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
    const joints = blow.rod?.joints ?? [];
    this.jointAt = new Map(joints.map((joint) => [joint.at, joint]));
    this.room = sum(joints.map(({ kind }) => GAPS[kind])) + (blow.rod?.bit_mass ? BIT : 0);
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
    const along = (width - 2 * MARGIN - APART - END - this.room) / long;
    const thick = Math.max(...this.own, ...this.rod);
    const across = Math.min((0.32 * height) / thick, Math.max(along, (0.26 * height) / thick));
    return { along, across };
  }

  paint(pen, width, height) {
    const colours = theme();
    const { blow, frame } = this;
    const { along, across } = this.scales(width, height);
    const mid = height * 0.31;
    const face = MARGIN + sum(blow.striker.lengths) * along;
    const apart = blow.arrays.touching[frame] === 0;
    const struck = face + APART;
    const own = apart ? 0 : APART; // while they touch no gap is between the faces
    const base = height * 0.72;
    const tall = height * 0.16;
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    pen.beginPath();
    (pen.moveTo(MARGIN, base), pen.lineTo(width - MARGIN, base));
    pen.stroke();
    const place = { mid, along, across, base, tall };
    this.body(pen, "striker", blow.striker, this.own, MARGIN + own, place, colours);
    let end = struck;
    if (blow.rod) {
      end = this.body(pen, "rod", blow.rod, this.rod, struck, place, colours);
      end = this.held(pen, struck, end, place, width, colours);
    }
    this.far(pen, end, mid, height, width, colours);
    this.words(pen, width, height, colours, { apart, face, mid });
  }

  /** The cells of a body in their colours, its outline, and its stress as a curve; where it ends. */
  body(pen, name, { lengths }, thick, left, { mid, along, across, base, tall }, colours) {
    const edges = this.blow.arrays[`${name}_edges`];
    const stress = this.blow.arrays[`${name}_stress`];
    const count = edges.length - 1;
    const first = this.frame * count;
    const most = this.most || 1;
    const starts = this.starts(name, lengths, left, along);
    const cells = []; // of each the pixels from and to, and its section
    let section = 0;
    let before = 0; // length of the sections before it
    for (let j = 0; j < count; j++) {
      while (section < lengths.length - 1 && edges[j] > (before + lengths[section]) * (1 - 1e-6)) before += lengths[section++];
      const [from, to] = [edges[j], edges[j + 1]].map((edge) => starts[section] + (edge - before) * along);
      cells.push([from, to]);
      const tallness = thick[section] * across;
      pen.fillStyle = signed(stress[first + j] / most);
      const whole = Math.floor(from); // whole pixels: else neighbours show through each other
      pen.fillRect(whole, mid - tallness / 2, Math.ceil(to) - whole, tallness);
    }
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.2;
    lengths.forEach((length, i) => {
      const tallness = thick[i] * across;
      pen.strokeRect(starts[i], mid - tallness / 2, length * along, tallness);
    });
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 1.8;
    pen.beginPath();
    cells.forEach(([from, to], j) => {
      const y = base - (stress[first + j] / most) * tall;
      (pen.lineTo(from, y), pen.lineTo(to, y));
    });
    pen.stroke();
    return starts.at(-1) + lengths.at(-1) * along;
  }

  /** Where the sections of a body begin, with room for the joints of a rod that come apart. */
  starts(name, lengths, left, along) {
    let x = left;
    return lengths.map((length, i) => {
      if (name === "rod") x += GAPS[this.jointAt.get(i)?.kind] ?? 0;
      const start = x;
      x += length * along;
      return start;
    });
  }

  /** What holds the tool: joints, feed and bit, each with its size in words; where the bit ends. */
  held(pen, struck, end, { mid, along, across }, width, colours) {
    const { rod } = this.blow;
    const starts = this.starts("rod", rod.lengths, struck, along);
    pen.font = "12.5px system-ui, sans-serif";
    let taken = 0; // up to where words stand in the row of the joints
    for (const joint of this.jointAt.values()) {
      const x = starts[joint.at];
      const [one, other] = [joint.at - 1, joint.at].map((i) => (this.rod[i] * across) / 2);
      this.joint(pen, joint, x, mid, one, other, colours);
      pen.fillStyle = colours.muted;
      taken = beside(pen, x, JOINT_ROW, jointWords(joint), taken, width - MARGIN);
    }
    const [row, top] = [FEED_ROW - 4, mid - ((this.rod[rod.feed?.at ?? 0] ?? 0) * across) / 2];
    const node = starts[rod.feed?.at ?? 0];
    if (rod.feed) {
      this.feed(pen, rod.feed, node, row, top, colours);
      const { force, damping, stiffness } = rod.feed;
      const more = [damping && `dashpot ${si(damping, "N·s/m", 3)}`, stiffness && `spring ${si(stiffness, "N/m", 3)}`];
      const words = `feed ${si(force, "N", 3)}`;
      pen.fillStyle = colours.muted;
      beside(pen, node, FEED_ROW, [[words, ...more.filter(Boolean)].join(", "), words], 0, width - MARGIN);
    } else if (rod.end === "rock" || rod.end === "fixed") {
      pen.fillStyle = colours.muted;
      beside(pen, node, FEED_ROW, ["no feed"], 0, width - MARGIN);
    }
    if (!rod.bit_mass) return end;
    const half = (this.rod.at(-1) * across) / 2 + 4;
    pen.fillStyle = colours.muted;
    pen.fillRect(end, mid - half, BIT, 2 * half);
    return end + BIT;
  }

  /** A joint that ends at `x`, between sections of such half thicknesses: a sleeve, a spring, or two faces. */
  joint(pen, { kind, opens = [], closes = [] }, x, mid, one, other, colours) {
    pen.strokeStyle = pen.fillStyle = colours.ink;
    pen.lineWidth = 1.2;
    const from = x - GAPS[kind];
    const least = Math.min(one, other);
    if (kind === "mass") {
      const half = Math.max(one, other);
      for (const y of [mid - half - 5, mid + half]) pen.fillRect(x - 8, y, 16, 5);
    } else if (kind === "elastic") {
      const high = Math.min(0.5 * least, 9);
      pen.beginPath();
      pen.moveTo(from, mid);
      for (const k of [1, 2, 3, 4, 5]) pen.lineTo(from + (k * GAPS.elastic) / 6, mid + (k % 2 ? high : -high));
      pen.lineTo(x, mid);
      pen.stroke();
    } else {
      const now = this.blow.arrays.t[this.frame];
      const past = (times) => times.filter((time) => time <= now).length;
      if (past(opens) <= past(closes)) pen.fillRect(from, mid - least, GAPS.contact, 2 * least); // shut
      else for (const [at, half] of [[from - 1, one], [x - 1, other]]) pen.fillRect(at, mid - half, 2, 2 * half);
    }
  }

  /** The feed: an arrow toward the rock at its node, with a dashpot behind it where it has one. */
  feed(pen, { damping }, x, row, top, colours) {
    pen.strokeStyle = pen.fillStyle = colours.kinds[3];
    pen.lineWidth = 2;
    const tail = Math.max(x - 34, 2);
    pen.beginPath();
    (pen.moveTo(x, row - 6), pen.lineTo(x, top));
    if (damping) {
      const [shut, open] = [tail, tail + 12];
      (pen.moveTo(open, row - 5), pen.lineTo(shut, row - 5), pen.lineTo(shut, row + 5), pen.lineTo(open, row + 5));
      (pen.moveTo(open - 4, row - 3), pen.lineTo(open - 4, row + 3));
      (pen.moveTo(open - 4, row), pen.lineTo(x - 6, row));
    } else (pen.moveTo(tail, row), pen.lineTo(x - 6, row));
    pen.stroke();
    pen.beginPath();
    (pen.moveTo(x - 1, row), pen.lineTo(x - 8, row - 5), pen.lineTo(x - 8, row + 5), pen.closePath());
    pen.fill();
  }

  /** What is at the far end: a wall, rock, a support, nothing, or the rest of an endless rod. */
  far(pen, x, mid, height, width, colours) {
    const end = this.blow.rod ? this.blow.rod.end : "wall";
    pen.font = "12.5px system-ui, sans-serif";
    pen.textAlign = "left";
    pen.strokeStyle = pen.fillStyle = colours.muted;
    pen.lineWidth = 1.2;
    const half = height * 0.18;
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
    const mass = this.blow.rod?.bit_mass;
    const words = mass ? `bit of ${withUnit(mass, "kg", 3)}, ${name}` : name;
    pen.fillText(tr(words), Math.min(x + 4, width - MARGIN - pen.measureText(tr(words)).width), mid + half + 14);
  }

  words(pen, width, height, colours, { apart, face, mid }) {
    pen.font = "12.5px system-ui, sans-serif";
    pen.fillStyle = colours.muted;
    pen.textAlign = face > 90 ? "right" : "left";
    pen.fillText(tr(apart ? "apart" : "in contact"), face > 90 ? face : MARGIN, mid + height * 0.18 + 14);
    pen.textAlign = "left";
    const sized = this.blow.units === "SI";
    const most = sized ? si(this.most, "Pa", 3) : number(this.most, 3);
    const y = height - 16;
    const [from, to] = [`compression −${most}`, `+${most} tension${sized ? "" : " (force)"}`];
    const [before, behind] = [from, to].map((text) => pen.measureText(tr(text)).width + 8);
    const left = MARGIN + before;
    const bar = Math.max(20, Math.min(120, width - left - behind - MARGIN));
    pen.fillText(tr(from), MARGIN, y + 10);
    pen.fillText(tr(to), left + bar + 8, y + 10);
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

/** Words on the right of a place, or on its left where there is no room: the first that fit between two others, if any;
 * where they end. */
const beside = (pen, x, y, options, from, to) => {
  for (const text of options) {
    const wide = pen.measureText(tr(text)).width;
    const left = x + 6 + wide <= to ? x + 6 : x - 40 - wide;
    if (left < from) continue;
    pen.textAlign = "left";
    pen.fillText(tr(text), left, y);
    return left + wide + 8;
  }
  return from;
};

/** A joint in words, the longer ones first. */
const jointWords = ({ kind, mass, stiffness, slack }) => {
  if (kind === "mass") return [`sleeve ${withUnit(mass, "kg", 3)}`, withUnit(mass, "kg", 3)];
  if (kind === "elastic") return [`spring ${si(stiffness, "N/m", 3)}`, si(stiffness, "N/m", 3)];
  return slack === null ? ["faces"] : [`slack ${si(slack, "m", 3)}`, si(slack, "m", 3)];
};

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
