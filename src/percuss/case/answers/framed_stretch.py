"""Which stretch of a simulated motion is framed: its first periods, or whole cycles of what it settles on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.simulate.events import IMPACT

if TYPE_CHECKING:
    from percuss.simulate import Trajectory

__all__ = ["Stretch", "stretch_of"]

_FEWEST = 240
"""Points of the striking end's history that a cycle has at least, however often it is told."""

Array = npt.NDArray[np.float64]

_TURN = 2.0 * math.pi
_NEAR = 1e-5
"""Rad within which an impact of a cycle and the one of the cycle after are at the same place."""


@dataclass(frozen=True)
class Stretch:
    """A stretch of a motion, which may be told several times over: one that repeats is simulated for few cycles.

    Attributes
    ----------
    motion
        Of which it is.
    begin, end
        The part of the simulation that it shows, in rad.
    copies
        How often.
    """

    motion: Trajectory
    begin: float
    end: float
    copies: int = 1

    @property
    def once(self) -> float:
        """Rad that are told once."""
        return self.end - self.begin

    @property
    def length(self) -> float:
        """Rad in all."""
        return self.copies * self.once

    def moments(self, times: Array) -> Array:
        """Times of the simulation that stand for `times` after the beginning of the stretch."""
        if self.copies == 1:
            return np.clip(self.begin + times, self.begin, self.end)
        return self.begin + np.where(times >= self.length, self.once, np.mod(times, self.once))

    def events(self) -> list[tuple[int, float]]:
        """Numbers of the events, and their times after the beginning; where copies join there is one and not two."""
        time = self.motion.events.time
        inside = np.flatnonzero((time >= self.begin) & (time <= self.end))
        later = inside[time[inside] > self.begin + _NEAR]
        first = [(int(i), float(time[i] - self.begin)) for i in inside]
        return first + [
            (int(i), float(time[i] - self.begin) + k * self.once) for k in range(1, self.copies) for i in later
        ]

    def end_point(self, points: int) -> tuple[Array, Array, Array]:
        """Time after the beginning, gap and velocity of the striking end; NaN where its velocity jumps."""
        time = self.motion.events.time
        jumps = time[(time >= self.begin) & (time <= self.end)]
        each = max(points // self.copies, min(points, _FEWEST))
        times, gap, velocity = _history(self.motion, self.begin, self.end, jumps, each)
        times = times - self.begin
        parts = [(times, gap, velocity)]
        later = times > _NEAR
        parts += [(times[later] + k * self.once, gap[later], velocity[later]) for k in range(1, self.copies)]
        found = [np.concatenate([part[i] for part in parts]) for i in range(3)]
        return found[0], found[1], found[2]


def stretch_of(motion: Trajectory, settled: bool, cycles: int) -> Stretch:
    """The first load periods of a motion, or what it settles on.

    A periodic motion is shown from an impact on, in whole cycles and never with anything of the way there: where it was
    followed for fewer cycles than are wanted, the last one is told again.

    Parameters
    ----------
    settled
        What it settles on.
    cycles
        Load periods.
    """
    first, last = motion.begin_time, motion.end_time
    length = cycles * _TURN
    if not settled:
        return Stretch(motion, first, min(first + length, last))
    if motion.cycle is None:
        return Stretch(motion, max(last - length, first, _half(motion)), last)
    once = motion.cycle.periods * _TURN
    wanted = max(cycles // motion.cycle.periods, 1)
    struck = motion.events.time[motion.events.code == IMPACT]
    begun = float(struck[motion.cycle.first])
    last = float(struck[-1])
    known = math.floor((last - begun + _NEAR) / once)  # whole cycles
    if known < wanted:
        begin = _impact(struck, last - once)
        return Stretch(motion, begin, _impact(struck, begin + once), wanted)
    begin = _impact(struck, last - wanted * once)
    return Stretch(motion, begin, _impact(struck, begin + wanted * once))


def _half(motion: Trajectory) -> float:
    """From when on a motion without a cycle may count as settled: its second half, if it has enough impacts."""
    struck = motion.events.time[motion.events.code == IMPACT]
    return float(struck[motion.summary.first]) if motion.summary.first else motion.begin_time


def _impact(struck: Array, time: float) -> float:
    """The last impact until then, with some room for rounding."""
    before = struck[struck <= time + _NEAR]
    return float(before[-1]) if before.size else time


def _history(motion: Trajectory, begin: float, end: float, jumps: Array, points: int) -> tuple[Array, Array, Array]:
    """Time, gap and velocity of the striking end: equal steps, and both sides of every jump with NaN between them."""
    if jumps.size > points // 4:
        jumps = jumps[:0]
    times = np.linspace(begin, end, max(points - 3 * jumps.size, 2))
    gap, velocity = motion.gap(times), motion.bar_velocity(1.0, times)[0]
    if not jumps.size:
        return times, gap, velocity
    before, after = (motion.bar_velocity(1.0, jumps, side)[0] for side in ("left", "right"))
    touch, nothing = motion.gap(jumps), np.full(jumps.size, np.nan)
    rank = np.concatenate([np.zeros(times.size), *(np.full(jumps.size, i) for i in (1, 2, 3))])
    clock = np.concatenate([times, jumps, jumps, jumps])
    rows: tuple[npt.NDArray[Any], ...] = (
        clock,
        np.concatenate([gap, touch, nothing, touch]),
        np.concatenate([velocity, before, nothing, after]),
    )
    order = np.lexsort((rank, clock))
    return rows[0][order], rows[1][order], rows[2][order]
