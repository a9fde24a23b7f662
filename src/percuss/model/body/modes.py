"""What a body says of its elastic modes: frequencies, dampings and shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array, ComplexArray

__all__ = ["ComplexShape", "Modes", "Shape"]


class Shape(NamedTuple):
    """Displacement along the bar and its slope, the strain u_x; equal shapes, dimensionless."""

    displacement: Array
    strain: Array


class ComplexShape(NamedTuple):
    """As `Shape`, of a harmonic motion: complex amplitudes."""

    displacement: ComplexArray
    strain: ComplexArray


@dataclass(frozen=True)
class Modes:
    """The elastic modes n = 1 … N of a free body under a load at one place; every array of shape (N,), dimensionless.

    Mode n moves as u = z_n(t) φ_n(x) φ_n(x_p), z_n'' + d_n z_n' + ω_n² z_n = p(t): B77's u_n. φ_n is scaled so that its
    modal mass is the mass of the body, 1.

    Parameters
    ----------
    omega
        Undamped frequencies ω_n, increasing, per radian of the load.
    damping
        d_n.
    inertia
        1/φ_n(1)²: the mass that the mode has at the striking end (uniform bar: 1/2). Never 0.
    at_load
        φ_n(x_p)/φ_n(1): the mode at the load, where the striking end moves by 1 (uniform bar, driven end: (−1)ⁿ).
    """

    omega: Array
    damping: Array
    inertia: Array
    at_load: Array

    @property
    def gamma(self) -> Array:
        """γ_n = φ_n(x_p) φ_n(1): z_n moves the striking end by γ_n z_n (uniform bar, driven end: 2(−1)ⁿ)."""
        return self.at_load / self.inertia

    @property
    def weight(self) -> Array:
        """φ_n(x_p)²: the kinetic energy is ½ Σ weight z_n'², the load's power p Σ weight z_n' (uniform bar: 2)."""
        return self.at_load**2 / self.inertia

    @property
    def end(self) -> Array:
        """|φ_n(1)|, at the striking end (uniform bar: √2)."""
        return 1.0 / np.sqrt(self.inertia)

    @property
    def size(self) -> int:
        """N."""
        return self.omega.size

    @property
    def is_damped(self) -> bool:
        """Whether every mode loses energy."""
        return bool(np.all(self.damping > 0.0))

    def stiffness(self, k: Array) -> ComplexArray:
        """ω_n² + ik d_n − k², shape (N, K): what divides the harmonics k of the load."""
        return np.asarray((self.omega**2)[:, None] + 1j * np.outer(self.damping, k) - (k**2)[None, :])

    def first(self, count: int) -> Modes:
        """The first `count` of them; itself when it has no more."""
        if count >= self.size:
            return self
        return Modes(self.omega[:count], self.damping[:count], self.inertia[:count], self.at_load[:count])
