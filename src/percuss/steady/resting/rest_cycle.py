"""A periodic motion that rests on the wall for a part of every cycle, as a value."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.model import System
from percuss.model.checks import Array, ComplexArray, text
from percuss.shown import Shown
from percuss.steady.resting.chain import Chain

__all__ = ["FoundRestCycles", "RestCycle"]

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class RestCycle(Shown):
    """A periodic motion with rest on the wall; made by `rest_cycles`.

    While it rests the bar forgets everything: the cycle is told by the phases of the load at which it is let go, and
    whatever disturbs it is gone after the next rest. All its multipliers are 0 (superstable). Times are in radians of
    the load's fundamental, all quantities are dimensionless. The bar has the modes 0 … N, forced part included, exactly
    as a simulation with N modes moves.

    Parameters
    ----------
    system
        What moves.
    periods
        n: load periods of the cycle.
    modes
        N.
    chains
        From each release to the next rest, in order; the first is that with the least phase of the load.
    """

    system: System
    periods: int
    modes: int
    chains: tuple[Chain, ...] = field(repr=False)

    @property
    def chatters(self) -> bool:
        """Whether infinitely many impacts pile up before a rest."""
        return any(chain.chatters for chain in self.chains)

    @property
    def label(self) -> str:
        """chatter/n, or rest/n where the bar comes to rest without chatter, as with R = 0."""
        return f"{'chatter' if self.chatters else 'rest'}/{self.periods}"

    @property
    def period(self) -> float:
        """T = 2πn."""
        return TURN * self.periods

    @property
    def times(self) -> tuple[float, ...]:
        """When the impacts are, unwrapped; of a chatter those that were followed one by one."""
        return tuple(impact.time for chain in self.chains for impact in chain.impacts)

    @property
    def phases(self) -> Array:
        """Phase of the load at each of these impacts, in [0, 2π)."""
        return np.mod(self.times, TURN)

    @property
    def speeds(self) -> Array:
        """Speed of the striking end just before each of these impacts."""
        return np.array([impact.speed for chain in self.chains for impact in chain.impacts])

    @property
    def flight_times(self) -> Array:
        """How long the bar was in the air before each of these impacts."""
        return np.concatenate([np.diff([chain.release, *(one.time for one in chain.impacts)]) for chain in self.chains])

    @property
    def release_phases(self) -> Array:
        """Phases of the load at which the bar is let go; shape (rests,)."""
        return np.mod([chain.release for chain in self.chains], TURN)

    @property
    def release_phase(self) -> float:
        """The first of them."""
        return float(self.release_phases[0])

    @property
    def rest_phases(self) -> Array:
        """Phases of the load at which the bar comes to rest after each release; shape (rests,)."""
        return np.mod(self._rests, TURN)

    @property
    def rest_phase(self) -> float:
        """The first of them."""
        return float(self.rest_phases[0])

    @property
    def _rests(self) -> Array:
        return np.array([math.nan if chain.rest is None else chain.rest for chain in self.chains])

    @property
    def rest_times(self) -> Array:
        """How long the bar lies on the wall each time; shape (rests,)."""
        first = self.chains[0].release
        ends = np.array([*(chain.release for chain in self.chains[1:]), first + self.period])
        return np.asarray(ends - self._rests)

    @property
    def multipliers(self) -> ComplexArray:
        """The multiplier of all disturbances: 0. Shape (1,)."""
        return np.zeros(1, dtype=complex)

    @property
    def stable(self) -> bool:
        """Always."""
        return True

    @property
    def admissible(self) -> bool:
        """Always: no flight that touches the wall before its impact was taken."""
        return True

    def __str__(self) -> str:
        impacts = self.speeds.size
        return (
            f"RestCycle {self.label}: release {self.release_phase:.6f}, greatest speed {self.speeds.max():.6f}, "
            f"rest from {self.rest_phase:.6f} rad, {impacts} impact{'s' if impacts != 1 else ''} followed, "
            f"{self.modes} modes"
        )


@dataclass(frozen=True)
class FoundRestCycles(Shown):
    """All cycles with rest of a system, one for each release phase at most.

    Parameters
    ----------
    system, modes, most
        What was asked: the system, N, and the most load periods of a cycle.
    cycles
        By the phase of their first release.
    releases
        All phases at which the load lets go of a bar at rest; shape (K,).
    leads_to
        Of each of them the number of the cycle, from 0, that a bar let go there ends in; −1 where it does not come back
        to a release within the load periods that were allowed, or rounding decides when. Shape (K,).
    """

    system: System
    modes: int
    most: int
    cycles: tuple[RestCycle, ...]
    releases: tuple[float, ...]
    leads_to: tuple[int, ...]

    def labelled(self, label: str) -> tuple[RestCycle, ...]:
        """Those of a label, such as chatter/1."""
        text("label", label, "chatter/n or rest/n")
        return tuple(cycle for cycle in self.cycles if cycle.label == label)

    def __str__(self) -> str:
        many, lost = len(self.releases), sum(number < 0 for number in self.leads_to)
        head = f"{len(self.cycles)} cycle{'s' if len(self.cycles) != 1 else ''} with rest from {many} release phase"
        head += "s" if many != 1 else ""
        if lost:
            head += f", {lost} without a return within {self.most} load periods"
        return "\n".join([head, *(f"  {cycle}" for cycle in self.cycles)])
