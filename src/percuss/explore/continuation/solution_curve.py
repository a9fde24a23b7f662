"""The curve of an orbit over a parameter: its equations, the way back to it, and its tangent.

The unknowns are the impact times, the mean velocity just after the first impact and the parameter, x = (t_1 … t_p, r,
λ/unit): p + 1 equations, so that the solutions are a curve. It is walked by its arclength (Keller, in: Rabinowitz, ed.,
Applications of Bifurcation Theory, 1977, 359–384), which goes round folds; and since no equation is divided by the
speed of an impact it is as smooth where an impact dies as elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.followed_orbit import FollowedOrbit
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.parameter_rows import ParameterRows
from percuss.explore.family import Family
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit, parameter_column
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.system_numbers import Numbers
from percuss.steady.states import check_pushes

__all__ = ["CurvePoint", "Number", "SolutionCurve", "turning", "twice", "where_it_vanishes"]

_MOST_STEPS, _MOST_ROWS = 12, 6
_KEPT = 32  # systems and motions
_CLOSE = 1e-9  # after a step below this there is none: what is left is its square
_FOUND, _WORDS = 0, {1: "no convergence", 2: "a step too long"}
_LONGEST = 0.5  # rad; a longer step of Newton's method has lost its way
_SEARCH_STEPS = 20
_DIFFERENCE = 1e-6
_ROUNDING = 1e-11


class CurvePoint(NamedTuple):
    """A point of the curve: its unknowns, the unit tangent there, and how many steps Newton's method took."""

    x: Array
    tangent: Array
    steps: int


Number: TypeAlias = Callable[[CurvePoint], float]


@dataclass(frozen=True)
class SolutionCurve:
    """The orbits z=p/n of a family of systems over one parameter.

    Parameters
    ----------
    family, name
        The systems, and which parameter is varied.
    impacts, periods, modes
        p, n and N.
    unit
        By how much the parameter changes for what counts as a step of 1 rad.
    """

    family: Family
    name: str
    impacts: int
    periods: int
    modes: int
    unit: float
    _systems: dict[float, System] = field(default_factory=dict, repr=False, compare=False)
    _motions: dict[bytes, FollowedOrbit] = field(default_factory=dict, repr=False, compare=False)
    _rooms: dict[tuple[int, ...], Any] = field(default_factory=dict, repr=False, compare=False)

    def other(self, impacts: int, periods: int) -> SolutionCurve:
        """The orbits of another label, of the same systems."""
        made = SolutionCurve(self.family, self.name, impacts, periods, self.modes, self.unit, self._systems)
        made.__dict__["rows"] = self.rows
        return made

    @cached_property
    def rows(self) -> ParameterRows:
        """The numbers of the systems for compiled functions."""
        return ParameterRows(self.system, self.modes, self.unit)

    def _room(self, numbers: Numbers) -> Any:
        key = numbers.waves, numbers.steps
        if key not in self._rooms:
            self._rooms[key] = numbers.room(self.impacts)
        return self._rooms[key]

    @property
    def moving_modes(self) -> int:
        """How many modes move, the rigid motion among them."""
        any_value = next(iter(self._systems.values()), None)
        return self.modes + (0 if any_value is not None and not any_value.body.is_free else 1)

    def system(self, value: float) -> System:
        """The system at a value of the parameter; PercussError where there is none."""
        if value not in self._systems:
            if len(self._systems) > _KEPT:
                self._systems.clear()
            self._systems[value] = self.family.system({self.name: value})
        return self._systems[value]

    def refusal(self, value: float) -> PercussError | None:
        """Why no orbit can be looked for at a value: there is no system, or its load does not push."""
        try:
            check_pushes(self.system(value))
        except PercussError as error:
            return error
        return None

    def value(self, x: Array) -> float:
        """The parameter at a point."""
        return float(x[-1]) * self.unit

    def motion(self, x: Array) -> FollowedOrbit:
        """The motion at a point; the first impact is the one that was the first all along the curve."""
        p, key = self.impacts, x.tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            system, times = self.system(self.value(x)), tuple(x[:p].tolist())
            self._motions[key] = FollowedOrbit(system, self.periods, times, self.modes, float(x[p]))
        return self._motions[key]

    def unknowns(self, orbit: PeriodicOrbit, value: float) -> Array:
        """The point of an orbit."""
        return np.array([*orbit.times, orbit.rigid_rebounds[0], value / self.unit])

    def matrix(self, orbit: PeriodicOrbit, column: Array) -> Array:
        """The derivative of the equations by the unknowns; shape (p + 1, p + 2)."""
        p, found = self.impacts, np.empty((self.impacts + 1, self.impacts + 2))
        found[:, : p + 1] = orbit.bordered().real
        found[:, 0] -= turning(orbit) * found[:, p]
        found[:, p + 1] = column * self.unit
        return found

    def column(self, orbit: PeriodicOrbit, value: float) -> Array:
        """The derivative of the equations by the parameter; shape (p + 1,)."""
        return parameter_column(orbit, self.system, value)

    def corrected(
        self, start: Array, normal: Array, along: Array | None = None, column: Array | None = None
    ) -> CurvePoint:
        """The point of the curve in a plane.

        Parameters
        ----------
        start
            A point of the plane, near the curve; shape (p + 2,).
        normal
            Of the plane.
        along
            Which way the tangent is to point; `normal` by default.
        column
            The derivative by the parameter, where it is to stay; else it is computed.

        Raises
        ------
        Strayed
            When Newton's method does not get there.
        """
        look()
        x, p, way = np.array(start), self.impacts, normal if along is None else along
        derivative, tangent, steps = np.empty((p + 1, p + 3)), np.empty(p + 2), 0
        if column is not None:
            derivative[:, p + 1] = column * self.unit
        for _ in range(_MOST_ROWS):
            try:
                base, numbers, rate = self.rows.near(self.value(x))
                ended, taken = orbit_kernels().corrected(
                    numbers.row, rate, base, self.unit, self._room(numbers), 2.0 * math.pi * self.periods,
                    x, normal, way, (_MOST_STEPS, _CLOSE, _LONGEST), column is not None, derivative, tangent,
                )  # fmt: skip
                if ended != _FOUND:
                    raise Strayed(_WORDS[ended])
                steps = steps or taken
                if not np.any(normal[:-1]):  # the parameter is held: rounding is not to lead past a limit
                    x[-1] = start[-1]
                if self.rows.fits(base, rate, self.value(x)):
                    return CurvePoint(x, tangent, steps)
            except PercussError as error:
                raise Strayed(str(error)) from None
        raise Strayed("no convergence")

    def linearised(self, x: Array) -> tuple[Array, Array]:
        """The derivative of the equations by the unknowns at a point, (p + 1, p + 2), and the equations, (p + 1,)."""
        value, found = self.value(x), np.empty((x.size - 1, x.size + 1))
        here, rate = self.rows.at(value), self.rows.near(value)[2]
        orbit_kernels().derivatives(
            here.row, rate, value, self.unit, self._room(here), 2.0 * math.pi * self.periods, x, found
        )
        return found[:, :-1], found[:, -1]

    @property
    def level(self) -> Array:
        """The normal of the planes in which the parameter is held."""
        return np.append(np.zeros(self.impacts + 1), 1.0)


def turning(orbit: PeriodicOrbit) -> float:
    """By how much the mean velocity just after the first impact grows if the impact is later, its state the same."""
    if not orbit.system.body.is_free:
        return 0.0
    first = orbit.system.load.value(np.array(orbit.times[:1]))
    return float(first[0] - orbit.system.d * orbit.rigid_rebounds[0])


def twice(x: Array, p: int, periods: int) -> Array:
    """The unknowns of an orbit told as one of twice the period."""
    return np.concatenate([x[:p], x[:p] + 2.0 * math.pi * periods, x[p:]])


def where_it_vanishes(curve: SolutionCurve, x: Array, number: Number) -> Array:
    """The point of a curve at which a number vanishes, by Newton's method from a point that is near; or Strayed."""
    x = np.array(x)
    for _ in range(_SEARCH_STEPS):
        look()
        matrix, off = curve.linearised(x)
        row, here = np.empty(x.size), number(CurvePoint(x, x, 0))
        for i in range(x.size):
            aside = np.array(x)
            aside[i] += _DIFFERENCE
            row[i] = (number(CurvePoint(aside, x, 0)) - here) / _DIFFERENCE
        try:
            step = np.linalg.solve(np.vstack([matrix, row]), -np.append(off, here))
        except np.linalg.LinAlgError:
            break
        size = float(np.abs(step).max())
        if not size < _LONGEST:
            break
        x = x + step
        if size < _ROUNDING:
            return x
    raise Strayed("no convergence")
