// Striker, tool and rock with the waves in them: the colour and the curve below are the stress, on the scale that is told.
// What holds the tool is drawn, too: its feed, its joints and its bit. It plays frame by frame, to the end of the blow.

import { put } from "../core/dom.js";
import { number, si, withUnit } from "../core/format.js";
import { tr } from "../core/words.js";
import { signed, theme } from "../pictures/colours.js";
import { FONT, arrowHead, penOf, signedScale, strokeLines } from "../pictures/pen.js";

/** @typedef {import("../pictures/pen.js").Pen} Pen */
/** @typedef {Record<string, any>} Colours */
/** A blow as the server tells it. @typedef {Record<string, any>} Blow */
/** @typedef {{ kind: string, at: number, mass?: number, stiffness?: number, slack?: number | null, opens?: number[],
 *   closes?: number[] }} Joint */
/** Where a body is drawn: its row, pixels of a length and of a thickness, and the row and the height of its curve.
 * @typedef {{ mid: number, along: number, across: number, base: number, tall: number }} Place */

const MARGIN = 16;
const APART = 7; // pixels between the faces while they are apart
const END = 54; // pixels for what is at the far end
const BIT = 9; // pixels of a bit that is known by its mass
/** Pixels between sections at a joint. @type {Record<string, number>} */
const GAPS = { mass: 0, elastic: 16, contact: 6 };
const FEED_ROW = 14; // where the words above the tool stand
const JOINT_ROW = 29;
/** @type {Record<string, string>} */
const ENDS = { infinite: "endless", free: "free", fixed: "fixed", rock: "rock", wall: "wall" };

export class BlowStage {
  /** @type {Blow | null} */
  blow = null;
  length = 0; // the last frame
  frame = 0;
  place = 0; // between frames, while it plays
  playing = false;
  seconds = 1; // that all frames take
  box = [0, 0];
  most = 0; // the greatest stress
  /** Thicknesses of the sections of striker and tool. @type {number[][]} */
  thick = [];
  /** @type {Map<number, Joint>} */
  joints = new Map();

  /** On a canvas; `note` says how it is drawn, `painted` is told of every frame, `ended` of the end of the blow.
   * @param {HTMLCanvasElement} canvas @param {HTMLElement} note @param {{ painted: () => void, ended: () => void }} told */
  constructor(canvas, note, { painted, ended }) {
    this.canvas = canvas;
    this.note = note;
    this.painted = painted;
    this.ended = ended;
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(canvas);
  }

  get there() {
    return Boolean(this.blow);
  }

  /** Another blow, from a share of its time on. @param {Blow} blow @param {number} share */
  show(blow, share) {
    const { arrays, striker, rod } = blow;
    this.blow = blow;
    this.most = 0;
    for (const values of [arrays.striker_stress, arrays.rod_stress ?? []])
      for (const value of values) this.most = Math.max(this.most, Math.abs(value));
    this.thick = thicknesses(rod ? [striker, rod] : [striker]);
    this.joints = new Map((rod?.joints ?? []).map((/** @type {Joint} */ joint) => [joint.at, joint]));
    this.length = arrays.t.length - 1;
    this.frame = this.place = Math.round(share * this.length);
  }

  play() {
    if (this.frame >= this.length) this.frame = 0;
    this.playing = true;
    this.place = this.frame;
    let before = performance.now();
    const step = (/** @type {number} */ now) => {
      if (!this.playing) return;
      this.place += ((now - before) / (1000 * this.seconds)) * this.length;
      before = now;
      if (this.place >= this.length) this.ended();
      if (Math.floor(this.place) !== this.frame) this.seek(Math.floor(this.place));
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    this.playing = false;
  }

  /** @param {number} frame */
  seek(frame) {
    if (!this.blow) return;
    this.frame = Math.min(Math.max(Math.round(frame), 0), this.length);
    this.draw();
    this.canvas.dataset.frame = String(this.frame);
    this.painted();
  }

  draw() {
    if (!this.blow || !this.box[0] || !this.box[1]) return;
    const { pen, width, height } = penOf(this.canvas, this.box);
    this.paint(pen, this.blow, width, height);
    put(this.note, this.magnified(this.blow, width, height));
  }

  /** Pixels of a length and of a thickness: both are to scale, the thickness on a larger one where bars are slender.
   * @param {Blow} blow @param {number} width @param {number} height */
  scales({ striker, rod }, width, height) {
    const long = sum(striker.lengths) + (rod ? sum(rod.lengths) : 0);
    const gaps = sum([...this.joints.values()].map(({ kind }) => GAPS[kind])) + (rod?.bit_mass ? BIT : 0);
    const along = (width - 2 * MARGIN - APART - END - gaps) / long;
    const thick = Math.max(...this.thick.flat());
    return { along, across: Math.min((0.32 * height) / thick, Math.max(along, (0.26 * height) / thick)) };
  }

  /** @param {Pen} pen @param {Blow} blow @param {number} width @param {number} height */
  paint(pen, blow, width, height) {
    const colours = theme();
    const place = { ...this.scales(blow, width, height), mid: 0.31 * height, base: 0.72 * height, tall: 0.16 * height };
    const face = MARGIN + sum(blow.striker.lengths) * place.along;
    const apart = blow.arrays.touching[this.frame] === 0;
    pen.font = FONT;
    strokeLines(pen, colours.line, 1, [MARGIN, place.base, width - MARGIN, place.base]);
    this.body(pen, "striker", MARGIN + (apart ? 0 : APART), place, colours); // while they touch no gap is between the faces
    let end = face + APART;
    if (blow.rod) {
      const starts = this.body(pen, "rod", end, place, colours);
      end = this.held(pen, blow.rod, starts, place, width, colours);
    }
    const low = place.mid + 0.18 * height + 14;
    this.far(pen, blow.rod, end, { mid: place.mid, half: 0.18 * height, low, width }, colours);
    pen.fillStyle = colours.muted;
    pen.textAlign = face > 90 ? "right" : "left";
    pen.fillText(tr(apart ? "apart" : "in contact"), face > 90 ? face : MARGIN, low);
    const sized = blow.units === "SI";
    const most = sized ? si(this.most, "Pa", 3) : number(this.most, 3);
    /** @type {[string, string]} */
    const ends = [`compression −${most}`, `+${most} tension${sized ? "" : " (force)"}`];
    const words = sum(ends.map((text) => pen.measureText(tr(text)).width + 8));
    signedScale(pen, ends, MARGIN, height - 16, Math.max(20, Math.min(120, width - 2 * MARGIN - words)));
  }

  /** The cells of a body in their colours, its outline, and its stress as a curve; where its sections begin, and where it
   * ends. @param {Pen} pen @param {"striker" | "rod"} name @param {number} left @param {Place} place @param {Colours} colours */
  body(pen, name, left, { mid, along, across, base, tall }, colours) {
    const { arrays, [name]: one } = /** @type {Blow} */ (this.blow);
    /** @type {number[]} */
    const lengths = one.lengths;
    const [edges, stresses] = [arrays[`${name}_edges`], arrays[`${name}_stress`]];
    const talls = this.thick[name === "rod" ? 1 : 0].map((thick) => thick * across);
    const count = edges.length - 1;
    const starts = [left];
    for (const [i, length] of lengths.entries()) {
      if (name === "rod") starts[i] += GAPS[this.joints.get(i)?.kind ?? ""] ?? 0; // room for a joint that comes apart
      starts.push(starts[i] + length * along);
    }
    const curve = [];
    for (let j = 0, section = 0, before = 0; j < count; j++) {
      while (section < lengths.length - 1 && edges[j] > (before + lengths[section]) * (1 - 1e-6))
        before += lengths[section++];
      const [from, to] = [edges[j], edges[j + 1]].map((edge) => starts[section] + (edge - before) * along);
      const share = stresses[this.frame * count + j] / (this.most || 1);
      const whole = Math.floor(from); // whole pixels: else neighbours show through each other
      pen.fillStyle = signed(share);
      pen.fillRect(whole, mid - talls[section] / 2, Math.ceil(to) - whole, talls[section]);
      curve.push(from, base - share * tall, to, base - share * tall);
    }
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.2;
    lengths.forEach((length, i) => pen.strokeRect(starts[i], mid - talls[i] / 2, length * along, talls[i]));
    strokeLines(pen, colours.accent, 1.8, curve);
    return starts;
  }

  /** What holds the tool: joints, feed and bit, each with its size in words; where the bit ends.
   * @param {Pen} pen @param {Blow} rod @param {number[]} starts @param {Place} place @param {number} width
   * @param {Colours} colours */
  held(pen, { feed, end, bit_mass: bit }, starts, { mid, across }, width, colours) {
    const half = this.thick[1].map((thick) => (thick * across) / 2);
    const say = (/** @type {number} */ x, /** @type {number} */ row, /** @type {string[]} */ words, from = 0) => {
      pen.fillStyle = colours.muted;
      return beside(pen, x, row, words, from, width - MARGIN);
    };
    let taken = 0; // up to where words stand in the row of the joints
    for (const joint of this.joints.values()) {
      this.joint(pen, joint, starts[joint.at], mid, half[joint.at - 1], half[joint.at], colours);
      taken = say(starts[joint.at], JOINT_ROW, jointWords(joint), taken);
    }
    const node = starts[feed?.at ?? 0];
    if (feed) {
      this.feed(pen, feed, node, FEED_ROW - 4, mid - (half[feed.at] ?? 0), colours);
      const words = [
        `feed ${si(feed.force, "N", 3)}`,
        feed.damping && `dashpot ${si(feed.damping, "N·s/m", 3)}`,
        feed.stiffness && `spring ${si(feed.stiffness, "N/m", 3)}`,
      ];
      say(node, FEED_ROW, [words.filter(Boolean).join(", "), words[0]]);
    } else if (end === "rock" || end === "fixed") say(node, FEED_ROW, ["no feed"]);
    const x = starts[starts.length - 1];
    if (!bit) return x;
    const wide = half[half.length - 1] + 4;
    pen.fillStyle = colours.muted;
    pen.fillRect(x, mid - wide, BIT, 2 * wide);
    return x + BIT;
  }

  /** A joint that ends at `x`, between sections of such half thicknesses: a sleeve, a spring, or two faces.
   * @param {Pen} pen @param {Joint} joint @param {number} x @param {number} mid @param {number} one @param {number} other
   * @param {Colours} colours */
  joint(pen, { kind, opens = [], closes = [] }, x, mid, one, other, colours) {
    const from = x - GAPS[kind];
    const least = Math.min(one, other);
    pen.fillStyle = colours.ink;
    if (kind === "mass") {
      const half = Math.max(one, other);
      for (const y of [mid - half - 5, mid + half]) pen.fillRect(x - 8, y, 16, 5);
    } else if (kind === "elastic") {
      const high = Math.min(0.5 * least, 9);
      const turns = [1, 2, 3, 4, 5].flatMap((k) => [from + (k * GAPS.elastic) / 6, mid + (k % 2 ? high : -high)]);
      strokeLines(pen, colours.ink, 1.2, [from, mid, ...turns, x, mid]);
    } else {
      const now = this.blow?.arrays.t[this.frame];
      const past = (/** @type {number[]} */ times) => times.filter((time) => time <= now).length;
      if (past(opens) <= past(closes)) return pen.fillRect(from, mid - least, GAPS.contact, 2 * least); // shut
      pen.fillRect(from - 1, mid - one, 2, 2 * one);
      pen.fillRect(x - 1, mid - other, 2, 2 * other);
    }
  }

  /** The feed: an arrow toward the rock at its node, with a dashpot behind it where it has one.
   * @param {Pen} pen @param {{ damping?: number }} feed @param {number} x @param {number} row @param {number} top
   * @param {Colours} colours */
  feed(pen, { damping }, x, row, top, colours) {
    const tail = Math.max(x - 34, 2);
    const open = tail + 12;
    const stem = [x, row - 6, x, top];
    const dashpot = [
      [open, row - 5, tail, row - 5, tail, row + 5, open, row + 5],
      [open - 4, row - 3, open - 4, row + 3],
    ];
    const shaft = [damping ? open - 4 : tail, row, x - 6, row];
    strokeLines(pen, colours.kinds[3], 2, stem, shaft, ...(damping ? dashpot : []));
    arrowHead(pen, colours.kinds[3], x - 1, row, -7, 5);
  }

  /** What is at the far end: a wall, rock, a support, nothing, or the rest of an endless rod.
   * @param {Pen} pen @param {Blow | null} rod @param {number} x
   * @param {{ mid: number, half: number, low: number, width: number }} place @param {Colours} colours */
  far(pen, rod, x, { mid, half, low, width }, colours) {
    const end = rod?.end ?? "wall";
    pen.fillStyle = colours.muted;
    if (end === "infinite") {
      const chevrons = [x + 6, x + 14, x + 22].map((at) => [at, mid - 6, at + 6, mid, at, mid + 6]);
      strokeLines(pen, colours.muted, 1.2, ...chevrons);
    } else if (end !== "free") {
      pen.fillRect(x, mid - half, 3, 2 * half);
      const rows = Array.from({ length: Math.ceil((2 * half - 8) / 9) }, (_, k) => mid - half + 9 * k);
      const lines = rows.map((y) =>
        end === "rock" ? [x + 5, y, x + 16, y + 4, x + 9, y + 9, x + 24, y + 9] : [x + 3, y, x + 18, y + 9],
      );
      strokeLines(pen, colours.muted, 1.2, ...lines);
    }
    const words = tr(rod?.bit_mass ? `bit of ${withUnit(rod.bit_mass, "kg", 3)}, ${ENDS[end]}` : ENDS[end]);
    pen.textAlign = "left";
    pen.fillText(words, Math.min(x + 4, width - MARGIN - pen.measureText(words).width), low);
  }

  /** How thickness is drawn beside length, in words. @param {Blow} blow @param {number} width @param {number} height */
  magnified(blow, width, height) {
    if (!blow.striker.areas) return "Thickness shows impedance; the sizes are not known.";
    const { along, across } = this.scales(blow, width, height);
    const larger = across / along > 1.05 ? `, ×${number(across / along, 2)} beside the lengths` : "";
    return `Lengths to scale; thickness to scale${larger}, of round bars of the same area.`;
  }
}

const sum = (/** @type {number[]} */ values) => values.reduce((total, value) => total + value, 0);

/** Words on the right of a place, or on its left where there is no room: the first that fit between two others, if any;
 * where they end. @param {Pen} pen @param {number} x @param {number} y @param {string[]} options @param {number} from
 * @param {number} to */
function beside(pen, x, y, options, from, to) {
  for (const text of options) {
    const wide = pen.measureText(tr(text)).width;
    const left = x + 6 + wide <= to ? x + 6 : x - 40 - wide;
    if (left < from) continue;
    pen.textAlign = "left";
    pen.fillText(tr(text), left, y);
    return left + wide + 8;
  }
  return from;
}

/** A joint in words, the longer ones first. @param {Joint} joint */
function jointWords({ kind, mass = 0, stiffness, slack }) {
  if (kind === "contact" && slack === null) return ["faces"];
  const [name, size] =
    kind === "mass"
      ? ["sleeve", withUnit(mass, "kg", 3)]
      : kind === "elastic"
        ? ["spring", si(stiffness, "N/m", 3)]
        : ["slack", si(slack, "m", 3)];
  return [`${name} ${size}`, size];
}

/** Of each body the diameters of round sections of these areas; without sizes the roots of the impedances, as shares of
 * the striker's length. @param {{ areas?: number[], impedances: number[], lengths: number[] }[]} bodies */
function thicknesses(bodies) {
  const most = Math.max(...bodies.flatMap(({ impedances }) => impedances));
  const thin = 0.15 * sum(bodies[0].lengths);
  return bodies.map(({ areas, impedances }) =>
    areas ? areas.map((area) => 2 * Math.sqrt(area / Math.PI)) : impedances.map((own) => thin * Math.sqrt(own / most)),
  );
}
