"""What ends cycles with rest, as a number that vanishes there, and the walk along all systems of which it does.

The number goes on smoothly to the other side. All of it belongs to one way of the bar: let go at a release phase, it
flies and strikes as far as the number asks for.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import BranchEvent, BranchPoint
from percuss.explore.continuation.rest_following import short_rest
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    Look,
    ParameterEnd,
    Problem,
    Target,
    Walk,
    refused,
    unit_tangent,
)
from percuss.explore.family import Family
from percuss.halting import check_interrupted
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.contact.falling_push import FallingPush
from percuss.model.system import set_at_wall, wall_load
from percuss.steady import RestCycle
from percuss.steady.resting.flight_chain import (
    ForcedResponse,
    ReleasedFlight,
    RestPath,
    RestSearch,
    WallImpact,
    chatter_left,
    release_phases,
)
from percuss.steady.resting.rest_cycles import cycle_through
from percuss.steady.trigonometric import trigonometric_roots

# ---- The way of a bar from a release up to what ends a cycle with rest, at one system after the other

TURN = 2.0 * math.pi
_JUMP = 1.5  # factor by which a flight may change in a step
_FEW = 1e-2  # an impact that is so much slower than at the last place is another one


class Unlike(CorrectorFailed):
    """Not the impacts that there were: one was born, or died."""

    def __init__(self, kind: BranchEvent) -> None:
        super().__init__("other impacts")
        self.kind = kind


class PushedRebound:
    """What an impact leaves: time, rebound, push (acceleration of an end at rest), and how fast that falls."""

    def __init__(self, leg: ReleasedFlight) -> None:
        swing, load = leg.swing, leg.swing.system.load
        self.time, self.rebound = leg.time, -leg.start.rate
        whole = 1.0 if swing.system.body.is_free else 0.0
        self.push = leg.acceleration - (swing.system.d if whole else float(swing.known.damping[0])) * self.rebound
        k = swing.harmonics
        rate = float((1j * k * load.coefficients[k.astype(int)] * leg.turned).real.sum())
        self.fall = -rate * (whole + float(swing.known.gamma.sum()))

    @property
    def share(self) -> float:
        """q of `FallingPush`; inf without a push."""
        return self.rebound * self.fall / self.push**2 if self.push > 0.0 else math.inf


def struck(course: RestSearch) -> PushedRebound:
    """What the next impact leaves; CorrectorFailed where there is none."""
    if not course.strikes():
        raise CorrectorFailed("no further impact")
    return PushedRebound(course.leg)


def near(phase: float, place: float) -> float:
    """A phase as the time nearest to a place."""
    return place + math.remainder(phase - place, TURN)


def _release_near(system: System, time: float) -> float:
    phases = release_phases(system.load)
    if not phases.size:
        raise CorrectorFailed("no release")
    return min((near(float(phase), time) for phase in phases), key=lambda one: abs(one - time))


@dataclass(frozen=True)
class RestWay:
    """A bar let go at a release phase and followed for so many load periods; its first impacts, alike everywhere."""

    modes: int
    release: float
    impacts: tuple[WallImpact, ...]
    periods: int

    def released(self, system: System) -> float:
        """When it is let go; CorrectorFailed where the load lets go nowhere."""
        return _release_near(system, self.release)

    def course(self, system: System) -> RestSearch:
        """The bar just after the last of these impacts; Unlike where they are others."""
        release = self.released(system)
        course = RestSearch(ForcedResponse(system, self.modes), release, release + TURN * (self.periods + 1))
        last, before = release, self.release
        for one in self.impacts:
            if not course.strikes():
                raise Unlike(BranchEvent.DEATH)
            its = course.impacts[-1]
            ratio = (its.time - last) / (one.time - before)
            if not 1.0 / _JUMP < ratio < _JUMP or its.speed < _FEW * one.speed:
                raise Unlike(BranchEvent.TOUCH if its.speed < one.speed else BranchEvent.DEATH)
            last, before = its.time, one.time
        return course

    def after(self, course: RestSearch, number: int) -> RestWay:
        """The same from here, with the first impacts of a course that has gone this way."""
        return RestWay(self.modes, course.release, tuple(course.impacts[:number]), self.periods)


# ---- What ends cycles with rest, as a number of the system that vanishes there and goes on smoothly to the other side

_STEPS, _CLOSE, _ASIDE = 30, 1e-12, 0.3


class RestCondition(ABC):
    """What ends the cycles on a way of the bar, and how: its `kind`."""

    way: RestWay
    kind: BranchEvent

    @abstractmethod
    def number(self, system: System) -> float:
        """What vanishes; CorrectorFailed where it is not known."""

    @abstractmethod
    def renewed(self, system: System) -> RestCondition:
        """The same with what belongs to a place on the curve taken anew."""

    @abstractmethod
    def phase(self, system: System) -> float:
        """When it happens, in rad of the load."""


@dataclass(frozen=True)
class Grazing(RestCondition):
    """The bar just reaches the wall at `time` after the release: a touch, or an impact without speed."""

    way: RestWay
    kind: BranchEvent
    time: float

    def _top(self, system: System) -> tuple[float, float]:
        """When the gap function has its maximum, after the release, and this."""
        course = self.way.course(system)
        begin = course.impacts[-1].time if course.impacts else course.release
        leg, time, last = course.leg, course.release + self.time, math.inf
        widest = _ASIDE * (time - begin)
        for _ in range(_STEPS):
            leg = _leg_at(course.leg, time)
            after, h = time - leg.time, 1e-6
            y, v = leg.gap(np.array([after, after + h]))
            bend = float(v[1] - v[0]) / h
            step = -float(v[0]) / bend if bend < 0.0 else math.inf
            if abs(time + step - course.release - self.time) > widest:
                raise CorrectorFailed("no maximum")
            time += step
            if abs(step) < _CLOSE or (abs(step) < 1e-9 and abs(step) >= abs(last)):
                return time - course.release, float(y[0])
            last = step
        raise CorrectorFailed("no maximum")

    def number(self, system: System) -> float:
        return self._top(system)[1]

    def renewed(self, system: System) -> Grazing:
        course = self.way.course(system)
        return Grazing(self.way.after(course, len(self.way.impacts)), self.kind, self._top(system)[0])

    def phase(self, system: System) -> float:
        return self.way.released(system) + self._top(system)[0]


def _leg_at(leg: ReleasedFlight, time: float) -> ReleasedFlight:
    """The part of a flight, between jumps of the load, that a time is in."""
    while (end := leg.swing.breaks_after(leg.time)) < time:
        leg = ReleasedFlight(leg.swing, end, leg.at(end - leg.time))
    return leg


@dataclass(frozen=True)
class Pulling(RestCondition):
    """A load that just no longer pulls: the number is how hard it does."""

    way: RestWay
    kind = BranchEvent.RELEASE_LOST

    def _deepest(self, system: System) -> tuple[float, float]:
        """The phase of the least load near the release, and that load."""
        load = system.load
        if load.is_piecewise:
            values, breaks = np.asarray(load.values), np.asarray(load.breaks)
            down = np.flatnonzero(values < np.roll(values, 1))
            times = [near(float(breaks[i]), self.way.release) for i in down]
            best = int(np.argmin(np.abs(np.array(times) - self.way.release)))
            return times[best], float(values[down[best]])
        k = load.harmonics.astype(float)
        rate = 1j * k * load.coefficients[load.harmonics]
        phases = trigonometric_roots(np.append(0.0, k), np.append(0.0j, rate))
        bends = [float((1j * k * rate * np.exp(1j * k * phase)).real.sum()) for phase in phases.tolist()]
        lows = [phase for phase, bend in zip(phases.tolist(), bends, strict=True) if bend > 0.0]
        if not lows:
            raise CorrectorFailed("a constant load")
        time = min((near(phase, self.way.release) for phase in lows), key=lambda one: abs(one - self.way.release))
        return time, float(load.value(time))

    def number(self, system: System) -> float:
        return -self._deepest(system)[1]

    def renewed(self, system: System) -> Pulling:
        way = self.way
        return Pulling(RestWay(way.modes, self._deepest(system)[0], (), way.periods))

    def phase(self, system: System) -> float:
        return self._deepest(system)[0]


# ---- Onsets: a rest that is about to vanish, or to begin, as a number that vanishes there (theory, Onset of chatter)

_MOST_IMPACTS = 400
_SLOWEST = 1.01  # of the growth of q − c, below which so many impacts do not tell it
_LOW, _HIGH = 0.5, 0.36  # of c, and itself: between these q is followed on; above 3/8 the bar is not thrown back
_OVER = 1e30  # in place of the q of an impact after the push is gone
_CALM = 0.3  # share of c by which q may differ from the first impact on that counts
_FINE = 1e-14  # rad of the load, beyond which later impacts have no say
_SURE = 0.5  # of a contact, left over where the bar is held without doubt


class Endless(CorrectorFailed):
    """More impacts than are followed."""


@dataclass(frozen=True)
class Vanishing(RestCondition):
    """A chatter that piles up just as the push that presses the bar on the wall is gone.

    The number is the push that is missing at the last of the impacts of the way: negative where the chatter does not
    come to its end. From there on impact by impact q departs from c, in a known way; where q is asked for late enough
    the number is exact.
    """

    way: RestWay
    kind = BranchEvent.ONSET

    def number(self, system: System) -> float:
        course = self.way.course(system)
        first = PushedRebound(course.leg)
        limit = FallingPush(-system.contact.velocity_factor)
        root = math.sqrt(limit.critical)
        found = root * first.push - math.sqrt(max(first.rebound * first.fall, 0.0))
        for excess, share, here in _followed(course, first, limit):
            found = share * (min(here.push, 0.0) - 0.5 * excess * first.push / root)
        return found

    def renewed(self, system: System) -> Vanishing:
        """With the first impact from which on q stays near c."""
        known, critical = len(self.way.impacts), FallingPush(-system.contact.velocity_factor).critical
        course = self.way.course(system)
        if system.contact.velocity_factor == 0.0:
            return Vanishing(self.way.after(course, known))
        if self._calm(course, critical):
            last = RestSearch(course.swing, course.release, course.stop)
            going = [last.strikes() for _ in range(known - 1)]
            first = known - 1 if all(going) and going and self._calm(last, critical) else known
        else:
            first = known
            for _ in range(_MOST_IMPACTS):
                if not course.strikes() or PushedRebound(course.leg).push <= 0.0:
                    break
                if self._calm(course, critical):
                    first = len(course.impacts)
                    break
        return Vanishing(self.way.after(course, first))

    @staticmethod
    def _calm(course: RestSearch, critical: float) -> bool:
        """Whether q is near c after the last impact."""
        return abs(PushedRebound(course.leg).share / critical - 1.0) < _CALM

    def phase(self, system: System) -> float:
        """When the load lets go."""
        course = self.way.course(system)
        here = PushedRebound(course.leg)
        return _release_near(system, here.time + max(here.push / here.fall, 0.0))


def _followed(
    course: RestSearch, first: PushedRebound, limit: FallingPush
) -> Iterator[tuple[float, float, PushedRebound]]:
    """Of each impact while q stays near c: its excess, the share of the first in it, and what it leaves."""
    if math.isinf(limit.growth) or first.push <= 0.0:
        return
    if limit.growth < _SLOWEST:
        raise Endless("too many impacts")
    here, share = first, 1.0
    for _ in range(_MOST_IMPACTS):
        if here.fall <= 0.0:
            return
        yield limit.excess(min(here.share, _OVER)), share, here
        if not _LOW * limit.critical < here.share < _HIGH or share * here.push < _FINE * here.fall:
            return
        here, share = struck(course), share / limit.growth
    raise Endless("too many impacts")


@dataclass(frozen=True)
class Late(RestCondition):
    """A bar that rests just as the load lets go, still pressed by strain or a step: the time from rest to release."""

    way: RestWay
    kind = BranchEvent.ONSET

    def _rest(self, system: System) -> tuple[float, RestSearch]:
        course = self.way.course(system)
        factor = system.contact.velocity_factor
        for _ in range(_MOST_IMPACTS):
            left = chatter_left(course.leg, factor) if factor < 0.0 else 0.0
            if left is not None:
                return course.leg.time + left, course
            struck(course)
        raise Endless("too many impacts")

    def number(self, system: System) -> float:
        rest, _ = self._rest(system)
        return _release_near(system, rest) - rest

    def renewed(self, system: System) -> Late:
        return Late(self.way.after(self._rest(system)[1], len(self.way.impacts)))

    def phase(self, system: System) -> float:
        """When the load lets go."""
        return _release_near(system, self._rest(system)[0])


@dataclass(frozen=True)
class Held(Vanishing):
    """The same by a law that turns the strain over: the bar is held already where its flights are short.

    Where that is, `spare` vanishes: a little beyond the place at which the chatter piles up as the push is gone.
    """

    def spare(self, system: System) -> float:
        """By how much flight and rebound of the best of the impacts are shorter than a contact, in rad of the load."""
        course = self.way.course(system)
        contact, best = 2.0 * system.body.transit_time, -math.inf
        for _ in range(_MOST_IMPACTS):
            push = float(system.load.value(course.leg.time))
            if push <= 0.0:
                break
            spare = contact - max(course.flight, -2.0 * course.leg.start.rigid / push)
            if spare < best or spare > _SURE * contact:
                return max(best, spare)
            best = spare
            struck(course)
        return best

    def renewed(self, system: System) -> Held:
        return Held(super().renewed(system).way)


# ---- What ends a branch of cycles with rest at one of its points, as a condition on the way of the bar

REST_FOLLOWED = (BranchEvent.ONSET, BranchEvent.TOUCH, BranchEvent.DEATH, BranchEvent.RELEASE_LOST)
"""The kinds of ends of which there are curves."""

_GONE, _HELD = 1e-2, 0.1  # of the greatest push, below which it vanishes, and where the bar is held before
_PILED = 0.5  # of c, below which a chatter piles up whatever becomes of the push
_RELEASE = 1e-6


def rest_condition(point: BranchPoint) -> tuple[RestCondition, float]:
    """The condition that holds at a point of a branch of cycles with rest, and the sign of its number on the branch."""
    cycle = point.cycle
    if point.kind is BranchEvent.RELEASE_LOST:
        return Pulling(RestWay(cycle.modes, cycle.release_phase, (), cycle.periods)), 1.0
    if point.kind is BranchEvent.ONSET:
        return _onset(point), 1.0 if cycle.rest_times.min() < short_rest(cycle) else -1.0
    if point.kind in (BranchEvent.TOUCH, BranchEvent.DEATH) and point.impact is not None:
        return _grazing(point, point.impact), 1.0 if point.kind is BranchEvent.DEATH else -1.0
    known = ", ".join(one.value for one in REST_FOLLOWED)
    raise ParameterError("point", str(point), f"a point of one of the kinds {known}")


def _way(point: BranchPoint, chain: RestPath, number: int) -> RestWay:
    cycle = point.cycle
    if _off_release(cycle, chain.release) > _RELEASE:
        raise ParameterError(
            "point", str(point), "one after a release where the load begins to pull", "this bar was laid down later"
        )
    return RestWay(cycle.modes, chain.release, chain.impacts[:number], cycle.periods)


def _onset(point: BranchPoint) -> RestCondition:
    """A rest that is about to vanish, or one that is about to begin."""
    cycle = point.cycle
    system, short = cycle.system, int(np.argmin(cycle.rest_times))
    chains = [cycle.chains[short]] if cycle.rest_times[short] < short_rest(cycle) else list(cycle.chains)
    factor = -system.contact.velocity_factor
    if factor == 0.0:
        ends = [(chain, i) for chain in chains for i in range(1, len(chain.impacts) + 1)]
        if len(chains) == 1 and chains[0] is cycle.chains[short]:
            ends = ends[-1:]
        chain, number = min(ends, key=lambda end: _off_release(cycle, end[0].impacts[end[1] - 1].time))
        way = _way(point, chain, number)
        return Late(way) if (cycle.modes and system.body.is_free) or system.load.is_piecewise else Vanishing(way)
    best = None
    for chain in chains:
        found = _vanishing(cycle, chain, FallingPush(factor))
        if found is not None and (best is None or found[1] < best[1]):
            best = chain, found[1], found[0]
    if best is not None:
        way = _way(point, best[0], best[2])
        return Vanishing(way) if system.contact.keeps_strain else Held(way)
    chain = chains[0]
    if chain.rest == chain.impacts[-1].time:
        told = "the ringing bar is held by one of its last, irregular impacts: of a rigid bar it can be, with 0 modes"
        raise ParameterError("point", str(point), "an onset that can be followed", told)
    limit, first = FallingPush(factor), len(chain.impacts)  # that from which on the others pile up anyway
    piled = [one.share < _PILED * limit.critical for one in _left(cycle, chain)]
    while first > 1 and piled[first - 2]:
        first -= 1
    return Late(_way(point, chain, first))


def _off_release(cycle: RestCycle, time: float) -> float:
    """How far a time is from the nearest release; infinite where there is none."""
    phases = release_phases(wall_load(cycle.system, cycle.modes))
    return min((abs(math.remainder(time - float(phase), TURN)) for phase in phases), default=math.inf)


def _left(cycle: RestCycle, chain: RestPath) -> list[PushedRebound]:
    """What each impact of a chain leaves."""
    course = RestSearch(
        ForcedResponse(set_at_wall(cycle.system, cycle.modes), cycle.modes), chain.release, chain.stop + TURN
    )
    return [struck(course) for _ in chain.impacts]


def _vanishing(cycle: RestCycle, chain: RestPath, limit: FallingPush) -> tuple[int, float] | None:
    """The first of the impacts that pile up as the push vanishes, and the least push; None where none do."""
    left = _left(cycle, chain)
    best, begun = None, None
    gone = (_GONE if cycle.system.contact.keeps_strain else _HELD) * max(one.push for one in left)
    for number, one in enumerate(left, 1):
        if abs(one.share / limit.critical - 1.0) >= _CALM:
            begun = None
            continue
        begun = number if begun is None else begun
        if one.push < gone and (best is None or one.push < best[1]):
            best = begun, one.push
    return best


def _grazing(point: BranchPoint, impact: int) -> Grazing:
    number = impact - 1
    for chain in point.cycle.chains:
        if number < len(chain.impacts):
            break
        number -= len(chain.impacts)
    way, here = _way(point, chain, number), chain.impacts[number].time
    if point.kind is BranchEvent.TOUCH:
        assert point.touch_phase is not None
        begin = chain.impacts[number - 1].time if number else chain.release
        first = near(point.touch_phase, begin)
        times = [first + TURN * turn for turn in range(point.cycle.periods + 2)]
        here = min((time for time in times if begin < time < here), default=here)
    return Grazing(way, point.kind, here - chain.release)


# ---- The walk along a curve of ends of cycles with rest over two parameters, and what happens on it

_LAST = {"restitution": (0.0, 1.0), "contact.restitution": (0.0, 1.0)}  # the values that there are
_BESIDE = 1e-6  # of a unit, how far beside the curve it is looked what cycle there is
_FAR = 1e2 * _BESIDE
_FIRM = 1e-4  # steps after which what failed before says nothing any more
_INSIDE = 1e-10  # of a unit, to which it is known where the cycle ceases
_TURN = math.cos(math.radians(25.0))
_NEAREST, _FURTHEST = 1e-9, 1e-2  # between which a length is searched for


@dataclass(frozen=True)
class RestEndCurve(Problem):
    """All systems over two parameters for which the number of what ends cycles with rest vanishes."""

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]
    condition: RestCondition
    impacts: int = 0
    places: tuple[int, int] = (0, 1)

    @property
    def periods(self) -> int:  # type: ignore[override]
        """Load periods for which the bar is followed."""
        return self.condition.way.periods

    def at_wall(self, x: Array) -> System:
        """The system as what is let go at the wall: see `percuss.model.system`."""
        return set_at_wall(self.system_at(x), self.condition.way.modes)

    def residual(self, x: Array) -> Array:
        """What vanishes on the curve."""
        try:
            return np.array([self.condition.number(self.at_wall(x))])
        except Interrupted:
            raise
        except PercussError as error:
            raise CorrectorFailed(str(error)) from error

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        """As of other curves, by the secant method along the line that is the plane here: the number has kinks."""
        way = np.array([-normal[1], normal[0]])
        matrix = self.matrix(start) if near.matrix is None else near.matrix
        at, slope, steps = _root_on_line(lambda at: float(self.residual(start + at * way)[0]), float(matrix[0] @ way))
        place = start + at * way
        try:
            beside = self.residual(place + self.difference * normal) / self.difference
        except CorrectorFailed:  # beyond the end of a parameter
            beside = -self.residual(place - self.difference * normal) / self.difference
        matrix = slope * way[None, :] + beside[:, None] * normal
        return CurvePoint(place, unit_tangent(matrix, along), steps, matrix)

    def renewed(self, x: Array) -> RestEndCurve:
        """The same with the way of the bar taken anew at a place of the curve."""
        return replace(self, condition=self.condition.renewed(self.at_wall(x)))

    def limit(self, here: Array, x: Array, bounds: Sequence[tuple[float, float]]) -> ParameterEnd | None:
        """The first end of a range on the way to another place, or of the values that there are."""
        known = [_LAST.get(name, (-math.inf, math.inf)) for name in self.names]
        inner = [(max(a, low), min(b, high)) for (a, b), (low, high) in zip(bounds, known, strict=True)]
        found = super().limit(here, x, inner)
        if found is None or math.isfinite(bounds[found.unknown][int(found.value > here[found.unknown])]):
            return found
        return found._replace(kind=BranchEvent.NO_SYSTEM)


_EXACT, _ROUGH, _LEAP = 1e-13, 1e-11, 2.0  # steps to a root: the last one, one that rounding has a say in, their growth
_MOST_STEPS, _REACH = 20, 0.1


def _root_on_line(number: Callable[[float], float], slope: float) -> tuple[float, float, int]:
    """Where a number vanishes near 0, by the secant method; its derivative there, and how many steps."""
    last, value = 0.0, number(0.0)
    if value == 0.0:
        return 0.0, slope, 0
    along = -value / slope if slope else math.inf
    for count in range(1, _MOST_STEPS + 1):
        if not abs(along) <= _REACH:
            raise CorrectorFailed("beside the curve")
        check_interrupted()
        now = number(along)
        if now == 0.0:
            return along, slope, count
        step = along - last
        rise = (now - value) / step
        ahead = -now / rise if rise * slope > 0.0 else math.inf
        if abs(ahead) > _LEAP * abs(step):
            if abs(step) < _ROUGH:
                return along, slope, count
            ahead = math.copysign(_LEAP * abs(step), -now * slope)
        elif abs(step) > _ROUGH:
            slope = rise
        if abs(ahead) <= _EXACT:
            return along + ahead, slope, count
        last, value, along = along, now, along + ahead
    raise CorrectorFailed("no root")


class RestEndWalk(Walk):
    """A walk along ends of cycles with rest; its marks are whether the cycle is there beside the curve.

    `cycle` is that which ends on the curve, where it was first met, `side` the sign of the number where it is; `seen`
    has of each point kept both parameters, when the bar is let go, and when the cycle ends.
    """

    quick = 5

    def __init__(
        self,
        curve: RestEndCurve,
        start: CurvePoint,
        bounds: Sequence[tuple[float, float]],
        cycle: RestCycle,
        side: float,
    ) -> None:
        super().__init__(curve, start, bounds)
        self.cycle, self.side, self.beyond = cycle, side, 0.0
        self.stray: CorrectorFailed | None = None
        self._ahead: tuple[CurvePoint, RestEndCurve, bool] | None = None
        self.seen: list[tuple[tuple[float, float], float, float]] = []

    def keep(self, point: CurvePoint, mark: int) -> None:
        super().keep(point, mark)
        condition = self.curve.condition
        values, release, phase = self.curve.values(point.x), condition.way.release, math.nan
        try:
            system = self.curve.at_wall(point.x)
            phase = condition.phase(system)
            values = self.curve.values(self._place(point, system))
        except (PercussError, CorrectorFailed):
            pass
        self.seen.append((values, release, phase))

    def mark(self) -> int:
        seen = self._ahead
        return int(self._is_cycle(self.here) if seen is None or seen[0] is not self.here else seen[2])

    def arrive(self, point: CurvePoint) -> None:
        seen = self._ahead
        self.curve = self.curve.renewed(point.x) if seen is None or seen[0] is not point else seen[1]
        super().arrive(point)
        if self.size > _FIRM:
            self.stray = None

    def failed(self, failed: CorrectorFailed) -> None:
        if type(self.stray) is CorrectorFailed or self.stray is None or type(failed) is not CorrectorFailed:
            self.stray = failed  # one that says more than that there was none is kept
        if isinstance(self.stray.__cause__, PercussError):
            self.refusal = self.stray.__cause__

    def check(self, found: CurvePoint, place: Array, last: bool = False) -> None:
        chord = found.x - self.here.x  # at R = 0 a curve of onsets may end with any slope
        if float(chord @ self.here.tangent) < _TURN * float(np.linalg.norm(chord)):
            raise CorrectorFailed("a bend")
        if not last:
            super().check(found, place)

    def look(self, target: Target) -> Look:
        """Where in a step the cycle ceases, or comes again."""
        segment = CurveSegment(self.curve, self.here, target.point)
        try:
            curve = self.curve.renewed(target.point.x)
            now = self._is_cycle(target.point, curve)
        except Interrupted:
            raise
        except PercussError as error:
            raise CorrectorFailed(str(error)) from error
        self._ahead = target.point, curve, now
        if now == bool(self.marks[-1]):
            return Look(segment, [], target.limit)
        low, high = 0.0, segment.length
        while high - low > _INSIDE:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._is_cycle(segment.at(middle)) is now else (middle, high)
        return Look(segment, [segment.event(BranchEvent.OTHER_CYCLE, high)], target.limit)

    def _is_cycle(self, point: CurvePoint, curve: RestEndCurve | None = None) -> bool:
        """Whether the bar let go comes back as the cycle does, hardly beside the curve."""
        curve = self.curve if curve is None else curve
        if curve.condition.kind is BranchEvent.RELEASE_LOST:
            return True
        try:
            place = self._place(point, curve.at_wall(point.x)) + self.side * _BESIDE * _across(point)
            system = curve.system_at(place)
        except Interrupted:
            raise
        except PercussError:  # beyond the end of a parameter
            return not self.marks or bool(self.marks[-1])
        try:
            release = curve.condition.way.released(set_at_wall(system, self.cycle.modes))
            found, _, _ = cycle_through(system, release, modes=self.cycle.modes, most=self.cycle.periods)
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError):
            return False
        return found is not None and found.periods == self.cycle.periods

    def _place(self, point: CurvePoint, system: System) -> Array:
        """Where the cycle ends: where the bar is hardly held any more, by a law that turns the strain over."""
        condition, x = self.curve.condition, point.x
        if not isinstance(condition, Held) or system.contact.velocity_factor >= 0.0:
            return x
        edge = [i for i, bounds in enumerate(self.bounds) if self.curve.values(x)[i] in bounds]
        way = _across(point)
        if edge:  # along the edge of the plane
            way = math.copysign(1.0, way[1 - edge[0]]) * np.eye(2)[1 - edge[0]]
        self.beyond = _vanishing_beyond(lambda at: condition.spare(self.curve.at_wall(x - at * way)), 0.7 * self.beyond)
        return np.asarray(x - self.beyond * way)

    def stuck(self) -> None:
        if isinstance(self.stray, Unlike):
            kind = BranchEvent.WITH_TOUCH if self.stray.kind is BranchEvent.TOUCH else BranchEvent.WITH_DEATH
            self._forget()
        elif isinstance(self.stray, Endless):
            kind = BranchEvent.UNPRESSED if isinstance(self.curve.condition, Late) else BranchEvent.ENDLESS
        elif self.stray is not None and isinstance(self.stray.__cause__, PercussError):
            kind = refused(self.stray.__cause__)
        else:
            kind = BranchEvent.LOST
        self.end(kind)

    def _forget(self) -> None:
        """Forget what is seen so near to the end of the curve that what is beside it is beyond."""

        def is_far(point: CurvePoint) -> bool:
            return float(np.linalg.norm(point.x - self.here.x)) > _FAR

        self.happened = [one for one in self.happened if is_far(one.point)]
        was = next((mark for point, mark in zip(self.points[::-1], self.marks[::-1], strict=True) if is_far(point)), 1)
        self.marks = [mark if is_far(point) else was for point, mark in zip(self.points, self.marks, strict=True)]


def _across(point: CurvePoint) -> Array:
    """The direction at right angles to the curve in which the number grows."""
    assert point.matrix is not None
    return np.asarray(point.matrix[0] / np.linalg.norm(point.matrix[0]))


def _vanishing_beyond(number: Callable[[float], float], about: float) -> float:
    """The first length at which a number that is positive at 0 vanishes; CorrectorFailed where that is too far."""
    low, high = 0.0, max(about, _NEAREST)
    while (above := number(high)) > 0.0:
        low, high = high, 2.0 * high
        if high > _FURTHEST:
            raise CorrectorFailed("held further on")
    if low == 0.0 and number(0.0) <= 0.0:
        return 0.0
    ends = (np.array([1.0 + low]), np.array([1.0 + high]), np.array([number(low)]), np.array([above]))  # to 1e-16
    return float(bracketed_roots(lambda at: np.array([number(float(one) - 1.0) for one in at]), *ends)[0]) - 1.0


# ---- Where such a curve begins

_SAME, _HELD_REACH = 1e-6, 1e-2  # of a unit, by which the start may be off, and where the bar is held before


def rest_end_start(
    curve: RestEndCurve, here: Array, bounds: Sequence[tuple[float, float]]
) -> tuple[RestEndCurve, CurvePoint]:
    """The curve through a place, and the point on it, with the number growing to the left; or CorrectorFailed."""
    reach = _HELD_REACH if isinstance(curve.condition, Held) else _SAME
    ends = [
        {end / unit for end in (*pair, *_LAST.get(name, ()))}
        for pair, unit, name in zip(bounds, curve.units, curve.names, strict=True)
    ]
    point = CurvePoint(here, np.zeros(2), 0)
    for _ in range(2):
        matrix = curve.matrix(point.x)
        slopes = matrix[0] / np.linalg.norm(matrix[0])
        free = np.abs(slopes) * np.where([value in on for value, on in zip(point.x, ends, strict=True)], 1e-9, 1.0)
        held = np.eye(2)[int(np.argmin(free))]  # not off the edge of the plane
        tangent = np.array([slopes[1], -slopes[0]])
        found = curve.corrected(point.x, held, tangent, CurvePoint(point.x, tangent, 0, matrix))
        if float(np.abs(found.x - point.x).max()) > reach:
            raise CorrectorFailed("beside the curve")
        point, curve = found, curve.renewed(found.x)
    return curve, point
