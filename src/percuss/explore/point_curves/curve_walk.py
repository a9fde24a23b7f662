"""The walk along a curve of points of orbits over two parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from percuss.errors import Interrupted, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.load_steps import beyond_corner, landed, step_ahead, step_row
from percuss.explore.continuation.solution_curve import refused
from percuss.explore.continuation.walk import (
    FIRST,
    SHORTEST,
    CorrectorFailed,
    CurvePoint,
    LocatedEvent,
    Look,
    Segment,
    Target,
    Walk,
    flights_of,
)
from percuss.explore.point_curves.conditions import Corner, Multiplier, Pair, Touch
from percuss.explore.point_curves.curve_events import (
    clearance_at,
    events_between,
    goes_back,
    halved,
    halves_differ,
    passed_at,
)
from percuss.explore.point_curves.extended_curve import ExtendedCurve
from percuss.model.checks import Array

_COALESCED, _NEARLY = 1e-5, 1e-3  # of the cycle: a flight below which two impacts are one, and where the walk halts
_ARC = 0.05  # of a step, by which its end may be beside the arc with the tangents at both ends
_BEND, _NEAR_STEP = 0.01, 4.0  # a step below which a corner may be what bends a curve, if no more of it away
_BESIDE = 5e-6  # rad, beyond a step of the load, so that differences are taken on one side of it
_HALVED = 0.02  # rad, between the halves of a cycle that may become one
_DOUBLE = BranchEvent.RESONANCE_1, BranchEvent.RESONANCE_2


class PointWalk(Walk):
    """A walk along points of orbits over two parameters; its marks are whether the motions are orbits otherwise."""

    quick = 8

    def __init__(self, curve: ExtendedCurve, start: CurvePoint, bounds: Sequence[tuple[float, float]]) -> None:
        super().__init__(curve.renewed(start.x), start, bounds)

    def arrive(self, point: CurvePoint) -> None:
        self.curve = self.curve.renewed(point.x)
        self.clear, self.passed = clearance_at(self.curve, point), passed_at(self.curve, point)
        super().arrive(point)

    def mark(self) -> int:
        return int(self.clear.is_orbit)

    def look(self, target: Target) -> Look:
        """The points of codimension two in a step, or where both halves of the cycle become one orbit."""
        segment = Segment(self.curve, self.here, target.point)
        if goes_back(self.curve):
            before, after = (halves_differ(self.curve, point.x) for point in (self.here, target.point))
            if before @ after < 0.0:
                return Look(segment, [], None, self._halved(target.point.x))
        return Look(segment, events_between(segment, self.clear, self.passed), target.limit)

    def _halved(self, near: Array) -> LocatedEvent:
        """Where both halves of the cycle are one orbit."""
        return LocatedEvent(BranchEvent.HALVING, math.nan, halved(self.curve, near))

    def ends_at(self, one: LocatedEvent) -> bool:
        condition = self.curve.condition
        if isinstance(condition, Pair) and one.kind in _DOUBLE:
            return True
        return isinstance(condition, Multiplier | Pair) and one.kind is BranchEvent.WITH_CORNER

    def end_here(self) -> BranchEvent | None:
        return BranchEvent.COALESCENCE if self._shortest() < _COALESCED else None

    def _shortest(self) -> float:
        """The shortest time between two impacts, or an impact and the touch, as a share of the cycle."""
        orbit, condition = self.curve.motion(self.here.x), self.curve.condition
        times = orbit.flight_times
        if isinstance(condition, Touch):
            time = float(self.curve.extra(self.here.x)[0])
            times = np.append(times, [time, times[condition.flight] - time])
        return float(times.min() / orbit.period)

    def check(self, found: CurvePoint, place: Array, last: bool = False) -> None:
        super().check(found, place)
        chord, mean = found.x - self.here.x, self.here.tangent + found.tangent  # along each other on an arc
        aside = float(np.linalg.norm(chord - (chord @ mean) / (mean @ mean) * mean))
        if aside > max(_ARC * float(np.linalg.norm(chord)), SHORTEST):
            raise CorrectorFailed("beside the arc")
        if isinstance(self.curve.condition, Touch):
            flight = flights_of(self.curve, found.x)[self.curve.condition.flight]
            if not 0.0 < float(self.curve.extra(found.x)[0]) < flight:
                raise CorrectorFailed("the touch passes an impact")

    def shorten(self) -> None:
        """Try a shorter step, or one past a corner."""
        if 0.5 * self.size < _BEND and self._past_corner(0.5 * self.size):
            return
        super().shorten()

    def stuck(self) -> None:
        if self._shortest() < _NEARLY:
            self.end(BranchEvent.COALESCENCE)
            return
        if goes_back(self.curve) and float(np.abs(halves_differ(self.curve, self.here.x)).max()) < _HALVED:
            try:
                self.at_last(self._halved(self.here.x), Look(Segment(self.curve, self.here, self.here), []))
                return
            except CorrectorFailed:
                self.end(BranchEvent.LOST)
                return
        self.end(BranchEvent.LOST if self.refusal is None else refused(self.refusal))

    def _past_corner(self, size: float) -> bool:
        """Go past a step of the load that an impact is about to meet; whether there is one, and a way beyond."""
        own = self.curve.condition.which if isinstance(self.curve.condition, Corner) else -1
        near = step_ahead(self.curve, self.here, self.passed, own)
        if near is None or not 0.0 <= near[0] <= _NEAR_STEP * size:
            return False
        if isinstance(self.curve.condition, Multiplier | Pair):
            if size < SHORTEST:
                self.end(BranchEvent.WITH_CORNER)
            return self.ended
        place, which = near
        start = self.here.x + place * self.here.tangent
        try:
            on = landed(self.curve, self.here._replace(x=start), which, self.passed)
            if float(np.abs(on.x - start).max()) > place:
                raise CorrectorFailed("another corner")
            corner, _, passed = beyond_corner(self.curve, on, which, self.passed)
            row = step_row(self.curve, on.x, which, int(min(passed[which], self.passed[which])))
            ahead = corner.x + _BESIDE / abs(float(corner.tangent @ row)) * corner.tangent
            beyond = self.curve.corrected(ahead, corner.tangent, corner.tangent, corner)
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError):
            return False
        for point in (on, beyond):
            self.arrive(point)
        self.happened.append(LocatedEvent(BranchEvent.WITH_CORNER, math.nan, on))
        self.size = FIRST
        return True
