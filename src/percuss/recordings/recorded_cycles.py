"""Where in its cycle each sample of a record lies, by the alignment that its load was made with."""

from __future__ import annotations

import numpy as np

from percuss.recordings.arrays import Array
from percuss.recordings.cycle_fit import CycleFit
from percuss.recordings.repetition import found_period

__all__ = ["recorded_phases"]


def recorded_phases(time: Array, values: Array, frequency: float | None) -> Array:
    """The phase of the load (rad) at every sample, increasing, 0 at the first one; shape (n,).

    Parameters
    ----------
    time, values
        Shape (n,): the record, s and any unit.
    frequency
        Of the fundamental, Hz, as `analyse` found it; None to find it.

    Raises
    ------
    HistoryError
        When the record holds no two cycles of that frequency.
    """
    t = time - time[0]
    middle, scale = 0.5 * (np.max(values) + np.min(values)), 0.5 * float(np.ptp(values))
    v = (values - middle) / (scale or 1.0)
    fit = CycleFit(t, v, found_period(t, v) if frequency is None else 1.0 / frequency, None)
    turns = np.interp(t, fit.bounds, np.arange(fit.bounds.size, dtype=float))
    beyond = t > fit.bounds[-1]
    turns[beyond] += (t[beyond] - fit.bounds[-1]) / fit.period
    return np.asarray(2.0 * np.pi * (turns - turns[0]))
