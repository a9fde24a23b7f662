"""Hypothesis strategies over the whole parameter space of the theory, and the bridge to the oracle.

Wave speed s from 0.3 to 1000 and damping d from 1e-12 to 10 (both by their logarithm, and d = 0), restitution 0 to 1
with both ends, 1 to 10 load periods per impact, loads of 1 to 20 harmonics of any phase and size, square waves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

import naive
from naive import mp
from percuss import Load, System, steady_states
from percuss.errors import ResonanceError


class Drawn(NamedTuple):
    """A system and the load periods per impact."""

    system: System
    periods: int


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers from 10**low to 10**high, evenly by their logarithm."""
    return st.floats(low, high).map(lambda x: float(10.0**x))


wave_speeds = decades(math.log10(0.3), 3.0)
dampings = st.one_of(st.just(0.0), decades(-12.0, 1.0))
restitutions = st.one_of(st.just(0.0), st.just(1.0), st.floats(0.0, 1.0))
periods = st.integers(1, 10)
kappas = st.floats(1.001, 1.999)
waves = st.tuples(decades(-3.0, 0.0), st.floats(0.0, 2.0 * math.pi)).map(
    lambda pair: pair[0] * complex(math.cos(pair[1]), math.sin(pair[1]))
)


@st.composite
def coefficients(draw: st.DrawFn, most: int = 20) -> list[complex]:
    """p_1 … p_K: one harmonic alone, or up to `most` of them (some may be absent)."""
    if draw(st.booleans()):
        k = draw(st.integers(1, most))
        return [0j] * (k - 1) + [draw(waves)]
    count = draw(st.integers(1, most))
    values = draw(st.lists(st.one_of(waves, waves, waves, st.just(0j)), min_size=count, max_size=count))
    return values if any(values) else [1.0 + 0j]


def level_of_one(d: float, restitution: float, m: int) -> float:
    """c/p_0 of B77 (14), by the oracle."""
    return float(naive.level(naive.Case.of(naive.Fourier.of([1, 1]), d=d, s=1, R=restitution, m=m)))


def highest_velocity(alternating: list[complex], d: float, samples: int = 4096) -> float:
    """max v_f by looking."""
    t = np.linspace(0.0, 2.0 * np.pi, samples, endpoint=False)
    k = np.arange(1, len(alternating) + 1)
    return float(((np.array(alternating) / (d + 1j * k)) @ np.exp(1j * np.outer(k, t))).real.max())


@st.composite
def fourier_systems(draw: st.DrawFn, most: int = 20, *, shares: st.SearchStrategy[float] | None = None) -> Drawn:
    """A smooth load whose mean is a drawn share of the greatest at which a steady motion exists."""
    s, d, r, m = draw(wave_speeds), draw(dampings), draw(restitutions), draw(periods)
    alternating = draw(coefficients(most))
    share = draw(st.floats(1e-3, 0.999) if shares is None else shares)
    unit = level_of_one(d, r, m)
    mean = share * (highest_velocity(alternating, d) / unit if unit > 1e-3 else 1.0)
    load = Load.fourier(np.array([mean, *alternating]))
    return Drawn(System(s=s, d=d, restitution=r, load=load), m)


@st.composite
def square_systems(draw: st.DrawFn, harmonics: int = 64) -> Drawn:
    """A square wave; about half of these have steady motions."""
    s, d, r, m = draw(wave_speeds), draw(dampings), draw(restitutions), draw(periods)
    rho = (1.0 - r) / (1.0 + r)
    limit = (1.0 - m * rho) + math.sqrt(1.0 + (m * rho) ** 2)  # of theory §7, for any m
    kappa = 1.0 + (min(limit, 1.999) - 1.0) * draw(st.floats(1e-3, 0.999))
    return Drawn(System(s=s, d=d, restitution=r, load=Load.square(draw(decades(-1, 1)), kappa, harmonics)), m)


def resonant(system: System) -> bool:
    """Whether the package refuses the system as exactly resonant (s = k/(nπ), d = 0)."""
    try:
        steady_states(system)
    except ResonanceError:
        return True
    return False


def oracle(system: System, m: int) -> naive.Case:
    """The same system in the oracle's digits; a square wave stays piecewise."""
    load = system.load
    if load.is_piecewise:
        q, kappa = load.values[0], mp.mpf(load.breaks[1]) / naive.PI
        return naive.Case.of(naive.Square.of(q, kappa), system.s, system.d, system.restitution, m)
    return naive.Case.of(naive.Fourier.of(load.coefficients.tolist()), system.s, system.d, system.restitution, m)
