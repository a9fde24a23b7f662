// The headline of a machine that switches itself: whether it runs, with what, or what keeps it from running.

import { h } from "../core/dom.js";
import { data } from "../core/state.js";

/** What of it the headline depends on. */
export const machineKey = () => [data.machine?.changed, data.machine?.modes, Boolean(data.machine?.more)];

/** [the kind of the badge, its text, the sentence below it]. */
export function machineVerdict() {
  const { runs, answer, sentence } = data.machine;
  const text = `${answer.outcome[0].toUpperCase()}${answer.outcome.slice(1)}${runs || !answer.label ? "" : `, ${answer.label}`}`;
  return [runs ? "good" : "bad", text, h("p", { id: "reason" }, runs ? running(data.machine) : sentence)];
}

/** A running machine in a sentence or two. */
function running({ settles, more }) {
  const stable = `One blow a cycle, switched by the piston. Stable: ${settles}.`;
  if (!more) return stable;
  const known = more.uncertainty ? ` ${more.uncertainty.sentence}` : "";
  return `${stable}${known} ${more.starts_from_rest ? "It starts from rest on the tool." : "It does not start from rest on the tool: it must be pushed off."}`;
}

/** Its figures: rows of [name, value, unit]. */
export function machineFigures() {
  const { answer } = data.machine;
  const { si, blows } = answer;
  if (!answer.period) return [];
  if (si)
    return [
      ["blow energy", si.blow_energy_J, "J"],
      ["blow rate", si.blow_rate_Hz, "Hz"],
      ["blows a minute", si.blow_rate_per_min, ""],
      ["striking speed", si.impact_velocity_m_s, "m/s"],
      ["stroke", 1e3 * si.stroke_m, "mm"],
      ["oil flow", si.oil_flow_l_per_min, "l/min"],
      ["delivered power", si.delivered_power_kW * 1000, "W"],
    ].filter(([, value]) => value !== null);
  return [
    ["blow energy", Math.max(...blows.map((blow) => blow.energy)), ""],
    ["striking speed", Math.max(...blows.map((blow) => blow.speed)), ""],
    ["period", answer.period, ""],
    ["stroke", answer.stroke, ""],
    ["share of the power stroke", answer.duty, ""],
  ];
}
