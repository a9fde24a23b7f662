"""The largest Lyapunov exponent of the map from impact to impact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, ResonanceError
from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import Array, count, instance, several
from percuss.shown import Shown
from percuss.simulate import Start, Starts, Stop, Trajectory, run
from percuss.simulate.ensemble import cores

LYAPUNOV_OUTCOMES = ("done", "rest", "departed", "work", "memory", "resonance")
"""How the computation of an exponent ends.

``rest``: the bar comes to rest on the wall, which erases every difference, so that the exponent is −∞. ``departed``:
the bar has left for good; there is none. ``work``, ``memory``: the simulation ended early
(`percuss.simulate.OUTCOMES`); the exponent is that of the impacts there are. ``resonance``: of a batch only; the load
meets an undamped elastic mode.
"""

_BATCHES = 20
_IMPACT, _REST = 0, 3  # numbers of events, as in percuss.simulate.events
_TURN = 2.0 * math.pi


@dataclass(frozen=True)
class Lyapunov(Shown):
    """How fast two motions that start near each other separate or converge.

    Attributes
    ----------
    exponent
        Mean logarithm of the growth per impact; −inf when the bar rests, NaN when there is none. Dimensionless.
    per_period
        The same per load period.
    error
        Standard error of `exponent`, from the scatter of the means of 20 stretches; 0 of −inf.
    impacts
        Impacts that were used.
    outcome
        One of `LYAPUNOV_OUTCOMES`.
    """

    exponent: float
    per_period: float
    error: float
    impacts: int
    outcome: str

    @property
    def interval(self) -> tuple[float, float]:
        """Four standard errors to either side, and ln n/n more below, of n impacts.

        In a regular motion without damping a difference grows in proportion to the number of impacts, by ln n in all.
        """
        bias = math.log(max(self.impacts, 2)) / max(self.impacts, 2)
        return self.exponent - 4.0 * self.error - bias, self.exponent + 4.0 * self.error

    @property
    def chaotic(self) -> bool:
        """Whether the exponent is positive, whatever the number within `interval`."""
        return self.interval[0] > 0.0

    def __str__(self) -> str:
        if not math.isfinite(self.exponent):
            return f"Lyapunov exponent {self.exponent} ({self.outcome})"
        return (
            f"Lyapunov exponent {self.exponent:.6g} ± {self.error:.1g} per impact, {self.per_period:.6g} per load "
            f"period ({self.impacts} impacts)"
        )


@dataclass(frozen=True)
class LyapunovMany(Shown):
    """The exponents of many motions, one row each; `code` is the number in `LYAPUNOV_OUTCOMES`. See `Lyapunov`."""

    exponent: Array
    per_period: Array
    error: Array
    impacts: npt.NDArray[np.int64]
    code: npt.NDArray[np.int8]

    def __len__(self) -> int:
        return int(self.code.size)

    def __getitem__(self, i: int) -> Lyapunov:
        figures = {name: getattr(self, name)[i].item() for name in _FIGURES}
        return Lyapunov(**figures, outcome=LYAPUNOV_OUTCOMES[self.code[i]])


_FIGURES = ("exponent", "per_period", "error", "impacts")
_EXPONENT = "the Lyapunov exponent"


def lyapunov_exponent(
    system: System, start: Start | None = None, *, modes: int = 0, impacts: int = 2000, discard: int = 500
) -> Lyapunov:
    """The largest Lyapunov exponent of a motion, from its linearised map impact by impact.

    The motion is simulated, and a small difference carried along with it: freely in flight, through the saltation
    matrix at every impact. Of a steady motion the exponent is the logarithm of the largest modulus of its multipliers.
    (A motion that starts on an unstable one to the last bit may stay there: start beside it.)

    Parameters
    ----------
    system
        What moves.
    start
        Where the motion begins; `Start.rigid()` by default.
    modes
        N, the elastic modes kept.
    impacts
        Impacts over which the growth is averaged, 20 or more. The average is weighted by exp(−1/(t(1 − t))), t from
        0 to 1 over them, which costs a chaotic motion a quarter more of error and gives a regular one many digits
        (Das et al. 2017).
    discard
        Impacts before them; in the second half of these the difference turns to where it grows fastest.

    Raises
    ------
    ParameterError
        For numbers out of range.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode.

    References
    ----------
    S. Das, Y. Saiki, E. Sander, J. A. Yorke, Quantitative quasiperiodicity, Nonlinearity 30 (2017) 4111–4140.

    Examples
    --------
    >>> from percuss import Load, Start, System, steady_states
    >>> from percuss.explore.lyapunov import lyapunov_exponent
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.77, 1.0))
    >>> _, orbit = steady_states(system).orbits
    >>> print(lyapunov_exponent(system, Start.orbit(orbit, velocity=[0.01])))
    Lyapunov exponent -0.130572 ± ... per impact, -0.130572 per load period (2000 impacts)
    """
    used, before = _numbers(impacts, discard)
    need_free(instance("system", system, System).body, _EXPONENT)
    stop = Stop(impacts=used + before + 1, periodic=False)
    return _of(run(system, start, modes=modes, stop=stop), used, before)


def lyapunov_many(
    systems: System | Sequence[System],
    starts: Start | Starts | Sequence[Start] | None = None,
    *,
    modes: int = 0,
    impacts: int = 2000,
    discard: int = 500,
    threads: int | None = None,
) -> LyapunovMany:
    """The largest Lyapunov exponents of many motions; each is what `lyapunov_exponent` gives.

    Parameters
    ----------
    systems, starts
        One of them for all, or as many as members; `Start.rigid()` by default.
    modes, impacts, discard
        See `lyapunov_exponent`.
    threads
        How many; by default as many as cores. The results are the same for any number.

    Raises
    ------
    ParameterError
        For numbers out of range, or of systems and starts that do not go together.
    """
    used, before = _numbers(impacts, discard)
    whole = (
        [systems] if isinstance(systems, System) else list(several("systems", systems, "a System, or a list of them"))
    )
    for system in whole:
        need_free(instance("systems", system, System).body, _EXPONENT)
    begins: Sequence[Start] | Starts = (
        [Start.rigid()] if starts is None else [starts] if isinstance(starts, Start) else starts
    )
    if not isinstance(begins, Starts):
        begins = [instance("starts", one, Start) for one in several("starts", begins, "a Start, Starts, or a list")]
    members = max(len(whole), len(begins))
    if {len(whole), len(begins)} - {1, members} or not whole:
        given = f"{len(whole)} systems and {len(begins)} starts"
        raise ParameterError("starts", given, "as many starts as systems, or one of either")
    workers = cores() if threads is None else count("threads", threads, most=1024)
    stop = Stop(impacts=used + before + 1, periodic=False)

    def one(i: int) -> Lyapunov:
        try:
            motion = run(whole[i % len(whole)], begins[i % len(begins)], modes=modes, stop=stop)
        except ResonanceError:
            return Lyapunov(math.nan, math.nan, math.nan, 0, "resonance")
        return _of(motion, used, before)

    if workers == 1:
        found = [one(i) for i in range(members)]
    else:
        with ThreadPoolExecutor(max_workers=min(workers, members), thread_name_prefix="percuss") as pool:
            try:
                found = list(pool.map(one, range(members)))
            except BaseException:
                pool.shutdown(wait=True, cancel_futures=True)
                raise
    figures = {name: np.array([getattr(one, name) for one in found]) for name in _FIGURES}
    code = np.array([LYAPUNOV_OUTCOMES.index(one.outcome) for one in found], dtype=np.int8)
    return LyapunovMany(**figures, code=code)


def _numbers(impacts: int, discard: int) -> tuple[int, int]:
    return count("impacts", impacts, least=_BATCHES, most=10**7), count("discard", discard, least=2, most=10**7)


def _of(motion: Trajectory, impacts: int, discard: int) -> Lyapunov:
    """The exponent of a simulated motion, over at most so many impacts after the first `discard`."""
    outcome = "done" if motion.outcome == "impacts" else motion.outcome
    code = motion.events.code
    struck, rests = np.flatnonzero(code == _IMPACT), np.flatnonzero(code == _REST)
    if outcome == "departed":
        return Lyapunov(math.nan, math.nan, math.nan, 0, outcome)
    later = struck[discard] if struck.size > discard else code.size
    if outcome == "rest" or (rests.size and rests[-1] > later):
        return Lyapunov(-math.inf, -math.inf, 0.0, max(struck.size - discard, 0), "rest")
    if struck.size <= discard + _BATCHES:
        return Lyapunov(math.nan, math.nan, math.nan, max(struck.size - discard, 0), outcome)
    first = struck[discard // 2]
    if rests.size and rests[-1] > first:  # no difference survived it
        first = struck[np.searchsorted(struck, rests[-1])]
    growth = _growths(motion, int(first))
    wanted = struck[discard:]
    used = growth[-wanted.size + 1 :] if growth.size >= wanted.size - 1 else growth
    times = np.diff(motion.events.period[wanted]) * _TURN + np.diff(motion.events.phase[wanted])
    if not np.all(np.isfinite(used)):
        return Lyapunov(-math.inf, -math.inf, 0.0, used.size, outcome)
    t = np.arange(1, used.size + 1) / (used.size + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    weight /= weight.sum()
    mean = float(weight @ used)
    return Lyapunov(mean, _TURN * mean / float(weight @ times), _error(used, weight), used.size, outcome)


def _error(growth: Array, weight: Array) -> float:
    """Standard error of the weighted mean, from the means of stretches that hardly know of each other."""
    parts = np.array_split(growth, _BATCHES)
    means, heavy = np.array([p.mean() for p in parts]), [w.sum() for w in np.array_split(weight, _BATCHES)]
    return float(means.std(ddof=1) * math.sqrt(float(np.sum(np.square(heavy)))))


def _growths(motion: Trajectory, first: int) -> Array:
    """Logarithm of the growth from impact to impact, after event number `first`."""
    from percuss.explore.tangent import (  # only here is the compiler needed
        ElasticRows,
        EventRows,
        ImpactFactors,
        log_growths,
    )
    from percuss.simulate.engine import prepared

    e, load, n = motion.events[first:], motion.system.load, motion.modes
    spectrum, table = prepared(motion.system, n)
    z = motion.states[first:, 2:].reshape(len(e), 2, n)
    steps = np.asarray(load.values)
    mean = steps[e.piece] if steps.size else np.full(len(e), load.mean)
    gone = np.append(0.0, np.diff(e.period) * _TURN + np.diff(e.phase))
    force = mean if steps.size else load.value(e.phase)
    events = EventRows(e.code, gone, e.phase, e.piece, e.impact_velocity, np.asarray(force))
    elastic = ElasticRows(np.ascontiguousarray(z[:, 0]), spectrum.free_rate(z), *spectrum.forced(e.phase, mean))
    growth = np.empty(max(len(e) - 1, 1))
    contact = motion.system.contact
    law = ImpactFactors(contact.strain_factor, contact.velocity_factor)
    found = log_growths(table, law, events, elastic, np.empty((2, n)), np.empty((2, n)), growth)
    return growth[:found]
