"""A blow that was followed: its waves in the scales of the blow, and the sums of them that results are made of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from percuss.blow.kernels.layout import FAR, WALL
from percuss.blow.kernels.sums import integrals, value_before
from percuss.blow.tables import Tables
from percuss.blow.trace import Trace
from percuss.model.checks import Array

__all__ = ["Course", "Sums"]


class Sums(NamedTuple):
    """∫ p dt, ∫ p² dt and ∫ p (t − begin) dt."""

    plain: float
    square: float
    moment: float


@dataclass(frozen=True, eq=False)
class Course:
    """A blow until the tick `end`.

    Row 2i is the wave to the right in section i by the time at which it leaves the section's left end, row 2i + 1 that
    to the left; sections are counted from the driven end through the face to the far end.
    """

    held: Tables
    end: int
    first_gap: float

    @property
    def striker(self) -> int:
        """Number of sections of the striker."""
        return self.held.problem.striker

    @property
    def size(self) -> int:
        """Number of all sections."""
        return int(self.held.problem.impedance.size)

    @property
    def tick(self) -> float:
        return self.held.problem.tick

    @cached_property
    def impedance(self) -> Array:
        return self.held.problem.impedance

    @cached_property
    def transit(self) -> list[int]:
        """Ticks; 0 of an endless section."""
        return [int(t) for t in self.held.problem.transit]

    @cached_property
    def mass(self) -> float:
        """Of the striker."""
        return float(sum(self.impedance[i] * self.transit[i] * self.tick for i in range(self.striker)))

    @property
    def has_rod(self) -> bool:
        return self.held.problem.end != WALL

    @cached_property
    def turns(self) -> list[int]:
        """Ticks at which the faces met and parted, in turn."""
        now = self.held.state.now[0]
        return [int(t) for t in self.held.state.contact[: now.noted] if t < self.end]

    @property
    def in_contact(self) -> bool:
        """Whether the faces are pressed together at the end of the window."""
        return len(self.turns) % 2 == 1

    def endless(self, section: int) -> bool:
        """Whether a section has no end."""
        return self.transit[section] == 0

    def sums(self, row: int, begin: int, end: int) -> Sums:
        """Of what leaves from one tick to another."""
        return Sums(*integrals(self.held.waves, row, begin, end, self.tick, self.held.state.work))

    def value(self, row: int, time: int) -> float:
        """What leaves just before a tick, so that several rows tell of the same side of a jump."""
        return float(value_before(self.held.waves, row, time, self.held.problem.near, self.held.state.work))

    def section_sums(self, section: int, time: int) -> tuple[Sums, Sums]:
        """Of both waves over a section at a tick, f first; of an endless one over all that was sent into it."""
        start = 0 if self.endless(section) else time - self.transit[section]
        return self.sums(2 * section, start, time), self.sums(2 * section + 1, start, time)

    def energy(self, first: int, last: int, time: int) -> float:
        """Kinetic and strain energy in the sections from `first` to before `last`."""
        found = 0.0
        for i in range(first, last):
            f, g = self.section_sums(i, time)
            found += float(self.impedance[i]) * (f.square + g.square)
        return found

    def momentum(self, first: int, last: int, time: int) -> float:
        """Likewise."""
        found = 0.0
        for i in range(first, last):
            f, g = self.section_sums(i, time)
            found += float(self.impedance[i]) * (f.plain + g.plain)
        return found

    def node_velocity(self, section: int, time: int) -> float:
        """Velocity of the left end of a section."""
        return self.value(2 * section, time) + self.value(2 * section + 1, time - self.transit[section])

    def travelled(self, section: int, begin: int, end: int) -> float:
        """How far the left end of a section moves."""
        back = self.transit[section]
        return self.sums(2 * section, begin, end).plain + self.sums(2 * section + 1, begin - back, end - back).plain

    def trace(self, row: int, shift: int = 0, first: int = 0, last: int | None = None) -> Trace:
        """A row, as it leaves or `shift` ticks later, over the window or from one tick to another, in its scales."""
        last = self.end if last is None else last
        waves = self.held.waves
        size = int(waves.pieces[row])
        starts = np.append(waves.start[row, :size], waves.known[row] if waves.known[row] < FAR else FAR)
        starts = np.where(abs(starts) >= FAR, np.sign(starts) * FAR, starts + shift)
        here = np.flatnonzero((starts[:-1] < last) & (starts[1:] > first))
        low, high = int(here[0]), int(here[-1]) + 1
        degrees, rest = waves.degree[row, low:high], waves.rest[row, low:high]
        coefficients = np.zeros((high - low, int(degrees.max()) + 1))
        coefficients[:, 0] = waves.first[row, low:high]
        for k in range(1, coefficients.shape[1]):
            bent = np.flatnonzero(degrees >= k)
            coefficients[bent, k] = waves.pool[rest[bent] + k - 1]
        edges = starts[low : high + 1].copy()
        for k in sorted({0, high - low - 1}):
            begin, end = max(first, int(edges[k])), min(last, int(edges[k + 1]))
            if degrees[k] and (begin, end) != (edges[k], edges[k + 1]):
                span = 2.0 / float(edges[k + 1] - edges[k])
                at = span * (np.array([begin, end]) - edges[k]) - 1.0
                coefficients[k] = _restricted(coefficients[k], float(at[0]), float(at[1]))
        edges[0], edges[-1] = first, last
        wide = (
            np.diff(edges) > self.held.problem.near
        )  # a break next to an end of the window leaves a piece of no width
        wide[0] |= not wide.any()
        edges = np.append(edges[:-1][wide], last)
        edges[0] = first
        return Trace(edges * self.tick, coefficients[wide])


def _restricted(row: Array, low: float, high: float) -> Array:
    """A Chebyshev series on [low, high] as one on [−1, 1]."""
    n = row.size - 1
    angles = np.pi * (np.arange(n + 1) + 0.5) / (n + 1)
    values = np.polynomial.chebyshev.chebval(0.5 * (low + high) + 0.5 * (high - low) * np.cos(angles), row)
    found = 2.0 / (n + 1) * (np.cos(np.outer(np.arange(n + 1), angles)) @ values)
    found[0] *= 0.5
    return np.asarray(found)
