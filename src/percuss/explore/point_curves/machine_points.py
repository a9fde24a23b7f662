"""Points of branches of machines that switch their own valve, and of structures that rest, over two parameters.

The cycles over two parameters with one equation more: a number that vanishes, of those that tell stability, or of the
tests of an order of events.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent, BranchPoint, PointCurve
from percuss.explore.continuation.machine_cycles import MachineCurve, kind_of
from percuss.explore.continuation.missed_events import nearest
from percuss.explore.continuation.rest_following import RestCurve, end_beyond
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Look,
    Problem,
    Target,
    Varied,
    Walk,
    both_ways,
    joined,
)
from percuss.explore.family import drives_itself
from percuss.halting import halting
from percuss.model.checks import Array
from percuss.steady import RestCycle
from percuss.steady.multipliers import TURNING
from percuss.steady.periodic.periodic_orbit import slope
from percuss.steady.self_excited.event_sequence import sequence_of
from percuss.steady.self_excited.valve_cycle import ValveCycle

FOLLOWED_OF_MACHINES = (
    BranchEvent.FOLD, BranchEvent.FLIP, BranchEvent.NEIMARK_SACKER, BranchEvent.TOUCH, BranchEvent.DEATH,
    BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD, BranchEvent.ORDER_LOST, BranchEvent.PORT_LOST,
    BranchEvent.PORT_TOUCH, BranchEvent.PRESSURE_GONE,
)  # fmt: skip
"""The kinds of points of machines of which there are curves."""
FOLLOWED_OF_SEVERAL = FOLLOWED_OF_MACHINES[:3]
"""Those of cycles with rest of structures of several modes."""

_EXCHANGES = BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD, BranchEvent.ORDER_LOST

_STEP = 1e-6  # of each unknown, for the derivatives of the number
_WITH = {
    BranchEvent.FOLD: BranchEvent.WITH_FOLD, BranchEvent.FLIP: BranchEvent.WITH_FLIP,
    BranchEvent.TOUCH: BranchEvent.WITH_TOUCH, BranchEvent.DEATH: BranchEvent.WITH_DEATH,
    BranchEvent.CORNER: BranchEvent.WITH_CORNER,
}  # fmt: skip
_SAME, _ROUNDING = 1e-6, 1e-11


@dataclass(frozen=True)
class MachinePoints(Problem):
    """All cycles of a curve over two parameters at which a test, or what a pair is off the unit circle, vanishes."""

    base: MachineCurve | RestCurve
    kind: BranchEvent
    test: str = ""
    pair: complex = 0.0
    periods = 1

    @property
    def family(self) -> Any:  # type: ignore[override]
        return self.base.family

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]
        return self.base.names

    @property
    def units(self) -> tuple[float, ...]:  # type: ignore[override]
        return self.base.units

    @property
    def impacts(self) -> int:  # type: ignore[override]
        return self.base.impacts

    @property
    def places(self) -> tuple[int, ...]:
        return self.base.places

    def system(self, *values: float) -> Any:
        return self.base.system(*values)

    def refusal(self, *values: float) -> PercussError | None:
        return self.base.refusal(*values)

    def motion(self, x: Array) -> ValveCycle | RestCycle:
        """The cycle at a point."""
        return self.base.motion(x)

    def flights(self, x: Array) -> Array:
        return self.base.flights(x)

    def apart(self, x: Array, first: Array) -> Array:
        return self.base.apart(x, first)

    def number(self, x: Array) -> float:
        """What vanishes."""
        if self.kind is BranchEvent.FOLD:
            return self.base.fold(CurvePoint(x, x, 0))
        if self.kind is BranchEvent.FLIP:
            return self.base.flip(CurvePoint(x, x, 0))
        if self.kind is BranchEvent.NEIMARK_SACKER:
            return abs(nearest(self.motion(x).multipliers().values, self.pair)) - 1.0
        assert isinstance(self.base, MachineCurve)
        found = self.base.test(self.test, x)
        if found is None:
            raise CorrectorFailed("another order of events")
        return found

    def renewed(self, x: Array) -> MachinePoints:
        """The same with the multiplier that is on the circle taken anew."""
        if self.kind is not BranchEvent.NEIMARK_SACKER:
            return self
        return replace(self, pair=nearest(self.motion(x).multipliers().values, self.pair))

    def residual(self, x: Array) -> Array:
        return np.append(self.base.residual(x), self.number(x))

    def matrix(self, x: Array) -> Array:
        def moved(way: Array) -> Callable[[float], Array]:
            return lambda by: np.array([self.number(x + by * way)])

        row = np.stack([slope(moved(way), _STEP, CorrectorFailed) for way in np.eye(x.size)], axis=1)
        return np.vstack([self.base.matrix(x), row])


class MachinePointWalk(Walk):
    """A walk along points of machines; its marks are whether the cycles are possible otherwise."""

    quick = 6

    def __init__(self, curve: MachinePoints, start: CurvePoint, bounds: Sequence[tuple[float, float]]) -> None:
        super().__init__(curve.renewed(start.x), start, bounds)

    def arrive(self, point: CurvePoint) -> None:
        self.curve = self.curve.renewed(point.x)
        super().arrive(point)

    def mark(self) -> int:
        return int(min(self._tests(self.here).values(), default=1.0) >= 0.0)

    def _tests(self, point: CurvePoint) -> dict[str, float]:
        """The tests but for that of the curve itself, and for what rounding makes of 0."""
        found = self.curve.base.tests(point.x)
        return {name: 0.0 if abs(v) < _ROUNDING else v for name, v in found.items() if name != self.curve.test}

    def _test(self, name: str, point: CurvePoint) -> float:
        return self._tests(point).get(name, 0.0)

    def look(self, target: Target) -> Look:
        segment, base = CurveSegment(self.curve, self.here, target.point), self.curve.base
        if isinstance(base, RestCurve) and not base.are_alike(segment.start.x, segment.stop.x):
            raise CorrectorFailed("other impacts")
        before, after = self._tests(segment.start), self._tests(segment.stop)
        found = []
        for name in before.keys() & after.keys():
            if before[name] * after[name] < 0.0:
                place = segment.root(partial(self._test, name))
                kind, which = kind_of(name)
                found.append(segment.event(_WITH.get(kind, kind), place, which))
        for kind, number in ((BranchEvent.FOLD, base.fold), (BranchEvent.FLIP, base.flip)):
            if kind is self.curve.kind:
                continue

            def at(point: CurvePoint, number: Callable[[CurvePoint], float] = number) -> float:
                return number(CurvePoint(point.x, point.x, 0))

            if at(segment.start) * at(segment.stop) < 0.0:
                found.append(segment.event(_WITH[kind], segment.root(at)))
        if self.curve.kind is BranchEvent.FOLD:
            m, start = base.places[0], segment.start.tangent

            def turns(point: CurvePoint) -> float:
                return float(point.tangent[m:] @ start[m:])

            if turns(segment.stop) < 0.0:
                found.append(segment.event(BranchEvent.CUSP, segment.root(turns)))
        return Look(segment, sorted(found, key=lambda one: one.place), target.limit)

    def stuck(self) -> None:
        rests = isinstance(self.curve.base, RestCurve)
        kind = end_beyond(self.curve.base, self.here).kind if rests else BranchEvent.LOST
        self.end(_WITH.get(kind, kind))


def _base(point: BranchPoint, over: Varied) -> tuple[Any, Array]:
    """All cycles over both parameters like that of a point, and its unknowns."""
    cycle, family, rests = point.motion, over.family, isinstance(point.motion, RestCycle)
    if point.kind not in (known := FOLLOWED_OF_SEVERAL if rests else FOLLOWED_OF_MACHINES):
        told = "several modes move on while the wall holds the contact: what ends their branches has no curve yet"
        kinds = f"a point of one of the kinds {', '.join(kind.value for kind in known)}"
        raise ParameterError("point", str(point), kinds, told if rests else "")
    if isinstance(cycle, RestCycle):
        return RestCurve.of(cycle, over)
    assert isinstance(cycle, ValveCycle) and drives_itself(family)
    tick = cycle.period / (2.0 * math.pi)
    base = MachineCurve(family, over.names, over.units, sequence_of(cycle), cycle.modes, tick)
    return base, base.unknowns(cycle, *over.here)


def cycle_curve(point: BranchPoint, over: Varied, most: int, halt: Callable[[], bool] | None) -> PointCurve:
    """A point of a branch of cycles followed through two parameters; see `percuss.explore.follow_point`."""
    base, x = _base(point, over)
    with halting(halt):
        curve = MachinePoints(base, point.kind, *_condition(base, x, point))
        try:
            start = curve.settled(x)
        except CorrectorFailed:
            start = None
        if start is None or float(np.abs(start.x - x).max()) > _SAME:
            raise ParameterError("point", str(point), f"a point of the hammers with {over}")
        walks = both_ways(lambda begin: MachinePointWalk(curve, begin, over.bounds), start, most)
    points, marks, happened = joined(walks)
    motions = [base.motion(one.x) for one in points]
    angle = {BranchEvent.FOLD: 0.0, BranchEvent.FLIP: math.pi}.get(point.kind, math.nan)
    angles = np.full(len(points), angle)
    if point.kind is BranchEvent.NEIMARK_SACKER:
        angles = np.array([abs(np.angle(_turning(motion))) for motion in motions])
    return PointCurve(
        event=point.kind, label=base.label, modes=base.modes, parameters=over.names,
        values=np.array([base.values(one.x) for one in points]),
        is_orbit=np.array(marks, dtype=bool), angles=angles, units=over.shown_units, **base.along(motions),
        points=tuple(_told(base, one, most, way) for one, way in happened),
    )  # fmt: skip


def _turning(cycle: ValveCycle | RestCycle) -> complex:
    """The multiplier of a pair that is nearest to the unit circle."""
    values = cycle.multipliers().values
    turning = values[values.imag > TURNING * np.abs(values)]
    return complex(turning[np.argmin(np.abs(np.abs(turning) - 1.0))]) if turning.size else complex(math.nan)


def _condition(base: Any, x: Array, point: BranchPoint) -> tuple[str, complex]:
    """The test that vanishes at a point, or the multiplier that is on the unit circle."""
    if point.kind in (BranchEvent.FOLD, BranchEvent.FLIP):
        return "", 0.0
    if point.kind is BranchEvent.NEIMARK_SACKER:
        return "", _turning(base.motion(x))
    kind = BranchEvent.CORNER if point.kind in _EXCHANGES else point.kind
    mine = {name: abs(value) for name, value in base.tests(x).items() if kind_of(name)[0] is kind}
    if not mine:
        raise ParameterError("point", str(point), "a point that a test of its order of events tells")
    return min(mine, key=lambda name: mine[name]), 0.0


def _told(base: Any, one: LocatedEvent, most: int, walk: Walk) -> BranchPoint:
    beyond = one.kind.words
    if one.kind is BranchEvent.STOPPED and len(walk.points) >= most:
        beyond = f"after {most} points, as many as were asked for"
    return BranchPoint(one.kind, base.values(one.point.x), base.motion(one.point.x), beyond)
