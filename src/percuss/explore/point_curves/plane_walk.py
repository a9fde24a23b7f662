"""The curve in a plane on which one number vanishes, walked by its arclength, one way, to where something ends it."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from percuss.errors import Interrupted, PercussError
from percuss.explore.continuation.next_point import FIRST, LONGEST, SHORTEST, Strayed
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.line_roots import root_on_line
from percuss.model.checks import Array

__all__ = ["Places", "PlaneWalk", "to_the_left"]

_TURN = math.cos(math.radians(25.0))
_ASIDE, _QUICK = 0.3, 0.03  # shares of a step, by which its end may be beside where it led, and is hardly
_FIRM = 1e-4  # steps that are shorter turn back only where the curve ends
_BESIDE = 1e-6  # how far from a place the number is looked at for its derivatives
_AGAIN = 8  # points after which a curve may be back at its first one


class Places(Protocol):
    """A plane with a number at each place, in the neighbourhood of a curve on which that vanishes."""

    def number(self, place: Array) -> float:
        """The number; Strayed or a PercussError where there is none."""
        ...

    def arrived(self, place: Array) -> None:
        """Take what belongs to a place on the curve anew; Strayed where it is no such place."""
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
        self.end: CurveEvent | None = None
        self.stray: Strayed | PercussError | None = None

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
                raise Strayed("a bend")
            self.places.arrived(found)
        except Interrupted:
            raise
        except (Strayed, PercussError) as stray:
            if type(self.stray) is Strayed or self.stray is None or type(stray) is not Strayed:
                self.stray = stray  # one that says more than that there was none is kept
            self.size *= 0.5
            if self.size < _FIRM and not self._aimed:
                self._aim()
            elif self.size < SHORTEST:
                on_edge = np.any((here == self.box[0]) | (here == self.box[1]))
                self.end = CurveEvent.LIMIT if on_edge and len(self.points) == 1 else CurveEvent.LOST
            return
        self.points.append(found)
        self.ways.append(way)
        self._aimed = False
        if self.size > _FIRM:
            self._firm, self.stray = way, None
        if limit:
            self.end = CurveEvent.LIMIT
        elif self._is_home():
            self.points[-1] = self.points[0]
            self.end = CurveEvent.CLOSED

    def _aim(self) -> None:
        """Put the direction at the last point right, where the curve bends faster than its points have told."""
        here, left, self._aimed = self.points[-1], to_the_left(self.way), True
        try:
            along, across = (self._seen(here + _BESIDE * way) / _BESIDE for way in (self.way, left))
        except Interrupted:
            raise
        except (Strayed, PercussError):
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
            raise Strayed("along the edge")
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
            raise Strayed("no step")
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
