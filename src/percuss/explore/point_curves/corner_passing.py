"""Past a step of the load: there the equations have a corner, and a curve of grazings or corners has one, too."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.corners import Passed, step_of
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.point_curves.conditions import Corner
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.model.checks import Array

__all__ = ["StepAhead", "beyond_step", "step_ahead"]

_DIFFERENCE = 1e-6
_BESIDE = 5e-6  # rad, beyond a step, so that differences are taken on one side of it


class StepAhead(NamedTuple):
    """A step of the load that an impact meets on the way along a tangent: how far off, and the normal of the plane."""

    distance: float
    normal: Array


def step_ahead(curve: ExtendedCurve, here: ExtendedPoint, passed: Passed) -> StepAhead | None:
    """The nearest one ahead; None for a load without steps, or where none comes nearer.

    Parameters
    ----------
    curve, here
        The curve, and the point on it.
    passed
        How many steps of the load each impact has passed.
    """
    if not curve.system(curve.values(here.x)).load.breaks:
        return None
    own = curve.condition.which if isinstance(curve.condition, Corner) else -1
    found = []
    for i in range(curve.impacts):
        for number in (int(passed[i]) - 1, int(passed[i])) if i != own else ():
            normal = _normal(curve, here.x, i, number)
            off = float(here.x[i]) - step_of(curve.system(curve.values(here.x)), number)
            rate = float(normal @ here.tangent)
            if off * rate < 0.0:
                found.append(StepAhead(-off / rate, normal / np.linalg.norm(normal)))
    return min(found, key=lambda one: one.distance, default=None)


def _normal(curve: ExtendedCurve, x: Array, i: int, number: int) -> Array:
    """The derivative of the time from a step to an impact by the unknowns."""
    normal, p = np.zeros(x.size), curve.impacts
    normal[i] = 1.0
    for j in (p + 1, p + 2):
        aside = np.zeros(x.size)
        aside[j] = _DIFFERENCE
        ends = [step_of(curve.system(curve.values(x + way * aside)), number) for way in (1.0, -1.0)]
        normal[j] = -(ends[0] - ends[1]) / (2.0 * _DIFFERENCE)
    return normal


def beyond_step(curve: ExtendedCurve, here: ExtendedPoint, step: StepAhead) -> tuple[ExtendedPoint, ExtendedPoint]:
    """The point on a step of the load, and one hardly beyond it with the tangent there; or Strayed."""
    side = float(np.sign(step.normal @ here.tangent))
    start = here.x + step.distance * here.tangent
    on = curve.corrected(start, step.normal, here.tangent, here.matrix)
    if float(np.abs(on.x - start).max()) > step.distance:
        raise Strayed("another corner")
    matrix = curve.matrix(on.x + side * _BESIDE * step.normal)
    tangent = np.linalg.svd(matrix)[2][-1]
    tangent = tangent * np.sign(tangent @ step.normal) * side
    place = on.x + (_BESIDE / abs(float(tangent @ step.normal))) * tangent
    return on, curve.corrected(place, tangent, tangent, matrix)
