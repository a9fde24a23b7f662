"""Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.errors import ConvergenceError
from percuss.model.checks import Array, ComplexArray, count
from percuss.model.load import Side
from percuss.stability.linear_map import LinearMap, linear_map
from percuss.stability.secular import secular_roots
from percuss.steady import Orbit

__all__ = ["Multipliers", "floquet_multipliers"]

MAX_MODES = 16384  # a map may ask for more than the 4096 that an orbit's fields are bounded to
_DENSE = 40  # up to this many modes a dense eigensolve is as fast
_TRACE = 1e-11  # relative error of the sums of the roots and of their squares
_DENSE_CHECK = 300  # up to this many it may stand in for roots that failed their check


@dataclass(frozen=True)
class Multipliers:
    """The Floquet multipliers of the map from impact to impact.

    Parameters
    ----------
    modes
        N: modes 0 … N were kept.
    values
        All 2N + 2 multipliers, largest modulus first; complex, dimensionless.
    dominant_mode
        The mode with the greatest share of energy in the eigenvector of the first multiplier; 0 is the rigid motion.
    """

    modes: int
    values: ComplexArray
    dominant_mode: int

    @property
    def moduli(self) -> Array:
        """Moduli, largest first."""
        return np.asarray(np.abs(self.values))

    @property
    def largest(self) -> float:
        """Largest modulus: less than 1 when the orbit is stable."""
        return float(np.abs(self.values[0]))


def floquet_multipliers(orbit: Orbit, modes: int = 32, *, side: Side = "right") -> Multipliers:
    """All multipliers of an orbit, exact for the bar with modes 0 … `modes`.

    Few modes go to a dense eigensolver; many to the secular function, whose cost grows in proportion to N.

    Parameters
    ----------
    orbit
        The orbit.
    modes
        N, 0 to 16384.
    side
        Which value of the load counts when it jumps at the impact.

    Raises
    ------
    ParameterError
        For N out of range.
    ConvergenceError
        When the roots fail the check by the trace of the map.
    """
    n = count("modes", modes, least=0, most=MAX_MODES)
    matrix = linear_map(orbit, n, side)
    values = np.linalg.eigvals(matrix.dense()).astype(complex) if n <= _DENSE else _secular(matrix)
    values = values[np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))]
    shares = matrix.shares(complex(values[0]))
    return Multipliers(n, values, int(np.argmax(shares)))


def _secular(matrix: LinearMap) -> ComplexArray:
    """Roots of the secular function, believed only when all converged and two power sums fit the map."""
    values, converged = secular_roots(*matrix.partial_fractions())
    scale = max(1.0, float(np.abs(values).max()))
    room = _TRACE * np.sqrt(values.size)
    first = abs(complex(values.sum()) - matrix.trace) / scale
    second = abs(complex((values**2).sum()) - matrix.trace_of_square) / scale**2
    if converged and first <= room and second <= room:
        return values
    if matrix.a.size <= _DENSE_CHECK:
        return np.asarray(np.linalg.eigvals(matrix.dense()).astype(complex))
    raise ConvergenceError(
        f"the multipliers of {matrix.a.size - 1} modes crowd too closely (R = {matrix.restitution:g}): they miss the "
        f"trace of their map by {first:.1e}",
        f"ask for at most {_DENSE_CHECK - 1} modes",
    )
