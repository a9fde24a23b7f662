"""The walk along a curve of orbits from a point, one way, until something ends it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from percuss.errors import Interrupted, PercussError
from percuss.explore.continuation.circle_crossings import crossings
from percuss.explore.continuation.corners import beyond_corner, corner_ahead, steps_passed
from percuss.explore.continuation.dips import may_vanish_twice
from percuss.explore.continuation.happenings import Happening, end_of, to_corner
from percuss.explore.continuation.homecoming import home
from percuss.explore.continuation.indicators import unstable
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.limits import limit_before
from percuss.explore.continuation.narrow_ends import first_impossible, stuck
from percuss.explore.continuation.next_point import FIRST, LONGEST, SHORTEST, Strayed, check_next
from percuss.explore.continuation.resonances import hides, leaps, resonant_points
from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.explore.continuation.turning_back import BESIDE, turning_back
from percuss.model.checks import Array

__all__ = ["Walk", "walked"]

_REFINED = 1e-5  # step below which none is taken again to see what its ends do not show
_QUICK = 3  # steps of Newton's method after which the next step along the curve is longer
_INSIDE = 1e-6  # share of a step beside a corner, nearer than which rounding decides on which side of it one is
_FEWEST = 8  # points of a walk that can have come back to its start


@dataclass
class Walk:
    """What one way along a curve gave.

    Parameters
    ----------
    points
        The points walked through, the first of them the start.
    unstable
        How many multipliers are outside the unit circle at each.
    happened
        What happened, in order; the last of them ended the walk.
    refusal
        Why the parameter goes no further, where it does not.
    """

    points: list[CurvePoint]
    unstable: list[int]
    happened: list[Happening] = field(default_factory=list)
    refusal: PercussError | None = None


def walked(
    curve: SolutionCurve, start: CurvePoint, bounds: tuple[float, float], most: int, *, fresh: bool = False
) -> Walk:
    """Walk from a point the way its tangent points.

    Parameters
    ----------
    curve, start
        The curve, and where on it.
    bounds
        Least and greatest value of the parameter.
    most
        Points at most.
    fresh
        Whether it begins at a flip, where the branch has an extremum of the parameter by itself.
    """
    walker = _Walker(curve, start, bounds, fresh)
    try:
        while not walker.ended and len(walker.walk.points) < most:
            walker.step()
    except Interrupted:
        pass
    if not walker.ended:
        walker.end(BranchEvent.STOPPED)
    return walker.walk


class _Target(NamedTuple):
    """Where a step leads: the point, the limit of the parameter there, what happens there, where the walk goes on."""

    point: CurvePoint
    limit: BranchEvent | None
    happening: Happening | None = None
    beyond: CurvePoint | None = None

    def at(self, segment: Segment) -> Happening | None:
        """What happens at the end of a segment."""
        return None if self.happening is None else self.happening._replace(place=segment.length)


class _Walker:
    """Where the walk is, and how long its next step will be."""

    def __init__(self, curve: SolutionCurve, start: CurvePoint, bounds: tuple[float, float], fresh: bool) -> None:
        self.curve, self.here, self.bounds, self.fresh = curve, start, bounds, fresh
        self.size = (BESIDE if fresh else FIRST) * math.sqrt(curve.impacts)
        self.passed = steps_passed(curve.motion(start.x))
        self.walk = Walk([start], [self._outside(start)])
        self.ended, self.cornered = False, False

    def _outside(self, point: CurvePoint) -> int:
        return unstable(self.curve.motion(point.x))

    def end(self, kind: BranchEvent) -> None:
        """End the walk here."""
        self.walk.happened.append(Happening(kind, 0.0, self.here))
        self.ended = True

    def step(self) -> None:
        """Go on to the next point, shorter if need be, and see what happens on the way."""
        for ahead in (self._ahead, self._at_corner):
            try:
                target = self._until_back(ahead())
                segment = Segment(self.curve, self.here, target.point)
                if not self.fresh and self.size > _REFINED and (leaps(segment) or may_vanish_twice(segment)):
                    raise Strayed("more may happen in the step than its ends show")
                inside = [] if self.fresh else resonant_points(segment, self.size <= _REFINED)
                narrow = first_impossible(segment, inside)
                if narrow is not None:
                    target, segment = _Target(narrow, None), Segment(self.curve, self.here, narrow)
                happening = end_of(segment, self.passed) or target.at(segment)
                if self.size > _REFINED and happening is None and hides(segment, inside):
                    raise Strayed("more may happen in the step than its ends show")
                part = to_corner(segment, happening)
                between = crossings(part, *self._smooth(part, happening), self.fresh, inside)
            except Strayed:
                continue
            self._went(segment, between, happening, target)
            return
        self._shorter()

    def _smooth(self, segment: Segment, happening: Happening | None) -> tuple[float, float]:
        """The part of a step between corners."""
        last = segment.length if happening is None else happening.place
        corner = happening is not None and happening.kind is BranchEvent.CORNER
        return _INSIDE * last if self.cornered else 0.0, last * (1.0 - _INSIDE) if corner else last

    def _went(self, segment: Segment, between: list[Happening], happening: Happening | None, target: _Target) -> None:
        """Keep a step with what happened in it."""
        limit, goes_on = target.limit, happening is None and target.limit is None
        back = home(self.walk.points[0], segment) if goes_on and len(self.walk.points) >= _FEWEST else None
        if back is not None:
            between = [one for one in between if float((one.point.x - back.x) @ back.tangent) < 0.0]
        for one in between:
            self._pass(one.point)
        self.walk.happened += between
        if self.fresh:
            self.fresh, self.size = False, FIRST * math.sqrt(self.curve.impacts)
        if happening is not None:
            self._at(happening, target)
            return
        self._arrive(segment.stop if back is None else back)
        if limit is not None:
            self.end(limit)
        elif back is not None:
            self.end(BranchEvent.CLOSED)
        elif segment.stop.steps <= _QUICK:
            self.size = min(1.5 * self.size, LONGEST * math.sqrt(self.curve.impacts))

    def _pass(self, point: CurvePoint) -> None:
        """Keep a point at which something happens; beside it a multiplier is on the unit circle."""
        self.walk.points.append(point)
        self.walk.unstable.append(self.walk.unstable[-1])

    def _arrive(self, point: CurvePoint) -> None:
        self.here, self.cornered = point, False
        self.walk.points.append(point)
        self.walk.unstable.append(self._outside(point))
        self.passed = steps_passed(self.curve.motion(point.x))

    def _ahead(self) -> _Target:
        """The next point, and the limit of the parameter that it lies on."""
        x, tangent = self.here.x, self.here.tangent
        place, normal = x + self.size * tangent, tangent
        limit = limit_before(self.curve, self.curve.value(x), self.curve.value(place), self.bounds)
        if limit is not None:
            self.walk.refusal = limit.refusal or self.walk.refusal
            along = limit.value / self.curve.unit - x[-1]
            if along == 0.0:
                return _Target(self.here, limit.kind)
            place = x + (along / tangent[-1] if tangent[-1] else 0.0) * tangent
            place[-1], normal = limit.value / self.curve.unit, self.curve.level
        found = self.curve.corrected(place, normal, tangent)
        self._check(found, place)
        return _Target(found, None if limit is None else limit.kind)

    def _until_back(self, target: _Target) -> _Target:
        """The same, or the place before it at which the branch turns back over its own image."""
        back = None if self.fresh else turning_back(Segment(self.curve, self.here, target.point))
        return target if back is None else _Target(back.before, None, back.happening, back.beyond)

    def _at_corner(self) -> _Target:
        """The point at which an impact meets the step of the load that it nears: the curve may turn back there."""
        start, point, which = corner_ahead(self.curve, self.here, self.passed, 2.0 * self.size)
        self._check(point, start)
        return _Target(point, None, Happening(BranchEvent.CORNER, math.nan, point, which))

    def _check(self, found: CurvePoint, place: Array) -> None:
        before, after = (self.here.x, self.here.tangent), (found.x, found.tangent)
        check_next(before, after, place, self.size, self.curve.impacts, self.curve.periods)

    def _shorter(self) -> None:
        """Try a shorter step; where none is short enough, say why."""
        self.size *= 0.5
        if self.size > SHORTEST:
            return
        happening = stuck(self.curve, self.walk.points, self.walk.refusal)
        if happening.kind is BranchEvent.DEATH:
            self._at(happening, _Target(happening.point, None))
        else:
            self.end(happening.kind)

    def _at(self, happening: Happening, target: _Target) -> None:
        """Go to the place of an end, of a corner, or of another branch."""
        if happening.kind is BranchEvent.CROSSING and target.beyond is not None:
            self._arrive(target.point)
            self._pass(happening.point)
            self.walk.happened.append(happening)
            self._arrive(target.beyond)
            return
        point = happening.point
        if happening.kind is not BranchEvent.CORNER:
            self._pass(point)
            if happening.kind is BranchEvent.TOUCH:  # a fold or flip may have been passed in the same step
                self.walk.unstable[-1] = self._outside(point)
            self.walk.happened.append(happening)
            self.ended = True
            return
        self._round(happening)

    def _round(self, corner: Happening) -> None:
        """Go on beyond a corner."""
        try:
            point, orbit, passed = beyond_corner(self.curve, corner.point, corner.which, self.passed)
        except Strayed:
            self.end(BranchEvent.LOST)
            return
        turned = point.tangent[-1] * corner.point.tangent[-1] < 0.0
        kind = BranchEvent.NONSMOOTH_FOLD if turned else BranchEvent.CORNER
        self.here, self.cornered, self.passed = point, True, passed
        self.walk.happened.append(Happening(kind, corner.place, corner.point, corner.which))
        self.walk.points.append(point)
        self.walk.unstable.append(unstable(orbit))
        self.size = min(self.size, FIRST * math.sqrt(self.curve.impacts))
