"""The flight of a rigid piston under a gas chamber and a drag, its force constant or with a ramp, and its passages.

The distance x behind the wall obeys x″ + d x′ + κx = a + jt. With s the answer to a unit velocity, q its integral and w
that of q,

    x = x₀ + v₀ s + (a − κx₀) q + jw,   v = v₀ s′ + (a − κx₀) s + jq,

which is a circle for κ > 0 and d = j = 0, an exponential for κ = 0 and d > 0, and a parabola for neither (theory, "The
machine that switches itself"). Functions are plain: interpreted for one piston, for which no compiler need be loaded,
and compiled for many (`cycle_kernels`), where those of a ramp have no part.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, takewhile
from typing import Any, NamedTuple

import numpy as np

from percuss.halting import look
from percuss.mechanics.flow import response, series
from percuss.model.checks import Array

PIECES = 3  # a flight between later turning points stays within the range of the third
STEPS = 200  # to a passage; halving alone takes fewer than 60
SHORTEST = 1e-300  # of the times that are tried, and doubled: a step of 0 would stay so
EPS = 2.0**-52

EDGE, WAY, DEMANDED, DELAY = range(4)
"""Rows of the ports: the place of each, its direction (0: the blow demands), its state, and its delay."""

NO_PORTS: list[list[float]] = [[], []]

Rows = Any
"""A table of numbers: an array where it is compiled, lists where it is interpreted, which are quicker there."""


class Flight(NamedTuple):
    """A flight from the distance x behind the wall with the velocity v away from it.

    Parameters
    ----------
    push
        Acceleration away from the wall at the wall, a.
    stiffness, drag
        κ and d.
    x, v
        At the start of the flight.
    ramp
        Growth of the push in time, j; with one the stiffness is above 0.
    """

    push: float
    stiffness: float
    drag: float
    x: float
    v: float
    ramp: float = 0.0


def acceleration(flight: Flight) -> float:
    """At the start, without the drag."""
    return flight.push - flight.stiffness * flight.x


def at(flight: Flight, t: float) -> tuple[float, float]:
    """Distance and velocity at a time."""
    ds, s, q, w = response(t, flight.stiffness, flight.drag)
    force, v, ramp = acceleration(flight), flight.v, flight.ramp
    return flight.x + v * s + force * q + ramp * w, v * ds + force * s + ramp * q


def distances(flight: Flight, times: Array) -> Array:
    """The distance at several times, in any order."""
    _, s, q, w = series(times, float(times.max(initial=0.0)), flight.stiffness, flight.drag)
    force = acceleration(flight)
    return np.asarray(flight.x + flight.v * s + force * q + flight.ramp * w)


def speed_at(flight: Flight, place: float, way: int) -> float:
    """Velocity at a place that is passed this way without drag: from the energy, however far it went before."""
    more = (place - flight.x) * (2.0 * flight.push - flight.stiffness * (place + flight.x))
    return way * math.sqrt(max(0.0, flight.v * flight.v + more))


def turning_time(flight: Flight) -> float:
    """When the velocity first is 0 after the start, under a constant force; infinite when it never is."""
    v, f = flight.v, acceleration(flight)
    below, square = 0.5 * v * flight.drag - f, flight.stiffness - 0.25 * flight.drag * flight.drag
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


def turning_step(flight: Flight) -> float:
    """The time between two turning points."""
    square = flight.stiffness - 0.25 * flight.drag * flight.drag
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf


def last_place(flight: Flight) -> float:
    """Where it comes to rest or goes to in the end, when it does not oscillate for ever."""
    if flight.ramp != 0.0:
        return math.copysign(math.inf, flight.ramp)
    if flight.stiffness > 0.0:
        return flight.push / flight.stiffness
    if flight.push != 0.0:
        return math.copysign(math.inf, flight.push)
    if flight.drag > 0.0:
        return flight.x + flight.v / flight.drag
    return flight.x if flight.v == 0.0 else math.copysign(math.inf, flight.v)


def farthest(flight: Flight, until: float) -> float:
    """The greatest distance from the wall up to a time, its end not looked at."""
    found, time, step = flight.x, turning_time(flight), turning_step(flight)
    for _ in range(PIECES):
        if not time < until:
            break
        found = max(found, at(flight, time)[0])
        time += step
    return found


def nearest_place(ports: Rows, here: float, last: float, way: int) -> float:
    """The first of the wall and the ports on the way to a place, NaN when there is none."""
    found, least = math.nan, way * (last - here)
    if way < 0 and 0.0 < here < least:
        found, least = 0.0, here
    for j in range(len(ports[WAY])):
        if ports[WAY][j] == way:
            ahead = way * (ports[EDGE][j] - here)
            if 0.0 < ahead < least:
                found, least = ports[EDGE][j], ahead
    return found


def first_crossing(flight: Flight, ports: Rows, until: float) -> tuple[float, float, int]:
    """Time, place and direction of the first passage of the wall or of a port; direction 0 when there is none.

    The wall is passed towards it, −1, a port in its own direction. A place that is only touched, or at which the flight
    starts, is not passed.
    """
    start, end, step, here = 0.0, turning_time(flight), turning_step(flight), flight.x
    for number in range(PIECES):
        stop = min(end, until)
        last = at(flight, stop)[0] if stop < math.inf else last_place(flight)
        way = 1 if last > here else -1
        place = nearest_place(ports, here, last, way)
        if not math.isnan(place):
            return time_at(flight, place, way, number, start, stop), place, way
        if end >= until:
            break
        start, end, here = end, end + step, last
    return 0.0, 0.0, 0


def time_at(flight: Flight, place: float, way: int, number: int, start: float, stop: float) -> float:
    """When a place is passed between two turning points: Newton's method between bounds, else halving."""
    if flight.stiffness == 0.0 and flight.drag == 0.0:
        speed = way * math.sqrt(max(0.0, flight.v * flight.v + 2.0 * flight.push * (place - flight.x)))
        return 2.0 * (place - flight.x) / (flight.v + speed) if number == 0 else (speed - flight.v) / flight.push
    x, v = at(flight, start)
    far, force = abs(place - x), abs(flight.push - flight.stiffness * x)
    step = min(far / abs(v) if v != 0.0 else math.inf, math.sqrt(far / force) if force != 0.0 else math.inf)
    step = 1.0 / math.sqrt(flight.stiffness) if step == math.inf else step  # at rest, until a ramp pushes
    step = max(step, SHORTEST)
    low, high = start, min(start + step, stop)  # the end may be far beyond the passage: a soft spring swings slowly
    while way * (at(flight, high)[0] - place) <= 0.0:
        if high >= stop:  # passed within rounding of the end
            return stop
        step *= 2.0
        low, high = high, min(start + step, stop)
    t = 0.5 * (low + high)
    for _ in range(STEPS):
        now, speed = at(flight, t)
        beyond = way * (now - place)
        if beyond == 0.0:
            return t
        if beyond < 0.0:
            low = t
        else:
            high = t
        following = t - beyond / (way * speed) if way * speed > 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - t) <= 2.0 * EPS * t or not low < following < high:
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


def ramped_crossing(flight: Flight, ports: Rows, until: float) -> tuple[float, float, int]:
    """As `first_crossing`, under a ramp."""
    here, done = flight.x, 0.0
    edges = [0.0, *(edge for edge, way in zip(ports[EDGE], ports[WAY], strict=True) if way != 0.0)]
    for number, (start, end) in enumerate(_pieces(flight, edges, until)):
        here = at(flight, start)[0] if start > done else here
        done, stop = end, min(end, until)
        last = at(flight, stop)[0] if math.isfinite(stop) else last_place(flight)
        way = 1 if last > here else -1
        place = nearest_place(ports, here, last, way)
        if not math.isnan(place):
            return time_at(flight, place, way, number, start, stop), place, way
        if end >= until:
            break
        here = last
    return 0.0, 0.0, 0


def turning_places(flight: Flight, until: float = math.inf) -> list[float]:
    """Where it turns, up to a time: without a ramp the first three, within which all others lie."""
    first, step = turning_time(flight), turning_step(flight)
    times: Iterable[float] = (first + n * step if n else first for n in range(PIECES))
    times = islice(times_at_speed(flight, 0.0), _MOST_TURNS) if flight.ramp != 0.0 else times
    return [at(flight, t)[0] for t in takewhile(lambda t: t < until, times)]


def times_at_speed(flight: Flight, speed: float, after: float = 0.0) -> Iterator[float]:
    """When the velocity under a ramp passes a value, in order, each time within rounding."""
    from scipy.optimize import brentq  # slow to import

    def beyond(t: float) -> float:
        return at(flight, t)[1] - speed

    start, low = after, beyond(after) if after else flight.v - speed
    for end in _turns_of_speed(flight, after):
        stop = _settled_after(flight, start, speed) if end == math.inf else end
        if stop is None:
            return
        high = beyond(stop)
        if low == 0.0:
            low = high
        elif (low < 0.0) != (high < 0.0):
            yield float(brentq(beyond, start, stop, xtol=EPS * stop, rtol=4.0 * EPS))
            low = high
        start = end
        if end == math.inf or abs(_drift(flight) - speed) > _swing(flight, end)[1]:
            return


def fastest(flight: Flight) -> float:
    """A bound of the speed under a ramp."""
    return abs(_drift(flight)) + _swing(flight, 0.0)[1]


def _drift(flight: Flight) -> float:
    """The velocity of the line about which it oscillates."""
    return flight.ramp / flight.stiffness


def _line(flight: Flight, time: float) -> float:
    return (flight.push + flight.ramp * time - flight.drag * _drift(flight)) / flight.stiffness


def _swing(flight: Flight, time: float) -> tuple[float, float]:
    """Bounds of the distance from the line, and of that of the velocity from the drift, from a time on."""
    x, v = at(flight, time)
    away, faster = x - _line(flight, time), v - _drift(flight)
    energy = math.sqrt(flight.stiffness * away * away + faster * faster)
    return energy / math.sqrt(flight.stiffness), energy


def _turns_of_speed(flight: Flight, after: float) -> Iterator[float]:
    """The times after another at which the acceleration is 0, then infinity where there are no more."""
    changing = acceleration(flight) - flight.drag * flight.v
    velocity = Flight(flight.ramp, flight.stiffness, flight.drag, flight.v, changing)
    end, step = turning_time(velocity), turning_step(velocity)
    if end < math.inf and step < math.inf and end <= after:
        end += math.ceil((after - end) / step + EPS) * step
    while True:
        look()
        if end > after:
            yield end
        if end == math.inf:
            return
        end += step


def _settled_after(flight: Flight, start: float, speed: float) -> float | None:
    """A time after which a velocity without further turns stays beyond a value, or None if it does not pass it."""
    now, then = at(flight, start)[1] - speed if start else flight.v - speed, _drift(flight) - speed
    if now * then >= 0.0:
        return None
    step = 1.0 / math.sqrt(flight.stiffness)
    while (at(flight, start + step)[1] - speed) * now > 0.0:
        step *= 2.0
    return start + step


def _pieces(flight: Flight, edges: Sequence[float], until: float) -> Iterator[tuple[float, float]]:
    """The times between which it does not turn, without some that are passed without any of the places."""
    start, turns, number = 0.0, times_at_speed(flight, 0.0), 0
    while True:
        end = next(turns, math.inf)
        yield start, end
        if end == math.inf:
            return
        start, number = end, number + 1
        if number % _BEFORE_LEAP == 0 and (leap := _idle(flight, start, edges, until)) > 0.0:
            if leap == math.inf:
                return
            start += leap
            turns = times_at_speed(flight, 0.0, after=start)


def _idle(flight: Flight, time: float, edges: Sequence[float], until: float) -> float:
    """For how long from a time on none of the places can be passed."""
    far, way = _swing(flight, time)[0], math.copysign(1.0, _drift(flight))
    ahead = [way * (edge - _line(flight, time)) for edge in edges]
    if any(-far <= distance <= far for distance in ahead):
        return 0.0
    next_one = min((distance for distance in ahead if distance > far), default=math.inf)
    idle: float = min((next_one - far) / abs(_drift(flight)), until - time)
    return idle * (1.0 - 1e-9)
