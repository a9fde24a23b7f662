"""The bar cut at mode N under its load, as plain arrays: frequencies, forced response, and the state in two forms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.model import System
from percuss.model.checks import Array, ComplexArray

__all__ = ["Spectrum"]

# A mode with d/2 beyond this part of nπs is treated as if overdamped: its amplitude and phase lose their meaning
_NEARLY_OVERDAMPED = 0.95
# Forced amplitudes this much larger than off resonance would leave no digit of an impact's time
_RESONANT = 1e10


@dataclass(frozen=True)
class Spectrum:
    """Modes 1 … N of a system as q_n = 2(−1)ⁿ u_n, whose sum with u_0 is the gap function.

    Parameters
    ----------
    system
        What moves.
    modes
        N, the number of elastic modes; 0 is the rigid bar.

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).
    """

    system: System
    modes: int

    def __post_init__(self) -> None:
        near = (np.abs(self.stiffness) * _RESONANT < (self.k**2)[:, None]) & (self.pk != 0.0)[:, None]
        if near.any():
            i, n = np.argwhere(near)[0]
            raise ResonanceError(int(self.k[i]), int(n) + 1)

    # -- the modes --

    @cached_property
    def omega(self) -> Array:
        """nπs, shape (N,)."""
        return np.asarray(np.arange(1, self.modes + 1) * np.pi * self.system.s)

    @cached_property
    def square(self) -> Array:
        """λ_n² = (nπs)² − d²/4, negative where overdamped; shape (N,)."""
        half = 0.5 * self.system.d
        return (self.omega - half) * (self.omega + half)

    @cached_property
    def lam(self) -> Array:
        """λ_n, and 1 where overdamped; shape (N,)."""
        return np.sqrt(np.where(self.square > 0.0, self.square, 1.0))

    @cached_property
    def over(self) -> int:
        """Number of the lowest modes that are overdamped or nearly so; their state is kept in another form."""
        return int(np.count_nonzero(0.5 * self.system.d > _NEARLY_OVERDAMPED * self.omega))

    @cached_property
    def sign(self) -> Array:
        """2(−1)ⁿ, shape (N,)."""
        return np.where(np.arange(1, self.modes + 1) % 2, -2.0, 2.0)

    @cached_property
    def statics(self) -> Array:
        """q_n under a constant unit load; shape (N,)."""
        return self.sign / self.omega**2

    # -- the load --

    @cached_property
    def pk(self) -> ComplexArray:
        """p_1 … p_K, shape (K,); none for a load of exact steps."""
        load = self.system.load
        pk = np.asarray(load.coefficients[1:])
        if load.is_piecewise or not pk.any():
            return np.zeros(0, dtype=complex)
        return pk[: int(np.flatnonzero(pk)[-1]) + 1]

    @cached_property
    def k(self) -> Array:
        """1 … K as floats, shape (K,)."""
        return np.arange(1.0, self.pk.size + 1.0)

    @cached_property
    def stiffness(self) -> ComplexArray:
        """(nπs)² + ikd − k², shape (K, N)."""
        return np.asarray(self.omega[None, :] ** 2 + (1j * self.k * self.system.d - self.k**2)[:, None])

    @cached_property
    def response(self) -> ComplexArray:
        """Complex amplitude of q_n under harmonic k; shape (K, N)."""
        pk = self.pk[:, None]
        return np.asarray(self.sign[None, :] * pk / np.where(pk == 0.0, 1.0, self.stiffness))

    @cached_property
    def rigid(self) -> ComplexArray:
        """Complex amplitude of u_0 under harmonic k; shape (K,)."""
        return np.asarray(self.pk / (1j * self.k * self.system.d - self.k**2))

    @cached_property
    def gap(self) -> ComplexArray:
        """Complex amplitude of the gap function under harmonic k; shape (K,)."""
        return np.asarray(self.rigid + self.response.sum(axis=1))

    def mean(self, piece: int) -> float:
        """The constant part of the load: its mean, or the value of the step number `piece`."""
        load = self.system.load
        return load.values[piece] if load.is_piecewise else load.mean

    def forced(self, phase: npt.ArrayLike, mean: npt.ArrayLike) -> tuple[Array, Array]:
        """q_n and q_n' of the forced motion at load phases; each of the shape of `phase`, and (N,) behind."""
        phases = np.asarray(phase, dtype=float)
        turned = np.exp(1j * self.k * phases[..., None])
        shape = (turned @ self.response).real + np.asarray(mean)[..., None] * self.statics
        return np.asarray(shape), np.asarray(((1j * self.k * turned) @ self.response).real)

    def forced_strain_beyond(self, x: Array, phase: Array, mean: Array) -> Array:
        """Strain of the forced motion in the modes above N, which the closed form has and the sum has not (theory §2).

        Parameters
        ----------
        x, phase
            Places and load phases; the result has the shape (len(x), len(phase)).
        mean
            The constant part of the load, shape (len(phase),).
        """
        s2, n = self.system.s**2, np.arange(1, self.modes + 1)
        shapes = -2.0 * np.pi * n * np.sin(np.pi * np.outer(x, n)) / self.sign
        static = (x - 1.0) / s2 - shapes @ self.statics
        q = np.sqrt(self.k**2 - 1j * self.k * self.system.d) / self.system.s
        below = 1.0 - np.exp(-2j * q)
        clear = np.abs(below) > 1e-9  # else a mode above N is in resonance, and there is no closed form
        places = np.exp(-1j * np.outer(x, q)) - np.exp(-1j * np.outer(2.0 - x, q))
        whole = -places / (s2 * np.where(clear, below, 1.0)) * self.pk  # −sin q(1 − x)/(s² sin q)
        beyond = np.where(clear, whole - shapes @ self.response.T, 0.0)
        return np.asarray(static[:, None] * mean + (beyond @ np.exp(1j * np.outer(self.k, phase))).real)

    # -- the state in two forms: B77's u_n, u_n', and the kernels' amplitudes of the free motion --

    def amplitudes(self, displacement: Array, velocity: Array, phase: float, mean: float) -> Array:
        """Amplitudes z of the free motion, shape (2, N), from u_n and u_n', n = 0 … N, each of shape (N+1,)."""
        shape, rate = self.forced(phase, mean)
        q = self.sign * displacement[1:] - shape
        w = self.sign * velocity[1:] - rate
        oscillates = np.arange(self.modes) >= self.over
        return np.stack([q, np.where(oscillates, -(w + 0.5 * self.system.d * q) / self.lam, w)])

    def free_rate(self, z: Array) -> Array:
        """q_n'(0) of the free motion from its amplitudes z, shape (…, 2, N): the overdamped modes keep it as it is."""
        oscillating = -self.lam * z[..., 1, :] - 0.5 * self.system.d * z[..., 0, :]
        return np.asarray(np.where(np.arange(self.modes) < self.over, z[..., 1, :], oscillating))

    def modal(
        self, z: Array, gap: npt.ArrayLike, rigid_rate: npt.ArrayLike, phase: npt.ArrayLike, mean: npt.ArrayLike
    ) -> tuple[Array, Array]:
        """u_n and u_n', n = 0 … N, from the kernels' form of the state; of one state or of many.

        Parameters
        ----------
        z
            Amplitudes, shape (…, 2, N).
        gap, rigid_rate, phase, mean
            u(1), u_0', the load phase and the constant part of the load, shape (…).
        """
        shape, rate = self.forced(phase, mean)
        q, w = z[..., 0, :] + shape, self.free_rate(z) + rate
        first = np.asarray(gap) - q.sum(axis=-1)
        displacement = np.concatenate([first[..., None], q / self.sign], axis=-1)
        return displacement, np.concatenate([np.asarray(rigid_rate)[..., None], w / self.sign], axis=-1)
