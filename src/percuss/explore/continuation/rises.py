"""Whether the bar passes through the wall for a moment of a step along a branch, and at neither of its ends."""

from __future__ import annotations

from percuss.explore.continuation.indicators import greatest_top
from percuss.explore.continuation.segment import Segment

__all__ = ["rise"]

_NEAR = 0.5  # share of the nearest of three heights below the wall
_GOLDEN, _LOOKS = 0.6180339887498949, 8


def _height(segment: Segment, place: float) -> float:
    """The greatest maximum of the gap function inside the flights, at a place; −1 for none."""
    return max(greatest_top(segment.curve.motion(segment.at(place).x)).height, -1.0)


def rise(segment: Segment, last: float) -> float | None:
    """A place within a segment at which the bar passes through the wall although it does not at either end; or None.

    Looked for where three values let a maximum be expected that is nearer to 0 than they are.
    """
    low, middle, high = (_height(segment, share * last) for share in (0.0, 0.5, 1.0))
    if middle > 0.0:
        return 0.5 * last
    bend, slope = 2.0 * (low - 2.0 * middle + high), 4.0 * middle - 3.0 * low - high
    if not (bend < 0.0 < slope < -2.0 * bend) or low - 0.25 * slope**2 / bend < _NEAR * max(low, middle, high):
        return None
    first, second = 0.0, last
    for _ in range(_LOOKS):  # golden section
        inner, outer = (second - _GOLDEN * (second - first), first + _GOLDEN * (second - first))
        heights = _height(segment, inner), _height(segment, outer)
        if max(heights) > 0.0:
            return inner if heights[0] > 0.0 else outer
        first, second = (first, outer) if heights[0] > heights[1] else (inner, second)
    return None
