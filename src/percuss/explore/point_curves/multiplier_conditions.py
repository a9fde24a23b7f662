"""What makes an orbit a fold, a flip or a Neimark–Sacker point: a multiplier, or a pair, on the unit circle.

A multiplier ξ makes K(ξ) singular. Bordered by a column b and a row cᵀ, [K b; cᵀ 0](v, g) = (0, 1), it is not, and
g vanishes where det K(ξ) does, of whatever size the determinant is (Griewank & Reddien, IMA J. Numer. Anal. 4 (1984)
295–303; Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, ch. 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.point_curves.conditions import Plain
from percuss.model.checks import Array, ComplexArray
from percuss.steady import PeriodicOrbit

__all__ = ["Multiplier", "Pair"]

_NARROW, _ROUND = 5e-5, 2e-4  # of cos θ from ±1, nearer than which what is asked is its mean on a circle around
_VANISHED = 1e-6  # of the longest row: a row that is 0 has no length of its own


@dataclass(frozen=True)
class Multiplier(Plain):
    """A multiplier 1, a fold, or −1, a flip.

    Parameters
    ----------
    xi
        1 or −1.
    border
        Left and right singular vector of K(ξ) with its rows taken by their lengths, and these.
    """

    xi: float
    border: tuple[Array, Array, Array]

    @staticmethod
    def of(orbit: PeriodicOrbit, xi: float) -> Multiplier:
        """With the borders of an orbit."""
        return Multiplier(xi, _border(orbit.bordered(xi)))

    @property
    def kind(self) -> BranchEvent:
        """Fold or flip."""
        return BranchEvent.FOLD if self.xi > 0.0 else BranchEvent.FLIP

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """g."""
        return np.array([self.at(orbit, self.xi).real])

    def at(self, orbit: PeriodicOrbit, xi: complex) -> complex:
        """g of another number in place of ξ, with the same borders."""
        return _bordered(orbit.bordered(xi), self.border)

    def null(self, orbit: PeriodicOrbit) -> Array:
        """v, by which the unknowns of the orbit change along the other branch; shape (p + 1,)."""
        return np.asarray(np.linalg.svd(orbit.bordered(self.xi).real)[2][-1])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Multiplier:
        """With borders taken anew."""
        return Multiplier.of(orbit, self.xi)


@dataclass(frozen=True)
class Pair(Plain):
    """A pair of multipliers on the unit circle; cos θ is an unknown.

    g(ξ) + g(1/ξ) and (g(ξ) − g(1/ξ))/(ξ − 1/ξ) are real and smooth where the two meet at 1 or at −1, too.
    """

    border: tuple[Array, Array, Array]

    @staticmethod
    def of(orbit: PeriodicOrbit, cosine: float) -> Pair:
        """With the borders of an orbit."""
        return Pair(_border(orbit.bordered(_on_circle(cosine))))

    @property
    def kind(self) -> BranchEvent:
        """Neimark–Sacker."""
        return BranchEvent.NEIMARK_SACKER

    @property
    def extras(self) -> int:
        """cos θ."""
        return 1

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """Mean and difference quotient of g at ξ and 1/ξ; both are analytic in cos θ, also where ξ = 1/ξ."""
        cosine = float(extra[0])
        if abs(abs(cosine) - 1.0) > _NARROW:
            return self._halves(orbit, cosine).real
        ahead, behind, aside = (self._halves(orbit, cosine + _ROUND * way) for way in (1.0, -1.0, 1j))
        return 0.25 * (ahead + behind + 2.0 * aside).real  # with the conjugate of the last: exact to the third order

    def _halves(self, orbit: PeriodicOrbit, cosine: complex) -> ComplexArray:
        xi = _on_circle(cosine)
        first = _bordered(orbit.bordered(_plain(xi)), self.border)
        if isinstance(cosine, float) and abs(cosine) < 1.0:
            return np.array([first.real, first.imag / xi.imag], dtype=complex)
        second = _bordered(orbit.bordered(_plain(1.0 / xi)), self.border)
        return np.array([0.5 * (first + second), (first - second) / (xi - 1.0 / xi)])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Pair:
        """With borders taken anew."""
        return Pair.of(orbit, float(extra[0]))


def _border(matrix: Array | ComplexArray) -> tuple[Array, Array, Array]:
    """Real borders and the lengths of the rows; the longest for one that vanishes, as of a held body."""
    lengths = np.linalg.norm(matrix, axis=1)
    lengths = np.where(lengths > _VANISHED * lengths.max(), lengths, lengths.max())
    left, _, right = np.linalg.svd(matrix / lengths[:, None])
    return _real(left[:, -1]), _real(right[-1].conj()), lengths


def _real(vector: ComplexArray) -> Array:
    """The longest real part of a complex vector times a number of modulus 1, of length 1."""
    square = complex(np.sum(vector**2))
    turned = vector * np.exp(-0.5j * np.angle(square)) if square else vector
    return np.asarray(turned.real / np.linalg.norm(turned.real))


def _bordered(matrix: Array | ComplexArray, border: tuple[Array, Array, Array]) -> complex:
    column, row, lengths = border
    size = row.size
    whole = np.zeros((size + 1, size + 1), dtype=matrix.dtype)
    whole[:size, :size], whole[:size, size], whole[size, :size] = matrix / lengths[:, None], column, row
    try:
        return complex(np.linalg.solve(whole, np.append(np.zeros(size), 1.0))[-1])
    except np.linalg.LinAlgError:
        return complex(np.nan)


def _plain(number: complex) -> complex:
    """A number as a real one, where it is."""
    return number if number.imag else number.real


def _on_circle(cosine: complex) -> complex:
    """ξ with (ξ + 1/ξ)/2 equal to a cosine; real for one beyond 1."""
    return complex(cosine + np.sqrt(complex(cosine * cosine - 1.0)))
