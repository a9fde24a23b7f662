"""The flight of a rigid piston under a gas chamber and a drag, its force constant or with a ramp, and its passages.

The distance x behind the wall obeys x″ + d x′ + κx = a + jt. With s the answer to a unit velocity, q its integral and w
that of q,

    x = x₀ + v₀ s + (a − κx₀) q + jw,   v = v₀ s′ + (a − κx₀) s + jq,

which is a circle for κ > 0 and d = j = 0, an exponential for κ = 0 and d > 0, and a parabola for neither (theory, "The
machine that switches itself"). A piston that draws from an accumulator has a ramp, as its pump goes on: it oscillates
about a line, and its velocity is a flight under a constant force.

Functions are plain: interpreted for one piston, for which no compiler need be loaded, and compiled for many
(`cycle_kernels`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

from percuss.mechanics.flow import response

PIECES = 3  # without a ramp a flight between later turning points stays within the range of the third
BEFORE_LEAP = 4  # pieces under a ramp, after which those are passed over in which no place can be passed
MOST_TURNS = 4096  # that are looked at for the farthest one
STEPS = 200  # to a passage; halving alone takes fewer than 60
SHORTEST = 1e-300  # of the times that are tried, and doubled: a step of 0 would stay so
EPS = 2.0**-52

EDGE, WAY, DEMANDED, DELAY = range(4)
"""Rows of the ports: the place of each, its direction (0: the blow demands), its state, and its delay."""

STIFFNESS, DRAG, FACTOR, GAS, FLOW, COMPLIANCE, BEGINS = range(7)
"""The law of a piston: of its chamber, drag and contact, the chamber's force, and its supply, whose pressure begins so.

Without a supply the compliance is infinite, the flow 0 and the pressure 1.
"""

NO_PORTS: list[list[float]] = [[], []]

Rows = Any
"""A table of numbers: an array where it is compiled, lists where it is interpreted, which are quicker there."""


class PistonFlight(NamedTuple):
    """From the distance x behind the wall with the velocity v away from it; `push` is a, the acceleration at the wall.

    `stiffness` and `drag` are κ and d, `ramp` j is the growth of the push in time, with which the stiffness is above 0.
    """

    push: float
    stiffness: float
    drag: float
    x: float
    v: float
    ramp: float = 0.0


def acceleration(flight: PistonFlight) -> float:
    """At the start, without the drag."""
    return flight.push - flight.stiffness * flight.x


def at(flight: PistonFlight, t: float) -> tuple[float, float]:
    """Distance and velocity at a time."""
    ds, s, q, w = response(t, flight.stiffness, flight.drag)
    force, v, ramp = acceleration(flight), flight.v, flight.ramp
    return flight.x + v * s + force * q + ramp * w, v * ds + force * s + ramp * q


def speed_at(flight: PistonFlight, place: float, way: int) -> float:
    """Velocity at a place that is passed this way without drag: from the energy, however far it went before."""
    more = (place - flight.x) * (2.0 * flight.push - flight.stiffness * (place + flight.x))
    return way * math.sqrt(max(0.0, flight.v * flight.v + more))


# ---- Where it turns


def turning_time(flight: PistonFlight) -> float:
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


def turning_step(flight: PistonFlight) -> float:
    """The time between two turning points."""
    square = flight.stiffness - 0.25 * flight.drag * flight.drag
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf


def drift_of(flight: PistonFlight) -> float:
    """The velocity of the line about which it oscillates under a ramp."""
    return flight.ramp / flight.stiffness


def line_of(flight: PistonFlight, time: float) -> float:
    """Where that line is."""
    return (flight.push + flight.ramp * time - flight.drag * drift_of(flight)) / flight.stiffness


def swing_of(flight: PistonFlight, time: float) -> float:
    """A bound of how far the velocity is from the drift, under a ramp, from a time on."""
    x, v = at(flight, time)
    away, faster = x - line_of(flight, time), v - drift_of(flight)
    return math.sqrt(flight.stiffness * away * away + faster * faster)


def next_at_speed(flight: PistonFlight, speed: float, after: float) -> tuple[float, float]:
    """When the velocity under a ramp next is a value, infinite for never, and from when on to look for the time after.

    Between two turns of the velocity, which is a flight itself, it passes a value once at most; and not at all any more
    where it has turned on both sides without that, such as one that touches the value again and again.
    """
    if after == math.inf:
        return math.inf, math.inf
    changing = acceleration(flight) - flight.drag * flight.v
    velocity = PistonFlight(flight.ramp, flight.stiffness, flight.drag, flight.v, changing, 0.0)
    end, step, drift = turning_time(velocity), turning_step(velocity), drift_of(flight)
    if end <= after:
        end = end + math.ceil((after - end) / step + EPS) * step if step < math.inf else math.inf
    start, here = after, at(velocity, after)[0]
    for _ in range(PIECES):
        last = at(velocity, end)[0] if end < math.inf else drift
        way = 1 if last > here else -1
        if way * (speed - here) > 0.0 and way * (last - speed) > 0.0:
            return time_at(velocity, speed, way, 1, start, end), end
        if end == math.inf:
            break
        start, here, end = end, last, end + step
    return math.inf, math.inf


def next_turn(flight: PistonFlight, after: float) -> tuple[float, float]:
    """When it next turns, infinite for never, and from when on to look for the turn after; 0 to begin with."""
    if flight.ramp != 0.0:
        return next_at_speed(flight, 0.0, after)
    time = turning_time(flight) if after == 0.0 else after + turning_step(flight)
    return time, time


def last_place(flight: PistonFlight) -> float:
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


def extremes(flight: PistonFlight, until: float) -> tuple[float, float]:
    """The least and the greatest distance from the wall up to a time, that at the end not looked at."""
    least, most, after = flight.x, flight.x, 0.0
    for _ in range(PIECES if flight.ramp == 0.0 else MOST_TURNS):
        time, after = next_turn(flight, after)
        if not time < until:
            break
        place = at(flight, time)[0]
        least, most = min(least, place), max(most, place)
    return least, most


def turning_places(flight: PistonFlight, until: float = math.inf) -> Iterator[float]:
    """Where it turns, up to a time: without a ramp the first three, within which all others lie."""
    after = 0.0
    for _ in range(PIECES if flight.ramp == 0.0 else MOST_TURNS):
        time, after = next_turn(flight, after)
        if not time < until:
            return
        yield at(flight, time)[0]


# ---- Which place it passes first


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


def first_crossing(flight: PistonFlight, ports: Rows, until: float) -> tuple[float, float, int]:
    """Time, place and direction of the first passage of the wall or of a port; direction 0 when there is none.

    The wall is passed towards it, −1, a port in its own direction. A place that is only touched, or at which the flight
    starts, is not passed.
    """
    start, here, after, number = 0.0, flight.x, 0.0, 0
    while number < PIECES or flight.ramp != 0.0:
        end, after = next_turn(flight, after)
        stop = min(end, until)
        last = at(flight, stop)[0] if stop < math.inf else last_place(flight)
        way = 1 if last > here else -1
        place = nearest_place(ports, here, last, way)
        if not math.isnan(place):
            return time_at(flight, place, way, number, start, stop), place, way
        if end >= until:
            break
        start, here, number = end, last, number + 1
        if flight.ramp != 0.0 and number % BEFORE_LEAP == 0:
            leap = idle(flight, start, ports, until)
            if leap == math.inf:
                break
            if leap > 0.0:
                start = after = start + leap
                here = at(flight, start)[0]
    return 0.0, 0.0, 0


def idle(flight: PistonFlight, time: float, ports: Rows, until: float) -> float:
    """For how long from a time on no place can be passed under a ramp."""
    far, drift, line = swing_of(flight, time) / math.sqrt(flight.stiffness), drift_of(flight), line_of(flight, time)
    way, ahead = math.copysign(1.0, drift), math.inf
    for j in range(-1, len(ports[WAY])):
        if j < 0 or ports[WAY][j] != 0.0:
            distance = way * ((0.0 if j < 0 else ports[EDGE][j]) - line)
            if -far <= distance <= far:
                return 0.0
            ahead = min(ahead, distance - far) if distance > far else ahead
    return min(ahead / abs(drift), until - time) * (1.0 - 1e-9)


def time_at(flight: PistonFlight, place: float, way: int, number: int, start: float, stop: float) -> float:
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


# ---- The pressure of a supply while a piston draws from it: of a state's force p at the pressure 1, π′ = (q + pv)/c


def pressure_range(
    flight: PistonFlight, duration: float, pressure: float, bare: float, law: Rows
) -> tuple[float, float]:
    """The least and the greatest pressure of a flight that begins at one: at its ends, or where π′ is 0."""
    least = most = pressure
    if flight.ramp != 0.0:
        time, after, speed = 0.0, 0.0, -law[FLOW] / bare
        while after < duration:
            time, after = next_at_speed(flight, speed, after)
            now = pressure_at(flight, min(time, duration), pressure, bare, law)
            least, most = min(least, now), max(most, now)
    now = pressure_at(flight, duration, pressure, bare, law)
    return min(least, now), max(most, now)


def pressure_at(flight: PistonFlight, t: float, pressure: float, bare: float, law: Rows) -> float:
    """The pressure at a time of a flight."""
    came: float = at(flight, t)[0] - flight.x
    more: float = (law[FLOW] * t + bare * came) / law[COMPLIANCE]
    return pressure + more
