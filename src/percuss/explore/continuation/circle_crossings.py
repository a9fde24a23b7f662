"""The folds, flips and pairs on the unit circle in a step along a curve of orbits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from percuss.explore.continuation.branch_crossings import crossing_point
from percuss.explore.continuation.happenings import Happening, happening
from percuss.explore.continuation.indicators import BEYOND, indicator, multipliers, outside, unstable
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint
from percuss.model import System
from percuss.model.checks import ComplexArray
from percuss.stability.multipliers import TURNING

__all__ = ["crossings"]

_ASIDE = 1e-3  # share of the segment beside a fold or flip, nearer to which rounding decides how many are outside
_LEVEL = 1e-5  # of the tangent, its part along the parameter beside a fold, where rounding may decide on signs
_NARROW = 2.0**-12  # share of the segment within which a pair is followed to the unit circle


def crossings(
    segment: Segment, first: float, last: float, fresh: bool, narrow: Sequence[tuple[float, CurvePoint]] = ()
) -> list[Happening]:
    """Folds, flips and pairs on the unit circle between two places of a segment, in order.

    Parameters
    ----------
    segment
        The step.
    first, last
        The places. A corner is none: where an impact meets a step of the load multipliers jump, and K(ξ) with them.
    fresh
        Whether the segment begins at a flip, where the branch has an extremum of the parameter by itself: so near to
        it rounding decides on folds, and they are not looked for.
    narrow
        Places inside with their points, at which more may happen than the ends show.

    Raises
    ------
    Strayed
        Where the ends are not on one sheet of the branch.
    """
    points = [(first, segment.at(first))]
    for place, point in narrow:
        if first < place < last and _signs(segment, point) != _signs(segment, points[-1][1]):
            points.append((place, point))
    points.append((last, segment.at(last)))
    found = []
    for start, stop in pairwise(points):
        found += _between(segment, start, stop, fresh and start[0] == first)
    return sorted(found, key=lambda one: one.place)


def _signs(segment: Segment, point: CurvePoint) -> tuple[bool, bool]:
    """The signs of det K(1) and det K(−1)."""
    motion = segment.curve.motion(point.x)
    return indicator(motion, 1.0) > 0.0, indicator(motion, -1.0) > 0.0


def _between(
    segment: Segment, first: tuple[float, CurvePoint], last: tuple[float, CurvePoint], fresh: bool
) -> list[Happening]:
    """Folds, flips and pairs between two places, given with their points."""
    curve, (low, start), (high, stop) = segment.curve, first, last

    def fold(point: CurvePoint) -> float:
        return indicator(curve.motion(point.x), 1.0)

    def flip(point: CurvePoint) -> float:
        return indicator(curve.motion(point.x), -1.0)

    found = []
    turned, singular = start.tangent[-1] * stop.tangent[-1] < 0.0, fold(start) * fold(stop) < 0.0
    away = min(abs(start.tangent[-1]), abs(stop.tangent[-1])) > _LEVEL
    if not fresh and away and turned != singular:  # det K(1) and the tangent change their signs together on one sheet
        crossed = None if turned else crossing_point(segment, fold, low, high)
        if crossed is None:
            raise Strayed("on another sheet of the branch")
        found.append(Happening(BranchEvent.CROSSING, *crossed))
    if not fresh and turned and singular:
        found.append(happening(segment, BranchEvent.FOLD, segment.root(fold, low, high)))
    if flip(start) * flip(stop) < 0.0:
        found.append(happening(segment, BranchEvent.FLIP, segment.root(flip, low, high)))
    if curve.modes:
        places = sorted([low, *(one.place for one in found), high])
        found += [one for here, there in pairwise(places) for one in _pairs(segment, here, there)]
    return found


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
    """Where the pair is on the circle that is clearly outside it at one of two places, and not at the other.

    One that crosses slowly is on the circle further back; if not within the step, it is told where it is clearly off.
    """
    curve = segment.curve
    both = [multipliers(curve.motion(segment.at(place).x)) for place in (low, high)]
    outer = max(both, key=outside)
    if outer is None:
        return []
    beyond = outer[(outer.imag > TURNING * np.abs(outer)) & (np.abs(outer) > 1.0 + BEYOND)]
    if not beyond.size:
        return []
    seen = left = complex(beyond[np.argmin(np.abs(beyond))])
    circle = 1.0 + (BEYOND if _keeps_its_energy(curve.motion(segment.start.x).system, curve.modes) else 0.0)

    def tracked(place: float) -> complex:
        values = multipliers(curve.motion(segment.at(place).x))
        return complex(math.nan) if values is None else nearest(values, seen)

    def modulus(point: CurvePoint) -> float:
        values = multipliers(curve.motion(point.x))
        return math.nan if values is None else abs(nearest(values, seen)) - circle

    inner, end = (low, high) if outer is both[1] else (high, low)
    here, away = 0.5 * (low + high), inner - end
    while abs(tracked(inner)) >= circle and 0.0 < inner < segment.length:
        seen, inner, away = tracked(inner), min(max(inner + away, 0.0), segment.length), 2.0 * away
    first, last = sorted((inner, end))
    if nearest(outer, seen) == left and modulus(segment.at(first)) * modulus(segment.at(last)) < 0.0:
        place = segment.root(modulus, first, last)
        if abs(modulus(segment.at(place))) < BEYOND:
            here = place
    return [happening(segment, BranchEvent.NEIMARK_SACKER, here)]


def _keeps_its_energy(system: System, modes: int) -> bool:
    """Whether a pair is on the circle up to where it meets another one, and leaves it then like a square root."""
    damping = system.body.modes(modes, system.load.at).damping
    return system.contact.is_lossless and system.d == 0.0 and not np.any(damping)


def nearest(values: ComplexArray, to: complex) -> complex:
    """The value that is nearest to another."""
    return complex(values[np.argmin(np.abs(values - to))])
