"""What is walked along: equations over one parameter or two with one unknown more, their systems and ranges."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from percuss.errors import LoadError, ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.family import Family, SystemFamily, family_of
from percuss.explore.parameters import PARAMETERS
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, finite, numbers
from percuss.steady.periodic.periodic_orbit import slope
from percuss.steady.states import check_pushes

# ---- What is varied: the systems, and of each parameter its value at first, its range, and what counts as a step

_UNITS = 4.0  # of the range of a parameter, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


class Varied(NamedTuple):
    """The systems, and of each parameter that is varied the name, its value where that begins, and the range."""

    family: Family
    names: tuple[str, ...]
    here: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]

    @property
    def units(self) -> tuple[float, ...]:
        """By how much each changes for a step of 1."""
        return tuple(unit_of(bounds, here) for bounds, here in zip(self.bounds, self.here, strict=True))

    @property
    def shown_units(self) -> tuple[str, ...]:
        """The units of SI that each is told in; empty for plain numbers."""
        known = getattr(self.family, "units", {})
        return tuple(known.get(name, "") for name in self.names)

    def __str__(self) -> str:
        return ", ".join(f"{name} = {value:.9g}" for name, value in zip(self.names, self.here, strict=True))


def varied(
    system: System,
    family: System | Family | None,
    names: Sequence[str],
    between: Sequence[object],
    values: Sequence[float | None],
) -> Varied:
    """What is varied, checked; None for a family, a range or a value stands for what the system itself tells."""
    found = Varied(SystemFamily(system) if family is None else family_of(family), tuple(names), (), ())
    found.family.check(dict(zip(names, found.shown_units, strict=True)))
    here = tuple(_value_at(system, name, value) for name, value in zip(names, values, strict=True))
    return found._replace(here=here, bounds=tuple(map(_range_around, between, here)))


def _range_around(between: object, here: float) -> tuple[float, float]:
    if between is None:
        return -math.inf, math.inf
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value that is followed")
    return float(ends[0]), float(ends[1])


def _value_at(system: System, name: str, given: float | None) -> float:
    if given is not None:
        return finite("value", given)
    found = PARAMETERS[name].get(system) if name in PARAMETERS else None
    if found is None:
        raise ParameterError("value", None, f"the value of {name} that belongs to what is followed")
    return found


def unit_of(bounds: tuple[float, float], here: float) -> float:
    """By how much a parameter changes for a step of 1, a power of 2, so that nothing is rounded by it."""
    scale, (low, high) = max(1.0, abs(here)), bounds
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))


# ---- Problems, and points of their curves


class CorrectorFailed(Exception):
    """Newton's method found no point of the curve, or not the one that was meant."""


class CurvePoint(NamedTuple):
    """A point of a curve: its unknowns, and the unit tangent there."""

    x: Array
    tangent: Array
    steps: int  # that Newton's method took
    matrix: Array | None = None  # the derivatives of the equations, where it was asked for them


class Limit(NamedTuple):
    """Where an unknown that is a parameter goes no further: its number, the last value, what is there, and why."""

    unknown: int
    value: float
    kind: BranchEvent
    refusal: PercussError | None = None


def refused(refusal: PercussError) -> BranchEvent:
    """What ends a curve where there is no system, or its load does not push."""
    return BranchEvent.NO_PUSH if isinstance(refusal, LoadError) else BranchEvent.NO_SYSTEM


def unit_tangent(matrix: Array, along: Array) -> Array:
    """The unit tangent that goes the same way as `along`; CorrectorFailed where it is at right angles to it."""
    try:
        found = np.linalg.solve(np.vstack([matrix, along]), np.append(np.zeros(along.size - 1), 1.0))
    except np.linalg.LinAlgError:
        raise CorrectorFailed("no tangent") from None
    return np.asarray(found / np.linalg.norm(found))


_MOST_STEPS, _MOST_RENEWALS = 16, 4
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad
_SLOW = 0.2  # share of the step before that a step may have before the derivatives are taken anew
_KEPT = 64  # systems


class Problem(ABC):
    """Equations whose solutions are a curve: one less than unknowns, the impact times first among these.

    Of one that tells no more than its equations derivatives are taken by differences.
    """

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]  # by how much each parameter changes for what counts as a step of 1 rad
    impacts: int  # how many of the unknowns are impact times
    periods: int
    oriented = True  # whether the equations stay the same along the curve: then their derivatives keep its sense
    difference = 1e-6  # by which the unknowns are moved for derivatives

    @property
    @abstractmethod
    def places(self) -> tuple[int, ...]:
        """Which of the unknowns are the parameters."""

    @abstractmethod
    def residual(self, x: Array) -> Array:
        """The equations, one less than unknowns."""

    # -- the systems --

    @cached_property
    def _systems(self) -> dict[tuple[float, ...], System]:
        return {}

    def system(self, *values: float) -> System:
        """The system at values of the parameters; PercussError where there is none."""
        if values not in self._systems:
            if len(self._systems) > _KEPT:
                self._systems.clear()
            self._systems[values] = self.family.system(dict(zip(self.names, values, strict=True)))
        return self._systems[values]

    def values(self, x: Array) -> tuple[float, ...]:
        """The parameters at a point."""
        return tuple(float(x[place] * unit) for place, unit in zip(self.places, self.units, strict=True))

    def system_at(self, x: Array) -> System:
        """The system at a point; PercussError where there is none, or its load does not push."""
        refusal = self.refusal(*self.values(x))
        if refusal is not None:
            raise refusal
        return self.system(*self.values(x))

    def refusal(self, *values: float) -> PercussError | None:
        """Why there can be no motion: there is no system, or its load does not push."""
        try:
            found = self.system(*values)
            if self.impacts:
                check_pushes(found)
        except PercussError as error:
            return error
        return None

    def limit(self, here: Array, x: Array, bounds: Sequence[tuple[float, float]]) -> Limit | None:
        """The first end of a range on the way to another place, or what `refused` there says."""
        found, share = None, 1.0
        for i, unit, (low, high) in zip(self.places, self.units, bounds, strict=True):
            value = float(x[i]) * unit
            if not low <= value <= high:
                end = (low if value < low else high) / unit
                part = (end - here[i]) / (x[i] - here[i])
                if found is None or part < share:
                    found, share = Limit(i, end, BranchEvent.LIMIT), part
        place = x if found is None else here + share * (x - here)
        if found is not None:
            place[found.unknown] = found.value
        refusal = self.refusal(*self.values(place))
        return found if refusal is None else self.refused(here, place, refusal)

    def refused(self, here: Array, place: Array, refusal: PercussError) -> Limit:
        """The last place on the way to one where there is no motion; here CorrectorFailed, and a shorter step."""
        raise CorrectorFailed(str(refusal)) from refusal

    # -- the way back to the curve --

    def matrix(self, x: Array) -> Array:
        """The derivatives of the equations by the unknowns, by central differences; on one side where a range ends."""

        def moved(way: Array) -> Callable[[float], Array]:
            return lambda by: self.residual(x + by * way)

        return np.stack([slope(moved(way), self.difference, CorrectorFailed) for way in np.eye(x.size)], axis=1)

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
