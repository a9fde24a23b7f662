"""A motion of which only the equations, the speeds and K(ξ) are asked, many times: computed by the kernels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from percuss.model.checks import Array, ComplexArray
from percuss.model.load import Side
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.system_numbers import Numbers, numbers_of

__all__ = ["QuickMotion"]

_GIVEN = 0  # the mean velocity after the first impact is that of the motion


@dataclass(frozen=True)
class QuickMotion(PeriodicOrbit):
    """The same motion as a `PeriodicOrbit`, of given mean velocity after the first impact."""

    @cached_property
    def _numbers(self) -> tuple[Numbers, Any]:
        numbers = numbers_of(self.system, self.modes)
        return numbers, numbers.room(self.impacts)

    @property
    def _unknowns(self) -> Array:
        assert self.rebound is not None
        return np.array([*self.times, self.rebound, 0.0])

    @cached_property
    def _looked(self) -> tuple[Array, Array]:
        """The equations and the speeds."""
        from percuss.steady.periodic.kernels.layout import SPEED

        p, (numbers, room) = self.impacts, self._numbers
        derivative = np.zeros((p + 1, p + 3))
        kernel = orbit_kernels().derivatives
        kernel(numbers.row, numbers.row, 0.0, 0.0, room, self.period, self._unknowns, derivative)
        return derivative[:, -1], np.array(room.impacts[SPEED])

    @property
    def residuals(self) -> Array:
        """As those of a `PeriodicOrbit`."""
        return self._looked[0]

    @property
    def speeds(self) -> Array:
        """As those of a `PeriodicOrbit`."""
        return self._looked[1]

    def bordered(self, xi: complex = 1.0, side: Side = "right") -> ComplexArray | Array:
        """As of a `PeriodicOrbit`."""
        if isinstance(xi, complex) or side != "right":
            return super().bordered(xi, side)
        numbers, room = self._numbers
        size, times = self.impacts + 1, np.array(self.times)
        kernel = orbit_kernels().singularity
        kernel(numbers.row, room, self.period, times, _GIVEN, self._unknowns[-2], float(xi))
        return np.array(room.matrix[:size, :size])
