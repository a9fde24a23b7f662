"""Lyapunov exponents of the map from impact to impact, of whatever hammer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, ResonanceError
from percuss.halting import on_threads
from percuss.mechanics.held_structure import held_structure
from percuss.model import HeldBody, Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, at_once, count, flag, instance, several
from percuss.short_repr import ShortRepr
from percuss.simulate import Start, Starts, Stop, Trajectory, run

LYAPUNOV_OUTCOMES = ("done", "rest", "departed", "work", "memory", "resonance", "stalls")
"""How the computation of an exponent ends.

``rest``: the bar comes to rest on the wall, which erases every difference, so that the exponent is −∞. A structure of
several modes moves on while it rests, and remembers; one that rests for good has no impacts, so that its exponents per
impact are −∞ (0 without damping), and that per load period is of what the wall holds. ``departed``, ``stalls``: the
bar has left for good, or the valve of a machine never switches again; there is none. ``work``, ``memory``: the
simulation ended early (`percuss.simulate.OUTCOMES`); the exponent is that of the impacts there are.
``resonance``: of a batch only; the load meets an undamped elastic mode.
"""

_BATCHES = 20
_IMPACT, _REST = 0, 3  # numbers of events, as in percuss.simulate.events
_TURN = 2.0 * math.pi
_NONE = (math.nan, math.nan, math.nan)
_ERASED = (-math.inf, -math.inf, 0.0)


@dataclass(frozen=True)
class Lyapunov(ShortRepr):
    """How fast two motions that start near each other separate or converge.

    Attributes
    ----------
    exponent
        Mean logarithm of the growth per impact; −inf when the bar rests, NaN when there is none. Dimensionless.
    per_period
        The same per load period; of a machine that switches its own valve, per unit of its time.
    error
        Standard error of `exponent`, from the scatter of the means of 20 stretches; 0 of −inf.
    outcome
        One of `LYAPUNOV_OUTCOMES`.
    modes
        N, the elastic modes kept.
    spectrum
        Where all are asked for, every exponent per impact, the greatest first: 2N + 2, of a structure 2N; of a machine
        without the one along its motion, which is 0, and with one for a supply and for each order that waits at a blow.
        −inf of what is erased.
    """

    exponent: float
    per_period: float
    error: float
    impacts: int
    outcome: str
    modes: int
    spectrum: tuple[float, ...] = ()

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
            lasting = f", {self.per_period:.6g} per load period" if math.isfinite(self.per_period) else ""
            return f"Lyapunov exponent {self.exponent} per impact{lasting} ({self.outcome}, {self.modes} modes)"
        return (
            f"Lyapunov exponent {self.exponent:.6g} ± {self.error:.1g} per impact, {self.per_period:.6g} per load "
            f"period ({self.impacts} impacts, {self.modes} modes)"
        )


@dataclass(frozen=True)
class LyapunovMany(ShortRepr):
    """The exponents of many motions with N `modes`, a row each; `code`: the number in `LYAPUNOV_OUTCOMES`.

    See `Lyapunov`.
    """

    exponent: Array
    per_period: Array
    error: Array
    impacts: npt.NDArray[np.int64]
    code: npt.NDArray[np.int8]
    modes: int
    spectrum: tuple[tuple[float, ...], ...] = ()

    def __len__(self) -> int:
        return int(self.code.size)

    def __getitem__(self, i: int) -> Lyapunov:
        figures = {name: getattr(self, name)[i].item() for name in _FIGURES}
        spectrum = self.spectrum[i] if self.spectrum else ()
        return Lyapunov(**figures, outcome=LYAPUNOV_OUTCOMES[self.code[i]], modes=self.modes, spectrum=spectrum)


_FIGURES = ("exponent", "per_period", "error", "impacts")


def lyapunov_exponent(
    system: System | Machine,
    start: Start | None = None,
    *,
    modes: int = DEFAULT_MODES,
    impacts: int = 2000,
    discard: int = 500,
    every: bool = False,
) -> Lyapunov:
    """The largest Lyapunov exponent of a motion, or every one, from its linearised map impact by impact.

    The motion is simulated, and a small difference carried along with it: freely in flight, through the saltation
    matrix at every event. Of a periodic motion the exponents are the logarithms of the moduli of its multipliers, over
    the impacts of its cycle. (A motion that starts on an unstable one to the last bit may stay there: start beside it.)

    Parameters
    ----------
    system
        What moves: a bar or a structure under a clock, or a machine that switches its own valve.
    start
        Where the motion begins; that of `run` by default.
    impacts
        Impacts over which the growth is averaged, 20 or more. The average is weighted by exp(−1/(t(1 − t))), t from
        0 to 1 over them, which costs a chaotic motion a quarter more of error and gives a regular one many digits
        (Das et al. 2017).
    discard
        Impacts before them; in the second half of these the difference turns to where it grows fastest.
    every
        Whether all of them are wanted, in `Lyapunov.spectrum`: by Gram and Schmidt's columns at each impact (Benettin
        et al. 1980).

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode.

    References
    ----------
    S. Das, Y. Saiki, E. Sander, J. A. Yorke, Quantitative quasiperiodicity, Nonlinearity 30 (2017) 4111–4140.
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems, Meccanica 15 (1980) 9–30.

    Examples
    --------
    >>> from percuss import Load, Start, System, steady_states
    >>> from percuss.explore.lyapunov import lyapunov_exponent
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.77, 1.0))
    >>> _, orbit = steady_states(system).orbits
    >>> print(lyapunov_exponent(system, Start.orbit(orbit, velocity=[0.01]), modes=0))
    Lyapunov exponent -0.130572 ± ... per impact, -0.130572 per load period (2000 impacts, 0 modes)
    """
    used, before = _numbers(impacts, discard)
    if not isinstance(system, Machine):
        instance("system", system, System)
    return _one(system, start, modes, used, before, flag("every", every))


def lyapunov_many(
    systems: System | Machine | Sequence[System | Machine],
    starts: Start | Starts | Sequence[Start] | None = None,
    *,
    modes: int = DEFAULT_MODES,
    impacts: int = 2000,
    discard: int = 500,
    every: bool = False,
    workers: int | None = None,
) -> LyapunovMany:
    """The largest Lyapunov exponents of many motions, or all; each is what `lyapunov_exponent` gives.

    Parameters
    ----------
    systems, starts
        One of them for all, or as many as members; `Start.rigid()` by default.
    modes, impacts, discard, every
        See `lyapunov_exponent`.
    workers
        How many threads; by default as many as cores. The results are the same for any number.
    """
    used, before, all_of_them = *_numbers(impacts, discard), flag("every", every)
    given: Any = [systems] if isinstance(systems, System | Machine) else systems
    whole: list[System | Machine] = list(several("systems", given, "a System or a Machine, or a list of them"))
    for system in whole:
        if not isinstance(system, Machine):
            instance("systems", system, System)
    begins: Any = [starts] if starts is None or isinstance(starts, Start) else starts
    if starts is not None and not isinstance(begins, Starts):
        begins = [instance("starts", one, Start) for one in several("starts", begins, "a Start, Starts, or a list")]
    members = max(len(whole), len(begins))
    if {len(whole), len(begins)} - {1, members} or not whole:
        told = f"{len(whole)} systems and {len(begins)} starts"
        raise ParameterError("starts", told, "as many starts as systems, or one of either")
    number = at_once(workers)

    def one(i: int) -> Lyapunov:
        try:
            return _one(whole[i % len(whole)], begins[i % len(begins)], modes, used, before, all_of_them)
        except ResonanceError:
            return Lyapunov(*_NONE, 0, "resonance", modes)

    found = on_threads(one, range(members), number)
    figures = {name: np.array([getattr(one, name) for one in found]) for name in _FIGURES}
    code = np.array([LYAPUNOV_OUTCOMES.index(one.outcome) for one in found], dtype=np.int8)
    return LyapunovMany(
        **figures, code=code, modes=modes, spectrum=tuple(one.spectrum for one in found) if every else ()
    )


def _numbers(impacts: int, discard: int) -> tuple[int, int]:
    return count("impacts", impacts, least=_BATCHES, most=10**7), count("discard", discard, least=2, most=10**7)


def _one(
    system: System | Machine, start: Start | None, modes: int, impacts: int, discard: int, every: bool
) -> Lyapunov:
    if isinstance(system, Machine) and system.valve.flows:
        settled = run(system, start, modes=modes, stop=Stop(impacts=discard, periodic=False))
        return _of_oil(system, settled, impacts, every)
    motion = run(system, start, modes=modes, stop=Stop(impacts=impacts + discard + 1, periodic=False))
    return _of(motion, impacts, discard, every)


def _of_oil(machine: Machine, motion: Trajectory, impacts: int, every: bool) -> Lyapunov:
    """The exponent of a machine whose oil flows, from where a motion of it has ended on."""
    from percuss.simulate.oil import FlowingOil
    from percuss.steady.oil.oil_cycle import growths_from

    if motion.outcome != "impacts":
        return Lyapunov(*(_ERASED if motion.outcome == "rest" else _NONE), 0, motion.outcome, motion.modes)
    onward = FlowingOil.restored(machine, motion.modes, motion.snapshot).motion
    found = growths_from(onward, impacts, every)
    blows = found.blows
    used, times = np.repeat(found.growth / blows[:, None], blows, axis=0), np.repeat(found.times / blows, blows)
    if len(used) <= _BATCHES:
        return Lyapunov(*_NONE, len(used), "stalls", motion.modes)
    return _averaged(used, times, "done" if found.whole else "stalls", motion.modes, 1.0, every)


def _of(motion: Trajectory, impacts: int, discard: int, every: bool = False) -> Lyapunov:
    """The exponent of a simulated motion, over at most so many impacts after the first `discard`."""
    from percuss.explore.tangent import growths  # only here is the compiler needed

    outcome = "done" if motion.outcome == "impacts" else motion.outcome
    code = motion.events.code
    struck, rests = np.flatnonzero(code == _IMPACT), np.flatnonzero(code == _REST)
    if outcome in ("departed", "stalls"):
        return Lyapunov(*_NONE, 0, outcome, motion.modes)
    later = struck[discard] if struck.size > discard else code.size
    left = max(struck.size - discard, 0)
    # what a machine rests from, its pressure and its orders remember; and of a structure the modes that the wall holds
    held = motion.is_clocked and isinstance(motion.system.body, HeldBody) and motion.modes > 1
    forgets = motion.is_clocked and not held
    if held and outcome == "rest":
        slowest = float(held_structure(motion.system, motion.modes).exponents[0].real.max())
        own = (-math.inf if slowest < 0.0 else 0.0, _TURN * slowest, 0.0)
        return Lyapunov(*own, left, "rest", motion.modes, own[:1] * (2 * motion.modes) if every else ())
    if outcome == "rest" or (forgets and rests.size and rests[-1] > later):
        return Lyapunov(*_ERASED, left, "rest", motion.modes)
    if struck.size <= discard + _BATCHES:
        return Lyapunov(*_NONE, left, outcome, motion.modes)
    first = struck[discard // 2]
    rests = rests[rests < later] if forgets else rests[:0]
    if rests.size and rests[-1] > first:  # no difference survived it
        first = struck[np.searchsorted(struck, rests[-1])]
    growth = growths(motion, int(first), every)
    wanted = struck[discard:]
    used = growth[-wanted.size + 1 :] if len(growth) >= wanted.size - 1 else growth
    if not np.all(np.isfinite(used[:, 0])):
        erased = "rest" if np.count_nonzero(code[later:] == _REST) else outcome
        return Lyapunov(*_ERASED, len(used), erased, motion.modes, (-math.inf,) * used.shape[1] if every else ())
    times = np.diff(motion.events.period[wanted]) * _TURN + np.diff(motion.events.phase[wanted])
    return _averaged(used, times, outcome, motion.modes, _TURN if motion.is_clocked else 1.0, every)


def _averaged(used: Array, times: Array, outcome: str, modes: int, turn: float, every: bool) -> Lyapunov:
    """Of the logarithms of the growth at each impact, (impacts, exponents), and the times to each."""
    t = np.arange(1, len(used) + 1) / (len(used) + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    weight /= weight.sum()
    mean = float(weight @ used[:, 0])
    spectrum: tuple[float, ...] = ()
    if every:
        dies = ~np.isfinite(used).all(axis=0)
        means = np.where(dies, -np.inf, weight @ np.where(dies, 0.0, used))
        spectrum = tuple(sorted(means.tolist(), reverse=True))
    rate = turn * mean / float(weight @ times)
    return Lyapunov(mean, rate, _error(used[:, 0], weight), len(used), outcome, modes, spectrum)


def _error(growth: Array, weight: Array) -> float:
    """Standard error of the weighted mean, from the means of stretches that hardly know of each other."""
    parts = np.array_split(growth, _BATCHES)
    means, heavy = np.array([p.mean() for p in parts]), [w.sum() for w in np.array_split(weight, _BATCHES)]
    return float(means.std(ddof=1) * math.sqrt(float(np.sum(np.square(heavy)))))
