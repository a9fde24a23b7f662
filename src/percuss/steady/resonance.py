"""Exact resonance of an undamped bar with any harmonic that its load contains (B77 16)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.model import HeldBody, Load, System
from percuss.model.checks import Array
from percuss.model.load import MAX_HARMONICS

__all__ = ["held_resonance", "refuse_resonance"]

IntArray = npt.NDArray[np.int64]

_EXACT = 64.0 * np.finfo(float).eps
_EXACT_BEYOND = 8.0 * np.finfo(float).eps  # for harmonics so high that many of them lie near some frequency
_MODES = 4096  # the most that any sum takes


def refuse_resonance(system: System) -> None:
    """ResonanceError when an undamped mode is driven at its own frequency; for a uniform bar s = k/(nπ).

    A load of steps contains harmonics without end: all up to 4096 are looked at, and those that the first 4096 modes
    could meet. That the load may act at a node of the mode is not looked at.
    """
    body, load = system.body, system.load
    if system.d > 0.0 or load.is_constant:
        return
    if isinstance(body, HeldBody):
        return _refuse_held(body, load)
    if load.is_piecewise:
        k, exact = _of_steps(body.modes(_MODES).omega)
    else:
        k, exact = load.harmonics, np.full(load.harmonics.shape, _EXACT)
    n = body.nearest(k)
    for i in _met(k, body.frequency(n), exact):
        driven = not load.is_piecewise or _contains(load, float(k[i]))
        if driven and body.modes(int(n[i])).damping[-1] == 0.0:
            raise ResonanceError(int(k[i]), int(n[i]))


def _refuse_held(body: HeldBody, load: Load) -> None:
    """The same for a structure: of steps all harmonics up to its highest frequency are looked at."""
    omega = body.frequencies(body.most_modes)
    free = np.flatnonzero(body.dampings(body.most_modes) == 0.0)
    k = np.rint(omega[free]).astype(np.int64) if load.is_piecewise else load.harmonics
    for n in free:
        for i in _met(k, np.full(k.shape, omega[n]), np.full(k.shape, _EXACT)):
            if k[i] >= 1 and (not load.is_piecewise or _contains(load, float(k[i]))):
                raise ResonanceError(int(k[i]), int(n) + 1)


def held_resonance(load: Load, fundamental: float) -> bool:
    """Whether steps contain a frequency (n − ½)ω_1 of an undamped uniform bar whose end is held, as at the wall."""
    k, exact = _of_steps(np.asarray(fundamental * (np.arange(1, _MODES + 1) - 0.5)))
    n = np.maximum(np.rint(k / fundamental + 0.5), 1.0)
    return any(_contains(load, float(k[i])) for i in _met(k, (n - 0.5) * fundamental, exact))


def _of_steps(frequencies: Array) -> tuple[IntArray, Array]:
    """The harmonics of a load of steps that are looked at, and how near each must come to a frequency."""
    k = np.concatenate([np.arange(1, MAX_HARMONICS + 1), np.rint(frequencies).astype(np.int64)])
    k = k[k >= 1]
    return k, np.where(k <= MAX_HARMONICS, _EXACT, _EXACT_BEYOND)


def _met(k: IntArray, frequency: Array, exact: Array) -> list[int]:
    """Which of the harmonics k meet a frequency, by increasing k."""
    met = np.flatnonzero(np.abs(k - frequency) <= exact * frequency)
    return [int(i) for i in met[np.argsort(k[met], kind="stable")]]


def _contains(load: Load, k: float) -> bool:
    """Whether the jumps of steps leave anything of harmonic k but rounding."""
    jumps = load.jumps
    terms = np.array([(jump.after - jump.before) * np.exp(-1j * k * jump.phase) for jump in jumps])
    return bool(abs(terms.sum()) > 8.0 * np.finfo(float).eps * (1.0 + k) * np.abs(terms).sum())
