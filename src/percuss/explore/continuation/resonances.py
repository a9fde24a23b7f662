"""Where in a step an elastic mode comes back after a cycle almost by itself, and multipliers may change in a moment.

With M_n the map of mode n through a cycle at fixed times, K(ξ) has the poles det(ξ − M_n) = 0. A mode without much
damping brings det(1 − M_n) or det(−1 − M_n) near to 0 in narrow places, and the two flips or folds on both sides of
one leave no trace at the ends of a step. The maps depend on the flights and the frequencies alone, and tell the places
without any orbit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.indicators import indicator
from percuss.explore.continuation.mode_maps import ModeMaps, mode_maps
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint
from percuss.model.checks import Array

__all__ = ["Place", "hides", "leaps", "resonant_points"]

Place = tuple[float, CurvePoint]
"""A place in a segment, and the point of the curve there."""

_FINE = 0.4  # rad, by which the fastest mode goes on from sample to sample
_FEWEST, _MOST = 9, 1025
_STILL = 1e-3  # rad, by which a mode goes on in a step, below which it stays as it is
_DAMPED = 2.0 * math.log(1e3)  # of a mode within a cycle, from which on nothing comes back
_NEAR = 0.5  # of det(±1 − M_n), above which nothing is narrow
_CLOSER = (0.1, 1e-2, 1e-3, 1e-4, 1e-5)  # rad on both sides of a least value, between which a parabola tells it
_DEEP = 1e-4  # of such a value, below which all of these are needed
_SAME = 1e-9  # of a step: modes whose times have a common measure come back together
_PLACES = 12  # in a step, of the lowest modes and the deepest first
_NARROW = 1e-2  # of det(±1 − M_n), below which the place is sought again from its own point
_BY_ITSELF = 1e-6  # det(±1 − M_n) below which a mode comes back by itself
_BESIDE = 1e-5  # rad, by which the angle of such a mode is on either side
_OFF = 0.3  # of the half width of such a place, by which it may be off
_AGAIN = 3  # times that a place is sought
_CLEAR = 100.0  # of that, from which on there are points of the curve
_OFF_MEAN = 0.015  # rad, between a chord and the mean of both tangents
_ALIKE = 0.2  # of the greater of both ends, by which det K(±1) in between may be beside the straight line


class _Least(NamedTuple):
    """Least values of det(±1 − M_n); each of the shape (k,).

    `mode` counts from 0, `which` is 0 for ξ = 1 and 1 for ξ = −1, `rate` is by how many radians the mode may go on in
    the place.
    """

    mode: npt.NDArray[np.intp]
    which: npt.NDArray[np.intp]
    place: Array
    rate: Array
    value: Array

    def some(self, which: npt.NDArray[np.intp] | slice) -> _Least:
        """Some of them."""
        return _Least(self.mode[which], self.which[which], self.place[which], self.rate[which], self.value[which])


def resonant_points(segment: Segment, skip: bool) -> list[Place]:
    """Points inside a segment at which det(1 − M_n) or det(−1 − M_n) of a mode has a small least value, in order.

    A mode that comes back by itself swings up without bound as the place is neared, often on one side only: there it
    is the points on both sides.

    Parameters
    ----------
    segment
        The step.
    skip
        Whether places without a point are left out; else Strayed is raised.
    """
    maps = mode_maps(segment)
    least = None if maps is None else _least_values(maps, segment.length)
    if maps is None or least is None:
        return []
    found: list[Place] = []
    for k in range(least.mode.size):
        try:
            found += _points(segment, maps, least.some(slice(k, k + 1)))
        except Strayed:
            if not skip:
                raise
    return sorted(found, key=lambda one: one[0])


def _points(segment: Segment, maps: ModeMaps, one: _Least) -> list[Place]:
    """The point of a least value, or those on both sides of it.

    The way beside the curve is not the curve: the place is sought again along the tangent of each point found.
    """
    place, length, found = float(one.place[0]), segment.length, []
    if one.value[0] > _NARROW:
        return [(place, segment.at(place))] if 0.0 < place < length else []
    free = bool(one.value[0] < _BY_ITSELF)
    width = (_BESIDE if free else _OFF * math.sqrt(float(one.value[0]))) / float(one.rate[0])
    for _ in range(_AGAIN):
        near = place - _CLEAR * width if free else place  # at such a place itself there may be no point
        if not 0.0 < near < place + width < length:
            break
        found.append((near, segment.at(near)))
        before, one = place, _closer(maps.beside(*found[-1]), one._replace(place=np.array([place])))
        place = float(one.place[0])
        if not free and abs(place - before) < width:
            break
    if not free or not found:
        return found[-1:]
    return [(side, segment.at(side)) for side in (place - width, place + width) if 0.0 < side < length]


def _least_values(maps: ModeMaps, length: float) -> _Least | None:
    """The least values inside a length, each told by parabolas."""
    turned = maps.turning(length)
    if np.all(maps.damping * maps.period > _DAMPED):
        return None
    samples = min(max(math.ceil(float(turned.max()) / _FINE) + 1, _FEWEST), _MOST)
    places = np.linspace(0.0, length, samples)
    values = maps.determinants(slice(None), places)
    inside = values[..., 1:-1]
    least = (inside <= values[..., :-2]) & (inside < values[..., 2:]) & (inside < _NEAR)
    which, mode, sample = np.nonzero(least & (turned > _STILL)[:, None])
    if not which.size:
        return None
    kept = np.argsort(inside[which, mode, sample] * (mode + 1.0) ** 2, kind="stable")[: 4 * _PLACES]
    which, mode, sample = which[kept], mode[kept], sample[kept]
    rate = turned[mode] / length
    found = _closer(maps, _Least(mode, which, places[sample + 1], rate, inside[which, mode, sample]))
    kept = np.sort(np.unique(np.round(found.place / (_SAME * length)), return_index=True)[1])[:_PLACES]
    return found.some(kept)


def _closer(maps: ModeMaps, least: _Least) -> _Least:
    """The same, nearer and nearer: by parabolas, which tell it well as the numbers vanish as squares."""
    rows, place, value = np.arange(least.mode.size), np.array(least.place), least.value
    for angle in _CLOSER if np.any(least.value < _DEEP) else _CLOSER[:2]:
        h = angle / least.rate
        at = place[:, None] + h[:, None] * np.array([-1.0, 0.0, 1.0])
        low, middle, high = maps.determinants(least.mode, at)[least.which, rows].T
        bend, slope = low - 2.0 * middle + high, 0.5 * (high - low)
        bend = np.where(bend > 0.0, bend, 1e-300)
        share = np.clip(-slope / bend, -2.0, 2.0)
        place, value = place + share * h, middle - 0.5 * share**2 * bend
    return least._replace(place=place, value=np.asarray(value))


def leaps(segment: Segment) -> bool:
    """Whether a step leads further aside than its two tangents do, as one does that goes on on another sheet.

    On one sheet the chord has the mean direction of both tangents, but for the square of the step.
    """
    if not segment.curve.modes:
        return False
    chord, mean = segment.stop.x - segment.start.x, segment.start.tangent + segment.stop.tangent
    if not (np.any(chord) and np.any(mean)):
        return False
    off = chord / np.linalg.norm(chord) - mean / np.linalg.norm(mean)
    return bool(np.linalg.norm(off) > _OFF_MEAN)


def hides(segment: Segment, points: Sequence[Place]) -> bool:
    """Whether det K(1) or det K(−1) at points inside a step is so far from what the ends let expect that more may be.

    Beside a place where a mode comes back the curve may turn to and fro, and which of its sheets is met there is by
    chance; but both numbers fall, or rise, long before.
    """
    if not points:
        return False
    low, high = (_numbers(segment, point) for point in (segment.start, segment.stop))
    size = np.maximum(np.abs(low), np.abs(high))
    for place, point in points:
        share = place / segment.length
        if np.any(np.abs(_numbers(segment, point) - (1.0 - share) * low - share * high) > _ALIKE * size):
            return True
    return False


def _numbers(segment: Segment, point: CurvePoint) -> Array:
    motion = segment.curve.motion(point.x)
    return np.array([indicator(motion, 1.0), indicator(motion, -1.0)])
