"""Whether a machine does the same again: its whole state at the ends of load periods, compared."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from percuss.model.checks import Array

__all__ = ["MOST_PERIODS", "Recurrence", "Settled"]

MOST_PERIODS = 16
"""The longest cycle that is looked for."""

_CONFIRMED = 2
_NEAR = 100.0  # times the tolerance


@dataclass(frozen=True)
class Settled:
    """A periodic motion: after so many load periods with so many impacts the state is the same.

    Attributes
    ----------
    impacts, periods
        p and n of its label z = p/n.
    returned
        How near the state came back, as `Limits.tolerance` measures it.
    """

    impacts: int
    periods: int
    returned: float


class Recurrence:
    """The last states at the ends of load periods."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._states: deque[tuple[float, Array]] = deque(maxlen=MOST_PERIODS)
        self._seen = [0] * (MOST_PERIODS + 1)

    def after(self, gap: float, waves: Array, speed: float) -> tuple[int, float]:
        """How many periods ago the state was the same, twice in a row, and how nearly; 0 when it never was.

        A motion that comes nearer to a shorter cycle is not settled on a longer one before it.
        """
        found, apart = (0, math.inf), [math.inf] * (MOST_PERIODS + 1)
        for periods, (old_gap, old) in enumerate(reversed(self._states), 1):
            off = float(np.linalg.norm(waves - old)) + abs(gap - old_gap) / (2.0 * math.pi)
            apart[periods] = off / speed if speed > 0.0 else math.inf if off > 0.0 else 0.0
            same = apart[periods] <= self.tolerance
            self._seen[periods] = self._seen[periods] + 1 if same else 0
            nearer = any(apart[part] <= _NEAR * self.tolerance for part in range(1, periods) if periods % part == 0)
            if not found[0] and self._seen[periods] >= _CONFIRMED and not nearer:
                found = periods, apart[periods]
        self._states.append((gap, waves))
        return found
