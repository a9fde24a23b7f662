"""Orbits followed through a parameter, both ways, from one that is known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import Interrupted
from percuss.explore.continuation.beginning import beginning, range_around, unit_of_turn, value_of
from percuss.explore.continuation.beyond import sentence
from percuss.explore.continuation.branch import Branch, BranchPoint
from percuss.explore.continuation.happenings import Happening
from percuss.explore.continuation.indicators import greatest_top, multipliers
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.limits import in_words
from percuss.explore.continuation.partners import doubled, grazing_partner
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.explore.continuation.walking import Walk, walked
from percuss.explore.family import Family, SystemFamily, family_of
from percuss.halting import halting
from percuss.model import System
from percuss.model.checks import callback, count, finite, instance, text
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.sameness import canonical, load_turn

__all__ = ["follow"]

MOST_POINTS = 100_000
MOST_DEPTH = 16
_UNITS = 4.0  # of the range of the parameter, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales
_SAME_POINT = 1e-7
_GIVEN_BACK = {BranchEvent.HALVING, BranchEvent.TOUCH, BranchEvent.DEATH}


def follow(
    orbit: PeriodicOrbit,
    along: str,
    between: tuple[float, float] | None = None,
    *,
    family: System | Family | None = None,
    value: float | None = None,
    switch: int = 0,
    most: int = 4000,
    halt: Callable[[], bool] | None = None,
) -> Branch:
    """Follow an orbit through a parameter, both ways, round folds, until something ends it.

    The branch is walked by its arclength in the times of its impacts, and everything that happens on it is located:
    folds, flips, pairs of multipliers on the unit circle, corners where an impact meets a step of the load, and what
    ends it: a touch between two impacts, the death of one, the end of the range. Nothing ends unexplained.

    What happens twice between two points of the walk, and leaves no trace in them, is not seen; a touch is looked for
    between them, too.

    Parameters
    ----------
    orbit
        Where to begin: an admissible orbit, of `percuss.steady.orbits` or `orbit_near`.
    along
        Name of the parameter; of `percuss.explore.PARAMETERS`, or of the family.
    between
        The range of the parameter, which must hold its value for the orbit; None to go on until the branch ends.
    family
        The systems; None for those that differ from that of the orbit in the parameter alone.
    value
        Of the parameter, for the orbit; None for what its system says, where it is a dimensionless one.
    switch
        How often to go on at the flips of a branch to the orbit of twice the period, and for a rigid bar at its
        grazings to the orbit with an impact more or less; 0 to 16.
    most
        Points of each way at most.
    halt
        Called again and again; once it returns true, what has been followed so far is the answer.

    Returns
    -------
    Branch
        Its points, what happens on it, and the branches switched to.

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
    >>> branch = follow(orbit_near(system, [0.39, 2.32], modes=0), "mean", (0.3, 1.2))
    >>> for point in branch.points:
    ...     print(point.kind.value, round(point.value, 9))
    grazing_impact_dies 0.399313189
    flip 0.659281675
    fold 0.673754187
    grazing_touch 0.527909682
    """
    instance("orbit", orbit, PeriodicOrbit)
    systems = SystemFamily(orbit.system) if family is None else family_of(family)
    name = text("along", along, "the name of a parameter")
    systems.check({name: getattr(systems, "units", {}).get(name, "")})
    here = value_of(orbit.system, name) if value is None else finite("value", value)
    bounds = (-math.inf, math.inf) if between is None else range_around(between, here)
    points, depth = count("most", most, least=2, most=MOST_POINTS), count("switch", switch, least=0, most=MOST_DEPTH)
    callback("halt", halt)
    scale = max(1.0, abs(here))
    size = scale if between is None else min((bounds[1] - bounds[0]) / _UNITS, _WIDE * scale)
    unit = 2.0 ** round(math.log2(size))  # so that nothing is rounded when values are taken by it
    curve = SolutionCurve(systems, name, orbit.impacts, orbit.periods, orbit.modes, unit)
    tracer = _Tracer(bounds, points, halt, [])
    with halting(halt):
        start = beginning(curve, orbit, here, bounds)
        if between is None and here == 0.0:  # its own size tells nothing of its scale
            curve = replace(curve, unit=unit_of_turn(curve, start))
            start = beginning(curve, orbit, here, bounds)
        forward = walked(curve, start, bounds, points)
        closed = forward.happened[-1].kind is BranchEvent.CLOSED
        back = None if closed else walked(curve, CurvePoint(start.x, -start.tangent, 0), bounds, points)
    return tracer.branch(curve, back, forward, depth)


@dataclass
class _Tracer:
    """Makes branches of walks, and follows the branches that begin at their points."""

    bounds: tuple[float, float]
    most: int
    halt: Callable[[], bool] | None
    met: list[tuple[int, int, float, float]]

    def branch(self, curve: SolutionCurve, back: Walk | None, forward: Walk, depth: int) -> Branch:
        """The branch of two walks from one point, the one backward first."""
        ways = [] if back is None else [(back.points[:0:-1], back.unstable[:0:-1], back.happened[::-1], back)]
        ways.append((forward.points, forward.unstable, forward.happened, forward))
        rows = [point for points, _, _, _ in ways for point in points]
        motions = [curve.motion(point.x) for point in rows]
        happened = [one for _, _, happened, _ in ways for one in happened]
        if forward.happened[-1].kind is BranchEvent.CLOSED:
            happened.insert(0, forward.happened[-1])
        refusals = [in_words(way.refusal) for _, _, happened, way in ways for one in happened]
        refusals += refusals[-1:]
        found = [branch_point(curve, one, refusal) for one, refusal in zip(happened, refusals, strict=False)]
        for one, point in zip(happened, found, strict=True):
            if one.kind in _GIVEN_BACK:
                self._is_new(curve.impacts, curve.periods, point)
        return Branch(
            curve.name, curve.impacts, curve.periods, curve.modes,
            values=np.array([curve.value(point.x) for point in rows]),
            times=np.array([motion.times for motion in motions]),
            speeds=np.array([motion.speeds for motion in motions]),
            unstable=np.array([number for _, numbers, _, _ in ways for number in numbers], dtype=np.int64),
            points=tuple(found),
            switched=self._switched(curve, list(zip(happened, found, strict=True)), depth) if depth else (),
        )  # fmt: skip

    def _switched(
        self, curve: SolutionCurve, happened: list[tuple[Happening, BranchPoint]], depth: int
    ) -> tuple[Branch, ...]:
        """The branches that begin at points of one, and have not been followed yet."""
        found = []
        for one, _ in happened:
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
            begun = Happening(starts, 0.0, start, dies)
            if not self._is_new(wide.impacts, wide.periods, branch_point(wide, begun, "")):
                continue
            with halting(self.halt):
                walk = walked(wide, start, self.bounds, self.most, fresh=True)
            walk.happened.insert(0, begun)
            found.append(self.branch(wide, None, walk, depth - 1))
        return tuple(found)

    def _is_new(self, impacts: int, periods: int, point: BranchPoint) -> bool:
        """Whether no branch was followed from, or to, a point; notes it."""
        key = (impacts, periods, point.value, point.orbit.phase)
        known = any(key[:2] == other[:2] and math.dist(key[2:], other[2:]) < _SAME_POINT for other in self.met)
        self.met.append(key)
        return not known


def branch_point(curve: SolutionCurve, one: Happening, refusal: str) -> BranchPoint:
    """What is told of a point."""
    motion = curve.motion(one.point.x)
    if one.kind is BranchEvent.HALVING:
        half = curve.impacts // 2
        motion = replace(motion, times=motion.times[:half], periods=curve.periods // 2)
    orbit = motion.from_first
    phase, impact = None, None
    if one.kind is BranchEvent.TOUCH:
        phase = float(np.mod(motion.times[0] + greatest_top(motion).time, 2.0 * math.pi))
    elif one.which >= 0:
        _, first = canonical(np.array(motion.times), motion.period, load_turn(motion.system.load))
        impact = (one.which - first) % motion.impacts + 1
    values = None if one.kind in (BranchEvent.TOUCH, BranchEvent.DEATH) else multipliers(orbit)
    try:
        beyond = sentence(curve, one, impact, refusal)
    except Interrupted:
        beyond = one.kind.words
    return BranchPoint(one.kind, curve.value(one.point.x), orbit, values, beyond, impact, phase)
