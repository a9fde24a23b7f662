"""What a search for orbits found, of a system or of a machine without a clock, and why its other tries gave none."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from percuss.model import System
from percuss.steady.multipliers import FoundMotions
from percuss.steady.periodic.periodic_orbit import PeriodicOrbit

MOST_IMPACTS = 64
MOST_PERIODS = 256
_NAMED = 8  # modes
_DOUBT = 0.05
_HALVINGS = 50


class Drop(Enum):
    """Why a try gave no new orbit."""

    LOST = "did not converge"
    COALESCED = "impacts coalesce"
    REPEAT = "repeats a shorter orbit"
    RESONANT = "internal resonance"
    NO_BLOW = "strikes backwards"
    THROUGH_WALL = "through the wall"
    OUT_OF_ORDER = "events out of order"
    ANOTHER_PORT = "another port is entered"
    NO_PRESSURE = "no pressure"
    KNOWN = "known already"


class Tally(NamedTuple):
    """How many starts came from one source, and how many of the orbits they were the first to lead to."""

    tries: int
    orbits: int


@dataclass(frozen=True)
class FoundOrbits(FoundMotions):
    """The orbits z=p/n that a search found.

    Parameters
    ----------
    system, impacts, periods, modes
        What was asked: p, n and N. Of a machine without a clock the periods are cycles of its valve.
    orbits
        Those that are possible, by the phase of their first impact; of a machine each is a `ValveCycle`, by period.
    impossible
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
    interrupted
        Whether the search was told to end before all of its tries.
    rest
        Of cycles of a machine with a rest on the wall "chatter" or "rest", the word before n in their label; else "".
    """

    system: System
    impacts: int
    periods: int
    modes: int
    orbits: tuple[PeriodicOrbit, ...]
    impossible: tuple[PeriodicOrbit, ...] = field(repr=False)
    tries: int
    dropped: Mapping[Drop, int]
    unseen: float | None
    complete: bool
    sources: Mapping[str, Tally] = field(default_factory=dict, repr=False)
    ended: int = 0
    interrupted: bool = False
    rest: str = ""

    @property
    def possible(self) -> tuple[PeriodicOrbit, ...]:
        """`orbits`, beside `impossible`."""
        return self.orbits

    @property
    def label(self) -> str:
        """z=p/n; of a machine without a clock p/n, blows and cycles of its valve, or with rest chatter/n or rest/n."""
        return f"{'z=' if isinstance(self.system, System) else ''}{self.rest or self.impacts}/{self.periods}"

    @property
    def unseen_sentence(self) -> str:
        """The estimate of `unseen` with its bound, and by how many tries."""
        if self.unseen is None:
            return "none met"
        tries = f"{self.ended} tr{'ies' if self.ended > 1 else 'y'} that ended at an orbit"
        return f"{self.unseen:.2g}, at most {self.unseen_bound:.2g} (with 95 %, by {tries})"

    @property
    def unseen_bound(self) -> float | None:
        """The greatest share of starts, with 95 %, that would lead to orbits not found; None as for `unseen`.

        Exact for a share of which so few of so many tries are met: Clopper and Pearson, Biometrika 26 (1934) 404–413.
        """
        if self.unseen is None or self.complete:
            return self.unseen
        return _at_most(round(self.unseen * self.ended), self.ended)

    @property
    def resonant_modes(self) -> tuple[int, ...]:
        """The elastic modes n that come back by themselves after the cycle of a root: internal resonance."""
        roots = (*self.orbits, *self.impossible)
        return tuple(sorted({n for root in roots for n in root.resonant_modes}))

    def __str__(self) -> str:
        found = f"{len(self.orbits)} orbit{'s' if len(self.orbits) != 1 else ''} with {self.modes} modes"
        if self.complete:
            head = f"{self.label}: {found}, complete (proved){free_amplitude(self.resonant_modes)}"
        else:
            estimate = (
                "no estimate of what is missing" if self.unseen is None else f"unseen share {self.unseen_sentence}"
            )
            head = (
                f"{self.label}: {found} in {self.tries} tries, {estimate}{', interrupted' if self.interrupted else ''}"
            )
            head += free_amplitude(self.resonant_modes)
        return "\n".join([head, *(f"  {orbit}" for orbit in self.orbits)])


def free_amplitude(modes: Collection[int]) -> str:
    """What a headline says of modes that the equations leave open: nothing where there are none."""
    named = ", ".join(str(n) for n in sorted(modes)[:_NAMED]) + (", …" if len(modes) > _NAMED else "")
    return f", but for the free amplitude of mode{'s' if len(modes) > 1 else ''} {named}" if modes else ""


def _at_most(successes: int, trials: int) -> float:
    """The probability with which no more successes than these have the probability 5 %; 1 when all are."""
    if successes >= trials:
        return 1.0
    j = np.arange(successes)
    ways = np.concatenate([[0.0], np.cumsum(np.log((trials - j) / (j + 1.0)))])
    j = np.arange(successes + 1)
    low, high = successes / trials, 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (low + high)
        if np.exp(ways + j * math.log(share) + (trials - j) * math.log1p(-share)).sum() > _DOUBT:
            low = share
        else:
            high = share
    return 0.5 * (low + high)
