"""Where the following of an orbit begins: the value of its parameter, the range around it, the point of the curve."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.indicators import indicator
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.explore.parameters import PARAMETERS
from percuss.model import System
from percuss.model.checks import Array, numbers
from percuss.steady import PeriodicOrbit
from percuss.steady.states import check_pushes

__all__ = ["beginning", "range_around", "unit_of_turn", "value_of"]

_SAME_ORBIT = 1e-6  # rad, by which the orbit may be inexact
_LEAST = 1e-6  # of the unit of a parameter, or its inverse: a scale beyond is none
_BESIDE, _ASIDE = 1e-6, 1e-3  # rad, on both sides of a fold or flip, and how far from it one begins


def range_around(between: tuple[float, float], here: float) -> tuple[float, float]:
    """The ends of a range that holds a value."""
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value of the orbit")
    return float(ends[0]), float(ends[1])


def value_of(system: System, name: str) -> float:
    """The value of a dimensionless parameter."""
    found = PARAMETERS[name].get(system) if name in PARAMETERS else None
    if found is None:
        raise ParameterError("value", None, f"the value of {name} that belongs to the orbit")
    return found


def beginning(curve: SolutionCurve, orbit: PeriodicOrbit, value: float, bounds: tuple[float, float]) -> CurvePoint:
    """The point of the orbit, the tangent towards greater values of the parameter; of a fold or flip, one beside it."""
    check_pushes(curve.system(value))
    if not orbit.admissible:
        raise ParameterError("orbit", str(orbit), "an admissible orbit")
    x = curve.unknowns(orbit, value)
    matrix = curve.matrix(orbit, curve.column(orbit, value))
    tangent = np.linalg.svd(matrix)[2][-1]
    tangent = tangent if tangent[-1] >= 0.0 else -tangent
    found = None
    for normal in (curve.level, tangent):  # the second at a fold
        try:
            found = curve.corrected(x, normal, tangent)
            break
        except Strayed:
            continue
    if found is None or float(np.abs(found.x - x).max()) > _SAME_ORBIT:
        raise ParameterError("orbit", str(orbit), f"an orbit of the system with {curve.name} = {value:.9g}")
    beside = _off(curve, found)
    return beside if bounds[0] <= curve.value(beside.x) <= bounds[1] else found


def unit_of_turn(curve: SolutionCurve, start: CurvePoint) -> float:
    """By how much the parameter changes while the impacts move by about 1 rad."""
    moved = float(np.abs(start.tangent[: curve.impacts]).max())
    size = float(abs(start.tangent[-1])) / moved if moved else 1.0
    return curve.unit * 2.0 ** round(math.log2(min(max(size, _LEAST), 1.0 / _LEAST)))


def _off(curve: SolutionCurve, start: CurvePoint) -> CurvePoint:
    """A point beside a start that is a fold or flip, which no step would pass; else the start."""
    try:
        sides = [curve.corrected(start.x + one * start.tangent, start.tangent) for one in (-_BESIDE, _BESIDE)]
        if not np.any(np.prod([_numbers(curve, one) for one in sides], axis=0) < 0.0):
            return start
        beside = curve.corrected(start.x + _ASIDE * start.tangent, start.tangent)
        return beside if curve.motion(beside.x).admissible else start
    except Strayed:
        return start


def _numbers(curve: SolutionCurve, point: CurvePoint) -> Array:
    motion = curve.motion(point.x)
    return np.array([indicator(motion, 1.0), indicator(motion, -1.0)])
