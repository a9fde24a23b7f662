"""The roots that a search for orbits has found, with a verdict on each, and what became of its tries."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from percuss.model.checks import Array
from percuss.steady.periodic.found_orbits import Drop, FoundOrbits, Tally
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.newton import Outcome, newton
from percuss.steady.periodic.periodic_orbit import PeriodicOrbit
from percuss.steady.periodic.sameness import SAME, differences, load_turn, repeats
from percuss.steady.reason import Reason

__all__ = ["RootSearch", "verdict"]

_AT_ONCE = 256  # starts of a batch, at most
_NUMBERS = 1 << 20  # of an array of a batch


def verdict(orbit: PeriodicOrbit) -> Drop | None:
    """Why a root is no orbit; None for one that is."""
    if orbit.impacts > 1 and orbit.resonant_modes:
        return Drop.RESONANT
    obstacle = orbit.obstacle
    return None if obstacle is None else Drop.NO_BLOW if obstacle is Reason.NO_BLOW else Drop.THROUGH_WALL


class RootSearch:
    """The roots found so far, with a verdict on each, and the tries that gave no new orbit."""

    def __init__(self, chain: ImpactChain) -> None:
        self.chain = chain
        self.turn = load_turn(chain.system.load)
        self.known = np.empty((0, chain.impacts))  # every root, repeats of shorter orbits among them
        self.roots: list[tuple[PeriodicOrbit, Drop | None]] = []
        self.dropped: Counter[Drop] = Counter()

    def drawn(self, random: np.random.Generator, size: int) -> Array:
        """Random times in a period, in order; shape (size, p)."""
        return np.sort(random.uniform(0.0, self.chain.period, (size, self.chain.impacts)), axis=1)

    def batches(self, tries: int, first: int = _AT_ONCE) -> Iterator[int]:
        """Sizes of the batches of so many tries, each twice the one before, up to what does not fill the memory."""
        chain = self.chain
        most = max(1, min(_AT_ONCE, _NUMBERS // (chain.impacts**2 * max(chain.modes, 1))))
        size = min(first, most)
        while tries > 0:
            yield min(size, tries)
            tries, size = tries - size, min(2 * size, most)

    def orbit(self, times: Array, rebound: float) -> PeriodicOrbit:
        """The motion with impacts at given times, the first of them in the first period of the load."""
        chain = self.chain
        kept = rebound if chain.is_neutral else None
        return PeriodicOrbit(chain.system, chain.periods, tuple(times.tolist()), chain.modes, kept).from_first

    def followed(self, starts: Array, known: Array | None = None) -> list[int]:
        """Follow starts and judge their ends; the numbers of the possible orbits at which they ended."""
        ended = newton(self.chain, starts, known, self.turn)
        self.dropped[Drop.LOST] += int((ended.outcome == Outcome.LOST).sum())
        self.dropped[Drop.COALESCED] += int((ended.outcome == Outcome.COALESCED).sum())
        reached = []
        for row in np.flatnonzero(ended.outcome == Outcome.ROOT):
            number, new = self.judged(ended.times[row], float(ended.rebound[row]))
            reason = self.roots[number][1]
            if reason is None:
                reached.append(number)
            if not new or reason is not None:
                self.dropped[reason or Drop.KNOWN] += 1
        return reached

    def judged(self, times: Array, rebound: float) -> tuple[int, bool]:
        """The number of a root, and whether it is new."""
        if self.roots:
            off = np.abs(differences(times, self.known, self.chain.period, self.turn)).max(axis=-1).min(axis=-1)
            nearest = int(np.argmin(off))
            if off[nearest] <= SAME:
                return nearest, False
        orbit = self.orbit(times, rebound)
        again = repeats(times, self.chain.period, self.turn) > 1
        self.roots.append((orbit, Drop.REPEAT if again else verdict(orbit)))
        self.known = np.concatenate([self.known, np.array([orbit.times])])
        return len(self.roots) - 1, True

    @property
    def good(self) -> int:
        """How many orbits have been found."""
        return sum(1 for _, reason in self.roots if reason is None)

    def result(
        self,
        tries: int,
        unseen: float | None,
        *,
        complete: bool = False,
        sources: Mapping[str, Tally] | None = None,
        ended: int = 0,
        halted: bool = False,
    ) -> FoundOrbits:
        """What was found; of a list that is proved to be complete the roots are counted, there are no tries."""
        chain = self.chain
        listed = sorted(self.roots, key=lambda root: root[0].times)
        good = tuple(orbit for orbit, reason in listed if reason is None)
        others = tuple(orbit for orbit, reason in listed if reason not in (None, Drop.REPEAT))
        counted = Counter(reason for _, reason in self.roots) if complete else self.dropped
        dropped = {drop: counted[drop] for drop in Drop if counted[drop]}
        return FoundOrbits(
            chain.system, chain.impacts, chain.periods, chain.modes, good, others, tries, dropped, unseen, complete,
            sources or {}, ended, halted,
        )  # fmt: skip
