"""Numbers with a bound of their error, in rows: midpoint-radius arithmetic, whose rounding goes into the radius.

A sum or a product in doubles is off by at most half a unit in the last place; a whole one is counted (Rump, Acta
Numerica 19 (2010) 287–449, §10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array

__all__ = ["UNIT", "Ball", "exactly", "hull"]

UNIT = float(np.finfo(float).eps)
_MORE = 1.0 + 16.0 * UNIT  # for what is rounded in computing a radius itself
_TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """All numbers within `rad` of `mid`; arrays of one shape, or shapes that broadcast.

    Examples
    --------
    >>> third = Ball(np.array(1.0), np.array(0.0)) * Ball(np.array(1.0 / 3.0), np.array(1e-16))
    >>> bool(third.rad < 4e-16), bool((third - exactly(1.0 / 3.0)).may_vanish)
    (True, True)
    """

    mid: Array
    rad: Array

    def __add__(self, other: Ball) -> Ball:
        mid = self.mid + other.mid
        return Ball(mid, (self.rad + other.rad + UNIT * np.abs(mid)) * _MORE + _TINY)

    def __sub__(self, other: Ball) -> Ball:
        return self + -other

    def __neg__(self) -> Ball:
        return Ball(-self.mid, self.rad)

    def __mul__(self, other: Ball) -> Ball:
        mid = self.mid * other.mid
        off = np.abs(self.mid) * other.rad + (np.abs(other.mid) + other.rad) * self.rad
        return Ball(mid, (off + UNIT * np.abs(mid)) * _MORE + _TINY)

    def over(self, divisor: Ball) -> Ball:
        """The quotient; a divisor that may vanish gives a radius that is infinite."""
        least = np.abs(divisor.mid) - divisor.rad
        safe = np.where(least > 0.0, divisor.mid, 1.0)
        mid = self.mid / safe
        off = (self.rad + np.abs(mid) * divisor.rad) / np.where(least > 0.0, least, 1.0)
        return Ball(mid, np.where(least > 0.0, (off + 2.0 * UNIT * np.abs(mid)) * _MORE + _TINY, np.inf))

    @property
    def most(self) -> Array:
        """A bound of its modulus."""
        return np.asarray((np.abs(self.mid) + self.rad) * _MORE)

    @property
    def may_vanish(self) -> npt.NDArray[np.bool_]:
        """Whether 0 may be among its numbers."""
        return np.asarray(~(np.abs(self.mid) > self.rad * _MORE))

    def wider(self, by: Array) -> Ball:
        """With a greater radius."""
        return Ball(self.mid, (self.rad + by) * _MORE)


def exactly(value: npt.ArrayLike) -> Ball:
    """Doubles as they are."""
    mid = np.asarray(value, dtype=float)
    return Ball(mid, np.zeros_like(mid))


def hull(low: Array, high: Array) -> Ball:
    """All numbers from one to another."""
    mid = 0.5 * (low + high)
    return Ball(mid, np.maximum(high - mid, mid - low) * _MORE + UNIT * np.abs(mid) + _TINY)
