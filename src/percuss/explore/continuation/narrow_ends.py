"""Where a motion is impossible in a place so narrow that neither end of a step shows it."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.explore.continuation.indicators import stays_off
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint

__all__ = ["first_impossible"]


def first_impossible(segment: Segment, places: Sequence[float]) -> CurvePoint | None:
    """The first point inside a step, of those where a mode swings up for a moment, whose motion is impossible."""
    for place in places:
        try:
            point = segment.at(place)
        except Strayed:
            continue
        motion = segment.curve.motion(point.x)
        if not min(motion.speeds) > 0.0 or not stays_off(motion):
            return point
    return None
