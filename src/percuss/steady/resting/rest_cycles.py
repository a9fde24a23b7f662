"""All cycles with rest of a system: one flight chain for each phase at which the load lets go."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.mechanics.held_structure import HeldStructure, held_structure
from percuss.model import System
from percuss.model.checks import DEFAULT_MODES, Array, array, count, instance, text
from percuss.model.load import Side
from percuss.model.system import set_at_wall
from percuss.steady.flight import Energy, Stretch, damped, deepest
from percuss.steady.multipliers import FoundMotions, Multipliers, Repeating
from percuss.steady.resting.flight_chain import (
    ForcedResponse,
    GapState,
    RestPath,
    RestSearch,
    release_phases,
    time_to_release,
)
from percuss.steady.resting.rest_map import FixedRests, Lying, begins, closed_near, next_rest

# ---- A periodic motion that rests on the wall for a part of every cycle, as a value

TURN = 2.0 * math.pi


@dataclass(frozen=True)
class RestCycle(Repeating):
    """A periodic motion with rest on the wall; made by `rest_cycles`.

    While it rests the bar forgets everything: the cycle is told by the phases of the load at which it is let go, and
    whatever disturbs it is gone after the next rest. All its multipliers are 0 (superstable); but a bar that its
    ringing lays down under a load that pulls is let go at once, and where it is nowhere held the phase is not
    forgotten. Nor do the several modes of a structure forget the shape and the phase in which they come to rest: of
    the 2N multipliers N are 0. Times are in radians of the load's fundamental, all quantities are dimensionless. The
    bar has the modes 0 … N, forced part included, exactly as a simulation with N modes moves.

    Parameters
    ----------
    periods
        n: load periods of the cycle.
    modes
        N.
    chains
        From each release to the next rest, in order; the first is that with the least phase of the load.
    remembered
        The multipliers of what the rests do not forget, the greatest first: none where the load holds the bar; of one
        that is let go at once what a cycle leaves of a small change of the phase; N of a structure of several modes.
    """

    system: System
    periods: int
    modes: int
    chains: tuple[RestPath, ...] = field(repr=False)
    remembered: tuple[complex, ...] = ()

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
    def rests(self) -> bool:
        """Always."""
        return True

    @property
    def is_several(self) -> bool:
        """Whether several modes of a structure move on while it rests, and remember."""
        return not self.system.body.is_free and self.modes > 1

    @property
    def lying(self) -> tuple[Lying, ...]:
        """When it comes to rest, and in which shape, after each release."""
        return tuple(Lying(chain.rest or math.nan, chain.shape) for chain in self.chains)

    # -- the motion between release and rest, followed again --

    @cached_property
    def _searches(self) -> tuple[RestSearch, ...]:
        swing = ForcedResponse(set_at_wall(self.system, self.modes), self.modes)
        found = tuple(RestSearch(swing, chain.release, chain.stop + TURN, chain.begun) for chain in self.chains)
        for search in found:
            search.chain()
        return found

    def motion(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) at times after the first release: 0 at rest and at impacts, negative between.

        What is left of a chatter that was summed is taken for rest. Shape (len(t),).
        """
        times, first = np.mod(array("t", t, -np.inf, np.inf), self.period), self.chains[0].release
        found = np.zeros_like(times)
        for leg, duration, _ in (one for search in self._searches for one in search.flown):
            since = np.mod(times - (leg.time - first), self.period)
            here = since < duration
            found[here] = leg.gap(since[here])[0] if here.any() else 0.0
        return found

    @property
    def stroke(self) -> float:
        """Range of the striking end's position."""
        swing = self._searches[0].swing
        fastest = max(1.0, *swing.known.omega[-1:].tolist(), *swing.harmonics[-1:].tolist())
        flown = (one for search in self._searches for one in search.flown)
        return max(deepest(leg.gap, duration, fastest) for leg, duration, _ in flown)

    # -- as every motion: the bounces of a chatter are no blows --

    @property
    def impacts(self) -> int:
        """Blows in a cycle, without the bounces of a chatter: the ever shorter flights before its end."""
        return sum(map(_blows, self.chains))

    @cached_property
    def _struck(self) -> list[list[GapState]]:
        """The motion just before each impact, of each chain."""
        return [[leg.at(time) for leg, time, struck in search.flown if struck] for search in self._searches]

    @cached_property
    def _strongest(self) -> tuple[float, GapState]:
        """The strongest blow: when, and the motion just before it."""
        number = int(np.argmax(self.speeds))
        return self.times[number], [one for chain in self._struck for one in chain][number]

    def _energies(self, motion: GapState) -> tuple[float, float]:
        """Kinetic and strain energy."""
        known = self._searches[0].swing.known
        kinetic = 0.5 * motion.rigid**2 + 0.5 * float(motion.velocity**2 @ known.inertia)
        return kinetic, 0.5 * float((known.omega * motion.displacement) ** 2 @ known.inertia)

    @property
    def phase(self) -> float:
        """Phase of the load at the strongest blow."""
        return float(np.mod(self._strongest[0], TURN))

    @property
    def impact_velocity(self) -> float:
        """Greatest of the speeds."""
        return float(self.speeds.max())

    @property
    def rigid_velocity(self) -> float:
        """Mean velocity of the bar just before the strongest blow."""
        return self._strongest[1].rigid

    @property
    def blow_energy(self) -> float:
        """Mean over the blows."""
        blows = (
            one for chain, struck in zip(self.chains, self._struck, strict=True) for one in struck[: _blows(chain)]
        )
        return float(np.mean([self._energies(one)[0] for one in blows]))

    @property
    def delivered_energy(self) -> float:
        """What impacts and rests take in a cycle, for each blow."""
        return self.energy.impact / self.impacts

    @cached_property
    def energy(self) -> Energy:
        """Energy over the cycle: put in by the load, taken by damping and by impacts and rests."""
        law = self.system.contact
        taken = [law.energy_taken(*self._energies(one)) for chain in self._struck for one in chain]
        swing = self._searches[0].swing
        left = [self._energies(search.leg.start) for search in self._searches]  # when it lies down
        taken += [kinetic if swing.is_several else kinetic + strain for kinetic, strain in left]
        flown = (one for search in self._searches for one in search.flown)
        stretches = [Stretch(leg.time, time, leg.rates) for leg, time, _ in flown]
        if swing.is_several:
            held = held_structure(swing.system, self.modes)
            stretches += map(partial(_while_held, held), self.chains, self.rest_times.tolist())
        lost = damped(self.system, swing.known.inertia, stretches)
        return Energy(math.fsum(taken) + lost, lost, math.fsum(taken))

    def _multipliers(self, side: Side) -> Multipliers:
        zeros = max(2 - len(self.remembered), len(self.remembered))
        return Multipliers(self.label, self.modes, np.append(self.remembered, np.zeros(zeros, complex)), self.system)

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


def _while_held(held: HeldStructure, chain: RestPath, lasts: float) -> Stretch:
    """A structure of several modes while the wall holds its contact, as a stretch of its motion."""
    lying = Lying(chain.rest or math.nan, chain.shape)

    def rates(t: Array) -> Array:
        return np.vstack([np.zeros(t.size), held.after(*begins(held, lying), t)[1]])

    return Stretch(lying.time, lasts, rates)


def _blows(chain: RestPath) -> int:
    """How many impacts there are up to the blow that a chatter begins with; all of them without one."""
    number = len(chain.impacts)
    flights = np.diff([chain.release, *(impact.time for impact in chain.impacts)])
    while chain.chatters and number > 1 and flights[number - 1] < flights[number - 2]:
        number -= 1
    return number


@dataclass(frozen=True)
class FoundRestCycles(FoundMotions):
    """The cycles with rest of a system, one for each release phase at most.

    Parameters
    ----------
    system, modes, most
        What was asked: the system, N, and the most load periods of a cycle.
    orbits
        The cycles, by the phase of their first release.
    releases
        All phases at which the load lets go of a bar at rest; shape (K,).
    leads_to
        Of each of them the number of the cycle, from 0, that a bar let go there ends in; −1 where it comes to none
        within the load periods that were allowed, or rounding decides when. Shape (K,).
    rests
        Of a structure of several modes, which is let go at any phase: from how many rests the cycles were looked for.
    """

    system: System
    modes: int
    most: int
    orbits: tuple[RestCycle, ...]
    releases: tuple[float, ...]
    leads_to: tuple[int, ...]
    rests: int = 0

    @property
    def complete(self) -> bool:
        """Whether none can be missed, of so many load periods, but those whose length rounding decides."""
        return not self.rests

    def labelled(self, label: str) -> tuple[RestCycle, ...]:
        """Those of a label, such as chatter/1."""
        text("label", label, "chatter/n or rest/n")
        return tuple(cycle for cycle in self.orbits if cycle.label == label)

    def __str__(self) -> str:
        many, lost = self.rests or len(self.releases), sum(number < 0 for number in self.leads_to)
        head = f"{len(self)} cycle{'s' if len(self) != 1 else ''} with rest from {many} "
        head += "rest" if self.rests else "release phase"
        head += "s" if many != 1 else ""
        if lost:
            head += f", {lost} without a return within {self.most} load periods"
        return "\n".join([head, *(f"  {cycle}" for cycle in self)])


# ---- All cycles with rest of a system: one flight chain for each phase at which the load lets go

MOST_PERIODS = 256
_MOST_MODES = 4096
_MOST_RELEASES = 256
_LATER = 1e-13  # rad, by which rounding may be late
_SETTLING = 64.0 * TURN
_AT_ONCE = 16  # times that a bar is let go at once in a cycle in which no load holds it
_AGAIN, _NEARLY = 1e-6, 1e-2  # rad, by which the phase of such a release comes back when its cycle is solved for
_MOVED, _SETTLED, _STEPS = 3e-6, 1e-11, 12  # rad, for slopes and at the end, and steps of Newton's method
_SHORT = 9.0  # rad, of a way on which rounding cannot grow to have a say


class ReleaseToRelease(NamedTuple):
    """From one release phase until let go at one again: chains, the number of the phase at the end (−1: none), when."""

    chains: list[RestPath]
    next: int = -1
    end: float = math.inf


def way_from(
    swing: ForcedResponse, releases: tuple[float, ...], number: int, most: float, late: float = 0.0
) -> ReleaseToRelease:
    """The way from a release phase to the next; `most`: rad after which it is given up."""
    chains: list[RestPath] = []
    time = first = releases[number] + late
    end = first + most
    while time < end and len(chains) < _MOST_RELEASES:
        chain = RestSearch(swing, time, end).chain()
        chains.append(chain)
        if chain.rest is None:
            break
        wait, following = time_to_release(swing.system.load, np.asarray(releases), chain.rest)
        time = chain.rest + wait
        if following >= 0 and time < first + most + TURN:
            turns = round((time - releases[following]) / TURN)
            return ReleaseToRelease(chains, following, releases[following] + TURN * turns)
        if following >= 0 or any(near < _AGAIN for _, near in _again(chains)):
            break
        end = max(end, first + _SETTLING)  # what is let go at once may take long to settle
    return ReleaseToRelease(chains)


def _sure_way(swing: ForcedResponse, releases: tuple[float, ...], number: int, most: float) -> ReleaseToRelease:
    """… which is no return where a bar that is let go hardly later comes back at another time."""
    way = way_from(swing, releases, number, most)
    if way.next >= 0 and way.end - releases[number] < _SHORT:
        other = way_from(swing, releases, number, most, _LATER)
        return way if (other.next, other.end) == (way.next, way.end) else ReleaseToRelease(way.chains, -1, way.end)
    return way


def rest_cycles(system: System, *, modes: int = DEFAULT_MODES, most: int = 64) -> FoundRestCycles:
    """The periodic motions that come to rest on the wall in every cycle.

    A bar that rests has forgotten how it came there, and leaves undeformed and from rest at a phase at which the load
    begins to pull. There are finitely many of these, so that following the bar from each of them to its next rest finds
    every such motion; no guess is needed, and none can be missed but those with more load periods than allowed and
    those whose length rounding decides. The bar comes to rest where infinitely many impacts have piled up in finite
    time (complete chatter), or with R = 0 at the first impact under a load that pushes. The conventions of rest and
    release are those of the simulation. Where the ringing of an elastic bar lays it down while the load pulls it is let
    go at once, at any phase: if that happens in every cycle and no load ever holds it, the cycle to which the motion
    from a release phase comes is solved for, and has a multiplier.

    A structure of one mode does as a bar does, but that its spring, too, presses or pulls. Of several modes those that
    are left move on while the wall holds the contact, and remember: its cycles are fixed points of a map from rest to
    rest (theory, Structures that are held). They are looked for from rests in the shapes in which the load bends the
    structure at some phases, on the way from rest to rest, and solved for by Newton's method where that nearly comes
    back; stable and unstable ones are found so, and some may be missed.

    Parameters
    ----------
    system
        The bar or the structure, its load and its contact.
    modes
        N: the bar has the modes 0 … N, in the forced part, too; a structure the modes 1 … N.
    most
        Load periods of a cycle, 1 to 256.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.
    ParameterError
        For numbers out of range.

    References
    ----------
    C. Budd and F. Dux, Chattering and related behaviour in impact oscillators, Phil. Trans. R. Soc. Lond. A 347 (1994)
    365–389.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> for cycle in rest_cycles(system, modes=0):
    ...     print(cycle.label, round(cycle.release_phase, 9), round(cycle.rest_phase, 9))
    chatter/1 2.498091545 6.018157846
    """
    instance("system", system, System)
    kept = system.body.chosen(count("modes", modes, least=0, most=_MOST_MODES))
    longest = count("most", most, most=MOST_PERIODS)
    swing = ForcedResponse(set_at_wall(system, kept), kept)
    if swing.is_several:
        return _of_several_modes(system, swing, longest)
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
        cycle = None
        if here in path:
            cycle = _cycle(system, swing, releases, ways, path[path.index(here) :])
        elif here < 0 and path and ways[path[-1]].end == math.inf:
            cycle = _let_go_at_once(system, swing, ways[path[-1]].chains)
        found = leads_to[here] if here not in path else -1
        if cycle is not None and cycle.periods <= longest:
            found = next((i for i, one in enumerate(cycles) if _is_same(one, cycle)), len(cycles))
            cycles[found:] = cycles[found:] or [cycle]
        leads_to.update(dict.fromkeys(path, found))
    order = sorted(range(len(cycles)), key=lambda number: cycles[number].release_phase)
    place = {-1: -1} | {number: i for i, number in enumerate(order)}
    return FoundRestCycles(
        system, kept, longest, tuple(cycles[number] for number in order), releases,
        tuple(place[leads_to[number]] for number in range(len(releases))),
    )  # fmt: skip


def _again(chains: Sequence[RestPath]) -> list[tuple[int, float]]:
    """How near the phase of the last release at once comes to each before it, and after how many chains."""
    ends = np.array([math.nan if chain.rest is None else chain.rest for chain in chains[-_AT_ONCE - 1 :]])
    off = np.abs(np.mod(ends[-1] - ends[-2::-1] + math.pi, TURN) - math.pi)
    return [(number, near) for number, near in enumerate(off.tolist(), 1) if near < _NEARLY]


def _let_go_at_once(system: System, swing: ForcedResponse, chains: Sequence[RestPath]) -> RestCycle | None:
    """The cycle that chains settle on whose bar is laid down under a load that pulls, each time, and let go at once."""
    for number, _ in _again(chains):
        periods = round((chains[-1].stop - chains[-1 - number].stop) / TURN)
        cycle = _at_once(system, swing, chains[-1].stop, number, periods)
        if cycle is not None:
            return cycle
    return None


def _at_once(system: System, swing: ForcedResponse, release: float, number: int, periods: int) -> RestCycle | None:
    """The cycle of so many chains, the bar let go at once after each, near the phase of a release."""

    def way(time: float) -> list[RestPath]:
        found, stop = list[RestPath](), time + TURN * (periods + 1)
        while len(found) < number and (not found or found[-1].rest is not None):
            found.append(RestSearch(swing, found[-1].stop if found else time, stop).chain())
        return found

    def late(time: float) -> float:
        chains = way(time)
        pulled = all(one.rest is not None and float(swing.system.load.value(one.rest)) < 0.0 for one in chains)
        return chains[-1].stop - time - TURN * periods if pulled else math.nan

    time, slope, step = release, 0.0, math.inf
    for _ in range(_STEPS):
        off, slope = late(time), (late(time + _MOVED) - late(time - _MOVED)) / (2.0 * _MOVED)
        if not abs(off) <= _NEARLY or slope == 0.0 or abs(step) <= _SETTLED:
            break
        step = -off / slope
        time += step
    if not abs(step) <= _SETTLED:
        return None
    first = min(float(np.mod(chain.release, TURN)) for chain in way(time))
    return RestCycle(system, periods, swing.modes, tuple(way(first)), (1.0 + slope,))


def _is_same(one: RestCycle, other: RestCycle) -> bool:
    return one.label == other.label and abs(one.release_phase - other.release_phase) < _AGAIN


def _cycle(
    system: System,
    swing: ForcedResponse,
    releases: tuple[float, ...],
    ways: dict[int, ReleaseToRelease],
    numbers: list[int],
) -> RestCycle:
    first = numbers.index(min(numbers))
    chains: list[RestPath] = []
    late = 0.0
    for number in numbers[first:] + numbers[:first]:
        way = ways[number]
        chains += [chain.later(late) for chain in way.chains]
        late += way.end - releases[way.next]
    return RestCycle(system, round(late / TURN), swing.modes, tuple(chains))


# ---- … of a structure of several modes: fixed points of its map from rest to rest

_STARTS, _SETTLES = 8, 16  # and load periods for which the way from each start is followed, or `most`
_MOST_RESTS, _LONGEST, _MOST_TRIES = 24, 8, 4  # on that way; of a cycle; and of Newton's method
_COMES_BACK, _COULD = 1e-2, 0.5  # of the shape, and rad: by how much the rests may be off where a cycle is solved for


def _of_several_modes(system: System, swing: ForcedResponse, longest: int) -> FoundRestCycles:
    held, cycles = held_structure(swing.system, swing.modes), list[RestCycle]()
    for number in range(_STARTS):
        phase = TURN * number / _STARTS
        bent = float(system.load.value(phase)) if number % 2 else system.load.mean
        for cycle in _from_rest(system, swing, Lying(phase, held.still(bent) / held.basis[0]), longest, cycles):
            if cycle.periods <= longest and not any(_is_same(one, cycle) for one in cycles):
                cycles.append(cycle)
    cycles.sort(key=lambda cycle: (cycle.periods, cycle.release_phase))
    return FoundRestCycles(system, swing.modes, longest, tuple(cycles), (), (), _STARTS)


def _from_rest(
    system: System, swing: ForcedResponse, lying: Lying, longest: int, known: list[RestCycle]
) -> Iterator[RestCycle]:
    """The cycles near the way of a structure from a rest on, up to that to which it comes."""
    been, tries, stop, off = [lying], 0, lying.time + TURN * max(longest, _SETTLES), partial(_off, swing)
    while len(been) <= _MOST_RESTS and tries < _MOST_TRIES:
        way = next_rest(swing, been[-1], stop)
        if way is None or way.path.rest is None:
            return
        been.append(way.end)
        if any(off(one, way.end) < _AGAIN for cycle in known for one in cycle.lying):
            return
        for rests in range(1, min(len(been), _LONGEST + 1)):
            near = off(been[-1 - rests], way.end)
            periods = round((way.end.time - been[-1 - rests].time) / TURN)
            if periods < 1 or not (near < _COMES_BACK or (rests <= 2 and near < _COULD)):
                continue
            tries += 1
            fixed = closed_near(swing, way.end, rests, periods)
            if fixed is None or any(off(fixed.ways[0].begin, one.end) < _AGAIN for one in fixed.ways[:-1]):
                continue
            yield cycle_of_rests(system, swing, fixed)
            if near < _COMES_BACK and off(fixed.ways[0].begin, way.end) < _COMES_BACK:
                return
            break


def _off(swing: ForcedResponse, one: Lying, other: Lying) -> float:
    """By how much two rests are off, of the shape, and in rad of the load."""
    time, root = abs(math.remainder(other.time - one.time, TURN)), np.sqrt(swing.known.inertia)
    size = max(float(np.abs(root * shape).max()) for shape in (one.shape, other.shape))
    return max(time, float(np.abs(root * (other.shape - one.shape)).max()) / max(size, 1e-300))


def cycle_of_rests(system: System, swing: ForcedResponse, fixed: FixedRests) -> RestCycle:
    """The cycle of a fixed point, from the release with the least phase on."""
    chains = [way.path for way in fixed.ways]
    first = int(np.argmin([np.mod(chain.release, TURN) for chain in chains]))
    periods = round((fixed.ways[-1].end.time - fixed.ways[0].begin.time) / TURN)
    turned = [*chains[first:], *(chain.later(TURN * periods) for chain in chains[:first])]
    early = TURN * math.floor(turned[0].release / TURN)
    values = np.linalg.eigvals(fixed.matrix).astype(complex)
    values = values[np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))]
    return RestCycle(
        system, periods, swing.modes, tuple(chain.later(-early) for chain in turned), tuple(values.tolist())
    )


def cycle_through(
    system: System, release: float, *, modes: int, most: int
) -> tuple[RestCycle | None, tuple[RestPath, ...], float | None]:
    """The cycle through the release phase nearest to the given one, or None; all chains, and that phase."""
    swing = ForcedResponse(set_at_wall(system, modes), modes)
    if swing.is_several:
        every = [one for one in rest_cycles(system, modes=modes, most=most) if one.periods == most]
        found = min(every, key=lambda one: abs(math.remainder(one.release_phase - release, TURN)), default=None)
        return found, () if found is None else found.chains, None if found is None else found.release_phase
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
