"""The flight of a rigid piston that draws from an accumulator: an affine force, and a ramp from the pump.

With the pressure π = π₀ + [qt + p(x − x₀)]/c the distance x behind the wall obeys, in a state of the force p,

    x″ + d x′ + (κ + p²/c) x = a − (pq/c) t,

an oscillation about a line. Its velocity is a flight under a constant force, the ramp: between two of that one's
turning points, which are closed, the velocity passes 0 once at most, and between two such times the piston passes a
place once at most (theory, "The machine that switches itself").
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice, takewhile

import numpy as np

from percuss.halting import look
from percuss.model.checks import Array
from percuss.steady.self_excited.piston_flight import Flight

__all__ = ["PressedFlight"]

_EPS = 2.0**-52
_MOST_TURNS = 4096  # that are looked at
_BEFORE_LEAP = 4  # pieces
_TERMS = 18
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
