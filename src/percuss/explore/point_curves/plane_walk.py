"""The curve in a plane on which one number vanishes, walked by its arclength, one way, to where something ends it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from percuss.errors import Interrupted, LoadError, ParameterError, PercussError
from percuss.explore.boundary_curves.plane_lines import bracketed_roots
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import in_words
from percuss.explore.continuation.solution_curve import FIRST, LONGEST, SHORTEST, CorrectorFailed
from percuss.explore.family import Family
from percuss.explore.point_curves.rest_conditions import Endless, Held, Late, RestCondition, Unlike
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.system import set_at_wall
from percuss.steady import RestCycle
from percuss.steady.resting.rest_cycles import cycle_through

# ---- Where a number vanishes along a line of a plane

_EXACT, _ROUGH, _LEAP = 1e-13, 1e-11, 2.0  # steps to a root: the last one, one that rounding has a say in, their growth
_MOST_STEPS = 20
_NEAREST, _FURTHEST = 1e-9, 1e-2  # between which a length is searched for


def root_on_line(
    number: Callable[[Array], float], place: Array, way: Array, slope: float, reach: float
) -> tuple[Array, float]:
    """Where a number vanishes on a line, by the secant method, and its slope; CorrectorFailed where it is too far.

    Parameters
    ----------
    number
        Of a place; shape (2,) in, a number out.
    place, way
        A place of the line, near the root, and its direction, of length 1; shape (2,).
    slope
        About the derivative along the line; not 0.
    reach
        How far away the root may be.
    """
    last, value = 0.0, number(place)
    if value == 0.0:
        return place, slope
    along = -value / slope
    for _ in range(_MOST_STEPS):
        if not abs(along) <= reach:
            raise CorrectorFailed("beside the curve")
        look()
        now = number(place + along * way)
        step = along - last
        if now == 0.0:
            return place + along * way, slope
        rise = (now - value) / step
        ahead = -now / rise if rise * slope > 0.0 else math.inf
        if abs(ahead) > _LEAP * abs(step):
            if abs(step) < _ROUGH:
                return place + along * way, slope
            ahead = math.copysign(_LEAP * abs(step), -now * slope)
        elif abs(step) > _ROUGH:
            slope = rise
        if abs(ahead) <= _EXACT:
            return place + (along + ahead) * way, slope
        last, value, along = along, now, along + ahead
    raise CorrectorFailed("no root")


def vanishing_beyond(number: Callable[[float], float], about: float) -> float:
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


# ---- The curve in a plane on which one number vanishes, walked by its arclength, one way, to where something ends it

_TURN = math.cos(math.radians(25.0))
_ASIDE, _QUICK = 0.3, 0.03  # shares of a step, by which its end may be beside where it led, and is hardly
_FIRM = 1e-4  # steps that are shorter turn back only where the curve ends
_BESIDE = 1e-6  # how far from a place the number is looked at for its derivatives
_AGAIN = 8  # points after which a curve may be back at its first one


class Places(Protocol):
    """A plane with a number at each place, in the neighbourhood of a curve on which that vanishes."""

    def number(self, place: Array) -> float:
        """The number; CorrectorFailed or a PercussError where there is none."""
        ...

    def arrived(self, place: Array) -> None:
        """Take what belongs to a place on the curve anew; CorrectorFailed where it is no such place."""
        ...


def to_the_left(way: Array) -> Array:
    """The direction at right angles to the left of another."""
    return np.array([-way[1], way[0]])


class PlaneWalk:
    """A walk along the curve.

    Parameters
    ----------
    places
        The plane.
    start, way
        A place of the curve, and the direction in which to set out; shape (2,).
    slope
        The derivative of the number at right angles to the left of that direction.
    box
        Lower and upper corner of what is walked through; shape (2, 2).

    Attributes
    ----------
    points, ways
        Places of the curve, from the start on, and its direction there.
    end
        What ended the walk.
    stray
        Why the last steps were no longer.
    """

    def __init__(self, places: Places, start: Array, way: Array, slope: float, box: Array) -> None:
        self.places, self.box = places, box
        self.points, self.ways, self.slope = [start], [way], slope
        self.size = FIRST
        self._firm, self._aimed = way, False
        self.end: BranchEvent | None = None
        self.stray: CorrectorFailed | PercussError | None = None

    @property
    def way(self) -> Array:
        """The direction at the last point."""
        return self.ways[-1]

    def step(self) -> None:
        """Go on to the next point, shorter if need be; `end` is set where there is none."""
        here = self.points[-1]
        try:
            found, limit = self._ahead()
            chord = found - here
            length = float(np.linalg.norm(chord))
            way = self._way_at(found)
            if (
                float(way @ self.way) < _TURN
                or float(chord @ self.way) < _TURN * length
                or float(way @ self._firm) < 0.0
            ):
                raise CorrectorFailed("a bend")
            self.places.arrived(found)
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError) as stray:
            if type(self.stray) is CorrectorFailed or self.stray is None or type(stray) is not CorrectorFailed:
                self.stray = stray  # one that says more than that there was none is kept
            self.size *= 0.5
            if self.size < _FIRM and not self._aimed:
                self._aim()
            elif self.size < SHORTEST:
                on_edge = np.any((here == self.box[0]) | (here == self.box[1]))
                self.end = BranchEvent.LIMIT if on_edge and len(self.points) == 1 else BranchEvent.LOST
            return
        self.points.append(found)
        self.ways.append(way)
        self._aimed = False
        if self.size > _FIRM:
            self._firm, self.stray = way, None
        if limit:
            self.end = BranchEvent.LIMIT
        elif self._is_home():
            self.points[-1] = self.points[0]
            self.end = BranchEvent.CLOSED

    def _aim(self) -> None:
        """Put the direction at the last point right, where the curve bends faster than its points have told."""
        here, left, self._aimed = self.points[-1], to_the_left(self.way), True
        try:
            along, across = (self._seen(here + _BESIDE * way) / _BESIDE for way in (self.way, left))
        except Interrupted:
            raise
        except (CorrectorFailed, PercussError):
            return
        if abs(along) < abs(across):
            way = self.way - along / across * left
            self.ways[-1] = way / float(np.linalg.norm(way))
            self.slope, self.size = math.copysign(math.hypot(along, across), across), FIRST

    def _ahead(self) -> tuple[Array, bool]:
        """The next point, and whether it is on the edge of the box."""
        place = self._extrapolated(self.size)
        normal = to_the_left(self.way)
        if self._outside(place) is not None:
            return self._on_edge(place), True
        aside = _ASIDE * self.size
        found, slope = root_on_line(self._seen, place, normal, self.slope, aside)
        if self._outside(found) is not None:
            return self._on_edge(found), True
        if float(np.linalg.norm(found - place)) < _QUICK * self.size:
            self.size = min(1.5 * self.size, LONGEST)
        self.slope = slope
        return found, False

    def _seen(self, place: Array) -> float:
        return self.places.number(place)

    def _outside(self, place: Array) -> int | None:
        """The coordinate by which a place is outside of the box, None where it is inside."""
        beyond = np.maximum(self.box[0] - place, place - self.box[1])
        i = int(np.argmax(beyond))
        return i if beyond[i] > 0.0 else None

    def _on_edge(self, place: Array) -> Array:
        """The point of the curve on the edge of the box, before a place outside of it."""
        here = self.points[-1]
        i = self._outside(place)
        assert i is not None
        edge = self.box[0, i] if place[i] < self.box[0, i] else self.box[1, i]
        share = (edge - here[i]) / (place[i] - here[i])
        start = here + share * (place - here)
        start[i] = edge
        along = np.zeros(2)
        along[1 - i] = 1.0
        nudge = min(1e-3 * self.size, 1e-5)
        if not self.box[0, 1 - i] <= start[1 - i] + nudge <= self.box[1, 1 - i]:
            nudge = -nudge
        slope = (self.places.number(start + nudge * along) - self.places.number(start)) / nudge
        if slope == 0.0:
            raise CorrectorFailed("along the edge")
        return root_on_line(self._seen, start, along, slope, self.size)[0]

    def _extrapolated(self, size: float) -> Array:
        """Where the curve should be a length further on, by the parabola through the last three points."""
        here = self.points[-1]
        place = here + size * self.way
        if len(self.points) < 3:
            return place
        return here + size * self.way + 0.5 * size**2 * self._bend()

    def _bend(self) -> Array:
        """The second derivative by the arclength, of the last three points."""
        a, b, c = self.points[-3:]
        first, second = float(np.linalg.norm(b - a)), float(np.linalg.norm(c - b))
        return np.asarray(2.0 * ((c - b) / second - (b - a) / first) / (first + second))

    def _way_at(self, found: Array) -> Array:
        """The direction of the curve at a new point."""
        here = self.points[-1]
        chord = found - here
        length = float(np.linalg.norm(chord))
        if length == 0.0:
            raise CorrectorFailed("no step")
        if len(self.points) > 1:
            before = self.points[-2]
            last = float(np.linalg.norm(here - before))
            bend = 2.0 * (chord / length - (here - before) / last) / (length + last)
            ahead = chord / length + 0.5 * length * bend
        else:
            ahead = 2.0 * chord / length - self.way
        return np.asarray(ahead / np.linalg.norm(ahead))

    def _is_home(self) -> bool:
        if len(self.points) < _AGAIN:
            return False
        first, here, last = self.points[0], self.points[-1], self.points[-2]
        chord = here - last
        length = float(np.linalg.norm(chord))
        share = float((first - last) @ chord) / length**2
        return 0.0 < share <= 1.0 and float(np.linalg.norm(last + share * chord - first)) < _QUICK * length


# ---- The walk along a curve of ends of cycles with rest, one way, and what happens on it

_NUDGE = 1e-5  # of a unit, for derivatives
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
        """The same as what is let go at the wall: see `percuss.model.system`."""
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

    kind: BranchEvent
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
        end = walk.end or BranchEvent.STOPPED
        end, beyond = self._reason() if end is BranchEvent.LOST else (end, end.words)
        last = self.passed[-1].place
        if end in (BranchEvent.WITH_TOUCH, BranchEvent.WITH_DEATH):
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
        if self.plane.condition.kind is BranchEvent.RELEASE_LOST:
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
        except (CorrectorFailed, PercussError):
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
            except (CorrectorFailed, ParameterError):
                break
            low, high = (low, middle) if there is after else (middle, high)
            found = place
        return RestHappening(BranchEvent.OTHER_CYCLE, found, BranchEvent.OTHER_CYCLE.words)

    def _reason(self) -> tuple[BranchEvent, str]:
        """Why the curve was lost."""
        stray = self.walk.stray
        if isinstance(stray, Unlike):
            kind = BranchEvent.WITH_TOUCH if stray.kind is BranchEvent.TOUCH else BranchEvent.WITH_DEATH
        elif isinstance(stray, Endless):
            kind = BranchEvent.UNPRESSED if isinstance(self.plane.condition, Late) else BranchEvent.ENDLESS
        elif isinstance(stray, PercussError):
            kind = BranchEvent.NO_PUSH if isinstance(stray, LoadError) else BranchEvent.NO_SYSTEM
            return kind, in_words(stray)
        else:
            kind = BranchEvent.LOST
        return kind, kind.words
