"""Where a walk along a closed curve comes back to its start."""

from __future__ import annotations

import numpy as np

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint
from percuss.steady.periodic.sameness import differences, load_turn

__all__ = ["home"]

_HOME = 1e-6  # rad, between the start of a walk and where it comes back to it


def home(first: CurvePoint, segment: Segment) -> CurvePoint | None:
    """The start of a walk, if a step comes back to it or past it, with the times of now."""
    curve, stop = segment.curve, segment.stop
    if abs(first.x[-1] - stop.x[-1]) > 2.0 * segment.length:
        return None
    p, orbit = curve.impacts, curve.motion(first.x)
    off = stop.x - first.x
    off[:p] = differences(stop.x[:p], first.x[None, :p], orbit.period, load_turn(orbit.system.load))[0, 0]
    if np.abs(off).max() > 2.0 * segment.length:
        return None
    ahead, along = float(off @ first.tangent), float(stop.tangent @ first.tangent)
    if not 0.0 <= ahead <= segment.length or along <= 0.0:
        return None
    try:  # another sheet of the branch may be as near: only the start itself is home
        back = curve.corrected(stop.x - ahead / along * stop.tangent, first.tangent)
    except Strayed:
        return None
    place = stop.x - off
    return first._replace(x=place) if float(np.abs(back.x - place).max()) < _HOME else None
