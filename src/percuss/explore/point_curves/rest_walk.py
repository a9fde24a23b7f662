"""The walk along a curve of ends of cycles with rest, one way, and what happens on it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from percuss.errors import Interrupted, LoadError, ParameterError, PercussError
from percuss.explore.continuation.limits import in_words
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.rest_branch import RestEvent
from percuss.explore.family import Family
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.line_roots import root_on_line, vanishing_beyond
from percuss.explore.point_curves.onsets import Endless, Held, Late
from percuss.explore.point_curves.plane_walk import PlaneWalk, to_the_left
from percuss.explore.point_curves.rest_conditions import RestCondition
from percuss.explore.point_curves.rest_way import Unlike
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.set_at_wall import set_at_wall
from percuss.steady import RestCycle
from percuss.steady.resting.search import cycle_through

__all__ = ["Passed", "RestHappening", "RestPlane", "RestWalk"]

_NUDGE = 1e-5  # of a unit, for derivatives
_BESIDE = 1e-6  # of a unit, from the curve, where the cycle is looked for
_FAR = 1e2 * _BESIDE
_INSIDE = 1e-7  # of a step, to which it is known where the cycle ceases


@dataclass
class RestPlane:
    """The plane of two parameters about a curve of ends of cycles with rest: `Places` of a walk.

    Parameters
    ----------
    family, names, units
        The systems, both parameters, and by how much each changes for what counts as a step of 1.
    condition
        What ends the cycles, told by the last place.
    """

    family: Family
    names: tuple[str, str]
    units: Array
    condition: RestCondition

    def values(self, place: Array) -> tuple[float, float]:
        """Both parameters at a place."""
        return float(place[0] * self.units[0]), float(place[1] * self.units[1])

    def system(self, place: Array) -> System:
        """The system there."""
        return self.family.system(dict(zip(self.names, self.values(place), strict=True)))

    def at_wall(self, place: Array) -> System:
        """The same as what is let go at the wall: see `percuss.model.set_at_wall`."""
        return set_at_wall(self.system(place), self.condition.way.modes)

    def number(self, place: Array) -> float:
        """What vanishes on the curve."""
        return self.condition.number(self.at_wall(place))

    def arrived(self, place: Array) -> None:
        """Take the way of the bar anew at a place of the curve."""
        self.condition = self.condition.renewed(self.at_wall(place))

    def slopes(self, place: Array, box: Array) -> Array:
        """The derivatives of the number at a place of the curve, from inside of a box."""
        found, here = np.zeros(2), self.number(place)
        for i in range(2):
            nudge = np.eye(2)[i] * (_NUDGE if place[i] + _NUDGE <= box[1, i] else -_NUDGE)
            try:
                there = self.number(place + nudge)
            except ParameterError:  # beyond the end of a parameter
                nudge = -nudge
                there = self.number(place + nudge)
            found[i] = (there - here) / nudge[i]
        return found


class Passed(NamedTuple):
    """A place of the curve: when the bar is let go there, when it happens, and whether the cycle is beside it."""

    place: Array
    release: float
    time: float
    is_cycle: bool


class RestHappening(NamedTuple):
    """What happens, and where."""

    kind: CurveEvent
    place: Array
    beyond: str


@dataclass
class RestWalk:
    """A walk, and what is seen on it.

    Parameters
    ----------
    cycle
        The cycle that ends on the curve, where it was first met.
    walk
        The walk.
    side
        1 where the cycle is to the left of it, −1 where it is to the right.
    """

    cycle: RestCycle
    walk: PlaneWalk
    side: float
    passed: list[Passed] = field(default_factory=list)
    happened: list[RestHappening] = field(default_factory=list)
    held: float = 0.0

    def walked(self, most: int) -> RestWalk:
        """The same after it has gone to its end."""
        walk = self.walk
        try:
            self._arrive()
            while walk.end is None and len(walk.points) < most:
                number = len(walk.points)
                walk.step()
                if len(walk.points) > number:
                    self._arrive()
        except Interrupted:
            if not self.passed:
                self.passed.append(Passed(walk.points[0], self.plane.condition.way.release, np.nan, True))
            del walk.points[len(self.passed) :]
        end = walk.end or CurveEvent.STOPPED
        end, beyond = self._reason() if end is CurveEvent.LOST else (end, end.words)
        last = self.passed[-1].place
        if end in (CurveEvent.WITH_TOUCH, CurveEvent.WITH_DEATH):
            self._cleared(last)
        self.happened.append(RestHappening(end, last, beyond))
        return self

    def _cleared(self, end: Array) -> None:
        """Forget what is seen so near to the end of the curve that what is beside it is beyond."""
        self.happened = [one for one in self.happened if np.linalg.norm(one.place - end) > _FAR]
        was = next((one.is_cycle for one in self.passed[::-1] if np.linalg.norm(one.place - end) > _FAR), True)
        self.passed = [
            one if np.linalg.norm(one.place - end) > _FAR else one._replace(is_cycle=was) for one in self.passed
        ]

    @property
    def plane(self) -> RestPlane:
        """The plane that is walked through."""
        assert isinstance(self.walk.places, RestPlane)
        return self.walk.places

    def _arrive(self) -> None:
        """See what there is at the last place."""
        place, system = self.walk.points[-1], self.plane.at_wall(self.walk.points[-1])
        condition = self.plane.condition
        if isinstance(condition, Held) and system.contact.velocity_factor < 0.0:
            place = self._where_held(condition, place)
        is_cycle = self._is_cycle(place, self.walk.way)
        if self.passed and is_cycle is not self.passed[-1].is_cycle:
            self.happened.append(self._located(self.passed[-1].place, place, is_cycle))
        self.passed.append(Passed(place, condition.way.release, condition.phase(system), is_cycle))

    def _where_held(self, condition: Held, place: Array) -> Array:
        """Where the bar is hardly held any more, at right angles to the curve or along the edge of the plane."""
        edge = np.flatnonzero((place == self.walk.box[0]) | (place == self.walk.box[1]))
        way = np.eye(2)[1 - edge[0]] if edge.size else to_the_left(self.walk.way)
        try:
            turned = self.plane.number(place + _NUDGE * way) > 0.0
        except ParameterError:  # beyond the end of a parameter
            turned = self.plane.number(place - _NUDGE * way) < 0.0
        way = -way if turned else way
        beyond = vanishing_beyond(lambda at: condition.spare(self.plane.at_wall(place + at * way)), 0.7 * self.held)
        self.held = beyond
        return place + beyond * way

    def _is_cycle(self, place: Array, way: Array) -> bool:
        """Whether the bar let go comes back as the cycle does, hardly beside the curve."""
        if self.plane.condition.kind is RestEvent.RELEASE_LOST:
            return True
        try:
            system = self.plane.system(place + self.side * _BESIDE * to_the_left(way))
        except PercussError:  # beyond the end of a parameter
            return not self.passed or self.passed[-1].is_cycle
        try:
            release = self.plane.condition.way.released(set_at_wall(system, self.cycle.modes))
            found, _, _ = cycle_through(system, release, modes=self.cycle.modes, most=self.cycle.periods)
        except Interrupted:
            raise
        except (Strayed, PercussError):
            return False
        return found is not None and found.periods == self.cycle.periods

    def _located(self, first: Array, last: Array, after: bool) -> RestHappening:
        """Where the cycle ceases, or comes again, between two places."""
        chord = last - first
        length = float(np.linalg.norm(chord))
        way, low, high, found = chord / length, 0.0, 1.0, last
        while high - low > _INSIDE:
            middle = 0.5 * (low + high)
            try:
                place = first + middle * chord
                place, _ = root_on_line(self.plane.number, place, to_the_left(way), self.walk.slope, length)
                there = self._is_cycle(place, way)
            except (Strayed, ParameterError):
                break
            low, high = (low, middle) if there is after else (middle, high)
            found = place
        return RestHappening(CurveEvent.OTHER_CYCLE, found, CurveEvent.OTHER_CYCLE.words)

    def _reason(self) -> tuple[CurveEvent, str]:
        """Why the curve was lost."""
        stray = self.walk.stray
        if isinstance(stray, Unlike):
            kind = CurveEvent.WITH_TOUCH if stray.kind is RestEvent.TOUCH else CurveEvent.WITH_DEATH
        elif isinstance(stray, Endless):
            kind = CurveEvent.UNPRESSED if isinstance(self.plane.condition, Late) else CurveEvent.ENDLESS
        elif isinstance(stray, PercussError):
            kind = CurveEvent.NO_PUSH if isinstance(stray, LoadError) else CurveEvent.NO_SYSTEM
            return kind, in_words(stray)
        else:
            kind = CurveEvent.LOST
        return kind, kind.words
