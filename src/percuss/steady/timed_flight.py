"""Does the bar as a whole pass through the impact plane between two blows that take time? Decided with bounds.

A cell of time is dropped only when Taylor's theorem, with a bound of the acceleration, proves that the bar stays off.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from percuss.model.checks import Array
from percuss.steady.admissible import Violation
from percuss.steady.phases import forced_response

if TYPE_CHECKING:
    from percuss.steady.timed_orbit import TimedOrbit

__all__ = ["rigid_passage"]

_TOUCH = 1e-13  # share of the scale of the motion that rounding hides
_NARROWEST = 1e-14  # share of the period below which a cell is not split further
_DEPTH = 1e-6  # relative accuracy of the greatest depth
_CELLS = 64  # per load period, to begin with


def rigid_passage(orbit: TimedOrbit) -> Violation | None:
    """The first passage of the bar's mean through the plane of the next blow, or None where there is proof of none.

    Passages less deep than half the greatest load times the square of the contact's duration are none.
    """
    start, stop = orbit.contact[1], orbit.period + orbit.contact[0]
    plane = float(orbit.rigid_motion(np.array([stop]))[0][0])
    speed, alternating = forced_response(orbit.system).rigid_bounds()
    greatest = alternating + orbit.system.load.mean
    fastest = 2.0 * speed + orbit.system.load.mean * orbit.period + abs(orbit.rebound_velocity)
    bend = greatest + orbit.system.d * fastest
    undecided = 0.5 * greatest * orbit.law.duration**2 + _TOUCH * fastest * orbit.period
    arrival = float(orbit.rigid_motion(np.array([stop]))[1][0])
    last = max(stop - 2.0 * arrival / bend, start) if arrival > 0.0 else stop  # from here on the bar comes to the plane

    def gap(t: Array) -> tuple[Array, Array]:
        moved, velocity = orbit.rigid_motion(t)
        return moved - plane - undecided, velocity

    count = _CELLS * orbit.periods
    half = 0.5 * (last - start) / count
    centres: Array = np.asarray(start + half * (2.0 * np.arange(count) + 1.0), dtype=float)
    first, best = np.inf, 0.0
    while centres.size and half > _NARROWEST * orbit.period:
        y, velocity = gap(centres)
        through = y > 0.0
        if through.any():
            first, best = min(first, float(centres[through].min())), max(best, float(y.max()))
        reach = y + np.abs(velocity) * half + 0.5 * bend * half**2
        # what is left may hold an earlier passage or a deeper one
        left = centres[(reach > 0.0) & ((centres - half < first) & ~through | (reach > (1.0 + _DEPTH) * best))]
        half *= 0.5
        centres = np.sort(np.concatenate([left - half, left + half]))
    return Violation(first, best + undecided) if np.isfinite(first) else None
