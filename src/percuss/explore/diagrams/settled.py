"""What the passes of a diagram settled on at a value of the parameter, each motion once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from percuss.explore.attractors.grouping import labels, matched
from percuss.explore.diagrams.passes import UNKNOWN
from percuss.explore.jobs.job import Columns
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["SettledMotion", "settled_at"]


@dataclass(frozen=True)
class SettledMotion(Shown):
    """A motion that simulations settle on at one value of the parameter; dimensionless.

    Parameters
    ----------
    value
        Of the parameter.
    label
        As `percuss.simulate.Trajectory.label` has it.
    members
        How many of the simulations at this value settled on it.
    phases, speeds
        Of the impacts of a cycle, or of the last ones of a motion without a cycle: of the first simulation. Of a long
        chatter the fastest ones.
    energy
        Mean kinetic energy before a main blow; NaN of a motion that rests or leaves for good.
    scales
        Metres per second and joules of a speed and an energy of 1; None for a system without units.
    """

    value: float
    label: str
    members: int
    phases: Array = field(repr=False)
    speeds: Array = field(repr=False)
    energy: float
    scales: tuple[float, float] | None = None


def settled_at(passes: Columns, i: int, value: float, scales: Array, load_scale: float) -> list[SettledMotion]:
    """What the passes settled on at value number i."""
    names = ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders", "invariants")
    there = np.flatnonzero(passes["code"][:, i] != UNKNOWN)
    if not there.size:
        return []
    here = {name: passes[name][there, i] for name in names}
    number, words = matched(here, load_scale), labels(here)
    found = []
    for group in range(int(number.max()) + 1):
        members = np.flatnonzero(number == group)
        row = int(there[members[0]])
        kept = np.isfinite(passes["phases"][row, i])
        energies = passes["blow_energy"][there[members], i]
        ended = str(words[members[0]]) in ("rest", "departed")  # whose blows were on the way there
        known = energies[np.isfinite(energies) & (not ended)]
        energy = float(known.mean()) if known.size else np.nan
        made = (float(scales[0]), float(scales[1])) if scales[0] > 0.0 else None
        found.append(
            SettledMotion(
                value,
                str(words[members[0]]),
                members.size,
                passes["phases"][row, i, kept],
                passes["speeds"][row, i, kept],
                energy,
                made,
            )
        )
    return found
