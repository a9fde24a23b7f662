"""What ends cycles with rest, as a number of the system that vanishes there and goes on smoothly to the other side.

All of it belongs to one way of the bar: let go at a release phase, it flies and strikes as far as the number asks for.
Here are touches, deaths of impacts and the last release.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.branch import BranchEvent, BranchPoint
from percuss.explore.continuation.problem import CorrectorFailed
from percuss.explore.continuation.rest_following import short_rest
from percuss.model import System
from percuss.model.contact.falling_push import FallingPush
from percuss.model.system import set_at_wall, wall_load
from percuss.steady import RestCycle
from percuss.steady.resting.flight_chain import (
    ReleasedFlight,
    RestPath,
    RestSearch,
    Swing,
    WallImpact,
    chatter_left,
    release_phases,
)
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
    """What an impact leaves: the time, the speed of the rebound, the push, and how fast that falls.

    The push is the acceleration of a striking end without velocity; it falls as the load does while the strain stays.
    """

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
    """The release nearest to a time; CorrectorFailed where the load lets go nowhere."""
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
        course = RestSearch(Swing(system, self.modes), release, release + TURN * (self.periods + 1))
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
    """The bar just reaches the wall in the flight after the impacts of the way: a touch, or an impact without speed.

    `time` is when it does, after the release.
    """

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
    """A bar that comes to rest just as the load lets go, still pressed on the wall by its strain, or by a step.

    The number is the time from the rest to the release.
    """

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
    """The way of a chain up to an impact."""
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
    course = RestSearch(Swing(set_at_wall(cycle.system, cycle.modes), cycle.modes), chain.release, chain.stop + TURN)
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
    """An impact that is born or dies."""
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
