"""The events of a machine's motion, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, choice
from percuss.shown import Shown

__all__ = ["MACHINE_KINDS", "MachineEvent", "MachineEvents"]

MACHINE_KINDS = ("impact", "grazing", "chatter", "rest", "release", "port", "valve")
"""Kinds of events of a machine, in the order of their numbers."""

_COLUMNS = (
    "code", "time", "velocity", "rebound_velocity", "energy_lost", "kinetic_energy", "state", "port", "resolved",
)  # fmt: skip


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
class MachineEvents(Shown):
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

    code: npt.NDArray[np.int8]
    time: Array
    velocity: Array
    rebound_velocity: Array
    energy_lost: Array
    kinetic_energy: Array
    state: npt.NDArray[np.int64]
    port: npt.NDArray[np.int64]
    resolved: npt.NDArray[np.int64]
    states: tuple[str, ...]

    @property
    def kind(self) -> npt.NDArray[np.str_]:
        """The kinds as words; shape (n,)."""
        return np.array(MACHINE_KINDS)[self.code]

    def of(self, kind: str) -> MachineEvents:
        """The events of one kind.

        Raises
        ------
        ParameterError
            For a kind that there is not.
        """
        choice("kind", kind, *MACHINE_KINDS)
        return self._part(self.code == MACHINE_KINDS.index(kind))

    def __len__(self) -> int:
        return int(self.code.size)

    def __iter__(self) -> Iterator[MachineEvent]:
        return map(self._one, range(len(self)))

    def __getitem__(self, which: object) -> MachineEvent | MachineEvents:
        """One event by its number, from the end when negative; the events of a slice, a mask or an array of numbers."""
        if isinstance(which, int | np.integer) and not isinstance(which, bool):
            return self._one(range(len(self))[which])
        return self._part(which)

    def _part(self, which: object) -> MachineEvents:
        return replace(self, **{name: getattr(self, name)[which] for name in _COLUMNS})

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

    @classmethod
    def of_all(cls, parts: Sequence[MachineEvents]) -> MachineEvents:
        """The events of several stretches of one motion, one after the other."""
        if len(parts) == 1:
            return parts[0]
        columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS}
        return replace(parts[0], **columns)

    def __str__(self) -> str:
        numbers = np.bincount(self.code, minlength=len(MACHINE_KINDS)).tolist()
        kinds = ", ".join(f"{n} {kind}" for n, kind in zip(numbers, MACHINE_KINDS, strict=True) if n)
        return f"MachineEvents: {kinds or 'none'}"
