"""Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5), and which motion each belongs to.

They are exact for the modes and the contact law of the system. What they say of the elastic modes is said by the law:
where an impact keeps the strain (B77) some of these may grow, where it turns the strain over, as waves in a uniform bar
do, their multipliers have a modulus of about R e^{−d_n T/2}.

A multiplier belongs to a mode by its participation factor l_n·r_n, the product of the mode's parts of its left and
right eigenvectors with l·r = 1 (Pérez-Arriaga, Verghese & Schweppe, IEEE Trans. PAS-101 (1982) 3117–3125). No scale of
the states enters. Over the modes the factors of one multiplier sum to 1, over the multipliers those of one mode to 2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from percuss.errors import ConvergenceError
from percuss.model import HeldBody, System
from percuss.model.checks import Array, ComplexArray, count, instance
from percuss.model.load import Side
from percuss.shown import Shown
from percuss.stability.linear_map import MAX_MODES, LinearMap, linear_map
from percuss.stability.secular import secular_roots
from percuss.steady import Orbit

__all__ = ["NEUTRAL", "TURNING", "Multipliers", "floquet_multipliers"]

NEUTRAL = 1e-10
"""Moduli this close to 1 are neither stable nor unstable: rounding would decide."""

TURNING = 1e-6
"""Part of its modulus from which on the imaginary part of a multiplier makes it one of a pair that turns."""

_DENSE = 40  # up to this many modes a dense eigensolve is as fast
_TRACE = 1e-11  # relative error of the sums of the roots and of their squares
_DENSE_CHECK = 300  # up to this many it may stand in for roots that failed their check
_TINY = 1e-6  # multipliers this small beside the largest, or beside 1, are taken for 0
_NEAR = 64  # multipliers of very many modes among which each of the rigid motion is looked for


@dataclass(frozen=True)
class Multipliers(Shown):
    """The Floquet multipliers of the map from impact to impact.

    Parameters
    ----------
    modes
        N: modes 0 … N were kept.
    values
        All 2N + 2 multipliers, of a body that is held 2N, largest modulus first; complex, dimensionless.
    dominant_mode
        The mode with the greatest share of energy in the eigenvector of the first multiplier; 0 is the rigid motion.
    """

    modes: int
    values: ComplexArray
    dominant_mode: int
    _orbit: Orbit = field(repr=False, compare=False)
    _map: LinearMap = field(repr=False, compare=False)
    _side: Side = field(repr=False, compare=False)

    @property
    def system(self) -> System:
        """What the orbit is one of."""
        return self._orbit.system

    @property
    def moduli(self) -> Array:
        """Moduli, largest first."""
        return np.asarray(np.abs(self.values))

    @property
    def largest(self) -> float:
        """Largest modulus: less than 1 when the orbit is stable."""
        return float(np.abs(self.values).max())  # of equal ones the first in `values` may be an ulp off

    @cached_property
    def rigid(self) -> tuple[int, int]:
        """Places in `values` of the two that belong to the rigid motion: those in which it takes part most.

        Of a body that is held those of its first mode.
        """
        if self.modes <= _DENSE_CHECK:
            return _rigid_pair(self._map, self.values)
        return _matched(self._orbit, self._side, self._map, self.values)

    @property
    def ringing_mode(self) -> int:
        """The mode that dominates the slowest of all others, 1 … N; 0 without elastic modes."""
        slowest = _slowest(self.rigid, self.values.size)
        number = 1 if self.system.body.is_free else 2
        return 0 if slowest is None else number + int(np.argmax(self._map.shares(complex(self.values[slowest]))[1:]))

    @property
    def rhythm(self) -> float:
        """Largest modulus of the two multipliers of the rigid motion."""
        return float(np.abs(self.values[list(self.rigid)]).max())

    @property
    def ringing(self) -> float | None:
        """Largest modulus of those of the elastic modes; None when there are none."""
        slowest = _slowest(self.rigid, self.values.size)
        return None if slowest is None else float(np.abs(self.values[slowest]))


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
    body = instance("orbit", orbit, Orbit).system.body
    n = body.chosen(n) if isinstance(body, HeldBody) else n
    matrix = linear_map(orbit, n, side)
    values = np.linalg.eigvals(matrix.dense()).astype(complex) if n <= _DENSE else _secular(matrix)
    values = values[np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))]
    shares = matrix.shares(complex(values[0]))
    first = 0 if body.is_free else 1
    return Multipliers(n, values, first + int(np.argmax(shares)), orbit, matrix, side)


def _rigid_pair(matrix: LinearMap, values: ComplexArray) -> tuple[int, int]:
    """The two multipliers in which the rigid motion takes part most.

    By the real part: where two multipliers meet, their factors grow without bound with opposite signs. Multipliers of 0
    (R = 0 has one in every block) have no eigenvectors of their own: together they have what the others leave of 2.
    """
    size = values.size
    if size == 2:
        return 0, 1
    alive = int(np.count_nonzero(np.abs(values) > _TINY * max(1.0, float(np.abs(values[0])))))
    part = matrix.participation(values[:alive]).real
    found = np.argsort(-part, kind="stable")[:2].tolist()
    left = 2.0 - float(part.sum()) if alive < size else 0.0
    if left > 1.5:
        found = [size - 2, size - 1]
    elif alive < size and (len(found) < 2 or left > part[found[1]]):
        found = [*found[:1], size - 1]
    first, second = sorted(found)
    return first, second


def _matched(orbit: Orbit, side: Side, matrix: LinearMap, values: ComplexArray) -> tuple[int, int]:
    """Positions of the two rigid multipliers among those of very many modes: nearest to where few modes have them."""
    few = floquet_multipliers(orbit, _DENSE, side=side)
    found: list[int] = []
    for one in few.values[list(few.rigid)]:
        near = np.argsort(np.abs(values - one), kind="stable")[:_NEAR]
        near = near[~np.isin(near, found)]
        lost = abs(one) <= _TINY * max(1.0, few.largest)
        part = matrix.participation(values[near]).real
        found.append(int(near[np.argmin(np.abs(values[near]))] if lost else near[np.argmax(part)]))
    first, second = sorted(found)
    return first, second


def _slowest(rigid: tuple[int, int], size: int) -> int | None:
    """Place of the largest multiplier that is not of the rigid motion, among `size` in order of modulus."""
    return next((i for i in range(size) if i not in rigid), None)


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
        f"the multipliers of {matrix.a.size - 1} modes crowd too closely, velocities times "
        f"{matrix.velocity_factor:g} at the impact: they miss the trace of their map by {first:.1e}",
        f"ask for at most {_DENSE_CHECK - 1} modes",
    )
