"""Where a motion is impossible in a place so narrow that neither end of a step shows it, or no step leads past it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.happenings import Happening
from percuss.explore.continuation.indicators import greatest_top
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.limits import refused
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.steady.periodic.newton import COALESCED

__all__ = ["dying", "first_impossible", "stuck"]

_NEAR = 1e-7  # rad, before the place where an impact dies
_BACK = 4  # points
_HALF = 0.5
_RESONANT = 1e-6  # det(I − M_n) below which internal resonance does


def stuck(curve: SolutionCurve, points: Sequence[CurvePoint], refusal: PercussError | None) -> Happening:
    """What ends a branch at the last of its points, beyond which no step leads, however short; and why not, if known.

    Parameters
    ----------
    curve, points
        The curve, and the points walked through.
    refusal
        Why the parameter goes no further, where it does not.
    """
    orbit, kind = curve.motion(points[-1].x), BranchEvent.LOST
    if float(orbit.flight_times.min()) < 1e3 * COALESCED * orbit.period:
        kind = BranchEvent.COALESCENCE
    elif np.abs(orbit.modal_determinants().real).min(initial=1.0) < _RESONANT:
        kind = BranchEvent.RESONANCE
    elif refusal is not None:
        kind = refused(refusal)
    elif (happening := dying(curve, points)) is not None:
        return happening
    return Happening(kind, 0.0, points[-1])


def dying(curve: SolutionCurve, points: Sequence[CurvePoint]) -> Happening | None:
    """The death of an impact just beyond the last of some points, to which they lead straight; or None.

    Where several impacts die at once the equations are singular, and Newton's method does not get past the place.
    """
    last = points[-1]
    now = curve.motion(last.x).speeds
    for first in points[-2 : -_BACK - 2 : -1]:  # so near to the place, the last step may have gone back by rounding
        before, way = curve.motion(first.x).speeds, last.x - first.x
        which = int(np.argmin(now / before))
        nearer = float(before[which] - now[which])
        share = float(now[which]) / nearer if nearer > 0.0 else 0.0
        if 0.0 < share * float(np.linalg.norm(way)) < _NEAR:
            return Happening(BranchEvent.DEATH, 0.0, last._replace(x=last.x + share * way), which)
    return None


def first_impossible(segment: Segment, points: Sequence[tuple[float, CurvePoint]]) -> CurvePoint | None:
    """The first of some points inside a step, where a mode swings up for a moment, whose motion is impossible.

    Where no mode swings further than at both ends, by as much as half of what is left there between the bar and the
    wall, or of the velocity of an impact, the flights are not looked at.
    """
    if not points:
        return None
    first, last = (segment.curve.motion(point.x) for point in (segment.start, segment.stop))
    known = first.system.body.modes(first.modes, first.system.load.at)
    size, widest = np.abs(known.gamma), np.maximum(first.amplitudes, last.amplitudes)
    off = -_HALF * max(greatest_top(first).height, greatest_top(last).height)
    away = _HALF * min(float(min(one.speeds.min(), one.rebound_speeds.min())) for one in (first, last))
    for _, point in points:
        motion = segment.curve.motion(point.x)
        if not motion.speeds.min() > 0.0:
            return point
        more = np.maximum(motion.amplitudes - widest, 0.0) * size
        if more.sum(axis=1).max() <= off and (more @ known.omega).max() <= away:
            continue
        if greatest_top(motion).height > 0.0:
            return point
    return None
