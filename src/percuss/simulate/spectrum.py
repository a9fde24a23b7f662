"""The body cut at mode N under its load, as plain arrays: frequencies, forced response, and the state in two forms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.model import System
from percuss.model.body import Modes
from percuss.model.checks import Array, ComplexArray
from percuss.simulate.damped_modes import DampedModes

__all__ = ["Spectrum", "units"]

# Where a load at a node of a mode does not move it, B77's u_n would be of no use
_NODE = 1e-12
# Forced amplitudes this much larger than off resonance would leave no digit of an impact's time
_RESONANT = 1e10


@dataclass(frozen=True)
class Spectrum(DampedModes):
    """Modes 1 … N of a system as q_n = γ_n u_n, which is what mode n adds to u_0 at the striking end: the gap function.

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
    def elastic(self) -> Modes:
        """The body's modes 1 … N under the load."""
        return self.system.body.modes(self.modes, self.system.load.at)

    @property
    def omega(self) -> Array:
        """ω_n, shape (N,)."""
        return self.elastic.omega

    @property
    def damping(self) -> Array:
        """d_n, shape (N,)."""
        return self.elastic.damping

    @property
    def inertia(self) -> Array:
        """What q_n'²/2 is multiplied by to be the kinetic energy of mode n; shape (N,)."""
        return self.elastic.inertia

    @cached_property
    def unit(self) -> Array:
        """q_n of u_n = 1; shape (N,)."""
        return units(self.elastic)

    @property
    def weight(self) -> Array:
        """What half u_n'² is multiplied by to be the kinetic energy of mode n; shape (N,)."""
        return np.asarray(self.elastic.inertia * self.unit**2)

    @cached_property
    def statics(self) -> Array:
        """q_n under a constant unit load; shape (N,)."""
        return np.asarray(self.elastic.gamma / self.omega**2)

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
        """ω_n² + ikd_n − k², shape (K, N)."""
        return np.asarray(self.elastic.stiffness(self.k).T)

    @cached_property
    def response(self) -> ComplexArray:
        """Complex amplitude of q_n under harmonic k; shape (K, N)."""
        pk = self.pk[:, None]
        return np.asarray(self.elastic.gamma[None, :] * pk / np.where(pk == 0.0, 1.0, self.stiffness))

    @cached_property
    def rigid(self) -> ComplexArray:
        """Complex amplitude of u_0 under harmonic k; shape (K,)."""
        if not self.system.body.is_free:
            return np.zeros(self.k.shape, dtype=complex)
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
        body, at = self.system.body, self.system.load.at
        static = body.static(x, at).strain - body.static(x, at, self.modes).strain
        with np.errstate(all="ignore"):
            whole = body.receptance(self.k, x, at).strain - body.receptance(self.k, x, at, self.modes).strain
        clear = np.isfinite(whole) & (np.abs(whole) < _RESONANT)  # else a mode above N is in resonance
        beyond = np.where(clear, whole, 0.0).T * self.pk
        return np.asarray(static[:, None] * mean + (beyond @ np.exp(1j * np.outer(self.k, phase))).real)

    # -- the state in two forms: B77's u_n, u_n', and the kernels' amplitudes of the free motion --

    def amplitudes(self, displacement: Array, velocity: Array, phase: float, mean: float) -> Array:
        """Amplitudes z of the free motion, shape (2, N), from u_n and u_n', n = 0 … N, each of shape (N+1,)."""
        shape, rate = self.forced(phase, mean)
        q = self.unit * displacement[1:] - shape
        w = self.unit * velocity[1:] - rate
        return np.stack([q, np.where(self.creeps, w, -(w + 0.5 * self.damping * q) / self.lam)])

    def free_rate(self, z: Array) -> Array:
        """q_n'(0) of the free motion from its amplitudes z, shape (…, 2, N): creeping modes keep it as it is."""
        oscillating = -self.lam * z[..., 1, :] - 0.5 * self.damping * z[..., 0, :]
        return np.asarray(np.where(self.creeps, z[..., 1, :], oscillating))

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
        displacement = np.concatenate([first[..., None], q / self.unit], axis=-1)
        return displacement, np.concatenate([np.asarray(rigid_rate)[..., None], w / self.unit], axis=-1)


def units(modes: Modes) -> Array:
    """q_n of u_n = 1, γ_n, shape (N,); for a load at a node of a mode, as if it were at the striking end."""
    return np.where(np.abs(modes.at_load) > _NODE, modes.gamma, 1.0 / modes.inertia)
