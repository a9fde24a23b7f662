"""The branches of cycles with rest in a diagram: as plain numbers, of each chatter the first impacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from percuss.explore.continuation.rest_branch import RestBranch, RestBranchPoint, RestEvent
from percuss.explore.diagrams.points import DiagramPoint
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady import RestCycle

__all__ = ["KEPT_IMPACTS", "DiagramRestBranch", "rest_line_of"]

KEPT_IMPACTS = 8
"""Impacts after each release that are kept, at most: those of a chatter have no last one."""

_TURN = 2.0 * np.pi
_ARRAYS = ("values", "releases", "rests", "times", "speeds", "energies")
_KINDS: dict[str, RestEvent] = {kind.value: kind for kind in RestEvent}


@dataclass(frozen=True)
class DiagramRestBranch(Shown):
    """A branch of cycles with rest in a diagram, all of them superstable; dimensionless, times in radians.

    Parameters
    ----------
    label
        chatter/n or rest/n.
    values
        Of the parameter along the branch, increasing; shape (m,).
    releases, rests
        When the bar is let go, and when it comes to rest after that; shape (m, rests).
    times, speeds
        Of the first impacts after each release; shape (m, rests, impacts), NaN where there are fewer.
    energies
        Mean kinetic energy just before a main blow; shape (m,), NaN where simulation does not tell it.
    points
        Its two ends.
    scales
        Metres per second and joules of a speed and an energy of 1; shape (m, 2), None for a system without units.
    """

    label: str
    values: Array = field(repr=False)
    releases: Array = field(repr=False)
    rests: Array = field(repr=False)
    times: Array = field(repr=False)
    speeds: Array = field(repr=False)
    energies: Array = field(repr=False)
    points: tuple[DiagramPoint, ...]
    scales: Array | None = field(default=None, repr=False)

    @property
    def phases(self) -> Array:
        """Phases of the load at the impacts, in [0, 2π); shape (m, rests, impacts)."""
        return np.mod(self.times, _TURN)

    @property
    def release_phases(self) -> Array:
        """Phases of the load at which the bar is let go; shape (m, rests)."""
        return np.mod(self.releases, _TURN)

    @property
    def rest_phases(self) -> Array:
        """Phases of the load at which the bar comes to rest; shape (m, rests)."""
        return np.mod(self.rests, _TURN)

    @property
    def stable(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Always; shape (m,)."""
        return np.ones(self.values.size, dtype=bool)

    def release_at(self, value: float) -> float | None:
        """The first release at a value of the parameter, straight between its points; None beyond the ends."""
        if not self.values[0] <= value <= self.values[-1]:
            return None
        return float(np.interp(value, self.values, np.unwrap(self.releases[:, 0])))

    @property
    def plain(self) -> dict[str, Any]:
        """Of JSON's types, with NaN."""
        arrays = {name: getattr(self, name).tolist() for name in _ARRAYS}
        scales = None if self.scales is None else self.scales.tolist()
        return {"label": self.label, **arrays, "points": [point.plain for point in self.points], "scales": scales}

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> DiagramRestBranch:
        """A branch from what was its `plain`."""
        points = tuple(DiagramPoint.of(point, _KINDS) for point in row["points"])
        scales = None if row["scales"] is None else np.array(row["scales"])
        return cls(row["label"], **{name: np.array(row[name]) for name in _ARRAYS}, points=points, scales=scales)

    def __str__(self) -> str:
        low, high = float(self.values[0]), float(self.values[-1])
        head = f"{self.label}: {self.values.size} points from {low:.9g} to {high:.9g}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


def rest_line_of(branch: RestBranch) -> DiagramRestBranch:
    """A followed branch with the energies of its cycles, as simulations tell them."""
    cycles, legs = branch.cycles, len(branch.cycles[0].chains)
    times, speeds = np.full((2, len(cycles), legs, KEPT_IMPACTS), np.nan)
    for i, cycle in enumerate(cycles):
        for leg, chain in enumerate(cycle.chains):
            kept = np.array(chain.impacts[:KEPT_IMPACTS]).reshape(-1, 2)
            times[i, leg, : len(kept)], speeds[i, leg, : len(kept)] = kept.T
    most = int(np.isfinite(times).sum(axis=-1).max())
    scales = [(one.system.speed_scale, one.system.energy_scale) for one in cycles if one.system.is_si]
    energies = _blow_energies([*cycles, *(point.cycle for point in branch.points)])
    return DiagramRestBranch(
        branch.label, branch.values,
        releases=np.array([[chain.release for chain in cycle.chains] for cycle in cycles]),
        rests=np.array([[chain.rest for chain in cycle.chains] for cycle in cycles], dtype=float),
        times=times[..., :most], speeds=speeds[..., :most], energies=energies[: len(cycles)],
        points=tuple(map(_point, branch.points, energies[len(cycles) :].tolist())),
        scales=np.array(scales) if len(scales) == len(cycles) else None,
    )  # fmt: skip


def _point(point: RestBranchPoint, energy: float) -> DiagramPoint:
    cycle, dies = point.cycle, point.kind is RestEvent.DEATH
    first = [impact for chain in cycle.chains for impact in chain.impacts[:KEPT_IMPACTS]]
    times, speeds = np.array(first).reshape(-1, 2).T
    return DiagramPoint(
        point.kind, point.value, cycle.label, np.mod(times, _TURN), speeds, point.beyond,
        point.impact if dies else None, None if dies else point.touch_phase, energy,
    )  # fmt: skip


def _blow_energies(cycles: Sequence[RestCycle]) -> Array:
    """The mean kinetic energy before a main blow, of simulations that start at the releases."""
    from percuss.simulate import Start, Stop, simulate_many

    starts = [Start.rigid(0.0, 0.0, cycle.release_phase) for cycle in cycles]
    many = simulate_many([one.system for one in cycles], starts, modes=cycles[0].modes, stop=Stop(), threads=1)
    same = many.label == np.array([cycle.label for cycle in cycles])
    return np.where(same, many.blow_energy, np.nan)
