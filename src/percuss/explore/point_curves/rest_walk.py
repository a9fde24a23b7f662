"""The walk along a curve of ends of cycles with rest over two parameters, and what happens on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import Interrupted, PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.problem import CorrectorFailed, CurvePoint, Limit, Problem, refused, unit_tangent
from percuss.explore.continuation.walk import CurveSegment, Look, Target, Walk
from percuss.explore.family import Family
from percuss.explore.point_curves.rest_conditions import Endless, Held, Late, RestCondition, Unlike
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.system import set_at_wall
from percuss.steady import RestCycle
from percuss.steady.resting.rest_cycles import cycle_through

_LAST = {"restitution": (0.0, 1.0), "contact.restitution": (0.0, 1.0)}  # the values that there are
_BESIDE = 1e-6  # of a unit, how far beside the curve it is looked what cycle there is
_FAR = 1e2 * _BESIDE
_FIRM = 1e-4  # steps after which what failed before says nothing any more
_INSIDE = 1e-10  # of a unit, to which it is known where the cycle ceases
_TURN = math.cos(math.radians(25.0))
_NEAREST, _FURTHEST = 1e-9, 1e-2  # between which a length is searched for


@dataclass(frozen=True)
class RestEndCurve(Problem):
    """All systems over two parameters for which the number of what ends cycles with rest vanishes."""

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]
    condition: RestCondition
    impacts: int = 0
    places: tuple[int, int] = (0, 1)

    @property
    def periods(self) -> int:  # type: ignore[override]
        """Load periods for which the bar is followed."""
        return self.condition.way.periods

    def at_wall(self, x: Array) -> System:
        """The system as what is let go at the wall: see `percuss.model.system`."""
        return set_at_wall(self.system_at(x), self.condition.way.modes)

    def residual(self, x: Array) -> Array:
        """What vanishes on the curve."""
        try:
            return np.array([self.condition.number(self.at_wall(x))])
        except Interrupted:
            raise
        except PercussError as error:
            raise CorrectorFailed(str(error)) from error

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        """As of other curves, by the secant method along the line that is the plane here: the number has kinks."""
        way = np.array([-normal[1], normal[0]])
        matrix = self.matrix(start) if near.matrix is None else near.matrix
        at, slope, steps = _root_on_line(lambda at: float(self.residual(start + at * way)[0]), float(matrix[0] @ way))
        place = start + at * way
        try:
            beside = self.residual(place + self.difference * normal) / self.difference
        except CorrectorFailed:  # beyond the end of a parameter
            beside = -self.residual(place - self.difference * normal) / self.difference
        matrix = slope * way[None, :] + beside[:, None] * normal
        return CurvePoint(place, unit_tangent(matrix, along), steps, matrix)

    def renewed(self, x: Array) -> RestEndCurve:
        """The same with the way of the bar taken anew at a place of the curve."""
        return replace(self, condition=self.condition.renewed(self.at_wall(x)))

    def limit(self, here: Array, x: Array, bounds: Sequence[tuple[float, float]]) -> Limit | None:
        """The first end of a range on the way to another place, or of the values that there are."""
        known = [_LAST.get(name, (-math.inf, math.inf)) for name in self.names]
        inner = [(max(a, low), min(b, high)) for (a, b), (low, high) in zip(bounds, known, strict=True)]
        found = super().limit(here, x, inner)
        if found is None or math.isfinite(bounds[found.unknown][int(found.value > here[found.unknown])]):
            return found
        return found._replace(kind=BranchEvent.NO_SYSTEM)


_EXACT, _ROUGH, _LEAP = 1e-13, 1e-11, 2.0  # steps to a root: the last one, one that rounding has a say in, their growth
_MOST_STEPS, _REACH = 20, 0.1


def _root_on_line(number: Callable[[float], float], slope: float) -> tuple[float, float, int]:
    """Where a number vanishes near 0, by the secant method; its derivative there, and how many steps."""
    last, value = 0.0, number(0.0)
    if value == 0.0:
        return 0.0, slope, 0
    along = -value / slope if slope else math.inf
    for count in range(1, _MOST_STEPS + 1):
        if not abs(along) <= _REACH:
            raise CorrectorFailed("beside the curve")
        look()
        now = number(along)
        if now == 0.0:
            return along, slope, count
        step = along - last
        rise = (now - value) / step
        ahead = -now / rise if rise * slope > 0.0 else math.inf
        if abs(ahead) > _LEAP * abs(step):
            if abs(step) < _ROUGH:
                return along, slope, count
            ahead = math.copysign(_LEAP * abs(step), -now * slope)
        elif abs(step) > _ROUGH:
            slope = rise
        if abs(ahead) <= _EXACT:
            return along + ahead, slope, count
        last, value, along = along, now, along + ahead
    raise CorrectorFailed("no root")


class RestEndWalk(Walk):
    """A walk along ends of cycles with rest; its marks are whether the cycle is there beside the curve.

    `cycle` is that which ends on the curve, where it was first met, `side` the sign of the number where it is; `seen`
    has of each point kept both parameters, when the bar is let go, and when the cycle ends.
    """

    quick = 5

    def __init__(
        self,
        curve: RestEndCurve,
        start: CurvePoint,
        bounds: Sequence[tuple[float, float]],
        cycle: RestCycle,
        side: float,
    ) -> None:
        super().__init__(curve, start, bounds)
        self.cycle, self.side, self.beyond = cycle, side, 0.0
        self.stray: CorrectorFailed | None = None
        self._ahead: tuple[CurvePoint, RestEndCurve, bool] | None = None
        self.seen: list[tuple[tuple[float, float], float, float]] = []

    def keep(self, point: CurvePoint, mark: int) -> None:
        super().keep(point, mark)
        condition = self.curve.condition
        values, release, phase = self.curve.values(point.x), condition.way.release, math.nan
        try:
            system = self.curve.at_wall(point.x)
            phase = condition.phase(system)
            values = self.curve.values(self._place(point, system))
        except (PercussError, CorrectorFailed):
            pass
        self.seen.append((values, release, phase))

    def mark(self) -> int:
        seen = self._ahead
        return int(self._is_cycle(self.here) if seen is None or seen[0] is not self.here else seen[2])

    def arrive(self, point: CurvePoint) -> None:
        seen = self._ahead
        self.curve = self.curve.renewed(point.x) if seen is None or seen[0] is not point else seen[1]
        super().arrive(point)
        if self.size > _FIRM:
            self.stray = None

    def failed(self, failed: CorrectorFailed) -> None:
        if type(self.stray) is CorrectorFailed or self.stray is None or type(failed) is not CorrectorFailed:
            self.stray = failed  # one that says more than that there was none is kept
        if isinstance(self.stray.__cause__, PercussError):
            self.refusal = self.stray.__cause__

    def check(self, found: CurvePoint, place: Array, last: bool = False) -> None:
        chord = found.x - self.here.x  # at R = 0 a curve of onsets may end with any slope
        if float(chord @ self.here.tangent) < _TURN * float(np.linalg.norm(chord)):
            raise CorrectorFailed("a bend")
        if not last:
            super().check(found, place)

    def look(self, target: Target) -> Look:
        """Where in a step the cycle ceases, or comes again."""
        segment = CurveSegment(self.curve, self.here, target.point)
        try:
            curve = self.curve.renewed(target.point.x)
            now = self._is_cycle(target.point, curve)
        except Interrupted:
            raise
        except PercussError as error:
            raise CorrectorFailed(str(error)) from error
        self._ahead = target.point, curve, now
        if now == bool(self.marks[-1]):
            return Look(segment, [], target.limit)
        low, high = 0.0, segment.length
        while high - low > _INSIDE:
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self._is_cycle(segment.at(middle)) is now else (middle, high)
        return Look(segment, [segment.event(BranchEvent.OTHER_CYCLE, high)], target.limit)

    def _is_cycle(self, point: CurvePoint, curve: RestEndCurve | None = None) -> bool:
        """Whether the bar let go comes back as the cycle does, hardly beside the curve."""
        curve = self.curve if curve is None else curve
        if curve.condition.kind is BranchEvent.RELEASE_LOST:
            return True
        try:
            place = self._place(point, curve.at_wall(point.x)) + self.side * _BESIDE * _across(point)
            system = curve.system_at(place)
        except Interrupted:
            raise
        except PercussError:  # beyond the end of a parameter
            return not self.marks or bool(self.marks[-1])
        try:
            release = curve.condition.way.released(set_at_wall(system, self.cycle.modes))
            found, _, _ = cycle_through(system, release, modes=self.cycle.modes, most=self.cycle.periods)
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError):
            return False
        return found is not None and found.periods == self.cycle.periods

    def _place(self, point: CurvePoint, system: System) -> Array:
        """Where the cycle ends: where the bar is hardly held any more, by a law that turns the strain over."""
        condition, x = self.curve.condition, point.x
        if not isinstance(condition, Held) or system.contact.velocity_factor >= 0.0:
            return x
        edge = [i for i, bounds in enumerate(self.bounds) if self.curve.values(x)[i] in bounds]
        way = _across(point)
        if edge:  # along the edge of the plane
            way = math.copysign(1.0, way[1 - edge[0]]) * np.eye(2)[1 - edge[0]]
        self.beyond = _vanishing_beyond(lambda at: condition.spare(self.curve.at_wall(x - at * way)), 0.7 * self.beyond)
        return np.asarray(x - self.beyond * way)

    def stuck(self) -> None:
        if isinstance(self.stray, Unlike):
            kind = BranchEvent.WITH_TOUCH if self.stray.kind is BranchEvent.TOUCH else BranchEvent.WITH_DEATH
            self._forget()
        elif isinstance(self.stray, Endless):
            kind = BranchEvent.UNPRESSED if isinstance(self.curve.condition, Late) else BranchEvent.ENDLESS
        elif self.stray is not None and isinstance(self.stray.__cause__, PercussError):
            kind = refused(self.stray.__cause__)
        else:
            kind = BranchEvent.LOST
        self.end(kind)

    def _forget(self) -> None:
        """Forget what is seen so near to the end of the curve that what is beside it is beyond."""

        def is_far(point: CurvePoint) -> bool:
            return float(np.linalg.norm(point.x - self.here.x)) > _FAR

        self.happened = [one for one in self.happened if is_far(one.point)]
        was = next((mark for point, mark in zip(self.points[::-1], self.marks[::-1], strict=True) if is_far(point)), 1)
        self.marks = [mark if is_far(point) else was for point, mark in zip(self.points, self.marks, strict=True)]


def _across(point: CurvePoint) -> Array:
    """The direction at right angles to the curve in which the number grows."""
    assert point.matrix is not None
    return np.asarray(point.matrix[0] / np.linalg.norm(point.matrix[0]))


def _vanishing_beyond(number: Callable[[float], float], about: float) -> float:
    """The first length at which a number that is positive at 0 vanishes; CorrectorFailed where that is too far."""
    low, high = 0.0, max(about, _NEAREST)
    while (above := number(high)) > 0.0:
        low, high = high, 2.0 * high
        if high > _FURTHEST:
            raise CorrectorFailed("held further on")
    if low == 0.0 and number(0.0) <= 0.0:
        return 0.0
    ends = (np.array([1.0 + low]), np.array([1.0 + high]), np.array([number(low)]), np.array([above]))  # to 1e-16
    return float(bracketed_roots(lambda at: np.array([number(float(one) - 1.0) for one in at]), *ends)[0]) - 1.0


# ---- Where such a curve begins

_SAME, _HELD = 1e-6, 1e-2  # of a unit, by which the start may be off, and where the bar is held before


def rest_end_start(
    curve: RestEndCurve, here: Array, bounds: Sequence[tuple[float, float]]
) -> tuple[RestEndCurve, CurvePoint]:
    """The curve through a place, and the point on it, with the number growing to the left; or CorrectorFailed."""
    reach = _HELD if isinstance(curve.condition, Held) else _SAME
    ends = [
        {end / unit for end in (*pair, *_LAST.get(name, ()))}
        for pair, unit, name in zip(bounds, curve.units, curve.names, strict=True)
    ]
    point = CurvePoint(here, np.zeros(2), 0)
    for _ in range(2):
        matrix = curve.matrix(point.x)
        slopes = matrix[0] / np.linalg.norm(matrix[0])
        free = np.abs(slopes) * np.where([value in on for value, on in zip(point.x, ends, strict=True)], 1e-9, 1.0)
        held = np.eye(2)[int(np.argmin(free))]  # not off the edge of the plane
        tangent = np.array([slopes[1], -slopes[0]])
        found = curve.corrected(point.x, held, tangent, CurvePoint(point.x, tangent, 0, matrix))
        if float(np.abs(found.x - point.x).max()) > reach:
            raise CorrectorFailed("beside the curve")
        point, curve = found, curve.renewed(found.x)
    return curve, point
