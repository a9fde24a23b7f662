"""The events of a machine's motion, as columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate.event_columns import EventColumns

__all__ = ["MACHINE_KINDS", "MachineEvent", "MachineEvents"]

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
