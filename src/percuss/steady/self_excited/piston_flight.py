"""The flight of a rigid piston under a constant force, a gas chamber and a drag, and where it first passes a place.

The distance x behind the wall obeys x″ + d x′ + κx = a. With s the answer to a unit velocity and q its integral,

    x = x₀ + v₀ s + (a − κx₀) q,   v = v₀ s′ + (a − κx₀) s,

which is a circle for κ > 0 and d = 0, an exponential for κ = 0 and d > 0, and a parabola for neither (theory, "The
machine that switches itself").

`flight_kernels` says the same once more, on purpose: it is compiled, for many pistons at once, and for one piston no
compiler need be loaded. A test compares the two.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.model.checks import Array

__all__ = ["Crossing", "Flight", "response"]

_SMALL = 0.5  # the series are taken where κt² and dt are no greater, and doubled from there
_TERMS = 18
_NOTHING = 2.0**-56  # of the sums, which are about 1
_PIECES = 3  # a flight between later turning points stays within the range of the third
_STEPS = 200  # to a passage; halving alone takes fewer than 60
_SHORTEST = 1e-300  # of the times that are tried, and doubled: a step of 0 would stay so
_EPS = 2.0**-52


def response(t: float, stiffness: float, drag: float) -> tuple[float, float, float]:
    """s′, s and q at the time t: velocity and place after a unit velocity, and place under a unit force from rest.

    A long swing by its circle, all else by power series and by doubling the time: smooth in κ and d, down to 0.
    """
    square = stiffness - 0.25 * drag * drag
    if stiffness * t * t > _SMALL and square > 0.5 * stiffness and drag <= stiffness * t:
        return _swing(t, stiffness, drag, math.sqrt(square))
    return _responses(t, t, stiffness, drag)


def _responses(t: Any, longest: float, stiffness: float, drag: float) -> tuple[Any, Any, Any]:
    """The same of a time, or of an array of times, the longest of which tells how often it is halved."""
    if stiffness == 0.0 and drag == 0.0:
        return 1.0, t, 0.5 * t * t
    doublings = 0
    while stiffness * longest * longest > _SMALL or drag * longest > _SMALL:
        longest *= 0.5
        doublings += 1
    t, many = t * 0.5**doublings, isinstance(t, np.ndarray)
    z, b = stiffness * t * t, drag * t
    before, now = 0.0, 1.0  # coefficients of the series of s(t)/t, one after the other
    ds = s = 1.0
    q = 0.5
    for n in range(1, _TERMS):
        before, now = now, -(b * n * now + z * before) / (n * (n + 1))
        ds += (n + 1) * now
        s += now
        q += now / (n + 2)
        if not many and n * (abs(now) + abs(before)) < _NOTHING:
            break
    s, q = s * t, q * t * t
    for _ in range(doublings):
        ds, s, q = ds * ds - stiffness * s * s, s * (1.0 - stiffness * q + ds), 2.0 * q + s * s - stiffness * q * q
    return ds, s, q


def _swing(t: float, stiffness: float, drag: float, rate: float) -> tuple[float, float, float]:
    """s′, s and q of a swing, where little is lost in their differences."""
    left, more = math.exp(-0.5 * drag * t), 0.5 * drag / rate
    sine, half = math.sin(rate * t), math.sin(0.5 * rate * t)
    ds, s = left * (math.cos(rate * t) - more * sine), left * sine / rate
    q = (2.0 * left * half * half - left * more * sine - math.expm1(-0.5 * drag * t)) / stiffness
    return ds, s, q


@dataclass(frozen=True)
class Crossing:
    """The first passage of a place: when, and which of the places that were asked for lie there."""

    time: float
    which: tuple[int, ...]


@dataclass(frozen=True)
class Flight:
    """A flight from the distance x behind the wall with the velocity v away from it.

    Parameters
    ----------
    push
        Acceleration away from the wall at the wall, a.
    stiffness, drag
        κ and d.
    x, v
        At the start of the flight.
    """

    push: float
    stiffness: float
    drag: float
    x: float
    v: float

    @property
    def acceleration(self) -> float:
        """At the start, without the drag."""
        return self.push - self.stiffness * self.x

    def push_at(self, t: float) -> float:
        """Acceleration away from the wall at the wall, at a time."""
        return self.push

    def at(self, t: float) -> tuple[float, float]:
        """Distance and velocity at a time."""
        ds, s, q = response(t, self.stiffness, self.drag)
        return self.x + self.v * s + self.acceleration * q, self.v * ds + self.acceleration * s

    def distances(self, times: Array) -> Array:
        """The distance at several times, in any order."""
        _, s, q = _responses(times, float(times.max(initial=0.0)), self.stiffness, self.drag)
        return np.asarray(self.x + self.v * s + self.acceleration * q)

    @property
    def turning_time(self) -> float:
        """When the velocity first is 0 after the start; infinite when it never is."""
        v, f, square = self.v, self.acceleration, self.stiffness - 0.25 * self.drag**2
        below = 0.5 * v * self.drag - f
        if square > 0.0:
            rate = math.sqrt(square)
            if v == 0.0:
                return math.pi / rate if f != 0.0 else math.inf
            return math.atan2(abs(v) * rate, below if v > 0.0 else -below) / rate  # no π is added: it would cancel
        if v == 0.0 or below == 0.0 or v / below < 0.0:
            return math.inf
        ratio, rate = v / below, math.sqrt(-square)
        if rate == 0.0:
            return ratio
        return math.atanh(rate * ratio) / rate if rate * ratio < 1.0 else math.inf

    @property
    def last_place(self) -> float:
        """Where it comes to rest or goes to in the end, when it does not oscillate for ever."""
        if self.stiffness > 0.0:
            return self.push / self.stiffness
        if self.push != 0.0:
            return math.copysign(math.inf, self.push)
        if self.drag > 0.0:
            return self.x + self.v / self.drag
        return self.x if self.v == 0.0 else math.copysign(math.inf, self.v)

    def turning_places(self, until: float = math.inf) -> list[float]:
        """Where it turns, up to a time: the first three, within which all others lie."""
        return [self.at(end)[0] for _, end in self._pieces([], until) if end < until]

    def first_crossing(self, places: Sequence[tuple[float, int]], until: float) -> Crossing | None:
        """The first of the places that is passed, each in its own direction: +1 away from the wall, −1 towards it.

        A place that is only touched, or at which the flight starts, is not passed.
        """
        x, done = self.x, 0.0
        for number, (start, end) in enumerate(self._pieces(places, until)):
            x = self.at(start)[0] if start > done else x
            done = end
            stop = min(end, until)
            last = self.at(stop)[0] if math.isfinite(stop) else self.last_place
            way = 1 if last > x else -1
            passed = [
                place for place, towards in places if towards == way and 0.0 < way * (place - x) < way * (last - x)
            ]
            if passed:
                place = min(passed) if way > 0 else max(passed)
                which = tuple(i for i, own in enumerate(places) if own == (place, way))
                return Crossing(self._time_at(place, way, number, start, stop), which)
            if end >= until:
                return None
            x = last
        return None

    def _pieces(self, places: Sequence[tuple[float, int]], until: float) -> Iterator[tuple[float, float]]:
        """The times between which it does not turn, without some that are passed without any of the places."""
        start, end = 0.0, self.turning_time
        square = self.stiffness - 0.25 * self.drag**2
        step = math.pi / math.sqrt(square) if square > 0.0 else math.inf
        for _ in range(_PIECES):
            yield start, end
            if end == math.inf:
                return
            start, end = end, end + step

    def _time_at(self, place: float, way: int, number: int, start: float, stop: float) -> float:
        """When a place is passed between two turning points."""
        if self.stiffness == 0.0 and self.drag == 0.0:
            speed = way * math.sqrt(max(0.0, self.v**2 + 2.0 * self.push * (place - self.x)))
            return 2.0 * (place - self.x) / (self.v + speed) if number == 0 else (speed - self.v) / self.push

        x, v = self.at(start)
        far, force = abs(place - x), abs(self.push - self.stiffness * x)
        step = min(far / abs(v) if v else math.inf, math.sqrt(far / force) if force else math.inf)
        step = 1.0 / math.sqrt(self.stiffness) if step == math.inf else step  # at rest, until a ramp pushes
        step = max(step, _SHORTEST)
        low, high = start, min(start + step, stop)  # the end may be far beyond the passage: a soft spring swings slowly
        while way * (self.at(high)[0] - place) <= 0.0:
            if high >= stop:  # passed within rounding of the end
                return stop
            step *= 2.0
            low, high = high, min(start + step, stop)
        return self._bracketed(place, way, low, high)

    def _bracketed(self, place: float, way: int, low: float, high: float) -> float:
        """When a place is passed between two times with no turning point between: Newton's method, else halving."""
        t = 0.5 * (low + high)
        for _ in range(_STEPS):
            now, speed = self.at(t)
            beyond = way * (now - place)
            if beyond == 0.0:
                return t
            low, high = (t, high) if beyond < 0.0 else (low, t)
            following = t - beyond / (way * speed) if way * speed > 0.0 else low
            if not low < following < high:
                following = 0.5 * (low + high)
            if abs(following - t) <= 2.0 * _EPS * t or not low < following < high:
                return following
            t = following
        return t
