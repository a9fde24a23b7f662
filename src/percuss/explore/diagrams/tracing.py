"""Branches over a parameter: orbits found at some values of it and followed, each branch once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch
from percuss.explore.continuation.following import follow
from percuss.explore.diagrams.diagram_lines import beyond_the_ends, goes_through, line_of, with_new
from percuss.explore.family import Family
from percuss.explore.orbit_starts import orbit_at, orbit_seeds
from percuss.halting import halting
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit, RestCycle, orbit_near, orbits, rest_cycles
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS
from percuss.steady.periodic.periodic_orbit import SAME, differences, load_turn

if TYPE_CHECKING:
    from percuss.simulate import Stop

Search: TypeAlias = Callable[[System], Sequence[PeriodicOrbit]]
"""What finds the orbits of a system."""


class SettledCycle(NamedTuple):
    """A cycle without rest that simulations settle on: the parameter, the times of its impacts, and load periods."""

    value: float
    times: Array
    periods: int

    @property
    def label(self) -> tuple[int, int]:
        """p and n."""
        return self.times.size, self.periods


_NEAR = 0.3  # rad, by which the times between two points of a branch may be off
_SAME = 10.0 * SAME
_MOTIONS = 16  # that are simulated for starts of a search
_SETTLING = 32  # random starts whose motions are looked at for longer cycles


def traced(
    family: Family,
    name: str,
    between: tuple[float, float],
    values: Sequence[float],
    search: Search,
    *,
    switch: int,
    modes: int,
    stopped: Callable[[], bool],
    settled: Sequence[SettledCycle] = (),
) -> list[Branch]:
    """All branches with an orbit that `search` finds or that is `settled` on, and what begins on them (`switch`)."""

    def system(value: float) -> System:
        return family.system({name: value})

    found: list[Branch] = []

    def add(value: float, orbit: PeriodicOrbit) -> None:
        """Follow the branch of an orbit, unless it is known."""
        nonlocal found
        if any(_is_on(line, value, orbit) for line in found):
            return
        try:
            branch = follow(
                orbit, name, between, family=family, value=value, switch=switch, progress=lambda _: stopped()
            )
        except PercussError:  # at an end of what can be followed
            return
        every = list(branch.family())
        beyond = beyond_the_ends(every, family, between, stopped)
        found = with_new(found, [*(line_of(one, system) for one in every), *beyond])

    for value in values:
        if stopped():
            break
        try:
            known = search(system(value))
        except PercussError:  # there is no such system, or its load does not push
            continue
        for orbit in known:
            if not stopped():
                add(value, orbit)
    for one in settled:
        if not stopped() and not any(goes_through(line, one.periods, one.value, one.times) for line in found):
            polished = orbit_at(system(one.value), one.times, one.periods, modes)
            if polished is not None:
                add(one.value, polished)
    return found


def of_label(label: tuple[int, int], modes: int, tries: int) -> Search:
    """The search for the orbits z=p/n, from random times and from simulated motions that nearly come back."""

    def search(system: System) -> Sequence[PeriodicOrbit]:
        near = orbit_seeds(system, *label, modes=modes, motions=_MOTIONS) if label[0] > 1 else None
        return orbits(system, *label, modes=modes, tries=tries, near=near).orbits

    return search


def settled_on(beyond: tuple[int, int], modes: int, stop: Stop, seed: int) -> Search:
    """The search for stable orbits longer than those of a label: the cycles that simulations settle on, polished."""

    def search(system: System) -> Sequence[PeriodicOrbit]:
        from percuss.simulate import Starts, simulate_many

        starts = Starts.random(system, _SETTLING, seed=seed)
        many = simulate_many(system, starts, modes=modes, stop=stop, keep=MOST_IMPACTS + 1, workers=1)
        assert many.last_time is not None
        found: list[PeriodicOrbit] = []
        cycles = zip(many.cycle_impacts.tolist(), many.cycle_periods.tolist(), many.cycle_kind.tolist(), strict=True)
        for row, (p, n, kind) in enumerate(cycles):
            known = p <= beyond[0] and n <= beyond[1]
            if kind or not 1 <= p <= MOST_IMPACTS or n > MOST_PERIODS or known:
                continue
            orbit = orbit_at(system, many.last_time[row, -p:], n, modes)
            if orbit is not None and not any(
                _same(orbit, np.array([other.times])) for other in found if other.label == orbit.label
            ):
                found.append(orbit)
        return found

    return search


def _is_on(line: Branch, value: float, orbit: PeriodicOrbit) -> bool:
    """Whether a branch goes through an orbit: the points beside it say where to look for the one that it has there."""
    if not line.possible or (line.impacts, line.periods) != (orbit.impacts, orbit.periods):
        return False
    for near in line.times_at(value):
        if not _same(orbit, near[None, :], _NEAR):
            continue
        own = orbit_near(orbit.system, near, orbit.periods, modes=orbit.modes)
        if own is not None and _same(orbit, np.array([own.times])):
            return True
    return False


def _same(orbit: PeriodicOrbit, times: Array, near: float = _SAME) -> bool:
    turn = load_turn(orbit.system.load)
    off = np.abs(differences(np.array(orbit.times), times, orbit.period, turn)).max(axis=-1)
    return float(off.min()) < near


def labels_up_to(up_to: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """All p and n up to those of a label, short cycles first."""
    every = [(p, n) for p in range(1, up_to[0] + 1) for n in range(1, up_to[1] + 1)]
    yield from sorted(every, key=lambda label: (sum(label), label))


# ---- Branches of cycles with rest over a parameter: all cycles at some values of it, followed, each branch once

MOST_REST_PERIODS = 4
"""Load periods of the cycles that are looked for: windows of longer ones are narrow, and take long to follow."""

_POINTS = 33  # over the whole range, at least
_FINER = 5  # times as many values as are given are looked at where the search for cycles takes no time
_NEAR_RELEASE = 0.05  # rad, within which the releases of two cycles of one label at one value are one


def rests_traced(
    family: Family,
    name: str,
    between: tuple[float, float],
    values: Sequence[float],
    modes: int,
    *,
    stopped: Callable[[], bool],
) -> list[Branch]:
    """All branches of cycles with rest that are met at one of the values; none of what does not rest as a whole."""
    found: list[Branch] = []
    for value in values if modes <= 1 else values[::_FINER]:  # a search takes seconds where several modes remember
        try:
            with halting(stopped):
                system = family.system({name: value})
                known = rest_cycles(system, modes=modes, most=MOST_REST_PERIODS).orbits if _rests(system, modes) else ()
                for cycle in known:
                    if not any(_is_on_rest_line(line, value, cycle) for line in found):
                        branch = follow(cycle, name, between, family=family, value=value, points=_POINTS)
                        found.append(line_of(branch, lambda at: family.system({name: at})))
        except PercussError:  # there is no such system, its load does not push, or nobody waits any longer
            if stopped():
                break
    return found


def _rests(system: System, modes: int) -> bool:
    """Whether the branches are few: after each touch an elastic bar goes on otherwise. With R = 1 no chatter ends."""
    return (modes == 0 or not system.body.is_free) and system.contact.velocity_factor > -1.0


def _is_on_rest_line(line: Branch, value: float, cycle: RestCycle) -> bool:
    """Whether a branch has a cycle: the phase at which the bar is let go tells all that follows."""
    releases = line.releases_at(value) if line.label == cycle.label else ()
    return any(abs(math.remainder(one - cycle.release_phase, 2.0 * math.pi)) < _NEAR_RELEASE for one in releases)
