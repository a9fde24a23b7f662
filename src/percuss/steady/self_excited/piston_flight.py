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
from functools import cached_property
from itertools import islice, takewhile
from typing import Any

import numpy as np

from percuss.halting import look
from percuss.model.checks import Array

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
    return responses(t, t, stiffness, drag)


def responses(t: Any, longest: float, stiffness: float, drag: float) -> tuple[Any, Any, Any]:
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

    def speed_at(self, place: float, way: int) -> float:
        """Velocity at a place that is passed this way without drag: from the energy, however far it went before."""
        more = (place - self.x) * (2.0 * self.push - self.stiffness * (place + self.x))
        return way * math.sqrt(max(0.0, self.v * self.v + more))

    def distances(self, times: Array) -> Array:
        """The distance at several times, in any order."""
        _, s, q = responses(times, float(times.max(initial=0.0)), self.stiffness, self.drag)
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


# ---- The flight of a rigid piston that draws from an accumulator: an affine force, and a ramp from the pump
#
# With the pressure π = π₀ + [qt + p(x − x₀)]/c the distance x behind the wall obeys, in a state of the force p,
#
#     x″ + d x′ + (κ + p²/c) x = a − (pq/c) t,
#
# an oscillation about a line. Its velocity is a flight under a constant force, the ramp: between two of that one's
# turning points, which are closed, the velocity passes 0 once at most, and between two such times the piston passes a
# place once at most (theory, "The machine that switches itself").

_MOST_TURNS = 4096  # that are looked at
_BEFORE_LEAP = 4  # pieces
_SHORT = 0.5  # square of the phase up to which the series are taken


@dataclass(frozen=True)
class PressedFlight(Flight):
    """A flight under a force that changes with the place and with time.

    Parameters
    ----------
    ramp
        Growth of the push in time; not 0, and with a stiffness above 0.
    """

    ramp: float

    def push_at(self, t: float) -> float:
        """Acceleration away from the wall at the wall, at a time."""
        return self.push + self.ramp * t

    def at(self, t: float) -> tuple[float, float]:
        """Distance and velocity at a time."""
        ds, s, q, w = self.response(t)
        push = self.acceleration
        return self.x + self.v * s + push * q + self.ramp * w, self.v * ds + push * s + self.ramp * q

    def distances(self, times: Array) -> Array:
        """The distance at several times, in any order."""
        return np.array([self.at(float(t))[0] for t in times.flat]).reshape(times.shape)

    def response(self, t: float) -> tuple[float, float, float, float]:
        """s′, s and q, and w, the place under a unit ramp: by sine and cosine where nothing cancels, else by series."""
        stiffness, drag = self.stiffness, self.drag
        if stiffness * t * t < _SHORT or drag * drag > stiffness:
            return _by_series(t, stiffness, drag)
        rate, fade = self._rate, math.exp(-0.5 * drag * t)
        s = fade * math.sin(rate * t) / rate
        ds = fade * math.cos(rate * t) - 0.5 * drag * s
        q = (1.0 - ds - drag * s) / stiffness
        return ds, s, q, (t - s - drag * q) / stiffness

    @property
    def turning_time(self) -> float:
        """When the velocity first is 0 after the start; infinite when it never is."""
        return next(self.times_at_speed(0.0), math.inf)

    @property
    def last_place(self) -> float:
        """Where it goes to in the end: with the pump."""
        return math.copysign(math.inf, self.ramp)

    def turning_places(self, until: float = math.inf) -> list[float]:
        """Where it turns, up to a time."""
        times = takewhile(lambda t: t < until, self.times_at_speed(0.0))
        return [self.at(t)[0] for t in islice(times, _MOST_TURNS)]

    def times_at_speed(self, speed: float, after: float = 0.0) -> Iterator[float]:
        """When the velocity passes a value, in order, each time within rounding."""
        from scipy.optimize import brentq  # slow to import

        def beyond(t: float) -> float:
            return self.at(t)[1] - speed

        start, low = after, beyond(after) if after else self.v - speed
        for end in self._turns_of_speed(after):
            stop = self._settled_after(start, speed) if end == math.inf else end
            if stop is None:
                return
            high = beyond(stop)
            if low == 0.0:
                low = high
            elif (low < 0.0) != (high < 0.0):
                yield float(brentq(beyond, start, stop, xtol=_EPS * stop, rtol=4.0 * _EPS))
                low = high
            start = end
            if not self._swings(end, speed):
                return

    @property
    def fastest(self) -> float:
        """A bound of its speed."""
        return abs(self._drift) + self._swing(0.0)[1]

    # -- the parts --

    @cached_property
    def _speed(self) -> Flight:
        """The velocity as a flight under a constant force."""
        return Flight(self.ramp, self.stiffness, self.drag, self.v, self.acceleration - self.drag * self.v)

    @property
    def _drift(self) -> float:
        """The velocity of the line about which it oscillates."""
        return self.ramp / self.stiffness

    @cached_property
    def _rate(self) -> float:
        """Of the oscillation; 0 where there is none."""
        return math.sqrt(max(self.stiffness - 0.25 * self.drag**2, 0.0))

    def _turns_of_speed(self, after: float) -> Iterator[float]:
        """The times after another at which the acceleration is 0, then infinity where there are no more."""
        end, rate = self._speed.turning_time, self._rate
        if end < math.inf and rate > 0.0 and end <= after:
            end += math.ceil((after - end) / (math.pi / rate) + _EPS) * math.pi / rate
        while True:
            look()
            if end > after:
                yield end
            if end == math.inf:
                return
            end = end + math.pi / rate if rate > 0.0 else math.inf

    def _settled_after(self, start: float, speed: float) -> float | None:
        """A time after which a velocity without further turns stays beyond a value, or None if it does not pass it."""
        now, then = self.at(start)[1] - speed if start else self.v - speed, self._drift - speed
        if now * then >= 0.0:
            return None
        step = 1.0 / math.sqrt(self.stiffness)
        while (self.at(start + step)[1] - speed) * now > 0.0:
            step *= 2.0
        return start + step

    def _swings(self, time: float, speed: float) -> bool:
        """Whether the velocity may still pass a value after a time."""
        return time < math.inf and abs(self._drift - speed) <= self._swing(time)[1]

    def _swing(self, time: float) -> tuple[float, float]:
        """Bounds of the distance from the line, and of that of the velocity from the drift, from a time on."""
        x, v = self.at(time)
        away, faster = x - self._line(time), v - self._drift
        energy = math.sqrt(self.stiffness * away * away + faster * faster)
        return energy / math.sqrt(self.stiffness), energy

    def _line(self, time: float) -> float:
        return (self.push + self.ramp * time - self.drag * self._drift) / self.stiffness

    def _pieces(self, places: Sequence[tuple[float, int]], until: float) -> Iterator[tuple[float, float]]:
        """The times between which it does not turn, without some that are passed without any of the places."""
        start, turns, number = 0.0, self.times_at_speed(0.0), 0
        while True:
            end = next(turns, math.inf)
            yield start, end
            if end == math.inf:
                return
            start, number = end, number + 1
            if number % _BEFORE_LEAP == 0 and (leap := self._idle(start, places, until)) > 0.0:
                if leap == math.inf:
                    return
                start += leap
                turns = self.times_at_speed(0.0, after=start)

    def _idle(self, time: float, places: Sequence[tuple[float, int]], until: float) -> float:
        """For how long from a time on none of the places can be passed."""
        far, way = self._swing(time)[0], math.copysign(1.0, self._drift)
        ahead = [way * (place - self._line(time)) for place, _ in places]
        if any(-far <= distance <= far for distance in ahead):
            return 0.0
        next_one = min((distance for distance in ahead if distance > far), default=math.inf)
        idle: float = min((next_one - far) / abs(self._drift), until - time)
        return idle * (1.0 - 1e-9)


def _by_series(t: float, stiffness: float, drag: float) -> tuple[float, float, float, float]:
    """s′, s, q and w by power series, and by doubling the time."""
    doublings = 0
    while stiffness * t * t > _SHORT or drag * t > _SHORT:
        t *= 0.5
        doublings += 1
    z, b = stiffness * t * t, drag * t
    before, now = 0.0, 1.0  # coefficients of the series of s(t)/t, one after the other
    ds, s, q, w = 1.0, 1.0, 0.5, 1.0 / 6.0
    for n in range(1, _TERMS):
        before, now = now, -(b * n * now + z * before) / (n * (n + 1))
        ds += (n + 1) * now
        s += now
        q += now / (n + 2)
        w += now / ((n + 2) * (n + 3))
    s, q, w = s * t, q * t * t, w * t * t * t
    for _ in range(doublings):
        w, t = 2.0 * w + q * s + (t - stiffness * w) * q, 2.0 * t
        ds, s, q = ds * ds - stiffness * s * s, s * (1.0 - stiffness * q + ds), 2.0 * q + s * s - stiffness * q * q
    return ds, s, q, w
