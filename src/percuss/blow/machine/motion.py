"""The motion of a machine whose every contact is resolved by waves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.blow.machine.impacts import Impacts
from percuss.blow.machine.lattice import Lattice
from percuss.blow.machine.options import Ending, Limits, Release
from percuss.blow.machine.recurrence import Settled
from percuss.blow.target import Target
from percuss.model import System
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["Energy", "MachineMotion", "Uncertainty"]

_TURN = 2.0 * math.pi
_LONG = 2  # load periods in contact from which on the bar is said to rest


@dataclass(frozen=True)
class Energy(Shown):
    """Where the energy of a motion went; all over the time followed, dimensionless.

    Attributes
    ----------
    load_work
        Done by the load.
    given
        To what is struck, ∫ N v dt at its face.
    damped
        Taken by damping.
    averaged
        What the lattice does not show: in a cell in which a contact starts or ends, or met a front, waves are known by
        their mean. It falls with the size of the cells.
    stored
        Rise of the striker's kinetic and elastic energy.
    """

    load_work: float
    given: float
    damped: float
    averaged: float
    stored: float

    @property
    def error(self) -> float:
        """What is missing, over the sum of the amounts: rounding; dimensionless."""
        parts = self.load_work, self.given, self.damped, self.averaged, self.stored
        missing = parts[0] - sum(parts[1:])
        whole = sum(map(abs, parts))
        return abs(missing) / whole if whole > 0.0 else 0.0


@dataclass(frozen=True)
class Uncertainty(Shown):
    """How far the settled motion of a lattice with half the cells is from this one.

    Attributes
    ----------
    phase
        Greatest difference of the phases of the impacts, in radians; None where the other lattice settled otherwise.
    velocity
        Greatest relative difference of the striking speeds.
    label
        What the other lattice settled on.
    """

    phase: float | None
    velocity: float | None
    label: str


@dataclass(frozen=True)
class MachineMotion(Shown):
    """The striker under its load, contact by contact.

    Everything is dimensionless; `system` has the scales to SI.

    Attributes
    ----------
    system, target
        What strikes under which load, and what is struck. The contact law of the system has no part in this.
    pushed_back
        Whether the rod is pushed back to its place as soon as the striker has left it the room, or stays where it is.
    quiet
        Whether all ringing was made to end between blows.
    release, limits
        Start and end as asked for.
    lattice
        The cells.
    impacts
        All impacts that have ended.
    grazes
        Contacts without an impulse to speak of, left out.
    ending
        Why it was followed no further.
    settled
        The periodic motion, or None.
    touching
        Whether the faces are in contact at the end.
    since
        Since when, in radians; NaN out of contact.
    end_time
        In radians.
    energy
        The balance.
    uncertainty
        What a coarser lattice gives; None where that was not asked for.
    """

    system: System
    target: Target
    pushed_back: bool
    quiet: bool
    release: Release
    limits: Limits
    lattice: Lattice
    impacts: Impacts
    grazes: int
    ending: Ending
    settled: Settled | None
    touching: bool
    since: float
    end_time: float
    energy: Energy
    uncertainty: Uncertainty | None = None

    @property
    def rests(self) -> bool:
        """Whether the striker has lain on what it strikes for the last load periods."""
        return self.touching and self.end_time - self.since >= _LONG * _TURN

    @property
    def label(self) -> str:
        """z=p/n for p impacts in n load periods; else rest, irregular, or none where nothing is struck."""
        if self.rests:
            return "rest"
        if self.settled is None:
            return "irregular" if self.impacts.size else "none"
        return f"z={self.settled.impacts}/{self.settled.periods}" if self.settled.impacts else "none"

    @cached_property
    def cycle(self) -> Impacts:
        """The impacts of the last settled cycle, or of the last half of an irregular motion."""
        n = self.impacts.size
        count = self.settled.impacts if self.settled is not None else (n + 1) // 2
        return self.impacts.part(slice(n - count, n))

    @property
    def phases(self) -> Array:
        """Phases of the load at the force centroids of the cycle's impacts, in [0, 2π)."""
        return self.cycle.phase

    @property
    def velocities(self) -> Array:
        """Striking speeds of the rigid motion at those."""
        return self.cycle.velocity

    @property
    def blow_rate(self) -> float:
        """Impacts per load period."""
        if self.settled is not None:
            return self.settled.impacts / self.settled.periods
        own = self.cycle
        return _TURN * (own.size - 1) / float(own.start[-1] - own.start[0]) if own.size > 1 else math.nan

    @property
    def impulse_per_period(self) -> float:
        """Σ J of the cycle over its load periods: p_0 2π of every periodic motion without drag."""
        return float(np.sum(self.cycle.impulse)) / self.settled.periods if self.settled is not None else math.nan

    @property
    def delivered_power(self) -> float:
        """Work done on what is struck, per radian of the load."""
        own = self.cycle
        if own.size == 0:
            return 0.0
        return float(np.mean(own.given)) * self.blow_rate / _TURN

    @property
    def rock_power(self) -> float:
        """Work that the rock keeps, per radian of the load; 0 without rock."""
        own = self.cycle
        return float(np.mean(own.rock_work)) * self.blow_rate / _TURN if own.size else 0.0

    def __str__(self) -> str:
        phases = ", ".join(f"{phase:.6g}" for phase in self.phases[:4]) if self.settled is not None else ""
        where = f", phase {phases}{' …' if self.cycle.size > 4 else ''}" if phases else ""
        count = self.impacts.size
        return f"Machine by waves: {self.label}{where}; {count} impact{'s' if count != 1 else ''}, {self.ending.value}"
