"""What happens between two points of a curve over two parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from percuss.explore.continuation.corners import Passed, step_of, steps_passed
from percuss.explore.point_curves.clearance import Clearance, clearance
from percuss.explore.point_curves.codimension_two import tests_of
from percuss.explore.point_curves.conditions import Corner
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.explore.point_curves.happening import CurveHappening, without_what_follows
from percuss.explore.point_curves.kinds import CurveEvent

__all__ = ["clearance_at", "happenings", "passed_at"]


def clearance_at(curve: ExtendedCurve, point: ExtendedPoint) -> Clearance:
    """How far the orbit at a point of the curve is from being none."""
    return clearance(curve.motion(point.x), curve.condition, curve.extra(point.x))


def passed_at(curve: ExtendedCurve, point: ExtendedPoint) -> Passed:
    """How many steps of the load each impact has passed; of that on a step all along, the number of the step."""
    found = steps_passed(curve.motion(point.x))
    if isinstance(curve.condition, Corner):
        found[curve.condition.which] = curve.condition.number
    return found


def happenings(
    curve: ExtendedCurve, here: ExtendedPoint, point: ExtendedPoint, clear: Clearance, passed: Passed
) -> list[CurveHappening]:
    """What happens on the way from a point to the next, in order; of the first, its clearance and steps passed."""

    def located(kind: CurveEvent, number: Callable[[ExtendedPoint], float]) -> CurveHappening:
        share, there = curve.root(here, point, number)
        return CurveHappening(kind, share, there)

    found = [located(kind, number) for kind, number in tests_of(curve, here) if number(here) * number(point) < 0.0]
    now = clearance_at(curve, point)
    for i in range(len(now)):
        if clear[i] * now[i] < 0.0:

            def margin(at: ExtendedPoint, i: int = i) -> float:
                return clearance_at(curve, at)[i]

            found.append(located(Clearance.lost(i), margin))
    after = passed_at(curve, point)
    for i in np.flatnonzero(after != passed).tolist():
        number = int(passed[i]) - (after[i] < passed[i])

        def off(at: ExtendedPoint, i: int = i, number: int = number) -> float:
            orbit = curve.motion(at.x)
            return float(orbit.times[i]) - step_of(orbit.system, number)

        found.append(located(CurveEvent.WITH_CORNER, off))
    return sorted(without_what_follows(found, curve.condition), key=lambda one: one.share)
