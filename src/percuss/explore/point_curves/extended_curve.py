"""The orbits of a family over two parameters that are all a fold, a flip, a grazing …: equations, way back, tangent.

The unknowns are the impact times, the mean velocity just after the first impact, both parameters in their units, and
what the condition brings, x = (t_1 … t_p, r, λ, μ, …). There is one equation less, so that the solutions are a curve,
which is walked by its arclength as a branch over one parameter is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from percuss.errors import PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.solution_curve import CorrectorFailed, QuickMotion, unit_tangent
from percuss.explore.family import Family
from percuss.explore.point_curves.conditions import Condition
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.states import check_pushes

_KEPT = 64
_MOST_STEPS, _MOST_RENEWALS = 16, 4
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad
_SLOW = 0.2  # share of the step before that a step may have before the derivatives are taken anew
_DIFFERENCE = 1e-6
_INSIDE = 1e-9  # of the whole way, by which rounding may miss a place


class ExtendedPoint(NamedTuple):
    """A point: its unknowns, the unit tangent, the derivatives of the equations there, and steps of Newton's method."""

    x: Array
    tangent: Array
    matrix: Array
    steps: int


@dataclass(frozen=True)
class ExtendedCurve:
    """All orbits z=p/n of a family for which a condition holds.

    Parameters
    ----------
    family, names, units
        The systems, both parameters, and by how much each changes for what counts as a step of 1 rad.
    impacts, periods, modes
        p, n and N.
    condition
        What makes the orbits what they are.
    """

    family: Family
    names: tuple[str, str]
    units: tuple[float, float]
    impacts: int
    periods: int
    modes: int
    condition: Condition
    _motions: dict[bytes, QuickMotion] = field(default_factory=dict, repr=False, compare=False)
    _systems: dict[tuple[float, float], System] = field(default_factory=dict, repr=False, compare=False)

    def renewed(self, x: Array) -> ExtendedCurve:
        """The same curve with what belongs to a place on it taken anew."""
        condition = self.condition.renewed(self.motion(x), self.extra(x))
        return self if condition is self.condition else replace(self, condition=condition, _motions={})

    def values(self, x: Array) -> tuple[float, float]:
        """Both parameters at a point."""
        p = self.impacts
        return float(x[p + 1]) * self.units[0], float(x[p + 2]) * self.units[1]

    def extra(self, x: Array) -> Array:
        """The unknowns of the condition."""
        return x[self.impacts + 3 :]

    def system(self, values: tuple[float, float]) -> System:
        """The system at values of the parameters; PercussError where there is none, or its load does not push."""
        if values not in self._systems:
            if len(self._systems) > _KEPT:
                self._systems.clear()
            found = self.family.system(dict(zip(self.names, values, strict=True)))
            check_pushes(found)
            self._systems[values] = found
        return self._systems[values]

    def refusal(self, values: tuple[float, float]) -> PercussError | None:
        """Why there can be no orbit at values."""
        try:
            self.system(values)
        except PercussError as error:
            return error
        return None

    def motion(self, x: Array) -> QuickMotion:
        """The motion at a point."""
        p, key = self.impacts, x[: self.impacts + 3].tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            system = self.system(self.values(x))
            times = self.condition.placed(system, x[:p])
            self._motions[key] = QuickMotion(system, self.periods, tuple(times.tolist()), self.modes, float(x[p]))
        return self._motions[key]

    def off(self, x: Array) -> Array:
        """The equations: those of the orbit, then the condition; one less than unknowns."""
        orbit = self.motion(x)
        return np.append(orbit.residuals, self.condition.off(orbit, x[: self.impacts], self.extra(x)))

    def matrix(self, x: Array) -> Array:
        """The derivatives of the equations by the unknowns, by central differences; on one side where a range ends."""
        columns = []
        for i in range(x.size):
            step = np.zeros(x.size)
            step[i] = _DIFFERENCE
            columns.append(_slope(self.off, x, step))
        return np.stack(columns, axis=1)

    def corrected(self, start: Array, normal: Array, along: Array, matrix: Array) -> ExtendedPoint:
        """The point of the curve in a plane.

        Parameters
        ----------
        start, normal
            A point of the plane, near the curve, and its normal.
        along
            Which way the tangent is to point.
        matrix
            The derivatives of the equations somewhere near.

        Raises
        ------
        CorrectorFailed
            When Newton's method does not get there.
        """
        look()
        x, last, renewals, own = np.array(start), np.inf, 0, False
        try:
            for step in range(1, _MOST_STEPS + 1):
                moved = np.linalg.solve(np.vstack([matrix, normal]), -np.append(self.off(x), normal @ (x - start)))
                size = float(np.abs(moved).max())
                if not size <= _LONGEST:
                    raise CorrectorFailed("a step too long")
                x = np.where(normal == 1.0, start, x + moved)  # what the plane holds is held without rounding
                if size <= _CLOSE and own:
                    self.system(self.values(x))
                    return ExtendedPoint(x, unit_tangent(matrix, along), matrix, step)
                own = False
                if size <= _CLOSE or size > _SLOW * last:
                    renewals += 1
                    if renewals > _MOST_RENEWALS:
                        break
                    matrix, own = self.matrix(x), True
                last = size
        except (PercussError, np.linalg.LinAlgError, FloatingPointError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")

    def settled(self, start: Array) -> ExtendedPoint:
        """The nearest point of the curve, with a tangent either way; or CorrectorFailed."""
        x = np.array(start)
        try:
            for step in range(1, _MOST_STEPS + 1):
                matrix = self.matrix(x)
                moved = -np.linalg.pinv(matrix) @ self.off(x)
                if not float(np.abs(moved).max()) <= _LONGEST:
                    break
                x = x + moved
                if float(np.abs(moved).max()) <= _CLOSE:
                    if self.refusal(self.values(x)) is not None:  # by rounding, where a parameter begins
                        x[self.impacts + 1 : self.impacts + 3] = start[self.impacts + 1 : self.impacts + 3]
                    return ExtendedPoint(x, np.linalg.svd(matrix)[2][-1], matrix, step)
        except (PercussError, np.linalg.LinAlgError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")

    def between(self, first: ExtendedPoint, last: ExtendedPoint, share: float) -> ExtendedPoint:
        """The point at a share of the way along the tangent of one point to another; or CorrectorFailed."""
        if share <= _INSIDE or share >= 1.0 - _INSIDE:
            return first if share < 0.5 else last
        ahead, off = first.tangent, last.x - first.x
        length = float(ahead @ off)
        start = first.x + share * length * ahead + share**2 * (off - length * ahead)
        return self.corrected(start, ahead, ahead, first.matrix if share < 0.5 else last.matrix)

    def root(
        self, first: ExtendedPoint, last: ExtendedPoint, number: Callable[[ExtendedPoint], float]
    ) -> tuple[float, ExtendedPoint]:
        """Where a number that changes its sign between two points vanishes: the share of the way, and the point."""
        low, high = number(first), number(last)
        if not low * high < 0.0:
            return (0.0, first) if abs(low) < abs(high) else (1.0, last)

        def several(shares: Array) -> Array:
            return np.array([number(self.between(first, last, float(share))) for share in shares])

        ends = (np.array([0.0]), np.array([1.0]), np.array([low]), np.array([high]))
        share = float(bracketed_roots(several, *ends, steps=30)[0])
        return share, self.between(first, last, share)


def _slope(function: Callable[[Array], Array], x: Array, step: Array) -> Array:
    """The derivative of a function along a step, by what can be evaluated of both sides."""
    length = 2.0 * float(np.abs(step).max())
    try:
        forward, inner = function(x + step), step
    except PercussError:
        forward, inner, length = function(x - step), -step, -length
    try:
        return (forward - function(x - inner)) / length
    except PercussError:
        return (4.0 * forward - function(x + 2.0 * inner) - 3.0 * function(x)) / length
