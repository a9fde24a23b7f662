// The headline while a simulated motion plays: it tells of that motion, and not of the steady one beside it.

import { h } from "../core/dom.js";
import { chosen, data, reasonOf, view } from "../core/state.js";

/** Whether what the page shows is a motion from a start. */
export const plays = () => view.panel === "motion" && view.source === "start" && !data.problems.length;

/** The motion that plays, once it is that of the present case; else null. */
const played = () => (data.played?.change === data.changed ? data.played.motion : null);

/** What of it the headline depends on. */
export const playedKey = () => (plays() ? [true, played()?.label, data.played?.change === data.changed] : [false]);

/** [the kind of the badge, its text, the sentence below it]. */
export function playedVerdict() {
  const motion = played();
  if (!motion) return ["warn", "Simulating …", h("p", { id: "reason" }, "From the start of the case.")];
  const { label } = motion;
  const steady = label.startsWith("z=");
  const sentence = `What plays was found by simulation from the start: ${meaning(label)}. ${beside()}`;
  return [steady ? "good" : "warn", `Plays: ${label}`, h("p", { id: "reason" }, sentence)];
}

/** A label in words. */
function meaning(label) {
  const [head, tail] = label.split(/[=/]/);
  const n = Number(label.split("/")[1] ?? 1);
  const again = tail === "?" ? "after a time that rounding decides" : n === 1 ? "every load period" : `again after ${n} load periods`;
  const words = {
    z: `${tail === "1" ? "one blow" : `${tail} blows`} ${n === 1 ? "every load period" : `in ${n} load periods`}`,
    chatter: `bounces that die out, rest and release, ${again}`,
    rest: label === "rest" ? "the bar comes to rest on the wall and stays there" : `blows, rest and release, ${again}`,
    departed: "the load pulls the bar off the wall for good",
    aperiodic: "its blows never repeat",
  };
  return words[head] ?? "the motion had not repeated when the simulation ended";
}

/** What there is beside it: the steady motion that the other panels tell of. */
function beside() {
  const found = chosen();
  const which = `steady motion with one blow ${view.m === 1 ? "every load period" : `in ${view.m} load periods`}`;
  if (!found) return `There is no ${which}.`;
  if (found.full && !found.full.admissible) return `The ${which} is not possible.`;
  const words = reasonOf(found);
  const verdict = /^(un)?stable/.test(words) ? words : `${found.quick.stable ? "stable" : "unstable"}: ${words}`;
  return `The ${which} is ${verdict}.`;
}

/** Its figures: rows of [name, value, unit]; means over what it settles on. */
export function playedFigures() {
  const summary = played()?.summary;
  if (!summary) return [];
  const { si } = summary;
  if (si)
    return [
      ["mean blow energy", si.blow_energy_J, "J"],
      ["blow rate", si.main_blow_rate_Hz, "Hz"],
      ["mean striking speed", si.impact_velocity_m_s, "m/s"],
      ["delivered power", si.delivered_power_kW === null ? null : si.delivered_power_kW * 1000, "W"],
    ].filter(([, value]) => value !== null && value !== undefined);
  return [
    ["mean blow energy", summary.blow_energy, ""],
    ["mean striking speed", summary.impact_velocity, ""],
    ["blows per load period", summary.main_blow_rate, ""],
  ].filter(([, value]) => value !== null && value !== undefined);
}
