"""What a rigid piston under a valve is, and the records of its way from blow to blow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from percuss.model import Contact, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.piston_flight import Flight
from percuss.steady.self_excited.pressed_flight import PressedFlight

__all__ = ["Ending", "Leg", "Piston", "Rebound", "Segment", "Switch", "Uncovering"]

_LEAST = 1e-100  # a stiffness or a drag below it is none: its times would overflow

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
