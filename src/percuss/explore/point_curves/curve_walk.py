"""The walk along a curve of points over two parameters, one way, until something ends it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import Interrupted, LoadError, PercussError
from percuss.explore.continuation.corners import Passed, step_of, steps_passed
from percuss.explore.continuation.next_point import FIRST, LONGEST, SHORTEST, Strayed, check_next
from percuss.explore.point_curves.clearance import Clearance, clearance
from percuss.explore.point_curves.codimension_two import tests_of
from percuss.explore.point_curves.conditions import Corner, Touch
from percuss.explore.point_curves.corner_passing import beyond_step, step_ahead
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.explore.point_curves.halving import goes_back, halved, halves_differ
from percuss.explore.point_curves.happening import CurveHappening, without_what_follows
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.multiplier_conditions import Multiplier, Pair
from percuss.model.checks import Array
from percuss.steady.periodic.sameness import differences, load_turn

__all__ = ["CurveWalk", "walked_curve"]

_QUICK = 8  # steps of Newton's method after which the next step along the curve is longer
_COALESCED, _NEARLY = 1e-5, 1e-3  # of the cycle: a flight below which two impacts are one, and where the walk halts
_BEND, _NEAR_STEP = 0.01, 4.0  # a step below which a corner may be what bends a curve, if no more of it away
_HALVED = 0.02  # rad, between the halves of a cycle that may become one
_DOUBLE = CurveEvent.RESONANCE_1, CurveEvent.RESONANCE_2
_HOME = 1e-6  # rad, between the start of a walk and where it comes back to it


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
        self.clear = self._clearance(start)
        self.passed = self._passed(start)
        self.walk = CurveWalk([start], [self.clear.is_orbit])
        self.ended = False

    def _clearance(self, point: ExtendedPoint) -> Clearance:
        return clearance(self.curve.motion(point.x), self.curve.condition, self.curve.extra(point.x))

    def _passed(self, point: ExtendedPoint) -> Passed:
        found = steps_passed(self.curve.motion(point.x))
        if isinstance(self.curve.condition, Corner):
            found[self.curve.condition.which] = self.curve.condition.number
        return found

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
            between = self._between(point)
        except Strayed:
            self._shorter()
            return
        home = self._home(point) if limit is None else None
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
        self.here, self.clear = point, self._clearance(point)
        self.passed = self._passed(point)
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

    def _home(self, point: ExtendedPoint) -> ExtendedPoint | None:
        """The start of the walk, if a step to a point comes back to it or past it, with the times of now."""
        first, p = self.walk.points[0], self.curve.impacts
        reach = 2.0 * float(np.linalg.norm(point.x - self.here.x))
        if len(self.walk.points) < 8 or np.abs(first.x[p + 1 : p + 3] - point.x[p + 1 : p + 3]).max() > reach:
            return None
        orbit = self.curve.motion(first.x)
        off = point.x - first.x
        turn = load_turn(orbit.system.load)
        off[:p] = differences(point.x[:p], first.x[None, :p], orbit.period, turn)[0, 0]
        ahead, along = float(off @ first.tangent), float(point.tangent @ first.tangent)
        if np.abs(off).max() > reach or not 0.0 <= ahead <= reach or along <= 0.0:
            return None
        try:  # another part of the curve may be as near: only the start itself is home
            start = point.x - ahead / along * point.tangent
            back = self.curve.corrected(start, first.tangent, first.tangent, point.matrix)
        except Strayed:
            return None
        place = point.x - off
        return first._replace(x=place) if float(np.abs(back.x - place).max()) < _HOME else None

    # -- what happens on the way --

    def _between(self, point: ExtendedPoint) -> list[CurveHappening]:
        """What happens on the way to a point, in order."""
        curve, here = self.curve, self.here
        found = []
        for kind, number in tests_of(curve, here):
            if number(here) * number(point) < 0.0:
                found.append(self._located(kind, point, number))
        now = self._clearance(point)
        for i in range(len(now)):
            if self.clear[i] * now[i] < 0.0:

                def margin(at: ExtendedPoint, i: int = i) -> float:
                    return self._clearance(at)[i]

                found.append(self._located(Clearance.lost(i), point, margin))
        found += self._corners(point)
        found = without_what_follows(found, self.curve.condition)
        return sorted(found, key=lambda one: one.share)

    def _located(
        self, kind: CurveEvent, point: ExtendedPoint, number: Callable[[ExtendedPoint], float]
    ) -> CurveHappening:
        share, found = self.curve.root(self.here, point, number)
        return CurveHappening(kind, share, found)

    def _corners(self, point: ExtendedPoint) -> list[CurveHappening]:
        """Where an impact meets a step of the load."""
        now, found = self._passed(point), []
        for i in np.flatnonzero(now != self.passed).tolist():
            number = int(self.passed[i]) - (now[i] < self.passed[i])

            def off(at: ExtendedPoint, i: int = i, number: int = number) -> float:
                orbit = self.curve.motion(at.x)
                return float(orbit.times[i]) - step_of(orbit.system, number)

            found.append(self._located(CurveEvent.WITH_CORNER, point, off))
        return found
