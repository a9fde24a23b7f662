"""A rigid piston under its valve from one blow to the next: closed flights, and their derivatives.

A leg carries, besides place, velocity and time of the piston, their derivatives by the speed just after the blow at
which it began, by the times of the orders that were pending there, and by the pressure of a supply there (theory, "The
machine that switches itself").
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from percuss.halting import look
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.piston_flight import Flight, response
from percuss.steady.self_excited.piston_records import Ending, Leg, Piston, Rebound, Segment, Switch, Uncovering
from percuss.steady.self_excited.pressed_flight import PressedFlight
from percuss.steady.self_excited.supply_course import lowest_pressure

__all__ = ["leg_after", "leg_from"]

_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_MOST_EVENTS = 400  # of a leg


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
            if self.x == 0.0 and self.v == 0.0 and flight.push <= 0.0 and (lifted := _lifted(flight)) > 0.0:
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
            place = None if found is None else self.places[found.which[0]][0]
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

    def _fly(self, flight: Flight, duration: float, place: float | None) -> None:
        """To the place, or, with none, to when the next order is due."""
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
            longer = -slope_x / (v or math.inf)
            x = place
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
        factor = self.piston.contact.velocity_factor
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
