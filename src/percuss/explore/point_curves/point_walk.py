"""What makes an orbit a grazing, a corner …: one equation more than its unknowns; the walk along all such orbits."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import FlipForm, press
from percuss.explore.continuation.missed_events import halves
from percuss.explore.continuation.orbit_curve import (
    OrbitProblem,
    Passed,
    beyond_corner,
    landed,
    lateness,
    step_ahead,
    step_of,
    step_row,
    steps_passed,
    twice,
)
from percuss.explore.continuation.walk import (
    FIRST,
    SHORTEST,
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Look,
    Number,
    Target,
    Walk,
    refused,
)
from percuss.explore.family import Family
from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.model.load import Side
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.periodic_orbit import SampledFlights

_LATE = 1e-4  # rad, by which the acceleration of the end is asked for


class Condition(ABC):
    """What is asked of an orbit, besides that it is one; by default of its times as they are, the same all along."""

    @property
    @abstractmethod
    def kind(self) -> BranchEvent:
        """What the orbit is where it holds."""

    @abstractmethod
    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """By how much it does not hold; as many numbers as it brings unknowns, and one."""

    def placed(self, system: System, times: Array) -> Array:
        """The times of the impacts as they stand in the equations."""
        return times

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Condition:
        """The same with what belongs to a place on the curve taken anew there."""
        return self


@dataclass(frozen=True)
class Death(Condition):
    """An impact without speed: number `which`."""

    which: int
    kind = BranchEvent.DEATH

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([orbit.speeds[self.which]])


@dataclass(frozen=True)
class Touch(Condition):
    """The bar touches the wall in flight `flight`, at a time after its start that is an unknown."""

    flight: int
    kind = BranchEvent.TOUCH

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return orbit.end_at(self.flight, float(extra[0]))[:2]


@dataclass(frozen=True)
class Corner(Condition):
    """Impact `which` falls on step `number` of the load, counted from time 0 on.

    The impact is put on the step before anything else is computed, so that the step may move with the parameters: as a
    function of the times alone the equations have a corner there.
    """

    which: int
    number: int
    kind = BranchEvent.CORNER

    @staticmethod
    def of(orbit: PeriodicOrbit, which: int) -> Corner:
        """The step that an impact of an orbit is at."""
        if not orbit.system.load.breaks:
            raise ParameterError("point", str(orbit), "an orbit whose load has steps")
        last = int(steps_passed(orbit)[which])
        numbers = (last - 1, last)
        return Corner(which, min(numbers, key=lambda n: abs(step_of(orbit.system, n) - orbit.times[which])))

    def placed(self, system: System, times: Array) -> Array:
        found = np.array(times)
        found[self.which] = step_of(system, self.number)
        return found

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([times[self.which] - orbit.times[self.which]])


def curvature(orbit: PeriodicOrbit, condition: Condition, extra: Array) -> float:
    """The acceleration of the striking end where it grazes, just after: negative where it really does."""
    if isinstance(condition, Touch):
        flight, time = orbit.flights[condition.flight], float(extra[0])
        velocity = flight.end_motion(np.array([time - _LATE, time + _LATE]), orbit.modes)[1]
        return float(velocity[1] - velocity[0]) / (2.0 * _LATE)
    assert isinstance(condition, Death)
    flight = orbit.flights[condition.which]
    velocity = flight.end_motion(np.array([0.0, _LATE]), orbit.modes)[1]
    return float(velocity[1] - velocity[0]) / _LATE


# ---- What makes an orbit a fold, a flip or a Neimark–Sacker point: a multiplier, or a pair, on the unit circle
#
# A multiplier ξ makes K(ξ) singular. Bordered by a column b and a row cᵀ, [K b; cᵀ 0](v, g) = (0, 1), it is not, and
# g vanishes where det K(ξ) does, of whatever size the determinant is (Griewank & Reddien, IMA J. Numer. Anal. 4 (1984)
# 295–303; Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, ch. 3).

_NARROW, _ROUND = 5e-7, 2e-6  # of cos θ from ±1, nearer than which what is asked is its mean on a circle around
_VANISHED = 1e-6  # of the longest row: a row that is 0 has no length of its own


@dataclass(frozen=True)
class Multiplier(Condition):
    """A multiplier ξ = 1, a fold, or −1, a flip."""

    # `border`: singular vectors of K(ξ) with its rows taken by their lengths, and these.

    xi: float
    border: tuple[Array, Array, Array]

    @staticmethod
    def of(orbit: PeriodicOrbit, xi: float) -> Multiplier:
        """With the borders of an orbit."""
        return Multiplier(xi, _border(orbit.bordered(xi)))

    @property
    def kind(self) -> BranchEvent:
        return BranchEvent.FOLD if self.xi > 0.0 else BranchEvent.FLIP

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([self.at(orbit, self.xi).real])

    def at(self, orbit: PeriodicOrbit, xi: complex) -> complex:
        """g of another number in place of ξ, with the same borders."""
        return _bordered(orbit.bordered(xi), self.border)

    def null(self, orbit: PeriodicOrbit) -> Array:
        """v, by which the unknowns of the orbit change along the other branch; shape (p + 1,)."""
        return np.asarray(np.linalg.svd(orbit.bordered(self.xi).real)[2][-1])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Multiplier:
        return Multiplier.of(orbit, self.xi)


@dataclass(frozen=True)
class Pair(Condition):
    """A pair of multipliers on the unit circle; cos θ is an unknown.

    g(ξ) + g(1/ξ) and (g(ξ) − g(1/ξ))/(ξ − 1/ξ) are real and smooth where the two meet at 1 or at −1, too.
    """

    border: tuple[Array, Array, Array]
    kind = BranchEvent.NEIMARK_SACKER

    @staticmethod
    def of(orbit: PeriodicOrbit, cosine: float) -> Pair:
        """With the borders of an orbit."""
        return Pair(_border(orbit.bordered(_on_circle(cosine))))

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """Mean and difference quotient of g at ξ and 1/ξ; both are analytic in cos θ, also where ξ = 1/ξ."""
        cosine = float(extra[0])
        if abs(abs(cosine) - 1.0) > _NARROW:
            return self._halves(orbit, cosine).real
        ahead, behind, aside = (self._halves(orbit, cosine + _ROUND * way) for way in (1.0, -1.0, 1j))
        return 0.25 * (ahead + behind + 2.0 * aside).real  # with the conjugate of the last: exact to the third order

    def _halves(self, orbit: PeriodicOrbit, cosine: complex) -> ComplexArray:
        xi = _on_circle(cosine)
        first = _bordered(orbit.bordered(_plain(xi)), self.border)
        if isinstance(cosine, float) and abs(cosine) < 1.0:
            return np.array([first.real, first.imag / xi.imag], dtype=complex)
        second = _bordered(orbit.bordered(_plain(1.0 / xi)), self.border)
        return np.array([0.5 * (first + second), (first - second) / (xi - 1.0 / xi)])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Pair:
        return Pair.of(orbit, float(extra[0]))


def _border(matrix: Array | ComplexArray) -> tuple[Array, Array, Array]:
    """Real borders and the lengths of the rows; the longest for one that vanishes, as of a held body."""
    lengths = np.linalg.norm(matrix, axis=1)
    lengths = np.where(lengths > _VANISHED * lengths.max(), lengths, lengths.max())
    left, _, right = np.linalg.svd(matrix / lengths[:, None])
    return _real(left[:, -1]), _real(right[-1].conj()), lengths


def _real(vector: ComplexArray) -> Array:
    """The longest real part of a complex vector times a number of modulus 1, of length 1."""
    square = complex(np.sum(vector**2))
    turned = vector * np.exp(-0.5j * np.angle(square)) if square else vector
    return np.asarray(turned.real / np.linalg.norm(turned.real))


def _bordered(matrix: Array | ComplexArray, border: tuple[Array, Array, Array]) -> complex:
    column, row, lengths = border
    size = row.size
    whole = np.zeros((size + 1, size + 1), dtype=matrix.dtype)
    whole[:size, :size], whole[:size, size], whole[size, :size] = matrix / lengths[:, None], column, row
    try:
        return complex(np.linalg.solve(whole, np.append(np.zeros(size), 1.0))[-1])
    except np.linalg.LinAlgError:
        return complex(np.nan)


def _plain(number: complex) -> complex:
    """A number as a real one, where it is."""
    return number if number.imag else number.real


def _on_circle(cosine: complex) -> complex:
    """ξ with (ξ + 1/ξ)/2 equal to a cosine; real for one beyond 1."""
    return complex(cosine + np.sqrt(complex(cosine * cosine - 1.0)))


# ---- The orbits over two parameters for which a condition holds: its unknowns come last, and its equations


@dataclass(frozen=True)
class ExtendedCurve(OrbitProblem):
    """All orbits z=p/n of a family over two parameters for which a condition holds."""

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]
    impacts: int
    periods: int
    modes: int
    condition: Condition

    def renewed(self, x: Array) -> ExtendedCurve:
        """The same curve with what belongs to a place on it taken anew."""
        condition = self.condition.renewed(self.motion(x), self.extra(x))
        return self if condition is self.condition else self.of(condition)

    def of(self, condition: Condition) -> ExtendedCurve:
        """The curve of another condition, of the same systems."""
        made = replace(self, condition=condition)
        made.__dict__["_systems"] = self._systems
        return made

    def extra(self, x: Array) -> Array:
        """The unknowns of the condition."""
        return x[self.impacts + 3 :]

    def placed(self, system: System, times: Array) -> Array:
        return self.condition.placed(system, times)

    def residual(self, x: Array) -> Array:
        orbit = self.motion(x)
        return np.append(orbit.residuals, self.condition.off(orbit, x[: self.impacts], self.extra(x)))


# ---- What happens between two points of a curve in two parameters, and what of it is one thing

_ALIKE = 1e-6  # of a step, within which two things happen at one place
_FOLLOW = {BranchEvent.WITH_FOLD, BranchEvent.WITH_FLIP, BranchEvent.RESONANCE_1, BranchEvent.RESONANCE_2}


def without_what_follows(found: list[LocatedEvent], condition: Condition, alike: float) -> list[LocatedEvent]:
    """What happens, a resonant grazing as one thing, and corners without what jumps there; places may be `alike`."""
    # At a resonant grazing K(ξ) is singular for every ξ, and so for 1 and −1, which says no more. On a curve of folds
    # or flips it is seen as an impact without speed.
    grazing = isinstance(condition, Death | Touch)
    sign = BranchEvent.RESONANT_GRAZING if grazing else BranchEvent.WITH_DEATH
    for one in [one for one in found if one.kind is sign]:
        here = [other for other in found if other.kind in _FOLLOW and abs(other.place - one.place) < alike]
        if here:
            found = [other for other in found if not any(other is gone for gone in (one, *here))]
            found.append(one._replace(kind=BranchEvent.RESONANT_GRAZING))
    corners = [one.place for one in found if one.kind is BranchEvent.WITH_CORNER]  # where K(ξ) jumps
    return [
        one for one in found if one.kind not in _FOLLOW or all(abs(one.place - corner) >= alike for corner in corners)
    ]


# ---- Whether a motion that fulfils a condition is an orbit otherwise: its impacts strike, and it stays off the wall

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


_LOST = BranchEvent.WITH_DEATH, BranchEvent.WITH_TOUCH, BranchEvent.WITH_STICKING


def clearance_at(curve: ExtendedCurve, point: CurvePoint) -> Clearance:
    """How far the motion at a point of the curve is from being no orbit, but for its condition."""
    orbit = curve.motion(point.x)
    dying = curve.condition.which if isinstance(curve.condition, Death) else -1
    speeds = [float(speed) for i, speed in enumerate(orbit.speeds) if i != dying]
    leaving = 1.0 if orbit.system.contact.rebounds else -press(orbit)[0]
    found = min(speeds, default=math.inf), min(1.0, -highest(curve, point.x).height), leaving
    return Clearance(*(0.0 if abs(margin) < _ROUNDING else margin for margin in found))


def highest(curve: ExtendedCurve, x: Array) -> SampledFlights:
    """The greatest maximum of the gap function inside the flights of a motion, but for that of the condition itself."""
    orbit, condition = curve.motion(x), curve.condition
    if isinstance(condition, Touch):
        return orbit.sampled_but(flight=condition.flight, time=float(curve.extra(x)[0]))
    return orbit.sampled_but(impact=condition.which if isinstance(condition, Death) else None)


# ---- Numbers that vanish at points of codimension two: smooth along a curve of folds, flips, grazings, corners, pairs

Tests: TypeAlias = list[tuple[BranchEvent, Number]]  # kinds of points, and of each the number that vanishes there
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
        others = [
            (BranchEvent.WITH_FOLD, of_orbit(lambda orbit, extra: orbit.singular()[0] * (1.0 - extra[0]))),
            (BranchEvent.WITH_FLIP, of_orbit(lambda orbit, extra: orbit.singular()[1] * (1.0 + extra[0]))),
        ]  # without the pair itself, where that comes to 1 or −1
        resonances = (
            (BranchEvent.RESONANCE_1, 1.0), (BranchEvent.RESONANCE_4, 0.0),
            (BranchEvent.RESONANCE_3, -0.5), (BranchEvent.RESONANCE_2, -1.0),
        )  # fmt: skip
        return others + [
            (kind, of_orbit(lambda _, extra, cosine=cosine: float(extra[0]) - cosine))  # type: ignore[misc]
            for kind, cosine in resonances
        ]
    if isinstance(condition, Corner):
        sides: tuple[Side, Side] = ("left", "right")
        return [
            (kind, of_orbit(lambda orbit, _, which=which, side=side: orbit.singular(side)[which]))  # type: ignore[misc]
            for which, kind in enumerate((BranchEvent.WITH_FOLD, BranchEvent.WITH_FLIP))
            for side in sides
        ]

    def resonant(orbit: PeriodicOrbit, extra: Array) -> float:
        if isinstance(condition, Touch):
            if orbit.modes + orbit.system.body.is_free != 1:
                return 1.0  # where several modes move no impact begins at a touch
            i = condition.flight
            times = (*orbit.times[: i + 1], orbit.times[i] + float(extra[0]), *orbit.times[i + 1 :])
            orbit = PeriodicOrbit(orbit.system, orbit.periods, times, orbit.modes, orbit.rigid_rebounds[0])
        return growing(orbit)

    flat = BranchEvent.FLAT_GRAZING, of_orbit(lambda orbit, extra: curvature(orbit, condition, extra))
    return [fold, flip, flat, (BranchEvent.RESONANT_GRAZING, of_orbit(resonant))]


def double(orbit: PeriodicOrbit, condition: Multiplier) -> float:
    """dg/dξ at the multiplier: 0 where it is a double one."""
    ahead, behind = (condition.at(orbit, condition.xi * (1.0 + h)).real for h in (_APART, -_APART))
    return (ahead - behind) / (2.0 * _APART)


def growing(orbit: PeriodicOrbit) -> float:
    """What the greatest multiplier times the speed of an impact tends to as that goes to 0."""
    # det(ξ − W) times the speeds is a polynomial of degree 2N + 2 in ξ; where an impact has no speed its first
    # coefficient vanishes, and the second is this number, up to a factor that does not change its sign.

    def scaled(xi: float) -> float:
        rest = float(np.prod(orbit.modal_determinants(xi).real / xi**2))
        return float(np.linalg.det(orbit.bordered(xi).real)) / xi * rest

    return 0.5 * (scaled(_FAR) + scaled(-_FAR))


# ---- What happens between two points of a curve over two parameters


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

            found.append(located(_LOST[i], margin))
    after = passed_at(curve, point)
    for i in np.flatnonzero(after != passed).tolist():
        number = int(passed[i]) - (after[i] < passed[i])

        def off(at: CurvePoint, i: int = i, number: int = number) -> float:
            return lateness(curve, at.x, i, number)

        found.append(located(BranchEvent.WITH_CORNER, off))
    found = without_what_follows(found, curve.condition, _ALIKE * segment.length)
    return sorted(found, key=lambda one: one.place)


# ---- Where a curve of orbits of twice the period comes to an end: the two halves of their cycle become one orbit
#
# An orbit that is told half its period later is the same orbit, and is as much a fold, a flip or one with a pair on the
# unit circle as before. Beyond the place at which its halves are one the curve would go back over itself. For folds
# that is the point of the flips of the orbit of half the period at which the doubled one begins towards the other side.

_HALVED_ASIDE = 1e-3  # of arclength, for the first step of the secant method
_STEPS, _BENT_CLOSE = 20, 1e-11
_REACH = 0.3  # rad, of the place from where it is looked for


def goes_back(curve: ExtendedCurve) -> bool:
    """Whether a curve would go back over itself once both halves of the cycle are one orbit."""
    return isinstance(curve.condition, Multiplier | Pair) and curve.impacts % 2 == curve.periods % 2 == 0


def halved(curve: ExtendedCurve, near: Array) -> LocatedEvent:
    """The point at which both halves are one orbit, from unknowns near it; or CorrectorFailed."""
    half = curve.impacts // 2
    start = halves(curve, near)[0][: half + 3]
    narrow = replace(curve, impacts=half, periods=curve.periods // 2)
    narrow = narrow.of(Multiplier.of(narrow.motion(start), -1.0))
    found = narrow.settled(start)
    if isinstance(curve.condition, Multiplier) and curve.condition.xi > 0.0:
        found = _bent_to_neither_side(narrow, found)
    if float(np.abs(found.x - start).max()) > _REACH:
        raise CorrectorFailed("another flip")
    x = np.concatenate([twice(found.x[: half + 1], half, narrow.periods), found.x[half + 1 :], curve.extra(near)])
    return LocatedEvent(BranchEvent.HALVING, math.nan, CurvePoint(x, np.zeros(x.size), 0))


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
        if abs(step) < _BENT_CLOSE:
            return found
        last, before, along = here, along, along + step
    raise CorrectorFailed("no such flip")


# ---- The walk along a curve of points of orbits over two parameters

_COALESCED, _NEARLY = 1e-5, 1e-3  # of the cycle: a flight below which two impacts are one, and where the walk halts
_ARC = 0.05  # of a step, by which its end may be beside the arc with the tangents at both ends
_BEND, _NEAR_STEP = 0.01, 4.0  # a step below which a corner may be what bends a curve, if no more of it away
_BESIDE = 5e-6  # rad, beyond a step of the load, so that differences are taken on one side of it
_HALVED = 0.02  # rad, between the halves of a cycle that may become one
_DOUBLE = BranchEvent.RESONANCE_1, BranchEvent.RESONANCE_2
_BOTH = 1e-9  # height of a second touch, of 1, where two come together


class PointWalk(Walk):
    """A walk along points of orbits over two parameters; its marks are whether the motions are orbits otherwise."""

    quick = 8

    def __init__(self, curve: ExtendedCurve, start: CurvePoint, bounds: Sequence[tuple[float, float]]) -> None:
        super().__init__(curve.renewed(start.x), start, bounds)

    def arrive(self, point: CurvePoint) -> None:
        self.curve = self.curve.renewed(point.x)
        self.clear, self.passed = clearance_at(self.curve, point), passed_at(self.curve, point)
        super().arrive(point)

    def mark(self) -> int:
        return int(self.clear.is_orbit)

    def look(self, target: Target) -> Look:
        """The points of codimension two in a step, or where both halves of the cycle become one orbit."""
        segment = CurveSegment(self.curve, self.here, target.point)
        if goes_back(self.curve):
            before, after = (halves(self.curve, point.x)[1] for point in (self.here, target.point))
            if before @ after < 0.0:
                return Look(segment, [], None, halved(self.curve, target.point.x))
        found = events_between(segment, self.clear, self.passed)
        for i, one in enumerate(found):
            beyond = self._other_touch(one) if one.kind is BranchEvent.WITH_TOUCH and self.clear.is_orbit else None
            if beyond is not None:
                return Look(CurveSegment(self.curve, self.here, one.point), found[:i], None, one, beyond)
        return Look(segment, found, target.limit)

    def _other_touch(self, one: LocatedEvent) -> CurvePoint | None:
        """The other place at which the ringing of a flight touches, with the way on which this one is lost."""
        # Beyond, the other touch is what ends motions: this one would come back to it after a loop of none.
        condition, x = self.curve.condition, one.point.x
        if not (isinstance(condition, Touch) and self.curve.modes):
            return None
        top, orbit = highest(self.curve, x), self.curve.motion(x)
        if top.flight != condition.flight or not abs(top.height) <= _BOTH:
            return None
        other = np.append(x[:-1], top.time - (orbit.times[top.flight] - orbit.times[0]))
        try:
            matrix, own = self.curve.matrix(other), self.curve.matrix(x)[-2]  # how the height of this touch changes
            tangent = np.linalg.svd(matrix)[2][-1]
        except (PercussError, np.linalg.LinAlgError):
            return None
        rate = float(own[:-1] @ tangent[:-1])
        return CurvePoint(other, tangent if rate < 0.0 else -tangent, 0, matrix)

    def at_last(self, one: LocatedEvent, look: Look) -> None:
        if look.beyond is not None:
            self.keep(one.point, self.marks[-1])
            self.happened.append(one)
            self.arrive(look.beyond)
            self.size = min(self.size, FIRST)
        else:
            super().at_last(one, look)

    def ends_at(self, one: LocatedEvent) -> bool:
        condition = self.curve.condition
        if isinstance(condition, Pair) and one.kind in _DOUBLE:
            return True
        return isinstance(condition, Multiplier | Pair) and one.kind is BranchEvent.WITH_CORNER

    def end_here(self) -> BranchEvent | None:
        return BranchEvent.COALESCENCE if self._shortest() < _COALESCED else None

    def _shortest(self) -> float:
        """The shortest time between two impacts, or an impact and the touch, as a share of the cycle."""
        orbit, condition = self.curve.motion(self.here.x), self.curve.condition
        times = orbit.flight_times
        if isinstance(condition, Touch):
            time = float(self.curve.extra(self.here.x)[0])
            times = np.append(times, [time, times[condition.flight] - time])
        return float(times.min() / orbit.period)

    def check(self, found: CurvePoint, place: Array, last: bool = False) -> None:
        super().check(found, place)
        chord, mean = found.x - self.here.x, self.here.tangent + found.tangent  # along each other on an arc
        aside = float(np.linalg.norm(chord - (chord @ mean) / (mean @ mean) * mean))
        if aside > max(_ARC * float(np.linalg.norm(chord)), SHORTEST):
            raise CorrectorFailed("beside the arc")
        if isinstance(self.curve.condition, Touch):
            flight = self.curve.flights(found.x)[self.curve.condition.flight]
            if not 0.0 < float(self.curve.extra(found.x)[0]) < flight:
                raise CorrectorFailed("the touch passes an impact")

    def shorten(self) -> None:
        """Try a shorter step, or one past a corner."""
        if 0.5 * self.size < _BEND and self._past_corner(0.5 * self.size):
            return
        super().shorten()

    def stuck(self) -> None:
        if self._shortest() < _NEARLY:
            self.end(BranchEvent.COALESCENCE)
            return
        if goes_back(self.curve) and float(np.abs(halves(self.curve, self.here.x)[1]).max()) < _HALVED:
            try:
                self.at_last(halved(self.curve, self.here.x), Look(CurveSegment(self.curve, self.here, self.here), []))
            except CorrectorFailed:
                self.end(BranchEvent.LOST)
            return
        self.end(BranchEvent.LOST if self.refusal is None else refused(self.refusal))

    def _past_corner(self, size: float) -> bool:
        """Go past a step of the load that an impact is about to meet; whether there is one, and a way beyond."""
        own = self.curve.condition.which if isinstance(self.curve.condition, Corner) else -1
        near = step_ahead(self.curve, self.here, self.passed, own)
        if near is None or not 0.0 <= near[0] <= _NEAR_STEP * size:
            return False
        if isinstance(self.curve.condition, Multiplier | Pair):
            if size < SHORTEST:
                self.end(BranchEvent.WITH_CORNER)
            return self.ended
        place, which = near
        start = self.here.x + place * self.here.tangent
        try:
            on = landed(self.curve, self.here._replace(x=start), which, self.passed)
            if float(np.abs(on.x - start).max()) > place:
                raise CorrectorFailed("another corner")
            corner, _, passed = beyond_corner(self.curve, on, which, self.passed)
            row = step_row(self.curve, on.x, which, int(min(passed[which], self.passed[which])))
            ahead = corner.x + _BESIDE / abs(float(corner.tangent @ row)) * corner.tangent
            beyond = self.curve.corrected(ahead, corner.tangent, corner.tangent, corner)
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError):
            return False
        for point in (on, beyond):
            self.arrive(point)
        self.happened.append(LocatedEvent(BranchEvent.WITH_CORNER, math.nan, on))
        self.size = FIRST
        return True
