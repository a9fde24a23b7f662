"""Where an impact meets a step of the load: a curve of orbits has a corner there, with a tangent on either side."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, Problem, unit_tangent
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit

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
            if curve.refusal_at(aside) is None:
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
    number, x = int(passed[which]) - (not later), np.array(near.x)
    for _ in range(_MOST_STEPS):  # by the derivative on the near side: which it is at the step itself rounding decides
        matrix = np.vstack([curve.matrix(_beside(x, which, not later)), step_row(curve, x, which, number)])
        off = np.append(curve.residual(x), lateness(curve, x, which, number))
        try:
            step = np.linalg.solve(matrix, -off)
        except np.linalg.LinAlgError:
            raise CorrectorFailed("no tangent") from None
        if not float(np.abs(step).max()) < _LONGEST:
            raise CorrectorFailed("a step too long")
        x = x + step
        if float(np.abs(step).max()) < _EXACT:
            break
    else:
        raise CorrectorFailed("no convergence")
    matrix = curve.matrix(_beside(x, which, not later))
    return CurvePoint(x, unit_tangent(matrix, near.tangent), near.steps, matrix)


def corner_ahead(curve: Problem, here: CurvePoint, passed: Passed, reach: float) -> tuple[Array, CurvePoint, int]:
    """The point at which an impact meets the step of the load that it nears: where on the tangent, where, which impact.

    CorrectorFailed where none does within so much of the curve.
    """
    near = step_ahead(curve, here, passed)
    if near is None:
        raise CorrectorFailed("the load has no steps")
    place, which = near
    if not 0.0 <= place <= reach:
        raise CorrectorFailed("no step of the load is near")
    start = here.x + place * here.tangent
    return start, landed(curve, here._replace(x=start, steps=0), which, passed), which


def beyond_corner(curve: Problem, corner: CurvePoint, which: int, passed: Passed) -> tuple[CurvePoint, Array, Passed]:
    """A corner with the tangent beyond it, on which the impact that meets the step goes on the same way.

    With it, unknowns just beyond, and how many steps of the load there are before each impact there.
    """
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
