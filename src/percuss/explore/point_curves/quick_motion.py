"""A motion of which only the equations, the speeds and K(ξ) are asked, many times: computed by the kernels."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from percuss.explore.continuation.followed_orbit import FollowedOrbit
from percuss.model.checks import Array, ComplexArray
from percuss.model.load import Side
from percuss.steady.periodic.flight import Flight
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.system_numbers import numbers_of

__all__ = ["QuickMotion"]

_GIVEN = 0  # the mean velocity after the first impact is that of the motion


class QuickMotion(FollowedOrbit):
    """The same motion as a `PeriodicOrbit`, of given mean velocity after the first impact; nothing is proved of it."""

    @cached_property
    def flights(self) -> tuple[Flight, ...]:
        """The flights, without the range of the mean motion, which serves the proof alone."""
        return tuple(self._flight(i, 1.0) for i in range(self.impacts))

    def bordered(self, xi: complex = 1.0, side: Side = "right") -> ComplexArray | Array:
        """As of a `PeriodicOrbit`."""
        if isinstance(xi, complex) or side != "right":
            return super().bordered(xi, side)
        assert self.rebound is not None
        numbers = numbers_of(self.system, self.modes)
        room, size, times = numbers.room(self.impacts), self.impacts + 1, np.array(self.times)
        orbit_kernels().singularity(numbers.row, room, self.period, times, _GIVEN, self.rebound, float(xi))
        return np.array(room.matrix[:size, :size])
