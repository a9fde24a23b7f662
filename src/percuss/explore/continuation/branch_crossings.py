"""Where another branch crosses: det K(1) vanishes there, and the parameter does not turn back.

Motions without losses under a load that is the same backwards in time meet such points, where they cease to be the
same backwards, too. There two tangents are possible, and beside it Newton's method decides between the branches by
rounding: the point is found from both sides (Keller, in: Rabinowitz, ed., Applications of Bifurcation Theory, 1977).
"""

from __future__ import annotations

from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint, Number

__all__ = ["crossing_point"]

_SHARES = (0.5, 0.3, 0.7)  # of what is left, at which a point is sought
_CLOSE = 1e-10  # of the parameter or a time, between both sides
_MOST = 60


def crossing_point(segment: Segment, number: Number, low: float, high: float) -> tuple[float, CurvePoint] | None:
    """The place between two others at which a number changes its sign and is 0, with its point; or None.

    None where the number jumps, as it does where the two ends are on different sheets of a branch.
    """
    first, last = segment.at(low), segment.at(high)
    below, above = number(first), number(last)
    size = max(abs(below), abs(above))
    for _ in range(_MOST):
        if not high - low > _CLOSE:
            break
        found = _between(segment, low, high)
        if found is None:
            break
        place, point = found
        here = number(point)
        if here * above > 0.0:
            high, last, above = place, point, here
        else:
            low, first, below = place, point, here
    if abs(above - below) > 0.5 * size or not high > low:
        return None
    share = below / (below - above)
    return low + share * (high - low), last._replace(x=first.x + share * (last.x - first.x))


def _between(segment: Segment, low: float, high: float) -> tuple[float, CurvePoint] | None:
    """A point between two places that are ends of what is left; None where Newton's method finds none."""
    for share in _SHARES:
        place = low + share * (high - low)
        try:
            return place, segment.at(place)
        except Strayed:
            continue
    return None
