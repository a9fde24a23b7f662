"""What is looked at on every point of a branch, to see what happens between two of them."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.followed_orbit import FollowedOrbit
from percuss.model.checks import ComplexArray
from percuss.stability import orbit_multipliers
from percuss.stability.outside_number import outside_number
from percuss.steady import PeriodicOrbit
from percuss.steady.admissible import start_acceleration
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.sampled_flights import sampled_flights
from percuss.steady.periodic.system_numbers import numbers_of

__all__ = ["BEYOND", "Top", "greatest_top", "indicator", "multipliers", "outside", "press", "stays_off", "unstable"]

BEYOND = 1e-7
"""Of 1, by which a multiplier beyond the unit circle is counted; nearer to it double ones are lost to rounding."""

_MANY = 12  # modes from which on it is faster not to compute the multipliers
_DEAD = 1e-13  # of the greatest velocity of the bar as a whole; less is rounding


class Top(NamedTuple):
    """The greatest local maximum of the gap function inside the flights: y there, when, and in which flight.

    `time` is counted from the first impact; without any, y is minus infinity.
    """

    height: float
    time: float
    flight: int


def indicator(orbit: PeriodicOrbit, xi: float) -> float:
    """det K(ξ), each row taken by its length: 0 at a fold for ξ = 1, at a flip for ξ = −1."""
    if isinstance(orbit, FollowedOrbit) and abs(xi) == 1.0:
        return orbit.singular[xi < 0.0]
    numbers, rebound = numbers_of(orbit.system, orbit.modes), orbit.rebound
    first = float(orbit.rigid_rebounds[0]) if rebound is None else rebound
    room = numbers.room(orbit.impacts)
    return orbit_kernels().singularity(numbers.row, room, orbit.period, np.array(orbit.times), 0, first, xi)


@lru_cache(maxsize=64)
def multipliers(orbit: PeriodicOrbit) -> ComplexArray | None:
    """The multipliers; None where an impact has no speed, beside which they grow without bound.

    The last ones are kept: each step of a walk asks for those at its start again. Not to be written into.
    """
    return None if _has_dead(orbit) else orbit_multipliers(orbit).values


def _has_dead(orbit: PeriodicOrbit) -> bool:
    """Whether an impact has no speed."""
    greatest = np.abs(orbit.rigid_velocities if orbit.system.body.is_free else orbit.speeds).max()
    return not np.all(np.abs(orbit.speeds) > _DEAD * greatest)


def outside(values: ComplexArray | None) -> int:
    """How many multipliers are outside the unit circle; -1 where none are known."""
    return -1 if values is None else int(np.count_nonzero(np.abs(values) > 1.0 + BEYOND))


@lru_cache(maxsize=64)
def unstable(orbit: PeriodicOrbit) -> int:
    """`outside` of the multipliers of an orbit; of many modes by the determinants of K(ξ) on the circle alone.

    The last ones are kept, as those of `multipliers`.
    """
    if orbit.modes >= _MANY and not _has_dead(orbit):
        counted = outside_number(orbit, BEYOND)
        if counted is not None:
            return counted
    return outside(multipliers(orbit))


def press(orbit: PeriodicOrbit) -> tuple[float, int]:
    """After which impact the striking end is pressed to the wall most, and its acceleration there; for R = 0."""
    rates = [start_acceleration(flight) for flight in orbit.flights]
    return max(rates), int(np.argmax(rates))


def greatest_top(orbit: PeriodicOrbit) -> Top:
    """The greatest local maximum of the gap function inside the flights."""
    found = sampled_flights(orbit)
    return Top(found.height, orbit.times[found.flight] - orbit.times[0] + found.time, found.flight)


def stays_off(orbit: PeriodicOrbit) -> bool:
    """Whether the bar stays off the wall between the impacts: samples prove it, or where they do not, all bounds."""
    return sampled_flights(orbit).proven or orbit.violation is None
