"""The numbers of one system as the kernels want them, computed once for all its motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from percuss.model import Load, System
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
    return Spectrum(system, modes), tables_of(system, modes)


def tables_of(system: System, modes: int) -> Tables:
    """The kernels' tables of a system cut at mode N.

    Its neighbours in a map, with another restitution or mean load, share all but a few numbers of them.

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).
    """
    load = system.load
    harmonics = () if load.is_piecewise else tuple(load.coefficients.tolist())[1:]
    shared = _without_mean(system.s, system.d, harmonics, modes)
    par = shared.par.copy()
    par[kn.R], par[kn.MEAN], par[kn.PUSHING] = system.restitution, load.mean, _longest_push(load)
    if load.is_piecewise:
        steps = np.array(load.values)
        par[kn.FORCE] = float(np.abs(load.values).max())
        releases = np.array(load.breaks)[(steps < 0.0) & (np.roll(steps, 1) >= 0.0)]
        return replace(shared, par=par, breaks=np.array(load.breaks), values=steps, releases=releases)
    par[kn.FORCE] = abs(load.mean) + shared.par[kn.FORCE]
    return replace(shared, par=par, releases=_releases(system.s, system.d, harmonics, modes, load.mean))


@lru_cache(maxsize=16)
def _without_mean(s: float, d: float, harmonics: tuple[complex, ...], modes: int) -> Tables:
    """The tables but for the restitution, the mean load, and what follows from them; none for a load of steps."""
    spectrum = Spectrum(System(s, d, 0.0, Load(np.array([0.0, *harmonics]))), modes)
    k, pk = spectrum.k, spectrum.pk
    mode = np.empty((kn.MODE_ROWS, modes))
    half = 0.5 * d
    oscillates = np.arange(modes) >= spectrum.over
    mode[kn.OMEGA], mode[kn.SIGNED], mode[kn.STATICS] = spectrum.omega, spectrum.square, spectrum.statics
    mode[kn.OSCILLATES], mode[kn.LAMBDA] = oscillates, oscillates * spectrum.lam
    mode[kn.INVERSE], mode[kn.SQUARE] = oscillates / spectrum.lam, oscillates * spectrum.square
    mode[kn.DELTA] = oscillates * half * half / (spectrum.omega + spectrum.lam)

    har = np.empty((kn.HARMONIC_ROWS, k.size))
    for row, values in ((kn.GAP_RE, spectrum.gap), (kn.RIGID_RE, spectrum.rigid), (kn.LOAD_RE, pk)):
        har[row], har[row + 1] = values.real, values.imag
    par = np.zeros(kn.PARAMETERS)
    par[kn.D], par[kn.BASE] = d, np.pi * s
    for order, row in enumerate((kn.REACH, kn.RATE, kn.CURVE, kn.JERK)):
        par[row] = float(np.sum(k**order * np.abs(spectrum.gap))) * (1.0 + 1e-12)
    par[kn.FORCE] = float(np.abs(pk).sum())
    par[kn.BEND] = float(np.sum(k**2 * np.abs(pk))) * (1.0 + 1e-12)
    par[kn.RIPPLE] = 1e-3
    if modes:
        par[kn.WAVE], par[kn.RIPPLE] = (1.0 + 0.5 / modes) / s, 0.5 / (modes * s)
    response = spectrum.response
    par[kn.SWAY] = float(np.sum(k * np.abs(spectrum.rigid)))
    par[kn.SWING] = par[kn.SWAY] + float(np.sum(k[:, None] * np.abs(response)))
    coupling = np.ascontiguousarray(np.stack([response.real, response.imag], axis=1))
    return Tables(par, mode, har, coupling, np.empty(0), np.empty(0), np.empty(0), spectrum.over)


_SAMPLES = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)


@lru_cache(maxsize=1024)
def _longest_push(load: Load) -> float:
    """A bound, from above, of the time for which the load does not pull; inf when no sample of it does."""
    pulls = np.flatnonzero(load.value(_SAMPLES) < 0.0)
    if not pulls.size:
        return np.inf
    return float(np.diff(pulls, append=pulls[0] + _SAMPLES.size).max() * _SAMPLES[1])


@lru_cache(maxsize=1024)
def _releases(s: float, d: float, harmonics: tuple[complex, ...], modes: int, mean: float) -> Array:
    """Phases at which a Fourier series begins to pull."""
    shared = _without_mean(s, d, harmonics, modes)
    found = np.empty(shared.har.shape[1])
    force = abs(mean) + shared.par[kn.FORCE]
    return np.unique(found[: kn.release_phases(shared.har, mean, shared.par[kn.BEND], force, found)])
