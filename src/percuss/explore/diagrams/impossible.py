"""Roots of the equations beyond an end of a branch: no motions, as the bar would pass the wall or strike backwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch, BranchPoint
from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve
from percuss.explore.diagrams.lines import DiagramBranch
from percuss.explore.family import Family
from percuss.model.checks import Array

__all__ = ["beyond_the_ends"]

_ENDS = {BranchEvent.TOUCH, BranchEvent.DEATH}
_FIRST, _LONGEST, _SHORTEST = 0.02, 0.1, 1e-4  # steps, of each impact in rad
_MOST = 150
_UNITS = 4.0  # of the range of the parameter, which count as a step of 1 rad
_TRIED = 1e-3
_SHOWN = 0.1  # share of the range for which they are followed


def beyond_the_ends(
    branches: Sequence[Branch], family: Family, between: tuple[float, float], stopped: Callable[[], bool]
) -> list[DiagramBranch]:
    """The continuation of each branch beyond its grazings, for a tenth of the range.

    The equations for the times of the impacts know nothing of the wall between them, nor of the sign of a speed, so
    that their solutions go on smoothly.
    """
    found = []
    for branch in branches:
        for point in {id(one): one for one in branch.ends}.values():
            if point.kind not in _ENDS or stopped():
                continue
            line = _beyond(branch, point, family, between)
            if line is not None:
                found.append(line)
    return found


def _beyond(branch: Branch, end: BranchPoint, family: Family, between: tuple[float, float]) -> DiagramBranch | None:
    """The roots beyond one end; None where Newton's method finds none."""
    unit = 2.0 ** round(math.log2((between[1] - between[0]) / _UNITS))
    curve = SolutionCurve(family, branch.parameter, branch.impacts, branch.periods, branch.modes, unit)
    try:
        start = _leaving(curve, curve.unknowns(end.orbit, end.value))
        points = [] if start is None else _walked(curve, start, between)
        motions = [curve.motion(point.x) for point in points]
        energies = [float(motion.blow_energies.mean()) for motion in motions]
    except (PercussError, Strayed, np.linalg.LinAlgError):
        return None
    if len(points) < 2:
        return None
    scales = [(one.system.speed_scale, one.system.energy_scale) for one in motions if one.system.is_si]
    return DiagramBranch(
        branch.impacts, branch.periods,
        values=np.array([curve.value(point.x) for point in points]),
        times=np.array([motion.times for motion in motions]),
        speeds=np.array([motion.speeds for motion in motions]),
        energies=np.array(energies), unstable=np.full(len(points), -1), points=(),
        scales=np.array(scales) if len(scales) == len(points) else None, possible=False,
    )  # fmt: skip


def _leaving(curve: SolutionCurve, x: Array) -> CurvePoint | None:
    """The end with the tangent that leads away from what is possible; None where neither way does."""
    orbit = curve.motion(x)
    tangent = np.linalg.svd(curve.matrix(orbit, curve.column(orbit, curve.value(x))))[2][-1]
    for way in (tangent, -tangent):
        try:
            tried = curve.corrected(x + _TRIED * way, way)
        except Strayed:
            continue
        if not curve.motion(tried.x).admissible:
            return CurvePoint(x, way, 0)
    return None


def _walked(curve: SolutionCurve, start: CurvePoint, between: tuple[float, float]) -> list[CurvePoint]:
    """Points along the curve from a start, as far as they are shown, or as Newton's method goes."""
    first, shown = curve.value(start.x), _SHOWN * (between[1] - between[0])
    points, size = [start], _FIRST * math.sqrt(curve.impacts)
    longest = _LONGEST * math.sqrt(curve.impacts)
    while len(points) < _MOST and size > _SHORTEST:
        here = points[-1]
        try:
            found = curve.corrected(here.x + size * here.tangent, here.tangent)
        except Strayed:
            size *= 0.5
            continue
        times = found.x[: curve.impacts]
        if float(found.tangent @ here.tangent) < 0.9 or np.any(np.diff(times) <= 0.0):
            size *= 0.5
            continue
        value = curve.value(found.x)
        if abs(value - first) > shown or not between[0] <= value <= between[1]:
            break
        points.append(found)
        size = min(1.5 * size, longest)
    return points
