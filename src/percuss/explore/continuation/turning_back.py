"""Where a branch comes to an orbit of more symmetry, at which it turns back over its own image.

An orbit of twice the period comes to the flip of the one whose period is doubled, and goes on with its halves
exchanged. One that is not the same backwards in time, of a system that is, comes to one that is the same, and goes on
backwards in time. Either way the parameter has an extremum there, det K(1) vanishes without a change of its sign, two
tangents are possible, and the nearer a step ends to the place, the more of it rounding decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.happenings import Happening
from percuss.explore.continuation.indicators import indicator
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import (
    CurvePoint,
    SolutionCurve,
    twice,
    where_it_vanishes,
)
from percuss.model.checks import Array

__all__ = ["BESIDE", "TurningBack", "turning_back"]

BESIDE = 5e-3
"""Of each impact in rad, how near to such a place a branch is looked at: nearer to it rounding decides on folds."""

_AROUND = 1e-3  # of each impact in rad, between the points that tell a crossing
_CLOSE = 1e-5  # rad, to which the place of a crossing is halved
_MOST, _ROUNDS = 60, 4
_POWERS = np.arange(4.0)
_SINGULAR = 1e-2  # by which the equations are nearer to singular there than at the ends of the step


class TurningBack(NamedTuple):
    """What happens there, the last point before it, and the first one beyond it; None where the branch ends."""

    happening: Happening
    before: CurvePoint
    beyond: CurvePoint | None


def turning_back(segment: Segment) -> TurningBack | None:
    """Where in a step the branch turns back over its own image; None where it does not."""
    found = _halving(segment)
    return _crossing(segment) if found is None else found


def _aside(segment: Segment, place: float) -> tuple[float, float]:
    """Places before and beyond one."""
    most = BESIDE * math.sqrt(segment.curve.impacts)
    return place - min(most, 0.5 * place), place + min(most, 0.5 * (segment.length - place))


def _halving(segment: Segment) -> TurningBack | None:
    """Where the two halves of the cycle become one and the same orbit: what tells them apart turns over.

    It is the flip of the orbit of half the period, and found as that: there the doubled one has two tangents.
    """
    p, curve = segment.curve.impacts, segment.curve
    if p % 2 or curve.periods % 2:
        return None
    first, second = (_halves(point, p, curve.periods) for point in (segment.start, segment.stop))
    if not first[1] @ second[1] < 0.0:
        return None
    share = float(np.linalg.norm(first[1]) / (np.linalg.norm(first[1]) + np.linalg.norm(second[1])))
    narrow = curve.other(p // 2, curve.periods // 2)
    near = (1.0 - share) * first[0] + share * second[0]

    def flip(point: CurvePoint) -> float:  # not by the lengths of its rows: without losses one may vanish here
        return float(np.linalg.det(narrow.motion(point.x).bordered(-1.0).real))

    found = where_it_vanishes(narrow, near, flip)
    if float(np.abs(found - near).max()) > segment.length:
        raise Strayed("another flip")
    point = CurvePoint(twice(found, p // 2, narrow.periods), segment.start.tangent, 0)
    place = float(segment.start.tangent @ (point.x - segment.start.x))
    if not 0.0 < place < segment.length:
        place = share * segment.length
    before = segment.at(_aside(segment, place)[0])
    return TurningBack(Happening(BranchEvent.HALVING, math.nan, point), before, None)


def _halves(point: CurvePoint, p: int, periods: int) -> tuple[Array, Array]:
    """The mean of both halves of a cycle, as unknowns of the curve of half the period, and their difference."""
    first, second = point.x[: p // 2], point.x[p // 2 : p] - math.pi * periods
    return np.concatenate([0.5 * (first + second), point.x[p:]]), second - first


def _crossing(segment: Segment) -> TurningBack | None:
    """Where the parameter turns back, det K(1) keeps its sign, and another branch crosses at right angles."""
    low, high = 0.0, segment.length
    first, last = segment.start, segment.stop
    if not first.tangent[-1] * last.tangent[-1] < 0.0 or not high > _CLOSE / _SINGULAR:
        return None
    if _fold(segment, first) * _fold(segment, last) <= 0.0:
        return None
    far = max(_singular(segment.curve, point) for point in (first, last))
    for _ in range(_MOST):
        if high - low < _CLOSE:
            break
        middle = 0.5 * (low + high)
        point = segment.at(middle)
        if point.tangent[-1] * last.tangent[-1] > 0.0:
            high, last = middle, point
        else:
            low, first = middle, point
    if max(_singular(segment.curve, point) for point in (first, last)) > _SINGULAR * far:
        return None
    place = 0.5 * (low + high)
    before, beyond = (segment.at(one) for one in _aside(segment, place))
    if _fold(segment, before) * _fold(segment, beyond) <= 0.0:
        return None
    return TurningBack(Happening(BranchEvent.CROSSING, math.nan, _top(segment, place)), before, beyond)


def _top(segment: Segment, near: float) -> CurvePoint:
    """Where the parameter has its extremum, by a cubic through points around it: nearer to it they are rounding."""
    places = _AROUND * math.sqrt(segment.curve.impacts) * np.array([-2.0, -1.0, 1.0, 2.0])
    rows = np.array([segment.at(near + place).x for place in places])
    powers = np.linalg.solve(np.vander(places, increasing=True), rows)
    place, (_, slope, bend, twist) = 0.0, powers[:, -1]
    for _ in range(_ROUNDS):
        place -= (slope + place * (2.0 * bend + place * 3.0 * twist)) / (2.0 * bend + place * 6.0 * twist)
    tangent = place ** _POWERS[:3] * _POWERS[1:] @ powers[1:]
    return CurvePoint(place**_POWERS @ powers, tangent / np.linalg.norm(tangent), 0)


def _fold(segment: Segment, point: CurvePoint) -> float:
    return indicator(segment.curve.motion(point.x), 1.0)


def _singular(curve: SolutionCurve, point: CurvePoint) -> float:
    """How far the equations are from a second solution of the tangent: the least singular value, rows of length 1."""
    matrix = curve.linearised(point.x)[0]
    return float(np.linalg.svd(matrix / np.linalg.norm(matrix, axis=1, keepdims=True), compute_uv=False)[-1])
