// The steady motions: where their phases come from, how they branch with the load, what the load does at the blow, and
// what becomes of a disturbance.

import { framed, h, put } from "../core/dom.js";
import { angle, number, si } from "../core/format.js";
import { wantBranches } from "./orbits_branches.js";
import { drawOrbitCharts, fullOf, orbitCharts } from "./orbits_charts.js";
import { chosen, data, isHeld, obstacleOf, on, reasonOf, show, switchesItself, unhurried, view } from "../core/state.js";
import { detailsOfScenes } from "../screen/scenes.js";

const parts = {};

/** The load at the blow, which stands on the screen. */
export function whyOfOrbits() {
  Object.assign(parts, orbitCharts());
  return parts.why;
}

export function start(section) {
  parts.table = h("div", { class: "scroll", id: "orbit-table" });
  parts.about = h("div", { id: "orbit-about" });
  parts.own = h("div", { class: "stack" }, parts.table, parts.rest, parts.about);
  put(section, parts.own, detailsOfScenes);
  const told = unhurried(words);
  on("tables", () => (parts.own.hidden = switchesItself() || isHeld()));
  on("quick", () => (pictures(), told())); // pictures at once: a slider waits for them
  on("steady view theme", framed(() => (pictures(), words())));
  on("quick view", wantBranches);
}

const pictures = () => !switchesItself() && !isHeld() && drawOrbitCharts(data.quick, view.panel === "orbits");

function words() {
  if (view.panel !== "orbits" || isHeld() || switchesItself()) return;
  table();
  about();
}

function table() {
  const quick = data.quick;
  if (!quick)
    return put(
      parts.table,
      h("p", { class: "muted" }, data.problems.length ? "No answer: see the problem above." : "…"),
    );
  const now = chosen()?.number;
  const head = ["Motion", "Impact phase", "Possible", "Verdict", "Rhythm", "Ringing", "Load at impact over mean", "Blow"];
  const rows = quick.orbits.map((orbit, i) => {
    const full = fullOf(i);
    const { ratio, lower, upper } = orbit.waveform;
    const cells = [
      h(
        "button",
        { type: "button", "aria-pressed": String(now === i + 1), onclick: () => show({ orbit: i + 1 }) },
        `${i + 1}`,
      ),
      phases(orbit),
      full ? (full.admissible ? "yes" : `no: ${obstacleOf({ quick: orbit, full })}`) : "…",
      reasonOf({ quick: orbit, full }),
      margin(full, orbit, "margin_rhythm"),
      margin(full, orbit, "margin_ringing"),
      `${number(ratio, 4)} (stable between ${number(lower, 3)} and ${number(upper, 3)})`,
      !(orbit.impact_velocity > 0) ? "–" : orbit.si ? si(orbit.si.blow_energy_J, "J") : number(orbit.blow_energy),
    ];
    return h(
      "tr",
      { class: now === i + 1 ? "chosen" : "" },
      cells.map((cell, j) => h("td", { class: j === 4 || j === 5 || j === 7 ? "n" : "" }, cell)),
    );
  });
  const title = `Steady motions with one impact ${quick.m === 1 ? "every load period" : `in ${quick.m} load periods`}`;
  const key = JSON.stringify([
    data.changed,
    Boolean(data.steady),
    quick.changed,
    now,
    Boolean(quick.orbits[0]?.reason),
  ]);
  if (parts.table.dataset.key === key) return;
  parts.table.dataset.key = key;
  put(
    parts.table,
    h("h2", {}, title),
    rows.length
      ? h(
          "table",
          {},
          h(
            "thead",
            {},
            h(
              "tr",
              {},
              head.map((t) => h("th", { scope: "col" }, t)),
            ),
          ),
          h("tbody", {}, rows),
        )
      : h("p", {}, `There is none: ${data.about.reasons["no motion"]}.`),
    (quick.blow_alone ?? []).map((lines) => h("p", {}, `Besides, ${lines.join("; ")}.`)),
  );
}

/** The impact phase, or that of the force of a blow that takes time with B77's beside it. */
function phases({ phase, phase_b77: b77 }) {
  return b77 === undefined ? angle(phase) : `${angle(phase)} (B77 ${angle(b77)})`;
}

/** One of the two margins, which come with the full answer; a rigid bar has no ringing. */
function margin(full, orbit, which) {
  const value = (full ?? orbit)[which];
  return value === null ? (full ? "–" : "…") : number(value, 4);
}

function about() {
  const found = chosen();
  const full = found?.full;
  if (!found) return put(parts.about, h("p", { class: "muted" }, "There is no steady motion to describe."));
  const key = JSON.stringify([data.changed, found.number, Boolean(full)]);
  if (parts.about.dataset.key === key) return;
  parts.about.dataset.key = key;
  const { lower, upper, ratio, stable } = found.quick.waveform;
  const rule = `At the moment of impact the load is ${number(ratio)} of its mean. A rigid, undamped bar sustains the motion while this ratio lies between ${number(lower)} (flip) and ${number(upper)} (fold): here it ${stable ? "does" : "does not"}.`;
  const notes = [full?.disagreement, ...(full?.warnings ?? [])].filter(Boolean);
  const reduced = found.quick.reduced;
  put(
    parts.about,
    h("h2", {}, `Motion ${found.number} in detail`),
    h("p", {}, rule),
    h(
      "dl",
      { class: "facts" },
      [
        ["impact phase", phases(found.quick)],
        ["largest multiplier, reduced criterion", number(Math.max(...reduced.moduli))],
        ["largest multiplier, with elastic modes", number(found.quick.multipliers?.largest)],
        ["σ, the bar's elasticity in the criterion", number(reduced.sigma)],
        ["proved", full ? (full.proven ? "yes, with all modes" : "not proved: the omitted modes leave it open") : "…"],
      ].map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]),
    ),
    (found.quick.blow ?? []).map((text) => h("p", {}, text)),
    notes.map((text) => h("p", { class: "note warn" }, text)),
  );
}
