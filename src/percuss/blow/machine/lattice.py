"""Sections on a lattice: a wave takes one step through a cell, and a load period is a whole number of steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["Lattice", "lattice_of"]

_TURN = 2.0 * math.pi
_SPREAD = 2.0  # times the steps asked for are the most that are tried
_ENOUGH = 1e-6  # rounding of the transit times that needs no further search
_AT_ONCE = 4096
_MOST_TRIED = 100_000
MOST_STEPS = 8_000_000
"""Steps of a load period: the work and the memory of a machine whose waves are very fast."""


@dataclass(frozen=True)
class Lattice(Shown):
    """Cells that all sections are cut into.

    The masses keep their ratios to the whole, which is 1, and the impedances theirs to one another: all that rounding
    changes is how long waves take.

    Attributes
    ----------
    steps
        Of a load period.
    step
        Length of one in radians, 2π/`steps`.
    cells
        Of each section of the striker, then of the rod.
    striker
        How many of the sections are the striker's.
    impedances
        Of all sections; dimensionless, the striker's mass Σ Z_i n_i Δt is 1.
    rounding
        The greatest change of a section's transit time, over that of the striker.
    """

    steps: int
    step: float
    cells: tuple[int, ...]
    striker: int
    impedances: tuple[float, ...]
    rounding: float


def lattice_of(impedances: Array, transit_times: Array, striker: int, cells: int) -> Lattice:
    """The lattice that rounds the transit times least of those with so many cells in the striker, up to twice as many.

    Parameters
    ----------
    impedances, transit_times
        Of the striker's sections, then of the rod's; dimensionless.
    striker
        How many are the striker's.
    cells
        In the striker, at least.

    Raises
    ------
    ParameterError
        When a load period would need too many steps, or a section gets no cell.
    """
    whole = float(transit_times[:striker].sum())
    least = math.ceil(_TURN / whole * cells)
    if least > MOST_STEPS:
        wanted = f"a wave that takes at least {_TURN * cells / MOST_STEPS:.3g} radians through the bar"
        raise ParameterError("s", 1.0 / whole, wanted, "give fewer cells, or treat the impact as instantaneous")
    best, rounding = _best(transit_times, whole, least, math.ceil(_SPREAD * least) + 64)
    step = _TURN / best
    numbers = np.maximum(np.rint(transit_times / step), 1.0)
    scale = 1.0 / float((impedances * numbers * step)[:striker].sum())
    return Lattice(best, step, tuple(int(n) for n in numbers), striker, tuple((scale * impedances).tolist()), rounding)


def _best(transit_times: Array, whole: float, least: int, most: int) -> tuple[int, float]:
    """The first number of steps that rounds the transit times by nothing to speak of, else the one that does least."""
    best, rounding = 0, math.inf
    stride = -(-(most - least) // _MOST_TRIED)
    for start in range(least, most, _AT_ONCE * stride):
        tried = np.arange(start, min(start + _AT_ONCE * stride, most), stride)
        off = _rounding(transit_times, whole, tried)
        if off.min() < rounding:
            best, rounding = int(tried[off.argmin()]), float(off.min())
        if rounding <= _ENOUGH:
            break
    tried = np.arange(max(best - stride, least), best + stride + 1)
    off = _rounding(transit_times, whole, tried)
    return int(tried[off.argmin()]), float(off.min())


def _rounding(transit_times: Array, whole: float, tried: npt.NDArray[np.int64]) -> Array:
    steps = transit_times[None, :] * (tried[:, None] / _TURN)
    changes = np.abs(np.maximum(np.rint(steps), 1.0) - steps).max(axis=1)
    return np.asarray(changes * _TURN / tried / whole)
