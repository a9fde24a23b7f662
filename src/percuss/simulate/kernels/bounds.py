"""A flight from an anchor on: bounds of its free part, its rounding error, its smooth part, and the anchor moved."""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.compiled import entry, inlined, inlined_sums, inner, summed
from percuss.simulate.kernels.modes import (
    creep_sizes,
    creeping,
    drift,
    elastic_apart,
    most_of,
    ramped,
    rising,
    sine_cosine,
    sway,
    turn_modes,
)
from percuss.simulate.kernels.motion_records import EPS, POWERS


@inlined_sums
def amplitudes(bar, modes, z, now):
    """f and f'' at the anchor, and bounds of |f|, |f'|, |f''|, |f‴| ever after."""
    f, curve = 0.0, 0.0
    if bar.law == POWERS:
        rate, d = 0.0, 2.0 * bar.half
        for j in range(modes.omega.shape[0]):
            zr = z[0, j] * modes.oscillates[j]
            f += zr
            rate += modes.lam[j] * z[1, j]
            curve += modes.square[j] * zr
        curve = 0.25 * d * d * f + d * rate - curve
    else:
        for j in range(modes.omega.shape[0]):
            zr, half = z[0, j] * modes.oscillates[j], modes.half[j]
            f += zr
            curve += (half * half - modes.square[j]) * zr + 2.0 * half * modes.lam[j] * z[1, j]
    sup, sup1, sup2, sup3 = ringing(modes, z)
    now.free_oscillating = f
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        q, q1, d = z[0, j], z[1, j], modes.damping[j]
        f += q
        curve -= d * q1 + modes.omega[j] * modes.omega[j] * q
        most, most1, most2, most3 = most_of(d, modes.signed[j], modes.omega[j], q, q1, 0.0, q, q1)
        sup += most
        sup1 += most1
        sup2 += most2
        sup3 += most3
    now.free, now.free_curve = f, curve
    grown = 1.0 + 1e-12  # the sums' own rounding
    now.sup, now.sup1, now.sup2, now.sup3 = sup * grown, sup1 * grown, sup2 * grown, sup3 * grown


@inner
def amplitudes_apart(bar, modes, z, now):
    """`amplitudes`, made once for what is seldom done."""
    amplitudes(bar, modes, z, now)


@inlined_sums
def ringing(modes, z):
    """Σ|z|, Σω|z|, Σω²|z|, Σω³|z| of the oscillating modes: bounds of their free part and its derivatives."""
    sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        one, other, w = abs(z[0, j]), abs(z[1, j]), modes.omega[j]
        # ≥ √(zr² + zi²), by 8 % at most
        size = modes.oscillates[j] * (max(one, other) + 0.4142135623730951 * min(one, other))
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    return sup, sup1, sup2, sup3


@summed
def ringing_left(modes, z, work):
    """The same at the time of the phasors in `work`, which have the damping of each mode in them."""
    sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        er, ei, w = 1.0 + work.re[j], work.im[j], modes.omega[j]
        one, other = abs(z[0, j] * er - z[1, j] * ei), abs(z[0, j] * ei + z[1, j] * er)
        size = modes.oscillates[j] * (max(one, other) + 0.4142135623730951 * min(one, other))
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    return sup, sup1, sup2, sup3


@entry
def bounded(bar, modes, z, now):
    """The bounds of a flight that stand in a saved state, computed again to see whether they are true."""
    amplitudes(bar, modes, z, now)


# ---- The rounding error of the gap during a flight


class Blur(NamedTuple):
    """What the rounding error of the gap is made of, each times some eps; see `blur`.

    `rush`, `crush`: the errors of the rate and of the acceleration.
    """

    at: float
    drifting: float
    push: float
    swing: float
    ring: float
    lasting: float
    place: float
    creeps: float
    rush: float
    crush: float


@inlined
def blur_of(bar, modes, motion, osc, ring1, ring2, curve):
    """The parts of the error for a flight from the anchor."""
    # `ring1`, `ring2`, `curve`: bounds of the derivatives of the oscillating modes, and of the smooth curvature.
    now = motion.now
    error = EPS * (8.0 + 0.125 * modes.omega.shape[0] + 0.5 * osc.shape[1])
    drifting, place, creeps, crush = abs(now.drift) + bar.sway, 0.0, 0.0, ring2
    if bar.spring > 0.0:
        drifting += abs(bar.climb) + abs(bar.lift) / (bar.spring * bar.spring)
    if modes.creeping.shape[0]:
        place, creeps, rush, crush = creep_sizes(bar, modes, motion.z)
        drifting, place, creeps, crush = drifting + rush, error * place, error * creeps, ring2 + crush
    return Blur(
        error * abs(now.gap), error * drifting, error * abs(bar.mean), error * bar.swing, error * ring1, bar.lasting,
        place, creeps, error * (drifting + bar.swing + ring1), error * (curve + crush),
    )  # fmt: skip


@inlined
def blur(size, tau, first, second):
    """The rounding error of the gap at τ, where `first` and `second` are those of `drift`."""
    # It is some eps, already in `size`, times the sum of the absolute values of what is summed: the gap at the anchor;
    # the drift b `first` + mean `second`; what the load's harmonics add, at most Σk|amplitude| τ or twice the
    # amplitudes; the oscillating modes, whose phase is known to eps λτ while they last, e^{−dτ/2} τ ≤ 2/(e d); and the
    # creeping ones, |q'(0)| h + |q(0)| g with h ≤ `first` and g ≤ ω² `second` (`creep`).
    total = size.at + size.drifting * abs(first) + size.push * second + size.swing * min(tau, 2.0)
    total = total + size.ring * min(tau, size.lasting)
    return total + min(size.place, size.creeps * second)


# ---- Bounds of the gap and of its derivatives during a flight: from the anchor on, and anew as damping takes its part

GROWN = 1.0 + 1e-12  # the sums' own rounding


class FlightBounds(NamedTuple):
    """What holds for a whole flight from the anchor.

    `pull`: acceleration of the drift at the anchor. `beat`: bound of the oscillation of the smooth part less what it is
    there. `ring`: bounds of the oscillating modes and their derivatives at the anchor. `size`: the rounding error.
    """

    pull: float
    beat: float
    ring: tuple[float, float, float, float]
    size: Blur


class Bounds(NamedTuple):
    """Bounds from some time on.

    `top`: how much f may exceed f(0). `sup1`, `sup2`: of f' and f''. `jerk`: of y‴. `curve`: of |S''|. `up`: of S''.
    """

    top: float
    sup1: float
    sup2: float
    jerk: float
    curve: float
    up: float


@inlined
def bounds_at_anchor(table, motion, desk):
    """What holds for the whole flight, and the bounds from its beginning on."""
    bar, modes, now, osc = table.bar, table.modes, motion.now, desk.osc
    pull = bar.mean - bar.damping * now.drift
    curve, up, bend = bar.curve + abs(pull), bar.curve + max(pull, 0.0), bar.jerk + bar.damping * abs(pull)
    if bar.spring > 0.0:
        curve, up, bend = swaying(bar, now, pull)
    ring = (now.sup, now.sup1, now.sup2, now.sup3)
    most, sup1, sup2, sup3 = 0.0, now.sup1, now.sup2, now.sup3
    if modes.creeping.shape[0]:
        rung, rung1, rung2, rung3 = ringing(modes, motion.z)
        ring = (rung * GROWN, rung1 * GROWN, rung2 * GROWN, rung3 * GROWN)
        most = rising(modes, motion.z[0], motion.z[1])
    beat = bar.reach
    for k in range(osc.shape[1]):
        beat -= osc[0, k]
    way = FlightBounds(pull, beat, ring, blur_of(bar, modes, motion, osc, ring[1], ring[2], curve))
    jerk = bend + sup3
    return way, Bounds(ring[0] - now.free_oscillating + most, sup1, sup2, jerk, curve, up)


@inlined
def swaying(bar, now, pull):
    """Bounds of S'', twice, and of S‴ on a gas chamber: |h'| ≤ 1, |h| ≤ 1/ω and |h''| ≤ d + ω (`sway`)."""
    curve = abs(pull) + bar.spring * abs(now.drift) + abs(bar.lift) / bar.spring
    jerk = abs(pull) * (bar.damping + bar.spring) + bar.spring * bar.spring * abs(now.drift) + abs(bar.lift)
    return curve * GROWN, curve * GROWN, jerk * GROWN


@inlined
def smooth_bounds(bar, way, bounds, first):
    """The bounds of S'' anew, with what is left of the drift's acceleration; `first` is that of `drift`."""
    if bar.spring > 0.0:
        return bounds
    left = way.pull * (1.0 - bar.damping * first)
    curve, up = bar.curve + abs(left), bar.curve + max(left, 0.0) + 4.0 * EPS * abs(way.pull)
    return Bounds(bounds.top, bounds.sup1, bounds.sup2, bounds.jerk, curve, up)


@inlined
def bounds_anew(table, motion, desk, way, tau, first):
    """All bounds at τ, with the phasors of τ on the desk."""
    bar, modes, z, ring = table.bar, table.modes, motion.z, way.ring
    if bar.law == POWERS:
        fade = math.exp(-bar.half * tau) * GROWN
        rung, sup1, sup2, sup3 = ring[0] * fade, ring[1] * fade, ring[2] * fade, ring[3] * fade
    else:
        rung, sup1, sup2, sup3 = ringing_left(modes, z, desk)
        rung, sup1, sup2, sup3 = rung * GROWN, sup1 * GROWN, sup2 * GROWN, sup3 * GROWN
    most = 0.0
    if modes.creeping.shape[0]:
        most, slow1, slow2, slow3 = creeping(modes, z, desk, tau)
        sup1, sup2, sup3 = slow1 + sup1, slow2 + sup2, slow3 + sup3
    left = way.pull * (1.0 - bar.damping * first)
    curve, up = bar.curve + abs(left), bar.curve + max(left, 0.0) + 4.0 * EPS * abs(way.pull)
    jerk = bar.jerk + bar.damping * (abs(left) + 4.0 * EPS * abs(way.pull)) + sup3
    if bar.spring > 0.0:
        curve, up, jerk = swaying(bar, motion.now, way.pull)
        jerk += sup3
    return Bounds(rung - motion.now.free_oscillating + most, sup1, sup2, jerk, curve, up)


# ---- The smooth part of the gap: all but the free elastic part (theory §2)
#
# The drift of the bar as a whole, under the constant part of the load, and what the load's harmonics add. On a gas
# chamber the drift is a motion on a spring; `bar.mean` is then its acceleration at the anchor, without drag, and an
# accumulator that is filled pushes it more and more.


@inlined
def smooth_and_drift(bar, now, osc, tau):
    """S(τ) − S(0), S'(τ), S''(τ), the gap without the free elastic part; and what `sway` said."""
    d, b = bar.damping, now.drift
    first, second = sway(d, bar.spring, tau)
    y = b * first + bar.mean * second
    v = now.smooth_rate + (bar.mean - d * b) * first
    a = (bar.mean - d * b) * (1.0 - d * first)
    if bar.spring > 0.0:
        square = bar.spring * bar.spring
        v -= square * b * second
        a -= square * ((bar.mean - d * b) * second + b * first)
        if bar.lift != 0.0:
            y += bar.lift * ramped(d, bar.spring, first, second, tau)
            v += bar.lift * second
            a += bar.lift * first
        y += bar.climb * tau
    if osc.shape[1]:
        sh, ch = sine_cosine(0.5 * tau)
        er1, ei1 = -2.0 * sh * sh, 2.0 * sh * ch  # e^{iτ} − 1, exact for small τ
        er, ei = er1, ei1
        for k in range(osc.shape[1]):
            if k:
                er, ei = er + er1 + (er * er1 - ei * ei1), ei + ei1 + (er * ei1 + ei * er1)
            g, h, n = osc[0, k], osc[1, k], k + 1.0
            y += g * er - h * ei
            v -= n * (g * ei + h * er)
            a -= n * n * (g * (1.0 + er) - h * ei)
    return y, v, a, first, second


@inlined
def smooth(bar, now, osc, tau):
    """The first three of them."""
    y, v, a, _, _ = smooth_and_drift(bar, now, osc, tau)
    return y, v, a


@inlined
def rigid_rate(bar, harmonics, drifted, c, s):
    """u_0', the velocity of the mean of the bar: of its drift, and of its oscillation at a load phase."""
    wr, wi, v = c, s, drifted
    for k in range(harmonics.gap_re.shape[0]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        v -= (k + 1) * (harmonics.rigid_re[k] * wi + harmonics.rigid_im[k] * wr)
    return v


@inlined
def drifted(bar, now, tau):
    """Velocity of the drift at τ."""
    if bar.spring > 0.0:
        first, second = sway(bar.damping, bar.spring, tau)
        late = (bar.spring * bar.spring * now.drift - bar.lift) * second
        return now.drift + (bar.mean - bar.damping * now.drift) * first - late
    first, _ = drift(bar.damping, tau)
    return now.drift + (bar.mean - bar.damping * now.drift) * first


@inlined
def smooth_at_anchor(bar, harmonics, now, osc):
    """What a flight from the anchor needs to know of the smooth part."""
    c, s = now.cosine, now.sine
    wr, wi, rate, rigid, curve = c, s, 0.0, 0.0, 0.0
    for k in range(harmonics.gap_re.shape[0]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        g = harmonics.gap_re[k] * wr - harmonics.gap_im[k] * wi
        h = harmonics.gap_re[k] * wi + harmonics.gap_im[k] * wr
        osc[0, k], osc[1, k], n = g, h, k + 1.0
        rate -= n * h
        curve -= n * n * g
        rigid -= n * (harmonics.rigid_re[k] * wi + harmonics.rigid_im[k] * wr)
    now.drift = now.rigid_rate - rigid
    now.smooth_rate = now.drift + rate + bar.climb
    now.acceleration = now.free_curve + curve + bar.mean - bar.damping * now.drift


# ---- The anchor moved along a flight


@inner
def advance(table, motion, desk, tau):
    """The anchor moved to τ under a constant load, without an impact; the clock is turned apart."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    ds, vs, _ = smooth(bar, now, desk.osc, tau)
    df, fv, _, slip = elastic_apart(bar, modes, z, now, desk, tau)
    now.rigid_rate = drifted(bar, now, tau)
    turn_modes(bar, modes, z, desk, tau, 0.0, slip)
    now.gap += ds + df
    now.gap_rate = vs + fv


@inlined
def jump_back(table, motion, old, new):
    """The force on the modes jumps, and with it the places about which they swing; so the free part jumps back."""
    modes, z = table.modes, motion.z
    for j in range(modes.omega.shape[0]):
        jump = modes.statics[j] * (old - new)
        z[0, j] += jump
        z[1, j] -= modes.half[j] * jump * modes.inverse[j]
    amplitudes_apart(table.bar, modes, z, motion.now)
