"""What machines that switch their own valves settle on, told apart by labels and by the numbers of their cycles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.grouping import grouped
from percuss.explore.attractors.machine_cycles import PERIODIC, blows_of, labels, motion_keys
from percuss.explore.jobs.job import Columns
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.simulate import MachineStarts, Stop

__all__ = ["MachineAttractor", "machine_attractors", "matched_machines"]


@dataclass(frozen=True)
class MachineAttractor(Shown):
    """A motion of a machine that others settle on; dimensionless.

    Parameters
    ----------
    number
        0 for the most frequent.
    label
        As `MachineTrajectory.label` has it.
    members, first
        How many of the motions settle on it, and the first of them.
    period
        In the machine's unit of time; NaN when it has none.
    impact_velocities, blow_energies
        Speeds and energies of the blows of one period, in order of time from the strongest on; empty without a period.
    energy_lost
        What blows, chatter and rest take in a period, per unit of mass; NaN without a period.
    """

    number: int
    label: str
    members: int
    first: int
    period: float
    impact_velocities: tuple[float, ...]
    blow_energies: tuple[float, ...]
    energy_lost: float

    @property
    def phases(self) -> tuple[float, ...]:
        """None: no clock drives the machine."""
        return ()

    @property
    def mark(self) -> str:
        """What tells it from others of its label."""
        return "" if math.isnan(self.period) else f"period {self.period:.4g}"

    @property
    def figures(self) -> dict[str, Any]:
        """Its numbers by name, of JSON's types."""
        known = not math.isnan(self.period)
        return {
            "period": self.period if known else None,
            "impact_velocities": list(self.impact_velocities),
            "blow_energies": list(self.blow_energies),
            "energy_lost": self.energy_lost if known else None,
        }


def matched_machines(columns: Columns, speed: float, distance: float) -> npt.NDArray[np.int64]:
    """The number of the attractor of each motion, 0 for the most frequent; see `percuss.explore.attractors.grouping`.

    Parameters
    ----------
    columns
        `MACHINE_COLUMNS`.
    speed
        The machine's scale of speeds.
    distance
        Relative, of periods and of speeds.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        values = np.column_stack(
            [
                np.log(columns["period"]),
                np.arcsinh(columns["blow_speed"] / speed),
                np.arcsinh(np.sqrt(columns["energy_lost"]) / speed),
            ]
        )
    return grouped(motion_keys(columns), values, PERIODIC, distance)


def machine_attractors(
    columns: Columns, number: npt.NDArray[np.int64], machine: Machine, starts: MachineStarts, modes: int, stop: Stop
) -> tuple[MachineAttractor, ...]:
    """The attractors behind the numbers; the blows are those of the first member, followed once more."""
    if not number.size:
        return ()
    _, first, members = np.unique(number, return_index=True, return_counts=True)
    names = labels({name: columns[name][first] for name in columns if columns[name].shape == number.shape})
    found = []
    for i, row in enumerate(first.tolist()):
        settles = columns["blows"][row] > 0 and columns["stall"][row] < 0
        blows = blows_of(machine, starts[row], modes, stop) if settles else ((), ())
        period, lost = float(columns["period"][row]), float(columns["energy_lost"][row])
        found.append(MachineAttractor(i, str(names[i]), int(members[i]), row, period, *blows, lost))
    return tuple(found)
