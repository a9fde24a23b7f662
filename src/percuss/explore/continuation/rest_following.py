"""Cycles with rest followed through a parameter, both ways, to where they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.branch import KEPT_IMPACTS, Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.branch_events import outside
from percuss.explore.continuation.machine_walk import MachineWalk, beginning, branch_of
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Problem,
    Varied,
    both_ways,
)
from percuss.explore.family import Family
from percuss.halting import check_interrupted, halting
from percuss.mechanics.held_structure import held_structure
from percuss.model.checks import Array, ComplexArray
from percuss.model.contact.falling_push import FallingPush
from percuss.model.system import wall_load
from percuss.steady import RestCycle
from percuss.steady.multipliers import TURNING
from percuss.steady.resting.flight_chain import ForcedResponse, RestPath, release_phases
from percuss.steady.resting.rest_cycles import MOST_PERIODS, cycle_of_rests, cycle_through
from percuss.steady.resting.rest_map import FixedRests, Lying, ways_from

# ---- What lies beyond the ends of a branch of cycles with rest, in a sentence


def _who(cycle: RestCycle) -> str:
    return "bar" if cycle.system.body.is_free else "structure"


def without_release(cycle: RestCycle) -> str:
    """Where the load no longer lets go."""
    if cycle.is_several:
        return "the wall never has to pull: the structure rests on it for good"
    return f"the load never turns from push to pull: the {_who(cycle)} rests on the wall for good"


def _after_onset(cycle: RestCycle) -> str:
    what = "the end of the chatter" if cycle.chatters else "the impact before the rest"
    if cycle.chatters and cycle.modes and cycle.system.body.is_free:
        return f"{what} meets the next release; beyond, the bar laid down is let go at once"
    told = f"{what} meets the next release, and the {_who(cycle)} is not laid down before it"
    if cycle.chatters and cycle.system.contact.keeps_strain:
        told += f"; beyond, motions z=p/{cycle.periods} have p growing without bound as this point is approached"
    return told


def _after_change(cycle: RestCycle, chains: Sequence[RestPath]) -> str:
    if any(chain.chatters for chain in chains) is cycle.chatters:
        return f"the {_who(cycle)} comes back to this release after other rests"
    if cycle.chatters:
        return f"without rebound the {_who(cycle)} rests at its first impact under a push: rest/{cycle.periods}"
    return f"with rebound, however little, the {_who(cycle)} chatters to its rest: chatter/{cycle.periods}"


# ---- What ends a branch of cycles with rest, told by the impacts that follow the releases on either side

_JUMP = 1.4  # factor by which a flight may change in a step
_AHEAD = 1.5
_SHORT = 1e-2  # rad of rest below which the rest is about to vanish
_FEW = 1e-3  # of the greatest speed: slower impacts belong to the chatter


def rest_end(
    value: float, cycle: RestCycle, own: tuple[RestPath, ...], chains: tuple[RestPath, ...], is_system: bool
) -> BranchPoint:
    """What ends the branch between a cycle, with its `own` chains, and what was followed just beyond."""
    phase, impact, several = None, None, cycle.is_several
    waits = [np.mod(after.release - (one.rest or math.nan), 2.0 * math.pi) for one, after in pairwise(chains)]
    vanishes = float(cycle.rest_times.min()) < short_rest(cycle)
    if not is_system:
        kind, beyond = BranchEvent.NO_SYSTEM, "there is no such system"
    elif not chains and not (several and vanishes):
        kind, beyond = BranchEvent.RELEASE_LOST, without_release(cycle)
    elif (other := _first_other(own, chains)) is not None:
        kind, phase, impact = other
        touches = f"the {_who(cycle)} touches the wall in a flight, and strikes it there beyond"
        jumps = cycle.modes > 0 and cycle.system.body.is_free
        beyond = f"{touches if kind is BranchEvent.TOUCH else 'an impact dies'}: what follows "
        beyond += "jumps" if jumps else "changes as the root of the distance from here"
    elif vanishes:
        kind, beyond = BranchEvent.ONSET, _after_onset(cycle)
    elif waits and float(np.nanmin([*waits, math.inf])) < _SHORT:
        what = "comes to rest once more: just before another release, which an impact meets here"
        kind, beyond = BranchEvent.ONSET, f"the {_who(cycle)} {what}"
    elif several:
        kind, beyond = BranchEvent.LOST, BranchEvent.LOST.words
    else:
        kind, beyond = BranchEvent.CHANGE, _after_change(cycle, chains)
    values = cycle.multipliers().values if cycle.remembered else None
    return BranchPoint(kind, (value,), cycle, beyond, values, impact, phase)


def short_rest(cycle: RestCycle) -> float:
    """The rest, in rad of the load, below which the rest of a cycle is about to vanish."""
    # by a law that turns the strain over the bar is held 1/(2c) contacts before the load lets go: see `FallingPush`
    contact, restitution = cycle.system.contact, -cycle.system.contact.velocity_factor
    if contact.keeps_strain or not 0.0 < restitution < 1.0:
        return _SHORT
    return max(_SHORT, _AHEAD * cycle.system.body.transit_time / FallingPush(restitution).critical)


def _first_other(chains: tuple[RestPath, ...], others: tuple[RestPath, ...]) -> tuple[BranchEvent, float, int] | None:
    """The first impact that one of the chains has and the other has not, its phase and its number; None for none."""
    before = 0
    for one, other in zip(chains, others, strict=False):
        if not (one.impacts and other.impacts):
            continue
        last, its_last = one.release, other.release
        many = min(_notable(one), _notable(other))
        for number, (mine, its) in enumerate(zip(one.impacts[:many], other.impacts[:many], strict=True), 1):
            ratio = (its.time - its_last) / (mine.time - last)
            slow, fast = sorted((mine.speed, its.speed))
            if not 1.0 / _JUMP < ratio < _JUMP or slow < _FEW * fast:
                touch = its.speed < mine.speed  # what is born or dies is slow
                where = its.time if touch else mine.time
                kind = BranchEvent.TOUCH if touch else BranchEvent.DEATH
                return kind, float(np.mod(where, 2.0 * math.pi)), before + number
            last, its_last = mine.time, its.time
        before += len(one.impacts)
    return None


def _notable(chain: RestPath) -> int:
    """How many impacts there are up to the last that is not of the end of a chatter."""
    fastest = max(impact.speed for impact in chain.impacts)
    return max(i for i, impact in enumerate(chain.impacts, 1) if impact.speed >= _FEW * fastest)


# ---- Cycles with rest followed through a parameter, both ways, to where they end

_EXACT = 2e-13  # of the parameter, to which a point is located
_NEARER, _MOST_OF = 0.45, 0.9  # of what is left to where a release is lost, and a rest vanishes
_BARELY = 1e-6  # of the parameter, before the last release, where pulls are too short for the chatter to be followed
_NEXT = 2e-9  # of the parameter, before the last release, to where the last cycle is followed if it can be
_ON = "the branch goes on"
_FAR = 1e6  # times the value, or 1: the ends where no range is given


def follow_rest(
    cycle: RestCycle,
    over: Varied,
    *,
    switch: int = 0,
    points: int = 65,
    most: int = 4000,
    halt: Callable[[], bool] | None = None,
) -> Branch:
    """The branch of a cycle with rest; see `percuss.explore.follow`."""
    # It goes on while the same impacts follow and the bar rests before the load pulls again: all multipliers are 0.
    if cycle.is_several:
        return _follow_several(cycle, over, switch, points, most, halt)
    if len(cycle.remembered) == 1:
        held = "a cycle in which the load holds the bar for some time"
        raise ParameterError("cycle", str(cycle), held, "a bar that is always let go at once is not followed yet")
    (here,), ((low, high),), share = over.here, over.bounds, 1.0 / (points - 1)
    bounded, far = math.isfinite(high - low), _FAR * max(1.0, abs(here))
    low, high = (low, high) if bounded else (here - far, here + far)
    step = share * (high - low) if bounded else share * (abs(here) or 1.0)
    walker = _Walker(over.family, over.names[0], cycle, step, 0.0 if bounded else share)
    with halting(halt):
        ends, (below, above) = [], ([(here, cycle)], [(here, cycle)])
        for way, stop in ((below, low), (above, high)):
            try:
                ends.append(walker.walked(way, stop))
            except Interrupted:
                ends.append(BranchPoint(BranchEvent.STOPPED, (way[-1][0],), way[-1][1], _ON))
    rows = [*below[:0:-1], *above]
    cycles = [row[1] for row in rows]
    return Branch(
        parameters=(walker.name,), label=cycle.label, modes=cycle.modes, values=np.array([row[0] for row in rows]),
        points=tuple(ends), unstable=np.zeros(len(rows), dtype=np.int64), motions=tuple(cycles), **along(cycles),
    )  # fmt: skip


def along(cycles: Sequence[RestCycle]) -> dict[str, Any]:
    """What a branch has of cycles: the first impacts after each of their releases, releases and rests."""
    times, speeds = np.full((2, len(cycles), len(cycles[0].chains), KEPT_IMPACTS), np.nan)
    for i, cycle in enumerate(cycles):
        for flight, chain in enumerate(cycle.chains):
            kept = np.array(chain.impacts[:KEPT_IMPACTS]).reshape(-1, 2)
            times[i, flight, : len(kept)], speeds[i, flight, : len(kept)] = kept.T
    most = int(np.isfinite(times).sum(axis=-1).max())
    return {
        "times": times[..., :most],
        "speeds": speeds[..., :most],
        "releases": np.array([[chain.release for chain in cycle.chains] for cycle in cycles]),
        "rests": np.array([[chain.rest for chain in cycle.chains] for cycle in cycles], dtype=float),
    }


@dataclass(frozen=True)
class _Walker:
    """The family, and where the walk began."""

    systems: Family
    name: str
    first: RestCycle
    step: float
    growth: float  # share of the way so far that a step may be, where the range has no ends

    def at(self, value: float, near: RestCycle) -> tuple[RestCycle | None, tuple[RestPath, ...], bool]:
        """The cycle at a value that goes on from one beside it, what was followed, and whether there is a system."""
        try:
            system = self.systems.system({self.name: value})
            cycle, chains, release = cycle_through(
                system, near.release_phase, modes=self.first.modes, most=self.first.periods
            )
        except Interrupted:
            raise
        except PercussError:
            return None, (), False
        if cycle is None or (cycle.label, len(cycle.chains)) != (near.label, len(near.chains)):
            return None, chains, True
        if _first_other(near.chains, cycle.chains) is not None:
            return None, chains, True
        return cycle, chains if release is not None else (), True

    def walked(self, rows: list[tuple[float, RestCycle]], end: float) -> BranchPoint:
        """The point at which the cycles end towards an end of the range; they are added to that where they begin."""
        (here, cycle), size = rows[-1], self.step
        first, failed, gone = here, False, None
        while here != end:
            check_interrupted()
            last = not failed and abs(end - here) <= 1.5 * size
            step = self._sized(rows, min(size, abs(end - here)), gone) if failed else size
            ahead = end if last else here + math.copysign(step, end - here)
            found, chains, is_system = self.at(ahead, cycle)
            scale = max(1.0, abs(here))
            if found is not None:
                size = min(1.5 * abs(ahead - here), max(self.step, self.growth * abs(ahead - first)))
                here, cycle = ahead, found
                rows.append((here, cycle))
                if gone is not None and abs(gone - here) < _NEXT * scale:
                    return BranchPoint(BranchEvent.RELEASE_LOST, (gone,), cycle, without_release(cycle))
                continue
            failed, size = True, 0.4 * abs(ahead - here)
            if gone is None and is_system and not chains:
                gone = self._release_lost(here, ahead - here)
            if size < _EXACT * scale:
                gone = self._release_lost(here, math.copysign(_BARELY * scale, end - here))
                if gone is not None:
                    return BranchPoint(BranchEvent.RELEASE_LOST, (gone,), cycle, without_release(cycle))
                return rest_end(here, cycle, cycle.chains, chains, is_system)
        return BranchPoint(BranchEvent.LIMIT, (here,), cycle, _ON)

    @staticmethod
    def _sized(rows: list[tuple[float, RestCycle]], size: float, gone: float | None) -> float:
        """A step, no longer than what is left by half where the release is lost, or by most where the rest vanishes."""
        here, cycle = rows[-1]
        if gone is not None:
            size = min(size, _NEARER * abs(gone - here))
        if len(rows) > 1:
            before, earlier = rows[-2]
            rest, wider = float(cycle.rest_times.min()), float(earlier.rest_times.min())
            left = rest / (wider - rest) * abs(here - before) if wider > rest else math.inf
            size = min(size, max(_MOST_OF * left, 2.0 * _EXACT * max(1.0, abs(here))))
        return size

    def _release_lost(self, value: float, ahead: float) -> float | None:
        """Where the load ceases to let go, if that is not beyond a step: there pulls move the bar by rounding."""

        def releases(at: float) -> bool:
            try:
                return bool(release_phases(wall_load(self.systems.system({self.name: at}), self.first.modes)).size)
            except PercussError:
                return True

        low, high = value, value + ahead
        if releases(high):
            return None
        while abs(high - low) > _EXACT * max(1.0, abs(value)):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if releases(middle) else (low, middle)
        return high


# ---- Those of structures of several modes: fixed points of the map from rest to rest, round folds and on at flips

_KEPT = 256  # motions
_LONG, _SHORTEST, _SAME = 40.0, 1e-13, 1e-6
_BEYOND = 10.0 ** np.arange(-12.0, -5.0)  # how far beyond an end it is looked what follows


@dataclass(frozen=True)
class RestCurve(Problem):
    """The cycles with so many rests of a family of structures with N modes.

    The unknowns are the shape and the time of a rest; shapes are counted in `size`, and `stride` tells how long the
    steps of a walk may be.
    """

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]
    modes: int
    rests: int
    periods: int
    chatters: bool
    size: float
    stride: float = 1.0
    impacts = 0
    difference = 1e-5

    @staticmethod
    def of(cycle: RestCycle, over: Varied, stride: float = 1.0) -> tuple[RestCurve, Array]:
        """The curve of a cycle, and its unknowns."""
        held, last = held_structure(cycle.system, cycle.modes), cycle.lying[-1]
        root, _, across = held.basis
        size = max(float(np.abs(root * last.shape).max()), 1e-300)
        rests, chatters = len(cycle.chains), cycle.chatters
        curve = RestCurve(
            over.family, over.names, over.units, cycle.modes, rests, cycle.periods, chatters, size, stride
        )
        values = np.divide(over.here, over.units)
        return curve, np.concatenate([across.T @ (root * last.shape) / size, [last.time], values])

    @property
    def places(self) -> tuple[int, ...]:
        return tuple(range(self.modes, self.modes + len(self.names)))

    @property
    def label(self) -> str:
        """Of the cycles."""
        return f"{'chatter' if self.chatters else 'rest'}/{self.periods}"

    def value(self, x: Array) -> float:
        """The parameter at a point, or the first of two."""
        return self.values(x)[0]

    def apart(self, x: Array, first: Array) -> Array:
        off = x - first
        off[self.modes - 1] = math.remainder(off[self.modes - 1], 2.0 * math.pi)
        return off

    @cached_property
    def _found(self) -> dict[bytes, FixedRests]:
        return {}

    def ways(self, x: Array) -> FixedRests:
        """The ways from rest to rest, all there are; PercussError where there is no system."""
        key = x[: self.places[-1] + 1].tobytes()
        if key not in self._found:
            if len(self._found) > _KEPT:
                self._found.clear()
            swing, n = ForcedResponse(self.system_at(x), self.modes), self.modes - 1
            held = held_structure(swing.system, self.modes)
            lying = Lying(float(x[n]), held.lies(self.size * x[:n]))
            self._found[key] = FixedRests(tuple(ways_from(swing, lying, self.rests, self.periods)))
        return self._found[key]

    def _closed(self, x: Array) -> FixedRests:
        found = self.ways(x)
        if len(found.ways) < self.rests or found.ways[-1].path.rest is None:
            raise CorrectorFailed("fewer rests")
        return found

    def residual(self, x: Array) -> Array:
        way = self._closed(x).ways[-1]
        root, _, across = way.held.basis
        n = self.modes - 1
        shape = across.T @ (root * way.end.shape) / self.size - x[:n]
        return np.append(shape, way.end.time - x[n] - 2.0 * math.pi * self.periods)

    def matrix(self, x: Array) -> Array:
        unit = np.append(np.full(self.modes - 1, self.size), 1.0)
        own = self._closed(x).matrix * (unit / unit[:, None]) - np.eye(self.modes)
        return np.hstack([own, self.by_differences(x, self.places, partial(self._beside, x))])

    def paths(self, x: Array) -> tuple[RestPath, ...]:
        """What follows each release, all there is."""
        return tuple(way.path for way in self.ways(x).ways)

    def are_alike(self, x: Array, other: Array) -> bool:
        """Whether the same impacts lead to rest at two points."""
        paths = self.paths(other)
        return any(path.chatters for path in paths) is self.chatters and _first_other(self.paths(x), paths) is None

    def _beside(self, x: Array, other: Array) -> Array:
        if not self.are_alike(x, other):
            raise CorrectorFailed("other impacts")
        return self.residual(other)

    def motion(self, x: Array) -> RestCycle:
        """The cycle at a point."""
        system = self.system_at(x)
        return cycle_of_rests(system, ForcedResponse(system, self.modes), self._closed(x))

    def tests(self, x: Array) -> dict[str, float]:
        """None: what ends a branch is found where it does."""
        return {}

    # -- numbers that vanish where stability changes --

    def unstable(self, x: Array) -> int:
        """How many multipliers are outside the unit circle."""
        return outside(self._multipliers(CurvePoint(x, x, 0)))

    def _multipliers(self, point: CurvePoint) -> ComplexArray:
        return np.linalg.eigvals(self._closed(point.x).matrix).astype(complex)

    def fold(self, point: CurvePoint) -> float:
        """Where a multiplier is 1."""
        return float(np.prod(1.0 - self._multipliers(point)).real)

    def flip(self, point: CurvePoint) -> float:
        """Where a multiplier is −1."""
        return float(np.prod(1.0 + self._multipliers(point)).real)

    def pair(self, point: CurvePoint) -> float:
        """Where the product of two multipliers is 1."""
        first, second = np.array(list(combinations(self._multipliers(point), 2))).T
        return float(np.real(np.prod(1.0 - first * second)))

    # -- cycles of twice and half as many rests --

    def doubled(self, x: Array) -> tuple[RestCurve, Array] | None:
        """The curve of two cycles, and the unknowns; None for too long ones."""
        wide = replace(self, rests=2 * self.rests, periods=2 * self.periods)
        return (wide, x) if wide.periods <= MOST_PERIODS else None

    def halves(self, x: Array) -> tuple[Array, Array] | None:
        """The mean of both halves of a cycle, and their difference; None for an odd number of rests or periods."""
        if self.rests % 2 or self.periods % 2:
            return None
        way, n = self._closed(x).ways[self.rests // 2 - 1], self.modes
        root, _, across = way.held.basis
        there = np.append(across.T @ (root * way.end.shape) / self.size, way.end.time - math.pi * self.periods)
        return np.append(0.5 * (x[:n] + there), x[n:]), there - x[:n]

    def halved(self, x: Array) -> RestCurve:
        """The curve of cycles of half of these."""
        return replace(self, rests=self.rests // 2, periods=self.periods // 2)

    def along(self, cycles: Sequence[RestCycle]) -> dict[str, Any]:
        """What a branch has of them."""
        return along(cycles)


def end_beyond(curve: RestCurve, here: CurvePoint) -> BranchPoint:
    """What ends a walk at a point, told by what follows just beyond."""
    for by in _BEYOND:
        try:
            chains, is_system = curve.paths(here.x + by * here.tangent), True
        except PercussError:
            chains, is_system = (), False
        found = rest_end(curve.value(here.x), curve.motion(here.x), curve.paths(here.x), chains, is_system)
        if found.kind is not BranchEvent.LOST:
            break
    return found


class RestWalk(MachineWalk):
    """A walk along them; `last` is what ends it where no step is short enough."""

    quick, shortest = 6, _SHORTEST
    last: BranchPoint | None = None

    @property
    def scale(self) -> float:
        return float(self.curve.stride)

    def what_happens(self, segment: CurveSegment) -> tuple[list[LocatedEvent], LocatedEvent | None]:
        curve, start, stop = segment.curve, segment.start, segment.stop
        if not curve.are_alike(start.x, stop.x):
            raise CorrectorFailed("other impacts")
        found = []
        for kind, number in _NUMBERS:
            if not self.fresh and number(curve, start) * number(curve, stop) < 0.0:
                one = segment.event(kind, segment.root(partial(number, curve)))
                turns = max(abs(np.imag(curve.motion(one.point.x).remembered)))
                if kind is not BranchEvent.NEIMARK_SACKER or turns > TURNING:
                    found.append(one)
        return sorted(found, key=lambda one: one.place), None

    def stuck(self) -> None:
        self.last = end_beyond(self.curve, self.here)
        self.end(self.last.kind)

    def told(self, one: LocatedEvent) -> BranchPoint:
        return self.last if self.last is not None and one is self.happened[-1] else super().told(one)


_NUMBERS: tuple[tuple[BranchEvent, Callable[[RestCurve, CurvePoint], float]], ...] = (
    (BranchEvent.FOLD, lambda curve, point: float(point.tangent[-1])),
    (BranchEvent.FLIP, RestCurve.flip),
    (BranchEvent.NEIMARK_SACKER, RestCurve.pair),
)


def _follow_several(
    cycle: RestCycle, over: Varied, switch: int, points: int, most: int, halt: Callable[[], bool] | None
) -> Branch:
    curve, x = RestCurve.of(cycle, over, _LONG / (points - 1))
    with halting(halt):
        start = beginning(curve, x)
        if start is None or float(np.abs(start.x - x).max()) > _SAME:
            raise ParameterError("orbit", str(cycle), f"a cycle of the system with {over}")
        ways = both_ways(lambda point: RestWalk(curve, point, over.bounds), start, most)
    return branch_of(curve, ways, over.bounds, most, switch, halt, [])
