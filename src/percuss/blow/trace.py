"""A quantity over time in pieces: constants, or polynomials where a spring or a mass is in the way."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, count, numbers


@dataclass(frozen=True, eq=False, repr=False)
class Trace:
    """A function of time from the first to the last of its breaks, continued as a constant beyond them.

    Parameters
    ----------
    times
        Breaks, increasing, shape (n + 1,); s, or radians of a dimensionless striker.
    coefficients
        Chebyshev coefficients of each piece over its own length, shape (n, degree + 1).

    Examples
    --------
    >>> steps = Trace(np.array([0.0, 1.0, 3.0]), np.array([[2.0], [-1.0]]))
    >>> steps.at([0.5, 1.0]).tolist(), steps.integral(), steps.peak
    ([2.0, -1.0], 0.0, 2.0)
    """

    times: Array
    coefficients: Array

    def at(self, time: npt.ArrayLike) -> Array:
        """Values at times, at a break that of the later piece; the shape of `time`.

        Raises
        ------
        ParameterError
            For times that are not finite numbers.
        """
        t = np.clip(numbers("time", time), self.times[0], self.times[-1])
        return self._values(self._pieces(t), t)

    def before(self, time: npt.ArrayLike) -> Array:
        """The same, at a break that of the earlier piece."""
        t = np.clip(numbers("time", time), self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, t, side="left") - 1, 0, len(self.coefficients) - 1)
        return self._values(piece, t)

    def _values(self, piece: npt.NDArray[np.intp], t: Array) -> Array:
        low, high = self.times[piece], self.times[piece + 1]
        x = 2.0 * (t - low) / (high - low) - 1.0
        one, two = np.zeros_like(x), np.zeros_like(x)
        for k in range(int(self._degrees[piece].max(initial=0)), 0, -1):
            one, two = self.coefficients[piece, k] + 2.0 * x * one - two, one
        return np.asarray(self.coefficients[piece, 0] + x * one - two)

    def sampled(self, size: int) -> tuple[Array, Array]:
        """Times and values for a curve, with both values at each jump and `size` points more; two arrays."""
        inside = np.linspace(self.times[0], self.times[-1], count("size", size, 2, 1 << 24))
        times = np.concatenate([self.times[:-1], self.times[1:], inside])
        values = np.concatenate([self.at(self.times[:-1]), self.before(self.times[1:]), self.at(inside)])
        # at a break the earlier piece's value comes first
        order = np.lexsort(
            (np.r_[np.full(len(self.times) - 1, 1), np.zeros(len(self.times) - 1), np.ones(size)], times)
        )
        return times[order], values[order]

    def integral(self) -> float:
        """∫ over all its pieces."""
        return float(np.sum(self.piece_integrals))

    @cached_property
    def piece_integrals(self) -> Array:
        """∫ over each piece, shape (n,)."""
        k = np.arange(0, self.coefficients.shape[1], 2)
        return np.asarray(np.diff(self.times) * (self.coefficients[:, ::2] @ (1.0 / (1.0 - k * k))))

    @cached_property
    def piece_moments(self) -> Array:
        """∫ (t − start of the piece) over each piece, shape (n,)."""
        degree = self.coefficients.shape[1] - 1
        # x T_k = (T_{k+1} + T_{|k−1|})/2
        even = {k: 1.0 / (1.0 - k * k) for k in range(0, degree + 2, 2)}
        weights = [0.5 * (even.get(k + 1, 0.0) + even.get(abs(k - 1), 0.0)) for k in range(degree + 1)]
        half = 0.5 * np.diff(self.times)
        return np.asarray(half * self.piece_integrals + 2.0 * half**2 * (self.coefficients @ np.array(weights)))

    @property
    def peak(self) -> float:
        """The greatest value."""
        return float(self.piece_peaks.max())

    @cached_property
    def piece_peaks(self) -> Array:
        """The greatest value of each piece, shape (n,)."""
        k = np.arange(self.coefficients.shape[1])
        even, odd = self.coefficients[:, ::2].sum(axis=1), self.coefficients[:, 1::2].sum(axis=1)
        found = np.maximum(even + odd, even - odd)  # T_k(±1)
        steepness = abs(self.coefficients) * k**2  # bounds |T_k'|
        turning = np.flatnonzero(steepness[:, 2:].sum(axis=1) > steepness[:, 1:2].sum(axis=1))
        found[turning] = [extreme(row) for row in self.coefficients[turning]]
        return np.asarray(found)

    def product_integral(self, other: Trace) -> float:
        """∫ of the product with another trace over the time that both have."""
        if other is self:
            return self._square_integral()
        low, high = max(self.times[0], other.times[0]), min(self.times[-1], other.times[-1])
        edges = np.unique(np.concatenate([self.times, other.times]))
        edges = np.unique(np.clip(edges, low, high))
        middle, half, total = 0.5 * (edges[:-1] + edges[1:]), 0.5 * np.diff(edges), 0.0
        one, two = self._pieces(middle), other._pieces(middle)
        needed = (self._degrees[one] + other._degrees[two]) // 2 + 1
        for size in np.unique(needed).tolist():
            here = needed == size
            nodes, weights = np.polynomial.legendre.leggauss(size)
            at = middle[here, None] + half[here, None] * nodes
            values = self._values(one[here, None], at) * other._values(two[here, None], at)
            total += float(half[here] @ (values @ weights))
        return total

    @cached_property
    def _degrees(self) -> npt.NDArray[np.intp]:
        """Of each piece, shape (n,)."""
        k = np.arange(self.coefficients.shape[1])
        return np.asarray(np.max((self.coefficients != 0.0) * k, axis=1))

    def _pieces(self, time: Array) -> npt.NDArray[np.intp]:
        """The piece at each time, at a break the later one."""
        return np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.coefficients) - 1)

    def _square_integral(self) -> float:
        """∫ of the square, from T_i T_j = (T_{i+j} + T_{|i−j|})/2."""
        k = np.arange(self.coefficients.shape[1])
        plus, minus = k[:, None] + k, k[:, None] - k
        even = plus % 2 == 0
        weights = np.where(even, 0.5 / (1.0 - (plus * even) ** 2) + 0.5 / (1.0 - (minus * even) ** 2), 0.0)
        return float(np.diff(self.times) @ np.sum(self.coefficients @ weights * self.coefficients, axis=1))

    def around(self, start: float, end: float) -> Trace:
        """The pieces that have a part between two times, whole; all where none has."""
        here = np.flatnonzero((self.times[:-1] < end) & (self.times[1:] > start))
        first, last = (here[0], here[-1] + 1) if here.size else (0, len(self.coefficients))
        return Trace(self.times[first : last + 1], self.coefficients[first:last])

    def scaled(self, factor: float, time: float = 1.0) -> Trace:
        """Values times a factor, times as well."""
        return Trace(self.times * time, self.coefficients * factor)

    def __repr__(self) -> str:
        return f"Trace({len(self.coefficients)} pieces from {self.times[0]:.6g} to {self.times[-1]:.6g})"


def extreme(row: Array) -> float:
    """The greatest value of a Chebyshev series on [−1, 1]."""
    kept = np.flatnonzero(abs(row) > 1e-30 * abs(row).max(initial=0.0))  # numpy divides by the last one
    if not kept.size or kept[-1] == 0:
        return float(row[0])
    series = np.polynomial.Chebyshev(row[: kept[-1] + 1])
    slope = series.deriv()
    places = slope.roots() if slope.coef.any() else np.zeros(0)
    inside = places.real[(abs(places.imag) < 1e-6) & (abs(places.real) < 1.0)]
    return float(max(series(np.concatenate([[-1.0, 1.0], inside]))))
