"""The events of a machine's motion, as columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate.events import EventColumns

MACHINE_KINDS = ("impact", "grazing", "chatter", "rest", "release", "port", "valve")
"""Kinds of events of a machine, in the order of their numbers."""


@dataclass(frozen=True)
class MachineEvent(Shown):
    """One event; see `MachineEvents`."""

    kind: str
    time: float
    velocity: float
    rebound_velocity: float
    energy_lost: float
    kinetic_energy: float
    state: str
    port: int | None
    resolved: int


@dataclass(frozen=True)
class MachineEvents(EventColumns[MachineEvent]):
    """The events of a machine's motion in order of time, one array for each quantity, all of shape (n,).

    ``events[i]`` is one `MachineEvent`; a slice, a mask or an array of numbers gives the `MachineEvents` of it.

    Attributes
    ----------
    kind
        What happened: ``impact``; ``grazing``, a touch that rounding does not tell from a miss; ``chatter``, the end
        of infinitely many impacts in finite time; ``rest``, the bar lies on the wall from now on; ``release``, the
        force pulls it off; ``port``, a port demands a state that was not the last one demanded; ``valve``, the state
        of the valve has changed.
    time
        In the machine's unit of time.
    velocity, rebound_velocity
        Velocity of the striking end before and after the event; `velocity` at a port is that of what the port reads.
    energy_lost
        What the event takes from the bar.
    kinetic_energy
        Just before an impact, all modes: the blow energy. 0 for other events.
    state
        The state of the valve after the event, by its number in `states`.
    port
        The number of the port that demands; −1 for other events.
    resolved
        Of a chatter: how many of its impacts are recorded singly before it, the main blow first.
    states
        The names of the valve's states.
    """

    KINDS = MACHINE_KINDS

    time: Array
    velocity: Array
    rebound_velocity: Array
    energy_lost: Array
    kinetic_energy: Array
    state: npt.NDArray[np.int64]
    port: npt.NDArray[np.int64]
    resolved: npt.NDArray[np.int64]
    states: tuple[str, ...]

    def _one(self, i: int) -> MachineEvent:
        return MachineEvent(
            MACHINE_KINDS[self.code[i]],
            float(self.time[i]),
            float(self.velocity[i]),
            float(self.rebound_velocity[i]),
            float(self.energy_lost[i]),
            float(self.kinetic_energy[i]),
            self.states[self.state[i]],
            int(self.port[i]) if self.port[i] >= 0 else None,
            int(self.resolved[i]),
        )


# ---- A machine's motion in short: its cycle, and its label

STALLS = ("on the tool", "in the chamber", "on a port", "leaves", "without pressure")
"""How a machine stalls: it lies on the wall and no order waits; it swings on the gas of its chamber, with ever
weaker blows or none; the valve switches to and fro at a port without end; it leaves and never comes back; the pressure
of its supply falls to 0. Each is proved."""

MACHINE_OUTCOMES = ("impacts", "time", "periodic", "stalls", "work", "memory", "cancelled")
"""How a simulation of a machine ends; as `OUTCOMES`, but for ``stalls``: the valve can never switch again, whatever
blows are left, which are followed as far as was asked for."""


@dataclass(frozen=True)
class MachineCycle(Shown):
    """A periodic motion that was found.

    Attributes
    ----------
    first
        The number of impacts before the motion is on the cycle to within the tolerance.
    blows
        Main blows in a period.
    valve_cycles
        How often the valve comes to the same state in a period.
    kind
        0: no rest; 1: with rest; 2: with rest at the end of complete chatter.
    period
        In the machine's unit of time.
    energy_lost
        What blows, chatter and rest take in a period, per unit of mass.
    blow_speed
        Striking speed of the strongest blow.
    """

    first: int
    blows: int
    valve_cycles: int
    kind: int
    period: float
    energy_lost: float
    blow_speed: float


def machine_label(ended: str, cycle: MachineCycle | None, wanders: bool) -> str:
    """The motion's name.

    ``runs n/m``, n blows in a valve cycle and m valve cycles until the motion repeats; ``double blow n/m`` with n of 2
    or more; ``runs with rest n/m``; ``cycles without blow``; ``stalls (…)``, see `STALLS`; ``irregular``, or
    ``undecided`` where too little was followed to tell.

    Parameters
    ----------
    ended
        How the simulation ended, one of `STALLS` among them.
    cycle
        The periodic motion, when one was found.
    wanders
        Whether the last changes of the valve do not come near any of the ones before.
    """
    if ended in STALLS:
        return f"stalls ({ended})"
    if cycle is None:
        return "irregular" if wanders else "undecided"
    if cycle.blows == 0:
        return "cycles without blow"
    blows = cycle.blows / cycle.valve_cycles
    numbers = f"{blows:.3g}/{cycle.valve_cycles}"
    if cycle.kind:
        return f"runs with rest {numbers}"
    return f"double blow {numbers}" if blows >= 2.0 else f"runs {numbers}"
