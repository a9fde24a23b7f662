"""Curves of orbits: over one parameter, with the way back to them and their tangents, and round steps of the load.

The unknowns are the impact times, the mean velocity just after the first impact and the parameter, x = (t_1 … t_p, r,
λ/unit): p + 1 equations, so that the solutions are a curve. It is walked by its arclength (Keller, in: Rabinowitz, ed.,
Applications of Bifurcation Theory, 1977, 359–384), which goes round folds; and since no equation is divided by the
speed of an impact it is as smooth where an impact dies as elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    Number,
    ParameterEnd,
    Problem,
    refused,
    unit_tangent,
)
from percuss.explore.family import Family
from percuss.halting import check_interrupted
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.impact_chain import Numbers, numbers_of, orbit_kernels

# ---- The systems of a family over one parameter as rows of numbers, and how these change with it

_ROWS_KEPT = 64
_WIDE, _NARROW = 2.0**-6, 1e-6  # differences, of the unit of the parameter and of the parameter
_EVEN = 32.0 * np.finfo(float).eps  # of a number, by which it may be beside a straight line


class Numbered(Protocol):
    """What has a row of numbers."""

    @property
    def row(self) -> Array: ...


N = TypeVar("N", bound=Numbered)


class ParameterRows(Generic[N]):
    """The rows of numbers that compiled functions take for systems, or for the cycles of machines.

    Most parameters move these numbers evenly: then a row and one rate tell all systems near, to rounding, and Newton's
    method need not make a system at each of its steps. Whether it is so is looked at again wherever it ends.
    To find out, the parameter is changed by its `unit`.
    """

    def __init__(self, numbers: Callable[[float], N], unit: float) -> None:
        self._numbers, self._unit = numbers, unit
        self._rows: dict[float, N] = {}
        self._last: tuple[float, N] | None = None
        self._rate: tuple[float, Array, bool] | None = None

    def at(self, value: float) -> N:
        """The row at a value; PercussError where there is no system."""
        if value not in self._rows:
            if len(self._rows) >= _ROWS_KEPT:
                self._rows.clear()
            self._rows[value] = self._numbers(value)
        self._last = value, self._rows[value]
        return self._rows[value]

    def near(self, value: float, within: float = 0.0) -> tuple[float, N, Array]:
        """A value, its row, and the rate from which the rows near follow; PercussError where the rate changes."""
        if self._last is not None and self._rate is not None and self._rate[2]:
            return (*self._last, self._rate[1])
        known = self._rate is not None and abs(self._rate[0] - value) <= within
        row = self.at(value)
        return value, row, self._rate[1] if known and self._rate is not None else self.rate(value)

    def rate(self, value: float) -> Array:
        """How the numbers change with the parameter; shape of a row."""
        if self._rate is None or not (self._rate[2] or self._rate[0] == value):
            wide = self._difference(value, _WIDE * self._unit) if self._rate is None else None
            if wide is not None and wide[1]:
                self._rate = value, wide[0], True
            else:
                narrow = self._difference(value, _NARROW * max(1.0, abs(value)))
                if narrow is None:
                    raise PercussError("the numbers of the system do not change steadily with the parameter")
                self._rate = value, narrow[0], False
        return self._rate[1]

    def fits(self, base: float, rate: Array, value: float) -> bool:
        """Whether the row at a value is that which another row and a rate lead to; PercussError without a system."""
        row, here = self.at(base).row, self.at(value).row
        moved = (value - base) * rate
        return here.shape == row.shape and _agree(here, row + moved, np.abs(row) + np.abs(moved))

    def _difference(self, value: float, step: float) -> tuple[Array, bool] | None:
        """The rate by a difference, and whether the numbers change evenly over it; None where there are none."""
        base = self.at(value)
        here = base.row
        for first, second in ((step, -step), (-step, -2.0 * step), (step, 2.0 * step)):
            try:
                one, two = self.at(value + first).row, self.at(value + second).row
            except PercussError:
                continue
            finally:
                self._last = value, base  # the rows kept may have been dropped by now
            if one.shape != here.shape or two.shape != here.shape:
                continue
            if second == -first:
                rate, middle = (one - two) / (2.0 * step), 0.5 * (one + two)
                return rate, _agree(middle, here, np.abs(here))
            rate = (4.0 * one - two - 3.0 * here) / (2.0 * first)
            return rate, _agree(one, 0.5 * (here + two), np.abs(here))
        return None


def _agree(one: Array, other: Array, size: Array) -> bool:
    return bool(np.all(np.abs(one - other) <= _EVEN * size))


# ---- Curves of orbits over one parameter or two; over one, the way back and the tangent by compiled functions

_KEPT = 256  # motions
_EVEN_LAST, _LAST = 1e-15, 1e-12  # of a limit of the parameter
_MOST_STEPS, _MOST_ROWS = 12, 6
_CLOSE = 1e-9  # after a step below this there is none: what is left is its square
_FOUND, _WORDS = 0, {1: "no convergence", 2: "a step too long"}
_LONGEST = 0.5  # rad; a longer step of Newton's method has lost its way
_SEARCH_STEPS = 20
_DIFFERENCE = 1e-6
_ROUNDING = 1e-11  # of a step of Newton's method: beside a step of the load what is left is less by _ASIDE


class OrbitProblem(Problem):
    """Orbits z=p/n with N modes: p impact times, and the mean velocity after the first; then come the parameters."""

    modes: int
    oriented = False

    @property
    def places(self) -> tuple[int, ...]:
        return tuple(range(self.impacts + 1, self.impacts + 1 + len(self.names)))

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @cached_property
    def _motions(self) -> dict[bytes, PeriodicOrbit]:
        return {}

    def placed(self, system: System, times: Array) -> Array:
        """The times of the impacts as they stand in the equations."""
        return times

    def motion(self, x: Array) -> PeriodicOrbit:
        """The motion at a point; the first impact is the one that was the first all along the curve."""
        p, key = self.impacts, x[: self.places[-1] + 1].tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            system = self.system_at(x)
            times = tuple(self.placed(system, x[:p]).tolist())
            self._motions[key] = PeriodicOrbit(system, self.periods, times, self.modes, float(x[p]))
        return self._motions[key]


@dataclass(frozen=True)
class SolutionCurve(OrbitProblem):
    """The orbits z=p/n of a family of systems over one parameter, which changes by `unit` for a step of 1 rad."""

    family: Family
    name: str
    impacts: int
    periods: int
    modes: int
    unit: float

    def other(self, impacts: int, periods: int) -> SolutionCurve:
        """The orbits of another label, of the same systems."""
        made = SolutionCurve(self.family, self.name, impacts, periods, self.modes, self.unit)
        made.__dict__.update(rows=self.rows, _systems=self._systems)
        return made

    @property
    def names(self) -> tuple[str]:  # type: ignore[override]
        return (self.name,)

    @property
    def units(self) -> tuple[float]:  # type: ignore[override]
        return (self.unit,)

    @cached_property
    def rows(self) -> ParameterRows[Numbers]:
        """The numbers of the systems for compiled functions."""
        return ParameterRows(self._numbers, self.unit)

    def _numbers(self, value: float) -> Numbers:
        return numbers_of(self.system(value), self.modes)

    @cached_property
    def _rooms(self) -> dict[tuple[int, int], Any]:
        return {}

    def _room(self, numbers: Numbers) -> Any:
        key = numbers.waves, numbers.steps
        if key not in self._rooms:
            self._rooms[key] = numbers.room(self.impacts)
        return self._rooms[key]

    def system_at(self, x: Array) -> System:
        return self.system(self.value(x))  # whether its load pushes or not

    def refused(self, here: Array, place: Array, refusal: PercussError) -> ParameterEnd:
        """The last value of the parameter, on the way to one, at which there is a system whose load pushes."""
        good, bad = self.value(here), self.value(place)
        while abs(good - bad) > _EVEN_LAST * max(abs(good), abs(bad), self.unit):
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if self.refusal(middle) is None else (good, middle)
        even = round(good, 12)  # the limit itself, where that is allowed
        last = even if abs(even - good) < _LAST and self.refusal(even) is None else good
        return ParameterEnd(place.size - 1, last / self.unit, refused(refusal), refusal)

    def value(self, x: Array) -> float:
        """The parameter at a point."""
        return float(x[-1]) * self.unit

    def unknowns(self, orbit: PeriodicOrbit, value: float) -> Array:
        """The point of an orbit."""
        return np.array([*orbit.times, orbit.rigid_rebounds[0], value / self.unit])

    def matrix(self, x: Array) -> Array:
        return self.linearised(x)[0]

    def residual(self, x: Array) -> Array:
        return self.linearised(x)[1]

    def corrected(
        self, start: Array, normal: Array, along: Array | None = None, near: CurvePoint | None = None
    ) -> CurvePoint:
        """As of other curves, by compiled functions; the tangent points the way of the normal by default."""
        check_interrupted()
        x, p, way = np.array(start), self.impacts, normal if along is None else along
        derivative, tangent, steps = np.empty((p + 1, p + 3)), np.empty(p + 2), 0
        for _ in range(_MOST_ROWS):
            try:
                base, numbers, rate = self.rows.near(self.value(x))
                ended, taken = orbit_kernels().corrected(
                    numbers.row, rate, base, self.unit, self._room(numbers), 2.0 * math.pi * self.periods,
                    x, normal, way, (_MOST_STEPS, _CLOSE, _LONGEST), derivative, tangent,
                )  # fmt: skip
                if ended != _FOUND:
                    raise CorrectorFailed(_WORDS[ended])
                steps = steps or taken
                if not np.any(normal[:-1]):  # the parameter is held: rounding is not to lead past a limit
                    x[-1] = start[-1]
                if self.rows.fits(base, rate, self.value(x)):
                    return CurvePoint(x, tangent, steps)
            except PercussError as error:
                raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")

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


def _solved(x: Array, linearised: Callable[[Array], tuple[Array, Array]], most: int) -> Array:
    """Where as many equations as unknowns hold, by Newton's method from a point near; or CorrectorFailed."""
    x = np.array(x)
    for _ in range(most):
        check_interrupted()
        matrix, off = linearised(x)
        try:
            step = np.linalg.solve(matrix, -off)
        except np.linalg.LinAlgError:
            break
        size = float(np.abs(step).max())
        if not size < _LONGEST:
            break
        x = x + step
        if size < _ROUNDING:
            return x
    raise CorrectorFailed("no convergence")


def where_it_vanishes(curve: Problem, x: Array, number: Number) -> Array:
    """The point of a curve at which a number vanishes, by Newton's method from a point near; or CorrectorFailed."""

    def linearised(x: Array) -> tuple[Array, Array]:
        matrix, off = curve.linearised(x)
        here = number(CurvePoint(x, x, 0))
        asides = x + _DIFFERENCE * np.eye(x.size)
        row = [(number(CurvePoint(aside, x, 0)) - here) / _DIFFERENCE for aside in asides]
        return np.vstack([matrix, row]), np.append(off, here)

    return _solved(x, linearised, _SEARCH_STEPS)


# ---- Where an impact meets a step of the load: a curve of orbits has a corner there, with a tangent on either side

Passed: TypeAlias = npt.NDArray[np.int64]  # how many steps of the load there are before each impact

_ASIDE = 1e-5  # rad, by which an impact is moved to one side of a step: more than differences by the parameter move it


def steps_passed(orbit: PeriodicOrbit) -> Passed:
    """How many steps of the load there are before each impact, counted from its time 0 on; shape (p,)."""
    breaks = np.asarray(orbit.system.load.breaks)
    if not breaks.size:
        return np.zeros(orbit.impacts, dtype=np.int64)
    turns = np.floor_divide(np.array(orbit.times) - breaks[0], 2.0 * math.pi)
    phases = np.array(orbit.times) - 2.0 * math.pi * turns
    return np.asarray(turns * breaks.size + np.searchsorted(breaks, phases, side="right"), dtype=np.int64)


def step_of(system: System, number: int) -> float:
    """When the step of the load with a number is, counted from time 0 on."""
    turns, which = divmod(number, len(system.load.breaks))
    return float(system.load.breaks[which]) + 2.0 * math.pi * turns


def lateness(curve: Problem, x: Array, which: int, number: int) -> float:
    """How much later than a step of the load an impact is."""
    return float(x[which]) - step_of(curve.system_at(x), number)


def step_row(curve: Problem, x: Array, which: int, number: int) -> Array:
    """Its derivatives by the unknowns: some parameters move the step."""
    row, here = np.zeros(x.size), step_of(curve.system_at(x), number)
    for place in curve.places:
        for h in (_DIFFERENCE, -_DIFFERENCE):
            aside = np.array(x)
            aside[place] += h
            if curve.refusal(*curve.values(aside)) is None:
                row[place] = -(step_of(curve.system_at(aside), number) - here) / h
                break
    row[which] = 1.0
    return row


def step_ahead(curve: Problem, here: CurvePoint, passed: Passed, own: int = -1) -> tuple[float, int] | None:
    """How far along the tangent an impact meets the next step of the load, and which; but for one on a step anyway."""
    if not curve.system_at(here.x).load.breaks:
        return None
    places = []
    for which in (i for i in range(curve.impacts) if i != own):
        for number in (int(passed[which]), int(passed[which]) - 1):  # an impact may run after a step that flees, too
            nearing = float(step_row(curve, here.x, which, number) @ here.tangent)
            if nearing * (number - int(passed[which]) + 0.5) > 0.0:
                places.append((-lateness(curve, here.x, which, number) / nearing, which))
    return min(places, default=None)


def landed(curve: Problem, near: CurvePoint, which: int, passed: Passed) -> CurvePoint:
    """The point of the curve at which an impact is exactly at a step, with the tangent before it."""
    later = _is_later(curve, near.x, which, passed)
    number = int(passed[which]) - (not later)

    def linearised(x: Array) -> tuple[Array, Array]:
        near_side = curve.matrix(_beside(x, which, not later))  # which it is at the step itself rounding decides
        matrix = np.vstack([near_side, step_row(curve, x, which, number)])
        return matrix, np.append(curve.residual(x), lateness(curve, x, which, number))

    x = _solved(near.x, linearised, _MOST_STEPS)
    matrix = curve.matrix(_beside(x, which, not later))
    return CurvePoint(x, unit_tangent(matrix, near.tangent), near.steps, matrix)


def corner_ahead(curve: Problem, here: CurvePoint, passed: Passed, reach: float) -> tuple[Array, CurvePoint, int]:
    """Where an impact meets the step of the load that it nears: where on the tangent, the point, which impact."""
    near = step_ahead(curve, here, passed)
    if near is None:
        raise CorrectorFailed("the load has no steps")
    place, which = near
    if not 0.0 <= place <= reach:
        raise CorrectorFailed("no step of the load is near")
    start = here.x + place * here.tangent
    return start, landed(curve, here._replace(x=start, steps=0), which, passed), which


def beyond_corner(curve: Problem, corner: CurvePoint, which: int, passed: Passed) -> tuple[CurvePoint, Array, Passed]:
    """A corner with the tangent beyond it, unknowns just beyond, and the steps of the load before each impact there."""
    later = _is_later(curve, corner.x, which, passed)
    aside = _beside(corner.x, which, later)
    matrix = curve.matrix(aside)
    row = step_row(curve, corner.x, which, int(passed[which]) - (not later))
    after = np.array(passed)
    after[which] += 1 if later else -1
    return corner._replace(tangent=unit_tangent(matrix, row if later else -row), matrix=matrix), aside, after


def _is_later(curve: Problem, x: Array, which: int, passed: Passed) -> bool:
    """Whether the step that an impact has come to is the one after it, not the one before."""
    after, before = (abs(lateness(curve, x, which, int(passed[which]) - back)) for back in (0, 1))
    return after <= before


def _beside(x: Array, which: int, later: bool) -> Array:
    """Unknowns at a corner, with the impact that meets the step moved a little to the side that is asked for."""
    x = np.array(x)
    x[which] += _ASIDE if later else -_ASIDE
    return x
