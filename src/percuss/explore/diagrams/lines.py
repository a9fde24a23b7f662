"""The branches of a diagram as plain numbers, and as bytes in which an archive keeps them."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch, BranchPoint
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.diagrams.points import DiagramPoint
from percuss.explore.diagrams.rest_lines import DiagramRestBranch
from percuss.model import System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady import PeriodicOrbit

__all__ = ["DiagramBranch", "line_of", "lines_from", "packed"]

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class DiagramBranch(Shown):
    """A branch of orbits z=p/n in a diagram; dimensionless, times in radians.

    Parameters
    ----------
    impacts, periods
        p and n.
    values
        Of the parameter along the branch; shape (m,).
    times, speeds
        Of the impacts, as a `Branch` has them; shape (m, p).
    energies
        Mean kinetic energy of the bar just before an impact; shape (m,).
    unstable
        How many multipliers are outside the unit circle, -1 where they grow without bound; shape (m,).
    points
        What happens on it, its two ends first and last.
    scales
        Metres per second and joules of a speed and an energy of 1; shape (m, 2), None for a system without units.
    possible
        Whether these are motions; if not, they are roots of the equations beyond an end of a branch.
    """

    impacts: int
    periods: int
    values: Array = field(repr=False)
    times: Array = field(repr=False)
    speeds: Array = field(repr=False)
    energies: Array = field(repr=False)
    unstable: npt.NDArray[np.int64] = field(repr=False)
    points: tuple[DiagramPoint, ...]
    scales: Array | None = field(default=None, repr=False)
    possible: bool = True

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def phases(self) -> Array:
        """Phases of the load at the impacts, in [0, 2π); shape (m, p)."""
        return np.mod(self.times, _TURN)

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Whether no multiplier is outside the unit circle; shape (m,)."""
        return np.asarray(self.unstable == 0)

    def times_at(self, value: float) -> list[Array]:
        """The times of the impacts where the branch has a value of the parameter, straight between its points."""
        return crossings(self.values, self.times, value)

    def __str__(self) -> str:
        low, high = float(self.values.min()), float(self.values.max())
        head = f"{self.label}: {self.values.size} points from {low:.9g} to {high:.9g}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


def crossings(values: Array, times: Array, value: float) -> list[Array]:
    """Rows of `times` where `values` pass a value, straight between the points."""
    off = values - value
    found = [times[i] for i in np.flatnonzero(off == 0.0).tolist()]
    for i in np.flatnonzero(off[:-1] * off[1:] < 0.0).tolist():
        share = off[i] / (off[i] - off[i + 1])
        found.append((1.0 - share) * times[i] + share * times[i + 1])
    return found


def line_of(branch: Branch, system: Callable[[float], System]) -> DiagramBranch:
    """A followed branch with the energies of its orbits.

    Parameters
    ----------
    branch
        As `follow` gives it.
    system
        The system at a value of the parameter.
    """
    energies, scales = np.full(branch.values.size, np.nan), np.full((branch.values.size, 2), np.nan)
    for i, (value, times) in enumerate(zip(branch.values.tolist(), branch.times.tolist(), strict=True)):
        try:
            here = system(value)
            motion = PeriodicOrbit(here, branch.periods, tuple(times), branch.modes)
            energies[i] = motion.blow_energies.mean()
        except PercussError:  # an end beyond which there is no system
            continue
        if here.is_si:
            scales[i] = here.speed_scale, here.energy_scale
    points = tuple(_point(point) for point in branch.points)
    made = scales if np.isfinite(scales).any() else None
    return DiagramBranch(
        branch.impacts, branch.periods, branch.values, branch.times, branch.speeds, energies, branch.unstable, points,
        made,
    )  # fmt: skip


def _point(point: BranchPoint) -> DiagramPoint:
    orbit = point.orbit
    return DiagramPoint(
        point.kind, point.value, orbit.label, orbit.phases, orbit.speeds, point.beyond, point.impact,
        point.touch_phase, float(orbit.blow_energies.mean()),
    )  # fmt: skip


# -- as bytes --


def packed(lines: Sequence[DiagramBranch | DiagramRestBranch], room: int) -> tuple[bytes, int]:
    """Branches as bytes, as many as there is room for, and how many of them that are."""
    kept = len(lines)
    while True:
        made = zlib.compress(json.dumps([_plain(line) for line in lines[:kept]]).encode(), 6)
        if len(made) <= room or not kept:
            return made, kept
        kept = min(kept - 1, int(kept * room / len(made)))


def lines_from(data: bytes) -> list[DiagramBranch | DiagramRestBranch]:
    """The branches that bytes hold; `packed` backwards."""
    return [_line(row) for row in json.loads(zlib.decompress(data))]


def _plain(line: DiagramBranch | DiagramRestBranch) -> dict[str, Any]:
    if isinstance(line, DiagramRestBranch):
        return line.plain
    arrays = {name: getattr(line, name).tolist() for name in ("values", "times", "speeds", "energies", "unstable")}
    scales = None if line.scales is None else line.scales.tolist()
    return {
        "impacts": line.impacts,
        "periods": line.periods,
        **arrays,
        "points": [point.plain for point in line.points],
        "scales": scales,
        "possible": line.possible,
    }


_KINDS: dict[str, BranchEvent] = {kind.value: kind for kind in BranchEvent}


def _line(row: dict[str, Any]) -> DiagramBranch | DiagramRestBranch:
    if "releases" in row:
        return DiagramRestBranch.of(row)
    points = tuple(DiagramPoint.of(point, _KINDS) for point in row["points"])
    p = row["impacts"]
    return DiagramBranch(
        p, row["periods"], np.array(row["values"]), np.array(row["times"]).reshape(-1, p),
        np.array(row["speeds"]).reshape(-1, p), np.array(row["energies"]), np.array(row["unstable"], dtype=np.int64),
        points, None if row["scales"] is None else np.array(row["scales"]), row["possible"],
    )  # fmt: skip
