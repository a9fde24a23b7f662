"""What happens within a step along a branch, and where in it the branch ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.corners import Passed, landed, step_time, steps_passed
from percuss.explore.continuation.indicators import greatest_top, press, stays_off
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.rises import rise
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint, Number
from percuss.steady import PeriodicOrbit

__all__ = ["Happening", "end_of", "happening", "to_corner"]

_BEFORE = 1e-6  # share of the way to a place that what holds just before it is asked at


class Happening(NamedTuple):
    """What happens at a place: its kind, the point, the number of the impact or flight that it happens to, or -1."""

    kind: BranchEvent
    place: float
    point: CurvePoint
    which: int = -1


def end_of(segment: Segment, passed: Passed) -> Happening | None:
    """The first thing in a segment beyond which the motion is no orbit, or after which the curve has a corner.

    Parameters
    ----------
    segment
        The step.
    passed
        How many steps of the load there were before each impact at its start.
    """
    found = [*_deaths(segment), *_corners(segment, passed)]
    first = min(found, key=lambda one: one.place) if found else None
    segment = to_corner(segment, first)
    last = segment.length if first is None else first.place * (1.0 - _BEFORE)
    orbit = segment.curve.motion(segment.at(last).x)
    if stays_off(orbit):
        hidden = rise(segment, last)
        if hidden is None:
            return first
        last, orbit = hidden, segment.curve.motion(segment.at(hidden).x)
    return _contact(segment, orbit, last) or first


def to_corner(segment: Segment, first: Happening | None) -> Segment:
    """The part of a segment up to a corner: what is beyond it says nothing about the way there."""
    if first is None or first.kind is not BranchEvent.CORNER:
        return segment
    return Segment(segment.curve, segment.start, first.point)


def happening(segment: Segment, kind: BranchEvent, place: float, which: int = -1) -> Happening:
    """What happens at a place of a segment."""
    return Happening(kind, place, segment.at(place), which)


def _deaths(segment: Segment) -> list[Happening]:
    curve = segment.curve
    last = curve.motion(segment.stop.x).speeds

    def speed(i: int) -> Number:
        return lambda point: float(curve.motion(point.x).speeds[i])

    return [
        happening(segment, BranchEvent.DEATH, segment.root(speed(int(i))), int(i)) for i in np.flatnonzero(last <= 0.0)
    ]


def _corners(segment: Segment, passed: Passed) -> list[Happening]:
    curve = segment.curve
    now = steps_passed(curve.motion(segment.stop.x))
    found = []
    for i in np.flatnonzero(now != passed).tolist():
        later = bool(now[i] > passed[i])
        number = int(passed[i]) if later else int(passed[i]) - 1

        def off(point: CurvePoint, i: int = i, number: int = number) -> float:
            return float(point.x[i]) - step_time(curve.motion(point.x), number)

        before = min(off(segment.start), -1e-300) if later else max(off(segment.start), 1e-300)
        near = happening(segment, BranchEvent.CORNER, segment.root(off, below=before), i)
        point = landed(curve, near.point, i, passed)
        place = float(segment.start.tangent @ (point.x - segment.start.x))
        found.append(near._replace(point=point, place=place))
    return found


def _contact(segment: Segment, beyond: PeriodicOrbit, last: float) -> Happening | None:
    """Where the bar first touches the wall between two impacts, or stays on it after one."""
    curve, found = segment.curve, []

    def top(point: CurvePoint) -> float:
        return max(greatest_top(curve.motion(point.x)).height, -1.0)

    def pressed(point: CurvePoint) -> float:
        return press(curve.motion(point.x))[0]

    if greatest_top(beyond).height > 0.0:
        place = segment.root(top, 0.0, last)
        found.append(happening(segment, BranchEvent.TOUCH, place))
    if not beyond.system.contact.rebounds and press(beyond)[0] >= 0.0:
        place = segment.root(pressed, 0.0, last)
        at = segment.at(place)
        found.append(Happening(BranchEvent.STICKING, place, at, press(curve.motion(at.x))[1]))
    return min(found, key=lambda one: one.place) if found else None
