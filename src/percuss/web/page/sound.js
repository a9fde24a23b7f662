// Each blow as a short ring: its pitch is the first elastic mode of the bar, its loudness grows with the blow energy.
// Nothing sounds until the user has asked for it.

let context = null;
let wanted = false;
let out = null;

export const soundOn = () => wanted;

export async function setSound(on) {
  wanted = on;
  if (!on) return context?.suspend();
  if (!context) {
    context = new AudioContext();
    out = context.createDynamicsCompressor();
    out.connect(context.destination);
  }
  return context.resume();
}

const AUDIBLE = [120, 9000]; // Hz
const PLAIN = 520; // Hz, for a case without seconds

/** How a blow sounds: frequency in Hz, loudness 0 to 1. Energy in J where there is one, else its share of the strongest. */
export function ring({ frequency, energy, share }) {
  const pitch = Math.min(Math.max(frequency ?? PLAIN, AUDIBLE[0]), AUDIBLE[1]);
  const size = energy === null || energy === undefined ? 0.5 : Math.min(1, 0.25 + 0.15 * Math.log10(1 + energy));
  return { pitch, loudness: size * (0.08 + 0.92 * Math.min(Math.max(share, 0), 1)) };
}

/** Let it sound; returns how, also when sound is off, so that it can be shown. */
export function blow(about) {
  const { pitch, loudness } = ring(about);
  if (wanted && context?.state === "running") strike(pitch, loudness);
  return { pitch, loudness };
}

function strike(pitch, loudness) {
  const now = context.currentTime;
  const gain = context.createGain();
  gain.connect(out);
  gain.gain.setValueAtTime(0, now);
  gain.gain.linearRampToValueAtTime(0.6 * loudness, now + 0.002);
  gain.gain.exponentialRampToValueAtTime(0.0004, now + 0.28);
  for (const [part, share] of [
    [1, 1],
    [2, 0.35],
    [3, 0.15],
  ]) {
    if (pitch * part > 16000) continue;
    const tone = context.createOscillator();
    const level = context.createGain();
    level.gain.value = share;
    tone.frequency.value = pitch * part;
    tone.connect(level).connect(gain);
    tone.start(now);
    tone.stop(now + 0.3);
  }
  const thud = context.createOscillator(); // the push of the blow itself, so that a small loudspeaker tells it from a whistle
  const body = context.createGain();
  thud.frequency.setValueAtTime(150, now);
  thud.frequency.exponentialRampToValueAtTime(50, now + 0.09);
  body.gain.setValueAtTime(0.9, now);
  body.gain.exponentialRampToValueAtTime(0.001, now + 0.12);
  thud.connect(body).connect(gain);
  thud.start(now);
  thud.stop(now + 0.13);
}
