"""A rigid piston under its valve from one blow to the next: closed flights, and their derivatives.

A leg carries, besides place, velocity and time of the piston, their derivatives by the speed just after the blow at
which it began, by the times of the orders that were pending there, and by the pressure of a supply there (theory, "The
machine that switches itself").
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from percuss.halting import look
from percuss.model import Contact, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.piston_flight import Flight, PressedFlight, response

# ---- What a rigid piston under a valve is, and the records of its way from blow to blow

_LEAST = 1e-100  # a stiffness or a drag below it is none: its times would overflow
_REBOUND = 1e-16  # a smaller part of the speed is no rebound: beside a wall it would fly no distance that numbers hold

Ending = Literal["blow", "on the wall", "nothing follows", "no blow", "no pressure"]
"""How a leg ends."""


@dataclass(frozen=True)
class Piston:
    """A rigid piston: its valve, how it leaves the wall, and its drag d."""

    valve: Valve
    contact: Contact
    drag: float

    def flight(self, state: str, x: float, v: float, pressure: float = 1.0) -> Flight:
        """The flight that begins at the distance x with the velocity v away from the wall."""
        chamber, supply, drag = self.valve.chamber, self.valve.supply, _felt(self.drag)
        if supply is None:
            return Flight(-self.valve.force(state), _felt(chamber.stiffness), drag, x, v)
        force, c = self.valve.force(state) - chamber.force, supply.compliance
        push, spring = -(pressure * force + chamber.force), force * force / c
        if _felt(spring) == 0.0 or force * supply.flow / c == 0.0:
            return Flight(push, _felt(chamber.stiffness), drag, x, v)
        return PressedFlight(push + spring * x, chamber.stiffness + spring, drag, x, v, -force * supply.flow / c)

    def after(self, rebound: Rebound) -> Flight:
        """The flight that a rebound begins."""
        return self.flight(rebound.state, 0.0, rebound.speed, 1.0 if rebound.pressure is None else rebound.pressure)

    @property
    def gas(self) -> float:
        """Stiffness of the chamber, as flights have it."""
        return _felt(self.valve.chamber.stiffness)

    def drawing(self, state: str) -> float:
        """The force of a state at the pressure 1, with which the piston draws from the supply; 0 without one."""
        return 0.0 if self.valve.supply is None else self.valve.force(state) - self.valve.chamber.force

    @property
    def factor(self) -> float:
        """Velocity just after a blow over that just before it."""
        factor = self.contact.velocity_factor
        return factor if abs(factor) >= _REBOUND else 0.0

    @property
    def places(self) -> tuple[list[tuple[float, int]], list[int]]:
        """The wall and the edges of the ports, each with the direction in which it is passed; the ports' numbers."""
        passed = [
            (i, (port.behind, 1 if port.side == "back" else -1))
            for i, port in enumerate(self.valve.ports)
            if port.behind is not None
        ]
        return [(0.0, -1), *(place for _, place in passed)], [i for i, _ in passed]


@dataclass(frozen=True)
class Rebound:
    """The piston just after a blow, before the blow demands anything; the time of the blow is 0.

    Parameters
    ----------
    speed
        Away from the wall.
    state
        Of the valve.
    orders
        What was demanded last, and what is pending.
    pressure
        Of the supply; None where it is constant.
    """

    speed: float
    state: str
    orders: Orders
    pressure: float | None = None

    @property
    def label(self) -> tuple[object, ...]:
        """What cannot change continuously."""
        return self.state, self.orders.last, tuple(to for _, to in self.orders.pending)

    @property
    def numbers(self) -> Array:
        """What can: the speed, when the pending orders are due, and the pressure of a supply."""
        pressure = [] if self.pressure is None else [self.pressure]
        return np.array([self.speed, *(due for due, _ in self.orders.pending), *pressure])

    def with_numbers(self, numbers: Array) -> Rebound:
        """The same with other numbers."""
        speed, *dues = (float(value) for value in numbers)
        pressure = None if self.pressure is None else dues.pop()
        pending = tuple((due, to) for due, (_, to) in zip(dues, self.orders.pending, strict=True))
        return Rebound(speed, self.state, replace(self.orders, pending=pending), pressure)


@dataclass(frozen=True)
class Segment:
    """A stretch of a leg without an event: its state, when it begins, how long it lasts, where it ends.

    `pressure` is that of the supply when it begins.
    """

    state: str
    time: float
    duration: float
    flight: Flight
    behind: float
    velocity: float
    pressure: float = 1.0


@dataclass(frozen=True)
class Switch:
    """A change of the valve's state.

    Attributes
    ----------
    time
        After the blow that begins the cycle.
    to
        The new state.
    behind, velocity
        Of the piston: distance behind the wall, and velocity away from it.
    work
        Rise of the force times that distance, per unit of mass: what the switch puts into the motion.
    """

    time: float
    to: str
    behind: float
    velocity: float
    work: float


@dataclass(frozen=True)
class Uncovering:
    """A port demands a state: its number, the time after the blow, and the velocity away from the wall."""

    port: int
    time: float
    velocity: float


@dataclass(frozen=True)
class Leg:
    """From just after one blow to just after the next one, or to where nothing follows.

    Parameters
    ----------
    ending
        How it ends.
    duration, blow_speed
        Time to the end of the leg, and speed just before the blow there.
    rebound
        The piston just after that blow; None without one.
    slope
        Derivative of the numbers of that rebound by those of the one that the leg began with.
    segments, switches, uncoverings
        What happens in between, in order.
    dropped
        Whether a demand replaced an order that was pending.
    """

    ending: Ending
    duration: float
    blow_speed: float
    rebound: Rebound | None
    slope: Array
    segments: tuple[Segment, ...]
    switches: tuple[Switch, ...]
    uncoverings: tuple[Uncovering, ...]
    dropped: bool

    @property
    def farthest(self) -> float:
        """The greatest distance from the wall."""
        turns = (s.flight.turning_places(s.duration) for s in self.segments)
        return max(
            (max([s.flight.x, s.behind, *own]) for s, own in zip(self.segments, turns, strict=True)), default=0.0
        )


def _felt(coefficient: float) -> float:
    return coefficient if coefficient >= _LEAST else 0.0


# ---- The pressure of a supply over a flight of the piston that draws from it


def pressure_at(segment: Segment, piston: Piston, t: float) -> float:
    """The pressure at a time after the begin of a segment."""
    supply = piston.valve.supply
    assert supply is not None
    came = segment.flight.at(t)[0] - segment.flight.x
    return segment.pressure + (supply.flow * t + piston.drawing(segment.state) * came) / supply.compliance


def pressure_extremes(segment: Segment, piston: Piston) -> tuple[float, float]:
    """The least and the greatest pressure of a segment: at its ends, or where the piston draws what the pump gives."""
    times = [0.0, segment.duration]
    drawing, supply = piston.drawing(segment.state), piston.valve.supply
    assert supply is not None
    if isinstance(segment.flight, PressedFlight):
        for time in segment.flight.times_at_speed(-supply.flow / drawing):
            if time >= segment.duration:
                break
            times.append(time)
    found = [pressure_at(segment, piston, t) for t in times]
    return min(found), max(found)


def lowest_pressure(segment: Segment, piston: Piston) -> float:
    """The least pressure of a segment; a lower bound of it where that is above 0."""
    supply, drawing = piston.valve.supply, piston.drawing(segment.state)
    assert supply is not None
    if not isinstance(segment.flight, PressedFlight):
        return segment.pressure
    way = segment.flight.x if drawing > 0.0 else segment.duration * segment.flight.fastest
    least = segment.pressure - abs(drawing) * way / supply.compliance
    return least if least > 0.0 else pressure_extremes(segment, piston)[0]


def pressure_integral(segment: Segment, piston: Piston) -> float:
    """The integral of the pressure over a segment, by that of the equation of motion."""
    supply, t, flight = piston.valve.supply, segment.duration, segment.flight
    assert supply is not None
    found = segment.pressure * t + 0.5 * supply.flow * t * t / supply.compliance
    if not isinstance(flight, PressedFlight):
        return found
    came, faster = segment.behind - flight.x, segment.velocity - flight.v
    way = (flight.acceleration * t + 0.5 * flight.ramp * t * t - faster - flight.drag * came) / flight.stiffness
    return found + piston.drawing(segment.state) / supply.compliance * way


# ---- A rigid piston under its valve from one blow to the next: closed flights, and their derivatives

_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_MOST_EVENTS = 400  # of a leg
_STILL = 1e-150  # a speed whose square, and so the height of its flight from the wall, is hardly a number


def leg_after(piston: Piston, rebound: Rebound) -> Leg:
    """The leg that a rebound begins; the blow demands first."""
    going = _Going(piston, 0.0, rebound.speed, rebound.state, rebound.orders, rebound.pressure)
    for i, port in enumerate(piston.valve.ports):
        if port.on == "impact":
            going.demand(i)
    return going.leg()


def leg_from(piston: Piston, behind: float, velocity: float) -> Leg:
    """The leg that begins at a distance from the wall, with the valve in its starting state."""
    valve = piston.valve
    begins = None if valve.supply is None else valve.supply.start
    going = _Going(piston, behind, velocity, valve.orders.last, valve.orders, begins)
    outwards = velocity > 0.0 or (velocity == 0.0 and going.flight.acceleration > 0.0)
    for i, port in enumerate(valve.ports):
        if port.behind is not None:
            inside = behind > port.behind or (behind == port.behind and outwards)
            if inside == (port.side == "back"):
                going.demand(i)
    return going.leg()


class _Going:
    """The piston on its way, with all derivatives."""

    def __init__(self, piston: Piston, x: float, v: float, state: str, orders: Orders, pressure: float | None) -> None:
        self.piston, self.x, self.v, self.state, self.orders = piston, x, v, state, orders
        self.supply, self.pressure = piston.valve.supply, 1.0 if pressure is None else pressure
        self.places, self.ports = piston.places
        self.time = 0.0
        waiting = len(orders.pending)
        unit = np.eye(1 + waiting + (self.supply is not None))
        self.slope_x, self.slope_v, self.slope_time = 0.0 * unit[0], unit[0], 0.0 * unit[0]
        self.slopes = dict(zip(orders.pending, unit[1 : 1 + waiting], strict=True))
        self.slope_pressure = 0.0 * unit[0] if self.supply is None else unit[-1]
        self.segments: list[Segment] = []
        self.switches: list[Switch] = []
        self.uncoverings: list[Uncovering] = []
        self.dropped = False

    @property
    def flight(self) -> Flight:
        """What begins here."""
        return self.piston.flight(self.state, self.x, self.v, self.pressure)

    def demand(self, number: int) -> None:
        """A port demands its state."""
        port = self.piston.valve.ports[number]
        before, self.orders = self.orders, self.orders.after(self.time, port)
        if self.orders is before:
            return
        self.dropped |= len(self.orders.pending) <= len(before.pending)
        self.slopes[self.orders.pending[-1]] = self.slope_time
        if port.on == "entering":
            self.uncoverings.append(Uncovering(number, self.time, self.v))
        self._carry_out()

    def leg(self) -> Leg:
        """Goes on to the next blow."""
        look()
        for _ in range(_MOST_EVENTS):
            self._carry_out()
            until = self.orders.pending[0][0] - self.time if self.orders.pending else math.inf
            flight = self.flight
            still = self.x == 0.0 and 0.0 <= self.v <= _STILL and flight.push <= 0.0
            if still and (lifted := _lifted(flight)) > 0.0:
                if until == lifted == math.inf:
                    return self._ended("on the wall")
                self._rest(flight, until, lifted)
                continue
            found = flight.first_crossing(self.places, until * (1.0 + _TOGETHER))
            if found is None and until == math.inf:
                self.segments.append(
                    Segment(self.state, self.time, math.inf, flight, flight.last_place, 0.0, self.pressure)
                )
                return self._ended("nothing follows")
            place = None if found is None else self.places[found.which[0]]
            self._fly(flight, until if found is None else found.time, place)
            if self.supply is not None and lowest_pressure(self.segments[-1], self.piston) < 0.0:
                return self._ended("no pressure")
            if found is not None and found.which[0] == 0:
                return self._struck()
            for which in () if found is None else found.which:
                self.demand(self.ports[which - 1])
        return self._ended("no blow")

    def _carry_out(self) -> None:
        """Changes the state by the orders that are due."""
        while self.orders.pending and self.orders.pending[0][0] <= self.time:
            (_, to), *left = self.orders.pending
            valve = self.piston.valve
            work = self.pressure * (valve.force(to) - valve.force(self.state)) * self.x
            self.switches.append(Switch(self.time, to, self.x, self.v, work))
            self.state, self.orders = to, replace(self.orders, pending=tuple(left))

    def _rest(self, flight: Flight, until: float, lifted: float) -> None:
        """Lies on the wall until the next order is due or a growing pressure lifts it, and forgets what was before."""
        duration, still = min(until, lifted), replace(flight, push=0.0, stiffness=0.0)
        if isinstance(flight, PressedFlight):
            still = Flight(0.0, 0.0, flight.drag, 0.0, 0.0)
        self.segments.append(Segment(self.state, self.time, duration, still, 0.0, 0.0, self.pressure))
        growth = 0.0 if self.supply is None else self.supply.flow / self.supply.compliance
        self.pressure += growth * duration
        if until <= lifted:
            due = self.orders.pending[0]
            self.time, before, self.slope_time = due[0], self.slope_time, self.slopes[due]
            self.slope_pressure = self.slope_pressure + growth * (self.slope_time - before)
        else:
            self.time, self.slope_time = self.time + duration, self.slope_time - self.slope_pressure / growth
            self.slope_pressure = 0.0 * self.slope_pressure
            self._lift()
        self.slope_x, self.slope_v = 0.0 * self.slope_x, 0.0 * self.slope_v

    def _lift(self) -> None:
        """The pressure at which nothing pushes to the wall any more, or just above it by rounding."""
        while self.flight.push < 0.0:
            self.pressure = math.nextafter(self.pressure, math.inf)

    def _fly(self, flight: Flight, duration: float, place: tuple[float, int] | None) -> None:
        """To the place, passed in a direction, or, with none, to when the next order is due."""
        x, v = flight.at(duration)
        ds, s, q = response(duration, flight.stiffness, flight.drag)
        gas, drawing = self.piston.gas, self.piston.drawing(self.state)
        slope_x = (1.0 - gas * q) * self.slope_x + s * self.slope_v - drawing * q * self.slope_pressure
        slope_v = -gas * s * self.slope_x + ds * self.slope_v - drawing * s * self.slope_pressure
        if place is None:
            due = self.orders.pending[0]
            longer = self.slopes[due] - self.slope_time
            self.time = due[0]
        else:
            x = place[0]
            v = flight.speed_at(*place) if flight.drag == 0.0 and self.supply is None else v
            longer = -slope_x / (v or math.inf)
            self.time += duration
        acceleration = flight.push_at(duration) - flight.stiffness * x - flight.drag * v
        began, came, pressure = self.time - duration, x - self.x, self.pressure
        if self.supply is not None:
            c, flow = self.supply.compliance, self.supply.flow
            self.pressure += (flow * duration + drawing * came) / c
            grown = (slope_x - self.slope_x) * drawing / c
            self.slope_pressure = self.slope_pressure + grown + (flow + drawing * v) / c * longer
        self.x, self.v = x, v
        with np.errstate(over="ignore", invalid="ignore"):  # beside a grazing they have no bound
            self.slope_x, self.slope_v = slope_x + v * longer, slope_v + acceleration * longer
        self.slope_time = self.slope_time + longer
        self.segments.append(Segment(self.state, began, duration, flight, x, v, pressure))

    def _struck(self) -> Leg:
        factor = self.piston.factor
        pending = tuple((due - self.time, to) for due, to in self.orders.pending)
        pressure = None if self.supply is None else self.pressure
        rebound = Rebound(factor * self.v, self.state, replace(self.orders, pending=pending), pressure)
        rows = [factor * self.slope_v, *(self.slopes[order] - self.slope_time for order in self.orders.pending)]
        if self.supply is not None:
            rows.append(self.slope_pressure)
        return self._ended("blow", rebound, np.array(rows))

    def _ended(self, ending: Ending, rebound: Rebound | None = None, slope: Array | None = None) -> Leg:
        happened = tuple(self.segments), tuple(self.switches), tuple(self.uncoverings)
        speed = -self.v if rebound is not None else math.nan
        slope = np.empty((0, 0)) if slope is None else slope
        return Leg(ending, self.time, speed, rebound, slope, *happened, self.dropped)


def _lifted(flight: Flight) -> float:
    """When the growing pressure lifts a piston off the wall on which it lies; infinite when it does not."""
    if not isinstance(flight, PressedFlight) or flight.ramp <= 0.0:
        return math.inf
    return -flight.push / flight.ramp
