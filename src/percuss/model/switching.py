"""Whether a load switches back and forth between two levels, as a valve does.

The levels are found as for a pulse (IEEE Std 181): the medians of the values above and below the middle of the range.
The load switches when it is within 15 % of their distance of one of them for at least 70 % of the period. A square wave
is for 100 % of it, one of five harmonics for 87 %, a trapezoid with edges of a fifth of the period for 72 %; a harmonic
load is for 41 %, a triangle for 30 %.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model.checks import Array, instance
from percuss.model.load import Load

__all__ = ["LEAST_SHARE", "NEAR", "Switching", "switching_of"]

NEAR = 0.15
"""How near a level, as a part of the distance of the two, the load counts as at it."""

LEAST_SHARE = 0.7
"""Part of the period from which on a load at its levels switches."""

_SAMPLES = 2048
_PER_HARMONIC = 8


@dataclass(frozen=True)
class Switching:
    """The two levels of a load that switches.

    Attributes
    ----------
    high, low
        In the unit of the load.
    share
        Part of the period that it is at one of them.
    """

    high: float
    low: float
    share: float


def switching_of(load: Load) -> Switching | None:
    """The levels of a load that switches between two, or None.

    None too for a clipped record: the levels are then those of the sensor, and what lay beyond them is unknown.

    Examples
    --------
    >>> from percuss import Load
    >>> switching_of(Load.harmonic(0.9, 1.0)) is None
    True
    >>> switching_of(Load.square(2.0, 1.3))
    Switching(high=2.0, low=-2.0, share=1.0)
    """
    instance("load", load, Load)
    if load.is_constant or (load.report is not None and load.report.clipped):
        return None
    values = _period(load)
    above = values > 0.5 * (float(values.max()) + float(values.min()))
    high, low = float(np.median(values[above])), float(np.median(values[~above]))
    away = np.minimum(np.abs(values - high), np.abs(values - low))
    share = float(np.mean(away <= NEAR * (high - low)))
    return Switching(high, low, share) if share >= LEAST_SHARE else None


def _period(load: Load) -> Array:
    """The load at evenly spaced phases."""
    size = load.coefficients.size
    n = max(_SAMPLES, _PER_HARMONIC * size)
    if load.is_piecewise:
        return load.value(2.0 * np.pi * (np.arange(n) + 0.5) / n)
    waves = np.zeros(n, dtype=complex)
    waves[:size] = load.coefficients
    return np.asarray(n * np.fft.ifft(waves).real)
