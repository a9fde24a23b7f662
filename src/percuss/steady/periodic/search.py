"""All orbits of a label that a search finds: exactly for one impact, else from random times, with an honest count."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, ParameterError
from percuss.halting import Elapsed, asked, check_interrupted, halting
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, array, callback, count, instance, numbers
from percuss.steady.multipliers import Reason
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS, Drop, FoundOrbits, Tally
from percuss.steady.periodic.impact_chain import ImpactChain, numbers_of, orbit_kernels
from percuss.steady.periodic.pair_proof import proved_pairs
from percuss.steady.periodic.periodic_orbit import SAME, PeriodicOrbit, differences, load_turn, repeats
from percuss.steady.states import check_pushes, steady_states

# ---- Newton's method on the times of the impacts, for many starts at once, led away from what is known (deflation)
#
# Roots that are known are made poles: with G = F Π (1 + 1/d_k²), d_k the distance to root k, the step is that of F
# times one number (Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026–A2045), so that deflation costs no
# solve.

_STEPS = 60
_FRESH = -1  # of `settling`: not begun
_WORK = 1 << 20  # modes × impacts² × steps in a call, a tenth of a second: between calls it can be interrupted
COALESCED = 1e-9  # share of the period below which a flight has vanished


class Outcome(IntEnum):
    """How a start ended."""

    LOST = 0
    ROOT = 1
    COALESCED = 2


class Ended(NamedTuple):
    """Where the starts ended: times (B, p), mean velocity after the first impact (B,), how (B,)."""

    times: Array
    rebound: Array
    outcome: npt.NDArray[np.int64]


def newton(chain: ImpactChain, times: Array, known: Array | None = None, turn: float = 2.0 * np.pi) -> Ended:
    """Follow starts of the shape (B, p) to impact times that belong to orbits, away from known roots (K, p)."""
    p, system = chain.impacts, numbers_of(chain.system, chain.modes)
    times = np.array(times, dtype=float, ndmin=2)
    rebound, outcome = np.zeros(times.shape[0]), np.zeros(times.shape[0], dtype=np.int64)
    settling = np.full(times.shape[0], _FRESH, dtype=np.int64)
    roots = np.empty((0, p)) if known is None else np.ascontiguousarray(known, dtype=float)
    work = p * (p + 4) * (system.modes + 1) + p * roots.size
    rows, steps = max(1, _WORK // (work * _STEPS)), min(_STEPS, max(1, _WORK // work))
    for first in range(0, times.shape[0], rows):
        some = slice(first, first + rows)
        for done in range(0, _STEPS, steps):
            check_interrupted()
            orbit_kernels().search(
                system.row, system.room(p), chain.period, turn, chain.is_neutral, roots, min(steps, _STEPS - done),
                times[some], rebound[some], settling[some], outcome[some],
            )  # fmt: skip
    return Ended(times, rebound, outcome)


# ---- The roots that a search for orbits has found, with a verdict on each, and what became of its tries

_AT_ONCE = 256  # starts of a batch, at most
_FEWEST = 16  # in the first batch that is led away from what is known: those of a batch do not know of each other
_NUMBERS = 1 << 20  # of an array of a batch


def verdict(orbit: PeriodicOrbit) -> Drop | None:
    """Why a root is no orbit; None for one that is."""
    if orbit.impacts > 1 and orbit.resonant_modes:
        return Drop.RESONANT
    obstacle = orbit.obstacle
    return None if obstacle is None else Drop.NO_BLOW if obstacle is Reason.NO_BLOW else Drop.THROUGH_WALL


class RootSearch:
    """The roots found so far, with a verdict on each, and the tries, by where they started and what became of them."""

    def __init__(self, chain: ImpactChain) -> None:
        self.chain = chain
        self.turn = load_turn(chain.system.load)
        self.known = np.empty((0, chain.impacts))  # every root, repeats of shorter orbits among them
        self.roots: list[tuple[PeriodicOrbit, Drop | None]] = []
        self.dropped: Counter[Drop] = Counter()
        self.met: Counter[int] = Counter()  # the orbits at which free tries ended
        self.sources: dict[str, Tally] = {}

    def tried(self, given: Mapping[str, Array], wanted: int, random: np.random.Generator) -> None:
        """Search from what is given, then from random times freely, then led away from what is known."""
        free = (wanted + 1) // 2
        for name, rows in given.items():
            self.sources[name] = Tally(0, 0)
            for first, size in self._batches(rows.shape[0]):
                self._followed(name, rows[first : first + size])
        self.sources[RANDOM] = Tally(0, 0)
        for _, size in self._batches(free):
            self.met.update(self._followed(RANDOM, self._drawn(random, size)))
        for _, size in self._batches(wanted - free, _FEWEST):
            self._followed(RANDOM, self._drawn(random, size), self.known)

    def _drawn(self, random: np.random.Generator, size: int) -> Array:
        return np.sort(random.uniform(0.0, self.chain.period, (size, self.chain.impacts)), axis=1)

    def _batches(self, tries: int, size: int = _AT_ONCE) -> Iterator[tuple[int, int]]:
        """Where batches of so many tries begin, and their sizes: each twice the one before, as the memory allows."""
        most = max(1, min(_AT_ONCE, _NUMBERS // (self.chain.impacts**2 * max(self.chain.modes, 1))))
        first, size = 0, min(size, most)
        while first < tries:
            check_interrupted()
            yield first, min(size, tries - first)
            first, size = first + size, min(2 * size, most)

    def _followed(self, name: str, starts: Array, known: Array | None = None) -> list[int]:
        """Follow starts and judge their ends; the numbers of the possible orbits at which they ended."""
        ended, before, reached = newton(self.chain, starts, known, self.turn), self._good, []
        self.dropped[Drop.LOST] += int((ended.outcome == Outcome.LOST).sum())
        self.dropped[Drop.COALESCED] += int((ended.outcome == Outcome.COALESCED).sum())
        for row in np.flatnonzero(ended.outcome == Outcome.ROOT):
            number, new = self.judged(ended.times[row], float(ended.rebound[row]))
            reason = self.roots[number][1]
            if reason is None:
                reached.append(number)
            if not new or reason is not None:
                self.dropped[reason or Drop.KNOWN] += 1
        tries, orbits = self.sources[name]
        self.sources[name] = Tally(tries + len(starts), orbits + self._good - before)
        return reached

    @property
    def _good(self) -> int:
        return sum(1 for _, reason in self.roots if reason is None)

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

    def orbit(self, times: Array, rebound: float) -> PeriodicOrbit:
        """The motion with impacts at given times, the first of them in the first period of the load."""
        chain = self.chain
        kept = rebound if chain.is_neutral else None
        return PeriodicOrbit(chain.system, chain.periods, tuple(times.tolist()), chain.modes, kept).from_first

    def result(self, *, complete: bool = False, interrupted: bool = False) -> FoundOrbits:
        """What was found; of a list that is proved to be complete the roots are counted, there are no tries."""
        chain, ended = self.chain, sum(self.met.values())
        unseen = sum(1 for times in self.met.values() if times == 1) / ended if ended else None
        listed = sorted(self.roots, key=lambda root: root[0].times)
        good = tuple(orbit for orbit, reason in listed if reason is None)
        others = tuple(orbit for orbit, reason in listed if reason not in (None, Drop.REPEAT))
        counted = Counter(reason for _, reason in self.roots) if complete else self.dropped
        dropped = {drop: counted[drop] for drop in Drop if counted[drop]}
        tries = sum(tally.tries for tally in self.sources.values())
        return FoundOrbits(
            chain.system, chain.impacts, chain.periods, chain.modes, good, others, tries, dropped,
            0.0 if complete else unseen, complete, self.sources, ended, interrupted,
        )  # fmt: skip


# ---- Where the starts of a search come from: random times, and rows of times that are given

RANDOM = "random times"  # what starts are called that nobody gave

_LATEST = 1e12  # rad


def given_rows(near: object, impacts: int, periods: int) -> dict[str, Array]:
    """Rows of times to start from, by where they come from, each of the shape (K, p); they may be none."""
    if near is not None and not isinstance(near, Mapping):
        raise ParameterError("near", near, 'rows of times by their source, as {"a guess": [[0.4, 2.3]]}, or None')
    accepted = f"rows of {impacts} increasing times within {periods} load period{'s' if periods > 1 else ''}"
    found = {}
    for name, rows in (near or {}).items():
        if not isinstance(name, str) or not name or name == RANDOM:
            raise ParameterError("near", name, "words for where the starts come from")
        times = numbers(f"near[{name!r}]", rows, accepted)
        times = times if times.size else np.empty((0, impacts))
        orderly = times.ndim == 2 and times.shape[1] == impacts and bool(np.all(np.abs(times) <= _LATEST))
        if not orderly or np.any(np.diff(times) <= 0.0) or np.any(np.ptp(times, axis=1) >= 2.0 * math.pi * periods):
            raise ParameterError(f"near[{name!r}]", rows, accepted)
        found[name] = times
    return found


# ---- All orbits of a label that a search finds: exactly for one impact, else from random times, with an honest count

_MOST_MODES = 4096
_MOST_TRIES = 10**7
_NEAR = 1e-8  # rad, from an enclosed root to that of Newton's method


def orbits(
    system: System | Machine,
    impacts: int,
    periods: int = 1,
    *,
    modes: int = DEFAULT_MODES,
    tries: int = 400,
    seed: int = 0,
    near: Mapping[str, Any] | None = None,
    progress: Callable[[Elapsed], object] | None = None,
) -> FoundOrbits:
    """The periodic motions z=p/n with p impacts in n load periods; of a machine p/n, blows in cycles of its valve.

    For p = 1 they are the steady motions of `steady_states`, all of them. For p = 2 and a rigid bar interval Newton's
    method encloses them all and proves that there are no others, but where one is degenerate (at a fold, at a step of
    the load, with R = 1 and no drag): `complete` tells. Else Newton's method starts from what is given, and then from
    random times: the first half of the tries freely, which tells how many orbits may be missing, the others led away
    from every root known so far. Whatever is found is looked at before it is called an orbit: each impact must strike
    forward, the bar must stay off the wall between impacts (proved with bounds), and it must be no repeat of a shorter
    orbit, nor one already found that starts from another impact or another period of the load.

    Of a machine without a clock the starts are orders of events: stretches of the rigid piston's motion from blow to
    blow, after random rebounds, and what is given. Newton's method closes each by the times of its blows and ports.
    What it finds is an orbit, a `ValveCycle`, if the order of events is the valve's own and nothing else happens in
    between, which is proved. Cycles with rest are none of them.

    Parameters
    ----------
    system
        The bar, its load and its contact; or a machine that switches its own valve.
    impacts, periods
        p, 1 to 64, and n, 1 to 256. They need not be coprime: z=2/2 is what a doubled z=1/1 is.
    modes
        N: the bar has the modes 0 … N, in the forced part, too.
    tries
        Random starts, where the list is not complete by itself.
    near
        Impact times to start from first, by where they come from: rows of p times in order, within n load periods, as
        the last impacts of a simulated motion are (`percuss.explore.orbit_seeds`). Each array has the shape (K, p).
        Of a machine lists of `CycleTimes`.
    progress
        Called again and again; once it returns true the search ends with what it has, `interrupted`.

    Raises
    ------
    LoadError
        When the load does not push (mean ≤ 0) or is constant.
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.
    Interrupted
        When it was interrupted before there was anything: among motions with one impact, which are found all at once.

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
    callback("progress", progress)
    halt = asked(progress)
    if isinstance(system, Machine):
        from percuss.steady.self_excited.valve_orbits import valve_orbits

        return valve_orbits(system, impacts, periods, modes=modes, tries=tries, seed=seed, near=near, halt=halt)
    instance("system", system, System)
    p, n = count("impacts", impacts, most=MOST_IMPACTS), count("periods", periods, most=MOST_PERIODS)
    kept = _kept(system, modes)
    wanted = count("tries", tries, most=_MOST_TRIES)
    start = count("seed", seed, least=0, most=2**63 - 1)
    given = given_rows(near, p, n)
    check_pushes(system)
    with halting(halt):
        if p == 1:
            return _with_one_impact(system, n, kept)
        search, interrupted = RootSearch(ImpactChain(system, p, n, kept)), False
        try:
            if p == 2 and kept == 0 and _proved(search):
                return search.result(complete=True)
            search.tried(given, wanted, np.random.default_rng(start))
        except Interrupted:
            if halt is None or not halt():  # told from outside: nobody waits for a part
                raise
            interrupted = True
    return search.result(interrupted=interrupted)


def orbit_near(
    system: System, times: npt.ArrayLike, periods: int = 1, *, modes: int = DEFAULT_MODES
) -> PeriodicOrbit | None:
    """The periodic motion whose impacts are near given times; None where Newton's method finds none.

    It need not be possible (look at its `admissible`), nor as near as one would like.

    Parameters
    ----------
    times
        When the p impacts are, in rad of the load, increasing, all of them within n load periods; shape (p,).

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
    return system.body.chosen(count("modes", modes, least=0, most=_MOST_MODES))


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
