"""The branches of a label: orbits searched for at some values of a parameter, and followed, each branch once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.following import follow
from percuss.explore.diagrams.impossible import beyond_the_ends
from percuss.explore.diagrams.lines import DiagramBranch, line_of, with_new
from percuss.explore.family import Family
from percuss.model import System
from percuss.steady import PeriodicOrbit, orbit_near, orbits
from percuss.steady.periodic.sameness import SAME, differences, load_turn

__all__ = ["labels_up_to", "traced"]

_NEAR = 0.3  # rad, by which the times between two points of a branch may be off
_SAME = 10.0 * SAME


def traced(
    family: Family,
    name: str,
    between: tuple[float, float],
    values: Sequence[float],
    label: tuple[int, int],
    *,
    modes: int,
    tries: int,
    switch: int,
    stopped: Callable[[], bool],
) -> list[DiagramBranch]:
    """All branches on which an orbit of a label was found at one of the values, and those that begin on them.

    Parameters
    ----------
    family, name, between
        The systems, and which parameter is varied in which range.
    values
        Of the parameter, at which orbits are searched for; in the range.
    label
        p and n.
    modes, tries, switch
        As for `percuss.steady.orbits` and `percuss.explore.follow`.
    stopped
        Whether the answer is no longer wanted.
    """

    def system(value: float) -> System:
        return family.system({name: value})

    found: list[DiagramBranch] = []
    for value in values:
        if stopped():
            break
        try:
            known = orbits(system(value), *label, modes=modes, tries=tries).orbits
        except PercussError:  # there is no such system, or its load does not push
            continue
        for orbit in known:
            if stopped() or any(_is_on(line, value, orbit) for line in found):
                continue
            try:
                branch = follow(orbit, name, between, family=family, value=value, switch=switch, halt=stopped)
            except PercussError:  # at an end of what can be followed
                continue
            every = list(branch.family())
            beyond = beyond_the_ends(every, family, between, stopped)
            found = with_new(found, [*(line_of(one, system) for one in every), *beyond])
    return found


def _is_on(line: DiagramBranch, value: float, orbit: PeriodicOrbit) -> bool:
    """Whether a branch goes through an orbit: the points beside it say where to look for the one that it has there."""
    if not line.possible or (line.impacts, line.periods) != (orbit.impacts, orbit.periods):
        return False
    turn = load_turn(orbit.system.load)
    times = np.array(orbit.times)
    for near in line.times_at(value):
        if float(np.abs(differences(times, near[None, :], orbit.period, turn)).max(axis=-1).min()) > _NEAR:
            continue
        own = orbit_near(orbit.system, near, orbit.periods, modes=orbit.modes)
        if own is not None:
            other = np.array([own.times])
            if float(np.abs(differences(times, other, orbit.period, turn)).max(axis=-1).min()) < _SAME:
                return True
    return False


def labels_up_to(up_to: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """All p and n up to those of a label, short cycles first."""
    every = [(p, n) for p in range(1, up_to[0] + 1) for n in range(1, up_to[1] + 1)]
    yield from sorted(every, key=lambda label: (sum(label), label))
