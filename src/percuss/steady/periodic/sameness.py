"""Which impact times belong to one and the same orbit: shifts of the first impact, and by whole periods of the load."""

from __future__ import annotations

import math

import numpy as np

from percuss.model import Load
from percuss.model.checks import Array

__all__ = ["SAME", "canonical", "differences", "load_turn", "repeats"]

SAME = 1e-7
"""Impact times that are as near as this are the same, in radians of the load."""

TURN = 2.0 * math.pi
_ROUNDING = 1e-12


def load_turn(load: Load) -> float:
    """After how long the load repeats: 2π, or an even part of it, as where only its harmonics 2, 4, … are present."""
    if not load.is_piecewise:
        return TURN / math.gcd(*load.harmonics.tolist()) if load.harmonics.size else TURN
    breaks, values = np.asarray(load.breaks), np.asarray(load.values)
    for shift in range(1, breaks.size):  # by so many steps
        if breaks.size % shift:
            continue
        moved = np.mod(np.roll(breaks, -shift) - breaks, TURN)
        if np.ptp(moved) <= _ROUNDING and np.all(np.roll(values, -shift) == values):
            return float(moved[0])
    return TURN


def differences(times: Array, others: Array, period: float, turn: float) -> Array:
    """t_i − t'_{i+c} for every shift c of the first impact, moved by whole periods of the load to be least.

    Parameters
    ----------
    times
        Shape (…, p).
    others
        Times of K orbits, shape (K, p).
    period, turn
        T, and after how long the load repeats.

    Returns
    -------
    numpy.ndarray
        Shape (…, K, p, p): orbits, shifts, impacts.
    """
    p = others.shape[-1]
    endless = np.concatenate([others, others + period], axis=-1)
    shifted = np.stack([endless[:, c : c + p] for c in range(p)], axis=1)
    off = times[..., None, None, :] - shifted
    return np.asarray(off - turn * np.rint(off.mean(axis=-1, keepdims=True) / turn))


def repeats(times: Array, period: float, turn: float) -> int:
    """How often a shorter orbit is repeated in the cycle: 1 for none; `times` of shape (p,)."""
    p = times.size
    turns = round(period / turn)
    for often in range(math.gcd(p, turns), 1, -1):
        if p % often or turns % often:
            continue
        step = p // often
        endless = np.concatenate([times, times + period])
        if np.abs(endless[step : step + p] - times - period / often).max() <= SAME:
            return often
    return 1


def canonical(times: Array, period: float, turn: float) -> tuple[Array, int]:
    """The times from the impact with the least phase on, which is in the first period of the load; and its number.

    Of impacts with phases that are the same but for rounding, that before the shortest flight.
    """
    flights = np.append(times[1:], times[0] + period) - times
    phases = np.mod(times, turn)
    phases = np.where(turn - phases <= SAME, phases - turn, phases)
    least = np.flatnonzero(phases <= phases.min() + SAME)
    first = int(least[np.argmin(flights[least])])
    moved = np.concatenate([times[first:], times[:first] + period])
    start = float(np.mod(moved[0], turn))
    return start + np.append(0.0, np.cumsum(np.diff(moved))), first
