// One flight of a hammer in closed form, and the first time at which something of it crosses a level.
//
// A hammer is told by modes q_j, what each moves its striking end by: q_j″ + d_j q_j′ + ω_j² q_j = γ_j p(t), and its gap is
// y = Σ q_j − g ≤ 0. A rigid free bar is one mode with ω = 0; a piston on the gas of a chamber one with ω² = κ. The load p
// is constant for the flight, or a Fourier series Re Σ p_k e^{ikθ}. Everything is an increment since the flight began, so
// that bounces of a millionth keep their digits:
//
//   free part      x(τ) − x₀ = v₀ S + (f − ω² x₀) Ψ,  x′ = v₀ S′ + (f − ω² x₀) S,
//                  S = e^{−dτ/2} sin λτ / λ, λ² = ω² − d²/4, Ψ = ∫S, S′ = 1 − d S − ω² Ψ
//   forced part    Re Σ B_k (e^{ikτ} − 1),  B_k = Σ_j γ_j p_k e^{ikθ}/(ω_j² − k² + i k d_j);  E_k = e^{ikτ} − 1 by the
//                  recurrence E_{k+1} = E_k + E_1 + E_k E_1
//
// The search for a crossing steps as far as a bound says that none can be: with r, r′, r″ known and |r″| ≤ M, |r‴| ≤ J for
// the rest of the flight, r stays below 0 while r + r′h + r″h²/2 + Jh³/6 and r + r′h + Mh²/2 do. It converges on a crossing
// from below, as Newton's method does, and passes a near miss in a few steps; nothing is sampled, so nothing is missed.

const EPS = 2 ** -52;
const SMALL = 0.1; // (ω + d) τ below which S, Ψ and S′ are summed as power series
const TERMS = 11;
const MOST_STEPS = 20_000;
const CHATTER_ERROR = 1e-12; // to which the end of chatter is known
export const NO_SPEED = 1e-13; // of the speeds that occur: a velocity that is none

/**
 * A hammer and its load as `motion` of POST /api/case has it.
 * @typedef {object} Model
 * @property {number[]} omega undamped frequencies ω_j, 0 of a rigid motion
 * @property {number[]} damping d_j
 * @property {number[]} drive γ_j
 * @property {number[]} inertia modal masses: the kinetic energy is ½ Σ m_j q_j′²
 * @property {number} gap where the wall stands, Σ q_j = g
 * @property {number} restitution R
 * @property {[number, number][]} coefficients p_0, p_1, … of a load with a clock
 * @property {number[]} breaks phases from which a load of steps has its `values`; both empty of a Fourier series
 * @property {number[]} values
 * @property {ValveModel | null} valve in place of a clock
 * @property {{exponents: number[], forth: number[], back: number[]} | null} [lying] of several modes while the wall holds
 *   them, see `Lying`
 * @property {{length_m: number, time_s: number} | null} [scales] SI units of length and time
 */
/**
 * @typedef {object} ValveModel
 * @property {Record<string, number>} states force of each state at the wall
 * @property {Port[]} ports
 * @property {string} start
 */
/**
 * @typedef {object} Port
 * @property {string} to
 * @property {number | null} behind
 * @property {number | null} speed
 * @property {"back" | "front" | null} side
 * @property {number} delay
 * @property {"entering" | "impact"} on
 */

/** What a model says, as numbers ready for use: the law of every flight under it. */
export class Law {
  /** @param {Model} model */
  constructor(model) {
    this.model = model;
    this.size = model.omega.length;
    this.damping = Float64Array.from(model.damping);
    this.square = Float64Array.from(model.omega, (omega) => omega * omega);
    this.drive = Float64Array.from(model.drive);
    this.inertia = Float64Array.from(model.inertia);
    this.gap = model.gap;
    this.restitution = model.restitution;
    this.valve = model.valve;
    this.steps = model.breaks.length > 0;
    const series = model.valve || this.steps ? [] : model.coefficients;
    this.mean = model.coefficients[0]?.[0] ?? 0;
    this.K = Math.max(series.length - 1, 0);
    /** p_k, k = 1 … K, real and imaginary parts in turn */
    this.load = new Float64Array(2 * this.K);
    for (let k = 1; k <= this.K; k++) this.load.set(series[k], 2 * k - 2);
    this.force = this.steps ? Math.max(...model.values.map(Math.abs)) : Math.abs(this.mean);
    this.bend = 0; // bound of |p″|
    for (let k = 1; k <= this.K; k++) {
      const size = Math.hypot(series[k][0], series[k][1]);
      this.force += size;
      this.bend += k * k * size;
    }
    /** H_jk, what harmonic k of 1 moves q_j by, real and imaginary parts in turn, mode after mode */
    this.response = new Float64Array(2 * this.K * this.size);
    for (let j = 0; j < this.size; j++)
      for (let k = 1; k <= this.K; k++) {
        let re = this.square[j] - k * k;
        const im = k * this.damping[j];
        if (Math.hypot(re, im) < 1e-9 * k * k) re = 1e-9 * k * k; // undamped resonance: grows all the same
        const [by, at] = [this.drive[j] / (re * re + im * im), 2 * (this.K * j + k - 1)];
        this.response[at] = re * by;
        this.response[at + 1] = -im * by;
      }
    const bears = this.drive.reduce((sum, one) => sum + one, 0);
    this.bears = this.size > 1 ? 0 : bears; // what of the load presses a hammer of one mode at rest on the wall …
    this.hold = this.size > 1 ? 0 : this.square[0] * this.gap; // … less what its spring pulls
    this.releases = this.steps ? this._stepReleases() : this._releases();
  }

  /** p and p′ at a phase, of a Fourier series. @param {number} phase @returns {[number, number]} */
  loadAt(phase) {
    const [c, s] = [Math.cos(phase), Math.sin(phase)];
    let [re, im, p, rate] = [1, 0, this.mean, 0];
    for (let k = 1, i = 0; k <= this.K; k++, i += 2) {
      [re, im] = [re * c - im * s, re * s + im * c];
      p += this.load[i] * re - this.load[i + 1] * im;
      rate -= k * (this.load[i] * im + this.load[i + 1] * re);
    }
    return [p, rate];
  }

  /** p_k e^{ikθ}, real and imaginary parts in turn. @param {number} phase */
  turned(phase) {
    const { load, K } = this;
    const turned = new Float64Array(2 * K);
    const [c, s] = [Math.cos(phase), Math.sin(phase)];
    let [re, im] = [1, 0];
    for (let i = 0; i < 2 * K; i += 2) {
      [re, im] = [re * c - im * s, re * s + im * c];
      turned[i] = load[i] * re - load[i + 1] * im;
      turned[i + 1] = load[i] * im + load[i + 1] * re;
    }
    return turned;
  }

  /** The number of the step of the load that holds at a phase. @param {number} phase */
  pieceAt(phase) {
    const { breaks } = this.model;
    let piece = breaks.length - 1;
    for (let i = 0; i < breaks.length; i++) if (breaks[i] <= phase) piece = i;
    return piece;
  }

  /** By how much a hammer of one mode at rest is pressed on the wall by a load. @param {number} p */
  press(p) {
    return this.bears * p - this.hold;
  }

  /** Time from a phase on until the load pulls a hammer at rest off the wall; infinite when it never does.
   * @param {number} phase @param {number} force the constant part of the load then */
  release(phase, force) {
    if ((this.valve || this.steps) && this.press(force) < 0) return 0;
    if (!this.valve && !this.steps) {
      const [p, rate] = this.loadAt(phase);
      const least = 64 * EPS * this.force;
      if (this.press(p) < -least || (this.press(p) <= least && this.bears * rate < 0)) return 0;
    }
    if (this.valve || !this.releases.length) return Infinity;
    const next = this.releases.find((one) => one >= phase) ?? this.releases[0] + 2 * Math.PI;
    return next - phase;
  }

  /** A time from a release on for which the load surely pulls: 0 when it jumps to a pull. @param {number} phase */
  pulls(phase) {
    if (this.valve || this.steps) return 0;
    const bend = this.bend * Math.abs(this.bears);
    const [p, rate] = this.loadAt(phase);
    const [a, b] = [-Math.min(this.press(p), 0), -this.bears * rate]; // a + b h − bend h²/2 is less than the pull
    const lasts = bend > 0 ? (b + Math.sqrt(b * b + 2 * bend * a)) / bend : 1;
    const swing = this.square[0] > 0 ? 0.5 / Math.sqrt(this.square[0]) : 1;
    return 0.5 * Math.min(Math.max(lasts, 1e-7), swing, 1);
  }

  _stepReleases() {
    const { breaks, values } = this.model;
    return breaks.filter((_, i) => this.press(values[i]) < 0 && this.press(values.at(i - 1) ?? 0) >= 0);
  }

  /** Phases at which the pressure turns to a pull, ascending; stepped over with the bound of p″, like a flight. */
  _releases() {
    /** @type {number[]} */
    const found = [];
    if (!(this.bend > 0) || this.size > 1) return found;
    const sign = Math.sign(this.bears) || 1;
    const bend = this.bend * Math.abs(this.bears);
    const least = 64 * EPS * this.force;
    const look = (/** @type {number} */ t) => {
      const [p, rate] = this.loadAt(t);
      return [this.press(p), this.bears * rate];
    };
    let [t, pushed, blind] = [0, -1, 1e-9];
    while (sign && t < 2 * Math.PI + 1e-6) {
      const [f, rate] = look(t);
      if (f > least) {
        pushed = t;
        t += Math.max(reach(-f, -rate, bend), 1e-15);
      } else if (f < -least) {
        if (pushed >= 0) {
          let [low, high] = [pushed, t];
          for (let i = 0; i < 100 && low < high; i++) {
            const middle = 0.5 * (low + high);
            if (look(middle)[0] > 0) low = middle;
            else high = middle;
          }
          found.push(high % (2 * Math.PI));
        }
        pushed = -1;
        t += Math.max(reach(f, rate, bend), 1e-15);
      } else {
        t += blind;
        blind *= 2;
        continue;
      }
      blind = 1e-9;
    }
    return found.sort((a, b) => a - b);
  }
}

/** How far u + v h + m h²/2 stays below 0 from h = 0 on. @param {number} u @param {number} v @param {number} m */
export function reach(u, v, m) {
  if (u > 0 || (u === 0 && v >= 0)) return 0;
  const root = Math.sqrt(Math.max(v * v - 2 * m * u, 0));
  if (v >= 0) return v + root > 0 ? (-2 * u) / (v + root) : Infinity;
  return m > 0 ? (root - v) / m : Infinity;
}

/** How far u + v h + a h²/2 + j h³/6 does: on [0, H] the last term is at most (j H/3) h²/2, a parabola for each H tried.
 * @param {number} u @param {number} v @param {number} a @param {number} j @param {number} m a bound of the curvature */
function reachCubic(u, v, a, j, m) {
  let best = reach(u, v, m);
  if (j === 0) return Math.max(best, reachParabola(u, v, a));
  let width = Math.max(4 * best, a < 0 ? Math.min((-1.5 * a) / j, 1e9) : 0);
  for (let i = 0; i < 4 && width > best; i++, width *= 0.5)
    best = Math.max(best, Math.min(width, reachParabola(u, v, a + (j * width) / 3)));
  return best;
}

/** As `reach`, for a curvature of either sign: infinite where the top of the parabola lies below 0.
 * @param {number} u @param {number} v @param {number} m */
function reachParabola(u, v, m) {
  if (m >= 0) return reach(u, v, m);
  if (v <= 0 || v * v < 2 * m * u) return u < 0 || v <= 0 ? Infinity : 0;
  return reach(u, v, m);
}

/** S, Ψ and S′ of a mode after τ, into `out`. @param {number} d @param {number} square ω² @param {number} tau
 * @param {Float64Array} out */
function basis(d, square, tau, out) {
  if ((Math.sqrt(square) + d) * tau < SMALL) {
    let [before, now, power, S, P, R] = [0, 1, tau, 0, 0, 0];
    for (let n = 1; n <= TERMS; n++) {
      S += now * power; // aₙ τⁿ
      R += n * now * (power / tau || (n === 1 ? 1 : 0));
      P += (now * power * tau) / (n + 1);
      [before, now] = [now, -(n * d * now + square * before) / (n * (n + 1))];
      power *= tau;
    }
    out[0] = S;
    out[1] = P;
    out[2] = R;
    return;
  }
  const half = 0.5 * d;
  const lambda2 = square - half * half;
  const fade = Math.exp(-half * tau);
  let [S, R] = [0, 0];
  if (square === 0) {
    S = d > 0 ? -Math.expm1(-d * tau) / d : tau;
    R = 1 - d * S;
    out[1] = d > 0 ? (tau - S) / d : 0.5 * tau * tau;
  } else {
    if (lambda2 > 1e-12 * square) {
      const lambda = Math.sqrt(lambda2);
      S = (fade * Math.sin(lambda * tau)) / lambda;
      R = fade * Math.cos(lambda * tau) - half * S;
    } else if (lambda2 < -1e-12 * square) {
      const mu = Math.sqrt(-lambda2);
      const [slow, fast] = [Math.exp((mu - half) * tau), Math.exp(-(mu + half) * tau)];
      S = (slow - fast) / (2 * mu);
      R = 0.5 * (slow + fast) - half * S;
    } else {
      S = tau * fade;
      R = fade - half * S;
    }
    out[1] = (1 - R - d * S) / square;
  }
  out[0] = S;
  out[2] = R;
}

/** From a state on: places and velocities of the modes, the phase of the load, its constant part. */
export class Flight {
  /** @param {Law} law @param {Float64Array} place @param {Float64Array} rate @param {number} phase
   * @param {number} force the constant part of the load @param {number} gap Σ q − g, exactly 0 at the wall */
  constructor(law, place, rate, phase, force, gap) {
    const { size, K } = law;
    this.law = law;
    this.place = place;
    this.rate = rate;
    this.phase = phase;
    this.force = force;
    this.gap = gap;
    this.out = new Float64Array(4);
    this.s = new Float64Array(3);
    /** free part of each mode: v₀ and f − ω² x₀ in turn */
    this.free = new Float64Array(2 * size);
    /** B_k e^{ikθ}, real and imaginary parts in turn */
    this.waves = new Float64Array(2 * K);
    this.clear = 0; // how far the last search has shown that there is nothing
    this.speed = 0; // a bound of |y′|, by which rounding is measured
    /** bounds of |y″|, |y‴| and |y⁗| */
    this.bounds = new Float64Array(3);
    const turned = law.turned(phase);
    for (let j = 0; j < size; j++) {
      let [x, v] = [place[j], rate[j]];
      for (let k = 1, i = 0, at = 2 * K * j; k <= K; k++, i += 2, at += 2) {
        const re = law.response[at] * turned[i] - law.response[at + 1] * turned[i + 1];
        const im = law.response[at] * turned[i + 1] + law.response[at + 1] * turned[i];
        this.waves[i] += re;
        this.waves[i + 1] += im;
        x -= re;
        v += k * im;
      }
      const [d, square, push] = [law.damping[j], law.square[j], law.drive[j] * force];
      const g = push - square * x;
      this.free.set([v, g], 2 * j);
      if (square === 0) {
        const a = Math.abs(push - d * v);
        this.speed += d > 0 ? Math.max(Math.abs(v), Math.abs(push / d)) : Math.abs(v);
        this._bound(a, d * a, d * d * a);
      } else {
        const omega = Math.sqrt(square);
        const swing = Math.hypot(g / omega, v); // ≥ |z′| and ω|z| for ever
        const a = (omega + d) * swing;
        const third = d * a + square * swing;
        this.speed += swing;
        this._bound(a, third, d * third + square * a);
      }
    }
    for (let k = 1, i = 0; k <= K; k++, i += 2) {
      const size = k * Math.hypot(this.waves[i], this.waves[i + 1]);
      this.speed += size;
      this._bound(k * size, k * k * size, k ** 3 * size);
    }
  }

  /** @param {number} second @param {number} third @param {number} fourth */
  _bound(second, third, fourth) {
    this.bounds[0] += second;
    this.bounds[1] += third;
    this.bounds[2] += fourth;
  }

  /** y, y′, y″ after τ, and y‴ under a constant load, into `out`. @param {number} tau */
  at(tau) {
    const { law, out, s, waves } = this;
    let [y, v, a, b] = [this.gap, 0, 0, 0];
    for (let j = 0, i = 0; j < law.size; j++, i += 2) {
      basis(law.damping[j], law.square[j], tau, s);
      const [v0, g] = [this.free[i], this.free[i + 1]];
      const own = v0 * s[2] + g * s[0];
      const step = v0 * s[0] + g * s[1];
      const curve = g - law.square[j] * step - law.damping[j] * own;
      y += step;
      v += own;
      a += curve;
      b -= law.damping[j] * curve + law.square[j] * own;
    }
    if (law.K) {
      const half = Math.sin(0.5 * tau);
      const [er, ei] = [-2 * half * half, Math.sin(tau)];
      let [re, im] = [0, 0];
      for (let k = 1, i = 0; k <= law.K; k++, i += 2) {
        [re, im] = [re + er + re * er - im * ei, im + ei + re * ei + im * er];
        const [wr, wi] = [waves[i], waves[i + 1]];
        const turned = wr * re - wi * im;
        y += turned;
        v -= k * (wr * im + wi * (1 + re));
        a -= k * k * (wr + turned);
      }
    }
    out[0] = y;
    out[1] = v;
    out[2] = a;
    out[3] = b;
    return out;
  }

  /** Place and velocity of every mode after τ. @param {number} tau  */
  modes(tau) {
    const { law, s } = this;
    const [place, rate] = [Float64Array.from(this.place), new Float64Array(law.size)];
    const turned = law.turned(this.phase);
    for (let j = 0, i = 0; j < law.size; j++, i += 2) {
      basis(law.damping[j], law.square[j], tau, s);
      place[j] += this.free[i] * s[0] + this.free[i + 1] * s[1];
      rate[j] = this.free[i] * s[2] + this.free[i + 1] * s[0];
      for (let k = 1, n = 0, at = 2 * law.K * j; k <= law.K; k++, n += 2, at += 2) {
        const wr = law.response[at] * turned[n] - law.response[at + 1] * turned[n + 1];
        const wi = law.response[at] * turned[n + 1] + law.response[at + 1] * turned[n];
        const half = Math.sin(0.5 * k * tau);
        const [re, im] = [-2 * half * half, Math.sin(k * tau)];
        place[j] += wr * re - wi * im;
        rate[j] -= k * (wr * im + wi * (1 + re));
      }
    }
    return [place, rate];
  }
}

/** The time until bounces have piled up, after a rebound w under a pressure P = `push` that changes at the rate j:
 * T₀ (1 − d T₀/6 − j T₀/(3P)), T₀ = 2w/((1 − R)P); −1 while it is not known to `CHATTER_ERROR`, or may last beyond the
 * horizon.
 * @param {Law} law @param {Flight} flight @param {number} w @param {number} push @param {number} horizon */
export function chatterLeft(law, flight, w, push, horizon) {
  const several = law.size > 1;
  const left = (2 * w) / ((1 - law.restitution) * push);
  const jerk = several ? flight.bounds[1] : law.bears * (law.K ? law.loadAt(flight.phase)[1] : 0);
  const d = several ? 0 : law.damping[0];
  const curl = law.square[0] + law.bend / push; // what the first order leaves out
  const known = ((Math.abs(jerk) / push + d) * left) ** 2 + curl * left * left;
  const unknown = several ? (Math.abs(jerk) * left) / push : 0;
  if (2 * left > horizon || known + unknown > 0.1 || (known + unknown) * left > CHATTER_ERROR) return -1;
  return several ? left : left * (1 - (d * left) / 6 - (jerk * left) / (3 * push));
}

/** The first time from `from` to `until` at which the n-th derivative of a motion passes a level upwards (`sign` 1) or
 * downwards (−1); infinite when there is none before its `clear`.
 * @param {{at: (tau: number) => Float64Array, bounds: Float64Array, speed: number, clear: number}} motion
 * @param {0 | 1} n @param {number} level @param {1 | -1} sign @param {number} from @param {number} until */
export function firstCrossing(motion, n, level, sign, from, until) {
  const { bounds, speed } = motion;
  const [m, j] = [bounds[n], bounds[n + 1]];
  const [top, noise] = [2 * EPS * (n ? speed : 0), 2 * EPS * (n ? m : speed)];
  let t = from;
  for (let i = 0; i < MOST_STEPS; i++) {
    const out = motion.at(t);
    let [r, rate, curve] = [sign * (out[n] - level), sign * out[n + 1], sign * out[n + 2]];
    if (t === 0 && Math.abs(rate) <= NO_SPEED * (n ? m : speed)) rate = 0;
    const least = top + noise * t + EPS * Math.abs(level);
    if (r >= 0 && rate > 0) return t > from ? Math.max(t - r / rate, from) : t;
    const next = t + reachCubic(Math.min(r, 0), rate, curve, j, m);
    if (r >= -least && rate > 0) return next;
    if (next > until) {
      motion.clear = next;
      return Infinity;
    }
    t = next > t ? next : t * (1 + 2 * EPS) + 1e-300;
  }
  return t; // it creeps along the level: a touch
}

// A structure of several modes while the wall holds its contact: another linear system, closed form again (the package's
// `mechanics.held_structure`). Its free motion is Σ a_i e^{μ_i τ}; `lying` of the model has the exponents μ_i, and what
// turns places and velocities q_n, q_n′ into amounts a_i (`forth`) and back:
//
//   a_i′ = μ_i a_i + b_i p + c_i,  b_i = Σ_n forth_in γ_n,  c_i = −Σ_n forth_in ω_n² g_n   (forth of the velocities)
//   q_n = g_n + Re Σ_i back_in a_i,   g_n = g (1/m_n)/Σ 1/m_n
//
// The force of the wall, F = Σ (γ_n p − d_n q_n′ − ω_n² q_n)/Σ 1/m_n, is a constant, exponentials and harmonics, too: the
// structure leaves where F turns from push to pull, which `firstCrossing` finds.

export class Lying {
  /** @param {Law} law @param {Float64Array} place @param {Float64Array} rate @param {number} phase
   * @param {number} force the constant part of the load */
  constructor(law, place, rate, phase, force) {
    const lying = law.model.lying ?? { exponents: [], forth: [], back: [] };
    const { size, K } = law;
    this.law = law;
    this.back = lying.back;
    this.exponents = lying.exponents;
    this.out = new Float64Array(4);
    this.clear = 0;
    this.found = Infinity;
    const soft = sum(law.inertia.map((m) => 1 / m));
    this.soft = soft;
    this.still = law.inertia.map((m) => law.gap / m / soft);
    const count = lying.exponents.length / 2;
    /** amounts of the exponentials, of the constant and of each harmonic; each re, im in turn */
    this.fading = new Float64Array(2 * count);
    this.constant = new Float64Array(2 * count);
    this.waves = new Float64Array(2 * count * K);
    /** of −F, r = steady + Re Σ faded e^{μτ} + Re Σ_k waved e^{ikτ} */
    this.faded = new Float64Array(2 * count);
    this.waved = new Float64Array(2 * K);
    this.steady = -(sum(law.drive) * force - dot(law.square, this.still)) / soft;
    this.bounds = new Float64Array(3); // of the second derivative of −F and the ones after it
    this.speed = 0;
    const turned = law.turned(phase);
    for (let k = 0; k < 2 * K; k++) this.waved[k] = (-sum(law.drive) * turned[k]) / soft;
    for (let i = 0; i < count; i++) {
      const [mr, mi] = [lying.exponents[2 * i], lying.exponents[2 * i + 1]];
      const [b, c, a, f] = [
        [0, 0],
        [0, 0],
        [0, 0],
        [0, 0],
      ];
      for (let n = 0; n < size; n++)
        for (const part of [0, 1]) {
          const at = 4 * (size * i + n) + part;
          b[part] += lying.forth[at + 2] * law.drive[n];
          c[part] -= lying.forth[at + 2] * law.square[n] * this.still[n];
          a[part] += lying.forth[at] * (place[n] - this.still[n]) + lying.forth[at + 2] * rate[n];
          f[part] += (law.damping[n] * lying.back[at + 2] + law.square[n] * lying.back[at]) / soft; // of −F
        }
      const own = over([-b[0] * force - c[0], -b[1] * force - c[1]], [mr, mi]);
      this.constant.set(own, 2 * i);
      a[0] -= own[0];
      a[1] -= own[1];
      this.steady += f[0] * own[0] - f[1] * own[1];
      for (let k = 1; k <= K; k++) {
        const wave = over(times(b, [turned[2 * k - 2], turned[2 * k - 1]]), [-mr, k - mi]);
        this.waves.set(wave, 2 * (K * i + k - 1));
        a[0] -= wave[0];
        a[1] -= wave[1];
        const part = times(f, wave);
        this.waved[2 * k - 2] += part[0];
        this.waved[2 * k - 1] += part[1];
      }
      this.fading.set(a, 2 * i);
      const part = times(f, a);
      this.faded.set(part, 2 * i);
      this._bound(Math.hypot(...part), Math.hypot(mr, mi));
    }
    for (let k = 1; k <= K; k++) this._bound(Math.hypot(this.waved[2 * k - 2], this.waved[2 * k - 1]), k);
  }

  /** @param {number} size @param {number} pace */
  _bound(size, pace) {
    this.speed += size * pace;
    for (let n = 0; n < 3; n++) this.bounds[n] += size * pace ** (n + 2);
  }

  /** −F and its derivatives after τ. @param {number} tau */
  at(tau) {
    const { out, exponents, faded, waved } = this;
    out.fill(0);
    out[0] = this.steady;
    const add = (/** @type {number[]} */ amount, /** @type {number[]} */ pace) => {
      for (let n = 0; n < 3; n++) {
        out[n] += amount[0];
        amount = times(amount, pace);
      }
    };
    for (let i = 0; i < exponents.length; i += 2) {
      const grown = times([faded[i], faded[i + 1]], turn(exponents[i], exponents[i + 1], tau));
      add(grown, [exponents[i], exponents[i + 1]]);
    }
    for (let k = 1; k <= this.law.K; k++) add(times([waved[2 * k - 2], waved[2 * k - 1]], turn(0, k, tau)), [0, k]);
    return out;
  }

  /** Place and velocity of every mode after τ. @param {number} tau */
  modes(tau) {
    const { law, exponents, back } = this;
    const [place, rate] = [Float64Array.from(this.still), new Float64Array(law.size)];
    for (let i = 0; i < exponents.length / 2; i++) {
      const amount = times(
        [this.fading[2 * i], this.fading[2 * i + 1]],
        turn(exponents[2 * i], exponents[2 * i + 1], tau),
      );
      amount[0] += this.constant[2 * i];
      amount[1] += this.constant[2 * i + 1];
      for (let k = 1; k <= law.K; k++) {
        const at = 2 * (law.K * i + k - 1);
        const wave = times([this.waves[at], this.waves[at + 1]], turn(0, k, tau));
        amount[0] += wave[0];
        amount[1] += wave[1];
      }
      for (let n = 0; n < law.size; n++) {
        const at = 4 * (law.size * i + n);
        place[n] += back[at] * amount[0] - back[at + 1] * amount[1];
        rate[n] += back[at + 2] * amount[0] - back[at + 3] * amount[1];
      }
    }
    return [place, rate];
  }

  /** A time from the release on for which the structure surely parts: y‴ = F′ Σ 1/m, and |y⁗| has a bound.
   * @param {Flight} flight from the release on @param {number} tau when that is */
  parts(flight, tau) {
    if (flight.at(0)[2] < -1e-9 * flight.bounds[0]) return 0; // the load has jumped to a pull
    return Math.max((2 * this.at(tau)[1] * this.soft) / flight.bounds[2], 1e-9);
  }

  /** When the wall lets go, as far as `until`. @param {number} until */
  release(until) {
    if (this.found === Infinity && this.clear <= until) {
      if (this.clear === 0 && this.at(0)[0] > 0) this.found = 0;
      else this.found = firstCrossing(this, 0, 0, 1, this.clear, until);
    }
    return this.found;
  }
}

/** e^{(re + i im) τ}. @param {number} re @param {number} im @param {number} tau */
const turn = (re, im, tau) => {
  const size = Math.exp(re * tau);
  return [size * Math.cos(im * tau), size * Math.sin(im * tau)];
};

/** @param {number[]} a @param {number[]} b */
const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];

/** @param {number[]} a @param {number[]} b */
function over(a, b) {
  const size = Math.max(b[0] * b[0] + b[1] * b[1], 1e-18); // an undamped resonance grows all the same
  return [(a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size];
}

/** @param {Float64Array} values */
const sum = (values) => values.reduce((total, one) => total + one, 0);

/** @param {Float64Array} a @param {Float64Array} b */
const dot = (a, b) => a.reduce((total, one, i) => total + one * b[i], 0);
