"""The motion of a machine whose every contact is resolved by waves."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Target
from percuss.blow.periods.lattice import Lattice
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate import MotionCycle, Start, Stop

# ---- Contacts gathered to impacts, with what each impact did

_TURN = 2.0 * math.pi
ROUND_TRIP = 2.0
"""Transit times: contacts nearer than the way of waves there and back belong to one impact."""

_GRAZE = 1e-9  # of the greatest impulse


@dataclass(frozen=True)
class Impacts(Shown):
    """The impacts of a machine, one after another; every array of shape (impacts,), dimensionless.

    Contacts that are less than a wave's way there and back apart are one impact; on a tool that is fed between blows,
    all contacts from one time that it is fed to the next.

    Attributes
    ----------
    start, end
        Of the contact, or of the first and the last contact; radians.
    contacts
        How many contacts.
    impulse
        J = ∫ N dt of all of them.
    centroid
        Time of the centroid of the contact force.
    velocity
        Of the rigid motion at the centroid, as it would be without the contact force (b77-blow's V). It tells little of
        an impact that lasts for a good part of a load period, such as a chatter that ends in rest.
    mean_before, mean_after
        Mean velocity of the striker when the contact starts and when it has ended.
    peak_force
        The greatest N.
    ringing_share
        Elastic energy when the contact has ended, over the striker's energy when it started.
    given
        ∫ N v dt at the struck face: the work done on what is struck.
    rock_work
        Work that the rock has kept by the next impact, ½ (1 − γ) K u_m²; 0 without rock.
    fed
        By how much the tool is fed after the impact; 0 of one that comes back to its place or is not fed.
    """

    start: Array
    end: Array
    contacts: npt.NDArray[np.int64]
    impulse: Array
    centroid: Array
    velocity: Array
    mean_before: Array
    mean_after: Array
    peak_force: Array
    ringing_share: Array
    given: Array
    rock_work: Array
    fed: Array

    @property
    def size(self) -> int:
        """How many impacts."""
        return self.start.size

    @property
    def phase(self) -> Array:
        """Of the load at the centroid, in [0, 2π)."""
        return np.asarray(self.centroid % _TURN % _TURN)

    @property
    def duration(self) -> Array:
        """From the start of the first contact to the end of the last."""
        return self.end - self.start

    @property
    def restitution(self) -> Array:
        """R of each impact, J/V − 1 with V at the centroid; NaN where V is not toward the struck face."""
        moving = self.velocity > 0.0
        return np.where(moving, self.impulse / np.where(moving, self.velocity, 1.0) - 1.0, math.nan)

    def part(self, which: int | slice | Array) -> Impacts:
        """Some of them; with a number that one, in plain numbers."""
        return Impacts(*(getattr(self, one.name)[which] for one in fields(self)))


def impacts_of(
    contacts: npt.NDArray[np.void], load: Load, transit: float, tool: tuple[float, float] | None = None
) -> tuple[Impacts, int]:
    """The impacts that contacts make, and how many grazing contacts were left out.

    `tool`: of one that is fed, the work that the rock has kept at the end and by how much it has been fed by then.
    """
    impulses = contacts["impulse"]
    real = impulses > _GRAZE * impulses.max(initial=0.0)
    kept = contacts[real]
    first = np.ones(kept.size, dtype=bool)
    if tool is None:
        first[1:] = kept["start"][1:] - kept["end"][:-1] >= ROUND_TRIP * transit
    else:
        first[1:] = np.diff(kept["blow"]) > 0
    at = np.flatnonzero(first)
    last = np.append(at[1:], kept.size) - 1 if at.size else at
    impulse = _sums(kept["impulse"], at)
    centroid = _sums(kept["moment"] + kept["impulse"] * kept["start"], at) / impulse
    start, before = kept["start"][at], kept["momentum_before"][at]
    fallen = load.mean * (centroid - start) + load.antiderivative(centroid) - load.antiderivative(start)
    energy, after = kept["energy_before"][at], kept["momentum_after"][last]
    hidden = kept["averaged_after"][last] - kept["averaged_before"][at]  # in cells that fronts divide
    elastic = kept["energy_after"][last] + hidden - 0.5 * after**2
    found = Impacts(
        start=start,
        end=kept["end"][last],
        contacts=last - at + 1,
        impulse=impulse,
        centroid=centroid,
        velocity=before + fallen,
        mean_before=before,
        mean_after=after,
        peak_force=np.maximum.reduceat(kept["peak"], at) if at.size else np.zeros(0),
        ringing_share=np.maximum(elastic, 0.0) / np.where(energy > 0.0, energy, math.inf),
        given=_sums(kept["given"], at),
        rock_work=_between(kept["rock_before"], at, tool and tool[0]),
        fed=_between(kept["advanced_before"], at, tool and tool[1]),
    )
    return found, int(np.count_nonzero(~real))


def _between(before: Array, at: npt.NDArray[np.intp], last: float | None) -> Array:
    """By how much a sum grows from each impact to the next, and from the last to the end."""
    return np.diff(before[at], append=last) if last is not None and at.size else np.zeros(at.size)


def _sums(values: Array, at: npt.NDArray[np.intp]) -> Array:
    return np.add.reduceat(values, at) if at.size else np.zeros(0)


# ---- Whether a machine does the same again: its whole state at the ends of load periods, compared

MOST_PERIODS = 16
"""The longest cycle that is looked for."""

_CONFIRMED = 2
_NEAR = 100.0  # times the tolerance


class Recurrence:
    """The last states at the ends of load periods."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._states: deque[tuple[float, Array]] = deque(maxlen=MOST_PERIODS)
        self._seen = [0] * (MOST_PERIODS + 1)

    def after(self, gap: float, waves: Array, speed: float) -> int:
        """How many periods ago the state was the same, twice in a row; 0 when it never was.

        A motion that comes nearer to a shorter cycle is not settled on a longer one before it.
        """
        found, apart = 0, [math.inf] * (MOST_PERIODS + 1)
        for periods, (old_gap, old) in enumerate(reversed(self._states), 1):
            off = float(np.linalg.norm(waves - old)) + abs(gap - old_gap) / (2.0 * math.pi)
            apart[periods] = off / speed if speed > 0.0 else math.inf if off > 0.0 else 0.0
            same = apart[periods] <= self.tolerance
            self._seen[periods] = self._seen[periods] + 1 if same else 0
            nearer = any(apart[part] <= _NEAR * self.tolerance for part in range(1, periods) if periods % part == 0)
            if not found and self._seen[periods] >= _CONFIRMED and not nearer:
                found = periods
        self._states.append((gap, waves))
        return found


# ---- The motion of a machine whose every contact is resolved by waves

_LONG = 2  # load periods in contact from which on the bar is said to rest


@dataclass(frozen=True)
class WaveEnergy(Shown):
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
class WaveMotion(Shown):
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
    start, stop
        As asked for.
    lattice
        The cells.
    impacts
        All impacts that have ended.
    grazes
        Contacts without an impulse to speak of, left out.
    outcome
        One of `percuss.simulate.OUTCOMES`: why it was followed no further.
    cycle
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
    start: Start
    stop: Stop
    lattice: Lattice
    impacts: Impacts
    grazes: int
    outcome: str
    cycle: MotionCycle | None
    touching: bool
    since: float
    end_time: float
    energy: WaveEnergy
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
        if self.cycle is None:
            return "irregular" if self.impacts.size else "none"
        return f"z={self.cycle.impacts}/{self.cycle.periods}" if self.cycle.impacts else "none"

    @cached_property
    def settled(self) -> Impacts:
        """The impacts of the last settled cycle, or of the last half of an irregular motion."""
        n = self.impacts.size
        count = self.cycle.impacts if self.cycle is not None else (n + 1) // 2
        return self.impacts.part(slice(n - count, n))

    @property
    def phases(self) -> Array:
        """Phases of the load at the force centroids of the cycle's impacts, in [0, 2π)."""
        return self.settled.phase

    @property
    def velocities(self) -> Array:
        """Striking speeds of the rigid motion at those."""
        return self.settled.velocity

    @property
    def blow_rate(self) -> float:
        """Impacts per load period."""
        if self.cycle is not None:
            return self.cycle.impacts / self.cycle.periods
        own = self.settled
        return _TURN * (own.size - 1) / float(own.start[-1] - own.start[0]) if own.size > 1 else math.nan

    @property
    def impulse_per_period(self) -> float:
        """Σ J of the cycle over its load periods: p_0 2π of every periodic motion without drag."""
        return float(np.sum(self.settled.impulse)) / self.cycle.periods if self.cycle is not None else math.nan

    @property
    def delivered_power(self) -> float:
        """Work done on what is struck, per radian of the load."""
        own = self.settled
        if own.size == 0:
            return 0.0
        return float(np.mean(own.given)) * self.blow_rate / _TURN

    @property
    def rock_power(self) -> float:
        """Work that the rock keeps, per radian of the load; 0 without rock."""
        own = self.settled
        return float(np.mean(own.rock_work)) * self.blow_rate / _TURN if own.size else 0.0

    def __str__(self) -> str:
        phases = ", ".join(f"{phase:.6g}" for phase in self.phases[:4]) if self.cycle is not None else ""
        where = f", phase {phases}{' …' if self.settled.size > 4 else ''}" if phases else ""
        count = self.impacts.size
        return (
            f"Machine by waves: {self.label}{where}; {count} impact{'s' if count != 1 else ''}, ended: {self.outcome}"
        )
