"""The events of a motion, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array

__all__ = ["CHATTER", "IMPACT", "KINDS", "RELEASE", "REST", "Event", "Events"]

KINDS = ("impact", "grazing", "chatter", "rest", "release")
"""Kinds of events, in the order of their numbers."""

IMPACT, GRAZING, CHATTER, REST, RELEASE = range(len(KINDS))

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Event:
    """One event; see `Events`."""

    kind: str
    time: float
    phase: float
    impact_velocity: float
    rebound_velocity: float
    energy_lost: float
    resolved: int


@dataclass(frozen=True)
class Events:
    """The events of a motion in order of time, one array for each quantity, all of shape (n,).

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
        Of a chatter: how many of the impacts before it are recorded singly.
    piece
        Number of the load's step that holds, for a load of steps.
    """

    code: npt.NDArray[np.int8]
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

    @property
    def kind(self) -> npt.NDArray[np.str_]:
        """The kinds as words; shape (n,)."""
        return np.array(KINDS)[self.code]

    def of(self, kind: str) -> Events:
        """The events of one kind.

        Raises
        ------
        ParameterError
            For a kind that there is not.
        """
        if kind not in KINDS:
            raise ParameterError("kind", kind, f"one of {', '.join(KINDS)}")
        return self[self.code == KINDS.index(kind)]

    def __len__(self) -> int:
        return int(self.code.size)

    def __getitem__(self, which: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Events:
        return Events(*(getattr(self, field.name)[which] for field in fields(self)))

    def __iter__(self) -> Iterator[Event]:
        for i, time in enumerate(self.time):
            yield Event(
                KINDS[self.code[i]],
                float(time),
                float(self.phase[i]),
                float(self.impact_velocity[i]),
                float(self.rebound_velocity[i]),
                float(self.energy_lost[i]),
                int(self.resolved[i]),
            )

    @classmethod
    def of_all(cls, parts: Sequence[Events]) -> Events:
        """The events of several stretches of one motion, one after the other."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))
