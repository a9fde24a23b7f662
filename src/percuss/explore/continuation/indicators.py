"""What is looked at on every point of a branch, to see what happens between two of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.explore.boundary_curves.roots import bracketed_roots
from percuss.model.checks import ComplexArray
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit
from percuss.steady.admissible import start_acceleration
from percuss.steady.periodic.flight import Flight

__all__ = ["Top", "greatest_top", "indicator", "multipliers", "outside", "press"]

_BEYOND = 1e-7  # of 1, by which a multiplier beyond the unit circle is counted; nearer double ones are lost to rounding
_DEAD = 1e-13  # of the greatest velocity of the bar as a whole; less is rounding
_PER_WAVE = 8  # samples in a period of the fastest mode
_FEWEST = 96  # samples of a flight
_AT_ONCE = 1 << 20  # modes × times


class Top(NamedTuple):
    """The greatest local maximum of the gap function inside the flights: y there, when, and in which flight.

    `time` is counted from the first impact; without any, y is minus infinity.
    """

    height: float
    time: float
    flight: int


def indicator(orbit: PeriodicOrbit, xi: float) -> float:
    """det K(ξ), each row taken by its length: 0 at a fold for ξ = 1, at a flip for ξ = −1."""
    matrix = orbit.bordered(xi).real
    return float(np.linalg.det(matrix / np.linalg.norm(matrix, axis=1, keepdims=True)))


def multipliers(orbit: PeriodicOrbit) -> ComplexArray | None:
    """The multipliers; None where an impact has no speed, beside which they grow without bound."""
    greatest = np.abs(orbit.rigid_velocities if orbit.system.body.is_free else orbit.speeds).max()
    if not np.all(np.abs(orbit.speeds) > _DEAD * greatest):
        return None
    return orbit_multipliers(orbit).values


def outside(values: ComplexArray | None) -> int:
    """How many multipliers are outside the unit circle; -1 where none are known."""
    return -1 if values is None else int(np.count_nonzero(np.abs(values) > 1.0 + _BEYOND))


def press(orbit: PeriodicOrbit) -> tuple[float, int]:
    """After which impact the striking end is pressed to the wall most, and its acceleration there; for R = 0."""
    rates = [start_acceleration(flight) for flight in orbit.flights]
    return max(rates), int(np.argmax(rates))


def greatest_top(orbit: PeriodicOrbit) -> Top:
    """The greatest local maximum of the gap function inside the flights."""
    found = [_top(flight, orbit.modes) for flight in orbit.flights]
    best = int(np.argmax([height for height, _ in found]))
    height, time = found[best]
    return Top(height, orbit.times[best] - orbit.times[0] + time, best)


def _top(flight: Flight, modes: int) -> tuple[float, float]:
    """The greatest local maximum inside a flight and its time after the impact; (−inf, 0) for none."""
    load, known = flight.system.load, flight.system.body.modes(modes, flight.system.load.at)
    fastest = max(float(known.omega[-1]) if modes else 1.0, 1.0 if load.is_piecewise else float(load.harmonics[-1]))
    number = max(_FEWEST, int(_PER_WAVE * fastest * flight.period / (2.0 * math.pi)))
    t = np.linspace(0.0, flight.period, number + 1)
    width = max(1, _AT_ONCE // max(modes, 1))
    rows = [flight.end_motion(t[i : i + width], modes) for i in range(0, t.size, width)]
    speed = np.concatenate([row[1] for row in rows])
    y = np.concatenate([row[0] for row in rows])
    here = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0))
    if not here.size:
        return -math.inf, 0.0
    here = here[np.argsort(-np.maximum(y[here], y[here + 1]), kind="stable")[:4]]
    tops = bracketed_roots(
        lambda times: flight.end_motion(times, modes)[1], t[here], t[here + 1], speed[here], speed[here + 1]
    )
    heights = flight.end_motion(tops, modes)[0]
    best = int(np.argmax(heights))
    return float(heights[best]), float(tops[best])
