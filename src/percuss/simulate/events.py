"""The events of a motion, as columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate.event_columns import EventColumns

__all__ = ["CHATTER", "IMPACT", "KINDS", "RELEASE", "REST", "Event", "Events"]

KINDS = ("impact", "grazing", "chatter", "rest", "release")
"""Kinds of events, in the order of their numbers."""

IMPACT, GRAZING, CHATTER, REST, RELEASE = range(len(KINDS))

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Event(Shown):
    """One event; see `Events`."""

    kind: str
    time: float
    phase: float
    impact_velocity: float
    rebound_velocity: float
    energy_lost: float
    resolved: int
    kinetic_energy: float
    period: int
    piece: int


@dataclass(frozen=True)
class Events(EventColumns[Event]):
    """The events of a motion in order of time, one array for each quantity, all of shape (n,).

    ``events[i]`` is one `Event`; a slice, a mask or an array of numbers gives the `Events` of it.

    Attributes
    ----------
    kind
        What happened: ``impact``; ``grazing``, a touch that rounding does not tell from a miss, after which the bar
        goes on unchanged; ``chatter``, the end of infinitely many impacts in finite time; ``rest``, the bar lies on
        the wall from now on; ``release``, the load pulls it off.
    period, phase
        When: load periods gone by, and the phase of the load in [0, 2π). Together they are exact however long the
        motion lasts.
    time
        2π · period + phase, in radians.
    impact_velocity, rebound_velocity
        Velocity u_t(1) of the striking end before and after the event, dimensionless.
    energy_lost
        What the event takes from the bar. Rest takes what motion and strain is left.
    kinetic_energy
        Just before an impact, all modes: the blow energy. 0 for other events.
    resolved
        Of a chatter: how many of its impacts are recorded singly before it, the main blow first.
    piece
        Number of the load's step that holds, for a load of steps.
    """

    KINDS = KINDS

    period: npt.NDArray[np.int64]
    phase: Array
    impact_velocity: Array
    rebound_velocity: Array
    energy_lost: Array
    kinetic_energy: Array
    resolved: npt.NDArray[np.int64]
    piece: npt.NDArray[np.int64]

    @property
    def time(self) -> Array:
        """2π · period + phase, in radians; shape (n,)."""
        return self.period * _TURN + self.phase

    def _one(self, i: int) -> Event:
        return Event(
            KINDS[self.code[i]],
            float(self.period[i] * _TURN + self.phase[i]),
            float(self.phase[i]),
            float(self.impact_velocity[i]),
            float(self.rebound_velocity[i]),
            float(self.energy_lost[i]),
            int(self.resolved[i]),
            float(self.kinetic_energy[i]),
            int(self.period[i]),
            int(self.piece[i]),
        )
