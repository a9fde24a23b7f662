"""All orbits of a label that a search finds: exactly for one impact, else from random times, with an honest count."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, ParameterError
from percuss.halting import halting, look
from percuss.model import HeldBody, System
from percuss.model.checks import Array, array, callback, count, instance
from percuss.steady.periodic.found_orbits import FoundOrbits, Tally
from percuss.steady.periodic.given_starts import RANDOM, given_rows
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.newton import Outcome, newton
from percuss.steady.periodic.pair_proof import proved_pairs
from percuss.steady.periodic.periodic_orbit import PeriodicOrbit
from percuss.steady.periodic.root_search import RootSearch, verdict
from percuss.steady.states import check_pushes, steady_states

__all__ = ["MOST_IMPACTS", "MOST_PERIODS", "orbit_near", "orbits"]

MOST_IMPACTS = 64
MOST_PERIODS = 256
_MOST_MODES = 4096
_MOST_TRIES = 10**7
_FEWEST = 16  # in the first batch that is led away from what is known: those of a batch do not know of each other
_NEAR = 1e-8  # rad, from an enclosed root to that of Newton's method


def orbits(
    system: System,
    impacts: int,
    periods: int = 1,
    *,
    modes: int = 32,
    tries: int = 400,
    seed: int = 0,
    near: Mapping[str, npt.ArrayLike] | None = None,
    halt: Callable[[], bool] | None = None,
) -> FoundOrbits:
    """The periodic motions z=p/n with p impacts in n load periods.

    For p = 1 they are the steady motions of `steady_states`, all of them. For p = 2 and a rigid bar interval Newton's
    method encloses them all and proves that there are no others, but where one is degenerate (at a fold, at a step of
    the load, with R = 1 and no drag): `complete` tells. Else Newton's method starts from what is given, and then from
    random times: the first half of the tries freely, which tells how many orbits may be missing, the others led away
    from every root known so far. Whatever is found is looked at before it is called an orbit: each impact must strike
    forward, the bar must stay off the wall between impacts (proved with bounds), and it must be no repeat of a shorter
    orbit, nor one already found that starts from another impact or another period of the load.

    Parameters
    ----------
    system
        The bar, its load and its contact.
    impacts, periods
        p, 1 to 64, and n, 1 to 256. They need not be coprime: z=2/2 is what a doubled z=1/1 is.
    modes
        N: the bar has the modes 0 … N, in the forced part, too.
    tries
        Random starts, where the list is not complete by itself.
    seed
        Of the random times.
    near
        Impact times to start from first, by where they come from: rows of p times in order, within n load periods, as
        the last impacts of a simulated motion are (`percuss.explore.orbit_seeds`). Each array has the shape (K, p).
    halt
        Asked now and then; once it returns true the search ends with what it has, `halted`.

    Raises
    ------
    LoadError
        When the load does not push (mean ≤ 0) or is constant.
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.
    ParameterError
        For numbers out of range.
    Interrupted
        When it was halted before there was anything: among motions with one impact, which are found all at once.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    >>> found = orbits(system, 2, 1, modes=0, tries=200)
    >>> for orbit in found.orbits:
    ...     print(orbit.phases.round(6), orbit.speeds.round(6))
    [0.148241 1.466982] [1.865025 0.732025]
    [0.390789 2.321002] [2.099374 0.497676]
    """
    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    kept = _kept(system, modes)
    wanted = count("tries", tries, most=_MOST_TRIES)
    start = count("seed", seed, least=0, most=2**63 - 1)
    given = given_rows(near, p, n)
    callback("halt", halt)
    check_pushes(system)
    with halting(halt):
        if p == 1:
            return _with_one_impact(system, n, kept)
        tried = _Tried(RootSearch(ImpactChain(system, p, n, kept)))
        try:
            if p == 2 and kept == 0 and _proved(tried.search):
                return tried.search.result(0, 0.0, complete=True)
            tried.all_of(given, wanted, np.random.default_rng(start))
        except Interrupted:
            if halt is None or not halt():  # told from outside: nobody waits for a part
                raise
            tried.halted = True
    return tried.result()


class _Tried:
    """The tries of a search so far, by where they started."""

    def __init__(self, search: RootSearch) -> None:
        self.search = search
        self.met: Counter[int] = Counter()  # the orbits at which free tries ended
        self.sources: dict[str, Tally] = {}
        self.halted = False

    def all_of(self, given: Mapping[str, Array], wanted: int, random: np.random.Generator) -> None:
        """From what is given, then freely, then away from what is known."""
        search, free = self.search, (wanted + 1) // 2
        for name, rows in given.items():
            self._counted(name, 0)
            first = 0
            for size in search.batches(rows.shape[0]):
                self._counted(name, size, rows[first : first + size])
                first += size
        self._counted(RANDOM, 0)
        for size in search.batches(free):
            self.met.update(self._counted(RANDOM, size, search.drawn(random, size)))
        for size in search.batches(wanted - free, _FEWEST):
            self._counted(RANDOM, size, search.drawn(random, size), search.known)

    def _counted(self, name: str, size: int, starts: Array | None = None, known: Array | None = None) -> list[int]:
        look()
        before, tally = self.search.good, self.sources.get(name, Tally(0, 0))
        reached = [] if starts is None else self.search.followed(starts, known)
        self.sources[name] = Tally(tally.tries + size, tally.orbits + self.search.good - before)
        return reached

    def result(self) -> FoundOrbits:
        """What was found, and an estimate of what was not."""
        ended = sum(self.met.values())
        unseen = sum(1 for times in self.met.values() if times == 1) / ended if ended else None
        tries = sum(tally.tries for tally in self.sources.values())
        return self.search.result(tries, unseen, sources=self.sources, ended=ended, halted=self.halted)


def orbit_near(system: System, times: npt.ArrayLike, periods: int = 1, *, modes: int = 32) -> PeriodicOrbit | None:
    """The periodic motion whose impacts are near given times; None where Newton's method finds none.

    It need not be possible (look at its `admissible`), nor as near as one would like.

    Parameters
    ----------
    system
        The bar, its load and its contact.
    times
        When the p impacts are, in rad of the load, increasing, all of them within n load periods; shape (p,).
    periods, modes
        n and N, as for `orbits`.

    Raises
    ------
    LoadError, ResonanceError, ParameterError
        As `orbits`; and for times that are not in order, or not within n load periods.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=5.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    >>> orbit = orbit_near(system, [0.4, 2.3], modes=16)
    >>> orbit.label, orbit.phases.round(6).tolist(), orbit.admissible
    ('z=2/1', [0.391798, 2.300889], True)
    """
    instance("system", system, System)
    n, kept = count("periods", periods, most=MOST_PERIODS), _kept(system, modes)
    given = array("times", times, -1e12, 1e12)
    if not 1 <= given.size <= MOST_IMPACTS or np.any(np.diff(given) <= 0.0) or np.ptp(given) >= 2.0 * math.pi * n:
        raise ParameterError(
            "times", times, f"1 to {MOST_IMPACTS} increasing times within {n} load period{'s' if n > 1 else ''}"
        )
    check_pushes(system)
    search = RootSearch(ImpactChain(system, given.size, n, kept))
    ended = newton(search.chain, given[None, :], None, search.turn)
    return search.orbit(ended.times[0], float(ended.rebound[0])) if ended.outcome[0] == Outcome.ROOT else None


def _kept(system: System, modes: int) -> int:
    """How many of so many modes the system has."""
    wanted, body = count("modes", modes, least=0, most=_MOST_MODES), system.body
    return body.chosen(wanted) if isinstance(body, HeldBody) else wanted


def _with_one_impact(system: System, periods: int, modes: int) -> FoundOrbits:
    """The roots of B77 (14), which are all the motions with one impact that there are."""
    found = steady_states(system, periods, modes=modes).orbits
    every = [PeriodicOrbit(system, periods, (orbit.phase,), modes) for orbit in found]
    good = tuple(orbit for orbit in every if orbit.admissible)
    others = tuple(orbit for orbit in every if not orbit.admissible)
    dropped = Counter(reason for orbit in others if (reason := verdict(orbit)))
    return FoundOrbits(system, 1, periods, modes, good, others, 0, dict(dropped), 0.0, True)


def _proved(search: RootSearch) -> bool:
    """Whether all pairs of impacts of a rigid bar were enclosed; each is then judged."""
    chain = search.chain
    times = proved_pairs(chain.system, chain.periods, search.turn)
    if times is None:
        return False
    ended = newton(chain, times, None, search.turn)
    if np.any(ended.outcome != Outcome.ROOT) or np.abs(ended.times - times).max(initial=0.0) > _NEAR:
        return False
    for row in range(times.shape[0]):
        search.judged(ended.times[row], float(ended.rebound[row]))
    return len(search.roots) == times.shape[0] and all(orbit.proven for orbit, _ in search.roots)
