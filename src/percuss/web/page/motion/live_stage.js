// A stage whose motion never restarts. While something moves, the hammer goes on under its new law from where it is, in
// closed form (live.js); when all is still and it has settled on the steady motion, the server's exact cycle, with all its
// ringing, takes over at a blow, and the other way round.

import { placeIn, valueIn } from "../core/rising.js";
import { Live } from "./live.js";
import { follow, followLive, hush, lag } from "./sound.js";
import { Stage } from "./stage.js";
import { tr } from "../core/words.js";
import { theme } from "../pictures/colours.js";

/** @typedef {import("./stage.js").Motion} Motion */
/** A steady motion of the server. @typedef {{ phase: number, impact_velocity: number }} Orbit */
/** What was shown at a time. @typedef {{ at: number, gap: number }} Past */

const NEAR = 0.03; // how near the last blow is to the steady motion's, in phase and as a share of its speed
const HAIR = 2e-3; // of the speed: what an unstable motion is disturbed by
const PERIODS = 8; // that the strip shows
const POINTS = 4000;
const TURN = 2 * Math.PI;

/** Another motion beside it, in the same phase of the load: that of a design that is pinned, or looked at on the map. */
class Ghost {
  /** @param {any} model
   * @param {{ phase: number, impact_velocity: number }} orbit @param {number} angle @param {string} name */
  constructor(model, orbit, angle, name) {
    this.name = name;
    this.live = new Live(model);
    this.begun = { gap: 0, velocity: -model.restitution * orbit.impact_velocity, phase: orbit.phase };
    this.live.place(this.begun);
    /** @type {Past[]} */
    this.past = [];
    this.now = 0;
    const before = PERIODS * TURN + ((((angle - orbit.phase) % TURN) + TURN) % TURN);
    for (let i = 0; i < 40 * PERIODS; i++) this.advance(before / (40 * PERIODS));
  }

  /** @param {number} dt */
  advance(dt) {
    for (const { kind, time } of this.live.advance(dt)) {
      if (kind !== "impact") continue;
      const since = this.live.now - time;
      this.past.push({ at: this.now + dt - since, gap: 0 });
      this.live.place(this.begun); // it stays on its motion, stable or not
      this.live.advance(since);
    }
    this.now += dt;
    this.past.push({ at: this.now, gap: this.live.gap });
    if (this.past.length > POINTS) this.past.splice(0, POINTS / 4);
  }
}

export class LiveStage extends Stage {
  /** @param {HTMLCanvasElement} canvas
   * @param {{ ticked: (time: number) => void, struck: (blow: any) => void,
   *   happened?: (event: any) => void }} told as of a stage; `happened` too, for each impact, rest and release */
  constructor(canvas, { happened, ...told }) {
    super(canvas, { ...told, stopped: hush, lag: (stage) => (stage.byFrames ? lag(stage) : stage.behind) });
    this.behind = 0; // s by which the motion is behind its sound
    this.happened = happened;
    /** The motion in closed form. @type {Live | null} */
    this.live = null;
    this.exact = false; // whether the server's frames are what is shown
    /** The steady motion of the present law. @type {any} */
    this.cycle = null;
    this.held = false; // by the hand
    /** Where a hand finds the bar. @type {[number, number] | null} */
    this.edges = null;
    /** @type {Map<string, Ghost>} */
    this.ghosts = new Map();
    /** @type {Past[]} */
    this.past = [];
    this.now = 0; // time since the page was opened, in that of the stage
    this.second = 1; // of the stage, in the time of the model
    this.period = TURN;
  }

  /** Whether what is shown is the server's frames. */
  get byFrames() {
    return this.exact || !this.live;
  }

  /** Each blow heard; `frequency` in Hz, `joule` of a unit of energy.
   * @param {number | null | undefined} frequency @param {number | null | undefined} joule */
  sounds(frequency, joule) {
    if (this.byFrames) follow(this, frequency);
    else if (this.playing && this.live)
      this.behind = followLive(this.live, this.rate * this.second, { frequency, joule });
  }

  get there() {
    return Boolean(this.live || this.motion);
  }

  /** A new law, from the present state on; `from` is the state of another hammer: {gap, velocity, phase}.
   * @param {any} model @param {any} [from] */
  under(model, from) {
    if (!model) return void (this.live = null);
    const present = this.exact && this.motion ? this.stateOfFrame() : null;
    this.cycle = null;
    hush();
    if (!this.live) this.live = new Live(model);
    else this.live.become(model);
    if (from) this.put(from);
    else if (present) this.live.place(present);
    this.exact = false;
    this.heard = [];
    this.deepest ||= 0.3;
    this.draw();
  }

  /** Show another motion beside it, or none. @param {string} name @param {any} [model] @param {any} [orbit] */
  beside(name, model, orbit) {
    if (!model || model.valve || !(orbit?.impact_velocity > 0)) this.ghosts.delete(name);
    else this.ghosts.set(name, new Ghost(model, orbit, this.angleNow(), name));
    this.draw();
  }

  angleNow() {
    if (this.exact && this.motion) return (this.motion.load_phase + this.time) % TURN;
    return this.live ? this.live.angle : 0;
  }

  /** The hammer held in the hand: where it is, until it is let go with the speed of the hand. @param {number} gap */
  hold(gap, velocity = 0) {
    this.put({ gap: Math.min(gap, 0), velocity, phase: this.angleNow() });
  }

  /** Another hammer: what was shown is not of it. */
  forget() {
    this.past = [];
    this.ghosts.clear();
    this.motion = null;
    this.exact = false;
    this.deepest = 0.3;
  }

  /** Put the hammer somewhere. @param {{gap: number, velocity: number, phase?: number}} state */
  put(state) {
    this.exact = false;
    this.live?.place(state);
    if (!this.playing) this.draw();
  }

  /** Let it go from an unstable motion, a hair's breadth aside: it leaves by itself.
   * @param {Orbit} orbit @param {number} restitution */
  leave(orbit, restitution) {
    this.put({ gap: 0, velocity: -restitution * orbit.impact_velocity * (1 + HAIR), phase: orbit.phase });
  }

  /** The exact frames of the steady motion that the present law has; while nothing plays they are shown at once.
   * @param {Motion} motion @param {any} force @param {any} shape @param {any} orbit */
  settle(motion, force, shape, orbit) {
    const time = this.phaseInFrames(motion);
    super.show(motion, force, shape);
    this.comes(time, { phase: orbit.phase, speed: orbit.impact_velocity });
  }

  /** Frames have come of the steady motion that the hammer tends to, at a time of which it is by now.
   * @param {number} time @param {any} cycle */
  comes(time, cycle) {
    this.cycle = cycle;
    this.time = time;
    if (!this.live || !this.playing) this.exact = true;
    this.draw();
  }

  /** Frames as they come, of a motion from a start. @param {Motion} motion @param {any} [force] @param {any} [shape] */
  show(motion, force, shape) {
    this.exact = true;
    this.cycle = null;
    this.live = null;
    super.show(motion, force, shape);
  }

  /** Where in the frames of a steady motion the live one is. @param {Motion} motion @returns {number} */
  phaseInFrames(motion) {
    const { t } = motion.arrays;
    const length = t.at(-1);
    const angle = this.live ? this.live.angle : 0;
    const turn = (((angle - motion.load_phase) % TURN) + TURN) % TURN;
    return length > 0 ? turn % length : 0;
  }

  /** @returns {number} */
  gapOfFrame() {
    return this.stateOfFrame().through;
  }

  /** Gap, velocity and phase of the frame in sight; `through` is the gap also where it is inside the wall.
   * @returns {any} */
  stateOfFrame() {
    const { end_t: t, end_gap: gap, end_velocity: velocity } = this.motion.arrays;
    const at = placeIn(t, this.time);
    const through = valueIn(gap, at);
    return {
      gap: Math.min(through, 0),
      through,
      velocity: valueIn(velocity, at),
      phase: (this.motion.load_phase + this.time) % TURN,
    };
  }

  /** A moment of the steady motion, whose frames are shown. @param {number} time */
  seek(time) {
    if (!this.motion) return;
    this.exact = true;
    super.seek(time);
  }

  /** @param {number} seconds */
  advance(seconds) {
    for (const ghost of this.ghosts.values()) ghost.advance(seconds * this.rate * this.second);
    if (this.held) return this.draw();
    const { live } = this;
    if (this.exact || !live) {
      super.advance(seconds);
      this.now += seconds * this.rate;
      if (this.motion) this.keep(this.gapOfFrame());
      return;
    }
    const dt = seconds * this.rate;
    const before = this.now;
    const events = live.advance(dt * this.second);
    this.now += dt;
    for (const event of events) {
      if (event.kind === "impact") {
        this.past.push({ at: before + Math.min(dt, Math.max(0, dt - (live.now - event.time) / this.second)), gap: 0 });
        this.loudest = Math.max(0.97 * this.loudest, event.energy, 1e-30);
        this.strike(event);
        if (this.settledAt(event)) this.takeOver();
      }
      this.happened?.(event);
    }
    this.keep(this.exact ? 0 : live.gap);
    this.flash.left = Math.max(0, this.flash.left - seconds);
    this.draw();
    this.ticked(this.exact ? this.time : live.angle);
  }

  /** Whether a blow is that of the steady motion whose frames have come. @param {any} blow @returns {boolean} */
  settledAt({ phase, speed }) {
    if (!this.cycle || !this.motion || !this.cycle.speed) return false;
    const turn = Math.abs(phase - this.cycle.phase) % TURN;
    return Math.min(turn, TURN - turn) < NEAR && Math.abs(speed / this.cycle.speed - 1) < NEAR;
  }

  takeOver() {
    hush();
    this.exact = true;
    this.time = this.phaseInFrames(this.motion);
    this.loudest = Math.max(1e-30, ...this.heard.map(({ energy }) => energy ?? 0)); // not a harder blow on the way here
  }

  /** @param {number} gap */
  keep(gap) {
    this.past.push({ at: this.now, gap });
    const deep = Math.max(-gap, 1e-12);
    this.deepest = deep > this.deepest ? deep : this.deepest; // grows at once
    const from = this.now - PERIODS * this.period;
    let gone = Math.max(this.past.length - POINTS, 0);
    while (gone < this.past.length && this.past[gone].at < from) gone += 1;
    if (gone > 64) this.past.splice(0, gone);
  }

  /** Where the parts of the bar are: rigid while the live motion is shown. @param {import("./stage.js").Scale} scale */
  pose(scale) {
    const { live } = this;
    if (this.exact || !live) return super.pose(scale);
    const edge = scale.wall + live.gap * scale.travel;
    const { places } = this;
    const edges = Array.from({ length: places }, (_, j) => edge - (1 - j / (places - 1)) * scale.bar);
    return { edges, shares: Array.from({ length: places - 1 }, () => 0), through: false };
  }

  /** The bar, and those beside it as outlines.
   * @param {CanvasRenderingContext2D} pen @param {import("./stage.js").Pose} pose
   * @param {import("./stage.js").Scale} scale @param {number} mid @param {import("./stage.js").Theme} colours */
  bar(pen, pose, scale, mid, colours) {
    super.bar(pen, pose, scale, mid, colours);
    this.edges = [pose.edges[0], pose.edges[pose.edges.length - 1]];
    pen.setLineDash([5, 4]);
    pen.lineWidth = 1.4;
    for (const { live, name } of this.ghosts.values()) {
      const edge = scale.wall + live.gap * scale.travel;
      pen.strokeStyle = name === "A" ? colours.accent : colours.muted;
      pen.strokeRect(edge - scale.bar, mid - scale.thick / 2 - 5, scale.bar, scale.thick + 10);
      pen.fillStyle = pen.strokeStyle;
      pen.fillText(
        tr(name),
        edge - scale.bar + 6,
        name === "A" ? mid - scale.thick / 2 - 9 : mid + scale.thick / 2 + 18,
      );
    }
    pen.setLineDash([]);
  }

  phaseOfLoad() {
    return this.exact || !this.live ? super.phaseOfLoad() : this.live.angle;
  }
}

/** The bar taken by the hand, and let go. @param {LiveStage} stage */
export function grab(stage) {
  const { canvas } = stage;
  /** Where the hand was, how far from the striking end it has the bar, and its speed.
   * @type {{ x: number, when: number, offset: number, speed: number } | null} */
  let last = null;
  const at = (/** @type {PointerEvent} */ event) => {
    const box = canvas.getBoundingClientRect();
    const k = theme().scale;
    const scale = stage.scales(box.width / k, box.height / k);
    return { x: (event.clientX - box.left) / k, scale, when: performance.now() };
  };
  const gapOf = (/** @type {ReturnType<typeof at>} */ { x, scale }, /** @type {number} */ offset) =>
    (x - offset - scale.wall) / scale.travel;
  canvas.addEventListener("pointerdown", (event) => {
    if (!stage.live || !stage.edges) return;
    const { x, when } = at(event);
    const [left, right] = stage.edges;
    if (x < left - 6 || x > right + 6) return;
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    last = { x, when, offset: x - right, speed: 0 };
    stage.held = true;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    const now = at(event);
    const gone = Math.max((now.when - last.when) / 1000, 1e-3) * stage.rate;
    const speed = Math.min(Math.max((now.x - last.x) / now.scale.travel / gone, -1), 1);
    stage.hold(gapOf(now, last.offset));
    last = { x: now.x, when: now.when, offset: last.offset, speed };
  });
  for (const end of /** @type {const} */ (["pointerup", "pointercancel"]))
    canvas.addEventListener(end, (event) => {
      if (!last) return;
      stage.held = false;
      stage.hold(gapOf(at(event), last.offset), last.speed);
      last = null;
    });
}
