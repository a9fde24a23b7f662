"""Where a motion is impossible in a place so narrow that neither end of a step shows it."""

from __future__ import annotations

from percuss.explore.continuation.indicators import stays_off
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.resonances import resonant_places
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint

__all__ = ["first_impossible"]


def first_impossible(segment: Segment) -> CurvePoint | None:
    """The first point inside a step, of those where a mode swings up for a moment, whose motion is impossible."""
    if not segment.curve.modes:
        return None
    for place in resonant_places(segment, 0.0, segment.length):
        try:
            point = segment.at(place)
        except Strayed:
            continue
        motion = segment.curve.motion(point.x)
        if not min(motion.speeds) > 0.0 or not stays_off(motion):
            return point
    return None
