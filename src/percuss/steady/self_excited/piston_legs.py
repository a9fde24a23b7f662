"""A rigid piston under its valve from one blow to the next: what it is, and the records of its way."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from percuss.halting import look
from percuss.model import Contact, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.piston_flight import Flight, at, fastest, times_at_speed, turning_places

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
        return Flight(push + spring * x, chamber.stiffness + spring, drag, x, v, -force * supply.flow / c)

    def after(self, rebound: Rebound) -> Flight:
        """The flight that a rebound begins."""
        return self.flight(rebound.state, 0.0, rebound.speed, 1.0 if rebound.pressure is None else rebound.pressure)

    def drawing(self, state: str) -> float:
        """The force of a state at the pressure 1, with which the piston draws from the supply; 0 without one."""
        return 0.0 if self.valve.supply is None else self.valve.force(state) - self.valve.chamber.force

    @property
    def factor(self) -> float:
        """Velocity just after a blow over that just before it."""
        factor = self.contact.velocity_factor
        return factor if abs(factor) >= _REBOUND else 0.0

    @cached_property
    def numbers(self) -> tuple[list[float], list[list[float]], list[float], Drawing | None]:
        """Forces of the states, ports, law and supply as `piston_kernels` have them."""
        valve, ways = self.valve, {"back": 1.0, "front": -1.0, None: 0.0}
        number = {name: float(i) for i, (name, _) in enumerate(valve.pairs)}
        ports = [(port.behind or 0.0, ways[port.side], number[port.to], port.delay) for port in valve.ports]
        law = [_felt(valve.chamber.stiffness), _felt(self.drag), self.factor]
        supply = None if valve.supply is None else Drawing(self)
        return [valve.force(name) for name in number], [list(row) for row in zip(*ports, strict=True)], law, supply


class Drawing:
    """The supply of a piston, as `piston_kernels` ask it; states by their numbers."""

    def __init__(self, piston: Piston) -> None:
        supply = piston.valve.supply
        assert supply is not None
        self.piston, self.states = piston, [name for name, _ in piston.valve.pairs]
        self.flow, self.compliance = supply.flow, supply.compliance
        self.drawing = [piston.drawing(state) for state in self.states]

    def flight(self, state: int, x: float, v: float, pressure: float) -> Flight:
        """The flight that begins in a state."""
        return self.piston.flight(self.states[state], x, v, pressure)

    def lowest(self, flight: Flight, duration: float, pressure: float, state: int) -> float:
        """The least pressure in a flight; a lower bound of it where that is above 0."""
        drawing = self.drawing[state]
        if flight.ramp == 0.0:
            return pressure
        way = flight.x if drawing > 0.0 else duration * fastest(flight)
        least = pressure - abs(drawing) * way / self.compliance
        segment = Segment(self.states[state], 0.0, duration, flight, 0.0, 0.0, pressure)
        return least if least > 0.0 else pressure_extremes(segment, self.piston)[0]


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
        turns = (turning_places(s.flight, s.duration) for s in self.segments)
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
    came = at(segment.flight, t)[0] - segment.flight.x
    return segment.pressure + (supply.flow * t + piston.drawing(segment.state) * came) / supply.compliance


def pressure_extremes(segment: Segment, piston: Piston) -> tuple[float, float]:
    """The least and the greatest pressure of a segment: at its ends, or where the piston draws what the pump gives."""
    times = [0.0, segment.duration]
    drawing, supply = piston.drawing(segment.state), piston.valve.supply
    assert supply is not None
    if segment.flight.ramp != 0.0:
        for time in times_at_speed(segment.flight, -supply.flow / drawing):
            if time >= segment.duration:
                break
            times.append(time)
    found = [pressure_at(segment, piston, t) for t in times]
    return min(found), max(found)


def pressure_integral(segment: Segment, piston: Piston) -> float:
    """The integral of the pressure over a segment, by that of the equation of motion."""
    supply, t, flight = piston.valve.supply, segment.duration, segment.flight
    assert supply is not None
    found = segment.pressure * t + 0.5 * supply.flow * t * t / supply.compliance
    if flight.ramp == 0.0:
        return found
    came, faster = segment.behind - flight.x, segment.velocity - flight.v
    way = (
        (flight.push - flight.stiffness * flight.x) * t + 0.5 * flight.ramp * t * t - faster - flight.drag * came
    ) / flight.stiffness
    return found + piston.drawing(segment.state) / supply.compliance * way


# ---- The leg that follows a rebound or a start

_ENDINGS: tuple[Ending, ...] = ("blow", "on the wall", "nothing follows", "no blow", "no pressure")
"""By the numbers of `piston_kernels`."""


def leg_after(piston: Piston, rebound: Rebound) -> Leg:
    """The leg that a rebound begins; the blow demands first."""
    return _leg(piston, 0.0, rebound, False)


def leg_from(piston: Piston, behind: float, velocity: float) -> Leg:
    """The leg that begins at a distance from the wall, with the valve in its starting state."""
    valve = piston.valve
    begins = None if valve.supply is None else valve.supply.start
    return _leg(piston, behind, Rebound(velocity, valve.orders.last, valve.orders, begins), True)


def _leg(piston: Piston, behind: float, begin: Rebound, started: bool) -> Leg:
    look()
    forces, ports, law, supply = piston.numbers
    room, ending = MOST + len(begin.orders.pending), kn.TOO_MANY
    while ending == kn.TOO_MANY:
        row, now, told = row_of(piston, begin, room), [0.0] * (kn.DUE + 2 * room), [0.0] * kn.TOLD
        log: list[tuple[Any, ...]] = []
        row[kn.X] = behind
        slopes, slope = table(kn.BY_ORDER + room, 2 + room), table(2 + room, 2 + room)
        ending = kn.leg(forces, ports, law, row, started, now, slopes, slope, told, supply, log)
        room *= 2
    names = [name for name, _ in piston.valve.pairs]
    segments = tuple(
        Segment(names[int(state)], time, duration, flight, x, v, pressure)
        for kind, time, duration, flight, state, x, v, pressure in (one for one in log if one[0] == kn.SEGMENT)
    )
    switches = tuple(Switch(one[1], names[int(one[2])], *one[3:]) for one in log if one[0] == kn.SWITCH)
    passed = tuple(Uncovering(one[2], one[1], one[3]) for one in log if one[0] == kn.UNCOVERING)
    dropped, happened = told[kn.DROPPED] > 0.0, (segments, switches, passed)
    if ending != kn.BLOW:
        return Leg(_ENDINGS[ending], now[kn.TIME], math.nan, None, np.empty((0, 0)), *happened, dropped)
    size = kn.size_of(now, supply)
    derivatives = np.array([line[: kn.size_of(row, supply)] for line in slope[:size]])
    rebound = rebound_of(piston, now)
    return Leg("blow", told[kn.DURATION], told[kn.SPEED], rebound, derivatives, *happened, dropped)


MOST = 8
"""Pending orders that there is room for at first."""


def table(rows: int, columns: int) -> list[list[float]]:
    """Zeros for `piston_kernels`."""
    return [[0.0] * columns for _ in range(rows)]


def row_of(piston: Piston, rebound: Rebound, room: int) -> list[float]:
    """A rebound as `piston_kernels` have it."""
    number = {name: float(i) for i, (name, _) in enumerate(piston.valve.pairs)}
    orders, pressure = rebound.orders, 1.0 if rebound.pressure is None else rebound.pressure
    row = [rebound.speed, number[rebound.state], number[orders.last], float(len(orders.pending)), 0.0, 0.0, pressure]
    row += [value for due, to in orders.pending for value in (due, number[to])]
    return row + [0.0] * (kn.DUE + 2 * room - len(row))


def rebound_of(piston: Piston, row: list[float]) -> Rebound:
    """… and back."""
    names = [name for name, _ in piston.valve.pairs]
    orders = row[kn.DUE : kn.DUE + 2 * int(row[kn.COUNT])]
    pending = tuple((due, names[int(to)]) for due, to in zip(orders[::2], orders[1::2], strict=True))
    pressure = None if piston.valve.supply is None else row[kn.PRESSURE]
    return Rebound(row[kn.V], names[int(row[kn.STATE])], Orders(names[int(row[kn.LAST])], pending), pressure)
