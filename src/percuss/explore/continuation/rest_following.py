"""Cycles with rest followed through a parameter, both ways, to where they end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.rest_branch import RestBranch, RestBranchPoint, RestEvent
from percuss.explore.continuation.rest_words import (
    after_change,
    after_grazing,
    after_onset,
    another_rest,
    without_release,
)
from percuss.explore.family import Family, SystemFamily, family_of
from percuss.explore.parameters import PARAMETERS
from percuss.halting import halting, look
from percuss.model import System
from percuss.model.checks import callback, count, finite, instance, numbers, text
from percuss.model.contact.falling_push import FallingPush
from percuss.model.set_at_wall import wall_load
from percuss.steady import RestCycle
from percuss.steady.resting.chain import Chain
from percuss.steady.resting.releases import release_phases
from percuss.steady.resting.search import cycle_through

__all__ = ["follow_rest_cycle", "short_rest"]

_EXACT = 2e-13  # of the parameter, to which a point is located
_JUMP = 1.4  # factor by which a flight may change in a step
_AHEAD = 1.5
_SHORT = 1e-2  # rad of rest below which the rest is about to vanish
_BARELY = 1e-6  # of the parameter, before the last release, where pulls are too short for the chatter to be followed
_ON = "the branch goes on"
_FEW = 1e-3  # of the greatest speed: slower impacts belong to the chatter


def follow_rest_cycle(
    cycle: RestCycle,
    along: str,
    between: tuple[float, float],
    *,
    family: System | Family | None = None,
    value: float | None = None,
    points: int = 65,
    halt: Callable[[], bool] | None = None,
) -> RestBranch:
    """Follow a cycle with rest through a parameter, both ways, until it ends.

    All its multipliers are 0, so that it goes on for as long as the same impacts follow the release and the bar comes
    to rest before the load pulls again. Where it ends is located to 1e-10 and said: the end of its chatter meets the
    next release (onset), the bar touches the wall in a flight or an impact dies, the load no longer lets go.

    Parameters
    ----------
    cycle
        Where to begin.
    along
        Name of the parameter; of `percuss.explore.PARAMETERS`, or of the family.
    between
        The range of the parameter, which must hold its value for the cycle.
    family
        The systems; None for those that differ from that of the cycle in the parameter alone.
    value
        Of the parameter, for the cycle; None for what its system says, where it is a dimensionless one.
    points
        Cycles over the whole range, at least; 2 to 10000.
    halt
        Called again and again; once it returns true, what has been followed so far is the answer.

    Returns
    -------
    RestBranch
        The cycles, and what happens at its two ends.

    Raises
    ------
    ParameterError
        For an unknown parameter, and for a range without the cycle.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import rest_cycles
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> (cycle,) = rest_cycles(system, modes=0).cycles
    >>> branch = follow_rest_cycle(cycle, "mean", (0.3, 1.2), points=9)
    >>> for point in branch.points:
    ...     print(point.kind.value, round(point.value, 9))
    onset 0.626037332
    release_lost 1.0
    """
    instance("cycle", cycle, RestCycle)
    systems = SystemFamily(cycle.system) if family is None else family_of(family)
    name = text("along", along, "the name of a parameter")
    systems.check({name: getattr(systems, "units", {}).get(name, "")})
    known = PARAMETERS[name].get(cycle.system) if name in PARAMETERS else None
    if value is None and known is None:
        raise ParameterError("value", None, f"the value of {name} that belongs to the cycle")
    here = finite("value", known if value is None else value)
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value of the cycle")
    step = float(ends[1] - ends[0]) / (count("points", points, least=2, most=10_000) - 1)
    walker = _Walker(systems, name, cycle, step)
    callback("halt", halt)
    with halting(halt):
        below, first = walker.walked(here, float(ends[0]))
        above, last = walker.walked(here, float(ends[1]))
    rows = [*below[::-1], (here, cycle), *above]
    return RestBranch(name, np.array([row[0] for row in rows]), tuple(row[1] for row in rows), (first, last))


@dataclass(frozen=True)
class _Walker:
    """The family, and where the walk began."""

    systems: Family
    name: str
    first: RestCycle
    step: float

    def at(self, value: float, near: RestCycle) -> tuple[RestCycle | None, tuple[Chain, ...], bool]:
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
        if cycle is None or cycle.label != near.label or not _alike(near.chains, cycle.chains):
            return None, chains, True
        return cycle, chains if release is not None else (), True

    def walked(self, start: float, end: float) -> tuple[list[tuple[float, RestCycle]], RestBranchPoint]:
        """The cycles from a value towards an end of the range, and the point at which they end."""
        rows = [(start, self.first)]
        try:
            point = self._walked(rows, end)
        except Interrupted:
            point = RestBranchPoint(RestEvent.STOPPED, *rows[-1], _ON)
        return rows[1:], point

    def _walked(self, rows: list[tuple[float, RestCycle]], end: float) -> RestBranchPoint:
        """… which are added to the one where the walk begins, for as long as nothing stops it."""
        (here, cycle), size = rows[-1], self.step
        while here != end:
            look()
            last = abs(end - here) <= 1.5 * size
            ahead = end if last else here + math.copysign(size, end - here)
            found, chains, is_system = self.at(ahead, cycle)
            if found is not None:
                here, cycle, size = ahead, found, min(1.5 * size, self.step)
                rows.append((here, cycle))
                continue
            size = 0.4 * min(size, abs(end - here))
            if size < _EXACT * max(1.0, abs(here)):
                gone = self._release_lost(here, math.copysign(_BARELY * max(1.0, abs(here)), end - here))
                if gone is not None:
                    return RestBranchPoint(RestEvent.RELEASE_LOST, gone, cycle, without_release(cycle))
                return self._end(here, cycle, chains, is_system)
        return RestBranchPoint(RestEvent.LIMIT, here, cycle, _ON)

    def _release_lost(self, value: float, ahead: float) -> float | None:
        """Where the load ceases to let go, if that is hardly beyond a value: pulls move the bar by rounding there."""

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

    def _end(self, value: float, cycle: RestCycle, chains: tuple[Chain, ...], is_system: bool) -> RestBranchPoint:
        """What ends the branch between a cycle and what was followed just beyond."""
        if not is_system:
            return RestBranchPoint(RestEvent.NO_SYSTEM, value, cycle, "there is no such system")
        if not chains:
            return RestBranchPoint(RestEvent.RELEASE_LOST, value, cycle, without_release(cycle))
        other = _first_other(cycle.chains, chains)
        if other is not None:
            kind, phase, impact = other
            told = after_grazing(cycle, kind is RestEvent.TOUCH)
            return RestBranchPoint(kind, value, cycle, told, phase, impact)
        if float(cycle.rest_times.min()) < short_rest(cycle):
            return RestBranchPoint(RestEvent.ONSET, value, cycle, after_onset(cycle))
        waits = [np.mod(after.release - (one.rest or math.nan), 2.0 * math.pi) for one, after in pairwise(chains)]
        if waits and float(np.nanmin([*waits, math.inf])) < _SHORT:
            return RestBranchPoint(RestEvent.ONSET, value, cycle, another_rest(cycle))
        return RestBranchPoint(RestEvent.CHANGE, value, cycle, after_change(cycle, chains))


def short_rest(cycle: RestCycle) -> float:
    """The rest, in rad of the load, below which the rest of a cycle is about to vanish.

    By a law that turns the strain over the bar is held 1/(2c) contacts before the load lets go: see `FallingPush`.
    """
    contact, restitution = cycle.system.contact, -cycle.system.contact.velocity_factor
    if contact.keeps_strain or not 0.0 < restitution < 1.0:
        return _SHORT
    return max(_SHORT, _AHEAD * cycle.system.body.transit_time / FallingPush(restitution).critical)


def _alike(chains: tuple[Chain, ...], others: tuple[Chain, ...]) -> bool:
    """Whether the same impacts follow each release, so that the second chains go on from the first ones."""
    return len(chains) == len(others) and _first_other(chains, others) is None


def _first_other(chains: tuple[Chain, ...], others: tuple[Chain, ...]) -> tuple[RestEvent, float, int] | None:
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
                kind = RestEvent.TOUCH if touch else RestEvent.DEATH
                return kind, float(np.mod(where, 2.0 * math.pi)), before + number
            last, its_last = mine.time, its.time
        before += len(one.impacts)
    return None


def _notable(chain: Chain) -> int:
    """How many impacts there are up to the last that is not of the end of a chatter."""
    fastest = max(impact.speed for impact in chain.impacts)
    return max(i for i, impact in enumerate(chain.impacts, 1) if impact.speed >= _FEW * fastest)
