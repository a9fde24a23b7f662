"""Where a motion is impossible in a place so narrow that neither end of a step shows it."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.explore.continuation.indicators import greatest_top
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint

__all__ = ["first_impossible"]


def first_impossible(segment: Segment, points: Sequence[tuple[float, CurvePoint]]) -> CurvePoint | None:
    """The first of some points inside a step, where a mode swings up for a moment, whose motion is impossible."""
    for _, point in points:
        motion = segment.curve.motion(point.x)
        if not min(motion.speeds) > 0.0 or greatest_top(motion).height > 0.0:
            return point
    return None
