"""Curves over two parameters of which the equations alone are known: derivatives by differences, and the way back."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np

from percuss.errors import Interrupted, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, Limit, unit_tangent
from percuss.explore.family import Family
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.states import check_pushes

_MOST_STEPS, _MOST_RENEWALS = 16, 4
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad
_SLOW = 0.2  # share of the step before that a step may have before the derivatives are taken anew
_KEPT = 64


class TwoParameters(ABC):
    """A `Problem` over two parameters: see `percuss.explore.continuation.walk`."""

    family: Family
    names: tuple[str, str]
    units: tuple[float, float]
    impacts: int
    periods: int
    oriented = True
    difference = 1e-6
    """By which the unknowns are moved for derivatives."""

    _systems: dict[tuple[float, float], System]

    @abstractmethod
    def residual(self, x: Array) -> Array:
        """The equations, one less than unknowns."""

    @property
    @abstractmethod
    def places(self) -> tuple[int, int]:
        """Which of the unknowns are the parameters."""

    def values(self, x: Array) -> tuple[float, float]:
        """Both parameters at a point."""
        first, second = self.places
        return float(x[first] * self.units[0]), float(x[second] * self.units[1])

    def system_at(self, x: Array) -> System:
        """The system at a point; PercussError where there is none, or its load does not push."""
        values = self.values(x)
        if values not in self._systems:
            if len(self._systems) > _KEPT:
                self._systems.clear()
            found = self.family.system(dict(zip(self.names, values, strict=True)))
            if self.impacts:
                check_pushes(found)
            self._systems[values] = found
        return self._systems[values]

    def refusal_at(self, x: Array) -> PercussError | None:
        """Why there can be no motion at a point."""
        try:
            self.system_at(x)
        except PercussError as error:
            return error
        return None

    def limit(self, here: Array, x: Array, bounds: Sequence[tuple[float, float]]) -> Limit | None:
        """The first end of a range on the way to another place; CorrectorFailed where there is no system."""
        found, share = None, 1.0
        for i, unit, (low, high) in zip(self.places, self.units, bounds, strict=True):
            value = float(x[i]) * unit
            if not low <= value <= high:
                end = (low if value < low else high) / unit
                part = (end - here[i]) / (x[i] - here[i])
                if found is None or part < share:
                    found, share = Limit(i, end, BranchEvent.LIMIT), part
        place = here + share * (x - here)
        if found is not None:
            place[found.unknown] = found.value
        refusal = self.refusal_at(place)
        if refusal is not None:
            raise CorrectorFailed(str(refusal)) from refusal
        return found

    def matrix(self, x: Array) -> Array:
        """The derivatives of the equations by the unknowns, by central differences; on one side where a range ends."""
        return np.stack([_slope(self.residual, x, step) for step in self.difference * np.eye(x.size)], axis=1)

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        """The point of the curve in a plane with a normal, from a place of it near a point of the curve.

        The tangent is to point the way of `along`. CorrectorFailed when Newton's method does not get there.
        """
        look()
        x, last, renewals, own, matrix = np.array(start), np.inf, 0, False, near.matrix
        try:
            matrix = self.matrix(x) if matrix is None else matrix
            for step in range(1, _MOST_STEPS + 1):
                moved = np.linalg.solve(np.vstack([matrix, normal]), -np.append(self.residual(x), normal @ (x - start)))
                size = float(np.abs(moved).max())
                if not size <= _LONGEST:
                    raise CorrectorFailed("a step too long")
                x = np.where(normal == 1.0, start, x + moved)  # what the plane holds is held without rounding
                if size <= _CLOSE and own:
                    self.system_at(x)
                    return CurvePoint(x, unit_tangent(matrix, along), step, matrix)
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


def _slope(function: Callable[[Array], Array], x: Array, step: Array) -> Array:
    """The derivative of a function along a step, by what can be evaluated of both sides."""
    length = 2.0 * float(np.abs(step).max())
    try:
        forward, inner = function(x + step), step
    except Interrupted:
        raise
    except (PercussError, CorrectorFailed):
        forward, inner, length = function(x - step), -step, -length
    try:
        return (forward - function(x - inner)) / length
    except Interrupted:
        raise
    except (PercussError, CorrectorFailed):
        return (4.0 * forward - function(x + 2.0 * inner) - 3.0 * function(x)) / length
