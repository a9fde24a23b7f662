// The impact phases of all steady motions against the load factor; they are asked for when the case has come to rest.

import { post } from "../core/api.js";
import { Chart, PHASES } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { latest, settled } from "../core/dom.js";
import { inUnit } from "../core/format.js";
import { REST, data, isHeld, on, uptodate, view } from "../core/state.js";

let chart = null;
let orbitPoints = null; // draws the present motions, as the other charts do
let branches = null;
let branched = -1; // the change of the case whose branches are shown

export function branchChart(points) {
  orbitPoints = points;
  chart = new Chart("Impact phase against the load factor");
  return chart;
}

/** Ask for the branches when the case has come to rest; along the load factor they stay as they are. */
export const wantBranches = settled(() => {
  if (view.panel !== "orbits" || isHeld() || !uptodate() || branched === data.changed) return;
  askBranches({ tables: data.tables, m: view.m, changed: data.changed });
}, REST);

on("tables", () => {
  const along = data.moved?.length === 1 && data.moved[0] === "load_factor";
  if (along && branched === data.changed - 1 && data.quick?.load_factor <= branches.load_factor.at(-1))
    branched = data.changed;
});

const askBranches = latest(
  ({ tables, m }) => post("curves", { case: tables, periods: m, points: 2, branches: 160 }),
  (found, { changed }) => {
    branches = found.branches;
    branched = changed;
    drawBranches();
  },
  () => {
    branches = null;
    branched = -1;
  },
);

/** The branches as far as they are known. */
export function drawBranches() {
  if (!branches || view.panel !== "orbits") return;
  const { kinds, ink } = theme();
  const { load_factor: factor, phase, reduced_stable: stable } = branches;
  const torn = (list) =>
    list.map((value, i) =>
      i && value !== null && list[i - 1] !== null && Math.abs(value - list[i - 1]) > Math.PI ? null : value,
    ); // over 2π
  const keep = (list, good, wish) =>
    list.map((value, i) =>
      value !== null && (good[i] === wish || good[i - 1] === wish || good[i + 1] === wish) ? value : null,
    );
  const items = phase.map(torn).flatMap((list, i) => [
    {
      type: "line",
      x: factor,
      y: keep(list, stable[i], false),
      colour: kinds[1],
      width: 2,
      dash: [6, 4],
      name: "unstable",
    },
    {
      type: "line",
      x: factor,
      y: list.map((value, j) => (stable[i][j] ? value : null)),
      colour: kinds[2],
      width: 3.5,
      name: "stable",
    },
  ]);
  const now = data.quick?.load_factor ?? branches.now;
  if (now !== null)
    items.push({
      type: "level",
      at: now,
      axis: "x",
      colour: ink,
      dash: [2, 3],
      width: 1.5,
      name: "the present load factor",
    });
  if (data.quick)
    items.push(
      ...orbitPoints(
        data.quick,
        () => now,
        (o) => o.phase_b77 ?? o.phase,
      ).map((item) => ({ ...item, name: "" })),
    );
  const values = factor.filter((v) => v !== null);
  chart.draw({
    x: {
      label: "load factor p₀/p₁",
      from: Math.min(...values, now ?? Infinity),
      to: Math.max(...values, now ?? -Infinity),
    },
    y: { label: inUnit("impact phase", "rad"), from: 0, to: 2 * Math.PI, ticks: PHASES },
    items,
    about: "Impact phases of the steady motions against the load factor; both branches meet in the fold",
  });
}
