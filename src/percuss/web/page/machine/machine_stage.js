// The machine in motion: the piston between its ports, what pushes it, and the spool of the valve.

import { theme } from "../pictures/colours.js";
import { number } from "../core/format.js";
import { LiveStage } from "../motion/live_stage.js";
import { tr } from "../core/words.js";

const FONT = "12.5px system-ui, sans-serif";
const LEFT = 20;
const RIGHT = 58; // pixels for the wall
const LEAST = 60; // pixels of the stroke: a shorter one is drawn larger

export class MachineStage extends LiveStage {
  get there() {
    return Boolean(this.motion);
  }

  /** The cycle of the present machine, which the live motion tends to; `sections` are those of the bar. */
  settle(motion, sections) {
    const share = this.length > 0 ? this.time / this.length : 0;
    this.law(motion, sections);
    const { answer } = motion;
    const [blow] = answer.blows;
    if (motion.arrays.t && blow) this.comes(this.exact || !this.live ? share * this.length : 0, { speed: blow.speed, period: answer.period });
    else this.draw();
  }

  /** A motion in `arrays`, with its `answer`, as frames from its start. */
  show(motion, sections) {
    this.live = null;
    this.exact = true;
    this.cycle = null;
    this.law(motion, sections);
    this.draw();
  }

  /** What is drawn of a machine. */
  law(motion, sections) {
    const { answer, arrays, scales } = motion;
    this.motion = motion;
    this.sections = sections?.map(({ length_m: length, diameter_m: thick }) => ({ length, thick }));
    const meters = scales?.length_m ?? 1;
    const seconds = scales?.time_s ?? 1;
    this.second = 1 / seconds;
    this.bar_ = meters;
    this.ports = answer.machine.ports.map((port) => ({ ...port, behind: port.behind && port.behind * meters }));
    this.length = arrays.t?.at(-1) ?? 0;
    this.time = Math.min(this.time, this.length);
    this.period = this.length || this.period;
    this.stroke = (answer.stroke ?? this.deepest ?? 0.1) * meters;
    this.deepest = this.stroke / meters;
    this.heard = answer.blows.map(({ time, energy }) => ({
      time: time * seconds,
      energy,
      energy_J: scales ? energy * scales.energy_J : null,
    }));
    this.loudest = Math.max(1e-30, ...this.heard.map(({ energy }) => energy));
    this.moves = arrays.t ? spoolMoves(answer, seconds) : [];
    this.most = Math.max(1e-30, ...(arrays.force ?? motion.forces).map(Math.abs));
  }

  gapOfFrame() {
    return this.motion.arrays.t ? this.now_().centre / this.bar_ : 0;
  }

  /** Of the frame in sight: as a live motion goes on from it. */
  stateOfFrame() {
    const { scales, states } = this.motion;
    const { centre, velocity, state } = this.now_();
    const { to } = this.spool(state);
    const late = this.moves.find(({ to: next, end }) => next === to && end > this.time);
    const orders = to === state ? [] : [{ after: ((late?.end ?? this.time) - this.time) * this.second, to: states[to] }];
    const [meters, seconds] = [scales?.length_m ?? 1, scales?.time_s ?? 1];
    return { gap: Math.min(centre / meters, 0), velocity: (velocity * seconds) / meters, state: states[state], demanded: states[to], orders };
  }

  settledAt({ speed, time }) {
    const since = time - (this.last ?? Number.NaN);
    this.last = time;
    if (!this.cycle) return false;
    return Math.abs(speed / this.cycle.speed - 1) < 0.03 && Math.abs(since / this.cycle.period - 1) < 0.03;
  }

  phaseInFrames() {
    return 0; // they begin at the blow
  }

  /** Where the piston is, what acts on it, the number of the state: at the present time. */
  now_() {
    const { arrays, states, forces, answer, scales } = this.motion;
    if (!this.exact && this.live) {
      const { live } = this;
      const strong = scales ? scales.force_N : 1;
      return { centre: live.gap * this.bar_, force: live.force * strong, state: Math.max(states.indexOf(live.state), 0), velocity: 0 };
    }
    const { t, centre, force, state, velocity, velocity_t: times } = arrays;
    if (!t) return { centre: 0, force: 0, state: states.indexOf(answer.machine.start_state), velocity: 0 };
    const between = (at, list) => {
      let [low, high] = [0, at.length - 1];
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (at[middle] <= this.time) low = middle;
        else high = middle;
      }
      const share = at[high] > at[low] ? (this.time - at[low]) / (at[high] - at[low]) : 0;
      return [list[low] + share * (list[high] - list[low]), low];
    };
    const [here, low] = between(t, centre);
    return { centre: here, force: between(t, force ?? forces)[0], state: state[low], velocity: between(times, velocity)[0] };
  }

  /** The place of the spool, a number of a state or between two: it travels while an order waits for its time. */
  spool(state) {
    const order = this.exact || !this.live ? null : this.live.orders[0];
    if (order) {
      const to = this.motion.states.indexOf(order.to);
      const delay = Math.max(...this.live.law.valve.ports.filter((port) => port.to === order.to).map((port) => port.delay), 1e-30);
      return { at: state + (1 - Math.min(order.due / delay, 1)) * (to - state), to };
    }
    if (!this.exact && this.live) return { at: state, to: state };
    for (const { begin, end, from, to } of this.moves) {
      const gone = this.time >= begin ? this.time - begin : this.time - begin + this.length; // it may wait over a blow
      if (gone < end - begin) return { at: from + (gone / (end - begin)) * (to - from), to };
    }
    return { at: state, to: state };
  }

  /** Pixels of lengths and of thicknesses. */
  scales(width, height) {
    const room = width - LEFT - RIGHT;
    const near = this.ports.map(({ behind }) => behind ?? 0).filter((behind) => !this.stroke || behind <= 3 * this.stroke);
    const reach = 1.08 * Math.max(this.stroke, ...near, 1e-3 * this.bar_);
    const along = room / (this.bar_ + reach);
    const bar = Math.min(Math.max(along * this.bar_, 0.25 * room), room - LEAST);
    const travel = (room - bar) / reach;
    const thick = Math.max(...(this.sections ?? [{ thick: 0.16 * this.bar_ }]).map((own) => own.thick));
    const across = Math.min((0.27 * height) / thick, Math.max(bar / this.bar_, (0.16 * height) / thick));
    return { wall: width - RIGHT, bar, along: bar / this.bar_, travel, across, thick: thick * across };
  }

  /** How the drawing is to scale, in words. */
  magnified() {
    const { along, travel, across } = this.scales(900, 300);
    const larger = (ratio, what) => (Math.abs(ratio - 1) > 0.05 ? `${what} ×${number(ratio, 2)}` : "");
    const words = [larger(travel / along, "travel"), this.sections && larger(across / along, "thickness")].filter(Boolean);
    const beside = words.length ? `; beside its length ${words.join(", ")}` : "";
    return this.sections ? `The piston is drawn to scale${beside}.` : `The thickness of the piston is not known${beside}.`;
  }

  paint(pen, width, height) {
    const colours = theme();
    const scale = this.scales(width, height);
    const { wall, bar, travel, thick } = scale;
    const mid = height * 0.65;
    const { centre, force, state } = this.now_();
    const edge = wall + Math.min(centre, 0) * travel;
    const rear = edge - bar;
    const top = mid - thick / 2 - 9;
    pen.font = FONT;
    this.wall(pen, wall, height, colours);
    this.spaces(pen, { rear, edge, mid, top, thick, wall, force }, colours);
    this.piston(pen, edge, mid, scale, colours);
    this.arrow(pen, rear + 0.25 * bar, mid, force, colours);
    const box = this.valve(pen, width, state, colours);
    this.lines(pen, { edge, top, scale, box }, colours);
    if (this.flash.left > 0) this.burst(pen, wall, mid, thick, colours);
    pen.textAlign = "left";
  }

  /** The housing, and behind the piston what pushes it: oil where the force acts, gas where there is some. */
  spaces(pen, { rear, edge, mid, top, thick, wall, force }, colours) {
    const low = 2 * mid - top;
    const share = Math.abs(force) / this.most;
    const full = thick + 10;
    pen.globalAlpha = 0.12 + 0.38 * share;
    pen.fillStyle = colours.kinds[force > 0 ? 3 : 0];
    if (force > 0) pen.fillRect(LEFT - 14, mid - full / 2, rear - LEFT + 14, full);
    else for (const y of [top, low - 6]) pen.fillRect(edge - 0.35 * (edge - rear), y, 0.35 * (edge - rear), 6);
    const { chamber } = this.motion.answer.machine;
    if (chamber.force || chamber.stiffness) {
      pen.globalAlpha = 0.5;
      pen.fillStyle = colours.kinds[2];
      pen.fillRect(LEFT - 14, mid - thick * 0.15, rear - LEFT + 14, thick * 0.3);
    }
    pen.globalAlpha = 1;
    pen.strokeStyle = colours.muted;
    pen.lineWidth = 2;
    pen.beginPath();
    for (const y of [top, low]) (pen.moveTo(LEFT - 14, y), pen.lineTo(wall - 12, y));
    (pen.moveTo(LEFT - 14, top), pen.lineTo(LEFT - 14, low));
    pen.stroke();
  }

  piston(pen, edge, mid, { bar, across }, colours) {
    const sections = this.sections ?? [{ length: this.bar_, thick: 0.16 * this.bar_ }];
    const whole = sections.reduce((sum, own) => sum + own.length, 0);
    pen.fillStyle = colours.sunken;
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.4;
    let left = edge - bar;
    for (const own of sections) {
      const [long, tall] = [(own.length / whole) * bar, own.thick * across];
      pen.fillRect(left, mid - tall / 2, long, tall);
      pen.strokeRect(left, mid - tall / 2, long, tall);
      left += long;
    }
  }

  /** The force as an arrow on the piston. */
  arrow(pen, x, y, force, colours) {
    const length = 52 * (force / this.most);
    if (Math.abs(length) < 3) return;
    const tip = x + length / 2;
    const head = length > 0 ? -8 : 8;
    pen.strokeStyle = pen.fillStyle = colours.kinds[force > 0 ? 3 : 0];
    pen.lineWidth = 3;
    pen.beginPath();
    (pen.moveTo(x - length / 2, y), pen.lineTo(tip + 0.6 * head, y));
    pen.stroke();
    pen.beginPath();
    (pen.moveTo(tip, y), pen.lineTo(tip + head, y - 6), pen.lineTo(tip + head, y + 6), pen.closePath());
    pen.fill();
  }

  /** The valve above the machine: one field for each state, the spool over the present one. */
  valve(pen, width, state, colours) {
    const { states } = this.motion;
    const field = Math.min(96, (width - 2 * LEFT - RIGHT) / Math.min(states.length, 6));
    const count = Math.min(states.length, 6);
    const left = Math.max(LEFT, (width - RIGHT - count * field) / 2);
    const [top, tall] = [14, 28];
    const { at, to } = this.spool(state);
    pen.globalAlpha = 0.35;
    pen.fillStyle = colours.kinds[this.motion.forces[state] > 0 ? 3 : 0];
    pen.fillRect(left + Math.min(at, count - 1) * field + 2, top + 2, field - 4, tall - 4);
    pen.globalAlpha = 1;
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.4;
    pen.strokeRect(left, top, count * field, tall);
    pen.textAlign = "center";
    for (let i = 0; i < count; i++) {
      pen.fillStyle = i === state ? colours.ink : colours.muted;
      const name = states[i].length > 12 ? `${states[i].slice(0, 11)}…` : states[i];
      pen.fillText(tr(name), left + (i + 0.5) * field, top + tall / 2 + 4.5);
    }
    pen.textAlign = "left";
    pen.fillStyle = colours.muted;
    if (to !== state) pen.fillText(tr(`ordered: ${states[to]}`), left + count * field + 8, top + tall / 2 + 4.5);
    return { left, right: left + count * field, bottom: top + tall };
  }

  /** Each port at its place in the housing, its line to the valve, and the place of the piston that it reads. */
  lines(pen, { edge, top, scale, box }, colours) {
    const { wall, bar, travel } = scale;
    this.ports.forEach((port, i) => {
      if (port.behind === null) return;
      const place = port.reads === "centre" ? this.centreOfMass() : port.reads;
      const x = wall - (1 - place) * bar - port.behind * travel;
      const mark = edge - (1 - place) * bar;
      const open = port.side === "back" ? mark < x : mark > x;
      const out = x < LEFT - 14;
      if (out) return;
      const joint = Math.min(Math.max(x, box.left + 6 + 8 * i), box.right - 6 - 8 * i);
      pen.strokeStyle = open ? colours.accent : colours.muted;
      pen.lineWidth = open ? 3 : 1.5;
      pen.setLineDash(open ? [] : [4, 3]);
      const bend = box.bottom + 12 + 9 * i;
      pen.beginPath();
      (pen.moveTo(x, top), pen.lineTo(x, bend), pen.lineTo(joint, bend), pen.lineTo(joint, box.bottom));
      pen.stroke();
      pen.setLineDash([]);
      pen.fillStyle = open ? colours.accent : colours.surface;
      pen.beginPath();
      pen.rect(x - 4, top - 4, 8, 8);
      pen.fill();
      pen.stroke();
      pen.fillStyle = colours.muted;
      pen.textAlign = i % 2 ? "left" : "right";
      pen.fillText(tr(`${i + 1} → ${port.to}`), x + (i % 2 ? 8 : -8), top - 8);
      pen.strokeStyle = colours.ink;
      pen.lineWidth = 2;
      pen.beginPath();
      (pen.moveTo(mark, top + 3), pen.lineTo(mark, top + 15));
      pen.stroke();
    });
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

/** When the spool travels, and from which state to which: from a demand to the change of the state. */
function spoolMoves({ valve, machine, ports, blows, period, first_state: first }, seconds) {
  const names = Object.keys(machine.states);
  return valve.map(({ time, to }, i) => {
    const from = i || !first ? valve.at(i - 1).to : first;
    const demanded = [
      ...ports.filter(({ port }) => machine.ports[port].to === to).map(({ port, time: at }) => [at, machine.ports[port].delay]),
      ...machine.ports.filter((port) => port.on === "impact" && port.to === to).flatMap(({ delay }) => blows.map((blow) => [blow.time, delay])),
    ];
    const late = ([at, delay]) => ((((time - at - delay + 0.5 * period) % period) + period) % period) - 0.5 * period;
    const asked = demanded.sort((a, b) => Math.abs(late(a)) - Math.abs(late(b)))[0];
    const travel = asked ? Math.max(asked[1] + late(asked), 0) : 0;
    const end = time >= travel ? time : time + period;
    return { begin: (end - travel) * seconds, end: end * seconds, from: names.indexOf(from), to: names.indexOf(to) };
  });
}
