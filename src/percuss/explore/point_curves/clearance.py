"""Whether a motion that fulfils a condition is an orbit otherwise: its impacts strike, and it stays off the wall."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.explore.boundary_curves.roots import bracketed_roots
from percuss.explore.continuation.indicators import press
from percuss.explore.point_curves.conditions import Condition, Death, Touch
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.flight import Flight

__all__ = ["Clearance", "clearance"]

_PER_WAVE, _FEWEST = 8, 96  # samples in a period of the fastest mode, and of a flight
_SAME = 1e-4  # rad: a maximum as near to the grazing is the grazing
_ROUNDING = 1e-11  # of 1, below which it is 0: the same grazing in another load period of the cycle


class Clearance(NamedTuple):
    """How far a motion is from losing each property of an orbit: negative where it has lost it.

    The least speed of an impact, the least distance to the wall of a maximum, for R = 0 the greatest acceleration from
    the wall after an impact; those at which the condition itself is 0 are left out. 0 but for rounding is 0: so it
    stays where the grazing comes twice in a cycle, and nothing happens there.
    """

    speed: float
    distance: float
    leaving: float

    @property
    def is_orbit(self) -> bool:
        """Whether nothing is lost."""
        return min(self) >= 0.0

    @staticmethod
    def lost(number: int) -> CurveEvent:
        """What it is to lose one of them."""
        return (CurveEvent.WITH_DEATH, CurveEvent.WITH_TOUCH, CurveEvent.WITH_STICKING)[number]


def clearance(orbit: PeriodicOrbit, condition: Condition, extra: Array) -> Clearance:
    """How far a motion is from being none, but for its condition."""
    dying = condition.which if isinstance(condition, Death) else -1
    speeds = [float(speed) for i, speed in enumerate(orbit.speeds) if i != dying]
    least = 1.0
    for i, flight in enumerate(orbit.flights):
        times, heights = maxima(flight, orbit.modes)
        own = np.zeros(times.size, dtype=bool)
        if isinstance(condition, Touch) and i == condition.flight:
            own = np.abs(times - extra[0]) < _SAME
        if i == dying:
            own = times < _SAME
        if (i + 1) % orbit.impacts == dying:
            own = own | (times > flight.period - _SAME)
        least = min(least, float(-heights[~own].max(initial=-1.0)))
    leaving = 1.0 if orbit.system.contact.rebounds else -press(orbit)[0]
    found = min(speeds, default=math.inf), least, leaving
    return Clearance(*(0.0 if abs(margin) < _ROUNDING else margin for margin in found))


def maxima(flight: Flight, modes: int) -> tuple[Array, Array]:
    """The local maxima of the gap function inside a flight: times after its start, and heights."""
    load, known = flight.system.load, flight.system.body.modes(modes, flight.system.load.at)
    fastest = max(float(known.omega[-1]) if modes else 1.0, 1.0 if load.is_piecewise else float(load.harmonics[-1]))
    number = max(_FEWEST, int(_PER_WAVE * fastest * flight.period / (2.0 * math.pi)))
    t = np.linspace(0.0, flight.period, number + 1)
    speed = flight.end_motion(t, modes)[1]
    here = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0))
    if not here.size:
        return np.empty(0), np.empty(0)
    tops = bracketed_roots(
        lambda times: flight.end_motion(times, modes)[1], t[here], t[here + 1], speed[here], speed[here + 1]
    )
    return tops, flight.end_motion(tops, modes)[0]
