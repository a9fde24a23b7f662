"""Whether a number of the orbits may vanish twice in a step along a branch, so that its two ends do not show it."""

from __future__ import annotations

import numpy as np

from percuss.explore.continuation.indicators import indicator
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint
from percuss.model.checks import Array

__all__ = ["may_vanish_twice"]

_NEAR = 0.25  # share of the least of three values


def may_vanish_twice(segment: Segment) -> bool:
    """Whether the speed of an impact, det K(1) or det K(−1) may vanish twice in a step.

    They are smooth, and looked at in the middle, too. They do if that has the other sign; they may where the three
    values let an extremum between the ends be expected that is beyond 0, or nearer to it than they are by far.
    """
    middle = segment.at(0.5 * segment.length)
    low, half, high = (_numbers(segment, point) for point in (segment.start, middle, segment.stop))
    side = np.sign(low)
    low, half, high = low * side, half * side, high * side
    bend, slope = 2.0 * (low - 2.0 * half + high), 4.0 * half - 3.0 * low - high
    with np.errstate(divide="ignore", invalid="ignore"):
        within = (slope < 0.0) & (-slope < 2.0 * bend)
        least = low - 0.25 * slope**2 / bend
        dip = within & (least < _NEAR * np.minimum(np.minimum(low, half), high))
    return bool(np.any((high > 0.0) & ((half <= 0.0) | dip)))


def _numbers(segment: Segment, point: CurvePoint) -> Array:
    orbit = segment.curve.motion(point.x)
    return np.append(orbit.speeds, [indicator(orbit, 1.0), indicator(orbit, -1.0)])
