"""The systems of a family over one parameter as rows of numbers, and how these change with it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from percuss.errors import PercussError
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.periodic.system_numbers import Numbers, numbers_of

__all__ = ["ParameterRows"]

_KEPT = 64
_WIDE, _NARROW = 2.0**-6, 1e-6  # differences, of the unit of the parameter and of the parameter
_EVEN = 32.0 * np.finfo(float).eps  # of a number, by which it may be beside a straight line


class ParameterRows:
    """The rows of numbers that compiled functions take for systems.

    Most parameters move these numbers evenly: then a row and one rate tell all systems near, to rounding, and Newton's
    method need not make a system at each of its steps. Whether it is so is looked at again wherever it ends.

    Parameters
    ----------
    system
        The system at a value of the parameter.
    modes
        N.
    unit
        By how much the parameter is changed to find out.
    """

    def __init__(self, system: Callable[[float], System], modes: int, unit: float) -> None:
        self._system, self._modes, self._unit = system, modes, unit
        self._rows: dict[float, Numbers] = {}
        self._last: tuple[float, Numbers] | None = None
        self._rate: tuple[float, Array, bool] | None = None

    def at(self, value: float) -> Numbers:
        """The row at a value; PercussError where there is no system."""
        if value not in self._rows:
            if len(self._rows) >= _KEPT:
                self._rows.clear()
            self._rows[value] = numbers_of(self._system(value), self._modes)
        self._last = value, self._rows[value]
        return self._rows[value]

    def near(self, value: float) -> tuple[float, Numbers, Array]:
        """A value, its row, and the rate of that, from which the rows near a value follow; or PercussError."""
        if self._last is not None and self._rate is not None and self._rate[2]:
            return (*self._last, self._rate[1])
        row = self.at(value)
        return value, row, self.rate(value)

    def rate(self, value: float) -> Array:
        """How the numbers change with the parameter; shape of a row."""
        if self._rate is None or not (self._rate[2] or self._rate[0] == value):
            wide = self._difference(value, _WIDE * self._unit)
            if wide is not None and wide[1]:
                self._rate = value, wide[0], True
            else:
                narrow = self._difference(value, _NARROW * max(1.0, abs(value)))
                if narrow is None:
                    raise PercussError("the numbers of the system do not change steadily with the parameter")
                self._rate = value, narrow[0], False
        return self._rate[1]

    def fits(self, base: float, rate: Array, value: float) -> bool:
        """Whether the row at a value is that which another row and a rate lead to; PercussError without a system."""
        row, here = self.at(base).row, self.at(value).row
        moved = (value - base) * rate
        return here.shape == row.shape and _agree(here, row + moved, np.abs(row) + np.abs(moved))

    def _difference(self, value: float, step: float) -> tuple[Array, bool] | None:
        """The rate by a difference, and whether the numbers change evenly over it; None where there are none."""
        base = self.at(value)
        here = base.row
        for first, second in ((step, -step), (-step, -2.0 * step), (step, 2.0 * step)):
            try:
                one, two = self.at(value + first).row, self.at(value + second).row
            except PercussError:
                continue
            finally:
                self._last = value, base  # the rows kept may have been dropped by now
            if one.shape != here.shape or two.shape != here.shape:
                continue
            if second == -first:
                rate, middle = (one - two) / (2.0 * step), 0.5 * (one + two)
                return rate, _agree(middle, here, np.abs(here))
            rate = (4.0 * one - two - 3.0 * here) / (2.0 * first)
            return rate, _agree(one, 0.5 * (here + two), np.abs(here))
        return None


def _agree(one: Array, other: Array, size: Array) -> bool:
    return bool(np.all(np.abs(one - other) <= _EVEN * size))
