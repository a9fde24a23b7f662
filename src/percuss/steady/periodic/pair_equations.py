"""Two impacts of a rigid bar, enclosed: the two equations for their times over boxes of times, and their derivatives.

The unknowns are the time t of one impact and the flight h after it; the other flight takes T − h. It is `ImpactChain`
for p = 2 and no elastic modes, written out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.model import System
from percuss.steady.oscillator import phi1, phi2
from percuss.steady.periodic.ball import UNIT, Ball, exactly, hull
from percuss.steady.periodic.rigid_forcing import FUNCTION, Forced, advances, forcing_of

__all__ = ["PairEquations", "Pairs"]

_HALF = exactly(0.5)


class Pairs(NamedTuple):
    """F_1 and F_2 over boxes, their derivatives by t and by h, and what F_1 is in proportion to, but for h."""

    first: Ball
    second: Ball
    by_t: tuple[Ball, Ball]
    by_h: tuple[Ball, Ball]
    per_flight: Ball


class PairEquations:
    """The equations of z=2/n.

    Parameters
    ----------
    system
        The bar; its elastic modes are left out.
    periods
        n.
    """

    def __init__(self, system: System, periods: int) -> None:
        self.forcing, self.d = forcing_of(system), system.d
        self.beta = float(system.contact.velocity_factor)
        length = 2.0 * math.pi * periods
        self.period = Ball(np.array(length), np.array(UNIT * length))
        left = advances(self.d, Ball(np.array([length]), np.array([UNIT * length])))[0]
        square = exactly(self.beta) * exactly(self.beta)
        self.square, self.divisor = square, exactly(1.0) - square * Ball(left.mid[0], left.rad[0])

    @property
    def is_solvable(self) -> bool:
        """Whether the rigid velocity follows from the times."""
        return bool(self.divisor.mid > 1e-3)

    def over(self, t: Ball, h: Ball) -> Pairs:
        """The equations over boxes; t and h of the shape (B,)."""
        d, mean, beta = exactly(self.d), self.forcing.mean, exactly(self.beta)
        one, two = self.forcing.over(t), self.forcing.over(t + h)
        rest = self.period - h
        (kept, once, again), (kept_2, once_2, again_2) = advances(self.d, h), advances(self.d, rest)
        v, w = one.velocity, two.velocity
        rise = self._rise(v, w, t, h)
        # the rigid velocity after either impact, r and q, with their derivatives
        gain = w - v * kept + mean * once
        gain_2 = v - w * kept_2 + mean * once_2
        gain_t, gain_h = two.slope - one.slope * kept, two.slope + (d * v + mean) * kept
        gain_2t, gain_2h = one.slope - two.slope * kept_2, -(two.slope + d * w + mean) * kept_2
        back = self.square * kept_2
        r = (back * gain + beta * gain_2).over(self.divisor)
        r_t = (back * gain_t + beta * gain_2t).over(self.divisor)
        r_h = (back * gain_h + d * back * gain + beta * gain_2h).over(self.divisor)
        before = kept * r + gain
        q, q_t = beta * before, beta * (kept * r_t + gain_t)
        q_h = beta * (kept * r_h - d * kept * r + gain_h)
        before_1 = kept_2 * (q - w) + v + mean * once_2
        moved = two.displacement - one.displacement
        return Pairs(
            (r - v) * once + mean * again + moved,
            (q - w) * once_2 + mean * again_2 - moved,
            ((r_t - one.slope) * once + rise, (q_t - two.slope) * once_2 - rise),
            (before + r_h * once, (q_h - two.slope) * once_2 - before_1 - rise),
            self._per_flight(r, t, h, one),
        )

    def _between(self, t: Ball, h: Ball) -> Ball:
        """v_f' at all times from the one impact to the other."""
        low, high = t.mid - t.rad, t.mid + t.rad + np.maximum(h.mid + h.rad, 0.0)
        return self.forcing.over(hull(low, high)).slope

    def _rise(self, v: Ball, w: Ball, t: Ball, h: Ball) -> Ball:
        """v_f(t + h) − v_f(t), for short flights by what lies between."""
        plain, mean_slope = w - v, self._between(t, h)
        steady = mean_slope * h
        narrow = steady.rad < plain.rad
        return Ball(np.where(narrow, steady.mid, plain.mid), np.where(narrow, steady.rad, plain.rad))

    def _per_flight(self, r: Ball, t: Ball, h: Ball, one: Forced) -> Ball:
        """F_1/(hφ_1) = r + h(φ_2(p_0 + d v_f) + ∫ (1 − s) v_f'(t + sh) ds)/φ_1, s from 0 to 1; for R = 0 over h."""
        first, second = _ratios(self.d, h)
        grown = second * (self.forcing.mean + exactly(self.d) * one.velocity) + _HALF * self._between(t, h)
        per_time = grown.over(first)
        return r + h * per_time if self.beta else per_time


def _ratios(d: float, h: Ball) -> tuple[Ball, Ball]:
    """φ_1(dh) and φ_2(dh), which fall with h."""
    ends = [d * np.maximum(h.mid - h.rad, 0.0) * (1.0 - UNIT), d * (h.mid + h.rad) * (1.0 + UNIT)]
    least, most = 1.0 - FUNCTION, 1.0 + FUNCTION
    return hull(phi1(ends[1]) * least, phi1(ends[0]) * most), hull(phi2(ends[1]) * least, phi2(ends[0]) * most)
