"""What a diagram consists of: what simulations settle on, and branches, also as the bytes that an archive keeps."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.orbit_curve import SolutionCurve
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, Walk, unit_of
from percuss.explore.family import Family
from percuss.model import Machine, System
from percuss.model.checks import Array
from percuss.short_repr import ShortRepr
from percuss.steady.periodic.periodic_orbit import differences

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class SettledMotion(ShortRepr):
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


def line_of(branch: Branch, system: Callable[[float], Any]) -> Branch:
    """A followed branch whose motions are plain numbers, with their energies; `system`: the hammer at a value."""
    scales = np.array([_scales(_system(system, value)) for value in branch.values.tolist()])
    points = tuple(point.plainly for point in branch.points)
    energies = np.array([motion.blow_energy for motion in branch.motions], dtype=np.float64)
    known = scales if np.isfinite(scales).any() else None
    return replace(branch, points=points, energies=energies, scales=known, motions=(), switched=())


def _system(system: Callable[[float], Any], value: float) -> Any:
    try:
        return system(value)
    except PercussError:  # an end beyond which there is none
        return None


def _scales(hammer: System | Machine | None) -> tuple[float, float]:
    return (np.nan, np.nan) if hammer is None or not hammer.is_si else (hammer.speed_scale, hammer.energy_scale)


# -- as bytes --


def packed(lines: Sequence[Branch], room: int) -> tuple[bytes, int]:
    """Branches as bytes, as many as there is room for, and how many of them that are."""
    kept = len(lines)
    while True:
        made = zlib.compress(json.dumps([line.as_json() for line in lines[:kept]]).encode(), 6)
        if len(made) <= room or not kept:
            return made, kept
        kept = min(kept - 1, int(kept * room / len(made)))


def lines_from(data: bytes) -> list[Branch]:
    """The branches that bytes hold; `packed` backwards."""
    return [Branch.from_json(row) for row in json.loads(zlib.decompress(data))]


# ---- One branch, found twice: by itself and by switching, from two of its orbits, from both of its ends

_NEAR = 0.02  # rad, within which rows of two walks along one branch may be apart
_LOCATED = 1e-8  # of the parameter, to which points of two walks are the same
_UNLOCATED = (BranchEvent.LOST, BranchEvent.STOPPED)
_ROWS = (0.25, 0.5, 0.75)  # of a branch, at which it is compared with another


def with_new(known: list[Branch], found: list[Branch]) -> list[Branch]:
    """Branches, and those of others that are not among them: a doubled orbit is found by itself, and by switching."""
    every = list(known)
    for line in found:
        if not any(_holds(other, line) for other in every):
            every.append(line)
    return every


def _holds(other: Branch, line: Branch) -> bool:
    if (other.label, other.possible) != (line.label, line.possible):
        return False
    if _tells_the_same(other, line):
        return True
    rows = {int(share * (line.values.size - 1)) for share in _ROWS}
    return all(_is_near(other, float(line.values[row]), line.times[row]) for row in rows)


def _tells_the_same(other: Branch, line: Branch) -> bool:
    """Whether all that is located on a branch is located on another: through each such orbit goes one curve."""
    located = [point for point in line.points if point.kind not in _UNLOCATED]
    return bool(located) and all(any(_one_point(point, its) for its in other.points) for point in located)


def _one_point(point: BranchPoint, other: BranchPoint) -> bool:
    """Whether two points are one: what happens, where, and the impacts, whichever is the first."""
    if (point.kind, point.plain.label) != (other.kind, other.plain.label):
        return False
    if abs(point.value - other.value) > _LOCATED * (1.0 + abs(point.value)):
        return False
    if point.plain.phases.size != other.plain.phases.size:  # a chatter, told further by one of them
        return True
    off = np.abs(np.exp(1j * point.plain.phases)[:, None] - np.exp(1j * other.plain.phases)[None, :])
    return bool(max(off.min(axis=0).max(), off.min(axis=1).max()) < _NEAR)


def goes_through(line: Branch, periods: int, value: float, times: Array) -> bool:
    """Whether a branch of possible orbits has one with nearly these impacts in so many load periods."""
    return line.possible and (line.impacts, line.periods) == (times.size, periods) and _is_near(line, value, times)


def _apart(times: Array, others: Array) -> Array:
    """How far impacts lie apart, counted from the first; of two chatters that are one the longer is told further."""
    told = min(times.size, others.size)
    return np.asarray(np.abs((times[:told] - times[0]) - (others[:told] - others[0])))


def _is_near(line: Branch, value: float, times: Array) -> bool:
    """Whether a branch has an orbit near given times."""
    if line.is_machine:
        return any(bool(np.all(_apart(times, at) < _NEAR / _TURN * at[-1])) for at in line.times_at(value))
    period = _TURN * line.periods
    return any(
        float(np.abs(differences(times, at[None, :], period, _TURN)).max(axis=-1).min()) < _NEAR
        for at in line.times_at(value)
    )


# ---- Roots of the equations beyond an end of a branch: no motions, as the bar would pass the wall or strike backwards

_ENDS = {BranchEvent.TOUCH, BranchEvent.DEATH}
_MOST = 150
_TRIED = 1e-3
_SHOWN = 0.1  # share of the range for which they are followed


def beyond_the_ends(
    branches: Sequence[Branch], family: Family, between: tuple[float, float], stopped: Callable[[], bool]
) -> list[Branch]:
    """Each branch continued smoothly beyond its grazings for a tenth: the equations know nothing of the wall."""
    found = []
    for branch in branches:
        for point in {id(one): one for one in branch.ends}.values():
            if point.kind not in _ENDS or stopped():
                continue
            line = _beyond(branch, point, family, between)
            if line is not None:
                found.append(line)
    return found


def _beyond(branch: Branch, end: BranchPoint, family: Family, between: tuple[float, float]) -> Branch | None:
    """The roots beyond one end; None where Newton's method finds none."""
    unit, shown = unit_of(between, end.value), _SHOWN * (between[1] - between[0])
    curve = SolutionCurve(family, branch.parameter, branch.impacts, branch.periods, branch.modes, unit)
    bounds = max(between[0], end.value - shown), min(between[1], end.value + shown)
    try:
        start = _leaving(curve, curve.unknowns(end.orbit, end.value))
        points = [] if start is None else Walk(curve, start, (bounds,)).walked(_MOST).points
        motions = [curve.motion(point.x) for point in points]
        energies = [float(motion.blow_energies.mean()) for motion in motions]
    except (PercussError, CorrectorFailed, np.linalg.LinAlgError):
        return None
    if len(points) < 2 or points[1] is points[0]:
        return None
    scales = [(one.system.speed_scale, one.system.energy_scale) for one in motions if one.system.is_si]
    return Branch(
        parameters=branch.parameters, label=branch.label, modes=branch.modes,
        values=np.array([curve.value(point.x) for point in points]),
        times=np.array([motion.times for motion in motions]),
        speeds=np.array([motion.speeds for motion in motions]),
        energies=np.array(energies), unstable=np.full(len(points), -1), points=(),
        scales=np.array(scales) if len(scales) == len(points) else None, possible=False,
    )  # fmt: skip


def _leaving(curve: SolutionCurve, x: Array) -> CurvePoint | None:
    """The end with the tangent that leads away from what is possible; None where neither way does."""
    tangent = np.linalg.svd(curve.matrix(x))[2][-1]
    for way in (tangent, -tangent):
        try:
            tried = curve.corrected(x + _TRIED * way, way)
        except CorrectorFailed:
            continue
        if not curve.motion(tried.x).admissible:
            return CurvePoint(x, way, 0)
    return None
