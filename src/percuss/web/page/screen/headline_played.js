// The headline while a simulated motion plays: it tells of that motion, and not of the steady one beside it.

import { chosen, data, reasonOf, view } from "../core/state.js";

/** Whether what the page shows is a motion from a start. */
export const plays = () => view.source === "start" && view.panel !== "blow";

/** How often, in load periods. @param {number} n */
export const every = (n) => (n === 1 ? "every load period" : `in ${n} load periods`);

/** @returns {import("./headline.js").Told} */
export function playedTold() {
  const motion = data.played?.change === data.changed ? data.played.motion : null; // once it is of the present case
  if (!motion) return { kind: "warn", text: "Simulating …", words: "From the start of the case." };
  const { label, summary } = motion;
  return {
    kind: label.startsWith("z=") ? "good" : "warn",
    text: `Plays: ${label}`,
    words: `What plays was found by simulation from the start: ${meaning(label)}. ${beside()}`,
    figures: figures(summary),
  };
}

/** A label in words. @param {string} label */
function meaning(label) {
  const [head, tail] = label.split(/[=/]/);
  const n = Number(label.split("/")[1] ?? 1);
  const again =
    tail === "?"
      ? "after a time that rounding decides"
      : n === 1
        ? "every load period"
        : `again after ${n} load periods`;
  /** @type {Record<string, string>} */
  const words = {
    z: `${tail === "1" ? "one blow" : `${tail} blows`} ${every(n)}`,
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
  const which = `steady motion with one blow ${every(view.m)}`;
  if (!found) return `There is no ${which}.`;
  if (found.full && !found.full.admissible) return `The ${which} is not possible.`;
  const words = reasonOf(found);
  const verdict = /^(un)?stable/.test(words) ? words : `${found.quick.stable ? "stable" : "unstable"}: ${words}`;
  return `The ${which} is ${verdict}.`;
}

/** Means over what it settles on. @param {Record<string, any>} [summary] */
function figures(summary) {
  const { si, blow_energy, impact_velocity, main_blow_rate } = summary ?? {};
  /** @type {import("./headline.js").Figure[]} */
  const found = si
    ? [
        ["mean blow energy", si.blow_energy_J, "J"],
        ["blow rate", si.main_blow_rate_Hz, "Hz"],
        ["mean striking speed", si.impact_velocity_m_s, "m/s"],
        ["delivered power", si.delivered_power_kW && si.delivered_power_kW * 1000, "W"],
      ]
    : [
        ["mean blow energy", blow_energy, ""],
        ["mean striking speed", impact_velocity, ""],
        ["blows per load period", main_blow_rate, ""],
      ];
  return found.filter(([, value]) => value !== null && value !== undefined);
}
