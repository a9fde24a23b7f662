"""The flight of a rigid piston under a constant force, a gas chamber and a drag, and its passages.

The distance x behind the wall obeys x″ + d x′ + κx = a. With s the answer to a unit velocity and q its integral,

    x = x₀ + v₀ s + (a − κx₀) q,   v = v₀ s′ + (a − κx₀) s,

which is a circle for κ > 0 and d = 0, an exponential for κ = 0 and d > 0, and a parabola for neither (theory, "The
machine that switches itself").

Functions are plain: interpreted for one piston, for which no compiler need be loaded, and compiled for many
(`cycle_kernels`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from percuss.mechanics.flow import response

PIECES = 3  # between later turning points a flight stays within the range of the third
STEPS = 200  # to a passage; halving alone takes fewer than 60
SHORTEST = 1e-300  # of the times that are tried, and doubled: a step of 0 would stay so
EPS = 2.0**-52

EDGE, WAY, READS, DEMANDED, DELAY = range(5)
"""Rows of the ports: the place or the speed of each, its direction (0: the blow demands), whether it is a speed, its
state, and its delay."""

STIFFNESS, DRAG, FACTOR = range(3)  # the law of a piston: of its chamber, drag and contact

NO_PORTS: list[list[float]] = [[], [], []]

Rows = Any  # a table of numbers: an array where it is compiled, lists where it is interpreted, which are quicker there


class PistonFlight(NamedTuple):
    """From x behind the wall with the velocity v away from it; `push` is a at the wall, `stiffness` κ, `drag` d."""

    push: float
    stiffness: float
    drag: float
    x: float
    v: float


def acceleration(flight: PistonFlight) -> float:
    """At the start, without the drag."""
    return flight.push - flight.stiffness * flight.x


def at(flight: PistonFlight, t: float) -> tuple[float, float]:
    """Distance and velocity at a time."""
    ds, s, q, _ = response(t, flight.stiffness, flight.drag)
    force, v = acceleration(flight), flight.v
    return flight.x + v * s + force * q, v * ds + force * s


def speed_at(flight: PistonFlight, place: float, way: int) -> float:
    """Velocity at a place that is passed this way without drag: from the energy, however far it went before."""
    more = (place - flight.x) * (2.0 * flight.push - flight.stiffness * (place + flight.x))
    return way * math.sqrt(max(0.0, flight.v * flight.v + more))


# ---- Where it turns


def turning_time(flight: PistonFlight) -> float:
    """When the velocity first is 0 after the start; infinite when it never is."""
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


def turning_step(flight: PistonFlight) -> float:
    """The time between two turning points."""
    square = flight.stiffness - 0.25 * flight.drag * flight.drag
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf


def next_turn(flight: PistonFlight, after: float) -> float:
    """When it next turns after a turn, infinite for never; 0 to begin with."""
    return turning_time(flight) if after == 0.0 else after + turning_step(flight)


def last_place(flight: PistonFlight) -> float:
    """Where it comes to rest or goes to in the end, when it does not oscillate for ever."""
    if flight.stiffness > 0.0:
        return flight.push / flight.stiffness
    if flight.push != 0.0:
        return math.copysign(math.inf, flight.push)
    if flight.drag > 0.0:
        return flight.x + flight.v / flight.drag
    return flight.x if flight.v == 0.0 else math.copysign(math.inf, flight.v)


def extremes(flight: PistonFlight, until: float) -> tuple[float, float]:
    """The least and the greatest distance from the wall up to a time, that at the end not looked at."""
    least, most, time = flight.x, flight.x, 0.0
    for _ in range(PIECES):
        time = next_turn(flight, time)
        if not time < until:
            break
        place = at(flight, time)[0]
        least, most = min(least, place), max(most, place)
    return least, most


def turning_places(flight: PistonFlight, until: float = math.inf) -> Iterator[float]:
    """Where it turns, up to a time: the first three, within which all others lie."""
    time = 0.0
    for _ in range(PIECES):
        time = next_turn(flight, time)
        if not time < until:
            return
        yield at(flight, time)[0]


# ---- Which place it passes first


def nearest_place(ports: Rows, reads: int, here: float, last: float, way: int) -> float:
    """The first of the wall and the ports on the way to a place, or of ports to a speed, NaN when there is none."""
    found, least = math.nan, way * (last - here)
    if way < 0 and 0.0 < here < least and reads == 0:
        found, least = 0.0, here
    for j in range(len(ports[WAY])):
        if ports[WAY][j] == way and ports[READS][j] == reads:
            ahead = way * (ports[EDGE][j] - here)
            if 0.0 < ahead < least:
                found, least = ports[EDGE][j], ahead
    return found


def first_crossing(flight: PistonFlight, ports: Rows, until: float) -> tuple[float, float, int, int]:
    """Time, place and direction of the first passage of the wall or of a port; direction 0 when there is none."""
    # The wall is passed towards it, −1, a port in its own direction. A place that is only touched, or at which the
    # flight starts, is not passed. The last: whether it is a speed that is passed, which moves as places do, without a
    # push.
    time, place, way = first_passage(flight, ports, 0, until)
    for j in range(len(ports[READS])):
        if ports[READS][j] != 0.0:
            rate = acceleration(flight) - flight.drag * flight.v
            of_speed = PistonFlight(0.0, flight.stiffness, flight.drag, flight.v, rate)
            earlier, speed, rises = first_passage(of_speed, ports, 1, time if way != 0 else until)
            return (earlier, speed, rises, 1) if rises != 0 else (time, place, way, 0)
    return time, place, way, 0


def first_passage(flight: PistonFlight, ports: Rows, reads: int, until: float) -> tuple[float, float, int]:
    """Of places alone, or of speeds in the flight of the speed."""
    start, here, end = 0.0, flight.x, 0.0
    for number in range(PIECES):
        end = next_turn(flight, end)
        stop = min(end, until)
        last = at(flight, stop)[0] if stop < math.inf else last_place(flight)
        way = 1 if last > here else -1
        place = nearest_place(ports, reads, here, last, way)
        if not math.isnan(place):
            return time_at(flight, place, way, number, start, stop), place, way
        if end >= until:
            break
        start, here = end, last
    return 0.0, 0.0, 0


def time_at(flight: PistonFlight, place: float, way: int, number: int, start: float, stop: float) -> float:
    """When a place is passed between two turning points: Newton's method between bounds, else halving."""
    if flight.stiffness == 0.0 and flight.drag == 0.0:
        speed = way * math.sqrt(max(0.0, flight.v * flight.v + 2.0 * flight.push * (place - flight.x)))
        return 2.0 * (place - flight.x) / (flight.v + speed) if number == 0 else (speed - flight.v) / flight.push
    x, v = at(flight, start)
    far, force = abs(place - x), abs(flight.push - flight.stiffness * x)
    step = min(far / abs(v) if v != 0.0 else math.inf, math.sqrt(far / force) if force != 0.0 else math.inf)
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
        if abs(following - t) <= 2.0 * EPS * t:  # before a bound is: rounding may put it on this side of the last one
            return following
        if not low < following < high:
            following = 0.5 * (low + high)
        if not low < following < high:
            return following
        t = following
    return t
