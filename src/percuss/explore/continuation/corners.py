"""Where an impact meets a step of the load: the curve of orbits has a corner there, with a tangent on either side."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.next_point import Strayed, unit_tangent
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit

__all__ = ["Passed", "beyond_corner", "corner_ahead", "step_of", "steps_passed"]

Passed: TypeAlias = npt.NDArray[np.int64]
"""How many steps of the load there are before each impact."""

_ASIDE = 1e-5  # rad, by which an impact is moved to one side of a step: more than differences by the parameter move it
_DIFFERENCE = 1e-6  # of the unit of the parameter
_EXACT = 1e-11  # of a step of Newton's method: what is left is less by the factor _ASIDE
_MOST_STEPS, _LONGEST = 12, 0.5


def steps_passed(orbit: PeriodicOrbit) -> Passed:
    """How many steps of the load there are before each impact, counted from its time 0 on; shape (p,)."""
    breaks = np.asarray(orbit.system.load.breaks)
    if not breaks.size:
        return np.zeros(orbit.impacts, dtype=np.int64)
    turns = np.floor_divide(np.array(orbit.times) - breaks[0], 2.0 * math.pi)
    phases = np.array(orbit.times) - 2.0 * math.pi * turns
    return np.asarray(turns * breaks.size + np.searchsorted(breaks, phases, side="right"), dtype=np.int64)


def step_time(orbit: PeriodicOrbit, number: int) -> float:
    """When the step of the load with a number is, counted from time 0 on."""
    return step_of(orbit.system, number)


def step_of(system: System, number: int) -> float:
    """The same of a system."""
    breaks = system.load.breaks
    turns, which = divmod(number, len(breaks))
    return float(breaks[which]) + 2.0 * math.pi * turns


def step_row(curve: SolutionCurve, x: Array, which: int, number: int) -> Array:
    """How an impact comes to be later than a step of the load, by the unknowns: some parameters move the step."""
    row, value = np.zeros(x.size), curve.value(x)
    here = step_time(curve.motion(x), number)
    for h in (_DIFFERENCE, -_DIFFERENCE):
        aside = np.array(x)
        aside[-1] += h
        if curve.refusal(value + h * curve.unit) is None:
            row[-1] = -(step_time(curve.motion(aside), number) - here) / h
            break
    row[which] = 1.0
    return row


def step_ahead(curve: SolutionCurve, here: CurvePoint, which: int, passed: Passed) -> tuple[float, int] | None:
    """How far along the tangent an impact meets the next step of the load, and the number of the impact."""
    orbit = curve.motion(here.x)
    if not orbit.system.load.breaks:
        return None
    places = []
    for number in (int(passed[which]), int(passed[which]) - 1):  # an impact may run after a step that flees, too
        nearing = float(step_row(curve, here.x, which, number) @ here.tangent)
        if nearing * (number - int(passed[which]) + 0.5) > 0.0:
            places.append((step_time(orbit, number) - float(here.x[which])) / nearing)
    return (min(places), which) if places else None


def landed(curve: SolutionCurve, near: CurvePoint, which: int, passed: Passed) -> CurvePoint:
    """The point of the curve at which an impact is exactly at a step, with the tangent before it; or Strayed."""
    later = is_later(curve, near, which, passed)
    number, x = int(passed[which]) - (not later), np.array(near.x)
    for _ in range(_MOST_STEPS):  # by the derivative on the near side: which it is at the step itself rounding decides
        aside = beside(curve, near._replace(x=x), which, not later)
        matrix = np.vstack(
            [curve.matrix(aside, curve.column(aside, curve.value(x))), step_row(curve, x, which, number)]
        )
        off = np.append(curve.linearised(x)[1], float(x[which]) - step_time(curve.motion(x), number))
        try:
            step = np.linalg.solve(matrix, -off)
        except np.linalg.LinAlgError:
            raise Strayed("no tangent") from None
        if not float(np.abs(step).max()) < _LONGEST:
            raise Strayed("a step too long")
        x = x + step
        if float(np.abs(step).max()) < _EXACT:
            break
    else:
        raise Strayed("no convergence")
    point = CurvePoint(x, near.tangent, near.steps)
    orbit = beside(curve, point, which, not later)
    matrix = curve.matrix(orbit, curve.column(orbit, curve.value(point.x)))
    return CurvePoint(point.x, unit_tangent(matrix, near.tangent), point.steps)


def corner_ahead(curve: SolutionCurve, here: CurvePoint, passed: Passed, reach: float) -> tuple[Array, CurvePoint, int]:
    """The point at which an impact meets the step of the load that it nears: where on the tangent, where, which impact.

    Strayed where none does within so much of the curve.
    """
    near = [one for i in range(curve.impacts) if (one := step_ahead(curve, here, i, passed))]
    if not near:
        raise Strayed("the load has no steps")
    place, which = min(near)
    if not 0.0 <= place <= reach:
        raise Strayed("no step of the load is near")
    start = here.x + place * here.tangent
    return start, landed(curve, CurvePoint(start, here.tangent, 0), which, passed), which


def beyond_corner(
    curve: SolutionCurve, corner: CurvePoint, which: int, passed: Passed
) -> tuple[CurvePoint, PeriodicOrbit, Passed]:
    """A corner with the tangent beyond it, on which the impact that meets the step goes on the same way; or Strayed.

    With it, the motion just beyond, and how many steps of the load there are before each impact there.
    """
    later = is_later(curve, corner, which, passed)
    orbit = beside(curve, corner, which, later)
    matrix = curve.matrix(orbit, curve.column(orbit, curve.value(corner.x)))
    row = step_row(curve, corner.x, which, int(passed[which]) - (not later))
    tangent = unit_tangent(matrix, row if later else -row)
    after = np.array(passed)
    after[which] += 1 if later else -1
    return CurvePoint(corner.x, tangent, corner.steps), orbit, after


def is_later(curve: SolutionCurve, point: CurvePoint, which: int, passed: Passed) -> bool:
    """Whether the step that an impact has come to is the one after it, not the one before."""
    orbit, time = curve.motion(point.x), float(point.x[which])
    after, before = (abs(step_time(orbit, int(passed[which]) - back) - time) for back in (0, 1))
    return after <= before


def beside(curve: SolutionCurve, point: CurvePoint, which: int, later: bool) -> PeriodicOrbit:
    """The motion at a corner, with the impact that meets the step moved a little to the side that is asked for."""
    x = np.array(point.x)
    x[which] += _ASIDE if later else -_ASIDE
    return curve.motion(x)
