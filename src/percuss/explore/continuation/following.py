"""Orbits followed through a parameter, both ways, from one that is known; how far it may move before one is lost."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint, recorded
from percuss.explore.continuation.branch_events import (
    Partner,
    Side,
    double_zero,
    doubled,
    end_of,
    grazing_partner,
    in_words,
    is_joined,
    multipliers,
    other_end,
    outside,
    side_of_doubled,
    side_told,
    to_corner,
    unstable,
)
from percuss.explore.continuation.machine_walk import follow_cycle
from percuss.explore.continuation.missed_events import (
    BESIDE,
    crossings,
    dead_end,
    hidden_crossing,
    narrow_end,
    resonant_points,
    sheet_jump,
    turning_back,
)
from percuss.explore.continuation.orbit_curve import SolutionCurve, beyond_corner, corner_ahead, steps_passed
from percuss.explore.continuation.rest_following import follow_rest
from percuss.explore.continuation.walk import (
    FIRST,
    CorrectorFailed,
    CurvePoint,
    CurveSegment,
    LocatedEvent,
    Look,
    Target,
    Varied,
    Walk,
    both_ways,
    joined,
    varied,
)
from percuss.explore.family import Family, SystemFamily, drives_itself, family_of
from percuss.halting import Elapsed, asked, halting
from percuss.model import System
from percuss.model.checks import callback, count, instance
from percuss.short_repr import ShortRepr
from percuss.steady import Orbit, PeriodicOrbit, RestCycle
from percuss.steady.multipliers import TURNING, Repeating
from percuss.steady.periodic.periodic_orbit import differences, load_turn
from percuss.steady.self_excited.valve_cycle import ValveCycle

# ---- Where the following of an orbit begins: the value of its parameter, the range around it, the point of the curve

_SAME_ORBIT = 1e-6  # rad, by which the orbit may be inexact
_LEAST = 1e-6  # of the unit of a parameter, or its inverse: a scale beyond is none
_BESIDE, _ASIDE = 1e-6, 1e-3  # rad, on both sides of a fold or flip, and how far from it one begins


def beginning(curve: SolutionCurve, orbit: PeriodicOrbit, value: float, bounds: tuple[float, float]) -> CurvePoint:
    """The point of the orbit, the tangent towards greater values of the parameter; of a fold or flip, one beside it."""
    refusal = curve.refusal(value)
    if refusal is not None:
        raise refusal
    if not orbit.admissible:
        raise ParameterError("orbit", str(orbit), "an admissible orbit")
    x = curve.unknowns(orbit, value)
    tangent = np.linalg.svd(curve.matrix(x))[2][-1]
    tangent = tangent if tangent[-1] >= 0.0 else -tangent
    found = None
    for normal in (curve.level, tangent):  # the second at a fold
        try:
            found = curve.corrected(x, normal, tangent)
            break
        except CorrectorFailed:
            continue
    if found is None or float(np.abs(found.x - x).max()) > _SAME_ORBIT:
        raise ParameterError("orbit", str(orbit), f"an orbit of the system with {curve.name} = {value:.9g}")
    beside = _off(curve, found)
    return beside if bounds[0] <= curve.value(beside.x) <= bounds[1] else found


def unit_of_turn(curve: SolutionCurve, start: CurvePoint) -> float:
    """By how much the parameter changes while the impacts move by about 1 rad."""
    moved = float(np.abs(start.tangent[: curve.impacts]).max())
    size = float(abs(start.tangent[-1])) / moved if moved else 1.0
    return curve.unit * 2.0 ** round(math.log2(min(max(size, _LEAST), 1.0 / _LEAST)))


def _off(curve: SolutionCurve, start: CurvePoint) -> CurvePoint:
    """A point beside a start that is a fold or flip, which no step would pass; else the start."""
    try:
        sides = [curve.corrected(start.x + one * start.tangent, start.tangent) for one in (-_BESIDE, _BESIDE)]
        if not np.any(np.prod([curve.motion(one.x).singular() for one in sides], axis=0) < 0.0):
            return start
        beside = curve.corrected(start.x + _ASIDE * start.tangent, start.tangent)
        return beside if curve.motion(beside.x).admissible else start
    except CorrectorFailed:
        return start


# ---- What lies beyond a point of a branch, in a sentence

_LEVEL = 1e-3  # of a tangent, its part along the parameter where a branch turns back
_INTO, _SHRINK, _STEPS = 0.01, 0.25, 8  # rad, how far into a branch it is looked where it leads; how often nearer
_CHANGED, _DEAD = 0.1, 1e-9  # share of the speed of an impact by which such a step may change it; of the greatest, none


def sentence(curve: SolutionCurve, one: LocatedEvent, impact: int | None, refusal: str) -> tuple[str, Side | None]:
    """What lies beyond, and to which side a branch begins there, of impact number `impact`; `refusal`: why it ends."""
    if one.kind is BranchEvent.FLIP:
        return _flip(curve, one.point)
    if one.kind in (BranchEvent.TOUCH, BranchEvent.DEATH):
        return _grazing(curve, one, impact)
    return _plainly(curve, one, impact, refusal), None


def _plainly(curve: SolutionCurve, one: LocatedEvent, impact: int | None, refusal: str) -> str:
    """Where no branch begins whose side is known."""
    kind, name = one.kind, curve.name
    if kind is BranchEvent.FOLD:
        return f"the branch turns back; beyond {name} = {curve.value(one.point.x):.9g} neither of its two orbits exists"
    if kind is BranchEvent.NEIMARK_SACKER:
        return _pair(curve, one.point)
    if kind is BranchEvent.CROSSING:
        over = "another branch crosses this one"
        if abs(one.point.tangent[-1]) < _LEVEL:
            return f"{over}, which turns back and goes on as its own image, backwards in time or some periods later"
        return f"{over}, and stability may pass from one to the other"
    if kind in (BranchEvent.CORNER, BranchEvent.NONSMOOTH_FOLD):
        way = "goes on" if kind is BranchEvent.CORNER else "turns back"
        return f"impact {impact} falls on the other side of a step of the load, and the branch {way}"
    if kind is BranchEvent.NO_SYSTEM:
        return f"there is no such system: {refusal}" if refusal else kind.words
    if kind is BranchEvent.STICKING:
        if curve.motion(one.point.x).system.body.is_free:
            return "the bar comes to rest on the wall and waits until the load pulls: a cycle with rest"
        return "the structure comes to rest on the wall, which is beyond the law of its impacts"
    return _PLAIN.get(kind, kind.words)


_PLAIN = {
    BranchEvent.HALVING: "the branch would go back over itself, half its period later",
    BranchEvent.COALESCENCE: "two impacts are one, so the label changes",
    BranchEvent.NO_PUSH: "the mean load does not push, so no motion keeps striking",
    BranchEvent.LIMIT: "the branch goes on",
    BranchEvent.CLOSED: "the branch is a closed loop, all of which is here",
    BranchEvent.RESONANCE: "an elastic mode would grow without bound from cycle to cycle",
    BranchEvent.STOPPED: "the branch goes on",
    BranchEvent.LOST: "Newton's method finds no further point, however short the step",
}


def _into(partner: Partner) -> Side | None:
    """The same of the branch itself, by steps into it that shrink until two say the same; None if none do."""
    curve, start = partner
    speeds = curve.motion(start.x).speeds
    alive = np.abs(speeds) > _DEAD * speeds.max()
    size, last = _INTO, None
    for _ in range(_STEPS):
        try:
            found = curve.corrected(start.x + size * start.tangent, start.tangent)
        except CorrectorFailed:
            found = None
        size, here = _SHRINK * size, None
        if found is not None and found.x[-1] != start.x[-1]:
            orbit = curve.motion(found.x)
            if np.all(np.abs(orbit.speeds - speeds)[alive] < _CHANGED * np.abs(speeds[alive])):
                here = Side(bool(found.x[-1] > start.x[-1]), outside(multipliers(orbit)) == 0)
        if here is not None and here == last:
            return here
        last = here
    return None


def _flip(curve: SolutionCurve, point: CurvePoint) -> tuple[str, Side | None]:
    partner = doubled(curve, point)
    if partner is None:
        return "an orbit of twice the period begins, longer than orbits are followed here", None
    side = side_of_doubled(curve, point)
    if side is None or side.stable is None:
        tried = _into(partner)
        side = tried if side is None else side._replace(stable=None if tried is None else tried.stable)
    return f"{partner[0].label} begins{side_told(curve.name, side)}", side


def _pair(curve: SolutionCurve, point: CurvePoint) -> str:
    values = multipliers(curve.motion(point.x))
    if values is None:
        return "motions on a torus may begin"
    turning = values[values.imag > TURNING * np.abs(values)]
    pair = turning[np.argmin(np.abs(np.abs(turning) - 1.0))]
    return f"motions on a torus may begin, which turn by {math.degrees(float(np.angle(pair))):.4g}° in a cycle"


def _grazing(curve: SolutionCurve, one: LocatedEvent, impact: int | None) -> tuple[str, Side | None]:
    touch = one.kind is BranchEvent.TOUCH
    is_free = curve.motion(one.point.x).system.body.is_free
    what = "bar" if is_free else "structure"
    here = f"the {what} would pass through the wall" if touch else f"impact {impact} would strike backwards"
    label = f"z={curve.impacts + 1 if touch else curve.impacts - 1}/{curve.periods}"
    if curve.impacts == 1 and not touch:
        return here, None
    if is_joined(curve):
        partner = grazing_partner(curve, one.point, one.kind, one.which)
        side = None if partner is None else _into(partner)
        return here if partner is None else f"{here}; {label} begins here{side_told(curve.name, side)}", side
    found = other_end(curve, one.point, one.kind, one.which)
    if found is None:
        return f"{here}; no end of {label} was found near", None
    event = "an impact without speed" if touch else "a touch"
    why = "the bar is elastic" if is_free else "the structure has several modes"
    return f"{here}; {label} ends at {found[0].value(found[1]):.9g} ({event}), not here: {why}", None


# ---- The walk along a curve of orbits over one parameter

_REFINED = 1e-5  # step below which none is taken again to see what its ends do not show
_INSIDE = 1e-6  # share of a step beside a corner, nearer than which rounding decides on which side of it one is


class OrbitWalk(Walk):
    """A walk along orbits; its marks are how many multipliers are outside, `fresh` where it begins at a flip."""

    def __init__(
        self, curve: SolutionCurve, start: CurvePoint, bounds: tuple[float, float], *, fresh: bool = False
    ) -> None:
        super().__init__(curve, start, (bounds,))
        self.fresh, self.cornered = fresh, False
        self.passed = steps_passed(curve.motion(start.x))
        if fresh:
            self.size = BESIDE * self.scale

    def mark(self) -> int:
        return unstable(self.curve.motion(self.here.x))

    def arrive(self, point: CurvePoint) -> None:
        super().arrive(point)
        self.passed, self.cornered = steps_passed(self.curve.motion(point.x)), False

    def ways(self) -> tuple[Callable[[], Target], ...]:
        return self.ahead, self._corner

    def _corner(self) -> Target:
        """The point at which an impact meets the step of the load that it nears: the curve may turn back there."""
        start, point, which = corner_ahead(self.curve, self.here, self.passed, 2.0 * self.size)
        self.check(point, start)
        return Target(point, None, LocatedEvent(BranchEvent.CORNER, math.nan, point, which))

    def look(self, target: Target) -> Look:
        """The folds, flips, pairs and other branches in a step, and what ends it, which may be before its target."""
        segment, beyond = CurveSegment(self.curve, self.here, target.point), None
        back = None if self.fresh else turning_back(segment)
        if back is not None:
            target, beyond = Target(back.before, None, back.event), back.beyond
            segment = CurveSegment(self.curve, self.here, target.point)
        coarse = self.size > _REFINED
        if not self.fresh and coarse and (sheet_jump(segment) or double_zero(segment)):
            raise CorrectorFailed("more may happen in the step than its ends show")
        inside = [] if self.fresh else resonant_points(segment, not coarse)
        narrow = narrow_end(segment, inside)
        if narrow is not None:
            target, segment = Target(narrow), CurveSegment(self.curve, self.here, narrow)
        there = None if target.event is None else target.event._replace(place=segment.length)
        last = end_of(segment, self.passed) or there
        if coarse and last is None and hidden_crossing(segment, inside):
            raise CorrectorFailed("more may happen in the step than its ends show")
        part = to_corner(segment, last)
        length = segment.length if last is None else last.place
        corner = last is not None and last.kind is BranchEvent.CORNER
        smooth = _INSIDE * length if self.cornered else 0.0, length * (1.0 - _INSIDE) if corner else length
        between = crossings(part, *smooth, self.fresh, inside)
        return Look(segment, between, target.limit, last, beyond if last is there else None)

    def went(self, look: Look) -> None:
        if self.fresh:
            self.fresh, self.size = False, FIRST * self.scale
        super().went(look)

    def at_last(self, one: LocatedEvent, look: Look) -> None:
        if one.kind is not BranchEvent.CORNER:
            super().at_last(one, look)
            if one.kind is BranchEvent.TOUCH:  # a fold or flip may have been passed in the same step
                self.marks[-1] = unstable(self.curve.motion(one.point.x))
            return
        try:
            point, aside, passed = beyond_corner(self.curve, one.point, one.which, self.passed)
        except CorrectorFailed:
            self.end(BranchEvent.LOST)
            return
        turned = point.tangent[-1] * one.point.tangent[-1] < 0.0
        self.here, self.cornered, self.passed = point, True, passed
        self.happened.append(one._replace(kind=BranchEvent.NONSMOOTH_FOLD) if turned else one)
        self.keep(point, unstable(self.curve.motion(aside)))
        self.size = min(self.size, FIRST * self.scale)

    def stuck(self) -> None:
        found = dead_end(self.curve, self.points, self.refusal)
        if found.kind is BranchEvent.DEATH:
            super().at_last(found, Look(CurveSegment(self.curve, self.here, found.point), []))
        else:
            self.end(found.kind)


# ---- Orbits followed through a parameter, both ways, from one that is known

MOST_POINTS = 100_000
MOST_DEPTH = 16
_SAME_POINT = 1e-7
_GIVEN_BACK = {BranchEvent.HALVING, BranchEvent.TOUCH, BranchEvent.DEATH}


def follow(
    orbit: Orbit | PeriodicOrbit | RestCycle | ValveCycle,
    along: str,
    between: tuple[float, float] | None = None,
    *,
    family: System | Family | None = None,
    value: float | None = None,
    switch: int = 0,
    most: int = 4000,
    points: int = 65,
    record: Mapping[str, Callable[[Any], float]] | None = None,
    progress: Callable[[Elapsed], object] | None = None,
) -> Branch:
    """Follow any periodic motion through a parameter, both ways, round folds, until something ends it.

    The branch is walked by its arclength in the times of its impacts, and everything that happens on it is located:
    folds, flips, pairs of multipliers on the unit circle, corners where an impact meets a step of the load, and what
    ends it: a touch between two impacts, the death of one, the end of the range. Nothing ends unexplained.

    What happens twice between two points of the walk, and leaves no trace in them, is not seen; a touch is looked for
    between them, too.

    A cycle with rest, all of whose multipliers are 0, goes on for as long as the same impacts follow its releases.
    Where it ends is located, too: the end of its chatter meets the next release (onset), the bar touches the wall in a
    flight or an impact dies, the load no longer lets go.

    Parameters
    ----------
    orbit
        Where to begin: an admissible orbit, of `percuss.steady.orbits` or `orbit_near`, or of `steady_states` with a
        number of modes; a cycle of `percuss.steady.rest_cycles`; or that of a machine that switches its own valve, of
        `percuss.steady.self_excited_motion` or `orbits`.
    along
        Name of the parameter; of `percuss.explore.PARAMETERS`, or of the family. With its range it is text as of the
        command: ``"mean=0.3:1.2"``.
    between
        The range of the parameter, which must hold its value for the orbit; None for that of `along`, or to go on until
        the branch ends.
    family
        The systems; None for those that differ from that of the orbit in the parameter alone.
    value
        Of the parameter, for the orbit; None for what its system says, where it is a dimensionless one.
    switch
        How often to go on at the flips of a branch to the orbit of twice the period, and for a rigid bar at its
        grazings to the orbit with an impact more or less; 0 to 16. Of no effect for a cycle whose rests forget all.
    most
        Points of each way at most.
    points
        Cycles with rest over the whole range, at least, or over a stretch as long as the value; 2 to 10000.
    record
        Functions of the motion, by name, whose values are kept along the branch, and those switched to.
    progress
        Called again and again; once it returns true, what has been followed so far is the answer.

    Raises
    ------
    LoadError, ResonanceError
        When the system of the orbit can have no steady impacts.
    ParameterError
        For an orbit that is not possible or none of this family, an unknown parameter, a range without the orbit.

    References
    ----------
    H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in: P. H. Rabinowitz (ed.),
    Applications of Bifurcation Theory, Academic Press 1977, 359–384.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    >>> branch = follow(orbit_near(system, [0.39, 2.32], modes=0), "mean=0.3:1.2")
    >>> for point in branch.points:
    ...     print(point.kind.value, round(point.value, 9))
    grazing_impact_dies 0.399313189
    flip 0.659281675
    fold 0.673754187
    grazing_touch 0.527909682
    """
    start = _with_modes(orbit) if isinstance(orbit, Orbit) else instance("orbit", orbit, Repeating)
    if not isinstance(start, PeriodicOrbit | RestCycle | ValveCycle):
        remedy = "timed_states(system, law) has all motions of such blows at any value of a parameter"
        raise ParameterError("orbit", str(orbit), "a motion whose blows take no time", remedy)
    over = varied(start.system, family, [along], [between], [value])
    most, depth = count("most", most, least=2, most=MOST_POINTS), count("switch", switch, least=0, most=MOST_DEPTH)
    few, kept = count("points", points, least=2, most=10_000), recorded(record)
    callback("progress", progress)
    halt = asked(progress)
    if isinstance(start, ValveCycle):
        found = follow_cycle(start, over, switch=depth, most=most, halt=halt)
    elif isinstance(start, RestCycle):
        found = follow_rest(start, over, switch=depth, points=few, most=most, halt=halt)
    else:
        found = _follow_orbit(start, over, depth, most, halt)
    return found.recording(kept)


def _with_modes(orbit: Orbit) -> PeriodicOrbit:
    """A motion of `steady_states` as one that is followed."""
    if orbit.requested_modes is None:
        raise ParameterError(
            "orbit",
            str(orbit),
            "a motion of the bar with a number of modes",
            "as steady_states(system, modes=32) gives",
        )
    return PeriodicOrbit(orbit.system, orbit.periods, orbit.times, orbit.modes)


def _follow_orbit(
    orbit: PeriodicOrbit, over: Varied, depth: int, points: int, halt: Callable[[], bool] | None
) -> Branch:
    (name,), (here,), (bounds,) = over.names, over.here, over.bounds
    curve = SolutionCurve(over.family, name, orbit.impacts, orbit.periods, orbit.modes, *over.units)
    tracer = _Tracer(bounds, points, halt, [])
    with halting(halt):
        start = beginning(curve, orbit, here, bounds)
        if math.isinf(bounds[0]) and here == 0.0:  # its own size tells nothing of its scale
            curve = replace(curve, unit=unit_of_turn(curve, start))
            start = beginning(curve, orbit, here, bounds)
        ways = both_ways(lambda point: OrbitWalk(curve, point, bounds), start, points)
    return tracer.branch(curve, ways, depth)


@dataclass
class _Tracer:
    """Makes branches of walks, and follows the branches that begin at their points."""

    bounds: tuple[float, float]
    most: int
    halt: Callable[[], bool] | None
    met: list[tuple[int, int, float, float]]

    def branch(self, curve: SolutionCurve, ways: Sequence[Walk], depth: int) -> Branch:
        points, marks, happened = joined(ways)
        motions = [curve.motion(point.x) for point in points]
        found = [branch_point(curve, one, in_words(way.refusal)) for one, way in happened]
        for (one, _), point in zip(happened, found, strict=True):
            if one.kind in _GIVEN_BACK:
                self._is_new(curve.impacts, curve.periods, point)
        return Branch(
            parameters=(curve.name,), label=curve.label, modes=curve.modes,
            values=np.array([curve.value(point.x) for point in points]),
            times=np.array([motion.times for motion in motions]),
            speeds=np.array([motion.speeds for motion in motions]),
            unstable=np.array(marks, dtype=np.int64), points=tuple(found), motions=tuple(map(replace, motions)),
            switched=self._switched(curve, [one for one, _ in happened], depth) if depth else (),
        )  # fmt: skip

    def _switched(self, curve: SolutionCurve, happened: Sequence[LocatedEvent], depth: int) -> tuple[Branch, ...]:
        """The branches that begin at points of one, and have not been followed yet."""
        found = []
        for one in happened:
            if one.kind is BranchEvent.FLIP:
                partner, starts = doubled(curve, one.point), BranchEvent.HALVING
            elif one.kind in (BranchEvent.TOUCH, BranchEvent.DEATH):
                partner = grazing_partner(curve, one.point, one.kind, one.which)
                starts = BranchEvent.DEATH if one.kind is BranchEvent.TOUCH else BranchEvent.TOUCH
            else:
                continue
            if partner is None or (self.halt is not None and self.halt()):
                continue
            wide, start = partner
            dies = int(np.argmin(wide.motion(start.x).speeds)) if starts is BranchEvent.DEATH else -1
            begun = LocatedEvent(starts, 0.0, start, dies)
            if not self._is_new(wide.impacts, wide.periods, branch_point(wide, begun, "")):
                continue
            with halting(self.halt):
                walk = OrbitWalk(wide, start, self.bounds, fresh=True).walked(self.most)
            walk.happened.insert(0, begun)
            found.append(self.branch(wide, (walk,), depth - 1))
        return tuple(found)

    def _is_new(self, impacts: int, periods: int, point: BranchPoint) -> bool:
        """Whether no branch was followed from, or to, a point; notes it."""
        key = (impacts, periods, point.value, point.orbit.from_first.phase)
        known = any(key[:2] == other[:2] and math.dist(key[2:], other[2:]) < _SAME_POINT for other in self.met)
        self.met.append(key)
        return not known


def branch_point(curve: SolutionCurve, one: LocatedEvent, refusal: str) -> BranchPoint:
    """What is told of a point."""
    motion = curve.motion(one.point.x)
    if one.kind is BranchEvent.HALVING:
        half = curve.impacts // 2
        motion = replace(motion, times=motion.times[:half], periods=curve.periods // 2)
    orbit = motion.plain
    phase, impact = None, None
    if one.kind is BranchEvent.TOUCH:
        phase = float(np.mod(motion.times[0] + motion.sampled.time, 2.0 * math.pi))
    elif one.which >= 0:
        impact = one.which + 1
    values = None if one.kind in (BranchEvent.TOUCH, BranchEvent.DEATH) else multipliers(orbit)
    try:
        beyond, side = sentence(curve, one, impact, refusal)
    except Interrupted:
        beyond, side = one.kind.words, None
    towards, criticality = (None, None) if side is None else (side.towards, side.criticality)
    return BranchPoint(
        one.kind, (curve.value(one.point.x),), orbit, beyond, values, impact, phase, towards, criticality
    )  # fmt: skip


# ---- How far a parameter may move before a motion ends or is no longer stable, and what a simulation does then

_LOSING = {
    BranchEvent.FOLD, BranchEvent.NONSMOOTH_FOLD, BranchEvent.FLIP, BranchEvent.NEIMARK_SACKER, BranchEvent.CROSSING,
}  # fmt: skip
_OPEN = {BranchEvent.LIMIT, BranchEvent.STOPPED, BranchEvent.CLOSED}
_BEYOND = 0.01  # of the parameter, how far beyond the end it is looked what a simulation does


@dataclass(frozen=True)
class ReachEnd(BranchPoint):
    """Where a stable motion ends, on one side: a point of its branch, of the kind `LIMIT` where it goes on beyond.

    Parameters
    ----------
    then
        Label of what a simulation settles on that starts from the motion, with the parameter a hundredth further; None
        where the motion goes on or there is nothing to simulate.
    """

    then: str | None = None

    @property
    def is_open(self) -> bool:
        """Whether the motion goes on beyond what was looked at."""
        return self.kind in _OPEN


@dataclass(frozen=True)
class Reach(ShortRepr):
    """How far a parameter may move before a stable motion is lost; made by `reach`.

    Parameters
    ----------
    parameter, value
        Its name, and its value for the motion.
    below, above
        Where the motion ends towards smaller and towards greater values.
    """

    parameter: str
    value: float
    below: ReachEnd
    above: ReachEnd

    def __str__(self) -> str:
        ends = (f"{one.value:.9g} ({one.kind.value})" for one in (self.below, self.above))
        return f"{self.parameter} = {self.value:.9g}: from {' to '.join(ends)}"


def reach(
    orbit: PeriodicOrbit | ValveCycle,
    along: str,
    between: tuple[float, float] | None = None,
    *,
    family: System | Family | None = None,
    value: float | None = None,
    progress: Callable[[Elapsed], object] | None = None,
) -> Reach:
    """How far a parameter may move before a stable motion ends or is no longer stable, and what comes then.

    The motion is followed both ways. It is lost where its branch ends or turns back, and where a multiplier leaves the
    unit circle; a corner at which it stays stable does not count.

    Parameters
    ----------
    orbit
        A stable orbit.
    along, between, family, value, progress
        As for `follow`.

    Raises
    ------
    LoadError, ResonanceError, ParameterError
        As `follow`, and for a motion that is not stable.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> found = reach(orbit_near(system, [2.2], modes=0), "mean", (0.3, 1.2))
    >>> found.below.kind.value, round(found.below.value, 9), found.below.then
    ('flip', 0.654954465, 'z=2/2')
    >>> found.above.kind.value, round(found.above.value, 9), found.above.then
    ('fold', 0.954929659, 'chatter/1')
    """
    callback("progress", progress)
    machine = isinstance(orbit, ValveCycle)
    hammer = orbit.system if machine else instance("orbit", orbit, PeriodicOrbit).system
    if not orbit.stable:
        raise ParameterError("orbit", str(orbit), "a stable orbit", "'follow' goes along unstable ones")
    branch = follow(orbit, along, between, family=family, value=value, progress=progress)
    systems = SystemFamily(hammer) if family is None else family_of(family)
    start = _row(branch, orbit, value)

    def end(way: int) -> ReachEnd:
        point = _lost(branch, start, way)
        beyond = _machine_then if machine else _then
        then = None if point.kind in _OPEN else beyond(systems, branch.parameter, point, way)
        return ReachEnd(**vars(point), then=then)

    return Reach(branch.parameter, float(branch.values[start]), end(-1), end(1))


def _row(branch: Branch, orbit: PeriodicOrbit | ValveCycle, value: float | None = None) -> int:
    """The row of a branch that is nearest to an orbit."""
    if isinstance(orbit, ValveCycle):
        return int(np.argmin(np.abs(branch.times / orbit.blow_times - 1.0).max(axis=-1)))
    turn = load_turn(orbit.system.load)
    off = np.abs(differences(np.array(orbit.times), branch.times, orbit.period, turn)).max(axis=-1).min(axis=-1)
    if value is not None:
        off = off + np.abs(branch.values - value) / max(float(np.ptp(branch.values)), 1e-300)
    return int(np.argmin(off))


def _lost(branch: Branch, start: int, way: int) -> BranchPoint:
    """The nearest point at which the motion of a row is lost; where there is none, an end of the branch."""
    first, *inner, last = branch.points
    rows = [_row(branch, point.valve_cycle if branch.is_machine else point.orbit, point.value) for point in inner]
    ahead = [(row, point) for row, point in zip(rows, inner, strict=True) if (row - start) * way > 0]
    for row, point in sorted(ahead, key=lambda one: way * one[0]):
        beyond = min(max(row + way, 0), branch.values.size - 1)
        if point.kind in _LOSING or branch.unstable[beyond] != 0:
            return point
    return last if way > 0 else first


def _then(systems: Family, name: str, point: BranchPoint, way: int) -> str | None:
    """What a simulation from the motion at a point settles on, with the parameter a little further."""
    from percuss.simulate import Start, run

    size = _BEYOND * (abs(point.value) or 1.0)
    try:
        for further in (1.0, 3.0, 10.0):  # beside a flip or a pair a motion leaves what is lost very slowly
            system = systems.system({name: point.value + way * further * size})
            label = run(system, Start.orbit(point.orbit), modes=point.orbit.modes).label
            if label != point.orbit.label:
                break
    except PercussError:
        return None
    return label


def _machine_then(machines: Family, name: str, point: BranchPoint, way: int) -> str | None:
    """The same of a machine, from the motion of its piston as a whole."""
    from percuss.simulate import Start, run

    assert drives_itself(machines)
    cycle, size = point.valve_cycle, _BEYOND * (abs(point.value) or 1.0)
    own, label = cycle.label, None
    start = Start.rigid(0.0, -cycle.rebound.speed).with_valve(cycle.state, cycle.orders)
    try:
        for further in (1.0, 3.0, 10.0):
            machine = machines.machine({name: point.value + way * further * size})
            label = run(machine, start, modes=cycle.modes).label
            if not label.endswith(own):
                break
    except PercussError:
        return label
    return label
