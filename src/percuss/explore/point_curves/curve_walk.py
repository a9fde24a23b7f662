"""The walk along a curve of points over two parameters, one way, until something ends it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from percuss.errors import Interrupted, LoadError, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import Passed, step_of
from percuss.explore.continuation.solution_curve import FIRST, LONGEST, SHORTEST, CorrectorFailed, check_next
from percuss.explore.point_curves.conditions import Corner, Multiplier, Pair, Touch
from percuss.explore.point_curves.curve_happenings import (
    CurveHappening,
    clearance_at,
    goes_back,
    halved,
    halves_differ,
    happenings,
    passed_at,
)
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.model.checks import Array
from percuss.steady.periodic.periodic_orbit import differences, load_turn

# ---- Where a walk along a curve comes back to where it began

_FIRST = 8  # points of a walk before which it is not looked for
_HOME = 1e-6  # rad, between the start of a walk and where it comes back to it


def home_of(
    curve: ExtendedCurve, points: Sequence[ExtendedPoint], here: ExtendedPoint, point: ExtendedPoint
) -> ExtendedPoint | None:
    """The start of a walk, if its step to a point comes back to it or past it, with the times of now."""
    first, p = points[0], curve.impacts
    reach = 2.0 * float(np.linalg.norm(point.x - here.x))
    if len(points) < _FIRST or np.abs(first.x[p + 1 : p + 3] - point.x[p + 1 : p + 3]).max() > reach:
        return None
    orbit = curve.motion(first.x)
    off = point.x - first.x
    turn = load_turn(orbit.system.load)
    off[:p] = differences(point.x[:p], first.x[None, :p], orbit.period, turn)[0, 0]
    ahead, along = float(off @ first.tangent), float(point.tangent @ first.tangent)
    if np.abs(off).max() > reach or not 0.0 <= ahead <= reach or along <= 0.0:
        return None
    try:  # another part of the curve may be as near: only the start itself is home
        start = point.x - ahead / along * point.tangent
        back = curve.corrected(start, first.tangent, first.tangent, point.matrix)
    except CorrectorFailed:
        return None
    place = point.x - off
    return first._replace(x=place) if float(np.abs(back.x - place).max()) < _HOME else None


# ---- Past a step of the load: there the equations have a corner, and a curve of grazings or corners has one, too

_DIFFERENCE = 1e-6
_BESIDE = 5e-6  # rad, beyond a step, so that differences are taken on one side of it


class StepAhead(NamedTuple):
    """A step of the load that an impact meets on the way along a tangent: how far off, and the normal of the plane."""

    distance: float
    normal: Array


def step_ahead(curve: ExtendedCurve, here: ExtendedPoint, passed: Passed) -> StepAhead | None:
    """The nearest one ahead; None for a load without steps, or where none comes nearer.

    Parameters
    ----------
    curve, here
        The curve, and the point on it.
    passed
        How many steps of the load each impact has passed.
    """
    if not curve.system(curve.values(here.x)).load.breaks:
        return None
    own = curve.condition.which if isinstance(curve.condition, Corner) else -1
    found = []
    for i in range(curve.impacts):
        for number in (int(passed[i]) - 1, int(passed[i])) if i != own else ():
            normal = _normal(curve, here.x, i, number)
            off = float(here.x[i]) - step_of(curve.system(curve.values(here.x)), number)
            rate = float(normal @ here.tangent)
            if off * rate < 0.0:
                found.append(StepAhead(-off / rate, normal / np.linalg.norm(normal)))
    return min(found, key=lambda one: one.distance, default=None)


def _normal(curve: ExtendedCurve, x: Array, i: int, number: int) -> Array:
    """The derivative of the time from a step to an impact by the unknowns."""
    normal, p = np.zeros(x.size), curve.impacts
    normal[i] = 1.0
    here = step_of(curve.system(curve.values(x)), number)
    for j in (p + 1, p + 2):
        for h in (_DIFFERENCE, -_DIFFERENCE):
            aside = np.array(x)
            aside[j] += h
            if curve.refusal(curve.values(aside)) is None:
                normal[j] = -(step_of(curve.system(curve.values(aside)), number) - here) / h
                break
    return normal


def beyond_step(curve: ExtendedCurve, here: ExtendedPoint, step: StepAhead) -> tuple[ExtendedPoint, ExtendedPoint]:
    """The point on a step of the load, and one hardly beyond it with the tangent there; or CorrectorFailed."""
    side = float(np.sign(step.normal @ here.tangent))
    start = here.x + step.distance * here.tangent
    on = curve.corrected(start, step.normal, here.tangent, here.matrix)
    if float(np.abs(on.x - start).max()) > step.distance:
        raise CorrectorFailed("another corner")
    try:
        matrix = curve.matrix(on.x + side * _BESIDE * step.normal)
    except PercussError as error:
        raise CorrectorFailed(str(error)) from None
    tangent = np.linalg.svd(matrix)[2][-1]
    tangent = tangent * np.sign(tangent @ step.normal) * side
    place = on.x + (_BESIDE / abs(float(tangent @ step.normal))) * tangent
    return on, curve.corrected(place, tangent, tangent, matrix)


# ---- The walk along a curve of points over two parameters, one way, until something ends it

_QUICK = 8  # steps of Newton's method after which the next step along the curve is longer
_COALESCED, _NEARLY = 1e-5, 1e-3  # of the cycle: a flight below which two impacts are one, and where the walk halts
_ARC = 0.05  # of a step, by which its end may be beside the arc with the tangents at both ends
_BEND, _NEAR_STEP = 0.01, 4.0  # a step below which a corner may be what bends a curve, if no more of it away
_HALVED = 0.02  # rad, between the halves of a cycle that may become one
_DOUBLE = BranchEvent.RESONANCE_1, BranchEvent.RESONANCE_2


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
        return CurveWalk([start], [True], [CurveHappening(BranchEvent.STOPPED, 1.0, start)])
    try:
        while not walker.ended and len(walker.walk.points) < most:
            walker.step()
    except Interrupted:
        pass
    if not walker.ended:
        walker.end(BranchEvent.STOPPED)
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

    def end(self, kind: BranchEvent) -> None:
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
        except CorrectorFailed:
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
            self.end(BranchEvent.CLOSED)
        elif self._shortest(point) < _COALESCED:
            self.end(BranchEvent.COALESCENCE)
        elif point.steps <= _QUICK:
            self.size = min(1.5 * self.size, LONGEST * math.sqrt(self.curve.impacts))

    def _stops(self, kind: BranchEvent) -> bool:
        """Whether the curve has no other side of a point."""
        condition = self.curve.condition
        if isinstance(condition, Pair) and kind in _DOUBLE:
            return True
        return isinstance(condition, Multiplier | Pair) and kind is BranchEvent.WITH_CORNER

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

    def _ahead(self) -> tuple[ExtendedPoint, BranchEvent | None]:
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
            normal, limit = np.zeros(place.size), BranchEvent.LIMIT
            normal[p + 1 + i] = 1.0
        refusal = self.curve.refusal(self.curve.values(place))
        if refusal is not None:
            self.walk.refusal = refusal
            raise CorrectorFailed(str(refusal))
        found = self.curve.corrected(place, normal, here.tangent, here.matrix)
        self._check(found, place)
        return found, limit

    def _check(self, found: ExtendedPoint, place: Array) -> None:
        """CorrectorFailed where a point is not the next one of the curve."""
        before, after = (self.here.x, self.here.tangent), (found.x, found.tangent)
        flights = check_next(before, after, place, self.size, self.curve.impacts, self.curve.periods)
        chord, mean = found.x - self.here.x, self.here.tangent + found.tangent  # along each other on an arc
        aside = float(np.linalg.norm(chord - (chord @ mean) / (mean @ mean) * mean))
        if aside > max(_ARC * float(np.linalg.norm(chord)), SHORTEST):
            raise CorrectorFailed("beside the arc")
        condition = self.curve.condition
        if isinstance(condition, Touch) and not 0.0 < float(self.curve.extra(found.x)[0]) < flights[condition.flight]:
            raise CorrectorFailed("the touch passes an impact")

    def _shorter(self) -> None:
        """Try a shorter step, or one past a corner; where none is short enough, say why."""
        self.size *= 0.5
        if self.size < _BEND and self._past_corner():
            return
        if self.size > SHORTEST:
            return
        if self._shortest(self.here) < _NEARLY:
            self.end(BranchEvent.COALESCENCE)
        elif goes_back(self.curve) and float(np.abs(halves_differ(self.curve, self.here.x)).max()) < _HALVED:
            try:
                self._halve(self.here.x)
            except CorrectorFailed:
                self.end(BranchEvent.LOST)
        elif self.walk.refusal is not None:
            self.end(BranchEvent.NO_PUSH if isinstance(self.walk.refusal, LoadError) else BranchEvent.NO_SYSTEM)
        else:
            self.end(BranchEvent.LOST)

    def _past_corner(self) -> bool:
        """Go past a step of the load that an impact is about to meet; whether there is one."""
        ahead = step_ahead(self.curve, self.here, self.passed)
        if ahead is None or ahead.distance > _NEAR_STEP * self.size:
            return False
        if isinstance(self.curve.condition, Multiplier | Pair):
            if self.size < SHORTEST:
                self.end(BranchEvent.WITH_CORNER)
            return self.ended
        try:
            on, beyond = beyond_step(self.curve, self.here, ahead)
        except CorrectorFailed:
            return False
        for point in (on, beyond):
            self._arrive(point)
        self.walk.happened.append(CurveHappening(BranchEvent.WITH_CORNER, 1.0, on))
        self.size = FIRST
        return True

    def _halve(self, near: Array) -> None:
        """End the walk where both halves of the cycle are one orbit."""
        self.here = halved(self.curve, near)
        self.walk.points.append(self.here)
        self.walk.is_orbit.append(self.walk.is_orbit[-1])
        self.end(BranchEvent.HALVING)
