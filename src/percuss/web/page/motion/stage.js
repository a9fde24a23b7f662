// The bar in motion, drawn anew for every frame of the screen from the frames that the server computed.
// Stroke and strain differ by orders of magnitude, so each is drawn on its own scale, and the scales are told.

import { signed, theme } from "../pictures/colours.js";
import { number, si } from "../core/format.js";

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
    new ResizeObserver(([{ contentRect }]) => {
      this.box = [contentRect.width, contentRect.height];
      this.draw();
    }).observe(canvas);
  }

  /** `sections` are those of a bar with sizes, drawn to scale; without them it has one thickness. */
  show(motion, force, sections) {
    const { arrays } = motion;
    this.shares = thicknesses(sections ?? [], arrays.x.length - 1);
    this.motion = motion;
    this.force = force;
    this.length = arrays.t.at(-1); // the frames may cover only the first part of the stretch
    this.places = arrays.x.length;
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

  play() {
    if (this.playing || !this.motion) return;
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

  /** Scales of the drawing: pixels for a bar length, for its travel and for its stretch. */
  scales(width) {
    const wall = width - 56;
    const travel = 0.36 * wall;
    const bar = 0.5 * wall;
    const rigid = this.motion.modes === 0 || this.strain < 1e-11; // what is left then is the rounding of the numbers on their way here
    return { wall, bar, travel: travel / this.deepest, stretch: rigid ? 0 : (0.07 * bar * this.grow) / this.stretch };
  }

  /** How much larger than the bar its travel and its stretch are drawn, in words. */
  magnified() {
    const { bar, travel, stretch } = this.scales(1000);
    const stretched = stretch ? `, stretch ×${number(stretch / bar, 2)}` : "; nothing is stretched";
    return `travel drawn ×${number(travel / bar, 2)}${stretched} on its own scale`;
  }

  draw() {
    const { canvas, motion } = this;
    const [width, height] = this.box;
    if (!motion || !width || !height) return;
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
    const scale = this.scales(width);
    const { places } = this;
    const { t, displacement, strain } = this.motion.arrays;
    const at = this.frame(t);
    const mid = height * 0.47;
    const thick = Math.min(height * 0.34, scale.bar * 0.2);
    this.wall(pen, scale.wall, height, colours);
    const value = (list, j) => {
      const a = list[at.i * places + j];
      return a + at.share * (list[at.next * places + j] - a);
    };
    const end = value(displacement, places - 1);
    const edge = scale.wall + end * scale.travel;
    const put = (j) => edge - (1 - j / (places - 1)) * scale.bar + (value(displacement, j) - end) * scale.stretch;
    let left = put(0);
    const edges = [left];
    for (let j = 0; j < places - 1; j++) {
      const right = put(j + 1);
      const share = (value(strain, j) + value(strain, j + 1)) / (2 * this.strain);
      pen.fillStyle = signed(share);
      const swell = thick * this.shares[j] * (1 - 0.06 * share);
      pen.fillRect(left - 0.4, mid - swell / 2, right - left + 0.8, swell);
      edges.push((left = right));
    }
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.2;
    for (let j = 0, from = 0; j < places - 1; j++) {
      if (this.shares[j] === this.shares[j + 1]) continue; // the outline goes on
      const tall = thick * this.shares[j];
      pen.strokeRect(edges[from], mid - tall / 2, edges[j + 1] - edges[from], tall);
      from = j + 1;
    }
    this.push(pen, edges[0], mid, colours);
    if (this.flash.left > 0) this.burst(pen, scale.wall, mid, thick, colours);
    this.words(pen, width, height, colours);
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

  /** The load on the driven end: an arrow, to the right when it pushes. */
  push(pen, x, y, colours) {
    if (!this.force) return;
    const value = this.force(this.motion.load_phase + this.time);
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
    const stress = this.motion.stress_scale_Pa;
    if (this.strain < 1e-11) return; // nothing is strained: at rest, without a load
    const most = stress ? si(this.strain * stress, "Pa", 3) : number(this.strain, 3);
    const y = height - 20;
    const bar = Math.min(120, width * 0.2);
    const long = [`compression −${most}`, `+${most} tension${stress ? "" : " (strain)"}`];
    const room = width - 14 - bar - 2 * 8 - 6;
    const fits = long.reduce((sum, text) => sum + pen.measureText(text).width, 0) <= room;
    const [from, to] = fits ? long : [`−${most}`, `+${most}${stress ? "" : " strain"}`];
    pen.fillStyle = colours.muted;
    const left = 14 + pen.measureText(from).width + 8;
    pen.fillText(from, 14, y + 10);
    pen.fillText(to, left + bar + 8, y + 10);
    for (let i = 0; i < bar; i++) {
      pen.fillStyle = signed((2 * i) / bar - 1);
      pen.fillRect(left + i, y, 1.5, 10);
    }
  }
}

/** The thickness of the bar in `count` equal parts of its length, as shares of the greatest. */
function thicknesses(sections, count) {
  const length = sections.reduce((sum, { length_m: own }) => sum + own, 0);
  const most = Math.max(...sections.map(({ diameter_m: own }) => own));
  return Array.from({ length: count }, (_, j) => {
    let left = ((j + 0.5) / count) * length;
    const here = sections.find(({ length_m: own }) => (left -= own) <= 0) ?? sections.at(-1);
    return here ? here.diameter_m / most : 1;
  });
}
