// The machine in motion: the piston between its ports, what pushes it, and the spool of the valve.

import { number } from "../core/format.js";
import { placeIn, valueIn } from "../core/rising.js";
import { tr } from "../core/words.js";
import { LiveStage } from "../motion/live_stage.js";
import { theme } from "../pictures/colours.js";
import { FONT, arrow, strokeLines } from "../pictures/pen.js";

/** @typedef {import("../pictures/pen.js").Pen} Pen */
/** @typedef {import("./machine_charts.js").Machine} Machine */
/** @typedef {Record<string, any>} Colours */
/** A travel of the spool between two states, by their numbers.
 * @typedef {{ begin: number, end: number, from: number, to: number }} Move */
/** Where the piston is drawn: the place of the wall, its length, pixels of a bar length, of travel and of thickness, and how
 * thick it is. @typedef {ReturnType<MachineStage["scales"]>} Scale */

const LEFT = 20;
const EDGE = LEFT - 14; // of the housing
const RIGHT = 58; // pixels for the wall
const LEAST = 60; // pixels of the stroke: a shorter one is drawn larger
const FIELDS = 6; // states of the valve that are drawn

export class MachineStage extends LiveStage {
  long = 1; // of the piston
  stroke = 0.1;
  most = 1; // the greatest force
  last = Number.NaN; // the moment of the blow before
  /** @type {any[]} */
  ports = [];
  /** @type {Move[]} */
  moves = [];
  /** @type {{ length: number, thick: number }[] | undefined} */
  sections = undefined;

  get there() {
    return Boolean(this.motion);
  }

  /** The cycle of the present machine, which the live motion tends to; `sections` are those of the bar.
   * @param {Machine} motion @param {any[]} [sections] */
  settle(motion, sections) {
    const share = this.length > 0 ? this.time / this.length : 0;
    this.law(motion, sections);
    const { speed } = motion.answer.blows[0] ?? {};
    const time = this.exact || !this.live ? share * this.length : 0;
    if (motion.arrays.t && speed !== undefined) this.comes(time, { speed, period: motion.answer.period });
    else this.draw();
  }

  /** A motion in `arrays`, with its `answer`, as frames from its start. @param {Machine} motion @param {any[]} [sections] */
  show(motion, sections) {
    this.live = null;
    this.exact = true;
    this.cycle = null;
    this.law(motion, sections);
    this.draw();
  }

  /** What is drawn of a machine. @param {Machine} motion @param {any[]} [sections] */
  law(motion, sections) {
    const { answer, arrays, scales } = motion;
    const [metres, seconds] = [scales?.length_m ?? 1, scales?.time_s ?? 1];
    this.motion = motion;
    this.long = metres;
    this.second = 1 / seconds;
    this.sections = sections?.map(({ length_m: length, diameter_m: thick }) => ({ length, thick }));
    this.ports = answer.machine.ports.map((/** @type {any} */ port) => ({
      ...port,
      behind: port.behind && port.behind * metres,
    }));
    this.length = arrays.t?.at(-1) ?? 0;
    this.time = Math.min(this.time, this.length);
    this.period = this.length || this.period;
    const stroke = answer.stroke ?? this.deepest ?? 0.1;
    this.deepest = stroke;
    this.stroke = stroke * metres;
    this.heard = answer.blows.map((/** @type {any} */ { time, energy }) => ({
      time: time * seconds,
      energy,
      energy_J: scales ? energy * scales.energy_J : null,
    }));
    this.loudest = Math.max(1e-30, ...this.heard.map((/** @type {any} */ { energy }) => energy));
    this.moves = arrays.t ? spoolMoves(answer, seconds) : [];
    this.most = Math.max(1e-30, ...(arrays.force ?? motion.forces).map(Math.abs));
  }

  gapOfFrame() {
    return this.motion.arrays.t ? this.present().centre / this.long : 0;
  }

  /** Of the frame in sight: as a live motion goes on from it. @returns {any} */
  stateOfFrame() {
    const { scales, states } = this.motion;
    const { centre, velocity, state } = this.present();
    const { to } = this.spool(state);
    const late = this.moves.find(({ to: next, end }) => next === to && end > this.time)?.end ?? this.time;
    const orders = to === state ? [] : [{ after: (late - this.time) * this.second, to: states[to] }];
    const speed = (velocity * (scales?.time_s ?? 1)) / this.long;
    const gap = Math.min(centre / this.long, 0);
    return { gap, velocity: speed, state: states[state], demanded: states[to], orders };
  }

  /** @param {any} blow */
  settledAt({ speed, time }) {
    const since = time - this.last;
    this.last = time;
    const { cycle } = this;
    return Boolean(cycle) && Math.abs(speed / cycle.speed - 1) < 0.03 && Math.abs(since / cycle.period - 1) < 0.03;
  }

  phaseInFrames() {
    return 0; // they begin at the blow
  }

  /** Where the piston is, what acts on it, the number of the state: at the present time. */
  present() {
    const { arrays, states, forces, answer, scales } = this.motion;
    const still = { centre: 0, force: 0, velocity: 0 };
    if (!this.exact && this.live) {
      const { gap, force, state } = this.live;
      const number = Math.max(states.indexOf(state), 0);
      return { ...still, centre: gap * this.long, force: force * (scales?.force_N ?? 1), state: number };
    }
    const { t, centre, force, state, velocity, velocity_t: times } = arrays;
    if (!t) return { ...still, state: states.indexOf(answer.machine.start_state) };
    const at = placeIn(t, this.time);
    return {
      centre: valueIn(centre, at),
      force: valueIn(force ?? forces, at),
      state: state[at[0]],
      velocity: valueIn(velocity, placeIn(times, this.time)),
    };
  }

  /** The place of the spool, a number of a state or between two: it travels while an order waits for its time.
   * @param {number} state */
  spool(state) {
    if (!this.exact && this.live) {
      const [order] = this.live.orders;
      if (!order) return { at: state, to: state };
      const to = this.motion.states.indexOf(order.to);
      const { ports: all } = /** @type {any} */ (this.live.law.valve);
      const ports = all.filter((/** @type {any} */ port) => port.to === order.to);
      const delay = Math.max(...ports.map((/** @type {any} */ port) => port.delay), 1e-30);
      return { at: state + (1 - Math.min(order.due / delay, 1)) * (to - state), to };
    }
    for (const { begin, end, from, to } of this.moves) {
      const gone = this.time - begin + (this.time >= begin ? 0 : this.length); // it may wait over a blow
      if (gone < end - begin) return { at: from + (gone / (end - begin)) * (to - from), to };
    }
    return { at: state, to: state };
  }

  /** What the piston looks like; one without sizes has one thickness. */
  get shapes() {
    return this.sections ?? [{ length: this.long, thick: 0.16 * this.long }];
  }

  /** Pixels of lengths and of thicknesses; nothing is stretched. @param {number} width @param {number} height */
  scales(width, height) {
    const room = width - LEFT - RIGHT;
    const near = this.ports.map(({ behind }) => behind ?? 0).filter((at) => !this.stroke || at <= 3 * this.stroke);
    const reach = 1.08 * Math.max(this.stroke, ...near, 1e-3 * this.long);
    const whole = (room / (this.long + reach)) * this.long;
    const bar = Math.min(Math.max(whole, 0.25 * room), room - LEAST);
    const thick = Math.max(...this.shapes.map((own) => own.thick));
    const along = bar / this.long;
    const across = Math.min((0.27 * height) / thick, Math.max(along, (0.16 * height) / thick));
    const travel = (room - bar) / reach;
    return { wall: width - RIGHT, bar, along, travel, across, thick: thick * across, stretch: 0 };
  }

  /** How the drawing is to scale, in words. */
  magnified() {
    const { along, travel, across } = this.scales(900, 300);
    const larger = (/** @type {number} */ ratio, /** @type {string} */ what) =>
      Math.abs(ratio - 1) > 0.05 ? [`${what} ×${number(ratio, 2)}`] : [];
    const words = [...larger(travel / along, "travel"), ...(this.sections ? larger(across / along, "thickness") : [])];
    const beside = words.length ? `; beside its length ${words.join(", ")}` : "";
    return this.sections
      ? `The piston is drawn to scale${beside}.`
      : `The thickness of the piston is not known${beside}.`;
  }

  /** @param {Pen} pen @param {number} width @param {number} height */
  paint(pen, width, height) {
    const colours = theme();
    const scale = this.scales(width, height);
    const { wall, bar, travel, thick } = scale;
    const { centre, force, state } = this.present();
    const mid = height * 0.65;
    const edge = wall + Math.min(centre, 0) * travel;
    const top = mid - thick / 2 - 9;
    const side = colours.kinds[force > 0 ? 3 : 0]; // that pushes
    pen.font = FONT;
    this.wall(pen, wall, height, colours);
    this.housing(pen, { rear: edge - bar, edge, mid, top, thick, wall, force, side }, colours);
    this.piston(pen, edge, mid, scale, colours);
    const [x, half] = [edge - 0.75 * bar, (26 * force) / this.most];
    if (Math.abs(half) >= 1.5) arrow(pen, side, x - half, x + half, mid);
    const box = this.valve(pen, width, state, colours);
    this.lines(pen, { edge, top, scale, box }, colours);
    if (this.flash.left > 0) this.burst(pen, wall, mid, thick, colours);
    pen.textAlign = "left";
  }

  /** The housing, and behind the piston what pushes it: oil where the force acts, gas where there is some.
   * @param {Pen} pen @param {{ rear: number, edge: number, mid: number, top: number, thick: number, wall: number,
   *   force: number, side: string }} place @param {Colours} colours */
  housing(pen, { rear, edge, mid, top, thick, wall, force, side }, colours) {
    const low = 2 * mid - top;
    const behind = rear - EDGE;
    pen.globalAlpha = 0.12 + (0.38 * Math.abs(force)) / this.most;
    pen.fillStyle = side;
    if (force > 0) pen.fillRect(EDGE, mid - thick / 2 - 5, behind, thick + 10);
    else for (const y of [top, low - 6]) pen.fillRect(edge - 0.35 * (edge - rear), y, 0.35 * (edge - rear), 6);
    const { chamber } = this.motion.answer.machine;
    if (chamber.force || chamber.stiffness) {
      pen.globalAlpha = 0.5;
      pen.fillStyle = colours.kinds[2];
      pen.fillRect(EDGE, mid - thick * 0.15, behind, thick * 0.3);
    }
    pen.globalAlpha = 1;
    strokeLines(pen, colours.muted, 2, [wall - 12, top, EDGE, top, EDGE, low, wall - 12, low]);
  }

  /** @param {Pen} pen @param {number} edge @param {number} mid @param {Scale} scale @param {Colours} colours */
  piston(pen, edge, mid, { bar, across }, colours) {
    const whole = this.shapes.reduce((sum, { length }) => sum + length, 0);
    pen.fillStyle = colours.sunken;
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.4;
    let left = edge - bar;
    for (const { length, thick } of this.shapes) {
      const [long, tall] = [(length / whole) * bar, thick * across];
      pen.fillRect(left, mid - tall / 2, long, tall);
      pen.strokeRect(left, mid - tall / 2, long, tall);
      left += long;
    }
  }

  /** The valve above the machine: one field for each state, the spool over the present one.
   * @param {Pen} pen @param {number} width @param {number} state @param {Colours} colours */
  valve(pen, width, state, colours) {
    const { states, forces } = this.motion;
    const count = Math.min(states.length, FIELDS);
    const field = Math.min(96, (width - 2 * LEFT - RIGHT) / count);
    const left = Math.max(LEFT, (width - RIGHT - count * field) / 2);
    const right = left + count * field;
    const [top, tall] = [14, 28];
    const row = top + tall / 2 + 4.5;
    const { at, to } = this.spool(state);
    pen.globalAlpha = 0.35;
    pen.fillStyle = colours.kinds[forces[state] > 0 ? 3 : 0];
    pen.fillRect(left + Math.min(at, count - 1) * field + 2, top + 2, field - 4, tall - 4);
    pen.globalAlpha = 1;
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.4;
    pen.strokeRect(left, top, count * field, tall);
    pen.textAlign = "center";
    for (const [i, name] of states.slice(0, count).entries()) {
      pen.fillStyle = i === state ? colours.ink : colours.muted;
      pen.fillText(tr(name.length > 12 ? `${name.slice(0, 11)}…` : name), left + (i + 0.5) * field, row);
    }
    pen.textAlign = "left";
    pen.fillStyle = colours.muted;
    if (to !== state) pen.fillText(tr(`ordered: ${states[to]}`), right + 8, row);
    return { left, right, bottom: top + tall };
  }

  /** Each port at its place in the housing, its line to the valve, and the place of the piston that it reads.
   * @param {Pen} pen @param {{ edge: number, top: number, scale: Scale, box: { left: number, right: number,
   *   bottom: number } }} place @param {Colours} colours */
  lines(pen, { edge, top, scale, box }, colours) {
    const { wall, bar, travel } = scale;
    for (const [i, { behind, reads, side, to }] of this.ports.entries()) {
      if (behind === null) continue;
      const before = (1 - (reads === "centre" ? this.centreOfMass() : reads)) * bar;
      const [x, mark] = [wall - before - behind * travel, edge - before];
      if (x < EDGE) continue;
      const open = side === "back" ? mark < x : mark > x;
      const joint = Math.min(Math.max(x, box.left + 6 + 8 * i), box.right - 6 - 8 * i);
      const bend = box.bottom + 12 + 9 * i;
      pen.setLineDash(open ? [] : [4, 3]);
      const colour = open ? colours.accent : colours.muted;
      strokeLines(pen, colour, open ? 3 : 1.5, [x, top, x, bend, joint, bend, joint, box.bottom]);
      pen.setLineDash([]);
      pen.fillStyle = open ? colours.accent : colours.surface;
      pen.fillRect(x - 4, top - 4, 8, 8);
      pen.strokeRect(x - 4, top - 4, 8, 8);
      pen.fillStyle = colours.muted;
      pen.textAlign = i % 2 ? "left" : "right";
      pen.fillText(tr(`${i + 1} → ${to}`), x + (i % 2 ? 8 : -8), top - 8);
      strokeLines(pen, colours.ink, 2, [mark, top + 3, mark, top + 15]);
    }
  }

  /** Where the centre of mass is, from 0 (driven end) to 1, of round sections of one material. */
  centreOfMass() {
    let [mass, moment, begin] = [0, 0, 0];
    for (const { length, thick } of this.sections ?? []) {
      mass += length * thick ** 2;
      moment += length * thick ** 2 * (begin + length / 2);
      begin += length;
    }
    return mass ? moment / mass / begin : 0.5;
  }
}

/** When the spool travels, and from which state to which: from a demand to the change of the state.
 * @param {any} answer @param {number} seconds @returns {Move[]} */
function spoolMoves({ valve, machine, ports, blows, period, first_state: first }, seconds) {
  const names = Object.keys(machine.states);
  return valve.map((/** @type {any} */ { time, to }, /** @type {number} */ i) => {
    const from = i || !first ? valve.at(i - 1).to : first;
    /** The moments of demands with their delays. @type {[number, number][]} */
    const demanded = [];
    for (const { port, time: at } of ports)
      if (machine.ports[port].to === to) demanded.push([at, machine.ports[port].delay]);
    for (const port of machine.ports)
      if (port.on === "impact" && port.to === to) for (const blow of blows) demanded.push([blow.time, port.delay]);
    const late = (/** @type {[number, number]} */ [at, delay]) =>
      ((((time - at - delay + 0.5 * period) % period) + period) % period) - 0.5 * period;
    const [asked] = demanded.sort((a, b) => Math.abs(late(a)) - Math.abs(late(b)));
    const travel = asked ? Math.max(asked[1] + late(asked), 0) : 0;
    const end = time >= travel ? time : time + period;
    return {
      begin: (end - travel) * seconds,
      end: end * seconds,
      from: names.indexOf(from),
      to: names.indexOf(to),
    };
  });
}
