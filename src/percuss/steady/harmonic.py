"""Forced response to a load given by harmonics: every sum over the modes in closed form (theory §4)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.oscillator import mode_frequencies
from percuss.steady.resonance import refuse_resonance

__all__ = ["Field", "HarmonicResponse", "mode_shapes", "static_shape"]

_SERIES_BELOW = 0.5  # |q| below which sin q − q is taken from its series
_AT_ONCE = 1 << 20  # harmonics × times
_KEPT_GAINS = 1 << 14  # numbers, modes × harmonics, of the tables that are kept


class Field(NamedTuple):
    """Displacement, velocity and strain; equal shapes, dimensionless."""

    displacement: Array
    velocity: Array
    strain: Array


def static_shape(system: System, x: Array, modes: int | None = None) -> tuple[Array, Array]:
    """Displacement and strain of the elastic modes under a constant unit force; all: (1/s²)(1/3 − x + x²/2)."""
    scale = 1.0 / system.s**2
    if modes is not None:
        cosines, slopes = mode_shapes(x, modes)
        flexibility = 1.0 / mode_frequencies(system.s, modes) ** 2
        return cosines @ flexibility, slopes @ flexibility
    return scale * (1.0 / 3.0 - x + 0.5 * x**2), scale * (x - 1.0)


def mode_shapes(x: Array, modes: int) -> tuple[Array, Array]:
    """2 cos nπx and its slope for n = 1 … `modes`; each of shape (len(x), modes)."""
    n = np.pi * np.arange(1, modes + 1)
    angles = np.outer(x, n)
    return np.asarray(2.0 * np.cos(angles), dtype=float), np.asarray(-2.0 * n * np.sin(angles), dtype=float)


class HarmonicResponse:
    """Periodic motion of the bar under its harmonics p_k, without rigid drift.

    Parameters
    ----------
    system
        Only s, d and the coefficients of the load are used, also when the load is piecewise.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven at one of its own frequencies (B77 16).
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.k = system.load.harmonics.astype(float)
        self.p: ComplexArray = system.load.coefficients[system.load.harmonics]
        self.q: ComplexArray = _wave_numbers(system.s, system.d, self.k)
        self.rigid_factor: ComplexArray = self.p / (system.d + 1j * self.k)
        self._end: dict[int | None, tuple[ComplexArray, ComplexArray]] = {}
        refuse_resonance(system)

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ), the periodic rigid velocity (theory §4); shape of `theta`."""
        return self._waves(theta, self.rigid_factor)

    def rigid_acceleration(self, theta: Array) -> Array:
        """v_f'(θ)."""
        return self._waves(theta, 1j * self.k * self.rigid_factor)

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        return self._waves(theta, self.rigid_factor / (1j * self.k))

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force."""
        return float(np.abs(self.rigid_factor).sum()), float(np.abs(self.p).sum())

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean."""
        return self.system.load.mean + self._waves(theta, self.p)

    # -- elastic part, all modes --

    def shapes(self, x: Array, modes: int | None = None) -> tuple[ComplexArray, ComplexArray]:
        """g_k(x) = 2 Σ_{n≥1} H_nk cos nπx, and its slope; shapes (K, len(x)).

        All modes in closed form: with G_k of theory §4, g_k = G_k − H_0k = (1/s²)[1/q² − cos q(1 − x)/(q sin q)].
        Or the first `modes` of them.
        """
        if modes is not None:
            cosines, slopes = mode_shapes(x, modes)
            gain = self.gains(modes)
            return (cosines @ gain).T, (slopes @ gain).T
        return _shapes(self.system.s, self.q, np.asarray(x, dtype=float))

    def end_shape(self, modes: int | None = None) -> ComplexArray:
        """g_k(1) of all modes, or of the first ones; shape (K,). Not to be written into."""
        if modes is None:
            return _end_shape(self.system.s, self.system.d, self.k.tobytes())
        return self.shapes(np.array([1.0]), modes)[0][:, 0]

    def gains(self, modes: int) -> ComplexArray:
        """H_nk of the modes n = 1 … `modes`; shape (modes, K). Not to be written into."""
        made = _known_gains if modes * self.k.size <= _KEPT_GAINS else _gains
        return made(self.system.s, self.system.d, self.k.tobytes(), modes)

    def elastic(self, x: Array, theta: Array, modes: int | None = None) -> Field:
        """Elastic part of the forced motion, with the static shape of the mean; shapes (len(x), len(θ)).

        All modes, or the first `modes`.
        """
        shape, slope = self.shapes(x, modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        rise, bend = static_shape(self.system, np.asarray(x, dtype=float), modes)
        mean = self.system.load.mean
        return Field(
            (shape.T @ waves).real + mean * rise[:, None],
            ((shape * (1j * self.k)[:, None]).T @ waves).real,
            (slope.T @ waves).real + mean * bend[:, None],
        )

    def end_motion(self, theta: Array, modes: int | None = None) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        both, size = np.empty((theta.size, 2)), max(1, _AT_ONCE // self.k.size)
        for i in range(0, theta.size, size):  # else a thousand harmonics at all times would fill the memory
            look()
            waves = np.exp(1j * np.outer(theta[i : i + size], self.k))
            both[i : i + size] = (waves @ self._at_end(modes)[0]).real
        return both[:, 0], both[:, 1]

    def end_velocity(self, theta: float, modes: int | None = None) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase; all modes, or the first ones."""
        return float((np.exp(1j * theta * self.k) @ self._at_end(modes)[1]).real)

    def _at_end(self, modes: int | None) -> tuple[ComplexArray, ComplexArray]:
        """What multiplies exp(ikθ) there: in displacement and velocity, shape (K, 2); in elastic velocity, (K,)."""
        if modes not in self._end:
            elastic = self.p * self.end_shape(modes)
            whole = elastic + self.rigid_factor / (1j * self.k)
            self._end[modes] = np.stack([whole, 1j * self.k * whole], axis=1), 1j * self.k * elastic
        return self._end[modes]

    # -- one mode at a time --

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        mean = self.system.load.mean / mode_frequencies(self.system.s, modes) ** 2
        return (gain @ waves).real + mean[:, None], ((gain * (1j * self.k)) @ waves).real

    def modal_apart(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """As `modal`, term by term in real numbers: the same bits for a phase alone and in a row.

        A matrix product does not give them, nor is it faster for a load of few harmonics at many phases.
        """
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        both = np.stack([waves, 1j * self.k[:, None] * waves], axis=1)  # displacement and velocity; (K, 2, len(θ))
        total = np.zeros((2, modes, waves.shape[1]))
        total[0] = (self.system.load.mean / mode_frequencies(self.system.s, modes) ** 2)[:, None]
        for column, pair in zip(gain.T, both, strict=True):
            total += column.real[:, None] * pair.real[:, None, :]
            total -= column.imag[:, None] * pair.imag[:, None, :]
        return total[0], total[1]

    def modal_velocity_bound(self, theta: float, omega: float) -> float:
        """P such that |f_n'(θ)| ≤ P/ω_n² for every mode with ω_n ≥ `omega`; inf when `omega` is too low for one.

        f_n' = p'/ω² + Re Σ ik p_k exp(ikθ) (k² − ikd) H_nk/ω².
        """
        shift = np.abs(self.k * (self.k - 1j * self.system.d))
        room = omega**2 - shift
        if np.any(room <= 0.0):
            return math.inf
        slope = abs(float((1j * self.k * self.p * np.exp(1j * self.k * theta)).real.sum()))
        return slope + float(np.sum(self.k * np.abs(self.p) * shift / room))

    def _waves(self, theta: Array, factor: ComplexArray) -> Array:
        theta = np.asarray(theta, dtype=float)
        flat = np.exp(1j * np.outer(theta.reshape(-1), self.k)) @ factor
        return np.asarray(flat.real.reshape(theta.shape))


def _shapes(s: float, wave: ComplexArray, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """g_k and its slope, all modes, for the wave numbers q_k; shapes (K, len(x))."""
    q, y = wave[:, None], (1.0 - x)[None, :]
    scale = 1.0 / s**2
    small = np.abs(q) < _SERIES_BELOW
    qs = np.where(small, q, 1.0)
    sine = np.sin(qs)
    top = _sinc_minus_one(qs) + 2.0 * np.sin(0.5 * qs * y) ** 2
    near = top / (qs * sine)
    near_slope = -np.sin(qs * y) / sine
    ql = np.where(small, 1.0 - 1.0j, q)  # Im q ≤ 0: factors exp(−iq…) never overflow
    down, up = np.exp(-1j * ql * (1.0 - y)), np.exp(-1j * ql * (1.0 + y))
    bottom = 1.0 - np.exp(-2j * ql)
    far = 1.0 / ql**2 - 1j * (down + up) / (ql * bottom)
    far_slope = -(down - up) / bottom
    shape = np.asarray(scale * np.where(small, near, far), dtype=complex)
    return shape, np.asarray(scale * np.where(small, near_slope, far_slope), dtype=complex)


@lru_cache(maxsize=32)
def _end_shape(s: float, d: float, k: bytes) -> ComplexArray:
    """g_k(1), which stays while R and the load's strength are moved; shape (K,)."""
    found = _shapes(s, _wave_numbers(s, d, np.frombuffer(k)), np.array([1.0]))[0][:, 0]
    found.setflags(write=False)
    return found


def _wave_numbers(s: float, d: float, k: Array) -> ComplexArray:
    """q_k of theory §4."""
    return np.asarray(np.sqrt(k * (k - 1j * d)) / s, dtype=complex)


def _gains(s: float, d: float, k: bytes, modes: int) -> ComplexArray:
    numbers = np.frombuffer(k)
    square = mode_frequencies(s, modes) ** 2
    found = np.asarray(1.0 / (square[:, None] - (numbers * (numbers - 1j * d))[None, :]), dtype=complex)
    found.setflags(write=False)
    return found


_known_gains = lru_cache(maxsize=16)(_gains)  # the same for every mean load, phase and restitution


def _sinc_minus_one(q: ComplexArray) -> ComplexArray:
    """sin q/q − 1 for |q| < 1 by its series: no cancellation."""
    square = q * q
    total = np.zeros_like(square)
    for j in range(9, 0, -1):
        total = -square / (2 * j * (2 * j + 1)) * (1.0 + total)
    return total
