"""The compiled functions for orbits, loaded where they are first used, as loading the compiler takes long."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.kernel_cache import ensure_cache
from percuss.mechanics.flow import Propagator
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.oscillator import refuse_resonance
from percuss.steady.periodic.impact_chain import Blocks, ImpactChain, Passage


class OrbitKernels(NamedTuple):
    """What Python calls; `percuss.steady.periodic.kernels` says what each does."""

    search: Callable[..., None]
    corrected: Callable[..., tuple[int, int]]
    derivatives: Callable[..., None]
    singularity: Callable[..., float]
    flown: Callable[..., None]


@cache
def orbit_kernels() -> OrbitKernels:
    """Load them, from numba's cache if they are there; else each is compiled when it is first called."""
    ensure_cache()
    from percuss.steady.periodic.kernels import flying, searching
    from percuss.steady.periodic.kernels import searching as following
    from percuss.steady.periodic.kernels import searching as looking

    found: Any = (searching.search, following.corrected, following.derivatives, looking.singularity, flying.flown)
    return OrbitKernels(*found)


# ---- A system as the kernels take it: one row of numbers; and the arrays that they work in


@dataclass(frozen=True)
class Numbers:
    """A system with the modes 0 … N in one row, and how many of them there are.

    Parameters
    ----------
    row
        As `percuss.steady.periodic.kernels.orbit_records` says.
    modes, waves, steps
        N; harmonics of the load, or its steps.
    """

    row: Array = field(repr=False)
    modes: int
    waves: int
    steps: int

    def room(self, impacts: int) -> Any:
        """The arrays for orbits with p impacts."""
        from percuss.steady.periodic.kernels.orbit_records import room_for

        return room_for(self.modes, self.waves, self.steps, impacts)


@lru_cache(maxsize=64)
def numbers_of(system: System, modes: int) -> Numbers:
    """The numbers of a system; the last ones are kept. Not to be written into.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.
    """
    refuse_resonance(system)
    load, contact = system.load, system.contact
    known = system.body.modes(modes, load.at)
    is_free = system.body.is_free
    row = [load.mean, system.push, system.d, contact.strain_factor, contact.velocity_factor]
    row += [float(is_free), system.body.gap]
    for values in (known.omega, known.damping, known.gamma):
        row += values.tolist()
    if load.is_piecewise:
        return Numbers(np.array([*row, *load.breaks, *load.values]), modes, 0, len(load.breaks))
    k = load.harmonics
    p = load.coefficients[k]
    return Numbers(np.array([*row, *k.tolist(), *p.real.tolist(), *p.imag.tolist()]), modes, k.size, 0)


# ---- Newton's method on the times of the impacts, for many starts at once, led away from what is known (deflation)
#
# Roots that are known are made poles: with G = F Π (1 + 1/d_k²), d_k the distance to root k, the step is that of F
# times one number (Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026–A2045), so that deflation costs no
# solve.

_STEPS = 60
_FRESH = -1  # of `settling`: not begun
_AT_ONCE = 1 << 20  # modes × impacts² × steps in a call, a tenth of a second: between calls it can be halted
COALESCED = 1e-9
"""Share of the period below which a flight has vanished."""


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
    """Follow starts of the shape (B, p) to impact times that belong to orbits, by compiled functions.

    Parameters
    ----------
    chain
        The equations.
    times
        In order, each row within a period.
    known
        Roots to keep away from, shape (K, p).
    turn
        After how long the load repeats.
    """
    p, system = chain.impacts, numbers_of(chain.system, chain.modes)
    times = np.array(times, dtype=float, ndmin=2)
    rebound, outcome = np.zeros(times.shape[0]), np.zeros(times.shape[0], dtype=np.int64)
    settling = np.full(times.shape[0], _FRESH, dtype=np.int64)
    roots = np.empty((0, p)) if known is None else np.ascontiguousarray(known, dtype=float)
    work = p * (p + 4) * (system.modes + 1) + p * roots.size
    rows, steps = max(1, _AT_ONCE // (work * _STEPS)), min(_STEPS, max(1, _AT_ONCE // work))
    for first in range(0, times.shape[0], rows):
        some = slice(first, first + rows)
        for done in range(0, _STEPS, steps):
            look()
            orbit_kernels().search(
                system.row, system.room(p), chain.period, turn, chain.is_neutral, roots, min(steps, _STEPS - done),
                times[some], rebound[some], settling[some], outcome[some],
            )  # fmt: skip
    return Ended(times, rebound, outcome)


# ---- The motion through impacts at given times, as `ImpactChain.passage` has it: one orbit, by compiled functions

_GIVEN = 0  # as in the kernels: the velocity after the first impact
_TIME, _FLIGHT, _FORCE, _, _, _FADE, _STAY, _RIGID, _REBOUND, _SPEED, _OFF = range(11)  # rows of `impacts`


def compiled_passage(chain: ImpactChain, times: Array, rebound: float) -> tuple[Passage, float, float]:
    """The motion through impacts at times of the shape (p,), the mean velocity just after the first one given.

    With it det K(1) and det K(−1), each row taken by its length.
    """
    numbers = numbers_of(chain.system, chain.modes)
    room = numbers.room(chain.impacts)
    flip, fold = (
        orbit_kernels().singularity(numbers.row, room, chain.period, times, _GIVEN, rebound, xi) for xi in (-1.0, 1.0)
    )
    rows = room.impacts
    a, b, c, e, u, v, f, rate = room.carried.transpose(0, 2, 1)
    known, contact = chain.known, chain.system.contact
    passage = Passage(
        times=rows[_TIME],
        flights=rows[_FLIGHT],
        force=rows[_FORCE],
        step=Propagator(a, b, c, e, np.full_like(a, np.nan), np.full_like(a, np.nan)),  # the last two serve one impact
        fade=rows[_FADE],
        stay=rows[_STAY],
        rigid=rows[_RIGID],
        rebound=rows[_REBOUND],
        displacement=u,
        velocity=v,
        forced=f,
        forced_velocity=rate,
        speed=rows[_SPEED],
        gap=rows[_OFF],
        closure=room.whole[0],
        blocks=Blocks.of(contact, known.damping, known.omega, (a, b, c, e), rows[_FLIGHT]),
    )
    return passage, fold, flip
