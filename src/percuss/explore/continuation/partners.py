"""The other branches that begin at a point of one: at a flip, and where an impact dies or is born."""

from __future__ import annotations

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.indicators import greatest_top
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.solution_curve import (
    CurvePoint,
    SolutionCurve,
    turning,
    twice,
    where_it_vanishes,
)
from percuss.model.checks import Array
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS

__all__ = ["Partner", "doubled", "grazing_partner", "is_joined", "other_end"]

Partner = tuple[SolutionCurve, CurvePoint]
"""A curve and the point on it where a branch begins, with the tangent that leads into it."""

_TRIED = 1e-3  # rad, by which it is tried which way leads into a branch


def doubled(curve: SolutionCurve, point: CurvePoint) -> Partner | None:
    """The branch z=2p/2n that begins at a flip; None for more impacts or periods than orbits may have.

    With K(−1) v = 0 its times are at first (t, t + T), and its tangent (v, −v) with the parameter at rest, so that no
    amplitude needs to be chosen.
    """
    p = curve.impacts
    if 2 * p > MOST_IMPACTS or 2 * curve.periods > MOST_PERIODS:
        return None
    orbit = curve.motion(point.x)
    null = np.linalg.svd(orbit.bordered(-1.0).real)[2][-1]
    moved = null[p] + turning(orbit) * null[0]
    tangent = np.concatenate([null[:p], -null[:p], [moved, 0.0]])
    x = twice(point.x, p, curve.periods)
    wider = curve.other(2 * p, 2 * curve.periods)
    return wider, CurvePoint(x, tangent / np.linalg.norm(tangent), 0)


def is_joined(curve: SolutionCurve) -> bool:
    """Whether an impact without speed changes nothing, so that branches with one impact more or less meet.

    Where one mode alone moves, as of a rigid bar; others have their whole velocity field changed, even when the
    striking end has no speed.
    """
    return curve.moving_modes == 1


def grazing_partner(curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int) -> Partner | None:
    """The branch with an impact more that begins at a touch, or with one less at the death of an impact.

    None where there is no such branch: an elastic bar, no impact left, or no way that leads into it.
    """
    if not is_joined(curve):
        return None
    made = _changed(curve, point, kind, which)
    if made is None:
        return None
    other, x, _ = made
    try:
        orbit = other.motion(x)
        tangent = np.linalg.svd(other.matrix(orbit, other.column(orbit, other.value(x))))[2][-1]
        for way in (tangent, -tangent):
            tried = other.motion(other.corrected(x + _TRIED * way, way).x)
            if np.all(tried.speeds > 0.0) and tried.admissible:
                return other, CurvePoint(x, way, 0)
    except (PercussError, Strayed, np.linalg.LinAlgError):
        pass
    return None


def _changed(
    curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int
) -> tuple[SolutionCurve, Array, int] | None:
    """The curve with an impact more or less, the point on it, and the number of the new impact or -1."""
    p, orbit = curve.impacts, curve.motion(point.x)
    if kind is BranchEvent.TOUCH:
        if p + 1 > MOST_IMPACTS:
            return None
        time = point.x[0] + greatest_top(orbit).time
        number = int(np.searchsorted(point.x[:p], time))
        return curve.other(p + 1, curve.periods), np.insert(point.x, number, time), number
    if p == 1:
        return None
    x = np.delete(point.x, which)
    if which == 0:
        x[p - 1] = orbit.rigid_rebounds[1]
    return curve.other(p - 1, curve.periods), x, -1


def other_end(
    curve: SolutionCurve, point: CurvePoint, kind: BranchEvent, which: int
) -> tuple[SolutionCurve, Array] | None:
    """Where the branch with an impact more or less ends, of an elastic bar: near, but not here; None if not found."""
    made = _changed(curve, point, kind, which)
    if made is None:
        return None
    other, x, number = made

    def vanishing(place: CurvePoint) -> float:
        orbit = other.motion(place.x)
        return float(orbit.speeds[number]) if number >= 0 else greatest_top(orbit).height

    try:
        found = where_it_vanishes(other, x, vanishing)
        orbit = other.motion(found)
        alive = np.delete(orbit.speeds, number) if number >= 0 else orbit.speeds
        return (other, found) if np.all(alive > 0.0) else None
    except (PercussError, Strayed, np.linalg.LinAlgError):
        return None
