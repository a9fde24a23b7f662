"""The machines that a record may be of: switches by ports without delay, by longer delays, or as the cycles tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from percuss.model import Chamber, Contact, Machine, Port, System, Valve
from percuss.model.load.valve import Orders
from percuss.shown import Shown
from percuss.steady.recorded.port_and_delay import Interval, PortAndDelay, Seen
from percuss.steady.self_excited.piston_records import Piston, Rebound
from percuss.steady.self_excited.rigid_cycle import RigidCycle, cycle_near

__all__ = ["RecordedSwitch", "cycle_read", "longest_that_run", "machine_read", "state_names"]

_HALVINGS = 6


@dataclass(frozen=True)
class RecordedSwitch(Shown):
    """A change of the force, seen in a record.

    Attributes
    ----------
    to
        The state that follows.
    jump
        Rise of the force at the switch, per mass.
    time
        After the blow that is nearest; negative before it. Over the cycles, with 95 % of their mean.
    behind, velocity
        Where the piston is then, and its velocity away from the wall, with 95 % of their means.
    side
        Of the port: "back" where the force rises, which the piston passes on its way back, "front" where it falls.
    by_blow
        Whether the blow itself may have ordered it: the least delay is then that since the blow.
    found
        The place of the port and the delay.
    seen
        The switch in each cycle.
    """

    to: str
    jump: float
    time: Interval
    behind: Interval
    velocity: Interval
    side: Literal["back", "front"]
    by_blow: bool
    found: PortAndDelay
    seen: tuple[Seen, ...] = field(repr=False, compare=False)

    @property
    def best_delay(self) -> float:
        """The delay that the cycles tell; else the least one."""
        return self.found.delay.value if self.found.told_apart else self.found.least

    def port(self, delay: float) -> Port:
        """The port that has this delay, where the piston was that long before the switch."""
        place = float(np.mean([one.motion.at(one.time - delay)[0] for one in self.seen]))
        struck = (self.by_blow and delay <= self.found.least) or (self.found.since_blow and delay >= self.found.longest)
        if struck or place <= 0.0:
            return Port(self.to, delay=delay, on="impact")
        return Port(self.to, behind=place, side=self.side, delay=delay)

    def __str__(self) -> str:
        when = f"{abs(self.time.value):.5g} {'before' if self.time.value < 0.0 else 'after'} the blow"
        apart = f"port {self.found.port.value:.5g}, delay {self.found.delay.value:.4g}"
        told = apart if self.found.told_apart else f"a delay up to {self.found.delay.high:.4g}"
        return f"{self.to}: {when}, {self.behind.value:.5g} behind the wall at {self.velocity.value:.5g}; {told}"


def state_names(number: int) -> list[str]:
    """Names of so many states, by rising force."""
    return ["return", "power"] if number == 2 else [f"state {i}" for i in range(1, number + 1)]


def machine_read(
    system: System,
    contact: Contact,
    forces: list[float],
    stiffness: float,
    switches: tuple[RecordedSwitch, ...],
    delays: list[float],
) -> Machine:
    """The machine whose switches have these delays; forces per mass, all in the unit of time of the machine."""
    states = dict(zip(state_names(len(forces)), forces, strict=True))
    ports = tuple(switch.port(delay) for switch, delay in zip(switches, delays, strict=True))
    valve = Valve(states, ports, chamber=Chamber(0.0, stiffness))
    if system.bar is None:
        return Machine(system.body, valve, contact, at=system.load.at)
    bar = system.bar
    sized = valve.scaled(bar.mass * bar.length, bar.length)
    return Machine.from_si(bar, sized, contact, at=system.load.at)


def longest_that_run(
    made: Callable[[list[float]], Machine], switches: tuple[RecordedSwitch, ...], speed: float
) -> Machine | None:
    """The machine with the longest delays, all the same part of what the motion allows, with which it runs steadily."""

    def at(part: float) -> Machine:
        return made(delays(part))

    def delays(part: float) -> list[float]:
        return [s.found.least + part * (s.found.longest - s.found.least) for s in switches]

    def runs(part: float) -> bool:
        cycle = cycle_read(at(part), switches, delays(part), speed)
        return cycle is not None and cycle.stable

    low, high = 0.0, 1.0
    if runs(high):
        return at(high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if runs(middle) else (low, middle)
    return at(low) if low > 0.0 else None


def cycle_read(
    machine: Machine, switches: tuple[RecordedSwitch, ...], delays: list[float], speed: float
) -> RigidCycle | None:
    """The cycle of a machine near the recorded motion, whose blows have that speed; None where there is none.

    The orders that are pending at the blow are those of the switches after it whose ports were passed before it.
    """
    late = [(s.time.value, s.to) for s, delay in zip(switches, delays, strict=True) if 0.0 < s.time.value < delay]
    pending, now = sorted(late), switches[-1].to
    orders = Orders(pending[-1][1] if pending else now, tuple(pending))
    rebound = Rebound(-machine.contact.velocity_factor * speed, now, orders)
    return cycle_near(Piston(machine.valve, machine.contact, machine.drag), rebound, 1)
