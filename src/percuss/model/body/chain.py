"""A chain of sections as its mechanics see it: impedances, transit times, and which point lies in which section."""

from __future__ import annotations

from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, ComplexArray

__all__ = ["Chain", "Numbers", "chain", "sinc_deficit"]

Numbers = npt.NDArray[np.intp]
"""Numbers of sections, from 0 on."""

_SERIES_BELOW = 0.5


class Chain:
    """Sections from the driven end to the striking end, of mass 1 and length 1 together.

    Parameters
    ----------
    impedances, transit_times
        Of each section; only the ratios of the impedances matter.
    lengths
        Of each section; only their ratios matter. None takes the transit times for them.

    Attributes
    ----------
    impedance, transit
        Z_i with Σ Z_i τ_i = 1, and τ_i; shape (K,).
    before, after
        Mass on the driven end's and on the striking end's side of the sections' boundaries; shape (K + 1,).
    start, width
        Where sections begin, from 0 to 1, and their lengths; shape (K,).
    """

    def __init__(self, impedances: Array, transit_times: Array, lengths: Array | None = None) -> None:
        self.transit = transit_times
        self.impedance = impedances / np.dot(impedances, transit_times)
        mass = self.impedance * transit_times
        self.before = np.append(0.0, np.cumsum(mass))
        self.after = np.append(np.cumsum(mass[::-1])[::-1], 0.0)
        sizes = transit_times if lengths is None else lengths
        ends = np.cumsum(sizes)
        self.start, self.width = np.append(0.0, ends[:-1]) / ends[-1], sizes / ends[-1]

    @property
    def size(self) -> int:
        """K."""
        return self.transit.size

    @cached_property
    def mirrored(self) -> Chain:
        """The same bar turned round."""
        return Chain(self.impedance[::-1], self.transit[::-1], self.width[::-1])

    @cached_property
    def slowness(self) -> Array:
        """Time of a wave per length, shape (K,): slopes along x are these times slopes along the wave's time."""
        return np.asarray(self.transit / self.width)

    @cached_property
    def stiffness(self) -> Array:
        """Force per strain, shape (K,)."""
        return np.asarray(self.impedance / self.slowness)

    @cached_property
    def lag(self) -> float:
        """Most by which the steps together can turn the phase of a wave: Σ arcsin |reflection coefficient|."""
        steps = pairwise(self.impedance.tolist())
        return float(sum(np.arcsin(abs(one - other) / (one + other)) for one, other in steps))

    def locate(self, x: Array) -> tuple[Numbers, Array]:
        """The section of each point, the later one at a step, and the time of a wave from its start to the point."""
        section = np.searchsorted(self.start[1:], x, side="right")
        begin, end = self.start[section], np.append(self.start[1:], 1.0)[section]  # a step is nowhere else
        share = np.clip((x - begin) / np.where(end > begin, end - begin, 1.0), 0.0, 1.0)
        return section, share * self.transit[section]

    def masses(self, section: Numbers, time: Array) -> tuple[Array, Array]:
        """Mass on both sides of points; neither is a difference from 1."""
        z, left = self.impedance[section], self.transit[section] - time
        return self.before[section] + z * time, self.after[section + 1] + z * left


@lru_cache(maxsize=64)
def chain(
    impedances: tuple[float, ...], transit_times: tuple[float, ...], lengths: tuple[float, ...] | None, s: float
) -> Chain:
    """The chain whose transit times add up to 1/s."""
    times = np.asarray(transit_times) / (s * float(np.sum(transit_times)))
    return Chain(np.asarray(impedances), times, None if lengths is None else np.asarray(lengths))


def sinc_deficit(q: ComplexArray) -> ComplexArray:
    """1 − sin q/q without cancellation near 0, where it is q²/6; any shape."""
    near = np.abs(q) < _SERIES_BELOW
    square, far = np.where(near, q, 0.0) ** 2, np.where(near, 1.0, q)
    total = np.zeros_like(square)
    for j in range(9, 0, -1):
        total = square / (2 * j * (2 * j + 1)) * (1.0 - total)
    return np.asarray(np.where(near, total, 1.0 - np.sin(far) / far))
