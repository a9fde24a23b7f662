// Each blow as a short ring: its pitch is the first elastic mode of the bar, its loudness grows with the blow energy.
// Nothing sounds until the user has asked for it.

let context = null;
let wanted = false;
let out = null;
let last = -1; // when the last blow sounds, s of the context

export const soundOn = () => wanted;

export async function setSound(on) {
  wanted = on;
  if (!on) return context?.suspend();
  if (!context) {
    context = new AudioContext();
    out = limited(context);
  }
  last = -1;
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
const RING = 0.28; // s

/** How a blow sounds: frequency in Hz, loudness 0 to 1. `energy` in J where there is one; `share` of the strongest. */
export function ring({ frequency, energy, share }) {
  const pitch = Math.min(Math.max(frequency ?? PLAIN, AUDIBLE[0]), AUDIBLE[1]);
  const size = energy === null || energy === undefined ? 0.5 : Math.min(1, 0.25 + 0.15 * Math.log10(1 + energy));
  const part = Math.min(Math.max(share, 0), 1) ** 4; // a tenth less energy is not heard; a third less sound is
  return { pitch, loudness: size * (0.08 + 0.92 * part) };
}

/** Let it sound `delay` seconds from now; returns how, also when sound is off, so that it can be shown. */
export function blow(about) {
  const { pitch, loudness } = ring(about);
  if (wanted && context?.state === "running") {
    const at = context.currentTime + Math.max(about.delay ?? 0, 0);
    const gap = last < 0 || at <= last ? RING : at - last; // blows that follow fast are kept apart
    last = at;
    strike(context, out, { at, pitch, loudness, length: Math.min(RING, Math.max(0.9 * gap, 0.02)) });
  }
  return { pitch, loudness };
}

/** One blow into a node of an audio context, at a time of it. */
export function strike(audio, into, { at, pitch, loudness, length = RING }) {
  const gain = audio.createGain();
  gain.connect(into);
  gain.gain.setValueAtTime(0, at);
  gain.gain.linearRampToValueAtTime(0.5 * loudness, at + 0.002);
  gain.gain.exponentialRampToValueAtTime(0.0004, at + length);
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
}

function sound(audio, into, at, length) {
  const tone = audio.createOscillator();
  tone.connect(into);
  tone.start(at);
  tone.stop(at + length);
  return tone;
}
