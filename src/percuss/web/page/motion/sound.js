// Each blow as a short ring at its own moment. Blows are placed on the clock of the audio hardware some tenths of a
// second ahead, from the times that the server gave: when a frame of the screen happens to be drawn does not matter.
// Nothing sounds until the user has asked for it.

import { number, si } from "../core/format.js";

let context = null;
let wanted = false;
let out = null;
let track = null;

export const AHEAD = 0.4; // s of sound that are placed before their time; a busy page may be late by that much

export const soundOn = () => wanted;

export async function setSound(on) {
  wanted = on;
  if (!on) {
    track?.silence();
    return context?.suspend();
  }
  if (!context) {
    context = new AudioContext();
    out = limited(context);
    track = new Track(context, out);
  }
  return context.resume();
}

/** Where blows go in a context: a limiter, which leaves all but the sum of many blows as it is. */
export function limited(audio) {
  const limiter = audio.createDynamicsCompressor();
  for (const [name, value] of Object.entries({ threshold: -3, knee: 0, ratio: 20, attack: 0.001, release: 0.05 }))
    limiter[name].value = value;
  limiter.connect(audio.destination);
  return limiter;
}

/** The limiter while sound is on, to measure what is heard. */
export const output = () => out;

const AUDIBLE = [120, 9000]; // Hz
const PLAIN = 520; // Hz, for a case without seconds
export const RING = 0.28; // s
const SAME = 0.99; // share of the strongest blow's energy from which on a blow counts as one of the strongest
const APART = 10; // dB by which any weaker blow is softer: a tenth less energy would not be heard
const FOURTH = 5; // semitones by which it is lower
export const LEAST = 1e-3; // share of the energy below which a blow is not heard

/** How a blow sounds: pitch in Hz and loudness 0 to 1; `clipped` says which way the mode itself cannot be heard.
 * `frequency` is that of the first mode in Hz, `energy` in J where there is one, `share` of the strongest blow's. */
export function ring({ frequency, energy, share }) {
  const mode = frequency ?? PLAIN;
  const base = Math.min(Math.max(mode, AUDIBLE[0]), AUDIBLE[1]);
  const size = energy === null || energy === undefined ? 0.5 : Math.min(1, 0.25 + 0.15 * Math.log10(1 + energy));
  const less = share >= SAME ? 0 : 1 - Math.max(share, 0);
  const weaker = less ? APART + 30 * less : 0; // dB
  const pitch = base * 2 ** (-(less ? FOURTH + 7 * less : 0) / 12);
  return { pitch, loudness: size * 10 ** (-weaker / 20), clipped: base > mode ? "low" : base < mode ? "high" : "", mode };
}

/** How a blow sounds, in words. */
export function heardAs(about) {
  const { pitch, loudness, clipped, mode } = ring(about);
  const words = `${si(pitch, "Hz", 3)}, ${number(100 * loudness, 2)} %`;
  return clipped ? `${words}; the first mode, ${si(mode, "Hz", 3)}, is too ${clipped} to hear` : words;
}

/** The blows of a motion, told over and over, on the clock of an audio context. */
export class Track {
  constructor(audio, into) {
    Object.assign(this, { audio, into, blows: [], length: 0, rate: 0, placed: [] });
  }

  /** What is played: `blows` {time, energy, share} in order of time, `length` in the same unit, `frequency` in Hz. */
  load({ blows, length, frequency }) {
    this.silence();
    this.blows = blows.filter(({ share }) => share >= LEAST);
    Object.assign(this, { length, frequency });
  }

  /** From now on: the moment `time` of the motion is at `at` of the clock, and `rate` of its unit pass in a second. */
  from(time, rate, at) {
    this.silence();
    Object.assign(this, { time, rate, at, turn: 0, next: 0 });
    while (this.next < this.blows.length && this.blows[this.next].time < time - 1e-9) this.next += 1;
  }

  /** The moment of the motion that is heard at a time of the clock. */
  moment(at) {
    return this.length > 0 ? (this.time + (at - this.at) * this.rate) % this.length : 0;
  }

  /** When a blow sounds: the one after the last of a turn is the first of the next. */
  when(turn, index) {
    const [more, i] = [Math.floor(index / this.blows.length), index % this.blows.length];
    return this.at + ((turn + more) * this.length + this.blows[i].time - this.time) / this.rate;
  }

  /** Place every blow that sounds before `until`. */
  ahead(until) {
    if (!this.blows.length || !(this.rate > 0) || !(this.length > 0)) return;
    for (;;) {
      const at = this.when(this.turn, this.next);
      if (at >= until) return;
      const index = this.next % this.blows.length;
      const gap = this.when(this.turn, this.next + 1) - at; // blows that follow fast are kept apart
      const { energy, share } = this.blows[index];
      const sounding = ring({ frequency: this.frequency, energy, share });
      if (at >= this.audio.currentTime - 0.005) {
        const length = Math.min(RING, Math.max(0.9 * gap, 0.02));
        this.placed.push({ at, node: strike(this.audio, this.into, { at, length, ...sounding }) });
      }
      this.next += 1;
      if (this.next >= this.blows.length) [this.turn, this.next] = [this.turn + 1, this.next - this.blows.length];
      if (this.placed.length > 512) this.placed = this.placed.filter((one) => one.at > this.audio.currentTime - RING);
    }
  }

  /** What has been placed and has not begun is not heard. */
  silence() {
    for (const { at, node } of this.placed) if (at > this.audio.currentTime) node.disconnect();
    this.placed = [];
    this.rate = 0;
  }
}

/** Sound as the stage plays: called with every frame. It begins anew only when the motion or its pace is another one;
 * the picture follows the sound, and not the other way round (`lag`). */
export function follow(stage, frequency) {
  if (!wanted || context?.state !== "running" || !stage.playing) return;
  if (track.motion !== stage.motion || track.length !== stage.length) {
    const blows = stage.heard.map((blow) => ({ ...blow, energy: blow.energy_J, share: stage.share(blow) }));
    track.load({ blows, length: stage.length, frequency });
    track.motion = stage.motion;
  }
  const now = context.currentTime;
  if (track.rate !== stage.rate) track.from(stage.time, stage.rate, now);
  track.ahead(now + AHEAD);
}

/** Seconds by which the picture is behind the sound; 0 without sound. */
export function lag(stage) {
  const together = wanted && context?.state === "running" && track.motion === stage.motion && track.rate === stage.rate;
  if (!together) return 0;
  const apart = track.moment(context.currentTime) - stage.time;
  return (apart - stage.length * Math.round(apart / stage.length)) / stage.rate; // a motion begins again at its end
}

/** The play has stopped, or jumped. */
export const hush = () => track?.silence();

/** One blow into a node of an audio context, at a time of it; the node that is its volume. */
export function strike(audio, into, { at, pitch, loudness, length = RING }) {
  const gain = audio.createGain();
  gain.connect(into);
  gain.gain.setValueAtTime(0, at);
  gain.gain.linearRampToValueAtTime(0.3 * loudness, at + 0.002); // a single blow stays below the limiter
  gain.gain.exponentialRampToValueAtTime(0.0004 * loudness, at + length);
  for (const [part, share] of [
    [1, 1],
    [2, 0.35],
    [3, 0.15],
  ]) {
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

function sound(audio, into, at, length) {
  const tone = audio.createOscillator();
  tone.connect(into);
  tone.start(at);
  tone.stop(at + length);
  return tone;
}
