"""One branch, found twice: by itself and by switching, from two of its orbits, from both of its ends."""

from __future__ import annotations

import numpy as np

from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.diagrams.lines import DiagramBranch
from percuss.explore.diagrams.points import DiagramPoint
from percuss.model.checks import Array
from percuss.steady.periodic.sameness import differences

__all__ = ["with_new"]

_TURN = 2.0 * np.pi
_NEAR = 0.02  # rad, within which rows of two walks along one branch may be apart
_LOCATED = 1e-8  # of the parameter, to which points of two walks are the same
_UNLOCATED = (BranchEvent.LOST, BranchEvent.STOPPED)
_ROWS = (0.25, 0.5, 0.75)  # of a branch, at which it is compared with another


def with_new(known: list[DiagramBranch], found: list[DiagramBranch]) -> list[DiagramBranch]:
    """Branches, and those of others that are not among them: a doubled orbit is found by itself, and by switching."""
    every = list(known)
    for line in found:
        if not any(_holds(other, line) for other in every):
            every.append(line)
    return every


def _holds(other: DiagramBranch, line: DiagramBranch) -> bool:
    """Whether a branch is another one, or a part of it."""
    if (other.impacts, other.periods, other.possible) != (line.impacts, line.periods, line.possible):
        return False
    if _tells_the_same(other, line):
        return True
    rows = {int(share * (line.values.size - 1)) for share in _ROWS}
    return all(_passes(other, float(line.values[row]), line.times[row]) for row in rows)


def _tells_the_same(other: DiagramBranch, line: DiagramBranch) -> bool:
    """Whether all that is located on a branch is located on another: through each such orbit goes one curve."""
    located = [point for point in line.points if point.kind not in _UNLOCATED]
    return bool(located) and all(any(_one_point(point, its) for its in other.points) for point in located)


def _one_point(point: DiagramPoint, other: DiagramPoint) -> bool:
    """Whether two points are one: what happens, where, and the impacts, whichever is the first."""
    if (point.kind, point.label) != (other.kind, other.label):
        return False
    if abs(point.value - other.value) > _LOCATED * (1.0 + abs(point.value)):
        return False
    off = np.abs(np.exp(1j * point.phases)[:, None] - np.exp(1j * other.phases)[None, :])
    return bool(max(off.min(axis=0).max(), off.min(axis=1).max()) < _NEAR)


def _passes(line: DiagramBranch, value: float, times: Array) -> bool:
    """Whether a branch has an orbit near given times."""
    period = _TURN * line.periods
    return any(
        float(np.abs(differences(times, at[None, :], period, _TURN)).max(axis=-1).min()) < _NEAR
        for at in line.times_at(value)
    )
