"""What a search for orbits found, and why each of its other tries gave none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from percuss.model import System
from percuss.shown import Shown
from percuss.steady.periodic.periodic_orbit import PeriodicOrbit

__all__ = ["Drop", "FoundOrbits", "Tally"]


class Drop(Enum):
    """Why a try gave no new orbit."""

    LOST = "did not converge"
    COALESCED = "impacts coalesce"
    REPEAT = "repeats a shorter orbit"
    RESONANT = "internal resonance"
    NO_BLOW = "strikes backwards"
    THROUGH_WALL = "through the wall"
    KNOWN = "known already"


class Tally(NamedTuple):
    """How many starts came from one source, and how many of the orbits they were the first to lead to."""

    tries: int
    orbits: int


@dataclass(frozen=True)
class FoundOrbits(Shown):
    """The orbits z=p/n that a search found.

    Parameters
    ----------
    system, impacts, periods, modes
        What was asked: p, n and N.
    orbits
        Those that are possible, by the phase of their first impact.
    rejected
        The other roots of the equations for the times, each with its `obstacle`; no repeats of shorter orbits.
    tries
        Starts that were followed; 0 where none was needed.
    dropped
        How many of the tries gave no new orbit, by reason; of a complete list, how many roots are none.
    unseen
        Estimate of the share of random starts that would lead to orbits not found: of the tries without deflation that
        ended at an orbit, the part whose orbit they met once only (Good, Biometrika 40 (1953) 237–264). None when no
        such try ended at one; 0 where the list is complete.
    complete
        Whether there are proved to be no others: of one impact in a cycle, and of two of a rigid bar but in degenerate
        cases.
    sources
        Where the starts came from: ``"random times"``, and what was given besides.
    ended
        From how many tries `unseen` is estimated; it is worth little where these are few.
    halted
        Whether the search was told to end before all of its tries.
    """

    system: System
    impacts: int
    periods: int
    modes: int
    orbits: tuple[PeriodicOrbit, ...]
    rejected: tuple[PeriodicOrbit, ...] = field(repr=False)
    tries: int
    dropped: Mapping[Drop, int]
    unseen: float | None
    complete: bool
    sources: Mapping[str, Tally] = field(default_factory=dict, repr=False)
    ended: int = 0
    halted: bool = False

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def resonant_modes(self) -> tuple[int, ...]:
        """The elastic modes n that come back by themselves after the cycle of a root: internal resonance."""
        roots = (*self.orbits, *self.rejected)
        return tuple(sorted({n for root in roots for n in root.resonant_modes}))

    def __str__(self) -> str:
        found = f"{len(self.orbits)} orbit{'s' if len(self.orbits) != 1 else ''}"
        if self.complete:
            head = f"{self.label}: {found}, complete (proved)"
        else:
            estimate = _estimate(self.unseen, self.ended)
            head = f"{self.label}: {found} in {self.tries} tries, {estimate}{', halted' if self.halted else ''}"
        return "\n".join([head, *(f"  {orbit}" for orbit in self.orbits)])


def _estimate(unseen: float | None, ended: int) -> str:
    """What is told of orbits that may be missing."""
    if unseen is None:
        return "no estimate of what is missing"
    return f"unseen share {unseen:.2g} (by {ended} tr{'ies' if ended > 1 else 'y'})"
