"""Bounds of the gap and of its derivatives during a flight: from the anchor on, and anew as damping takes its part."""

from __future__ import annotations

import math
from typing import NamedTuple

from percuss.compiled import inlined
from percuss.simulate.kernels.bounds import ringing, ringing_left
from percuss.simulate.kernels.codes import EPS, POWERS
from percuss.simulate.kernels.creeping import creeping
from percuss.simulate.kernels.rounding import Blur, blur_of

GROWN = 1.0 + 1e-12  # the sums' own rounding


class Way(NamedTuple):
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
        most, sup1, sup2, sup3 = creeping(modes, motion.z, desk, 0.0)
        sup1, sup2, sup3 = ring[1] + sup1, ring[2] + sup2, ring[3] + sup3
    beat = bar.reach
    for k in range(osc.shape[1]):
        beat -= osc[0, k]
    way = Way(pull, beat, ring, blur_of(bar, modes, motion, osc, ring[1], ring[2], curve))
    jerk = bend + sup3
    return way, Bounds(ring[0] - now.free_oscillating + most, sup1, sup2, jerk, curve, up)


@inlined
def swaying(bar, now, pull):
    """Bounds of S'', twice, and of S‴ on a gas chamber: |h'| ≤ 1, |h| ≤ 1/ω and |h''| ≤ d + ω (`sway`)."""
    curve = abs(pull) + bar.spring * abs(now.drift)
    jerk = abs(pull) * (bar.damping + bar.spring) + bar.spring * bar.spring * abs(now.drift)
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
