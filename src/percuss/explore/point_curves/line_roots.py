"""Where a number vanishes along a line of a plane."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from percuss.explore.boundary_curves.roots import bracketed_roots
from percuss.explore.continuation.next_point import Strayed
from percuss.halting import look
from percuss.model.checks import Array

__all__ = ["root_on_line", "vanishing_beyond"]

_EXACT, _ROUGH, _LEAP = 1e-13, 1e-11, 2.0  # steps to a root: the last one, one that rounding has a say in, their growth
_MOST_STEPS = 20
_NEAREST, _FURTHEST = 1e-9, 1e-2  # between which a length is searched for


def root_on_line(
    number: Callable[[Array], float], place: Array, way: Array, slope: float, reach: float
) -> tuple[Array, float]:
    """Where a number vanishes on a line, by the secant method, and its slope; Strayed where that is too far away.

    Parameters
    ----------
    number
        Of a place; shape (2,) in, a number out.
    place, way
        A place of the line, near the root, and its direction, of length 1; shape (2,).
    slope
        About the derivative along the line; not 0.
    reach
        How far away the root may be.
    """
    last, value = 0.0, number(place)
    if value == 0.0:
        return place, slope
    along = -value / slope
    for _ in range(_MOST_STEPS):
        if not abs(along) <= reach:
            raise Strayed("beside the curve")
        look()
        now = number(place + along * way)
        step = along - last
        if now == 0.0:
            return place + along * way, slope
        rise = (now - value) / step
        ahead = -now / rise if rise * slope > 0.0 else math.inf
        if abs(ahead) > _LEAP * abs(step):
            if abs(step) < _ROUGH:
                return place + along * way, slope
            ahead = math.copysign(_LEAP * abs(step), -now * slope)
        elif abs(step) > _ROUGH:
            slope = rise
        if abs(ahead) <= _EXACT:
            return place + (along + ahead) * way, slope
        last, value, along = along, now, along + ahead
    raise Strayed("no root")


def vanishing_beyond(number: Callable[[float], float], about: float) -> float:
    """The first length at which a number that is positive at 0 vanishes; Strayed where that is far from about there."""
    low, high = 0.0, max(about, _NEAREST)
    while (above := number(high)) > 0.0:
        low, high = high, 2.0 * high
        if high > _FURTHEST:
            raise Strayed("held further on")
    if low == 0.0 and number(0.0) <= 0.0:
        return 0.0
    ends = (np.array([1.0 + low]), np.array([1.0 + high]), np.array([number(low)]), np.array([above]))  # to 1e-16
    return float(bracketed_roots(lambda at: np.array([number(float(one) - 1.0) for one in at]), *ends)[0]) - 1.0
