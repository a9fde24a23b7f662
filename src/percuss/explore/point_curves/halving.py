"""Where a curve of orbits of twice the period comes to an end: the two halves of their cycle become one orbit.

An orbit that is told half its period later is the same orbit, and is as much a fold, a flip or one with a pair on the
unit circle as before. Beyond the place at which its halves are one the curve would go back over itself. For folds that
is the point of the flips of the orbit of half the period at which the doubled one begins towards the other side.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.solution_curve import twice
from percuss.explore.point_curves.codimension_two import bend_of_the_doubled
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.explore.point_curves.multiplier_conditions import Multiplier, Pair
from percuss.model.checks import Array

__all__ = ["goes_back", "halved", "halves_differ"]

_ASIDE = 1e-3  # of arclength, for the first step of the secant method
_STEPS, _CLOSE = 20, 1e-11
_REACH = 0.3  # rad, of the place from where it is looked for


def goes_back(curve: ExtendedCurve) -> bool:
    """Whether a curve would go back over itself once both halves of the cycle are one orbit."""
    return isinstance(curve.condition, Multiplier | Pair) and curve.impacts % 2 == curve.periods % 2 == 0


def halves_differ(curve: ExtendedCurve, x: Array) -> Array:
    """By how much the times of the second half of the cycle are later than those of the first; shape (p/2,)."""
    half = curve.impacts // 2
    return x[half : 2 * half] - x[:half] - math.pi * curve.periods


def halved(curve: ExtendedCurve, near: Array) -> ExtendedPoint:
    """The point at which both halves are one orbit, from unknowns near it; or Strayed."""
    p, half = curve.impacts, curve.impacts // 2
    start = np.concatenate([near[:half] + 0.5 * halves_differ(curve, near), near[p : p + 3]])
    narrow = ExtendedCurve(
        curve.family, curve.names, curve.units, half, curve.periods // 2, curve.modes, curve.condition
    )
    flip = Multiplier.of(narrow.motion(start), -1.0)
    narrow = replace(narrow, condition=flip, _motions={})
    found = narrow.settled(start)
    if isinstance(curve.condition, Multiplier) and curve.condition.xi > 0.0:
        found = _bent_to_neither_side(narrow, flip, found)
    if float(np.abs(found.x - start).max()) > _REACH:
        raise Strayed("another flip")
    x = np.concatenate([twice(found.x[: half + 1], half, narrow.periods), found.x[half + 1 :], curve.extra(near)])
    return ExtendedPoint(x, np.zeros(x.size), np.zeros((0, x.size)), 0)


def _bent_to_neither_side(narrow: ExtendedCurve, flip: Multiplier, start: ExtendedPoint) -> ExtendedPoint:
    """The point of a curve of flips at which the doubled orbit begins towards neither side, by the secant method."""

    def bend(point: ExtendedPoint) -> float:
        return bend_of_the_doubled(narrow.motion(point.x), flip)

    found, last, before, along = start, bend(start), 0.0, _ASIDE
    for _ in range(_STEPS):
        found = narrow.corrected(start.x + along * start.tangent, start.tangent, start.tangent, start.matrix)
        here = bend(found)
        if here == last or abs(along) > _REACH:
            break
        step = -here * (along - before) / (here - last)
        if abs(step) < _CLOSE:
            return found
        last, before, along = here, along, along + step
    raise Strayed("no such flip")
