// A machine over its cycle: position, force and velocity with a running mark; its work as a loop; energy and rate over
// the pressure with the present point.

import { Chart, span } from "../pictures/chart.js";
import { theme } from "../pictures/colours.js";
import { h } from "../core/dom.js";
import { inUnit, number, scaleOf, si } from "../core/format.js";

const charts = {};
let curve = null; // the latest over the pressure: {more, changed, push, bar, body, factors, energy, rate}

export function machineCharts() {
  charts.position = new Chart("Centre of the piston over time");
  charts.force = new Chart("Force on the piston, positive toward the wall");
  charts.velocity = new Chart("Velocity, positive toward the wall");
  charts.loop = new Chart("Force over position: the loop is the work of a cycle");
  charts.energy = new Chart("Blow energy over the pressure");
  charts.rate = new Chart("Blow rate over the pressure");
  const order = ["position", "energy", "force", "rate", "velocity", "loop"];
  return h("div", { class: "grid", id: "machine-charts" }, order.map((name) => h("div", { class: "card" }, charts[name].figure)));
}

/** Factors and units in which a machine is told. */
export function machineUnits({ units, arrays, forces, answer, scales }) {
  const plain = { k: 1, name: "" };
  if (units !== "SI") return { time: plain, length: plain, force: plain, speed: plain, energy: plain, rate: plain };
  const scaled = (size, unit) => {
    const { factor, unit: name } = scaleOf(size, unit);
    return { k: factor, name };
  };
  const stroke = (answer.stroke ?? 0) * scales.length_m;
  return {
    time: scaled(Math.min((answer.period ?? 0) * scales.time_s, 0.9), "s"),
    length: scaled(Math.min(stroke || 1e-3, 0.9), "m"),
    force: scaled(Math.max(...(arrays.force ?? forces).map(Math.abs)), "N"),
    speed: { k: 1, name: "m/s" },
    energy: scaled(answer.si?.blow_energy_J ?? 1, "J"),
    rate: { k: 60, name: "1/min" },
  };
}

export function drawMachine(motion, units) {
  const { arrays } = motion;
  if (!arrays.t) return;
  const { kinds } = theme();
  const t = scaled(arrays.t, units.time.k);
  const x = { label: inUnit(motion.started ? "time after the start" : "time after the blow", units.time.name), from: 0, to: t.at(-1) };
  position(motion, units, x, t);
  const force = scaled(arrays.force, units.force.k);
  over(charts.force, x, "force", units.force.name, t, force, kinds[0]);
  const speed = scaled(arrays.velocity, units.speed.k);
  over(charts.velocity, x, "velocity", units.speed.name, scaled(arrays.velocity_t, units.time.k), speed, kinds[1]);
  loop(motion, units, force);
}

const scaled = (values, factor) => Array.from(values, (value) => value * factor);
const zero = () => ({ type: "level", at: 0, colour: theme().ink });

function over(chart, x, what, unit, times, values, colour) {
  const [from, to] = span([values, [0]]);
  chart.draw({ x, y: { label: inUnit(what, unit), from, to }, items: [zero(), { type: "line", x: times, y: values, colour }] });
}

function position(motion, { length, time }, x, t) {
  const { arrays, answer, scales } = motion;
  const { kinds, ink, surface } = theme();
  const place = scaled(arrays.centre, length.k);
  const [meters, seconds] = [scales?.length_m ?? 1, scales?.time_s ?? 1];
  const low = 1.15 * Math.min(...place);
  const items = [{ type: "level", at: 0, colour: ink, name: "tool or wall" }];
  answer.machine.ports.forEach((port, i) => {
    if (port.behind === null) return;
    const at = -port.behind * meters * length.k;
    if (at < low) return; // it is never reached
    items.push({ type: "level", at, colour: kinds[3], dash: [6, 4], name: "ports" });
    items.push({ type: "label", x: 0.62 * x.to, y: at, text: `port ${i + 1} → ${port.to}`, colour: kinds[3], dy: at > 0.1 * low ? 14 : -6 });
  });
  items.push({ type: "line", x: t, y: place, colour: kinds[0], name: "centre" });
  const mark = (times, shape, colour, name) => {
    const xs = times.map((at) => at * seconds * time.k);
    const ys = times.map((at) => at_(arrays, at * seconds) * length.k);
    items.push({ type: "points", x: xs, y: ys, shape, colour, size: 5, name });
  };
  mark(answer.ports.map((one) => one.time), "ring", kinds[3], "port passed");
  mark(answer.valve.map((one) => one.time), "diamond", kinds[1], "valve switches");
  mark(answer.blows.map((one) => one.time), "disc", kinds[4] ?? surface, "blow");
  const about = `Position over the cycle: a stroke of ${told(motion, answer.stroke * meters, "m")}`;
  charts.position.draw({ x, y: { label: inUnit("position", length.name), from: low, to: -0.12 * low || 1 }, items, about });
}

const told = ({ units }, value, unit) => (units === "SI" ? si(value, unit, 3) : number(value, 3));

/** The position of the centre at a time, between its neighbours. */
function at_({ t, centre }, time) {
  const after = t.findIndex((one) => one >= time);
  const j = after < 0 ? t.length - 1 : Math.max(after, 1);
  const gap = t[j] - t[j - 1];
  return centre[j - 1] + (gap > 0 ? ((time - t[j - 1]) / gap) * (centre[j] - centre[j - 1]) : 0);
}

function loop(motion, { length, force }, values) {
  const { kinds } = theme();
  const place = scaled(motion.arrays.centre, length.k);
  const [from, to] = span([values, [0]]);
  const items = [zero(), { type: "line", x: place, y: values, colour: kinds[0] }];
  const x = { label: inUnit("position", length.name), from: 1.06 * Math.min(...place), to: -0.06 * Math.min(...place) || 1 };
  charts.loop.draw({ x, y: { label: inUnit("force", force.name), from, to }, items });
}

/** Keep the curve of an answer that has one, and the pressure that it belongs to. */
export function keepCurve(motion) {
  const { more } = motion;
  if (!more || curve?.more === more) return;
  const { pressure_curve: rows } = more;
  curve = null;
  if (!rows.length) return;
  const { energy, rate } = atPresent(more, more.si);
  const values = (key, base) => rows.map((row) => (row[key] === null ? null : base * (1 + row[key])));
  curve = {
    more,
    changed: motion.changed,
    push: pushOf(motion),
    bar: motion.pressure_Pa ? motion.pressure_Pa / 1e5 : null,
    body: bodyOf(more.modes),
    factors: rows.map((row) => row.pressure),
    energy: values("energy", energy),
    rate: values("rate", rate),
  };
}

/** The greatest force of the valve, which grows with the pressure. */
const pushOf = ({ answer }) => Math.max(...Object.values(answer.machine.states).map(Math.abs));

const bodyOf = (modes) => (modes ? `${modes} elastic modes` : "rigid piston");

/** Energy and rate of a cycle, in SI where it has figures in SI; null where there is none. */
function atPresent(cycle, figures) {
  if (!cycle?.blows.length) return { energy: null, rate: null };
  const energy = figures?.blow_energy_J ?? Math.max(...cycle.blows.map((blow) => blow.energy));
  return { energy, rate: figures?.blow_rate_Hz ?? cycle.blows.length / cycle.period };
}

/** Energy and rate over the pressure, the present point, and that of a rigid piston beside it once the elastic one is
 * known; the curve may be that of a moment ago. */
export function drawCurve(motion, units) {
  const { kinds, ink, muted } = theme();
  const now = motion.runs ? atPresent(motion.answer, motion.answer.si) : {};
  const rigid = motion.modes ? atPresent(motion.more?.rigid, motion.more?.rigid_si) : {};
  const bar = motion.pressure_Pa ? motion.pressure_Pa / 1e5 : null;
  const factor = curve ? pushOf(motion) / curve.push : 1;
  const here = bar ?? factor;
  const fresh = curve?.changed === motion.changed;
  const per = bar ? (curve?.bar ?? bar) : 1;
  const x = {
    label: bar ? "pressure of the supply [bar]" : "forces of the valve, relative",
    from: Math.min(0.5 * per, 0.95 * here),
    to: Math.max(1.5 * per, 1.05 * here),
  };
  for (const [chart, key, unit, words] of [
    [charts.energy, "energy", units.energy, "blow energy"],
    [charts.rate, "rate", units.rate, "blow rate"],
  ]) {
    const ys = (curve?.[key] ?? []).map((one) => (one === null ? null : one * unit.k));
    const points = [
      [rigid[key], "ring", 10, "now, rigid piston"],
      [now[key], "diamond", 7, `now, ${bodyOf(motion.modes)}`],
    ].filter(([value]) => Number.isFinite(value));
    const items = points.map(([value, shape, size, name]) => ({ type: "points", x: [here], y: [value * unit.k], shape, size, colour: ink, name }));
    const [, to] = span([ys, points.map(([value]) => value * unit.k), [0]], 0.08);
    if (curve) {
      const name = `${curve.body}${fresh ? "" : ", of a moment ago"}`;
      items.unshift({ type: "line", x: curve.factors.map((one) => one * per), y: ys, colour: fresh ? kinds[key === "rate" ? 0 : 4] : muted, dash: fresh ? [] : [5, 4], name });
    }
    chart.draw({ x, y: { label: inUnit(words, unit.name), from: 0, to }, items, about: `${words} over the pressure: ${items.map(({ name }) => name).join(", ")}` });
  }
}

/** The present moment on the charts. */
export function followMachine(motion, units, time) {
  if (!motion.arrays.t) return;
  const at = time * units.time.k;
  for (const name of ["position", "force", "velocity"]) charts[name].over([], at);
}
