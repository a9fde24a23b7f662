// @ts-check
// The blows of a live motion, each as a short ring at its own moment: those of the next tenth of a second are placed on the
// clock of the audio hardware, so that a frame that comes late moves no blow, and what had been placed is dropped as soon as
// the law of the motion changes, so that a doubling is heard when it comes.

import { LEAST, RING, output, ring, soundOn, strike } from "./sound.js";

/** @typedef {import("./live.js").Live} Live */
/** @typedef {{frequency?: number | null, joule?: number | null}} About pitch in Hz, and J of a unit of energy */

export const SOON = 0.12; // s of sound that are placed before their time
const APART = 0.08; // s by which picture and sound may be apart before the sound begins anew
const LATE = 0.005; // s after its moment at which a blow is still placed

export class LiveTrack {
  /** @param {BaseAudioContext} audio @param {AudioNode} into */
  constructor(audio, into) {
    this.audio = audio;
    this.into = into;
    /** @type {{at: number, time: number, node: AudioNode}[]} */
    this.placed = [];
    this.rate = 0;
    this.zero = 0; // when on the clock the moment 0 of the motion is
    this.changes = -1;
    this.told = -Infinity; // the moment up to which blows are placed
    this.gap = RING; // s between the last two
    /** @type {Live | null} */
    this.live = null;
  }

  /** Seconds by which the motion is behind the sound. @param {Live} live */
  behind(live) {
    return this.live === live && this.rate > 0 ? this.audio.currentTime - this.zero - live.now / this.rate : 0;
  }

  /** Place what comes; called with every frame. @param {Live} live @param {number} rate units of the motion's time that
   * pass in a second @param {About} [about] */
  follow(live, rate, { frequency, joule } = {}) {
    if (!(rate > 0)) return this.silence();
    const now = this.audio.currentTime;
    if (live !== this.live || rate !== this.rate || Math.abs(this.behind(live)) > APART) {
      this.silence();
      Object.assign(this, { live, rate, zero: now - live.now / rate });
    } else if (live.changes !== this.changes) this.silence();
    this.changes = live.changes;
    const next = (now - this.zero + SOON) * rate - live.now;
    const blows = live.ahead(Math.max(next, 0)).filter(({ kind }) => kind === "impact");
    const most = Math.max(...live.blows.map(({ speed }) => speed), ...blows.map(({ speed }) => speed)) ** 2;
    for (const [i, { after, speed, energy }] of blows.entries()) {
      const moment = live.now + after;
      const at = this.zero + moment / rate;
      const share = speed ** 2 / most;
      if (moment <= this.told + 1e-9 * rate || at < now - LATE || share < LEAST) continue;
      const following = blows.slice(i + 1).find((one) => one.speed ** 2 >= LEAST * most);
      if (following) this.gap = (following.after - after) / rate;
      const length = Math.min(RING, Math.max(0.9 * this.gap, 0.02));
      const sounding = ring({ frequency, energy: joule ? energy * joule : null, share });
      this.placed.push({
        at,
        time: moment,
        node: strike(this.audio, this.into, { at: Math.max(at, now), length, ...sounding }),
      });
      this.told = moment;
    }
    if (this.placed.length > 256) this.placed = this.placed.filter((one) => one.at > now - RING);
  }

  /** What has been placed and has not begun is not heard. */
  silence() {
    const now = this.audio.currentTime;
    this.told = -Infinity;
    for (const { at, time, node } of this.placed)
      if (at > now) node.disconnect();
      else this.told = Math.max(this.told, time);
    this.placed = this.placed.filter(({ at }) => at <= now);
  }
}

/** @type {LiveTrack | null} */
let track = null;

/** Sound as a live motion goes on: called with every frame; silent while the user has not asked for it.
 * @param {Live} live @param {number} rate @param {About} [about] @returns {number} seconds by which the motion is behind */
export function followLive(live, rate, about) {
  const out = output();
  if (!soundOn() || out?.context.state !== "running") return 0;
  track ??= new LiveTrack(out.context, out);
  track.follow(live, rate, about);
  return track.behind(live);
}

/** The motion stands still, or has jumped. */
export const hushLive = () => track?.silence();
