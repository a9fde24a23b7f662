"""Where a walk along a curve comes back to where it began."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.steady.periodic.sameness import differences, load_turn

__all__ = ["home_of"]

_FIRST = 8  # points of a walk before which it is not looked for
_HOME = 1e-6  # rad, between the start of a walk and where it comes back to it


def home_of(
    curve: ExtendedCurve, points: Sequence[ExtendedPoint], here: ExtendedPoint, point: ExtendedPoint
) -> ExtendedPoint | None:
    """The start of a walk, if its step to a point comes back to it or past it, with the times of now."""
    first, p = points[0], curve.impacts
    reach = 2.0 * float(np.linalg.norm(point.x - here.x))
    if len(points) < _FIRST or np.abs(first.x[p + 1 : p + 3] - point.x[p + 1 : p + 3]).max() > reach:
        return None
    orbit = curve.motion(first.x)
    off = point.x - first.x
    turn = load_turn(orbit.system.load)
    off[:p] = differences(point.x[:p], first.x[None, :p], orbit.period, turn)[0, 0]
    ahead, along = float(off @ first.tangent), float(point.tangent @ first.tangent)
    if np.abs(off).max() > reach or not 0.0 <= ahead <= reach or along <= 0.0:
        return None
    try:  # another part of the curve may be as near: only the start itself is home
        start = point.x - ahead / along * point.tangent
        back = curve.corrected(start, first.tangent, first.tangent, point.matrix)
    except Strayed:
        return None
    place = point.x - off
    return first._replace(x=place) if float(np.abs(back.x - place).max()) < _HOME else None
