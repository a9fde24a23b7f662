"""How far a parameter may move before a motion ends or is no longer stable, and what a simulation does then."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.following import follow
from percuss.explore.family import Family, SystemFamily, family_of
from percuss.model import System
from percuss.model.checks import callback, instance
from percuss.shown import Shown
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit
from percuss.steady.periodic.periodic_orbit import differences, load_turn

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
class Reach(Shown):
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
    orbit: PeriodicOrbit,
    along: str,
    between: tuple[float, float] | None = None,
    *,
    family: System | Family | None = None,
    value: float | None = None,
    halt: Callable[[], bool] | None = None,
) -> Reach:
    """How far a parameter may move before a stable motion ends or is no longer stable, and what comes then.

    The motion is followed both ways. It is lost where its branch ends or turns back, and where a multiplier leaves the
    unit circle; a corner at which it stays stable does not count.

    Parameters
    ----------
    orbit
        A stable orbit.
    along, between, family, value, halt
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
    instance("orbit", orbit, PeriodicOrbit)
    callback("halt", halt)
    if not orbit_multipliers(orbit).stable:
        raise ParameterError("orbit", str(orbit), "a stable orbit", "'follow' goes along unstable ones")
    branch = follow(orbit, along, between, family=family, value=value, halt=halt)
    systems = SystemFamily(orbit.system) if family is None else family_of(family)
    start = _row(branch, orbit, value)

    def end(way: int) -> ReachEnd:
        point = _lost(branch, start, way)
        then = None if point.kind in _OPEN else _then(systems, along, point, way)
        return ReachEnd(**vars(point), then=then)

    return Reach(along, float(branch.values[start]), end(-1), end(1))


def _row(branch: Branch, orbit: PeriodicOrbit, value: float | None = None) -> int:
    """The row of a branch that is nearest to an orbit."""
    turn = load_turn(orbit.system.load)
    off = np.abs(differences(np.array(orbit.times), branch.times, orbit.period, turn)).max(axis=-1).min(axis=-1)
    if value is not None:
        off = off + np.abs(branch.values - value) / max(float(np.ptp(branch.values)), 1e-300)
    return int(np.argmin(off))


def _lost(branch: Branch, start: int, way: int) -> BranchPoint:
    """The nearest point at which the motion of a row is lost; where there is none, an end of the branch."""
    first, *inner, last = branch.points
    rows = [_row(branch, point.orbit, point.value) for point in inner]
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
