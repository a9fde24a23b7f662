// The bar in motion, drawn anew for every frame of the screen from the frames that the server computed.
// Stroke and strain differ by orders of magnitude, so each is drawn on its own scale, and the scales are told.

import { signed, theme } from "../pictures/colours.js";
import { number, si } from "../core/format.js";
import { tr } from "../core/words.js";

const FLASH = 0.22; // seconds that a blow is seen
const LATE = 0.2; // seconds behind its sound from which on the picture jumps to it

export class Stage {
  /** `ticked(time)` is called for every frame, `struck(blow)` when the play passes a blow, `stopped()` when it pauses
   * or jumps; `lag(stage)` tells how many seconds the picture is behind its sound. */
  constructor(canvas, { ticked, struck, stopped, lag }) {
    Object.assign(this, { canvas, ticked, struck, stopped, lag });
    this.motion = null;
    this.time = 0; // rad after the begin of the motion
    this.rate = 1; // rad per second
    this.grow = 1;
    this.playing = false;
    this.flash = { left: 0, size: 0 };
    this.frames = [];
    this.box = [0, 0];
    this.looks(PLAIN, 33);
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(canvas);
  }

  /** `shape` is what the hammer and its tool look like: {bar, tool: [{length, thick}], held, rock}, in metres, or in bar
   * lengths; without one a bar of one thickness before a wall. */
  show(motion, force, shape = PLAIN) {
    const { arrays } = motion;
    this.looks(shape, arrays.x.length);
    this.motion = motion;
    this.force = force;
    this.length = arrays.t.at(-1); // the frames may cover only the first part of the stretch
    this.deepest = Math.max(1e-12, ...Array.from(arrays.end_gap, (v) => (Number.isFinite(v) ? -v : 0)));
    this.strain = 1e-12;
    for (const value of arrays.strain) this.strain = Math.max(this.strain, Math.abs(value));
    this.stretch = 1e-12;
    const { displacement } = arrays;
    for (let i = 0; i < displacement.length; i += this.places) {
      const end = displacement[i + this.places - 1];
      for (let j = 0; j < this.places; j++) this.stretch = Math.max(this.stretch, Math.abs(displacement[i + j] - end));
    }
    this.heard = motion.blows.filter((blow) => blow.kind !== "release" && blow.kind !== "grazing");
    const near = 1e-5 * this.length; // a period begins and ends with the same blow
    if (this.heard.some((blow) => blow.time < near))
      this.heard = this.heard.filter((blow) => blow.time < this.length - near);
    this.loudest = Math.max(1e-30, ...this.heard.map((blow) => blow.energy ?? 0));
    this.time = Math.min(this.time, this.length);
    this.draw();
  }

  /** What is drawn, in so many places along the bar. */
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
    const step = (now) => {
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

  seek(time) {
    this.stopped();
    this.time = Math.min(Math.max(time, 0), this.length);
    this.draw();
    this.ticked(this.time);
  }

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

  /** The blows of a stretch, seen and counted; when they are heard is another matter. */
  blows(from, to) {
    for (const blow of this.heard) {
      if (blow.time <= from || blow.time > to) continue;
      this.flash = { left: FLASH, size: Math.sqrt(this.share(blow)) };
      this.struck(blow);
    }
  }

  /** The energy of a blow over that of the strongest. */
  share(blow) {
    return Math.max(blow.energy ?? 0, 0) / this.loudest;
  }

  /** The frames of the last second, for whoever wants to know whether they come fast enough. */
  count(now) {
    this.frames.push(now);
    while (this.frames.length > 61) this.frames.shift();
    if (this.frames.length > 30)
      this.canvas.dataset.fps = ((1000 * (this.frames.length - 1)) / (now - this.frames[0])).toFixed(1);
  }

  /** Scales of the drawing: pixels of the bar's length, for a bar length of travel, and of stretch; to scale as far as the
   * travel can be seen. */
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
    const rigid = !this.motion || this.motion.modes === 0 || this.strain < 1e-11; // what is left then is the rounding of the numbers on their way here
    return { wall, bar: long, travel, along: long / length, across, thick: thick * across, stretch: rigid ? 0 : (0.05 * long * this.grow) / this.stretch };
  }

  /** How much larger than the bar its travel and its stretch are drawn, in words. */
  magnified() {
    const { bar, travel, stretch } = this.scales(600);
    const stretched = stretch ? `, stretch ×${number(stretch / bar, 2)}` : "; nothing is stretched";
    return travel / bar < 1.05 ? `travel to scale${stretched}` : `travel drawn ×${number(travel / bar, 2)}${stretched} on its own scale`;
  }

  draw() {
    const { canvas } = this;
    const [width, height] = this.box;
    if (!this.there || !width || !height) return;
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
  }

  paint(pen, width, height) {
    const colours = theme();
    const scale = this.scales(width, height);
    const mid = height * 0.46;
    this.struckAt(pen, scale, mid, width, height, colours);
    const at = this.pose(scale);
    this.bar(pen, at, scale, mid, colours);
    if (this.shape.held) this.spring(pen, at.edges[0], mid, colours);
    this.push(pen, at.edges[0], mid, colours);
    if (this.flash.left > 0) this.burst(pen, scale.wall, mid, scale.thick, colours);
    this.words(pen, width, height, colours);
  }

  /** Where the parts of the bar are on the screen, and their strain as a share of the greatest. */
  pose(scale) {
    const { places } = this;
    const { t, displacement, strain } = this.motion.arrays;
    const at = this.frame(t);
    const value = (list, j) => {
      const a = list[at.i * places + j];
      return a + at.share * (list[at.next * places + j] - a);
    };
    const end = value(displacement, places - 1);
    const edge = scale.wall + end * scale.travel;
    const edges = Array.from({ length: places }, (_, j) => edge - (1 - j / (places - 1)) * scale.bar + (value(displacement, j) - end) * scale.stretch);
    const shares = Array.from({ length: places - 1 }, (_, j) => (value(strain, j) + value(strain, j + 1)) / (2 * this.strain));
    return { edges, shares, through: end > 1e-9 };
  }

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

  /** What is struck: a wall, or the tool to scale as far as there is room, and the rock at its end. */
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
    if (short < 0.999) this.broken(pen, wall + 0.55 * room, mid, colours);
    if (rock) this.ground(pen, left, mid, width, height, colours);
  }

  /** Two slanted strokes: the tool is longer than it is drawn. */
  broken(pen, x, mid, colours) {
    const tall = 26;
    pen.fillStyle = colours.sunken;
    pen.beginPath();
    (pen.moveTo(x - 1, mid - tall), pen.lineTo(x + 9, mid - tall), pen.lineTo(x + 1, mid + tall), pen.lineTo(x - 9, mid + tall), pen.fill());
    pen.strokeStyle = colours.muted;
    pen.beginPath();
    for (const dx of [0, 8]) (pen.moveTo(x + dx, mid - tall), pen.lineTo(x + dx - 8, mid + tall));
    pen.stroke();
  }

  ground(pen, x, mid, width, height, colours) {
    pen.fillStyle = colours.muted;
    pen.globalAlpha = 0.35;
    pen.fillRect(x, mid - 0.34 * height, width - x, 0.68 * height);
    pen.globalAlpha = 1;
    pen.strokeStyle = colours.muted;
    pen.beginPath();
    for (let y = mid - 0.34 * height; y < mid + 0.34 * height - 10; y += 10) (pen.moveTo(x + 2, y + 10), pen.lineTo(Math.min(x + 22, width), y));
    pen.stroke();
  }

  /** What holds a structure. */
  spring(pen, x, mid, colours) {
    pen.strokeStyle = colours.muted;
    pen.lineWidth = 2;
    pen.beginPath();
    (pen.moveTo(10, mid - 34), pen.lineTo(10, mid + 34), pen.moveTo(10, mid));
    for (let i = 1; i < 12; i++) pen.lineTo(10 + (i / 12) * (x - 10), mid + (i % 2 ? -9 : 9));
    pen.lineTo(x, mid);
    pen.stroke();
  }

  /** The two frames about the present time and the share of the second. */
  frame(t) {
    const last = t.length - 1;
    const place = this.length > 0 ? (this.time / this.length) * last : 0;
    const i = Math.min(Math.max(Math.floor(place), 0), last);
    return { i, next: Math.min(i + 1, last), share: place - i };
  }

  wall(pen, x, height, colours) {
    pen.fillStyle = colours.muted;
    pen.fillRect(x, 12, 4, height - 44);
    pen.strokeStyle = colours.muted;
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (let y = 16; y < height - 32; y += 11) (pen.moveTo(x + 4, y), pen.lineTo(x + 20, y + 11));
    pen.stroke();
  }

  phaseOfLoad() {
    return this.motion.load_phase + this.time;
  }

  /** The load on the driven end: an arrow, to the right when it pushes. */
  push(pen, x, y, colours) {
    if (!this.force) return;
    const value = this.force(this.phaseOfLoad());
    const length = 46 * value;
    if (Math.abs(length) < 2) return;
    const tip = value > 0 ? x - 4 : x - 4 + length;
    const tail = value > 0 ? x - 4 - length : x - 4;
    const head = value > 0 ? -7 : 7;
    pen.strokeStyle = pen.fillStyle = colours.kinds[3];
    pen.lineWidth = 3;
    pen.beginPath();
    (pen.moveTo(tail, y), pen.lineTo(tip + head * 0.6, y));
    pen.stroke();
    pen.beginPath();
    (pen.moveTo(tip, y), pen.lineTo(tip + head, y - 6), pen.lineTo(tip + head, y + 6), pen.closePath());
    pen.fill();
  }

  burst(pen, x, y, thick, colours) {
    const share = this.flash.left / FLASH;
    const reach = (0.35 + 0.65 * this.flash.size) * (10 + 26 * (1 - share));
    pen.strokeStyle = colours.kinds[4];
    pen.globalAlpha = share;
    pen.lineWidth = 3;
    pen.beginPath();
    for (const side of [-1, 1])
      for (const lean of [0.35, 1])
        (pen.moveTo(x - 3, y + side * (thick / 2 + 4)),
          pen.lineTo(x - 3 - lean * reach, y + side * (thick / 2 + 4 + reach)));
    pen.stroke();
    pen.globalAlpha = 1;
  }

  words(pen, width, height, colours) {
    pen.font = "12.5px system-ui, sans-serif";
    pen.textAlign = "left";
    const stress = this.motion?.stress_scale_Pa;
    if (!(this.strain > 1e-11)) return; // nothing is strained: at rest, without a load
    const most = stress ? si(this.strain * stress, "Pa", 3) : number(this.strain, 3);
    const y = height - 20;
    const bar = Math.min(120, width * 0.2);
    const long = [`compression −${most}`, `+${most} tension${stress ? "" : " (strain)"}`];
    const room = width - 14 - bar - 2 * 8 - 6;
    const fits = long.reduce((sum, text) => sum + pen.measureText(tr(text)).width, 0) <= room;
    const [from, to] = fits ? long : [`−${most}`, `+${most}${stress ? "" : " strain"}`];
    pen.fillStyle = colours.muted;
    const left = 14 + pen.measureText(tr(from)).width + 8;
    pen.fillText(tr(from), 14, y + 10);
    pen.fillText(tr(to), left + bar + 8, y + 10);
    for (let i = 0; i < bar; i++) {
      pen.fillStyle = signed((2 * i) / bar - 1);
      pen.fillRect(left + i, y, 1.5, 10);
    }
  }
}

/** A bar of which no size is known, before a wall. */
export const PLAIN = { bar: [{ length: 1, thick: 0.16 }], tool: [], held: false, rock: false };

const lengthOf = (sections) => sections.reduce((sum, { length }) => sum + length, 0);

/** The thickness of the bar in `count` equal parts of its length, as shares of the greatest. */
function thicknesses(sections, count) {
  const most = Math.max(...sections.map(({ thick }) => thick));
  return Array.from({ length: count }, (_, j) => {
    let left = ((j + 0.5) / count) * lengthOf(sections);
    const here = sections.find(({ length }) => (left -= length) <= 0) ?? sections.at(-1);
    return here.thick / most;
  });
}
