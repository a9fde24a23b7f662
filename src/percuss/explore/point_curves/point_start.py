"""What a point of a branch of orbits is, as a condition, and the unknowns that this brings."""

from __future__ import annotations

import math

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.continuation.branch import BranchPoint
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.point_curves.conditions import Condition, Corner, Death, Touch
from percuss.explore.point_curves.multiplier_conditions import Multiplier, Pair
from percuss.steady import PeriodicOrbit

__all__ = ["FOLLOWED", "point_condition"]

FOLLOWED = (
    BranchEvent.FOLD, BranchEvent.FLIP, BranchEvent.HALVING, BranchEvent.NEIMARK_SACKER, BranchEvent.TOUCH,
    BranchEvent.DEATH, BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD,
)  # fmt: skip
"""The kinds of points of which there are curves."""


def point_condition(point: BranchPoint) -> tuple[Condition, list[float]]:
    """What the orbits of the curve have in common, and the unknowns that this brings."""
    kind, orbit = point.kind, point.orbit
    if kind is BranchEvent.FOLD:
        return Multiplier.of(orbit, 1.0), []
    if kind in (BranchEvent.FLIP, BranchEvent.HALVING):
        return Multiplier.of(orbit, -1.0), []
    if kind is BranchEvent.NEIMARK_SACKER and point.multipliers is not None:
        turning = point.multipliers[np.abs(point.multipliers.imag) > 0.0]
        cosine = math.cos(float(np.angle(turning[np.argmin(np.abs(np.abs(turning) - 1.0))])))
        return Pair.of(orbit, cosine), [cosine]
    if kind is BranchEvent.DEATH and point.impact is not None:
        return Death(point.impact - 1), []
    if kind is BranchEvent.TOUCH and point.touch_phase is not None:
        return _touch(orbit, point.touch_phase)
    if kind in (BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD) and point.impact is not None:
        return Corner.of(orbit, point.impact - 1), []
    known = ", ".join(one.value for one in FOLLOWED)
    raise ParameterError("point", str(point), f"a point of one of the kinds {known}")


def _touch(orbit: PeriodicOrbit, phase: float) -> tuple[Touch, list[float]]:
    """The flight in which the bar touches the wall at a phase, and how long after its start."""
    turn = 2.0 * math.pi
    after = float(np.mod(phase - orbit.times[0], turn)) + turn * np.arange(orbit.periods)
    time = float(after[np.argmax(orbit.end_point(after))])
    starts = np.array(orbit.times) - orbit.times[0]
    flight = int(np.searchsorted(starts, time, side="right")) - 1
    return Touch(flight), [time - float(starts[flight])]
