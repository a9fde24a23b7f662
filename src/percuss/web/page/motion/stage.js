// The bar in motion, drawn anew for every frame of the screen from the frames that the server computed.
// Stroke and strain differ by orders of magnitude, so each is drawn on its own scale, and the scales are told.

import { data } from "../core/state.js";
import { number, si } from "../core/format.js";
import { whenever } from "../core/signals.js";
import { read } from "../core/units.js";
import { tr } from "../core/words.js";
import { signed, theme, themeNow } from "../pictures/colours.js";
import { FONT, arrow, penOf, signedScale, strokeLines } from "../pictures/pen.js";

/** @typedef {CanvasRenderingContext2D} Pen */
/** @typedef {ReturnType<typeof theme>} Theme */
/** @typedef {{ length: number, thick: number }} Section */
/** What the hammer and its tool look like, in metres or in bar lengths.
 * @typedef {{ bar: Section[], tool: Section[], held: boolean, rock: boolean }} Shape */
/** An answer of the server with its frames, or a happening of the live motion. @typedef {any} Motion */
/** @typedef {Record<string, any>} Blow */
/** Pixels: where the wall is, of the bar, for a bar length of travel and of stretch, for lengths and thicknesses.
 * @typedef {{ wall: number, bar: number, travel: number, along: number, across: number, thick: number,
 *   stretch: number }} Scale */
/** Where the parts of a bar are, and their strain as a share of the greatest.
 * @typedef {{ edges: number[], shares: number[], through: boolean }} Pose */
/** What a stage tells: each frame, each blow that it passes, each pause or jump; and asks: by how many seconds the picture
 * is behind its sound.
 * @typedef {{ ticked: (time: number) => void, struck: (blow: Blow) => void, stopped: () => void,
 *   lag: (stage: any) => number }} Told */

const FLASH = 0.22; // seconds that a blow is seen
const LATE = 0.2; // seconds behind its sound from which on the picture jumps to it

export class Stage {
  /** @param {HTMLCanvasElement} canvas @param {Told} told */
  constructor(canvas, { ticked, struck, stopped, lag }) {
    this.canvas = canvas;
    this.ticked = ticked;
    this.struck = struck;
    this.stopped = stopped;
    this.lag = lag;
    /** @type {Motion | null} */
    this.motion = null;
    /** The load by its phase, as a share of its greatest value.
     * @type {((phase: number) => number) | null | undefined} */
    this.force = null;
    this.length = 0; // of the motion
    this.deepest = 0; // of its gaps
    this.strain = this.stretch = 1e-12; // the greatest
    /** @type {Blow[]} */
    this.heard = [];
    this.loudest = 1e-30; // the energy of the strongest
    this.before = 0; // when the frame before was
    this.time = 0; // rad after the begin of the motion
    this.rate = 1; // rad per second
    this.grow = 1;
    this.playing = false;
    this.flash = { left: 0, size: 0 };
    /** @type {number[]} */
    this.frames = []; // of the last second
    this.box = [0, 0];
    this.places = 33; // along the bar
    this.shape = PLAIN;
    this.shares = thicknesses(PLAIN.bar, 32);
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(canvas);
    whenever(themeNow, () => this.draw());
  }

  /** Frames to be played. @param {Motion} motion @param {any} [force] @param {any} [shape] a `Shape` */
  show(motion, force, shape = PLAIN) {
    const { arrays } = motion;
    this.looks(shape, arrays.x.length);
    this.motion = motion;
    this.force = force;
    this.length = arrays.t.at(-1); // the frames may cover only the first part of the stretch
    this.deepest = Math.max(1e-12, ...Array.from(arrays.end_gap, (v) => (Number.isFinite(v) ? -v : 0)));
    this.strain = this.stretch = 1e-12;
    for (const value of arrays.strain) this.strain = Math.max(this.strain, Math.abs(value));
    const { displacement } = arrays;
    for (let i = 0; i < displacement.length; i += this.places) {
      const end = displacement[i + this.places - 1];
      for (let j = 0; j < this.places; j++) this.stretch = Math.max(this.stretch, Math.abs(displacement[i + j] - end));
    }
    /** @type {Blow[]} */
    const blows = motion.blows.filter((/** @type {Blow} */ { kind }) => kind !== "release" && kind !== "grazing");
    this.heard = once(blows, this.length);
    this.loudest = Math.max(1e-30, ...this.heard.map(({ energy }) => energy ?? 0));
    this.time = Math.min(this.time, this.length);
    this.draw();
  }

  /** What is drawn, in so many places along the bar. @param {Shape} shape @param {number} places */
  looks(shape, places) {
    Object.assign(this, { shape, places, shares: thicknesses(shape.bar, places - 1) });
  }

  /** Whether there is something to draw. */
  get there() {
    return Boolean(this.motion);
  }

  play() {
    if (this.playing || !this.there) return;
    this.playing = true;
    this.before = performance.now();
    this.frames = [];
    const step = (/** @type {number} */ now) => {
      if (!this.playing) return;
      const [gone, lag] = [Math.min(Math.max((now - this.before) / 1000, 0), 0.25), this.lag(this)];
      this.advance(Math.max(gone + (Math.abs(lag) > LATE ? lag : 0.1 * lag), 0));
      this.before = now;
      this.count(now);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    this.playing = false;
    this.stopped();
  }

  /** @param {number} time */
  seek(time) {
    this.stopped();
    this.time = Math.min(Math.max(time, 0), this.length);
    this.draw();
    this.ticked(this.time);
  }

  /** @param {number} seconds */
  advance(seconds) {
    const from = this.time;
    let to = from + seconds * this.rate;
    this.blows(from, to);
    if (to >= this.length) {
      to = this.length > 0 ? to % this.length : 0;
      this.blows(-1e-9, to);
    }
    this.time = to;
    this.flash.left = Math.max(0, this.flash.left - seconds);
    this.draw();
    this.ticked(to);
  }

  /** The blows of a stretch, seen and counted; when they are heard is another matter.
   * @param {number} from @param {number} to */
  blows(from, to) {
    for (const blow of this.heard) {
      if (blow.time <= from || blow.time > to) continue;
      this.strike(blow);
    }
  }

  /** A blow is seen, and counted. @param {Blow} blow */
  strike(blow) {
    this.flash = { left: FLASH, size: Math.sqrt(this.share(blow)) };
    this.canvas.dataset.blows = String(Number(this.canvas.dataset.blows ?? 0) + 1);
    this.struck(blow);
  }

  /** The energy of a blow over that of the strongest. @param {Blow} blow */
  share(blow) {
    return Math.max(blow.energy ?? 0, 0) / this.loudest;
  }

  /** The frames of the last second, for whoever wants to know whether they come fast enough. @param {number} now */
  count(now) {
    this.frames.push(now);
    while (this.frames.length > 61) this.frames.shift();
    if (this.frames.length > 30)
      this.canvas.dataset.fps = ((1000 * (this.frames.length - 1)) / (now - this.frames[0])).toFixed(1);
  }

  /** To scale as far as the travel can be seen. @param {number} width @param {number} height @returns {Scale} */
  scales(width, height = 200) {
    const { bar, tool } = this.shape;
    const struck = tool.length ? Math.min(0.26 * width, 220) : 56;
    const wall = width - struck;
    const room = wall - 24 - (this.shape.held ? 50 : 0);
    const along = room / (1 + this.deepest);
    const travel = Math.max(along, Math.min(90, 0.3 * room) / this.deepest);
    const long = Math.max(room - travel * this.deepest, 0.2 * room);
    const [length, thick] = [lengthOf(bar), Math.max(...bar.map((one) => one.thick))];
    const most = Math.max(thick, ...tool.map((one) => one.thick));
    const across = Math.min(Math.max(long / length, 16 / thick), (0.5 * height) / most);
    const rigid = !this.motion || this.motion.modes === 0 || this.strain < 1e-11; // of rounding
    const stretch = rigid ? 0 : (0.05 * long * this.grow) / this.stretch;
    return { wall, bar: long, travel, along: long / length, across, thick: thick * across, stretch };
  }

  /** How much larger than the bar its travel and its stretch are drawn, in words. */
  magnified() {
    const { bar, travel, stretch } = this.scales(600);
    const stretched = stretch ? `, stretch ×${number(stretch / bar, 2)}` : "; nothing is stretched";
    return travel / bar < 1.05
      ? `travel to scale${stretched}`
      : `travel drawn ×${number(travel / bar, 2)}${stretched} on its own scale`;
  }

  draw() {
    const [wide, high] = this.box;
    if (!this.there || !wide || !high) return;
    const { pen, width, height } = penOf(this.canvas, this.box);
    this.paint(pen, width, height);
  }

  /** @param {Pen} pen @param {number} width @param {number} height */
  paint(pen, width, height) {
    const colours = theme();
    const scale = this.scales(width, height);
    const mid = height * 0.46;
    pen.font = FONT;
    pen.textAlign = "left";
    this.struckAt(pen, scale, mid, width, height, colours);
    const at = this.pose(scale);
    this.bar(pen, at, scale, mid, colours);
    if (this.shape.held) spring(pen, at.edges[0], mid, colours);
    this.push(pen, at.edges[0], mid, colours);
    if (this.flash.left > 0) this.burst(pen, scale.wall, mid, scale.thick, colours);
    this.words(pen, width, height, colours);
  }

  /** @param {Scale} scale @returns {Pose} */
  pose(scale) {
    const { places } = this;
    const { t, displacement, strain } = this.motion.arrays;
    const at = this.frame(t);
    const value = (/** @type {Float32Array} */ list, /** @type {number} */ j) => {
      const a = list[at.i * places + j];
      return a + at.share * (list[at.next * places + j] - a);
    };
    const end = value(displacement, places - 1);
    const edge = scale.wall + end * scale.travel;
    const edges = Array.from(
      { length: places },
      (_, j) => edge - (1 - j / (places - 1)) * scale.bar + (value(displacement, j) - end) * scale.stretch,
    );
    const shares = Array.from(
      { length: places - 1 },
      (_, j) => (value(strain, j) + value(strain, j + 1)) / (2 * this.strain),
    );
    return { edges, shares, through: end > 1e-9 };
  }

  /** @param {Pen} pen @param {Pose} pose @param {Scale} scale @param {number} mid @param {Theme} colours */
  bar(pen, { edges, shares, through }, { thick }, mid, colours) {
    for (let j = 0; j < shares.length; j++) {
      pen.fillStyle = through ? colours.bad : signed(shares[j]);
      const swell = thick * this.shares[j] * (1 - 0.06 * shares[j]);
      pen.fillRect(edges[j] - 0.4, mid - swell / 2, edges[j + 1] - edges[j] + 0.8, swell);
    }
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.2;
    for (let j = 0, from = 0; j < shares.length; j++) {
      if (this.shares[j] === this.shares[j + 1]) continue; // the outline goes on
      const tall = thick * this.shares[j];
      pen.strokeRect(edges[from], mid - tall / 2, edges[j + 1] - edges[from], tall);
      from = j + 1;
    }
  }

  /** What is struck: a wall, or the tool to scale as far as there is room, and the rock at its end.
   * @param {Pen} pen
   * @param {Scale} scale @param {number} mid @param {number} width @param {number} height @param {Theme} colours */
  struckAt(pen, { wall, along, across }, mid, width, height, colours) {
    const { tool, rock } = this.shape;
    if (!tool.length) return this.wall(pen, wall, height, colours);
    const room = width - wall - (rock ? 30 : 12);
    const short = Math.min(1, room / (along * lengthOf(tool)));
    pen.strokeStyle = colours.ink;
    pen.fillStyle = colours.sunken;
    pen.lineWidth = 1.2;
    let left = wall;
    for (const { length, thick } of tool) {
      const [long, tall] = [length * along * short, Math.max(thick * across, 5)];
      pen.fillStyle = colours.line;
      pen.fillRect(left, mid - tall / 2, long, tall);
      pen.strokeRect(left, mid - tall / 2, long, tall);
      left += long;
    }
    if (short < 0.999) broken(pen, wall + 0.55 * room, mid, colours);
    if (rock) ground(pen, left, mid, width, height, colours);
  }

  /** The two frames about the present time and the share of the second. @param {Float32Array} t */
  frame(t) {
    const last = t.length - 1;
    const place = this.length > 0 ? (this.time / this.length) * last : 0;
    const i = Math.min(Math.max(Math.floor(place), 0), last);
    return { i, next: Math.min(i + 1, last), share: place - i };
  }

  /** A wall. @param {Pen} pen @param {number} x @param {number} height @param {Theme} colours */
  wall(pen, x, height, { muted }) {
    pen.fillStyle = muted;
    pen.fillRect(x, 12, 4, height - 44);
    const hatches = Array.from({ length: Math.max(Math.ceil((height - 48) / 11), 0) }, (_, i) => 16 + 11 * i);
    strokeLines(pen, muted, 1.2, ...hatches.map((y) => [x + 4, y, x + 20, y + 11]));
  }

  phaseOfLoad() {
    return this.motion.load_phase + this.time;
  }

  /** The load on the driven end: an arrow, to the right when it pushes.
   * @param {Pen} pen @param {number} x @param {number} y @param {Theme} colours */
  push(pen, x, y, { kinds }) {
    const length = 46 * (this.force?.(this.phaseOfLoad()) ?? 0);
    if (Math.abs(length) < 2) return;
    const [tail, tip] = length > 0 ? [x - 4 - length, x - 4] : [x - 4, x - 4 + length];
    arrow(pen, kinds[3], tail, tip, y, 7);
  }

  /** A blow, for a moment.
   * @param {Pen} pen @param {number} x @param {number} y @param {number} thick @param {Theme} colours */
  burst(pen, x, y, thick, { kinds }) {
    const share = this.flash.left / FLASH;
    const reach = (0.35 + 0.65 * this.flash.size) * (10 + 26 * (1 - share));
    const near = thick / 2 + 4;
    const ray = (/** @type {number} */ side, /** @type {number} */ lean) => [
      x - 3,
      y + side * near,
      x - 3 - lean * reach,
      y + side * (near + reach),
    ];
    pen.globalAlpha = share;
    strokeLines(pen, kinds[4], 3, ray(-1, 0.35), ray(-1, 1), ray(1, 0.35), ray(1, 1));
    pen.globalAlpha = 1;
  }

  /** The scale of the strain. @param {Pen} pen @param {number} width @param {number} height @param {Theme} colours */
  words(pen, width, height, colours) {
    const stress = this.motion?.stress_scale_Pa;
    if (!(this.strain > 1e-11)) return; // nothing is strained: at rest, without a load
    const most = stress ? si(this.strain * stress, "Pa", 3) : number(this.strain, 3);
    const bar = Math.min(120, width * 0.2);
    const long = /** @type {[string, string]} */ ([
      `compression −${most}`,
      `+${most} tension${stress ? "" : " (strain)"}`,
    ]);
    const room = width - 14 - bar - 2 * 8 - 6;
    const fits = long.reduce((sum, text) => sum + pen.measureText(tr(text)).width, 0) <= room;
    pen.fillStyle = colours.muted;
    signedScale(pen, fits ? long : [`−${most}`, `+${most}${stress ? "" : " strain"}`], 14, height - 20, bar);
  }
}

/** Two slanted strokes: the tool is longer than it is drawn.
 * @param {Pen} pen @param {number} x @param {number} mid @param {Theme} colours */
function broken(pen, x, mid, { sunken, muted }) {
  const [top, foot] = [mid - 26, mid + 26];
  strokeLines(pen, sunken, 10, [x + 4, top, x - 4, foot]);
  strokeLines(pen, muted, 1.2, [x, top, x - 8, foot], [x + 8, top, x, foot]);
}

/** The rock.
 * @param {Pen} pen @param {number} x @param {number} mid @param {number} width @param {number} height
 * @param {Theme} colours */
function ground(pen, x, mid, width, height, { muted }) {
  const [top, tall] = [mid - 0.34 * height, 0.68 * height];
  pen.fillStyle = muted;
  pen.globalAlpha = 0.35;
  pen.fillRect(x, top, width - x, tall);
  pen.globalAlpha = 1;
  const hatches = Array.from({ length: Math.max(Math.ceil(tall / 10) - 1, 0) }, (_, i) => top + 10 * i);
  strokeLines(pen, muted, 1.2, ...hatches.map((y) => [x + 2, y + 10, Math.min(x + 22, width), y]));
}

/** What holds a structure. @param {Pen} pen @param {number} x @param {number} mid @param {Theme} colours */
function spring(pen, x, mid, { muted }) {
  const turns = Array.from({ length: 11 }, (_, i) => [10 + ((i + 1) / 12) * (x - 10), mid + (i % 2 ? 9 : -9)]);
  strokeLines(pen, muted, 2, [10, mid - 34, 10, mid + 34], [10, mid, ...turns.flat(), x, mid]);
}

/** A load as a share of its greatest value, by its phase.
 * @param {Iterable<number> | null | undefined} curve over a period */
export function pushOf(curve) {
  if (!curve) return null;
  const load = [...curve];
  const most = Math.max(...load.map(Math.abs)) || 1;
  return (/** @type {number} */ phase) => {
    const share = (((phase / (2 * Math.PI)) % 1) + 1) % 1;
    return load[Math.round(share * (load.length - 1))] / most;
  };
}

/** The blows of a motion, in which a period begins and ends with the same one.
 * @param {Blow[]} blows @param {number} length */
export function once(blows, length) {
  const near = 1e-5 * length;
  return blows.some(({ time }) => time < near) ? blows.filter(({ time }) => time < length - near) : blows;
}

/** A bar of which no size is known, before a wall. @type {Shape} */
export const PLAIN = { bar: [{ length: 1, thick: 0.16 }], tool: [], held: false, rock: false };

/** @param {Section[]} sections */
const lengthOf = (sections) => sections.reduce((sum, { length }) => sum + length, 0);

/** The thickness of the bar in `count` equal parts of its length, as shares of the greatest.
 * @param {Section[]} sections @param {number} count */
function thicknesses(sections, count) {
  const most = Math.max(...sections.map(({ thick }) => thick));
  return Array.from({ length: count }, (_, j) => {
    let left = ((j + 0.5) / count) * lengthOf(sections);
    const here = sections.find(({ length }) => (left -= length) <= 0) ?? sections[sections.length - 1];
    return here.thick / most;
  });
}

/** What the hammer of the present case looks like, in metres; a case without sizes has a bar of one thickness.
 * @returns {Shape} */
export function shapeOfCase() {
  const { tables, info } = data;
  if (!tables) return PLAIN;
  const known = (info?.bar?.sections ?? []).map((/** @type {any} */ one) => ({
    length: one.length_m,
    thick: one.diameter_m,
  }));
  const bar = known.length && (tables.bar?.sections || tables.bar?.length) ? known : PLAIN.bar;
  return {
    bar,
    tool: known.length ? toolOf(tables.tool) : [],
    held: Boolean(tables.body),
    rock: Boolean(tables.rock && tables.tool),
  };
}

/** Sections of the tool whose length and diameter are told; an endless rod is drawn as long as there is room.
 * @param {any} tool @returns {Section[]} */
function toolOf(tool) {
  const sections = Array.isArray(tool?.sections) ? tool.sections : [];
  const metres = (/** @type {unknown} */ text) => read(String(text ?? ""), "m").value;
  return sections
    .map((/** @type {any} */ one) => ({ length: metres(one.length) || 10, thick: metres(one.diameter) || 0 }))
    .filter((/** @type {Section} */ one) => one.thick > 0);
}
