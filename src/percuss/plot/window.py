"""The part of a simulated motion that its picture shows at full resolution: the last cycles or flights."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from percuss.model.checks import Array
    from percuss.simulate import Events, Trajectory

__all__ = ["Window", "window_of"]

_TURN = 2.0 * math.pi

LONG_CYCLE = 12
"""Load periods of a cycle that is too long to be shown twice."""

MOST_VALUES = 4_000_000
"""Samples times modes."""


@dataclass(frozen=True)
class Window:
    """A stretch of a motion from `first` to `last` (rad), with a word for what it is."""

    motion: Trajectory
    first: float
    last: float
    what: str

    @cached_property
    def events(self) -> Events:
        """The events of the stretch."""
        time = self.motion.events.time
        return self.motion.events[(time >= self.first) & (time <= self.last)]

    def _grid(self, points: int) -> Array:
        most = max(MOST_VALUES // (self.motion.modes + 1), 200)
        return np.linspace(self.first, self.last, min(points, most))

    @cached_property
    def _jumps(self) -> Array:
        """Times of events, at most 500 of them, at which the velocity jumps."""
        times = np.unique(np.clip(self.events.time, self.first, self.last))
        return times[-500:]

    @cached_property
    def times(self) -> Array:
        """Sample times, those of the events among them."""
        return np.unique(np.concatenate([self._grid(2400), self._jumps]))

    @cached_property
    def gap(self) -> Array:
        """The gap at `times`."""
        return np.minimum(self.motion.gap(self.times), 0.0)

    @cached_property
    def velocity(self) -> tuple[Array, Array]:
        """Times, each event's twice, and the velocity of the striking end there."""
        return self._both_sides(lambda t, side: self.motion.bar_velocity(1.0, t, side)[0])

    @cached_property
    def energy(self) -> tuple[Array, Array]:
        """Times, each event's twice, and the energy of the bar there."""
        return self._both_sides(lambda t, side: self.motion.energy(t, side))

    def _both_sides(self, quantity: Any) -> tuple[Array, Array]:
        times = np.concatenate([self._jumps, self.times])
        values = np.concatenate([quantity(self._jumps, "left"), quantity(self.times, "right")])
        order = np.argsort(times, kind="stable")  # the side before an event comes first
        return times[order], values[order]

    @cached_property
    def strain(self) -> tuple[Array, Array, float, float]:
        """Places, shape (101,), the strain there, shape (101, samples), and the first and the last time of it.

        Of the end of the stretch only: a cycle or two load periods, in which the waves can be told apart.
        """
        trips = 240.0 * self.motion.system.body.transit_time  # 120 times to the other end and back
        first = max(self.first, self.last - min(max(0.5 * (self.last - self.first), 2.0 * _TURN), trips))
        times = np.linspace(first, self.last, min(720, max(MOST_VALUES // (self.motion.modes + 1), 200)))
        x = np.linspace(0.0, 1.0, 101)
        return x, self.motion.strain(x, times), first, self.last


def window_of(motion: Trajectory) -> Window:
    """Two cycles of a periodic motion; all of a short motion; the last eight load periods and four blows of another."""
    first, last = motion.begin_time, motion.end_time
    cycle = re.fullmatch(r"(?:z=\d+|chatter|rest)/(\d+)", motion.label)
    if cycle is not None and int(cycle[1]) <= LONG_CYCLE:
        start = last - 2.0 * int(cycle[1]) * _TURN
        return Window(motion, max(start, first), last, "the last two cycles")
    blows = motion.events.of("impact").time[motion.main_blows]
    few = blows.size <= 60 and (last - first <= 12.0 * _TURN or motion.system.load.is_constant)
    if few or blows.size < 4:
        return Window(motion, first, last, "the whole motion")
    start = min(last - 8.0 * _TURN, float(blows[-4]))
    return Window(motion, max(start, first), last, "the last flights")
