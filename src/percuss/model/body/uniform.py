"""The uniform bar of B77: one section, every sum over its modes in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body.body import Body, ComplexShape, IntArray, Shape
from percuss.model.body.damping import MOST_DAMPING, UNDAMPED, Damping
from percuss.model.checks import Array, ComplexArray, instance, positive

__all__ = ["UniformBar"]

# Far beyond any bar: outside them the squares of the frequencies leave the range of double precision
LEAST_S, MOST_S = 1e-4, 1e9

_RESONANT = 1e-12
_SERIES_BELOW = 0.5  # |q| below which sin q − q is taken from its series


@dataclass(frozen=True)
class UniformBar(Body):
    """A bar of one section (B77 3, 4): u_tt + d u_t − s² u_xx = 0, −s² u_x(0, t) = p(t), u_x(1, t) = 0.

    ω_n = nπs, φ_n = √2 cos nπx; displacements z_n are B77's u_n.

    Parameters
    ----------
    s
        Wave speed C/(LΩ), dimensionless, greater than 0.
    damping
        The law of damping.

    Raises
    ------
    ParameterError
        For values out of range.
    """

    kind: ClassVar[str] = "uniform"

    s: float
    damping: Damping = UNDAMPED

    def __post_init__(self) -> None:
        object.__setattr__(self, "s", positive("s", self.s))
        if not LEAST_S <= self.s <= MOST_S:
            raise ParameterError("s", self.s, f"a wave speed from {LEAST_S:g} to {MOST_S:g} bar lengths per radian")
        if instance("damping", self.damping, Damping).rigid > MOST_DAMPING:
            raise ParameterError("d", self.damping.rigid, f"a damping of at most {MOST_DAMPING:g}")

    def frequencies(self, count: int) -> Array:
        return np.asarray(np.pi * self.s * np.arange(1, count + 1), dtype=float)

    def inertia(self, count: int) -> Array:
        return np.full(count, 0.5)

    def shapes(self, x: Array, count: int) -> Shape:
        n = np.pi * np.arange(1, count + 1)
        angles, turned = np.outer(x, n), _alternating(count)
        return Shape(turned * np.cos(angles), -turned * n * np.sin(angles))

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        (near, side), (far, other) = _images(np.asarray(x, dtype=float), source)
        rise = 0.5 * (self._static(near) + self._static(far))
        return Shape(rise, 0.5 * (side * (near - 1.0) + other * (far - 1.0)) / self.s**2)

    def _static(self, x: Array) -> Array:
        return np.asarray((1.0 / 3.0 - x + 0.5 * x**2) / self.s**2)

    def mass_before(self, x: Array) -> Array:
        return np.array(x, dtype=float)

    def frequency_floor(self, n: int) -> float:
        return math.pi * self.s * n

    @property
    def coupling_bound(self) -> float:
        return 2.0

    def lossless_receptance(self, z: ComplexArray, x: Array, source: float = 0.0) -> ComplexShape:
        """(1/s²)[1/q² − cos q(1 − x)/(q sin q)] with q = z/s for a source at x = 0 (theory §4); else by images."""
        q = np.asarray(z / self.s, dtype=complex)
        (near, side), (far, other) = _images(np.asarray(x, dtype=float), source)
        shape, slope = _driven_at_0(self.s, q, near)
        if source == 0.0:
            return ComplexShape(shape, slope)
        second, second_slope = _driven_at_0(self.s, q, far)
        return ComplexShape(0.5 * (shape + second), 0.5 * (side * slope + other * second_slope))

    def held_transfer(self, k: Array, at: int = 0) -> ComplexArray:
        """cos qx_p/cos q (theory §4), for every damping of which one lossless bar stands for all modes."""
        bar = self.damping.lossless(k)
        if not bar.exact:
            return super().held_transfer(k, at)
        q, x = bar.z / self.s, self.place(at)
        there = _decaying(q, 1.0 - x) + _decaying(q, 1.0 + x)
        bottom = _decaying(q, 1.0) ** 2 + 1.0
        resonant = np.abs(bottom) < _RESONANT * np.maximum(1.0, np.abs(q))
        return np.where(resonant, np.inf, there / np.where(resonant, 1.0, bottom))

    @property
    def is_uniform(self) -> bool:
        return True

    def frequency(self, n: IntArray) -> Array:
        return np.asarray(np.pi * self.s * n, dtype=float)

    def nearest(self, omega: npt.ArrayLike) -> IntArray:
        n = np.maximum(np.rint(np.asarray(omega, dtype=float) / (math.pi * self.s)), 1.0)
        return np.asarray(n.astype(np.int64))

    def __str__(self) -> str:
        return f"s = {self.s:.6g}, {self.damping}"


def _decaying(q: ComplexArray, way: float) -> ComplexArray:
    """exp(−iq·way), which for Im q ≤ 0 never grows."""
    return np.asarray(np.exp(-1j * way * q.real - way * np.abs(q.imag)))


def _alternating(count: int) -> Array:
    """(−1)ⁿ for n = 1 … `count`."""
    return np.where(np.arange(1, count + 1) % 2, -1.0, 1.0)


def _images(x: Array, source: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The two distances, over the near and over the far end, that a wave runs from the source, and their slopes.

    cos nπx cos nπx_p = ½ [cos nπ(x − x_p) + cos nπ(x + x_p)]: the answer to a force anywhere is the mean of two
    answers to one at the end.
    """
    apart, back = x - source, 1.0 - (x + source)
    return (np.abs(apart), np.where(apart >= 0.0, 1.0, -1.0)), (1.0 - np.abs(back), np.where(back >= 0.0, 1.0, -1.0))


def _driven_at_0(s: float, wave: ComplexArray, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """g(x) and its slope, all modes, for the wave numbers q; shapes (K, len(x))."""
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


def _sinc_minus_one(q: ComplexArray) -> ComplexArray:
    """sin q/q − 1 for |q| < 1 by its series: no cancellation."""
    square = q * q
    total = np.zeros_like(square)
    for j in range(9, 0, -1):
        total = -square / (2 * j * (2 * j + 1)) * (1.0 + total)
    return total
