"""The folds, flips and pairs on the unit circle in a step along a curve of orbits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import BEYOND, multipliers, outside, unstable
from percuss.explore.continuation.orbit_curve import SolutionCurve, twice, where_it_vanishes
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Number,
    Problem,
    refused,
)
from percuss.mechanics.flow import propagator
from percuss.model.checks import Array, ComplexArray
from percuss.steady.multipliers import TURNING
from percuss.steady.periodic.search import COALESCED

# ---- Where another branch crosses: det K(1) vanishes there, and the parameter does not turn back
#
# Motions without losses under a load that is the same backwards in time meet such points, where they cease to be the
# same backwards, too. There two tangents are possible, and beside it Newton's method decides between the branches by
# rounding: the point is found from both sides (Keller, in: Rabinowitz, ed., Applications of Bifurcation Theory, 1977).

_SHARES = (0.5, 0.3, 0.7)  # of what is left, at which a point is sought
_CLOSE = 1e-10  # of the parameter or a time, between both sides
_MOST = 60


def crossing_point(segment: CurveSegment, number: Number, low: float, high: float) -> tuple[float, CurvePoint] | None:
    """The place and point between two others at which a number vanishes; None where it jumps, from sheet to sheet."""
    first, last = segment.at(low), segment.at(high)
    below, above = number(first), number(last)
    size = max(abs(below), abs(above))
    for _ in range(_MOST):
        if not high - low > _CLOSE:
            break
        for share in _SHARES:
            try:
                place = low + share * (high - low)
                point = segment.at(place)
                break
            except CorrectorFailed:
                continue
        else:
            break
        here = number(point)
        if here * above > 0.0:
            high, last, above = place, point, here
        else:
            low, first, below = place, point, here
    if abs(above - below) > 0.5 * size or not high > low:
        return None
    share = below / (below - above)
    return low + share * (high - low), last._replace(x=first.x + share * (last.x - first.x))


# ---- The folds, flips and pairs on the unit circle in a step along a curve of orbits

_ASIDE = 1e-3  # share of the segment beside a fold or flip, nearer to which rounding decides how many are outside
_LEVEL = 1e-5  # of the tangent, its part along the parameter beside a fold, where rounding may decide on signs
_NARROW = 2.0**-12  # share of the segment within which a pair is followed to the unit circle


def crossings(
    segment: CurveSegment, first: float, last: float, fresh: bool, narrow: Sequence[tuple[float, CurvePoint]] = ()
) -> list[LocatedEvent]:
    """Folds, flips and pairs on the unit circle between two places of a step, in order, neither of them a corner."""
    # Of a `fresh` step, that begins at a flip, folds are not looked for, as rounding decides on them; at the `narrow`
    # places inside more may happen than the ends show. CorrectorFailed where these are not on one sheet of the branch.
    points = [(first, segment.at(first))]

    def signs(point: CurvePoint) -> list[bool]:
        return [number > 0.0 for number in segment.curve.motion(point.x).singular()]

    for place, point in narrow:
        if first < place < last and signs(point) != signs(points[-1][1]):
            points.append((place, point))
    points.append((last, segment.at(last)))
    found = []
    for start, stop in pairwise(points):
        found += _between(segment, start, stop, fresh and start[0] == first)
    return sorted(found, key=lambda one: one.place)


def _between(
    segment: CurveSegment, first: tuple[float, CurvePoint], last: tuple[float, CurvePoint], fresh: bool
) -> list[LocatedEvent]:
    curve, (low, start), (high, stop) = segment.curve, first, last

    def fold(point: CurvePoint) -> float:
        return float(curve.motion(point.x).singular()[0])

    def flip(point: CurvePoint) -> float:
        return float(curve.motion(point.x).singular()[1])

    found = []
    turned, singular = start.tangent[-1] * stop.tangent[-1] < 0.0, fold(start) * fold(stop) < 0.0
    away = min(abs(start.tangent[-1]), abs(stop.tangent[-1])) > _LEVEL
    if not fresh and away and turned != singular:  # det K(1) and the tangent change their signs together on one sheet
        crossed = None if turned else crossing_point(segment, fold, low, high)
        if crossed is None:
            raise CorrectorFailed("on another sheet of the branch")
        found.append(LocatedEvent(BranchEvent.CROSSING, *crossed))
    if not fresh and turned and singular:
        found.append(segment.event(BranchEvent.FOLD, segment.root(fold, low, high)))
    if flip(start) * flip(stop) < 0.0:
        found.append(segment.event(BranchEvent.FLIP, segment.root(flip, low, high)))
    if curve.modes:
        places = sorted([low, *(one.place for one in found), high])
        found += [one for here, there in pairwise(places) for one in _pairs(segment, here, there)]
    return found


def _pairs(segment: CurveSegment, start: float, stop: float) -> list[LocatedEvent]:
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


def _pair(segment: CurveSegment, low: float, high: float) -> list[LocatedEvent]:
    """Where the pair is on the circle that is clearly outside at one of two places; a slow one further back."""
    curve = segment.curve
    both = [multipliers(curve.motion(segment.at(place).x)) for place in (low, high)]
    outer = max(both, key=outside)
    if outer is None:
        return []
    beyond = outer[(outer.imag > TURNING * np.abs(outer)) & (np.abs(outer) > 1.0 + BEYOND)]
    if not beyond.size:
        return []
    seen = left = complex(beyond[np.argmin(np.abs(beyond))])
    system = curve.motion(segment.start.x).system
    damping = system.body.modes(curve.modes, system.load.at).damping
    # without losses a pair is on the circle up to where it meets another one, and leaves it then like a square root
    circle = 1.0 + (BEYOND if system.contact.is_lossless and system.d == 0.0 and not np.any(damping) else 0.0)

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
    return [segment.event(BranchEvent.NEIMARK_SACKER, here)]


def nearest(values: ComplexArray, to: complex) -> complex:
    """The value that is nearest to another."""
    return complex(values[np.argmin(np.abs(values - to))])


# ---- Where a branch comes to an orbit of more symmetry, at which it turns back over its own image
#
# An orbit of twice the period comes to the flip of the one whose period is doubled, and goes on with its halves
# exchanged. One that is not the same backwards in time, of a system that is, comes to one that is the same, and goes on
# backwards in time. Either way the parameter has an extremum there, det K(1) vanishes without a change of its sign, two
# tangents are possible, and the nearer a step ends to the place, the more of it rounding decides.

BESIDE = 5e-3
"""Of each impact in rad, how near to such a place a branch is looked at: nearer to it rounding decides on folds."""

_AROUND = 1e-3  # of each impact in rad, between the points that tell a crossing
_TURNED_SAME = 1e-9  # rad, between the halves of a cycle that are one
_TURNED_CLOSE = 1e-5  # rad, to which the place of a crossing is halved
_MOST_TURNS, _ROUNDS = 60, 4
_POWERS = np.arange(4.0)
_SINGULAR = 1e-2  # by which the equations are nearer to singular there than at the ends of the step


class TurningBack(NamedTuple):
    """What happens there, the last point before it, and the first one beyond it; None where the branch ends."""

    event: LocatedEvent
    before: CurvePoint
    beyond: CurvePoint | None


def turning_back(segment: CurveSegment) -> TurningBack | None:
    """Where in a step the branch turns back over its own image; None where it does not."""
    found = _halving(segment)
    return _crossing(segment) if found is None else found


def _aside(segment: CurveSegment, place: float) -> tuple[float, float]:
    """Places before and beyond one."""
    most = BESIDE * math.sqrt(segment.curve.impacts)
    return place - min(most, 0.5 * place), place + min(most, 0.5 * (segment.length - place))


def _halving(segment: CurveSegment) -> TurningBack | None:
    """Where the halves of the cycle become one orbit, found as its flip: there the doubled one has two tangents."""
    p, curve = segment.curve.impacts, segment.curve
    if p % 2 or curve.periods % 2:
        return None
    first, second = (halves(curve, point.x) for point in (segment.start, segment.stop))
    apart, after = float(np.linalg.norm(first[1])), float(np.linalg.norm(second[1]))
    if after < _TURNED_SAME < BESIDE * apart:
        raise CorrectorFailed("on the branch of half the period")
    if not first[1] @ second[1] < 0.0:
        return None
    share = apart / (apart + after)
    narrow = curve.other(p // 2, curve.periods // 2)
    near = (1.0 - share) * first[0] + share * second[0]

    def flip(point: CurvePoint) -> float:  # not by the lengths of its rows: without losses one may vanish here
        return float(np.linalg.det(narrow.motion(point.x).bordered(-1.0).real))

    found = where_it_vanishes(narrow, near, flip)
    if float(np.abs(found - near).max()) > segment.length:
        raise CorrectorFailed("another flip")
    point = CurvePoint(twice(found, p // 2, narrow.periods), segment.start.tangent, 0)
    place = float(segment.start.tangent @ (point.x - segment.start.x))
    if not 0.0 < place < segment.length:
        place = share * segment.length
    before = segment.at(_aside(segment, place)[0])
    return TurningBack(LocatedEvent(BranchEvent.HALVING, math.nan, point), before, None)


def halves(curve: Problem, x: Array) -> tuple[Array, Array]:
    """The mean of both halves of a cycle, as unknowns of the curve of half the period, and their difference."""
    p = curve.impacts
    first, second = x[: p // 2], x[p // 2 : p] - math.pi * curve.periods
    return np.concatenate([0.5 * (first + second), x[p:]]), second - first


def _crossing(segment: CurveSegment) -> TurningBack | None:
    """Where the parameter turns back, det K(1) keeps its sign, and another branch crosses at right angles."""
    low, high = 0.0, segment.length
    first, last = segment.start, segment.stop
    if not first.tangent[-1] * last.tangent[-1] < 0.0 or not high > _TURNED_CLOSE / _SINGULAR:
        return None
    if _fold(segment, first) * _fold(segment, last) <= 0.0:
        return None
    far = max(_singular(segment.curve, point) for point in (first, last))
    for _ in range(_MOST_TURNS):
        if high - low < _TURNED_CLOSE:
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
    return TurningBack(LocatedEvent(BranchEvent.CROSSING, math.nan, _top(segment, place)), before, beyond)


def _top(segment: CurveSegment, near: float) -> CurvePoint:
    """Where the parameter has its extremum, by a cubic through points around it: nearer to it they are rounding."""
    places = _AROUND * math.sqrt(segment.curve.impacts) * np.array([-2.0, -1.0, 1.0, 2.0])
    rows = np.array([segment.at(near + place).x for place in places])
    powers = np.linalg.solve(np.vander(places, increasing=True), rows)
    place, (_, slope, bend, twist) = 0.0, powers[:, -1]
    for _ in range(_ROUNDS):
        place -= (slope + place * (2.0 * bend + place * 3.0 * twist)) / (2.0 * bend + place * 6.0 * twist)
    tangent = place ** _POWERS[:3] * _POWERS[1:] @ powers[1:]
    return CurvePoint(place**_POWERS @ powers, tangent / np.linalg.norm(tangent), 0)


def _fold(segment: CurveSegment, point: CurvePoint) -> float:
    return float(segment.curve.motion(point.x).singular()[0])


def _singular(curve: SolutionCurve, point: CurvePoint) -> float:
    """How far the equations are from a second solution of the tangent: the least singular value, rows of length 1."""
    matrix = curve.linearised(point.x)[0]
    return float(np.linalg.svd(matrix / np.linalg.norm(matrix, axis=1, keepdims=True), compute_uv=False)[-1])


# ---- Where a motion is impossible in a place so narrow that neither end of a step shows it, or no step leads past it

_NEAR = 1e-7  # rad, before the place where an impact dies
_SAME = 1e-6  # rad, between both halves of a cycle
_BACK = 4  # points
_HALF = 0.5
_RESONANT = 1e-6  # det(I − M_n) below which internal resonance does


def dead_end(curve: SolutionCurve, points: Sequence[CurvePoint], refusal: PercussError | None) -> LocatedEvent:
    """What ends a branch at the last of its points, beyond which no step leads, and why the parameter does not."""
    orbit, kind = curve.motion(points[-1].x), BranchEvent.LOST
    if float(orbit.flight_times.min()) < 1e3 * COALESCED * orbit.period:
        kind = BranchEvent.COALESCENCE
    elif np.abs(orbit.modal_determinants().real).min(initial=1.0) < _RESONANT:
        kind = BranchEvent.RESONANCE
    elif refusal is not None:
        kind = refused(refusal)
    elif (death := dying_impact(points, lambda point: curve.motion(point.x).speeds)) is not None:
        return death
    elif curve.impacts % 2 == curve.periods % 2 == 0:  # where the halves meet a step of the load, not at their flip
        apart = halves(curve, points[-1].x)[1]
        kind = BranchEvent.HALVING if float(np.abs(apart).max()) < _SAME else kind
    return LocatedEvent(kind, 0.0, points[-1])


def dying_impact(points: Sequence[CurvePoint], speeds: Callable[[CurvePoint], Array]) -> LocatedEvent | None:
    """The death just beyond some points that lead there, or None: no step gets past where several impacts die."""
    last = points[-1]
    now = speeds(last)
    for first in points[-2 : -_BACK - 2 : -1]:  # so near to the place, the last step may have gone back by rounding
        before, way = speeds(first), last.x - first.x
        which = int(np.argmin(now / before))
        nearer = float(before[which] - now[which])
        share = float(now[which]) / nearer if nearer > 0.0 else 0.0
        if 0.0 < share * float(np.linalg.norm(way)) < _NEAR:
            return LocatedEvent(BranchEvent.DEATH, 0.0, last._replace(x=last.x + share * way), which)
    return None


def narrow_end(segment: CurveSegment, points: Sequence[tuple[float, CurvePoint]]) -> CurvePoint | None:
    """The first point inside a step where a mode swings up beyond both ends and the motion is impossible."""
    if not points:
        return None
    first, last = (segment.curve.motion(point.x) for point in (segment.start, segment.stop))
    known = first.system.body.modes(first.modes, first.system.load.at)
    size, widest = np.abs(known.gamma), np.maximum(first.amplitudes, last.amplitudes)
    off = -_HALF * max(first.sampled.height, last.sampled.height)
    away = _HALF * min(float(min(one.speeds.min(), one.rebound_speeds.min())) for one in (first, last))
    for _, point in points:
        motion = segment.curve.motion(point.x)
        if not motion.speeds.min() > 0.0:
            return point
        more = np.maximum(motion.amplitudes - widest, 0.0) * size
        if more.sum(axis=1).max() <= off and (more @ known.omega).max() <= away:
            continue
        if motion.sampled.height > 0.0:
            return point
    return None


# ---- The maps of the elastic modes through a cycle, with its times held, along a way beside a curve of orbits


class ModeMaps(NamedTuple):
    """M_n of every elastic mode along x(place) = x + place rate + place² bend, of which the times come first.

    `omega` and `damping` are those at place 0, `faster` and `duller` how they change with the place; `kept` and
    `turned` what an impact multiplies the strain and the velocity of a mode by.
    """

    x: Array
    rate: Array
    bend: Array
    omega: Array
    damping: Array
    faster: Array
    duller: Array
    kept: float
    turned: float
    period: float
    impacts: int

    def beside(self, place: float, point: CurvePoint) -> ModeMaps:
        """The same along the tangent of a point of the curve at a place."""
        rate = point.tangent / float(self.rate @ point.tangent) * float(self.rate @ self.rate)
        return self._replace(x=point.x - place * rate, rate=rate, bend=np.zeros_like(rate))

    def turning(self, length: float) -> Array:
        """By how much the angles of the modes may change over so much of the way; shape (N,)."""
        p = self.impacts
        moved = 2.0 * np.abs(np.diff(length * self.rate[:p] + length**2 * self.bend[:p])).sum()
        beyond = self.omega + length * self.faster
        return np.asarray(np.abs(length * self.faster) * self.period + np.maximum(self.omega, beyond) * moved)

    def determinants(self, n: npt.NDArray[np.intp] | slice, places: Array) -> Array:
        """det(1 − M_n) and det(−1 − M_n) of some modes; shape (2, k, l) for places of the shape (k, l) or (l,)."""
        p, at = self.impacts, places[..., None]
        times = self.x[:p] + at * self.rate[:p] + at**2 * self.bend[:p]
        flights = np.concatenate([times[..., 1:], times[..., :1] + self.period], axis=-1) - times
        omega = self.omega[n, None] + places * self.faster[n, None]
        damping = self.damping[n, None] + places * self.duller[n, None]
        step = propagator(omega[..., None], damping[..., None], flights)
        a, b, c, e = (part[..., 0] for part in step[:4])
        a, b, c, e = self.kept * a, self.kept * b, self.turned * c, self.turned * e
        for i in range(1, p):
            sa, sb, sc, se = (part[..., i] for part in step[:4])
            a, c = self.kept * (sa * a + sb * c), self.turned * (sc * a + se * c)
            b, e = self.kept * (sa * b + sb * e), self.turned * (sc * b + se * e)
        trace, size = a + e, a * e - b * c
        return np.stack([1.0 - trace + size, 1.0 + trace + size])


def mode_maps(segment: CurveSegment) -> ModeMaps | None:
    """Those along a segment; None without elastic modes, or where the other end has other ones."""
    curve, length = segment.curve, segment.length
    if not curve.modes or not length > 0.0:
        return None
    systems = [curve.system(curve.value(point.x)) for point in (segment.start, segment.stop)]
    first, last = (system.body.modes(curve.modes, system.load.at) for system in systems)
    omega, damping = np.asarray(first.omega), np.asarray(first.damping) + np.zeros(np.shape(first.omega))
    if not omega.size or np.shape(last.omega) != omega.shape:
        return None
    start, ahead, contact = segment.start.x, segment.start.tangent, systems[0].contact
    return ModeMaps(
        start, ahead, (segment.stop.x - start - length * ahead) / length**2,
        omega, damping, (np.asarray(last.omega) - omega) / length, (np.asarray(last.damping) - damping) / length,
        contact.strain_factor, contact.velocity_factor, 2.0 * math.pi * curve.periods, curve.impacts,
    )  # fmt: skip


# ---- Where in a step an elastic mode comes back after a cycle almost by itself, and multipliers may change in a moment
#
# With M_n the map of mode n through a cycle at fixed times, K(ξ) has the poles det(ξ − M_n) = 0. A mode without much
# damping brings det(1 − M_n) or det(−1 − M_n) near to 0 in narrow places, and the two flips or folds on both sides of
# one leave no trace at the ends of a step. The maps depend on the flights and the frequencies alone, and tell the
# places without any orbit.

Place = tuple[float, CurvePoint]  # a place in a segment, and the point of the curve there
_FINE = 0.4  # rad, by which the fastest mode goes on from sample to sample
_FEWEST, _MOST_RESONANCES = 9, 1025
_STILL = 1e-3  # rad, by which a mode goes on in a step, below which it stays as it is
_DAMPED = 2.0 * math.log(1e3)  # of a mode within a cycle, from which on nothing comes back
_NEAR_RESONANCE = 0.5  # of det(±1 − M_n), above which nothing is narrow
_CLOSER = (0.1, 1e-2, 1e-3, 1e-4, 1e-5)  # rad on both sides of a least value, between which a parabola tells it
_DEEP = 1e-4  # of such a value, below which all of these are needed
_PLACES = 12  # in a step, of the lowest modes and the deepest first
_NARROW_RESONANCE = 1e-2  # of det(±1 − M_n), below which the place is sought again from its own point
_BY_ITSELF = 1e-6  # det(±1 − M_n) below which a mode comes back by itself
_BESIDE = 1e-5  # rad, by which the angle of such a mode is on either side
_OFF = 0.3  # of the half width of such a place, by which it may be off
_AGAIN = 3  # times that a place is sought
_CLEAR = 100.0  # of that, from which on there are points of the curve
_OFF_MEAN = 0.015  # rad, between a chord and the mean of both tangents
_ALIKE = 0.2  # of the greater of both ends, by which det K(±1) in between may be beside the straight line


class _Least(NamedTuple):
    """Least values of det(±1 − M_n), (k,): the mode from 0, 0 for ξ = 1 or 1 for −1, its radians in the place."""

    mode: npt.NDArray[np.intp]
    which: npt.NDArray[np.intp]
    place: Array
    rate: Array
    value: Array

    def some(self, which: npt.NDArray[np.intp] | slice) -> _Least:
        return _Least(self.mode[which], self.which[which], self.place[which], self.rate[which], self.value[which])


def resonant_points(segment: CurveSegment, skip: bool) -> list[Place]:
    """Points inside a segment at which det(1 − M_n) or det(−1 − M_n) of a mode has a small least value, in order."""
    # A mode that comes back by itself swings up without bound as the place is neared, often on one side only: there it
    # is the points on both sides. To `skip` places without a point they are left out; else CorrectorFailed is raised.
    maps = mode_maps(segment)
    least = None if maps is None else _least_values(maps, segment.length)
    if maps is None or least is None:
        return []
    found: list[Place] = []
    for k in range(least.mode.size):
        try:
            found += _points(segment, maps, least.some(slice(k, k + 1)))
        except CorrectorFailed:
            if not skip:
                raise
    return sorted(found, key=lambda one: one[0])


def _points(segment: CurveSegment, maps: ModeMaps, one: _Least) -> list[Place]:
    """The point of a least value, or both beside it, each sought again along the tangent."""
    place, length, found = float(one.place[0]), segment.length, []
    if one.value[0] > _NARROW_RESONANCE:
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
    samples = min(max(math.ceil(float(turned.max()) / _FINE) + 1, _FEWEST), _MOST_RESONANCES)
    places = np.linspace(0.0, length, samples)
    values = maps.determinants(slice(None), places)
    inside = values[..., 1:-1]
    least = (inside <= values[..., :-2]) & (inside < values[..., 2:]) & (inside < _NEAR_RESONANCE)
    which, mode, sample = np.nonzero(least & (turned > _STILL)[:, None])
    if not which.size:
        return None
    kept = np.argsort(inside[which, mode, sample] * (mode + 1.0) ** 2, kind="stable")[: 4 * _PLACES]
    which, mode, sample = which[kept], mode[kept], sample[kept]
    rate = turned[mode] / length
    found = _closer(maps, _Least(mode, which, places[sample + 1], rate, inside[which, mode, sample]))
    kept = np.sort(np.unique(np.round(found.place / (_TURNED_SAME * length)), return_index=True)[1])[:_PLACES]
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


def sheet_jump(segment: CurveSegment, most: float = _OFF_MEAN) -> bool:
    """Whether the chord leads further aside than its tangents: on one sheet it has their mean direction."""
    if not segment.curve.modes:
        return False
    chord, mean = segment.stop.x - segment.start.x, segment.start.tangent + segment.stop.tangent
    if not (np.any(chord) and np.any(mean)):
        return False
    off = chord / np.linalg.norm(chord) - mean / np.linalg.norm(mean)
    return bool(np.linalg.norm(off) > most)


def hidden_crossing(segment: CurveSegment, points: Sequence[Place]) -> bool:
    """Whether det K(±1) inside a step is so far from what its ends let expect that more may happen there."""
    if not points:
        return False
    low, high = (np.array(segment.curve.motion(point.x).singular()) for point in (segment.start, segment.stop))
    size = np.maximum(np.abs(low), np.abs(high))
    for place, point in points:
        share = place / segment.length
        here = np.array(segment.curve.motion(point.x).singular())
        if np.any(np.abs(here - (1.0 - share) * low - share * high) > _ALIKE * size):
            return True
    return False
