"""Points of a branch followed through two parameters: folds, flips, pairs on the unit circle, grazings, corners."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent, BranchPoint, PointCurve
from percuss.explore.continuation.branch_events import in_words
from percuss.explore.continuation.walk import (
    CorrectorFailed,
    CurvePoint,
    LocatedEvent,
    Problem,
    Varied,
    Walk,
    both_ways,
    joined,
    varied,
)
from percuss.explore.family import Family
from percuss.explore.point_curves.machine_points import cycle_curve
from percuss.explore.point_curves.point_walk import (
    Condition,
    Corner,
    Death,
    ExtendedCurve,
    Multiplier,
    Pair,
    PointWalk,
    Touch,
)
from percuss.explore.point_curves.rest_walk import TURN, RestEndCurve, RestEndWalk, rest_condition, rest_end_start
from percuss.halting import Elapsed, asked, halting
from percuss.model import System
from percuss.model.checks import Array, callback, count, instance, several
from percuss.steady import PeriodicOrbit, RestCycle
from percuss.steady.self_excited.valve_cycle import ValveCycle

# ---- What a point of a branch of orbits is, as a condition, and the unknowns that this brings

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
    time = float(after[np.argmax(orbit.motion(after))])
    starts = np.array(orbit.times) - orbit.times[0]
    flight = int(np.searchsorted(starts, time, side="right")) - 1
    return Touch(flight), [time - float(starts[flight])]


# ---- Points of a branch followed through two parameters: folds, flips, pairs on the unit circle, grazings, corners

MOST_POINTS = 100_000
_SAME = 1e-6
_RANGES, _VALUES = "two ranges, or None for one without ends", "the values of both parameters"
_TWO = "two names of parameters, such as ('restitution', 'load_factor')"


def follow_point(
    point: BranchPoint,
    along: Sequence[str],
    between: Sequence[tuple[float, float] | None] | None = None,
    *,
    family: System | Family | None = None,
    values: Sequence[float] | None = None,
    most: int = 2000,
    progress: Callable[[Elapsed], object] | None = None,
) -> PointCurve:
    """Follow a located point of a branch through two parameters, both ways, to the edge of their plane.

    A fold stays a fold, a flip a flip, a grazing a grazing, while both parameters change: the curve that divides the
    plane into those with and without the orbit, or with it stable and unstable. Points of codimension two on the way
    are located and named. Where the motion ceases to be an orbit for another reason, since it touches the wall
    elsewhere or an impact strikes backwards, the curve goes on and is marked; where a ringing bar touches a second time
    in the same flight it goes on with that touch, which is what ends motions beyond.

    Parameters
    ----------
    point
        A fold, flip, Neimark–Sacker point, touch, death of an impact, or a corner, of `follow`; an onset, touch, death
        or the last release of cycles with rest; of those of structures of several modes, and of machines that switch
        their own valve, a fold, flip or Neimark–Sacker point, or an end that is told by the order of events of these.
    along
        The names of both parameters, each with its range or without: ``"restitution=0:0.9"``.
    between
        The range of each, or None for one that `along` tells; None to go on until the curve ends, or has `most`
        points.
    family
        The systems; None for those that differ from that of the point in both parameters alone.
    values
        Of both parameters, at the point; None for what its system says, where they are dimensionless ones.
    most
        Points of each way at most.
    progress
        Called again and again; once it returns true, what has been followed so far is the answer.

    References
    ----------
    Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 3rd ed., Springer 2004, § 10.3; W. Govaerts, Numerical
    Methods for Bifurcations of Dynamical Equilibria, SIAM 2000.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import BranchEvent, follow
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    >>> flip = follow(orbit_near(system, [0.39, 2.32], modes=0), "mean", (0.6, 1.2)).at(BranchEvent.FLIP)[0]
    >>> curve = follow_point(flip, ("restitution=0.4:0.6", "mean=0.3:1.2"))
    >>> for one in curve.ends:
    ...     print(one.kind.value, [round(value, 9) for value in one.values])
    limit [0.4, 0.574481856]
    limit [0.6, 0.768652978]
    """
    motion = instance("point", point, BranchPoint).motion
    if not isinstance(motion, PeriodicOrbit | RestCycle | ValveCycle):
        raise ParameterError("point", str(point), "a point of follow")
    names = tuple(several("along", along, _TWO))
    if len(names) != 2 or names[0] == names[1]:
        raise ParameterError("along", along, _TWO)
    given = (None, None) if values is None else several("values", values, _VALUES)
    ranges = (None, None) if between is None else several("between", between, _RANGES)
    for told, two, meant in (("values", given, _VALUES), ("between", ranges, _RANGES)):
        if len(two) != 2:
            raise ParameterError(told, two, meant)
    hammer = motion.machine if isinstance(motion, ValveCycle) else motion.system
    over = varied(hammer, family, names, ranges, given)
    if over.names[0] == over.names[1]:
        raise ParameterError("along", along, _TWO)
    ways = count("most", most, least=2, most=MOST_POINTS)
    callback("progress", progress)
    halt = asked(progress)
    if isinstance(motion, ValveCycle) or (isinstance(motion, RestCycle) and motion.is_several):
        return cycle_curve(point, over, ways, halt)
    if isinstance(motion, RestCycle):
        return _rest_ends(point, over, ways, halt)
    with halting(halt):
        curve, start = _start(point, over)
        walks = both_ways(lambda point: PointWalk(curve, point, over.bounds), start, ways)
    points, marks, happened = joined(walks)
    rows = np.array([point.x for point in points])
    return PointCurve(
        event=curve.condition.kind, label=curve.label, modes=curve.modes,
        parameters=curve.names, values=np.array([curve.values(x) for x in rows]),
        times=np.array([curve.motion(x).times for x in rows]),
        is_orbit=np.array(marks, dtype=bool), angles=_angles(curve, rows), units=over.shown_units,
        points=tuple(_point(curve, one, walk, ways) for one, walk in happened),
    )  # fmt: skip


def _start(point: BranchPoint, over: Varied) -> tuple[ExtendedCurve, CurvePoint]:
    orbit, (condition, extra) = point.orbit, point_condition(point)
    curve = ExtendedCurve(over.family, over.names, over.units, orbit.impacts, orbit.periods, orbit.modes, condition)
    places = [value / unit for value, unit in zip(over.here, over.units, strict=True)]
    x = np.array([*orbit.times, orbit.rigid_rebounds[0], *places, *extra])
    try:
        found = curve.settled(x)
    except CorrectorFailed:
        found = None
    if found is None or float(np.abs(found.x - x).max()) > _SAME:
        raise ParameterError("point", str(point), f"a point of the systems with {over}")
    return curve, found


def _rest_ends(point: BranchPoint, over: Varied, most: int, halt: Callable[[], bool] | None) -> PointCurve:
    """The same of an end of a branch of cycles with rest: an onset, a touch, a death, the last release."""
    (condition, side), cycle = rest_condition(point), point.cycle
    try:
        curve, start = rest_end_start(
            RestEndCurve(over.family, over.names, over.units, condition), np.divide(over.here, over.units), over.bounds
        )
    except Interrupted:
        raise
    except (CorrectorFailed, PercussError) as error:
        raise ParameterError("point", str(point), f"a point of the systems with {over}", str(error)) from None
    with halting(halt):
        walks = both_ways(lambda begin: RestEndWalk(curve, begin, over.bounds, cycle, side), start, most)
    _, marks, happened = joined(walks)
    *backward, forward = walks
    seen = [one for way in backward for one in way.seen[:0:-1]] + forward.seen
    values, releases, phases = zip(*seen, strict=True)
    return PointCurve(
        event=point.kind, label=cycle.label, modes=cycle.modes, parameters=over.names, values=np.array(values),
        releases=np.array(releases), event_phases=np.mod(phases, TURN), is_orbit=np.array(marks, dtype=bool),
        units=over.shown_units, points=tuple(_point(curve, one, way, most) for one, way in happened),
    )  # fmt: skip


def _angles(curve: ExtendedCurve, rows: Array) -> Array:
    condition = curve.condition
    if isinstance(condition, Pair):
        return np.arccos(np.clip(rows[:, -1], -1.0, 1.0))
    angle = (0.0 if condition.xi > 0.0 else math.pi) if isinstance(condition, Multiplier) else math.nan
    return np.full(len(rows), angle)


def _point(curve: Problem, one: LocatedEvent, walk: Walk, most: int) -> BranchPoint:
    beyond = one.kind.words
    if one.kind in (BranchEvent.NO_PUSH, BranchEvent.NO_SYSTEM) and walk.refusal is not None:
        beyond = in_words(walk.refusal)
    if one.kind is BranchEvent.STOPPED and len(walk.points) >= most:
        beyond = f"after {most} points, as many as were asked for"
    motion = curve.motion(one.point.x).plain if isinstance(curve, ExtendedCurve) else None
    return BranchPoint(one.kind, curve.values(one.point.x), motion, beyond)
