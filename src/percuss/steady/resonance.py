"""Exact resonance of an undamped bar with any harmonic that its load contains (B77 16)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.model.load import MAX_HARMONICS

__all__ = ["refuse_resonance", "resonance_of_steps"]

_EXACT = 64.0 * np.finfo(float).eps
_EXACT_BEYOND = 8.0 * np.finfo(float).eps  # for harmonics so high that many of them lie near some frequency
_MODES = 4096  # the most that any sum takes


def refuse_resonance(system: System) -> None:
    """ResonanceError when an undamped bar is driven at one of its own frequencies, s = k/(nπ).

    A load of steps contains harmonics without end: all up to 4096 are looked at, and those that the first 4096 modes
    could meet.
    """
    if system.d > 0.0:
        return
    if system.load.is_piecewise:
        found = resonance_of_steps(system)
    else:
        k = system.load.harmonics
        n = np.rint(k / (math.pi * system.s))
        met = np.flatnonzero((n >= 1.0) & _meets(k, math.pi * system.s * n, _EXACT))
        found = (int(k[met[0]]), int(n[met[0]])) if met.size else None
    if found is not None:
        raise ResonanceError(*found)


def resonance_of_steps(system: System, offset: float = 0.0) -> tuple[int, int] | None:
    """The first harmonic k of a load of steps that is a frequency (n − `offset`)πs, with its n; None when none is.

    Parameters
    ----------
    offset
        0 for the free bar, ½ for the bar whose end rests on the wall.
    """
    base = math.pi * system.s
    low, modes = np.arange(1, MAX_HARMONICS + 1), np.arange(1, _MODES + 1)
    k = np.concatenate([low.astype(float), np.rint((modes - offset) * base)])
    n = np.concatenate([np.rint(low / base + offset), modes.astype(float)])
    exact = np.where(k <= MAX_HARMONICS, _EXACT, _EXACT_BEYOND)
    met = np.flatnonzero((n >= 1.0) & (k >= 1.0) & _meets(k, (n - offset) * base, exact))
    for i in met[np.argsort(k[met], kind="stable")]:
        if _contains(system.load, float(k[i])):
            return int(k[i]), int(n[i])
    return None


def _meets(k: npt.ArrayLike, frequency: Array, share: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    return np.asarray(np.abs(np.asarray(k) - frequency) <= np.asarray(share) * frequency)


def _contains(load: Load, k: float) -> bool:
    """Whether the jumps of steps leave anything of harmonic k but rounding."""
    jumps = load.jumps
    terms = np.array([(jump.after - jump.before) * np.exp(-1j * k * jump.phase) for jump in jumps])
    return bool(abs(terms.sum()) > 8.0 * np.finfo(float).eps * (1.0 + k) * np.abs(terms).sum())
