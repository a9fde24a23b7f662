"""What happens within a step along a branch: where it ends, and which multipliers come to the unit circle before."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.corners import Passed, landed, step_time, steps_passed
from percuss.explore.continuation.indicators import (
    greatest_top,
    indicator,
    multipliers,
    outside,
    press,
    stays_off,
    unstable,
)
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.rises import rise
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import (
    CurvePoint,
    Number,
    Strayed,
    twice,
    where_it_vanishes,
)
from percuss.model.checks import Array, ComplexArray
from percuss.stability.multipliers import TURNING
from percuss.steady import PeriodicOrbit

__all__ = ["Happening", "crossings", "end_of", "to_corner"]

_BEFORE = 1e-6  # share of the way to a place that what holds just before it is asked at
_ASIDE = 1e-3  # share of the segment beside a fold or flip, nearer to which rounding decides how many are outside
_CLOSE_TO_HALF = 0.1  # share of the way to the place where the halves are one: nearer there are two tangents
_LEVEL = 1e-5  # of the tangent, its part along the parameter beside a fold, where rounding may decide on signs
_NARROW = 2.0**-12  # share of the segment within which a pair is followed to the unit circle


class Happening(NamedTuple):
    """What happens at a place: its kind, the point, the number of the impact or flight that it happens to, or -1."""

    kind: BranchEvent
    place: float
    point: CurvePoint
    which: int = -1


def end_of(segment: Segment, passed: Passed, fresh: bool) -> Happening | None:
    """The first thing in a segment beyond which the motion is no orbit, or after which the curve has a corner.

    Parameters
    ----------
    segment
        The step.
    passed
        How many steps of the load there were before each impact at its start.
    fresh
        Whether it begins at a flip, where the two halves of the cycle are one.
    """
    found = [*_deaths(segment), *_corners(segment, passed), *([] if fresh else _halvings(segment))]
    first = min(found, key=lambda one: one.place) if found else None
    segment = to_corner(segment, first)
    last = segment.length if first is None else first.place * (1.0 - _BEFORE)
    orbit = segment.curve.motion(segment.at(last).x)
    if stays_off(orbit):
        hidden = rise(segment, last)
        if hidden is None:
            return first
        last, orbit = hidden, segment.curve.motion(segment.at(hidden).x)
    return _contact(segment, orbit, last) or first


def to_corner(segment: Segment, first: Happening | None) -> Segment:
    """The part of a segment up to a corner: what is beyond it says nothing about the way there."""
    if first is None or first.kind is not BranchEvent.CORNER:
        return segment
    return Segment(segment.curve, segment.start, first.point)


def _happening(segment: Segment, kind: BranchEvent, place: float, which: int = -1) -> Happening:
    return Happening(kind, place, segment.at(place), which)


def _deaths(segment: Segment) -> list[Happening]:
    curve = segment.curve
    last = curve.motion(segment.stop.x).speeds

    def speed(i: int) -> Number:
        return lambda point: float(curve.motion(point.x).speeds[i])

    return [
        _happening(segment, BranchEvent.DEATH, segment.root(speed(int(i))), int(i)) for i in np.flatnonzero(last <= 0.0)
    ]


def _halvings(segment: Segment) -> list[Happening]:
    """Where the two halves of the cycle become one and the same orbit: what tells them apart turns over.

    It is the flip of the orbit of half the period, and found as that: there the doubled one has two tangents.
    """
    p, curve = segment.curve.impacts, segment.curve
    if p % 2 or curve.periods % 2:
        return []
    first, second = (_halves(point, p, curve.periods) for point in (segment.start, segment.stop))
    if not first[1] @ second[1] < 0.0:
        return []
    share = float(np.linalg.norm(first[1]) / (np.linalg.norm(first[1]) + np.linalg.norm(second[1])))
    narrow = curve.other(p // 2, curve.periods // 2)
    near = (1.0 - share) * first[0] + share * second[0]

    def flip(point: CurvePoint) -> float:
        return indicator(narrow.motion(point.x), -1.0)

    found = where_it_vanishes(narrow, near, flip)
    if float(np.abs(found - near).max()) > segment.length:
        raise Strayed("another flip")
    point = CurvePoint(twice(found, p // 2, narrow.periods), segment.start.tangent, 0)
    return [Happening(BranchEvent.HALVING, share * (1.0 - _CLOSE_TO_HALF) * segment.length, point)]


def _halves(point: CurvePoint, p: int, periods: int) -> tuple[Array, Array]:
    """The mean of both halves of a cycle, as unknowns of the curve of half the period, and their difference."""
    first, second = point.x[: p // 2], point.x[p // 2 : p] - math.pi * periods
    return np.concatenate([0.5 * (first + second), point.x[p:]]), second - first


def _corners(segment: Segment, passed: Passed) -> list[Happening]:
    curve = segment.curve
    now = steps_passed(curve.motion(segment.stop.x))
    found = []
    for i in np.flatnonzero(now != passed).tolist():
        later = bool(now[i] > passed[i])
        number = int(passed[i]) if later else int(passed[i]) - 1

        def off(point: CurvePoint, i: int = i, number: int = number) -> float:
            return float(point.x[i]) - step_time(curve.motion(point.x), number)

        before = min(off(segment.start), -1e-300) if later else max(off(segment.start), 1e-300)
        near = _happening(segment, BranchEvent.CORNER, segment.root(off, below=before), i)
        point = landed(curve, near.point, i, passed)
        place = float(segment.start.tangent @ (point.x - segment.start.x))
        found.append(near._replace(point=point, place=place))
    return found


def _contact(segment: Segment, beyond: PeriodicOrbit, last: float) -> Happening | None:
    """Where the bar first touches the wall between two impacts, or stays on it after one."""
    curve, found = segment.curve, []

    def top(point: CurvePoint) -> float:
        return max(greatest_top(curve.motion(point.x)).height, -1.0)

    def pressed(point: CurvePoint) -> float:
        return press(curve.motion(point.x))[0]

    if greatest_top(beyond).height > 0.0:
        place = segment.root(top, 0.0, last)
        found.append(_happening(segment, BranchEvent.TOUCH, place))
    if not beyond.system.contact.rebounds and press(beyond)[0] >= 0.0:
        place = segment.root(pressed, 0.0, last)
        at = segment.at(place)
        found.append(Happening(BranchEvent.STICKING, place, at, press(curve.motion(at.x))[1]))
    return min(found, key=lambda one: one.place) if found else None


def crossings(segment: Segment, first: float, last: float, fresh: bool) -> list[Happening]:
    """Folds, flips and pairs on the unit circle between two places of a segment, in order.

    Parameters
    ----------
    segment
        The step.
    first, last
        The places. A corner is none: where an impact meets a step of the load multipliers jump, and K(ξ) with them.
    fresh
        Whether the segment begins at a flip, where the branch has an extremum of the parameter by itself.

    Raises
    ------
    Strayed
        Where the ends are not on one sheet of the branch.
    """
    start, stop, curve = segment.at(first), segment.at(last), segment.curve

    def fold(point: CurvePoint) -> float:
        return indicator(curve.motion(point.x), 1.0)

    def flip(point: CurvePoint) -> float:
        return indicator(curve.motion(point.x), -1.0)

    found = []
    turned, singular = start.tangent[-1] * stop.tangent[-1] < 0.0, fold(start) * fold(stop) < 0.0
    away = min(abs(start.tangent[-1]), abs(stop.tangent[-1])) > _LEVEL
    if not fresh and away and turned != singular:  # det K(1) and the tangent change their signs together on one sheet
        raise Strayed("on another sheet of the branch")
    if not fresh and turned and singular:
        found.append(_happening(segment, BranchEvent.FOLD, segment.root(fold, first, last)))
    if flip(start) * flip(stop) < 0.0:
        found.append(_happening(segment, BranchEvent.FLIP, segment.root(flip, first, last)))
    if curve.modes:
        places = sorted([first, *(one.place for one in found), last])
        found += [one for low, high in pairwise(places) for one in _pairs(segment, low, high)]
    return sorted(found, key=lambda one: one.place)


def _pairs(segment: Segment, start: float, stop: float) -> list[Happening]:
    """Where a pair of multipliers comes to the unit circle between two places, if the number outside tells of one."""
    curve, aside = segment.curve, _ASIDE * segment.length
    low, high = start + (aside if start else 0.0), stop - (aside if stop < segment.length else 0.0)
    if low >= high:
        return []

    def count(place: float) -> int:
        return unstable(curve.motion(segment.at(place).x))

    first, second = count(low), count(high)
    if min(first, second) < 0 or abs(second - first) < 2:
        return []
    while high - low > _NARROW * segment.length:
        middle = 0.5 * (low + high)
        now = count(middle)
        if abs(now - first) >= abs(second - now):
            high, second = middle, now
        else:
            low, first = middle, now
    return _pair(segment, low, high)


def _pair(segment: Segment, low: float, high: float) -> list[Happening]:
    curve = segment.curve
    both = [multipliers(curve.motion(segment.at(place).x)) for place in (low, high)]
    outer = max(both, key=outside)
    if outer is None:
        return []
    beyond = outer[(outer.imag > TURNING * np.abs(outer)) & (np.abs(outer) > 1.0)]
    if not beyond.size:
        return []
    seen = complex(beyond[np.argmin(np.abs(beyond))])

    def modulus(point: CurvePoint) -> float:
        values = multipliers(curve.motion(point.x))
        return math.nan if values is None else abs(nearest(values, seen)) - 1.0

    if not modulus(segment.at(low)) * modulus(segment.at(high)) < 0.0:
        return []
    return [_happening(segment, BranchEvent.NEIMARK_SACKER, segment.root(modulus, low, high))]


def nearest(values: ComplexArray, to: complex) -> complex:
    """The value that is nearest to another."""
    return complex(values[np.argmin(np.abs(values - to))])
