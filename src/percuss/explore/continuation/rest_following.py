"""Cycles with rest followed through a parameter, both ways, to where they end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.rest_branch import RestBranch, RestBranchPoint, RestEvent
from percuss.explore.continuation.rest_ends import alike, rest_end
from percuss.explore.continuation.rest_words import without_release
from percuss.explore.family import Family, SystemFamily, family_of
from percuss.explore.parameters import PARAMETERS
from percuss.halting import halting, look
from percuss.model import System
from percuss.model.checks import callback, count, finite, instance, numbers, text
from percuss.model.set_at_wall import wall_load
from percuss.steady import RestCycle
from percuss.steady.resting.chain import Chain
from percuss.steady.resting.releases import release_phases
from percuss.steady.resting.search import cycle_through

__all__ = ["follow_rest_cycle"]

_EXACT = 2e-13  # of the parameter, to which a point is located
_NEARER, _MOST_OF = 0.45, 0.9  # of what is left to where a release is lost, and a rest vanishes
_BARELY = 1e-6  # of the parameter, before the last release, where pulls are too short for the chatter to be followed
_NEXT = 2e-9  # of the parameter, before the last release, to where the last cycle is followed if it can be
_ON = "the branch goes on"
_FAR = 1e6  # times the value, or 1: the ends where no range is given


def follow_rest_cycle(
    cycle: RestCycle,
    along: str,
    between: tuple[float, float] | None = None,
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
        The range of the parameter, which must hold its value for the cycle; None to go on until the branch ends, or a
        million times as far as where it began.
    family
        The systems; None for those that differ from that of the cycle in the parameter alone.
    value
        Of the parameter, for the cycle; None for what its system says, where it is a dimensionless one.
    points
        Cycles over the whole range, at least; without a range over a stretch as long as the value. 2 to 10000.
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
    low, high = _range(between, here)
    share = 1.0 / (count("points", points, least=2, most=10_000) - 1)
    step = share * (high - low) if between is not None else share * (abs(here) or 1.0)
    walker = _Walker(systems, name, cycle, step, 0.0 if between is not None else share)
    callback("halt", halt)
    with halting(halt):
        below, first = walker.walked(here, low)
        above, last = walker.walked(here, high)
    rows = [*below[::-1], (here, cycle), *above]
    return RestBranch(name, np.array([row[0] for row in rows]), tuple(row[1] for row in rows), (first, last))


def _range(between: tuple[float, float] | None, here: float) -> tuple[float, float]:
    """The ends of the range; far away where none is given."""
    if between is None:
        far = _FAR * max(1.0, abs(here))
        return here - far, here + far
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value of the cycle")
    return float(ends[0]), float(ends[1])


@dataclass(frozen=True)
class _Walker:
    """The family, and where the walk began."""

    systems: Family
    name: str
    first: RestCycle
    step: float
    growth: float  # share of the way so far that a step may be, where the range has no ends

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
        if cycle is None or cycle.label != near.label or not alike(near.chains, cycle.chains):
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
        first, failed, gone = here, False, None
        while here != end:
            look()
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
                    return RestBranchPoint(RestEvent.RELEASE_LOST, gone, cycle, without_release(cycle))
                continue
            failed, size = True, 0.4 * abs(ahead - here)
            if gone is None and is_system and not chains:
                gone = self._release_lost(here, ahead - here)
            if size < _EXACT * scale:
                gone = self._release_lost(here, math.copysign(_BARELY * scale, end - here))
                if gone is not None:
                    return RestBranchPoint(RestEvent.RELEASE_LOST, gone, cycle, without_release(cycle))
                return rest_end(here, cycle, chains, is_system)
        return RestBranchPoint(RestEvent.LIMIT, here, cycle, _ON)

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
