"""What happens within a step along a branch, and where in it the branch ends."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.orbit_curve import (
    Passed,
    SolutionCurve,
    landed,
    lateness,
    steps_passed,
    turning,
    twice,
    where_it_vanishes,
)
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, CurveSegment, LocatedEvent, Number
from percuss.model.checks import Array, ComplexArray
from percuss.steady import PeriodicOrbit
from percuss.steady.flight import start_acceleration
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS

# ---- What is looked at on every point of a branch, to see what happens between two of them

BEYOND = 1e-7
"""Of 1, by which a multiplier beyond the unit circle is counted; nearer to it double ones are lost to rounding."""

_MANY = 12  # modes from which on it is faster not to compute the multipliers
_CLEARLY = 1e-6  # of how far a bar flies at most, by which it is clearly beyond the wall
_DEAD = 1e-13  # of the greatest velocity of the bar as a whole; less is rounding


@lru_cache(maxsize=64)
def multipliers(orbit: PeriodicOrbit) -> ComplexArray | None:
    """The multipliers, not to be written into; None at an impact without speed: beside it they have no bound."""
    # The last are kept: each step of a walk asks for those at its start again.
    return None if _has_dead(orbit) else orbit.multipliers().values


def _has_dead(orbit: PeriodicOrbit) -> bool:
    greatest = np.abs(orbit.rigid_velocities if orbit.system.body.is_free else orbit.speeds).max()
    return not np.all(np.abs(orbit.speeds) > _DEAD * greatest)


def outside(values: ComplexArray | None) -> int:
    """How many multipliers are outside the unit circle; -1 where none are known."""
    return -1 if values is None else int(np.count_nonzero(np.abs(values) > 1.0 + BEYOND))


@lru_cache(maxsize=64)
def unstable(orbit: PeriodicOrbit) -> int:
    """`outside` of the multipliers of an orbit; of many modes by the determinants of K(ξ) on the circle alone."""
    if orbit.modes >= _MANY and not _has_dead(orbit):
        counted = orbit.outside(BEYOND)
        if counted is not None:
            return counted
    return outside(multipliers(orbit))


def press(orbit: PeriodicOrbit) -> tuple[float, int]:
    """After which impact the striking end is pressed to the wall most, and its acceleration there; for R = 0."""
    rates = [start_acceleration(flight) for flight in orbit.flights]
    return max(rates), int(np.argmax(rates))


def stays_off(orbit: PeriodicOrbit) -> bool:
    """Whether the bar stays off the wall between the impacts: samples prove it, or where they do not, all bounds."""
    found = orbit.sampled
    if found.height > _CLEARLY * float(orbit.speeds.max()) * orbit.period:  # beyond what all modes may change of it
        return False
    return orbit._stays_off


# ---- Whether the bar passes through the wall for a moment of a step along a branch, and at neither of its ends

_NEAR = 0.5  # share of the nearest of three heights below the wall
_GOLDEN, _LOOKS = 0.6180339887498949, 8


def _top(segment: CurveSegment) -> Number:
    """The greatest maximum of the gap function inside the flights, at a point; −1 for none."""
    return lambda point: max(float(segment.curve.motion(point.x).sampled.height), -1.0)


def inner_touch(segment: CurveSegment, last: float) -> float | None:
    """A place where the bar passes through the wall, where three values let a nearer maximum be expected."""
    height = _top(segment)
    low, middle, high = (height(segment.at(share * last)) for share in (0.0, 0.5, 1.0))
    if middle > 0.0:
        return 0.5 * last
    bend, slope = 2.0 * (low - 2.0 * middle + high), 4.0 * middle - 3.0 * low - high
    if not (bend < 0.0 < slope < -2.0 * bend) or low - 0.25 * slope**2 / bend < _NEAR * max(low, middle, high):
        return None
    first, second = 0.0, last
    for _ in range(_LOOKS):  # golden section
        inner, outer = (second - _GOLDEN * (second - first), first + _GOLDEN * (second - first))
        heights = height(segment.at(inner)), height(segment.at(outer))
        if max(heights) > 0.0:
            return inner if heights[0] > 0.0 else outer
        first, second = (first, outer) if heights[0] > heights[1] else (inner, second)
    return None


# ---- What happens within a step along a branch, and where in it the branch ends

_BEFORE = 1e-6  # share of the way to a place that what holds just before it is asked at


def end_of(segment: CurveSegment, passed: Passed) -> LocatedEvent | None:
    """The first thing in a step beyond which the motion is no orbit, or after which the curve has a corner."""
    found = [*_deaths(segment), *_corners(segment, passed)]
    first = min(found, key=lambda one: one.place) if found else None
    segment = to_corner(segment, first)
    last = segment.length if first is None else first.place * (1.0 - _BEFORE)
    orbit = segment.curve.motion(segment.at(last).x)
    if stays_off(orbit):
        hidden = inner_touch(segment, last)
        if hidden is None:
            return first
        last, orbit = hidden, segment.curve.motion(segment.at(hidden).x)
    return _contact(segment, orbit, last) or first


def to_corner(segment: CurveSegment, first: LocatedEvent | None) -> CurveSegment:
    """The part of a segment up to a corner: what is beyond it says nothing about the way there."""
    if first is None or first.kind is not BranchEvent.CORNER:
        return segment
    return CurveSegment(segment.curve, segment.start, first.point)


def _deaths(segment: CurveSegment) -> list[LocatedEvent]:
    curve = segment.curve
    last = curve.motion(segment.stop.x).speeds

    def speed(i: int) -> Number:
        return lambda point: float(curve.motion(point.x).speeds[i])

    return [segment.event(BranchEvent.DEATH, segment.root(speed(int(i))), int(i)) for i in np.flatnonzero(last <= 0.0)]


def _corners(segment: CurveSegment, passed: Passed) -> list[LocatedEvent]:
    curve = segment.curve
    now = steps_passed(curve.motion(segment.stop.x))
    found = []
    for i in np.flatnonzero(now != passed).tolist():
        later = bool(now[i] > passed[i])
        number = int(passed[i]) if later else int(passed[i]) - 1

        def off(point: CurvePoint, i: int = i, number: int = number) -> float:
            return lateness(curve, point.x, i, number)

        before = min(off(segment.start), -1e-300) if later else max(off(segment.start), 1e-300)
        near = segment.event(BranchEvent.CORNER, segment.root(off, below=before), i)
        point = landed(curve, near.point, i, passed)
        place = float(segment.start.tangent @ (point.x - segment.start.x))
        found.append(near._replace(point=point, place=place))
    return found


def _contact(segment: CurveSegment, beyond: PeriodicOrbit, last: float) -> LocatedEvent | None:
    """Where the bar first touches the wall between two impacts, or stays on it after one."""
    curve, found = segment.curve, []

    def pressed(point: CurvePoint) -> float:
        return press(curve.motion(point.x))[0]

    if beyond.sampled.height > 0.0:
        place = segment.root(_top(segment), 0.0, last)
        found.append(segment.event(BranchEvent.TOUCH, place))
    if not beyond.system.contact.rebounds and press(beyond)[0] >= 0.0:
        place = segment.root(pressed, 0.0, last)
        at = segment.at(place)
        found.append(LocatedEvent(BranchEvent.STICKING, place, at, press(curve.motion(at.x))[1]))
    return min(found, key=lambda one: one.place) if found else None


# ---- Whether a number of the orbits may vanish twice in a step along a branch, so that its two ends do not show it

_NEAR_ZERO = 0.25  # share of the least of three values


def double_zero(segment: CurveSegment) -> bool:
    """Whether the speed of an impact, det K(1) or det K(−1) may vanish twice in a step, as its middle tells."""
    orbits = [segment.curve.motion(segment.at(share * segment.length).x) for share in (0.0, 0.5, 1.0)]
    low, half, high = (np.append(orbit.speeds, orbit.singular()) for orbit in orbits)
    side = np.sign(low)
    low, half, high = low * side, half * side, high * side
    bend, slope = 2.0 * (low - 2.0 * half + high), 4.0 * half - 3.0 * low - high
    with np.errstate(divide="ignore", invalid="ignore"):
        within = (slope < 0.0) & (-slope < 2.0 * bend)
        least = low - 0.25 * slope**2 / bend
        dip = within & (least < _NEAR_ZERO * np.minimum(np.minimum(low, half), high))
    return bool(np.any((high > 0.0) & ((half <= 0.0) | dip)))


# ---- The other branches that begin at a point of one: at a flip, and where an impact dies or is born

Partner = tuple[SolutionCurve, CurvePoint]
"""A curve and the point on it where a branch begins, with the tangent that leads into it."""

_TRIED = 1e-3  # rad, by which it is tried which way leads into a branch


def doubled(curve: SolutionCurve, point: CurvePoint) -> Partner | None:
    """The branch z=2p/2n from a flip, at first (t, t + T) along (v, −v), K(−1) v = 0; None for too long ones."""
    p = curve.impacts
    if 2 * p > MOST_IMPACTS or 2 * curve.periods > MOST_PERIODS:
        return None
    orbit = curve.motion(point.x)
    null = np.linalg.svd(orbit.bordered(-1.0).real)[2][-1]
    moved = null[p] + turning(orbit) * null[0]
    tangent = np.concatenate([null[:p], -null[:p], [moved, 0.0]])
    x = twice(point.x, p, curve.periods)
    wider = curve.other(2 * p, 2 * curve.periods)
    return wider, CurvePoint(x, tangent / np.linalg.norm(tangent), 0)


def is_joined(curve: SolutionCurve) -> bool:
    """Whether one mode alone moves, so that an impact without speed changes nothing, and branches meet there."""
    known = next(iter(curve._systems.values()), None)
    return curve.modes + (known is None or known.body.is_free) == 1


def grazing_partner(curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int) -> Partner | None:
    """The branch with an impact more that begins at a touch, or with one less at a death; None for none."""
    if not is_joined(curve):
        return None
    made = _changed(curve, point, kind, which)
    if made is None:
        return None
    other, x, _ = made
    try:
        tangent = np.linalg.svd(other.matrix(x))[2][-1]
        for way in (tangent, -tangent):
            tried = other.motion(other.corrected(x + _TRIED * way, way).x)
            if np.all(tried.speeds > 0.0) and tried.admissible:
                return other, CurvePoint(x, way, 0)
    except (PercussError, CorrectorFailed, np.linalg.LinAlgError):
        pass
    return None


def _changed(
    curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int
) -> tuple[SolutionCurve, Array, int] | None:
    """The curve with an impact more or less, the point on it, and the number of the new impact or -1."""
    p, orbit = curve.impacts, curve.motion(point.x)
    if kind is BranchEvent.TOUCH:
        if p + 1 > MOST_IMPACTS:
            return None
        time = point.x[0] + orbit.sampled.time
        number = int(np.searchsorted(point.x[:p], time))
        return curve.other(p + 1, curve.periods), np.insert(point.x, number, time), number
    if p == 1:
        return None
    x = np.delete(point.x, which)
    if which == 0:
        x[p - 1] = orbit.rigid_rebounds[1]
    return curve.other(p - 1, curve.periods), x, -1


def other_end(
    curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int
) -> tuple[SolutionCurve, Array] | None:
    """Where the branch with an impact more or less ends, of an elastic bar: near, but not here; None if not found."""
    made = _changed(curve, point, kind, which)
    if made is None:
        return None
    other, x, number = made

    def vanishing(place: CurvePoint) -> float:
        orbit = other.motion(place.x)
        return float(orbit.speeds[number]) if number >= 0 else orbit.sampled.height

    try:
        found = where_it_vanishes(other, x, vanishing)
        orbit = other.motion(found)
        alive = np.delete(orbit.speeds, number) if number >= 0 else orbit.speeds
        return (other, found) if np.all(alive > 0.0) else None
    except (PercussError, CorrectorFailed, np.linalg.LinAlgError):
        return None


def in_words(refusal: PercussError | None) -> str:
    """What a refusal expects, without the value beyond the end that was tried; empty for none."""
    if isinstance(refusal, ParameterError):
        return f"{refusal.name}: expected {refusal.accepted}"
    return str(refusal or "")


# ---- The normal form of a flip: towards which side the orbit of twice the period begins, and whether it is stable
# there
#
# With G the equations of the cycle told as one of twice the period, G_x q = 0 and w G_x = 0, a the size of what is
# added along q and s the arclength of the parent, the doubled orbit is at s = −c a²/e + …,
#
#     c = w·(G_xxx q³/6 + G_xx q h),   G_x h = −G_xx q²/2,   e = d(w G_x q)/ds
#
# (Kuznetsov, Elements of Applied Bifurcation Theory, 2004, § 5.4). At a fold of the parent G_x has a second null
# vector, h grows without bound, and c has a pole there, as it has where an impact without speed makes K(ξ) singular for
# every ξ. Times the determinant of G_x bordered by q and w it is finite, and vanishes where c does alone.

_FLIP_FORM_ASIDE, _SHARE = 4e-3, 0.05  # rad, along the doubled branch, and of its shortest flight
_ALONG, _BESIDE = 1e-5, 1e-6  # of arclength, and of ξ, for derivatives
_RESOLVED, _REGULAR = 1e-6, 1e-10  # of the terms of a number, and of the greatest singular value, less is none


class Side(NamedTuple):
    """Whether a branch begins towards greater values, and whether it is stable there; None: it is not resolved.

    `supercritical`, of a flip: whether the doubled orbit begins where the one before it is no longer stable.
    """

    greater: bool
    stable: bool | None
    supercritical: bool | None = None

    @property
    def towards(self) -> str:
        """The word for the side."""
        return "greater" if self.greater else "smaller"

    @property
    def criticality(self) -> str | None:
        """The word for `supercritical`."""
        return None if self.supercritical is None else "supercritical" if self.supercritical else "subcritical"


def side_told(name: str, side: Side | None) -> str:
    """Towards which values of a parameter a branch begins and whether it is stable there, or what is not resolved."""
    if side is None:
        return ", to which side and whether it is stable is not resolved"
    towards = f" towards {side.towards} {name}"
    if side.stable is None:
        return f"{towards}, whether it is stable is not resolved"
    return f"{towards}, {'stable' if side.stable else 'unstable'}"


class FlipForm(NamedTuple):
    """Both terms of c times the determinant, that taken by its other factors, and the null vectors of K(−1)."""

    terms: tuple[float, float]
    determinant: float
    left: Array
    right: Array

    @property
    def bend(self) -> float:
        """c times the determinant: 0 where the doubled orbit begins towards neither side, whatever G_x is."""
        return sum(self.terms)

    @staticmethod
    def of(orbit: PeriodicOrbit) -> FlipForm:
        """Of an orbit at its flip."""
        p = orbit.impacts
        aside = min(_FLIP_FORM_ASIDE, _SHARE * float(orbit.flight_times.min()))
        here = twice(np.array([*orbit.times, orbit.rigid_rebounds[0]]), p, orbit.periods)

        def matrix(x: Array) -> Array:
            wide = PeriodicOrbit(orbit.system, 2 * orbit.periods, tuple(x[:-1].tolist()), orbit.modes, float(x[-1]))
            found = np.array(wide.bordered().real)
            found[:, 0] -= turning(wide) * found[:, -1]
            return found

        columns, _, rows = np.linalg.svd(orbit.bordered(-1.0).real)
        left, right = columns[:, -1], rows[-1]
        row = np.concatenate([left[:p], -left])  # the halves of the cycle are each the other's negative
        way = np.concatenate([right[:p], -right[:p], [right[p] + turning(orbit) * right[0]]])
        row, way, middle = row / np.linalg.norm(row), way / np.linalg.norm(way), matrix(here)
        bordered = np.block([[middle, row[:, None]], [way[None, :], np.zeros((1, 1))]])
        u, sizes, v = np.linalg.svd(bordered)
        small = float(np.linalg.slogdet(u)[0] * np.linalg.slogdet(v)[0] * sizes[-1])

        def terms(size: float) -> Array:
            ahead, behind = matrix(here + size * way), matrix(here - size * way)
            second = np.append((ahead - behind) @ way, 0.0) / (2.0 * size)
            inner = -0.5 * (v.T @ (small / sizes * (u.T @ second)))[:-1]
            third = row @ (ahead + behind - 2.0 * middle) @ way / size**2
            return np.array([small * third / 6.0, row @ (ahead - behind) @ inner / (2.0 * size)])

        coarse, middling, fine = (terms(share * aside) for share in (1.0, 0.5, 0.25))  # (Romberg)
        first, second = (64.0 * fine - 20.0 * middling + coarse) / 45.0
        return FlipForm((float(first), float(second)), small / float(sizes[0]), left, right)


def side_of_doubled(curve: SolutionCurve, point: CurvePoint) -> Side | None:
    """Where the doubled orbit of a flip begins, by the normal form; None where that is degenerate."""
    orbit = curve.motion(point.x)
    form = FlipForm.of(orbit)

    def slope(ahead: Array, behind: Array) -> tuple[float, bool]:
        """Of w K q, between two matrices, and whether that is more than rounding."""
        change = form.left @ (ahead - behind) @ form.right
        return float(change), bool(abs(change) > _RESOLVED * float(np.abs(ahead - behind).max()))

    step = _ALONG * point.tangent
    along, moves = slope(*(curve.motion(x).bordered(-1.0).real for x in (point.x + step, point.x - step)))
    turn, simple = slope(*(orbit.bordered(xi).real for xi in (-1.0 + _BESIDE, -1.0 - _BESIDE)))
    resolved = abs(form.bend) > _RESOLVED * sum(map(abs, form.terms)) and abs(form.determinant) > _REGULAR
    if not (resolved and moves and simple and point.tangent[-1]):
        return None
    c = form.bend * form.determinant
    return Side(-c * along * float(point.tangent[-1]) > 0.0, _stable(orbit, c * turn < 0.0), c * turn < 0.0)


def _stable(orbit: PeriodicOrbit, beyond: bool) -> bool | None:
    """Whether the doubled orbit is stable, that begins where the parent's −1 is beyond the unit circle or not."""
    values = multipliers(orbit)
    if values is None:
        return None
    others = np.abs(np.delete(values, int(np.argmin(np.abs(values + 1.0)))))
    if np.any(others > 1.0 + BEYOND) or not beyond:
        return False
    return None if np.any(others > 1.0 - BEYOND) else True
