// Each blow as a short ring at its own moment. Blows are placed on the clock of the audio hardware some tenths of a
// second ahead, from the times that the server gave: when a frame of the screen happens to be drawn does not matter.
// Nothing sounds until the user has asked for it.

import { number, si } from "../core/format.js";

let wanted = false;
/** Where blows go while sound is on, to measure what is heard: a limiter. @type {AudioNode | null} */
let out = null;
/** @type {Track | null} */
let track = null;
/** @type {LiveTrack | null} */
let liveTrack = null;

export const AHEAD = 0.4; // s of sound that are placed before their time; a busy page may be late by that much

export const soundOn = () => wanted;

/** @param {boolean} on */
export async function setSound(on) {
  wanted = on;
  if (!on) {
    hush();
    return /** @type {AudioContext | undefined} */ (out?.context)?.suspend();
  }
  if (!out) {
    out = limited(new AudioContext());
    track = new Track(out.context, out);
  }
  return /** @type {AudioContext} */ (out.context).resume();
}

/** Where blows go in a context: a limiter, which leaves all but the sum of many blows as it is.
 * @param {BaseAudioContext} audio */
export function limited(audio) {
  const limiter = audio.createDynamicsCompressor();
  for (const [name, value] of Object.entries({ threshold: -3, knee: 0, ratio: 20, attack: 0.001, release: 0.05 }))
    /** @type {Record<string, any>} */ (limiter)[name].value = value;
  limiter.connect(audio.destination);
  return limiter;
}

const AUDIBLE = [120, 9000]; // Hz
const PLAIN = 520; // Hz, for a case without seconds
const RING = 0.28; // s
const SAME = 0.99; // share of the strongest blow's energy from which on a blow counts as one of the strongest
const APART = 10; // dB by which any weaker blow is softer: a tenth less energy would not be heard
const FOURTH = 5; // semitones by which it is lower
const LEAST = 1e-3; // share of the energy below which a blow is not heard

/** How a blow sounds: pitch in Hz and loudness 0 to 1; `clipped` says which way the mode itself cannot be heard.
 * `frequency` is that of the first mode in Hz, `energy` in J where there is one, `share` of the strongest blow's.
 * @param {{ frequency?: number | null, energy?: number | null, share: number }} blow */
export function ring({ frequency, energy, share }) {
  const mode = frequency ?? PLAIN;
  const base = Math.min(Math.max(mode, AUDIBLE[0]), AUDIBLE[1]);
  const size = energy === null || energy === undefined ? 0.5 : Math.min(1, 0.25 + 0.15 * Math.log10(1 + energy));
  const less = share >= SAME ? 0 : 1 - Math.max(share, 0);
  const weaker = less ? APART + 30 * less : 0; // dB
  const pitch = base * 2 ** (-(less ? FOURTH + 7 * less : 0) / 12);
  return {
    pitch,
    loudness: size * 10 ** (-weaker / 20),
    clipped: base > mode ? "low" : base < mode ? "high" : "",
    mode,
  };
}

/** How a blow sounds, in words. @param {Parameters<typeof ring>[0]} about */
export function heardAs(about) {
  const { pitch, loudness, clipped, mode } = ring(about);
  const words = `${si(pitch, "Hz", 3)}, ${number(100 * loudness, 2)} %`;
  return clipped ? `${words}; the first mode, ${si(mode, "Hz", 3)}, is too ${clipped} to hear` : words;
}

const LATE = 0.005; // s after its moment at which a blow is still placed

/** Blows on the clock of an audio context. */
class Clock {
  /** @param {BaseAudioContext} audio @param {AudioNode} into */
  constructor(audio, into) {
    this.audio = audio;
    this.into = into;
    /** Those that are placed: when they sound, and at which moment of the motion.
     * @type {{ at: number, time: number, node: AudioNode }[]} */
    this.placed = [];
  }

  /** Place one; the next follows it by `gap`, so that those which follow fast are kept apart.
   * @param {number} at @param {number} gap @param {Parameters<typeof ring>[0]} about @param {number} time */
  place(at, gap, about, time) {
    const now = this.audio.currentTime;
    const length = Math.min(RING, Math.max(0.9 * gap, 0.02));
    const node = strike(this.audio, this.into, { at: Math.max(at, now), length, ...ring(about) });
    this.placed.push({ at, time, node });
    if (this.placed.length > 512) this.placed = this.placed.filter((one) => one.at > now - RING);
  }

  /** What has been placed and has not begun is not heard. */
  silence() {
    const now = this.audio.currentTime;
    for (const { at, node } of this.placed) if (at > now) node.disconnect();
    this.placed = this.placed.filter(({ at }) => at <= now);
  }
}

/** The blows of a motion, told over and over. */
export class Track extends Clock {
  /** @param {BaseAudioContext} audio @param {AudioNode} into */
  constructor(audio, into) {
    super(audio, into);
    /** @type {{ time: number, energy?: number | null, share: number }[]} */
    this.blows = [];
    /** The frames that its blows are of. @type {any} */
    this.motion = null;
    /** @type {number | null | undefined} */
    this.frequency = null;
    this.length = this.rate = this.time = this.at = this.turn = this.next = 0;
  }

  /** What is played: `blows` in order of time, `length` in the same unit, `frequency` in Hz.
   * @param {{ blows: Track["blows"], length: number, frequency?: number | null }} what */
  load({ blows, length, frequency }) {
    this.silence();
    this.blows = blows.filter(({ share }) => share >= LEAST);
    Object.assign(this, { length, frequency });
  }

  /** From now on: the moment `time` of the motion is at `at` of the clock, and `rate` of its unit pass in a second.
   * @param {number} time @param {number} rate @param {number} at */
  from(time, rate, at) {
    this.silence();
    Object.assign(this, { time, rate, at, turn: 0, next: 0 });
    while (this.next < this.blows.length && this.blows[this.next].time < time - 1e-9) this.next += 1;
  }

  /** The moment of the motion that is heard at a time of the clock. @param {number} at */
  moment(at) {
    return this.length > 0 ? (this.time + (at - this.at) * this.rate) % this.length : 0;
  }

  /** When a blow sounds: the one after the last of a turn is the first of the next.
   * @param {number} turn @param {number} index */
  when(turn, index) {
    const [more, i] = [Math.floor(index / this.blows.length), index % this.blows.length];
    return this.at + ((turn + more) * this.length + this.blows[i].time - this.time) / this.rate;
  }

  /** Place every blow that sounds before `until`. @param {number} until */
  ahead(until) {
    if (!this.blows.length || !(this.rate > 0) || !(this.length > 0)) return;
    for (;;) {
      const at = this.when(this.turn, this.next);
      if (at >= until) return;
      const { time, energy, share } = this.blows[this.next % this.blows.length];
      const gap = this.when(this.turn, this.next + 1) - at;
      if (at >= this.audio.currentTime - LATE) this.place(at, gap, { frequency: this.frequency, energy, share }, time);
      this.next += 1;
      if (this.next >= this.blows.length) [this.turn, this.next] = [this.turn + 1, this.next - this.blows.length];
    }
  }

  silence() {
    super.silence();
    this.rate = 0;
  }
}

/** @typedef {import("./live.js").Live} Live */
/** @typedef {{frequency?: number | null, joule?: number | null}} About pitch in Hz, and J of a unit of energy */

const SOON = 0.12; // s of sound that are placed before their time
const ANEW = 0.08; // s by which picture and sound may be apart before the sound begins anew

/** The blows of a live motion: those of the next tenth of a second are placed, so that a late frame moves none, and are
 * dropped as soon as the law of the motion changes, so that a doubling is heard when it comes. */
export class LiveTrack extends Clock {
  /** @param {BaseAudioContext} audio @param {AudioNode} into */
  constructor(audio, into) {
    super(audio, into);
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
    if (live !== this.live || rate !== this.rate || Math.abs(this.behind(live)) > ANEW) {
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
      this.place(at, this.gap, { frequency, energy: joule ? energy * joule : null, share }, moment);
      this.told = moment;
    }
  }

  silence() {
    super.silence();
    this.told = Math.max(-Infinity, ...this.placed.map(({ time }) => time));
  }
}

/** Sound as the stage plays: called with every frame. It begins anew only when the motion or its pace is another one;
 * the picture follows the sound, and not the other way round (`lag`).
 * @param {import("./stage.js").Stage} stage @param {number | null | undefined} frequency */
export function follow(stage, frequency) {
  if (!wanted || !track || track.audio.state !== "running" || !stage.playing) return;
  if (track.motion !== stage.motion || track.length !== stage.length) {
    const blows = stage.heard.map((blow) => ({ time: blow.time, energy: blow.energy_J, share: stage.share(blow) }));
    track.load({ blows, length: stage.length, frequency });
    track.motion = stage.motion;
  }
  const now = track.audio.currentTime;
  if (track.rate !== stage.rate) track.from(stage.time, stage.rate, now);
  track.ahead(now + AHEAD);
}

/** Seconds by which the picture is behind the sound; 0 without sound. @param {import("./stage.js").Stage} stage */
export function lag(stage) {
  if (!wanted || !track || track.audio.state !== "running") return 0;
  if (track.motion !== stage.motion || track.rate !== stage.rate) return 0;
  const apart = track.moment(track.audio.currentTime) - stage.time;
  return (apart - stage.length * Math.round(apart / stage.length)) / stage.rate; // a motion begins again at its end
}

/** Sound as a live motion goes on: called with every frame; silent while the user has not asked for it.
 * @param {Live} live
 * @param {number} rate @param {About} [about] @returns {number} seconds by which the motion is behind */
export function followLive(live, rate, about) {
  if (!wanted || out?.context.state !== "running") return 0;
  liveTrack ??= new LiveTrack(out.context, out);
  liveTrack.follow(live, rate, about);
  return liveTrack.behind(live);
}

/** The play has stopped, or jumped. */
export function hush() {
  track?.silence();
  liveTrack?.silence();
}

/** One blow into a node of an audio context, at a time of it; the node that is its volume.
 * @param {BaseAudioContext} audio @param {AudioNode} into
 * @param {{ at: number, pitch: number, loudness: number, length?: number }} blow */
export function strike(audio, into, { at, pitch, loudness, length = RING }) {
  const gain = audio.createGain();
  gain.connect(into);
  gain.gain.setValueAtTime(0, at);
  gain.gain.linearRampToValueAtTime(0.3 * loudness, at + 0.002); // a single blow stays below the limiter
  gain.gain.exponentialRampToValueAtTime(0.0004 * loudness, at + length);
  for (const [i, share] of [1, 0.35, 0.15].entries()) {
    const part = i + 1;
    if (pitch * part > 16000) continue;
    const level = audio.createGain();
    level.gain.value = share;
    level.connect(gain);
    sound(audio, level, at, length + 0.02).frequency.value = pitch * part;
  }
  const body = audio.createGain(); // the push of the blow itself: a small loudspeaker tells it from a whistle
  body.gain.setValueAtTime(0.6, at);
  body.gain.exponentialRampToValueAtTime(0.001, at + Math.min(0.12, length));
  body.connect(gain);
  const thud = sound(audio, body, at, Math.min(0.13, length)).frequency;
  thud.setValueAtTime(150, at);
  thud.exponentialRampToValueAtTime(50, at + 0.09);
  return gain;
}

/** @param {BaseAudioContext} audio @param {AudioNode} into @param {number} at @param {number} length */
function sound(audio, into, at, length) {
  const tone = audio.createOscillator();
  tone.connect(into);
  tone.start(at);
  tone.stop(at + length);
  return tone;
}
