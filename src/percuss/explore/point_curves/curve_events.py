"""What happens between two points of a curve over two parameters."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import FlipForm, press
from percuss.explore.continuation.load_steps import Passed, step_of, steps_passed
from percuss.explore.continuation.solution_curve import twice
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, CurveSegment, LocatedEvent, Number
from percuss.explore.point_curves.conditions import (
    Condition,
    Corner,
    Death,
    Multiplier,
    Pair,
    Touch,
    curvature,
)
from percuss.explore.point_curves.extended_curve import ExtendedCurve
from percuss.model.checks import Array
from percuss.model.load import Side
from percuss.steady import PeriodicOrbit
from percuss.steady.flight import Flight

# ---- What happens between two points of a curve in two parameters, and what of it is one thing

_ALIKE = 1e-6  # of a step, within which two things happen at one place
_FOLLOW = {BranchEvent.WITH_FOLD, BranchEvent.WITH_FLIP, BranchEvent.RESONANCE_1, BranchEvent.RESONANCE_2}


def without_what_follows(found: list[LocatedEvent], condition: Condition, alike: float) -> list[LocatedEvent]:
    """What happens, a resonant grazing as one thing, and corners without what jumps there; places may be `alike`.

    At a resonant grazing K(ξ) is singular for every ξ, and so for 1 and −1, which says no more. On a curve of folds or
    flips it is seen as an impact without speed.
    """
    grazing = isinstance(condition, Death | Touch)
    sign = BranchEvent.RESONANT_GRAZING if grazing else BranchEvent.WITH_DEATH
    for one in [one for one in found if one.kind is sign]:
        here = [other for other in found if other.kind in _FOLLOW and _is_near(other.place, [one.place], alike)]
        if here:
            found = [other for other in found if not any(other is gone for gone in (one, *here))]
            found.append(one._replace(kind=BranchEvent.RESONANT_GRAZING))
    corners = [one.place for one in found if one.kind is BranchEvent.WITH_CORNER]  # where K(ξ) jumps
    return [one for one in found if one.kind not in _FOLLOW or not _is_near(one.place, corners, alike)]


def _is_near(place: float, others: list[float], alike: float) -> bool:
    return any(abs(place - other) < alike for other in others)


# ---- Whether a motion that fulfils a condition is an orbit otherwise: its impacts strike, and it stays off the wall

_PER_WAVE, _FEWEST = 8, 96  # samples in a period of the fastest mode, and of a flight
_SAME = 1e-4  # rad: a maximum as near to the grazing is the grazing
_ROUNDING = 1e-11  # of 1, below which it is 0: the same grazing in another load period of the cycle


class Clearance(NamedTuple):
    """How far a motion is from losing each property of an orbit: negative where it has lost it.

    The least speed of an impact, the least distance to the wall of a maximum, for R = 0 the greatest acceleration from
    the wall after an impact; those at which the condition itself is 0 are left out. 0 but for rounding is 0: so it
    stays where the grazing comes twice in a cycle, and nothing happens there.
    """

    speed: float
    distance: float
    leaving: float

    @property
    def is_orbit(self) -> bool:
        """Whether nothing is lost."""
        return min(self) >= 0.0

    @staticmethod
    def lost(number: int) -> BranchEvent:
        """What it is to lose one of them."""
        return (BranchEvent.WITH_DEATH, BranchEvent.WITH_TOUCH, BranchEvent.WITH_STICKING)[number]


def clearance(orbit: PeriodicOrbit, condition: Condition, extra: Array) -> Clearance:
    """How far a motion is from being none, but for its condition."""
    dying = condition.which if isinstance(condition, Death) else -1
    speeds = [float(speed) for i, speed in enumerate(orbit.speeds) if i != dying]
    least = 1.0
    for i, flight in enumerate(orbit.flights):
        times, heights = maxima(flight, orbit.modes)
        own = np.zeros(times.size, dtype=bool)
        if isinstance(condition, Touch) and i == condition.flight:
            own = np.abs(times - extra[0]) < _SAME
        if i == dying:
            own = times < _SAME
        if (i + 1) % orbit.impacts == dying:
            own = own | (times > flight.period - _SAME)
        least = min(least, float(-heights[~own].max(initial=-1.0)))
    leaving = 1.0 if orbit.system.contact.rebounds else -press(orbit)[0]
    found = min(speeds, default=math.inf), least, leaving
    return Clearance(*(0.0 if abs(margin) < _ROUNDING else margin for margin in found))


def maxima(flight: Flight, modes: int) -> tuple[Array, Array]:
    """The local maxima of the gap function inside a flight: times after its start, and heights."""
    load, known = flight.system.load, flight.system.body.modes(modes, flight.system.load.at)
    fastest = max(float(known.omega[-1]) if modes else 1.0, 1.0 if load.is_piecewise else float(load.harmonics[-1]))
    number = max(_FEWEST, int(_PER_WAVE * fastest * flight.period / (2.0 * math.pi)))
    t = np.linspace(0.0, flight.period, number + 1)
    speed = flight.end_motion(t, modes)[1]
    here = np.flatnonzero((speed[:-1] > 0.0) & (speed[1:] <= 0.0))
    if not here.size:
        return np.empty(0), np.empty(0)
    tops = bracketed_roots(
        lambda times: flight.end_motion(times, modes)[1], t[here], t[here + 1], speed[here], speed[here + 1]
    )
    return tops, flight.end_motion(tops, modes)[0]


# ---- Numbers that vanish at points of codimension two: smooth along a curve of folds, flips, grazings, corners, pairs

Tests: TypeAlias = list[tuple[BranchEvent, Number]]
"""Kinds of points, and of each the number that vanishes there."""

_APART = 1e-4  # of ξ from 1 or −1, for the derivative of g
_FAR = 1e4  # ξ at which the multipliers that are finite count no more


def tests_of(curve: ExtendedCurve, first: CurvePoint) -> Tests:
    """What is looked at between a point of a curve and the next one."""
    condition = curve.condition

    def of_orbit(number: Callable[[PeriodicOrbit, Array], float]) -> Number:
        return lambda point: number(curve.motion(point.x), curve.extra(point.x))

    fold = BranchEvent.WITH_FOLD, of_orbit(lambda orbit, _: orbit.singular()[0])
    flip = BranchEvent.WITH_FLIP, of_orbit(lambda orbit, _: orbit.singular()[1])
    if isinstance(condition, Multiplier) and condition.xi > 0.0:
        p = curve.impacts
        before = first.tangent[p + 1 : p + 3]
        cusp = BranchEvent.CUSP, lambda point: float(point.tangent[p + 1 : p + 3] @ before)
        return [flip, cusp, (BranchEvent.RESONANCE_1, of_orbit(lambda orbit, _: double(orbit, condition)))]
    if isinstance(condition, Multiplier):
        bent = BranchEvent.GENERALIZED_FLIP, of_orbit(lambda orbit, _: FlipForm.of(orbit).bend)
        return [fold, bent, (BranchEvent.RESONANCE_2, of_orbit(lambda orbit, _: double(orbit, condition)))]
    if isinstance(condition, Pair):
        turns = (
            (BranchEvent.RESONANCE_1, 0), (BranchEvent.RESONANCE_4, 90),
            (BranchEvent.RESONANCE_3, 120), (BranchEvent.RESONANCE_2, 180),
        )  # fmt: skip
        others = (
            (BranchEvent.WITH_FOLD, of_orbit(lambda orbit, extra: orbit.singular()[0] * (1.0 - extra[0]))),
            (BranchEvent.WITH_FLIP, of_orbit(lambda orbit, extra: orbit.singular()[1] * (1.0 + extra[0]))),
        )  # without the pair itself, where that comes to 1 or −1
        return [*others, *((kind, of_orbit(_turn(degrees))) for kind, degrees in turns)]
    if isinstance(condition, Corner):
        sides: tuple[Side, Side] = ("left", "right")
        return [
            (kind, of_orbit(lambda orbit, _, which=which, side=side: orbit.singular(side)[which]))  # type: ignore[misc]
            for which, kind in enumerate((BranchEvent.WITH_FOLD, BranchEvent.WITH_FLIP))
            for side in sides
        ]
    flat = BranchEvent.FLAT_GRAZING, of_orbit(lambda orbit, extra: curvature(orbit, condition, extra))
    return [fold, flip, flat, *_resonant(condition, of_orbit)]


def _turn(degrees: int) -> Callable[[PeriodicOrbit, Array], float]:
    cosine = round(math.cos(math.radians(degrees)), 12)
    return lambda _, extra: float(extra[0]) - cosine


def _resonant(condition: Condition, of_orbit: Callable[..., Number]) -> Tests:
    def number(orbit: PeriodicOrbit, extra: Array) -> float:
        if isinstance(condition, Death):
            return growing(orbit)
        assert isinstance(condition, Touch)
        number = condition.flight + 1
        times = np.insert(np.array(orbit.times), number, orbit.times[condition.flight] + extra[0])
        wide = PeriodicOrbit(orbit.system, orbit.periods, tuple(times.tolist()), orbit.modes, orbit.rigid_rebounds[0])
        alone = orbit.modes + orbit.system.body.is_free == 1
        return growing(wide) if alone else 1.0  # where several modes move no impact begins at a touch

    return [(BranchEvent.RESONANT_GRAZING, of_orbit(number))]


def double(orbit: PeriodicOrbit, condition: Multiplier) -> float:
    """dg/dξ at the multiplier: 0 where it is a double one."""
    ahead, behind = (condition.at(orbit, condition.xi * (1.0 + h)).real for h in (_APART, -_APART))
    return (ahead - behind) / (2.0 * _APART)


def growing(orbit: PeriodicOrbit) -> float:
    """What the greatest multiplier times the speed of an impact tends to as that goes to 0.

    det(ξ − W) times the speeds is a polynomial of degree 2N + 2 in ξ; where an impact has no speed its first
    coefficient vanishes, and the second is this number, up to a factor that does not change its sign.
    """

    def scaled(xi: float) -> float:
        rest = float(np.prod(orbit.modal_determinants(xi).real / xi**2))
        return float(np.linalg.det(orbit.bordered(xi).real)) / xi * rest

    return 0.5 * (scaled(_FAR) + scaled(-_FAR))


# ---- What happens between two points of a curve over two parameters


def clearance_at(curve: ExtendedCurve, point: CurvePoint) -> Clearance:
    """How far the orbit at a point of the curve is from being none."""
    return clearance(curve.motion(point.x), curve.condition, curve.extra(point.x))


def passed_at(curve: ExtendedCurve, point: CurvePoint) -> Passed:
    """How many steps of the load each impact has passed; of that on a step all along, the number of the step."""
    found = steps_passed(curve.motion(point.x))
    if isinstance(curve.condition, Corner):
        found[curve.condition.which] = curve.condition.number
    return found


def events_between(segment: CurveSegment, clear: Clearance, passed: Passed) -> list[LocatedEvent]:
    """What happens on a step, in order; of its start the clearance, and how many steps of the load are passed."""
    curve, here, point = segment.curve, segment.start, segment.stop

    def located(kind: BranchEvent, number: Number) -> LocatedEvent:
        return segment.event(kind, segment.root(number))

    found = [located(kind, number) for kind, number in tests_of(curve, here) if number(here) * number(point) < 0.0]
    now = clearance_at(curve, point)
    for i in range(len(now)):
        if clear[i] * now[i] < 0.0:

            def margin(at: CurvePoint, i: int = i) -> float:
                return clearance_at(curve, at)[i]

            found.append(located(Clearance.lost(i), margin))
    after = passed_at(curve, point)
    for i in np.flatnonzero(after != passed).tolist():
        number = int(passed[i]) - (after[i] < passed[i])

        def off(at: CurvePoint, i: int = i, number: int = number) -> float:
            orbit = curve.motion(at.x)
            return float(orbit.times[i]) - step_of(orbit.system, number)

        found.append(located(BranchEvent.WITH_CORNER, off))
    found = without_what_follows(found, curve.condition, _ALIKE * segment.length)
    return sorted(found, key=lambda one: one.place)


# ---- Where a curve of orbits of twice the period comes to an end: the two halves of their cycle become one orbit
#
# An orbit that is told half its period later is the same orbit, and is as much a fold, a flip or one with a pair on the
# unit circle as before. Beyond the place at which its halves are one the curve would go back over itself. For folds
# that is the point of the flips of the orbit of half the period at which the doubled one begins towards the other side.

_HALVED_ASIDE = 1e-3  # of arclength, for the first step of the secant method
_STEPS, _CLOSE = 20, 1e-11
_REACH = 0.3  # rad, of the place from where it is looked for


def goes_back(curve: ExtendedCurve) -> bool:
    """Whether a curve would go back over itself once both halves of the cycle are one orbit."""
    return isinstance(curve.condition, Multiplier | Pair) and curve.impacts % 2 == curve.periods % 2 == 0


def halves_differ(curve: ExtendedCurve, x: Array) -> Array:
    """By how much the times of the second half of the cycle are later than those of the first; shape (p/2,)."""
    half = curve.impacts // 2
    return x[half : 2 * half] - x[:half] - math.pi * curve.periods


def halved(curve: ExtendedCurve, near: Array) -> CurvePoint:
    """The point at which both halves are one orbit, from unknowns near it; or CorrectorFailed."""
    p, half = curve.impacts, curve.impacts // 2
    start = np.concatenate([near[:half] + 0.5 * halves_differ(curve, near), near[p : p + 3]])
    narrow = ExtendedCurve(
        curve.family, curve.names, curve.units, half, curve.periods // 2, curve.modes, curve.condition
    )
    flip = Multiplier.of(narrow.motion(start), -1.0)
    narrow = replace(narrow, condition=flip, _motions={})
    found = narrow.settled(start)
    if isinstance(curve.condition, Multiplier) and curve.condition.xi > 0.0:
        found = _bent_to_neither_side(narrow, found)
    if float(np.abs(found.x - start).max()) > _REACH:
        raise CorrectorFailed("another flip")
    x = np.concatenate([twice(found.x[: half + 1], half, narrow.periods), found.x[half + 1 :], curve.extra(near)])
    return CurvePoint(x, np.zeros(x.size), 0)


def _bent_to_neither_side(narrow: ExtendedCurve, start: CurvePoint) -> CurvePoint:
    """The point of a curve of flips at which the doubled orbit begins towards neither side, by the secant method."""

    def bend(point: CurvePoint) -> float:
        return FlipForm.of(narrow.motion(point.x)).bend

    found, last, before, along = start, bend(start), 0.0, _HALVED_ASIDE
    for _ in range(_STEPS):
        found = narrow.corrected(start.x + along * start.tangent, start.tangent, start.tangent, start)
        here = bend(found)
        if here == last or abs(along) > _REACH:
            break
        step = -here * (along - before) / (here - last)
        if abs(step) < _CLOSE:
            return found
        last, before, along = here, along, along + step
    raise CorrectorFailed("no such flip")
