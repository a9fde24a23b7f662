"""The numbers of one system as the kernels want them, computed once for all its motions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.simulate import kernels as kn
from percuss.simulate.spectrum import Spectrum

__all__ = ["Tables", "prepared", "tables_of"]


@dataclass(frozen=True)
class Tables:
    """Arrays for the kernels; rows and columns are named there.

    Attributes
    ----------
    par, mode, har
        Numbers of the system, of its elastic modes, shape (rows, N), and of the harmonics, shape (rows, K).
    coupling
        Displacement of q_n = 2(−1)ⁿ u_n under harmonic k, real and imaginary part; shape (K, 2, N).
    breaks, values
        Steps of a piecewise constant load, otherwise empty.
    releases
        Phases at which the load begins to pull.
    over
        Number of the lowest modes that are overdamped or nearly so.
    """

    par: Array
    mode: Array
    har: Array
    coupling: Array
    breaks: Array
    values: Array
    releases: Array
    over: int


@lru_cache(maxsize=16)
def prepared(system: System, modes: int) -> tuple[Spectrum, Tables]:
    """Spectrum and tables of a system, kept for the next motion of it.

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).
    """
    spectrum = Spectrum(system, modes)
    return spectrum, tables_of(spectrum)


def tables_of(spectrum: Spectrum) -> Tables:
    """The kernels' tables of a system cut at mode N."""
    system, modes, k, pk = spectrum.system, spectrum.modes, spectrum.k, spectrum.pk
    load = system.load
    mode = np.empty((kn.MODE_ROWS, modes))
    half = 0.5 * system.d
    oscillates = np.arange(modes) >= spectrum.over
    mode[kn.OMEGA], mode[kn.SIGNED], mode[kn.STATICS] = spectrum.omega, spectrum.square, spectrum.statics
    mode[kn.OSCILLATES], mode[kn.LAMBDA] = oscillates, oscillates * spectrum.lam
    mode[kn.INVERSE], mode[kn.SQUARE] = oscillates / spectrum.lam, oscillates * spectrum.square
    mode[kn.DELTA] = oscillates * half * half / (spectrum.omega + spectrum.lam)

    har = np.empty((kn.HARMONIC_ROWS, k.size))
    for row, values in ((kn.GAP_RE, spectrum.gap), (kn.RIGID_RE, spectrum.rigid), (kn.LOAD_RE, pk)):
        har[row], har[row + 1] = values.real, values.imag
    par = np.zeros(kn.PARAMETERS)
    par[kn.D], par[kn.R], par[kn.BASE], par[kn.MEAN] = system.d, system.restitution, np.pi * system.s, load.mean
    for order, row in enumerate((kn.REACH, kn.RATE, kn.CURVE, kn.JERK)):
        par[row] = float(np.sum(k**order * np.abs(spectrum.gap))) * (1.0 + 1e-12)
    par[kn.FORCE] = float(np.abs(load.values).max()) if load.is_piecewise else abs(load.mean) + float(np.abs(pk).sum())
    par[kn.BEND] = float(np.sum(k**2 * np.abs(pk))) * (1.0 + 1e-12)
    par[kn.RIPPLE] = 1e-3
    if modes:
        par[kn.WAVE], par[kn.RIPPLE] = (1.0 + 0.5 / modes) / system.s, 0.5 / (modes * system.s)
    if load.is_piecewise:
        steps = np.array(load.values)
        releases = np.array(load.breaks)[(steps < 0.0) & (np.roll(steps, 1) >= 0.0)]
    else:
        found = np.empty(k.size)
        releases = np.unique(found[: kn.release_phases(har, load.mean, par[kn.BEND], par[kn.FORCE], found)])
    response = spectrum.response
    return Tables(
        par,
        mode,
        har,
        np.ascontiguousarray(np.stack([response.real, response.imag], axis=1)),
        np.array(load.breaks),
        np.array(load.values),
        releases,
        spectrum.over,
    )
