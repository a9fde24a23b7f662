// The motion of a hammer that never restarts: it goes on from where it is, frame by frame, while its law changes under it.
//
// Between events it moves in closed form (`flight.js`), from one event to the next: an impact, q_j′ → −R q_j′ of all modes
// (B77 10); a step of the load; a port that the piston passes, an order of the valve that is due; the end of a rest. Bounces
// that pile up end in a rest on the wall (`chatterLeft`), where a hammer of one mode lies until the load pulls, and one of
// several until the wall would have to (`Lying`). What has settled is named as by `Trajectory.label` of the package.

import { chatterLeft, firstCrossing, Flight, Law, Lying, NO_SPEED } from "./flight.js";
import { MARKS, nameOf } from "./settled.js";

/** @typedef {import("./flight.js").Model} Model */
/** @typedef {{time: number, kind: "impact" | "rest" | "release" | "switch", speed: number, energy: number, phase: number,
 *   state?: string, chatter?: boolean}} Happening */
/** @typedef {import("./settled.js").Mark} Mark */
/** @typedef {{gap?: number, velocity?: number, phase?: number, disturbance?: number, places?: number[], rates?: number[],
 *   state?: string, demanded?: string, orders?: {after: number, to: string}[]}} Place */

const TURN = 2 * Math.PI;
const TURN_LOW = 2.4492935982947064e-16; // 2π less TURN
const KEPT = 30; // blows that are told
const CROWD = 300; // events in no time, after which a machine is stuck on a port
const NO_TIME = 1e-9; // of a period, or of a cycle
const SAME = 4e-12; // time, of the valve's unit, within which events are simultaneous

/** A port that watches the flight, or the wall. @typedef {{n: 0 | 1, level: number, sign: 1 | -1, clear: number,
 *   found: number}} Watch */

export class Live {
  /** @param {Model} model */
  constructor(model) {
    this.law = new Law(model);
    this.time = 0; // at the last event
    this.since = 0; // time since then
    this.period = 0;
    this.phase = 0;
    this.piece = 0;
    this.place_ = new Float64Array(this.law.size);
    this.rate_ = new Float64Array(this.law.size);
    this.gap_ = 0;
    this.resting = false;
    this.laid = 0; // when it was laid down last
    this.hold = 0; // time for which a flight just released is known to be free
    this.state = model.valve?.start ?? "";
    this.demanded = this.state;
    /** @type {{due: number, to: string}[]} */
    this.orders = [];
    /** @type {boolean[]} */
    this.inside = [];
    /** @type {{phase: number, speed: number}[]} */
    this.blows = [];
    this.records = true; // its marks: not of a scout
    this.crowd = 0; // events since the time `begun`, where no time goes by
    this.begun = -Infinity;
    this.changes = 0; // counts its laws and the states that it was put on
    /** @type {{live: Live, ahead: number, events: (Happening & {after: number})[]} | null} */
    this.scout = null;
    this.flight = new Flight(this.law, this.place_, this.rate_, 0, 0, 0);
    /** @type {Lying | null} */
    this.lying = null;
    /** @type {Watch[]} */
    this.watches = [];
    /** @type {Mark[]} */
    this.marks = [];
    /** @type {(Mark & {at: number})[]} */
    this.released = [];
    this.rests = this.chatters = this.struck = 0;
    this.place({});
  }

  // ---- Where it is

  get gap() {
    return this.resting ? 0 : this.flight.at(this.since)[0];
  }

  get velocity() {
    return this.resting ? 0 : this.flight.at(this.since)[1];
  }

  /** Whether its valve switches to and fro at a port without end: no time goes by any more. */
  get stuck() {
    return this.crowd >= CROWD;
  }

  /** Time gone by since it was made, in the unit of the model. */
  get now() {
    return this.time + this.since;
  }

  /** Phase of the load by now, in [0, 2π); 0 of a machine that switches itself. */
  get angle() {
    return this.law.valve ? 0 : (this.phase + this.since) % TURN;
  }

  /** The load by now, toward the wall; of a machine with the force of its chamber. */
  get force() {
    const { law } = this;
    if (law.valve) return this._constant() - law.square[0] * this.gap;
    return law.steps ? law.model.values[law.pieceAt(this.angle)] : law.loadAt(this.angle)[0];
  }

  /** The constant part of the load in this flight. */
  _constant() {
    const { law } = this;
    if (law.valve) return law.valve.states[this.state];
    return law.steps ? law.model.values[this.piece] : law.mean;
  }

  // ---- Changing the law, and the state

  /** Go on under another law: from this place and velocity, phase or state of the valve. @param {Model} model */
  become(model) {
    const [before, law] = [this.law, new Law(model)];
    this._arrive(this.since);
    const [was, is] = [before.model.scales, model.scales];
    const long = was && is ? was.length_m / is.length_m : 1; // lengths in bar lengths, times in radians of the load
    const slow = was && is ? was.time_s / is.time_s : 1;
    const [end, rate] = [(this.gap_ + before.gap) * long, sum(this.rate_) * (long / slow)];
    if (law.size === before.size && law.size > 1) {
      this.place_ = this.place_.map((q) => q * long);
      this.rate_ = this.rate_.map((v) => (v * long) / slow);
    } else {
      this.place_ = new Float64Array(law.size);
      this.rate_ = new Float64Array(law.size);
      this.place_[0] = end;
      this.rate_[0] = rate;
    }
    const gap = sum(this.place_) - law.gap;
    this.law = law;
    this.resting = this.resting && gap >= 0 && (law.size === 1 || law.size === before.size);
    this.orders = this.orders.filter(({ to }) => law.valve?.states[to] !== undefined);
    for (const order of this.orders) order.due *= slow;
    if (law.valve?.states[this.state] === undefined) this.demanded = this.state = law.valve?.start ?? "";
    if (law.valve?.states[this.demanded] === undefined) this.demanded = this.orders.at(-1)?.to ?? this.state;
    if (law.steps) this.piece = law.pieceAt(this.phase);
    this._put(Math.min(gap, 0));
    const ports = law.valve?.ports ?? [];
    const known = before.valve?.ports.length === ports.length ? this.inside : [];
    this.inside = ports.map((port) => this._occupied(port));
    ports.forEach((port, i) => this.inside[i] && !known[i] && this._demand(port)); // moved across the piston
    this._forget();
    this._set();
  }

  /** Put it on a state: at rest on the wall by default. A machine is asked by the ports that it covers at once, unless the
   * orders that wait are given; `disturbance` is a part of the velocity. @param {Place} state */
  place({ gap = 0, velocity = 0, phase, disturbance = 0, places, rates, state, demanded, orders }) {
    const { law } = this;
    this._arrive(this.since);
    this.place_.fill(0);
    this.rate_.fill(0);
    this.place_[0] = gap + law.gap;
    this.rate_[0] = velocity;
    if (places) this.place_.set(places);
    if (rates) this.rate_.set(rates);
    this.rate_ = this.rate_.map((v) => v * (1 + disturbance));
    if (phase !== undefined && !law.valve) this.phase = ((phase % TURN) + TURN) % TURN;
    if (law.steps) this.piece = law.pieceAt(this.phase);
    if (law.valve) this.state = state ?? law.valve.start;
    this.demanded = demanded ?? orders?.at(-1)?.to ?? this.state;
    this.orders = (orders ?? []).map(({ after, to }) => ({ due: after, to }));
    this.resting = law.size === 1 && gap === 0 && !places && !rates && velocity === 0;
    this._put(Math.min(sum(this.place_) - law.gap, 0));
    const ports = law.valve?.ports ?? [];
    this.inside = ports.map((port) => this._occupied(port));
    if (!orders) ports.forEach((port, i) => this.inside[i] && this._demand(port));
    this._forget();
    this._set();
  }

  /** The gap is what it is to the last bit: 0 at the wall. @param {number} gap */
  _put(gap) {
    this.gap_ = gap;
    this.place_[0] += gap - (sum(this.place_) - this.law.gap);
  }

  _flight() {
    return new Flight(this.law, this.place_, this.rate_, this.phase, this._constant(), this.gap_);
  }

  /** The flight from here on, and who watches it. */
  _set() {
    const { law } = this;
    this.flight = this._flight();
    this.lying =
      this.resting && law.size > 1 ? new Lying(law, this.place_, this.rate_, this.phase, this._constant()) : null;
    this.watches = [{ n: 0, level: 0, sign: 1, clear: this.hold, found: Infinity }];
    for (const [i, port] of (law.valve?.ports ?? []).entries()) {
      const [n, level, way] = edge(port);
      this.watches.push({
        n,
        level,
        sign: this.inside[i] ? (way === 1 ? -1 : 1) : way,
        clear: port.side ? 0 : Infinity,
        found: Infinity,
      });
    }
  }

  /** What was known of the motion is not known of the one to come. */
  _forget() {
    this.marks = [];
    this.released = [];
    this.rests = this.chatters = this.struck = 0;
    this.scout = null;
    this.crowd = 0;
    this.begun = -Infinity;
    this.changes += 1;
  }

  // ---- Ports and orders

  /** @param {import("./flight.js").Port} port */
  _occupied(port) {
    if (!port.side) return false;
    const [n, level, way] = edge(port);
    return way * ((n ? sum(this.rate_) : this.gap_) - level) > 0;
  }

  /** A port demands its state: ignored when it was demanded last; else it replaces what would come after it.
   * @param {import("./flight.js").Port} port */
  _demand(port) {
    if (port.to === this.demanded) return;
    this.demanded = port.to;
    this.orders = this.orders.filter(({ due }) => due < port.delay);
    this.orders.push({ due: port.delay, to: port.to });
  }

  // ---- Time goes on

  /** Go on by a time; what has happened. @param {number} dt @returns {Happening[]} */
  advance(dt) {
    /** @type {Happening[]} */
    const events = [];
    if (this.scout) {
      this.scout.ahead -= dt;
      this.scout.events = this.scout.events.filter((event) => (event.after -= dt) > 0);
      if (this.scout.ahead < 0) this.scout = null;
    }
    for (let left = dt; left > 0 && !this.stuck;) {
      const [wait, what] = this._next(left + this.since);
      const part = wait - this.since;
      if (part > left || what === null) {
        this.since += left;
        break;
      }
      left -= Math.max(part, 0);
      this._arrive(wait);
      this.crowd = this.time - this.begun > 8 * NO_TIME * this._cycle() ? 0 : this.crowd + 1;
      if (!this.crowd) this.begun = this.time;
      what(events);
      this._set();
    }
    return events;
  }

  /** What happens within the next time, without moving on; `after` says in how long. @param {number} dt */
  ahead(dt) {
    if (!this.scout) this.scout = { live: this._copy(), ahead: 0, events: [] };
    const { scout } = this;
    if (dt > scout.ahead) {
      const from = scout.live.now - scout.ahead;
      for (const event of scout.live.advance(dt - scout.ahead))
        scout.events.push({ ...event, after: event.time - from });
      scout.ahead = dt;
    }
    return scout.events.filter(({ after }) => after <= dt);
  }

  _copy() {
    const copy = /** @type {Live} */ (Object.create(Live.prototype));
    Object.assign(copy, this, {
      records: false,
      scout: null,
      marks: [],
      released: [],
      blows: [],
      inside: [...this.inside],
    });
    copy.place_ = this.place_.slice();
    copy.rate_ = this.rate_.slice();
    copy.orders = this.orders.map((order) => ({ ...order }));
    copy.watches = this.watches.map((watch) => ({ ...watch }));
    return copy;
  }

  /** Time from the last event to the next one, as far as `until`, and what it does.
   * @param {number} until @returns {[number, ((events: Happening[]) => void) | null]} */
  _next(until) {
    const { law } = this;
    let [wait, what] = /** @type {[number, ((events: Happening[]) => void) | null]} */ ([until, null]);
    const due = this.orders.length ? this.orders[0].due : Infinity;
    if (due <= wait) [wait, what] = [due, (events) => this._switch(events)];
    if (law.steps && (!this.resting || this.lying)) {
      const step = this._toStep();
      if (step <= wait) [wait, what] = [step, () => this._step()];
    }
    if (this.resting) {
      const release = this.lying ? this.lying.release(wait) : law.release(this.phase, this._constant());
      if (release <= wait) [wait, what] = [Math.max(release, this.since), (events) => this._let(events)];
      return [wait, what];
    }
    const settled = this._atWall(Math.min(due, law.steps ? this._toStep() : Infinity));
    if (settled >= 0)
      return settled < due && settled <= wait ? [settled, (events) => this._rest(events)] : [wait, what];
    for (let i = this.watches.length - 1; i >= 0; i--) {
      const found = this._seek(this.watches[i], wait + SAME);
      if (found > wait + (i ? -SAME : SAME)) continue; // of simultaneous events the blow comes first, then the ports in turn
      wait = found;
      what = i ? () => this._pass(i - 1) : (events) => this._strike(events);
    }
    return [wait, what];
  }

  /** @param {Watch} watch @param {number} until */
  _seek(watch, until) {
    if (watch.found < Infinity || watch.clear > until) return watch.found;
    watch.found = firstCrossing(this.flight, watch.n, watch.level, watch.sign, watch.clear, until);
    if (watch.found === Infinity) watch.clear = this.flight.clear;
    return watch.found;
  }

  /** The state after τ is where the next flight begins. @param {number} tau */
  _arrive(tau) {
    if (!(tau > 0)) return;
    if (this.lying) [this.place_, this.rate_] = this.lying.modes(tau);
    else if (!this.resting) {
      const gap = this.flight.at(tau)[0];
      [this.place_, this.rate_] = this.flight.modes(tau);
      this._put(gap);
    }
    this.time += tau;
    this.since = 0;
    this.hold = Math.max(this.hold - tau, 0);
    for (const order of this.orders) order.due -= tau;
    if (this.law.valve) return;
    const step = this.law.steps && (!this.resting || this.lying) ? this._toStep() : Infinity;
    const phase = this.phase + tau;
    const turns = Math.floor(phase / TURN);
    this.period += turns;
    this.phase = Math.max(phase - turns * TURN - turns * TURN_LOW, 0);
    if (this.law.steps && this.resting && !this.lying) this.piece = this.law.pieceAt(this.phase);
    else if (tau <= step && step < Infinity && this._toStep() > step) this.phase = this._nextBreak(); // rounded past it
  }

  /** Time to the next step of the load. */
  _toStep() {
    const { breaks } = this.law.model;
    const next = this.piece + 1;
    if (next < breaks.length) return Math.max(breaks[next] - this.phase, 0);
    return breaks[0] - this.phase + (breaks[0] >= this.phase ? 0 : TURN);
  }

  /** @param {number} phase where the load is known to be */
  _clock(phase) {
    this.period += Math.round((this.phase - phase) / TURN);
    this.phase = phase;
    if (this.law.steps) this.piece = this.law.pieceAt(phase);
  }

  _nextBreak() {
    const { breaks } = this.law.model;
    return breaks[(this.piece + 1) % breaks.length];
  }

  _step() {
    this._clock(this._nextBreak());
  }

  // ---- What happens at the wall

  /** What a hammer on the wall does: −1 when it flies, else the time after which it lies still.
   * @param {number} horizon */
  _atWall(horizon) {
    if (this.gap_ < 0 || this.hold > 0) return -1;
    const { law, flight } = this;
    const [, v, a] = flight.at(0);
    const slow = NO_SPEED * flight.speed;
    if (v > slow) return -1; // it strikes at once
    const push = law.size > 1 ? a : law.press(law.steps || law.valve ? this._constant() : law.loadAt(this.phase)[0]);
    if (v >= -slow) return push >= 0 ? 0 : -1;
    const r = law.restitution;
    if (r >= 1 || r === 0 || !(push > 0)) return -1;
    return chatterLeft(law, flight, -v, push, horizon);
  }

  /** @param {Happening[]} events */
  _strike(events) {
    const { law } = this;
    const speed = sum(this.rate_);
    let energy = 0;
    for (let j = 0; j < law.size; j++) energy += 0.5 * law.inertia[j] * this.rate_[j] ** 2;
    this.rate_ = this.rate_.map((v) => -law.restitution * v);
    this._put(0);
    this.hold = 0;
    this.struck += 1;
    const event = this._told(events, "impact", speed, energy);
    this.blows.push({ phase: event.phase, speed });
    if (this.blows.length > KEPT) this.blows.shift();
    if (!law.valve) this._mark(event);
    for (const [i, port] of (law.valve?.ports ?? []).entries())
      if (port.on === "impact") this._demand(port);
      else if (port.behind === null) this.inside[i] = this._occupied(port); // a velocity that jumps passes nothing
  }

  /** @param {Happening[]} events */
  _rest(events) {
    const chatter = this.law.restitution > 0;
    this.rate_.fill(0);
    this._put(0);
    this.resting = true;
    this.laid = this.time;
    this.rests += 1;
    if (chatter) this.chatters += 1;
    const event = this._told(events, "rest", 0, 0);
    event.chatter = chatter;
    for (const port of this.law.valve?.ports ?? []) if (chatter && port.on === "impact") this._demand(port);
  }

  /** @param {Happening[]} events */
  _let(events) {
    const { law } = this;
    const at = law.releases.findIndex(
      (phase) => Math.abs(phase - this.phase) < 1e-9 || TURN - Math.abs(phase - this.phase) < 1e-9,
    );
    if (at >= 0) this._clock(law.releases[at]);
    this.resting = false;
    this.hold = this.lying ? this.lying.parts(this._flight(), this.lying.found) : law.pulls(this.phase);
    const event = this._told(events, "release", 0, 0);
    this.released.push({ ...this._mark_(event), at, shape: [...this.place_, ...this.rate_] });
    if (this.released.length > MARKS) this.released.shift();
  }

  // ---- What happens at the valve

  /** @param {Happening[]} events */
  _switch(events) {
    const order = this.orders.shift();
    if (!order) return;
    const before = this.state;
    this.state = order.to;
    if (this.state === before) return;
    const event = this._told(events, "switch", sum(this.rate_), 0);
    event.state = this.state;
    this._mark(event);
  }

  /** A port's edge is passed. @param {number} i */
  _pass(i) {
    this.inside[i] = !this.inside[i];
    if (this.inside[i] && this.law.valve) this._demand(this.law.valve.ports[i]);
  }

  // ---- What is told

  /** What the motion is by now, as the package names it; "" while it has not settled. */
  label() {
    return nameOf(this);
  }

  /** A period of the load, or about the time of a cycle of a machine. */
  _cycle() {
    const { valve } = this.law;
    if (!valve) return TURN;
    const same = this.marks.filter(({ state }) => state === this.state);
    if (same.length > 1) return (same[same.length - 1].time - same[0].time) / (same.length - 1);
    const way = Math.max(...valve.ports.map(({ behind }) => behind ?? 0));
    const push = Math.min(...Object.values(valve.states).map(Math.abs).filter(Boolean));
    return 4 * Math.sqrt(way / push) || 1 / 8;
  }

  /** @param {Happening[]} events @param {Happening["kind"]} kind @param {number} speed @param {number} energy */
  _told(events, kind, speed, energy) {
    /** @type {Happening} */
    const event = { time: this.time, kind, speed, energy, phase: this.phase };
    events.push(event);
    return event;
  }

  /** @param {Happening} event @returns {Mark} */
  _mark_({ speed, time, phase }) {
    const { period, state, struck: blows, rests, chatters } = this;
    return { phase, speed, period, time, state, gap: this.gap_, blows, rests, chatters, orders: this.orders.length };
  }

  /** @param {Happening} event */
  _mark(event) {
    if (!this.records) return;
    this.marks.push(this._mark_(event));
    if (this.marks.length > MARKS) this.marks.shift();
  }
}

/** Which derivative a port watches, at which level, and which way it enters its region.
 * @param {import("./flight.js").Port} port @returns {[0 | 1, number, 1 | -1]} */
function edge({ behind, speed, side }) {
  const way = side === "front" ? 1 : -1;
  return behind !== null ? [0, -behind, way] : [1, way * (speed ?? 0), way];
}

/** @param {Float64Array} values */
function sum(values) {
  let total = 0;
  for (let i = 0; i < values.length; i++) total += values[i];
  return total;
}
