"""All cycles with rest of a system: one flight chain for each phase at which the load lets go."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from percuss.model import System
from percuss.model.checks import Array, count, instance, text
from percuss.model.system import set_at_wall
from percuss.shown import Shown
from percuss.steady.multipliers import Multipliers, Reason
from percuss.steady.resting.flight_chain import RestPath, RestSearch, Swing, release_phases, time_to_release

# ---- A periodic motion that rests on the wall for a part of every cycle, as a value

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
    chains: tuple[RestPath, ...] = field(repr=False)

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

    def multipliers(self) -> Multipliers:
        """The multipliers of all disturbances: 0."""
        return Multipliers(self.label, self.modes, np.zeros(2, dtype=complex), self.system)

    @property
    def stable(self) -> bool:
        """Always."""
        return True

    @property
    def verdict(self) -> Reason:
        """Always `Reason.STABLE`."""
        return Reason.STABLE

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


# ---- All cycles with rest of a system: one flight chain for each phase at which the load lets go

MOST_PERIODS = 256
_MOST_MODES = 4096
_MOST_RELEASES = 256
_LATER = 1e-13  # rad, by which rounding may be late
_SHORT = 9.0  # rad, of a way on which rounding cannot grow to have a say


class ReleaseToRelease(NamedTuple):
    """From one release phase until let go at one again: chains, the number of the phase at the end (−1: none), when."""

    chains: list[RestPath]
    next: int = -1
    end: float = math.inf


def way_from(
    swing: Swing, releases: tuple[float, ...], number: int, most: float, late: float = 0.0
) -> ReleaseToRelease:
    """The way from a release phase to the next; `most`: rad after which it is given up."""
    chains: list[RestPath] = []
    time = first = releases[number] + late
    while time < first + most and len(chains) < _MOST_RELEASES:
        chain = RestSearch(swing, time, first + most).chain()
        chains.append(chain)
        if chain.rest is None:
            break
        wait, following = time_to_release(swing.system.load, np.asarray(releases), chain.rest)
        time = chain.rest + wait
        if following >= 0:
            turns = round((time - releases[following]) / TURN)
            return ReleaseToRelease(chains, following, releases[following] + TURN * turns)
    return ReleaseToRelease(chains)


def _sure_way(swing: Swing, releases: tuple[float, ...], number: int, most: float) -> ReleaseToRelease:
    """… which is no return where a bar that is let go hardly later comes back at another time."""
    way = way_from(swing, releases, number, most)
    if way.next >= 0 and way.end - releases[number] < _SHORT:
        other = way_from(swing, releases, number, most, _LATER)
        return way if (other.next, other.end) == (way.next, way.end) else ReleaseToRelease(way.chains, -1, way.end)
    return way


def rest_cycles(system: System, *, modes: int = 32, most: int = 64) -> FoundRestCycles:
    """All periodic motions that rest on the wall for a part of every cycle.

    A bar that rests has forgotten how it came there, and leaves undeformed and from rest at a phase at which the load
    begins to pull. There are finitely many of these, so that following the bar from each of them to its next rest finds
    every such motion; no guess is needed, and none can be missed but those with more load periods than allowed and
    those whose length rounding decides. The bar comes to rest where infinitely many impacts have piled up in finite
    time (complete chatter), or with R = 0 at the first impact under a load that pushes. The conventions of rest and
    release are those of the simulation.

    Parameters
    ----------
    system
        The bar, its load and its contact; or a structure of one mode, of which the spring, too, presses or pulls.
    modes
        N: the bar has the modes 0 … N, in the forced part, too; a structure the modes 1 … N.
    most
        Load periods of a cycle, 1 to 256.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.
    ParameterError
        For numbers out of range; for a structure of several modes, which moves on while the wall holds its contact.

    References
    ----------
    C. Budd and F. Dux, Chattering and related behaviour in impact oscillators, Phil. Trans. R. Soc. Lond. A 347 (1994)
    365–389.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> for cycle in rest_cycles(system, modes=0).cycles:
    ...     print(cycle.label, round(cycle.release_phase, 9), round(cycle.rest_phase, 9))
    chatter/1 2.498091545 6.018157846
    """
    instance("system", system, System)
    kept = system.body.chosen(count("modes", modes, least=0, most=_MOST_MODES))
    longest = count("most", most, most=MOST_PERIODS)
    swing = Swing(set_at_wall(system, kept), kept)
    releases = tuple(float(phase) for phase in release_phases(swing.system.load))
    ways: dict[int, ReleaseToRelease] = {}
    leads_to: dict[int, int] = {-1: -1}
    cycles: list[RestCycle] = []
    for start in range(len(releases)):
        path: list[int] = []
        here = start
        while here not in leads_to and here not in path:
            path.append(here)
            ways[here] = _sure_way(swing, releases, here, TURN * longest)
            here = ways[here].next
        if here in path:
            cycle = _cycle(system, swing, releases, ways, path[path.index(here) :])
            if cycle.periods <= longest:
                cycles.append(cycle)
            found = len(cycles) - 1 if cycle.periods <= longest else -1
        else:
            found = leads_to[here]
        leads_to.update(dict.fromkeys(path, found))
    order = sorted(range(len(cycles)), key=lambda number: cycles[number].release_phase)
    place = {-1: -1} | {number: i for i, number in enumerate(order)}
    return FoundRestCycles(
        system, kept, longest, tuple(cycles[number] for number in order), releases,
        tuple(place[leads_to[number]] for number in range(len(releases))),
    )  # fmt: skip


def _cycle(
    system: System, swing: Swing, releases: tuple[float, ...], ways: dict[int, ReleaseToRelease], numbers: list[int]
) -> RestCycle:
    first = numbers.index(min(numbers))
    chains: list[RestPath] = []
    late = 0.0
    for number in numbers[first:] + numbers[:first]:
        way = ways[number]
        for chain in way.chains:  # so much later
            moved = tuple(impact._replace(time=impact.time + late) for impact in chain.impacts)
            rest = None if chain.rest is None else chain.rest + late
            chains.append(RestPath(chain.release + late, moved, rest, chain.chatters, chain.stop + late))
        late += way.end - releases[way.next]
    return RestCycle(system, round(late / TURN), swing.modes, tuple(chains))


def cycle_through(
    system: System, release: float, *, modes: int, most: int
) -> tuple[RestCycle | None, tuple[RestPath, ...], float | None]:
    """The cycle through the release phase nearest to the given one, or None; all chains, and that phase."""
    swing = Swing(set_at_wall(system, modes), modes)
    releases = tuple(float(phase) for phase in release_phases(swing.system.load))
    if not releases:
        return None, (), None
    off = np.abs(np.mod(np.asarray(releases) - release + math.pi, TURN) - math.pi)
    start = here = int(np.argmin(off))
    ways: dict[int, ReleaseToRelease] = {}
    path: list[int] = []
    late = 0.0
    while here >= 0 and here not in path and late < TURN * most:
        path.append(here)
        ways[here] = way_from(swing, releases, here, TURN * most)
        late += ways[here].end - releases[here]
        here = ways[here].next
    chains = tuple(chain for number in path for chain in ways[number].chains)
    closed = here == start and late < TURN * (most + 0.5)
    return (_cycle(system, swing, releases, ways, path) if closed else None), chains, releases[start]
