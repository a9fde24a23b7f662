"""Cycles with rest followed through a parameter, both ways, to where they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import KEPT_IMPACTS, Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.walk import Varied
from percuss.explore.family import Family
from percuss.halting import check_interrupted, halting
from percuss.model.checks import Array, ComplexArray
from percuss.model.contact.falling_push import FallingPush
from percuss.model.system import wall_load
from percuss.steady import RestCycle
from percuss.steady.multipliers import TURNING
from percuss.steady.resting.flight_chain import RestPath, release_phases
from percuss.steady.resting.rest_cycles import cycle_near, cycle_through, lying_between
from percuss.steady.resting.rest_map import Lying

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
_FOLDS = 0.05  # from 1, of a multiplier beyond whose point no cycle is found
_HALVINGS, _SAME = 40, 1e-8  # to a point between two others, and share of their distance that those of a pair are off
_REACH = 0.03  # rad, and of the shape, by which a rest may be off where it was expected
_FEW = 1e-3  # of the greatest speed: slower impacts belong to the chatter


def rest_end(value: float, cycle: RestCycle, chains: tuple[RestPath, ...], is_system: bool) -> BranchPoint:
    """What ends the branch between a cycle and what was followed just beyond."""
    phase, impact, several = None, None, cycle.is_several
    waits = [np.mod(after.release - (one.rest or math.nan), 2.0 * math.pi) for one, after in pairwise(chains)]
    vanishes = float(cycle.rest_times.min()) < short_rest(cycle)
    if not is_system:
        kind, beyond = BranchEvent.NO_SYSTEM, "there is no such system"
    elif any(abs(one - 1.0) < _FOLDS for one in cycle.remembered):
        kind, beyond = BranchEvent.FOLD, f"another cycle {cycle.label} meets this one, and there is none beyond"
    elif not chains and not (several and vanishes):
        kind, beyond = BranchEvent.RELEASE_LOST, without_release(cycle)
    elif (other := _first_other(cycle.chains, chains)) is not None:
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
    return BranchPoint(kind, (value,), cycle, beyond, multipliers_of(cycle), impact, phase)


def multipliers_of(cycle: RestCycle) -> ComplexArray | None:
    """Those of what its rests do not forget, for a point of a branch; None where they forget everything."""
    return np.array(cycle.remembered) if cycle.remembered else None


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


def follow_rest(cycle: RestCycle, over: Varied, *, points: int = 65, halt: Callable[[], bool] | None = None) -> Branch:
    """The branch of a cycle with rest; see `percuss.explore.follow`."""
    # It goes on while the same impacts follow and the bar rests before the load pulls again: all multipliers are 0, or
    # of a structure of several modes those of a map of which it is a fixed point, up to a fold.
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
        inner = []
        with suppress(Interrupted):
            inner = [point for pair in pairwise(rows) for point in walker.crossings(*pair)]
    what = ends[0], *inner, ends[1]
    return _branch(walker.name, np.array([row[0] for row in rows]), tuple(row[1] for row in rows), what)


def _branch(name: str, values: Array, cycles: tuple[RestCycle, ...], points: tuple[BranchPoint, ...]) -> Branch:
    """The cycles with the first impacts after each of their releases."""
    times, speeds = np.full((2, len(cycles), len(cycles[0].chains), KEPT_IMPACTS), np.nan)
    for i, cycle in enumerate(cycles):
        for flight, chain in enumerate(cycle.chains):
            kept = np.array(chain.impacts[:KEPT_IMPACTS]).reshape(-1, 2)
            times[i, flight, : len(kept)], speeds[i, flight, : len(kept)] = kept.T
    most = int(np.isfinite(times).sum(axis=-1).max())
    return Branch(
        parameters=(name,), label=cycles[0].label, modes=cycles[0].modes, values=values, points=points,
        times=times[..., :most], speeds=speeds[..., :most],
        unstable=np.array([_outside(cycle) for cycle in cycles], dtype=np.int64),
        releases=np.array([[chain.release for chain in cycle.chains] for cycle in cycles]),
        rests=np.array([[chain.rest for chain in cycle.chains] for cycle in cycles], dtype=float), motions=cycles,
    )  # fmt: skip


def _outside(cycle: RestCycle) -> int:
    """How many multipliers are outside the unit circle."""
    return sum(abs(one) > 1.0 for one in cycle.remembered)


@dataclass(frozen=True)
class _Walker:
    """The family, and where the walk began."""

    systems: Family
    name: str
    first: RestCycle
    step: float
    growth: float  # share of the way so far that a step may be, where the range has no ends

    def at(
        self, value: float, near: RestCycle, lying: Lying | None = None
    ) -> tuple[RestCycle | None, tuple[RestPath, ...], bool]:
        """The cycle at a value that goes on from one beside it, what was followed, and whether there is a system.

        `lying`: where a structure of several modes should come to rest.
        """
        try:
            system = self.systems.system({self.name: value})
            if near.is_several:
                last = near.lying[-1]
                begin = last if lying is None else lying
                moved = abs(math.remainder(begin.time - last.time, 2.0 * math.pi))
                cycle, chains = cycle_near(system, near, begin, max(_REACH, 0.5 * moved))
                same = cycle is not None and cycle.label == near.label
                return (cycle, chains, True) if same else (None, chains, True)
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
            lying = None
            if cycle.is_several and len(rows) > 1:
                (before, earlier), _ = rows[-2:]
                lying = lying_between(cycle, earlier, (ahead - here) / (before - here))
            found, chains, is_system = self.at(ahead, cycle, lying)
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
                return rest_end(here, cycle, chains, is_system)
        return BranchPoint(BranchEvent.LIMIT, (here,), cycle, _ON)

    def crossings(self, one: tuple[float, RestCycle], other: tuple[float, RestCycle]) -> list[BranchPoint]:
        """Where multipliers pass through the unit circle between two points."""
        (low, cycle), (high, after) = one, other
        counts, found = sorted((_outside(cycle), _outside(after))), list[BranchPoint]()

        def beside(at: float) -> RestCycle | None:
            return self.at(at, cycle, lying_between(cycle, after, (at - low) / (high - low)))[0]

        for place in range(*counts):

            def beyond(values: Array, place: int = place) -> Array:
                there = [beside(at) for at in values.tolist()]
                return np.array([math.nan if here is None else abs(here.remembered[place]) - 1.0 for here in there])

            first, last = (np.array([abs(here.remembered[place]) - 1.0]) for here in (cycle, after))
            value = float(bracketed_roots(beyond, np.array([low]), np.array([high]), first, last, _HALVINGS)[0])
            there = beside(value)
            if there is None or (found and abs(found[-1].value - value) < _SAME * abs(high - low)):
                continue  # the other one of a pair
            passes = there.remembered[place]
            kind = BranchEvent.FLIP if passes.real < 0.0 else BranchEvent.CROSSING
            kind = BranchEvent.NEIMARK_SACKER if abs(passes.imag) > TURNING else kind
            found.append(BranchPoint(kind, (value,), there, kind.words, multipliers_of(there)))
        return sorted(found, key=lambda point: point.value)

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
