"""Newton's method on the times of the impacts, for many starts at once, led away from what is known (deflation).

Roots that are known are made poles: with G = F Π (1 + 1/d_k²), d_k the distance to root k, the step is that of F times
one number (Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026–A2045), so that deflation costs no solve.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model.checks import Array
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.system_numbers import numbers_of

__all__ = ["COALESCED", "Ended", "Outcome", "newton"]

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
