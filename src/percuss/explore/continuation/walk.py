"""What is walked along, equations over one parameter or two with one unknown more, and the walk, one way, to its end.

A problem has one equation less than unknowns, so that its solutions are a curve, which is walked by its arclength
(Keller, in: Rabinowitz, ed., Applications of Bifurcation Theory, 1977, 359–384). What happens in a step is told by what
is asked of its problem: see `OrbitWalk` for branches of orbits, `PointWalk` for their points over two parameters.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, Self, TypeAlias, TypeVar

import numpy as np

from percuss.errors import Interrupted, LoadError, ParameterError, PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.family import Axis, Family, SystemFamily, family_of
from percuss.explore.parameters import parameters_of
from percuss.halting import check_interrupted
from percuss.model import Machine, System
from percuss.model.checks import Array, finite, numbers, text
from percuss.steady.periodic.periodic_orbit import differences, load_turn, slope
from percuss.steady.states import check_pushes

# ---- What is varied: the systems, and of each parameter its value at first, its range, and what counts as a step

_UNITS = 4.0  # of the range of a parameter, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


class Varied(NamedTuple):
    """The systems, and of each parameter that is varied the name, its value where that begins, and the range."""

    family: Family
    names: tuple[str, ...]
    here: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]

    @property
    def units(self) -> tuple[float, ...]:
        """By how much each changes for a step of 1."""
        return tuple(unit_of(bounds, here) for bounds, here in zip(self.bounds, self.here, strict=True))

    @property
    def shown_units(self) -> tuple[str, ...]:
        """The units of SI that each is told in; empty for plain numbers."""
        known = getattr(self.family, "units", {})
        return tuple(known.get(name, "") for name in self.names)

    def __str__(self) -> str:
        return ", ".join(f"{name} = {value:.9g}" for name, value in zip(self.names, self.here, strict=True))


def varied(
    system: System | Machine,
    family: System | Family | None,
    names: Sequence[str],
    between: Sequence[object],
    values: Sequence[float | None],
) -> Varied:
    """What is varied, checked; None for a family, a range or a value stands for what the system itself tells.

    A name may bring its range, ``mean=0.3:1.2``.
    """
    names, ranges, units = zip(*map(_ranged, names, between), strict=True)
    found = Varied(SystemFamily(system) if family is None else family_of(family), names, (), ())
    told = {name: unit or own for name, unit, own in zip(names, units, found.shown_units, strict=True)}
    found.family.check(told)
    here = tuple(_value_at(system, name, value) for name, value in zip(names, values, strict=True))
    return found._replace(here=here, bounds=tuple(map(_range_around, ranges, here)))


def _ranged(along: str, between: object) -> tuple[str, object, str]:
    """A parameter, its range, and the unit that is told with it."""
    if "=" not in text("along", along, "the name of a parameter, or NAME=FROM:TO"):
        return along, between, ""
    if between is not None:
        raise ParameterError("between", between, f"None: '{along}' brings a range")
    axis = Axis.range_of(along)
    return axis.name, axis.values, axis.unit


def _range_around(between: object, here: float) -> tuple[float, float]:
    if between is None:
        return -math.inf, math.inf
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value that is followed")
    return float(ends[0]), float(ends[1])


def _value_at(system: System | Machine, name: str, given: float | None) -> float:
    if given is not None:
        return finite("value", given)
    known = parameters_of(system)
    found = known[name].get(system) if name in known else None
    if found is None:
        raise ParameterError("value", None, f"the value of {name} that belongs to what is followed")
    return found


def unit_of(bounds: tuple[float, float], here: float) -> float:
    """By how much a parameter changes for a step of 1, a power of 2, so that nothing is rounded by it."""
    scale, (low, high) = max(1.0, abs(here)), bounds
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))


# ---- Problems, and points of their curves


class CorrectorFailed(Exception):
    """Newton's method found no point of the curve, or not the one that was meant."""


class CurvePoint(NamedTuple):
    """A point of a curve: its unknowns, and the unit tangent there."""

    x: Array
    tangent: Array
    steps: int  # that Newton's method took
    matrix: Array | None = None  # the derivatives of the equations, where it was asked for them
    curve: Any = None  # on which it is, where a walk goes on from one curve to another
    motion: Any = None  # there, where a walk keeps it


class ParameterEnd(NamedTuple):
    """Where an unknown that is a parameter goes no further: its number, the last value, what is there, and why."""

    unknown: int
    value: float
    kind: BranchEvent
    refusal: PercussError | None = None


def refused(refusal: PercussError) -> BranchEvent:
    """What ends a curve where there is no system, or its load does not push."""
    return BranchEvent.NO_PUSH if isinstance(refusal, LoadError) else BranchEvent.NO_SYSTEM


def unit_tangent(matrix: Array, along: Array) -> Array:
    """The unit tangent that goes the same way as `along`; CorrectorFailed where it is at right angles to it."""
    try:
        found = np.linalg.solve(np.vstack([matrix, along]), np.append(np.zeros(along.size - 1), 1.0))
    except np.linalg.LinAlgError:
        raise CorrectorFailed("no tangent") from None
    return np.asarray(found / np.linalg.norm(found))


_MOST_STEPS, _MOST_RENEWALS = 16, 4
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad
_SLOW = 0.2  # share of the step before that a step may have before the derivatives are taken anew
_KEPT = 256  # systems


class Problem(ABC):
    """Equations, one less than unknowns (the impact times first), whose solutions are a curve."""

    # Of one that tells no more than its equations derivatives are taken by differences.

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]  # by how much each parameter changes for what counts as a step of 1 rad
    impacts: int  # how many of the unknowns are impact times
    periods: int
    oriented = True  # whether the equations stay the same along the curve: then their derivatives keep its sense
    difference = 1e-6  # by which the unknowns are moved for derivatives
    motion: Any  # at a point, where impacts are among the unknowns

    @property
    @abstractmethod
    def places(self) -> tuple[int, ...]:
        """Which of the unknowns are the parameters."""

    @abstractmethod
    def residual(self, x: Array) -> Array:
        """The equations, one less than unknowns."""

    # -- the systems --

    @cached_property
    def _systems(self) -> dict[tuple[float, ...], System]:
        return {}

    def system(self, *values: float) -> System:
        """The system at values of the parameters; PercussError where there is none."""
        if values not in self._systems:
            if len(self._systems) > _KEPT:
                self._systems.clear()
            self._systems[values] = self.family.system(dict(zip(self.names, values, strict=True)))
        return self._systems[values]

    def values(self, x: Array) -> tuple[float, ...]:
        """The parameters at a point."""
        return tuple(float(x[place] * unit) for place, unit in zip(self.places, self.units, strict=True))

    def system_at(self, x: Array) -> System:
        """The system at a point; PercussError where there is none, or its load does not push."""
        refusal = self.refusal(*self.values(x))
        if refusal is not None:
            raise refusal
        return self.system(*self.values(x))

    def refusal(self, *values: float) -> PercussError | None:
        """Why there can be no motion: there is no system, or its load does not push."""
        try:
            found = self.system(*values)
            if self.impacts:
                check_pushes(found)
        except PercussError as error:
            return error
        return None

    def limit(self, here: Array, x: Array, bounds: Sequence[tuple[float, float]]) -> ParameterEnd | None:
        """The first end of a range on the way to another place, or what `refused` there says."""
        found, share = None, 1.0
        for i, unit, (low, high) in zip(self.places, self.units, bounds, strict=True):
            value = float(x[i]) * unit
            if not low <= value <= high:
                end = (low if value < low else high) / unit
                part = (end - here[i]) / (x[i] - here[i])
                if found is None or part < share:
                    found, share = ParameterEnd(i, end, BranchEvent.LIMIT), part
        place = x if found is None else here + share * (x - here)
        if found is not None:
            place[found.unknown] = found.value
        refusal = self.refusal(*self.values(place))
        return found if refusal is None else self.refused(here, place, refusal)

    def refused(self, here: Array, place: Array, refusal: PercussError) -> ParameterEnd:
        """The last place on the way to one where there is no motion; here CorrectorFailed, and a shorter step."""
        raise CorrectorFailed(str(refusal)) from refusal

    # -- times --

    def flights(self, x: Array) -> Array:
        """The times of the flights, which change only little in a step."""
        p = self.impacts
        return np.append(x[1:p], x[0] + 2.0 * math.pi * self.periods) - x[:p] if p else np.empty(0)

    def apart(self, x: Array, first: Array) -> Array:
        """How far unknowns are from others, as those of motions whose first impact and load period may differ."""
        off, p = x - first, self.impacts
        if p:
            orbit = self.motion(first)
            off[:p] = differences(x[:p], first[None, :p], orbit.period, load_turn(orbit.system.load))[0, 0]
        return off

    # -- the way back to the curve --

    def matrix(self, x: Array) -> Array:
        """The derivatives of the equations by the unknowns."""
        return self.by_differences(x, range(x.size))

    def by_differences(
        self, x: Array, places: Sequence[int], equations: Callable[[Array], Array] | None = None
    ) -> Array:
        """Those by some of them, by central differences; on one side where a range or the `equations` end."""
        found = equations or self.residual

        def moved(place: int) -> Callable[[float], Array]:
            way = np.eye(x.size)[place]
            return lambda by: found(x + by * way)

        return np.stack([slope(moved(place), self.difference, CorrectorFailed) for place in places], axis=1)

    def linearised(self, x: Array) -> tuple[Array, Array]:
        """The derivatives of the equations, and the equations."""
        return self.matrix(x), self.residual(x)

    def settled(self, start: Array) -> CurvePoint:
        """The nearest point of the curve, with a tangent either way; or CorrectorFailed."""
        x = np.array(start)
        try:
            for step in range(1, _MOST_STEPS + 1):
                matrix, off = self.linearised(x)
                moved = -np.linalg.pinv(matrix) @ off
                if not float(np.abs(moved).max()) <= _LONGEST:
                    break
                x = x + moved
                if float(np.abs(moved).max()) <= _CLOSE:
                    if self.refusal(*self.values(x)) is not None:  # by rounding, where a parameter begins
                        x[list(self.places)] = start[list(self.places)]
                    return CurvePoint(x, np.linalg.svd(matrix)[2][-1], step, matrix, self)
        except (PercussError, np.linalg.LinAlgError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        """The point of the curve in a plane with a normal, its tangent the way of `along`; or CorrectorFailed."""
        check_interrupted()
        x, last, renewals, own, matrix = np.array(start), np.inf, 0, False, near.matrix
        try:
            matrix = self.matrix(x) if matrix is None else matrix
            for step in range(1, _MOST_STEPS + 1):
                moved = np.linalg.solve(np.vstack([matrix, normal]), -np.append(self.residual(x), normal @ (x - start)))
                size = float(np.abs(moved).max())
                if not size <= _LONGEST:
                    raise CorrectorFailed("a step too long")
                x = np.where(normal == 1.0, start, x + moved)  # what the plane holds is held without rounding
                if size <= _CLOSE and own:
                    self.system_at(x)
                    return CurvePoint(x, unit_tangent(matrix, along), step, matrix, self)
                own = False
                if size <= _CLOSE or size > _SLOW * last:
                    renewals += 1
                    if renewals > _MOST_RENEWALS:
                        break
                    matrix, own = self.matrix(x), True
                last = size
        except (PercussError, np.linalg.LinAlgError, FloatingPointError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")


# ---- The walk along a curve

FIRST, LONGEST, SHORTEST = 0.02, 0.1, 1e-9  # steps along a curve, of each impact in rad


Number: TypeAlias = Callable[[CurvePoint], float]


# ---- A step along a curve, and the places in it where a number vanishes


@dataclass(frozen=True)
class CurveSegment:
    """The curve between two of its points; places in it are counted along the tangent at the first one."""

    curve: Any
    start: CurvePoint
    stop: CurvePoint
    _points: dict[float, CurvePoint] = field(default_factory=dict, repr=False, compare=False)

    @property
    def length(self) -> float:
        """The place of the second point."""
        return float(self.start.tangent @ (self.stop.x - self.start.x))

    def at(self, place: float) -> CurvePoint:
        """The point at a place; CorrectorFailed where there is none."""
        if place == 0.0:
            return self.start
        if place == self.length:
            return self.stop
        if place not in self._points:
            ahead, length = self.start.tangent, self.length
            bend = self.stop.x - self.start.x - length * ahead
            start = self.start.x + place * ahead + (place / length) ** 2 * bend
            near = self.start if place < 0.5 * length else self.stop
            self._points[place] = self.curve.corrected(start, ahead, ahead, near)
        return self._points[place]

    def beside(self, place: float) -> Array:
        """About the unknowns at a place: on the cubic through both ends and their tangents."""
        start, stop, u = self.start, self.stop, place / self.length
        ends = np.stack([start.x, stop.x, start.tangent, stop.tangent / (stop.tangent @ start.tangent)])
        v, w = u * u * (3.0 - 2.0 * u), u * (1.0 - u) * self.length
        return np.asarray(np.array([1.0 - v, v, w * (1.0 - u), -w * u]) @ ends)

    def root(self, number: Number, low: float = 0.0, high: float | None = None, below: float | None = None) -> float:
        """Where a number vanishes between two places; `below` is that at `low`, where rounding decides on its sign."""
        last = self.length if high is None else high
        first, second = number(self.at(low)) if below is None else below, number(self.at(last))

        def several(places: Array) -> Array:
            return np.array([number(self.at(float(place))) for place in places])

        if first * second >= 0.0:
            return low if abs(first) < abs(second) else last
        ends = (np.array([low]), np.array([last]), np.array([first]), np.array([second]))
        return float(bracketed_roots(several, *ends, steps=60)[0])

    def event(self, kind: BranchEvent, place: float, which: int = -1) -> LocatedEvent:
        """What happens at a place."""
        return LocatedEvent(kind, place, self.at(place), which)


class LocatedEvent(NamedTuple):
    """What happens at a place: its kind, the point, the number of the impact or flight that it happens to, or -1."""

    kind: BranchEvent
    place: float
    point: CurvePoint
    which: int = -1


_TURN = math.cos(math.radians(25.0))  # of the tangent in a step
_ASIDE = 0.5  # of a step, by which its end may be beside the tangent
_FLIGHT = 0.5  # share of a flight by which it may change in a step
_HOME = 1e-6  # rad, between the start of a walk and where it comes back to it


def closed_at(first: CurvePoint, segment: CurveSegment) -> CurvePoint | None:
    """The start of a walk, if a step comes back to it or past it, with the times of now."""
    curve, stop, p = segment.curve, segment.stop, segment.curve.impacts
    reach = 2.0 * segment.length
    if np.abs((stop.x - first.x)[p:]).max() > reach:
        return None
    off = curve.apart(stop.x, first.x)
    if np.abs(off).max() > reach:
        return None
    ahead, along = float(off @ first.tangent), float(stop.tangent @ first.tangent)
    if not 0.0 <= ahead <= reach or along <= 0.0:
        return None
    try:  # another part of the curve may be as near: only the start itself is home
        back = curve.corrected(stop.x - ahead / along * stop.tangent, first.tangent, first.tangent, stop)
    except CorrectorFailed:
        return None
    place = stop.x - off
    return first._replace(x=place) if float(np.abs(back.x - place).max()) < _HOME else None


# ---- The walk

_FEWEST = 8  # points of a walk that can have come back to its start


class Target(NamedTuple):
    """Where a step leads: the point, the limit of a parameter that it lies on, and what else happens there."""

    point: CurvePoint
    limit: BranchEvent | None = None
    event: LocatedEvent | None = None


class Look(NamedTuple):
    """What is seen of a step: the part of the curve gone, what happens on it, and the limit or end it meets."""

    segment: CurveSegment
    between: list[LocatedEvent]
    limit: BranchEvent | None = None
    last: LocatedEvent | None = None
    beyond: CurvePoint | None = None


class Walk:
    """A walk from a point of a curve, the way its tangent points, within the range of each parameter.

    `points` are those walked through, the first of them the start, and `marks` what is known of each: see the kinds of
    walks. `happened` is what happened, in order, the last of which ended the walk; `refusal` why a parameter goes no
    further, where it does not.
    """

    quick = 3  # steps of Newton's method after which the next step along the curve is longer
    shortest = SHORTEST

    def __init__(self, curve: Any, start: CurvePoint, bounds: Sequence[tuple[float, float]]) -> None:
        self.curve, self.here, self.bounds = curve, start, bounds
        self.size = FIRST * self.scale
        self.points: list[CurvePoint] = []
        self.marks: list[int] = []
        self.happened: list[LocatedEvent] = []
        self.refusal: PercussError | None = None
        self.ended = False

    @property
    def scale(self) -> float:
        """What steps are counted in."""
        return math.sqrt(max(self.curve.impacts, 1))

    def walked(self, most: int) -> Self:
        """The same after so many points at most, or when it has come to its end."""
        try:
            self.arrive(self.here)
            while not self.ended and len(self.points) < most:
                self.step()
        except Interrupted:
            pass
        if not self.points:
            self.keep(self.here, 1)
        if not self.ended:
            self.end(BranchEvent.STOPPED)
        return self

    # -- what differs between kinds of walks --

    def mark(self) -> int:
        """What is known of the point at which the walk has arrived."""
        return 1

    def look(self, target: Target) -> Look:
        """What happens on a step; CorrectorFailed where a shorter one is needed to tell."""
        return Look(CurveSegment(self.curve, self.here, target.point), [], target.limit)

    def ends_at(self, one: LocatedEvent) -> bool:
        """Whether the curve has no other side of a point."""
        return False

    def at_last(self, one: LocatedEvent, look: Look) -> None:
        """Go to the place of what ends a step, and on from there."""
        if look.beyond is not None:
            self.arrive(look.segment.stop)
        self.keep(one.point, self.marks[-1])
        self.happened.append(one)
        self.ended = look.beyond is None
        if look.beyond is not None:
            self.arrive(look.beyond)

    def end_here(self) -> BranchEvent | None:
        """What ends the walk at the point at which it has arrived."""
        return None

    def stuck(self) -> None:
        """End the walk where no step is short enough, and say why."""
        self.end(BranchEvent.LOST)

    def home(self, segment: CurveSegment) -> CurvePoint | None:
        """The start of the walk, if a step comes back to it."""
        return closed_at(self.points[0], segment)

    # -- what is common --

    def end(self, kind: BranchEvent) -> None:
        """End the walk here."""
        self.happened.append(LocatedEvent(kind, 0.0, self.here))
        self.ended = True

    def keep(self, point: CurvePoint, mark: int) -> None:
        """Keep a point."""
        self.points.append(point)
        self.marks.append(mark)

    def arrive(self, point: CurvePoint) -> None:
        """Be at the next point."""
        self.here = point
        self.keep(point, self.mark())

    def ways(self) -> tuple[Callable[[], Target], ...]:
        """What is tried, one after the other, before the step is made shorter."""
        return (self.ahead,)

    def step(self) -> None:
        """Go on to the next point, shorter if need be, and see what happens on the way."""
        for way in self.ways():
            try:
                look = self.look(way())
            except CorrectorFailed as failed:
                self.failed(failed)
                continue
            self.went(look)
            return
        self.shorten()

    def failed(self, failed: CorrectorFailed) -> None:
        """Note why a step failed."""
        if isinstance(failed.__cause__, PercussError):
            self.refusal = failed.__cause__

    def shorten(self) -> None:
        """Try a shorter step."""
        self.size *= 0.5
        if self.size <= self.shortest:
            self.stuck()

    def went(self, look: Look) -> None:
        """Keep a step with what happened in it."""
        segment, between, limit, last, _ = look
        goes_on = last is None and limit is None and len(self.points) >= _FEWEST
        back = self.home(segment) if goes_on else None
        if back is not None:
            between = [one for one in between if float((one.point.x - back.x) @ back.tangent) < 0.0]
        for one in between:
            self.keep(one.point, self.marks[-1])  # beside what happens the number of multipliers outside changes
            self.happened.append(one)
            if self.ends_at(one):
                self.ended = True
                return
        if last is not None:
            self.at_last(last, look)
            return
        self.arrive(segment.stop if back is None else back)
        end = limit or (None if back is None else BranchEvent.CLOSED) or self.end_here()
        if end is not None:
            self.end(end)
        elif segment.stop.steps <= self.quick:
            self.size = min(1.5 * self.size, LONGEST * self.scale)

    def ahead(self) -> Target:
        """The next point, and the limit of a parameter that it lies on."""
        x, tangent = self.here.x, self.here.tangent
        place = x + self.size * tangent
        limit = self.curve.limit(x, place, self.bounds)
        if limit is None:
            found = self.curve.corrected(place, tangent, tangent, self.here)
            self.check(found, place)
            limit = self.curve.limit(x, found.x, self.bounds)  # the curve may bend past it
            if limit is None:
                return Target(found)
        self.refusal = limit.refusal or self.refusal
        along, i = limit.value - x[limit.unknown], limit.unknown
        if along == 0.0:
            return Target(self.here, limit.kind)
        place = x + (along / tangent[i] if tangent[i] else 0.0) * tangent
        place[i] = limit.value
        found = self.curve.corrected(place, np.eye(x.size)[i], tangent, self.here)
        self.check(found, place, last=True)
        return Target(found, limit.kind)

    def check(self, found: CurvePoint, place: Array, last: bool = False) -> None:
        """CorrectorFailed where a point is not the next one of the curve, or the last one, at a limit."""
        curve, here = self.curve, self.here
        if float(found.tangent @ here.tangent) < _TURN:
            raise CorrectorFailed("a bend")
        if float(np.linalg.norm(found.x - place)) > _ASIDE * self.size:
            raise CorrectorFailed("beside the tangent")
        if not np.all(np.abs(curve.flights(found.x) / curve.flights(here.x) - 1.0) < _FLIGHT):
            raise CorrectorFailed("a flight changes too much")
        before, after = here.matrix, found.matrix
        if not curve.oriented or before is None or after is None:
            return
        sides = [np.linalg.det(np.vstack(pair)) for pair in ((before, here.tangent), (after, found.tangent))]
        if sides[0] * sides[1] < 0.0:
            raise CorrectorFailed("on another part of the curve")


OneWay = TypeVar("OneWay", bound=Walk)


def both_ways(walk: Callable[[CurvePoint], OneWay], start: CurvePoint, most: int) -> tuple[OneWay, ...]:
    """The walks from a point backward and forward, of so many points at most; one where the curve is closed."""
    forward = walk(start).walked(most)
    if forward.happened[-1].kind is BranchEvent.CLOSED:
        return (forward,)
    return walk(start._replace(tangent=-start.tangent)).walked(most), forward


def joined(ways: Sequence[OneWay]) -> tuple[list[CurvePoint], list[int], list[tuple[LocatedEvent, OneWay]]]:
    """The points, marks and events (with their ways) of ways from one point, as one; a closed one begins at its end."""
    *backward, forward = ways
    points = [point for way in backward for point in way.points[:0:-1]] + forward.points
    marks = [mark for way in backward for mark in way.marks[:0:-1]] + forward.marks
    happened = [(one, way) for way in backward for one in way.happened[::-1]]
    happened += [(one, forward) for one in forward.happened]
    if forward.happened[-1].kind is BranchEvent.CLOSED:
        happened.insert(0, happened[-1])
    return points, marks, happened
