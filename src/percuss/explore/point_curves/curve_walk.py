"""The walk along a curve of points over two parameters, one way, until something ends it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import Interrupted, LoadError, PercussError
from percuss.explore.continuation.next_point import FIRST, LONGEST, SHORTEST, Strayed, check_next
from percuss.explore.point_curves.closing import home_of
from percuss.explore.point_curves.conditions import Touch
from percuss.explore.point_curves.corner_passing import beyond_step, step_ahead
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.explore.point_curves.halving import goes_back, halved, halves_differ
from percuss.explore.point_curves.happening import CurveHappening
from percuss.explore.point_curves.happenings_between import clearance_at, happenings, passed_at
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.multiplier_conditions import Multiplier, Pair
from percuss.model.checks import Array

__all__ = ["CurveWalk", "walked_curve"]

_QUICK = 8  # steps of Newton's method after which the next step along the curve is longer
_COALESCED, _NEARLY = 1e-5, 1e-3  # of the cycle: a flight below which two impacts are one, and where the walk halts
_ARC = 0.05  # of a step, by which its end may be beside the arc with the tangents at both ends
_BEND, _NEAR_STEP = 0.01, 4.0  # a step below which a corner may be what bends a curve, if no more of it away
_HALVED = 0.02  # rad, between the halves of a cycle that may become one
_DOUBLE = CurveEvent.RESONANCE_1, CurveEvent.RESONANCE_2


@dataclass
class CurveWalk:
    """What one way along a curve gave: points from the start on, which are orbits, and what happened, the end last."""

    points: list[ExtendedPoint]
    is_orbit: list[bool]
    happened: list[CurveHappening] = field(default_factory=list)
    refusal: PercussError | None = None


def walked_curve(
    curve: ExtendedCurve, start: ExtendedPoint, bounds: tuple[tuple[float, float], tuple[float, float]], most: int
) -> CurveWalk:
    """Walk from a point the way its tangent points.

    Parameters
    ----------
    curve, start
        The curve, and where on it.
    bounds
        The range of each parameter.
    most
        Points at most.
    """
    try:
        walker = _Walker(curve, start, bounds)
    except Interrupted:
        return CurveWalk([start], [True], [CurveHappening(CurveEvent.STOPPED, 1.0, start)])
    try:
        while not walker.ended and len(walker.walk.points) < most:
            walker.step()
    except Interrupted:
        pass
    if not walker.ended:
        walker.end(CurveEvent.STOPPED)
    return walker.walk


class _Walker:
    """Where the walk is, and how long its next step will be."""

    def __init__(
        self, curve: ExtendedCurve, start: ExtendedPoint, bounds: tuple[tuple[float, float], tuple[float, float]]
    ) -> None:
        self.curve, self.here, self.bounds = curve.renewed(start.x), start, bounds
        self.size = FIRST * math.sqrt(curve.impacts)
        self.clear = clearance_at(self.curve, start)
        self.passed = passed_at(self.curve, start)
        self.walk = CurveWalk([start], [self.clear.is_orbit])
        self.ended = False

    def end(self, kind: CurveEvent) -> None:
        """End the walk here."""
        self.walk.happened.append(CurveHappening(kind, 1.0, self.here))
        self.ended = True

    def step(self) -> None:
        """Go on to the next point, shorter if need be, and see what happens on the way."""
        try:
            point, limit = self._ahead()
            if (
                goes_back(self.curve)
                and halves_differ(self.curve, self.here.x) @ halves_differ(self.curve, point.x) < 0.0
            ):
                self._halve(point.x)
                return
            between = happenings(self.curve, self.here, point, self.clear, self.passed)
        except Strayed:
            self._shorter()
            return
        home = home_of(self.curve, self.walk.points, self.here, point) if limit is None else None
        if home is not None:
            between = [one for one in between if float((one.point.x - home.x) @ home.tangent) < 0.0]
        for one in between:
            self.walk.points.append(one.point)
            self.walk.is_orbit.append(self.walk.is_orbit[-1])
            self.walk.happened.append(one)
            if self._stops(one.kind):
                self.ended = True
                return
        self._arrive(point if home is None else home)
        if limit is not None:
            self.end(limit)
        elif home is not None:
            self.end(CurveEvent.CLOSED)
        elif self._shortest(point) < _COALESCED:
            self.end(CurveEvent.COALESCENCE)
        elif point.steps <= _QUICK:
            self.size = min(1.5 * self.size, LONGEST * math.sqrt(self.curve.impacts))

    def _stops(self, kind: CurveEvent) -> bool:
        """Whether the curve has no other side of a point."""
        condition = self.curve.condition
        if isinstance(condition, Pair) and kind in _DOUBLE:
            return True
        return isinstance(condition, Multiplier | Pair) and kind is CurveEvent.WITH_CORNER

    def _arrive(self, point: ExtendedPoint) -> None:
        self.curve = self.curve.renewed(point.x)
        self.here, self.clear = point, clearance_at(self.curve, point)
        self.passed = passed_at(self.curve, point)
        self.walk.points.append(point)
        self.walk.is_orbit.append(self.clear.is_orbit)

    def _shortest(self, point: ExtendedPoint) -> float:
        """The shortest time between two impacts, or an impact and the touch, as a share of the cycle."""
        orbit, condition = self.curve.motion(point.x), self.curve.condition
        times = orbit.flight_times
        if isinstance(condition, Touch):
            time = float(self.curve.extra(point.x)[0])
            times = np.append(times, [time, times[condition.flight] - time])
        return float(times.min()) / orbit.period

    # -- the next point --

    def _ahead(self) -> tuple[ExtendedPoint, CurveEvent | None]:
        """The next point, and the limit of a parameter that it lies on."""
        p, here = self.curve.impacts, self.here
        place, limit, normal = here.x + self.size * here.tangent, None, here.tangent
        for i, (low, high) in enumerate(self.bounds):
            values = self.curve.values(place)
            if low <= values[i] <= high:
                continue
            end, speed = low if values[i] < low else high, float(here.tangent[p + 1 + i])
            off = end / self.curve.units[i] - float(here.x[p + 1 + i])
            place = here.x + (off / speed) * here.tangent
            place[p + 1 + i] = end / self.curve.units[i]
            normal, limit = np.zeros(place.size), CurveEvent.LIMIT
            normal[p + 1 + i] = 1.0
        refusal = self.curve.refusal(self.curve.values(place))
        if refusal is not None:
            self.walk.refusal = refusal
            raise Strayed(str(refusal))
        found = self.curve.corrected(place, normal, here.tangent, here.matrix)
        self._check(found, place)
        return found, limit

    def _check(self, found: ExtendedPoint, place: Array) -> None:
        """Strayed where a point is not the next one of the curve."""
        before, after = (self.here.x, self.here.tangent), (found.x, found.tangent)
        flights = check_next(before, after, place, self.size, self.curve.impacts, self.curve.periods)
        chord, mean = found.x - self.here.x, self.here.tangent + found.tangent  # along each other on an arc
        aside = float(np.linalg.norm(chord - (chord @ mean) / (mean @ mean) * mean))
        if aside > max(_ARC * float(np.linalg.norm(chord)), SHORTEST):
            raise Strayed("beside the arc")
        condition = self.curve.condition
        if isinstance(condition, Touch) and not 0.0 < float(self.curve.extra(found.x)[0]) < flights[condition.flight]:
            raise Strayed("the touch passes an impact")

    def _shorter(self) -> None:
        """Try a shorter step, or one past a corner; where none is short enough, say why."""
        self.size *= 0.5
        if self.size < _BEND and self._past_corner():
            return
        if self.size > SHORTEST:
            return
        if self._shortest(self.here) < _NEARLY:
            self.end(CurveEvent.COALESCENCE)
        elif goes_back(self.curve) and float(np.abs(halves_differ(self.curve, self.here.x)).max()) < _HALVED:
            try:
                self._halve(self.here.x)
            except Strayed:
                self.end(CurveEvent.LOST)
        elif self.walk.refusal is not None:
            self.end(CurveEvent.NO_PUSH if isinstance(self.walk.refusal, LoadError) else CurveEvent.NO_SYSTEM)
        else:
            self.end(CurveEvent.LOST)

    def _past_corner(self) -> bool:
        """Go past a step of the load that an impact is about to meet; whether there is one."""
        ahead = step_ahead(self.curve, self.here, self.passed)
        if ahead is None or ahead.distance > _NEAR_STEP * self.size:
            return False
        if isinstance(self.curve.condition, Multiplier | Pair):
            if self.size < SHORTEST:
                self.end(CurveEvent.WITH_CORNER)
            return self.ended
        try:
            on, beyond = beyond_step(self.curve, self.here, ahead)
        except Strayed:
            return False
        for point in (on, beyond):
            self._arrive(point)
        self.walk.happened.append(CurveHappening(CurveEvent.WITH_CORNER, 1.0, on))
        self.size = FIRST
        return True

    def _halve(self, near: Array) -> None:
        """End the walk where both halves of the cycle are one orbit."""
        self.here = halved(self.curve, near)
        self.walk.points.append(self.here)
        self.walk.is_orbit.append(self.walk.is_orbit[-1])
        self.end(CurveEvent.HALVING)
