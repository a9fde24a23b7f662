// The headline of a machine that switches itself: whether it runs, with what, or what keeps it from running.

import { intoRock } from "./headline.js";

/** @param {Record<string, any>} machine @returns {import("./headline.js").Told} */
export function machineTold({ runs, answer, sentence, settles, more }) {
  const { outcome, label } = answer;
  const known = more?.uncertainty ? ` ${more.uncertainty.sentence}` : "";
  const rest = more?.starts_from_rest
    ? "It starts from rest on the tool."
    : "It does not start from rest on the tool: it must be pushed off.";
  const running = `One blow a cycle, switched by the piston. Stable: ${settles}.${more ? `${known} ${rest}` : ""}`;
  return {
    kind: runs ? "good" : "bad",
    text: `${outcome[0].toUpperCase()}${outcome.slice(1)}${runs || !label ? "" : `, ${label}`}`,
    words: runs ? running : sentence,
    figures: answer.period ? [...figures(answer), ...(answer.si ? intoRock(more ?? answer) : [])] : [],
  };
}

/** @param {Record<string, any>} answer */
function figures({ si, blows, period, stroke, duty }) {
  const greatest = (/** @type {string} */ name) => Math.max(...blows.map((/** @type {any} */ blow) => blow[name]));
  /** @type {import("./headline.js").Figure[]} */
  const found = si
    ? [
        ["blow energy", si.blow_energy_J, "J"],
        ["blow rate", si.blow_rate_Hz, "Hz"],
        ["striking speed", si.impact_velocity_m_s, "m/s"],
        ["stroke", 1e3 * si.stroke_m, "mm"],
        ["oil flow", si.oil_flow_l_per_min, "l/min"],
        ["delivered power", si.delivered_power_kW * 1000, "W"],
      ]
    : [
        ["blow energy", greatest("energy"), ""],
        ["striking speed", greatest("speed"), ""],
        ["period", period, ""],
        ["stroke", stroke, ""],
        ["share of the power stroke", duty, ""],
      ];
  return found.filter(([, value]) => value !== null);
}
