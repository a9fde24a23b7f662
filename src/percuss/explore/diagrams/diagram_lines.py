"""The branches of a diagram as plain numbers, and as bytes in which an archive keeps them."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.continuation.branch import Branch, BranchEvent, BranchPoint
from percuss.explore.continuation.rest_following import RestBranch, RestBranchPoint, RestEvent
from percuss.explore.continuation.solution_curve import CurvePoint, SolutionCurve, Strayed
from percuss.explore.family import Family
from percuss.model import System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady import PeriodicOrbit, RestCycle
from percuss.steady.periodic.periodic_orbit import differences

# ---- What happens at a point of a line of a diagram

_PLAIN = ("value", "label", "beyond", "impact", "touch_phase", "energy")


@dataclass(frozen=True)
class DiagramPoint(Shown):
    """A point of a branch at which something happens; dimensionless, phases in radians.

    Parameters
    ----------
    kind
        What happens.
    value
        Of the parameter.
    label
        Of the motion there: z=p/n, chatter/n or rest/n.
    phases, speeds
        Of its impacts; shape (p,). Of a cycle with rest those that its branch has.
    beyond
        What lies beyond, in a sentence.
    impact
        Number, from 1 on, of the impact of these that dies or meets a step; or None.
    touch_phase
        Phase of the load at which the bar touches the wall; or None.
    energy
        Mean kinetic energy before an impact; of a cycle with rest, before a main blow.
    """

    kind: BranchEvent | RestEvent
    value: float
    label: str
    phases: Array = field(repr=False)
    speeds: Array = field(repr=False)
    beyond: str
    impact: int | None = None
    touch_phase: float | None = None
    energy: float = np.nan

    def __str__(self) -> str:
        return f"{self.kind.value} of {self.label} at {self.value:.12g}: {self.beyond}"

    @property
    def plain(self) -> dict[str, Any]:
        """Of JSON's types."""
        texts = {"kind": self.kind.value, "phases": self.phases.tolist(), "speeds": self.speeds.tolist()}
        return texts | {name: getattr(self, name) for name in _PLAIN}

    @classmethod
    def of(cls, row: Mapping[str, Any], kinds: Mapping[str, BranchEvent | RestEvent]) -> DiagramPoint:
        """A point from what was its `plain`; `kinds`: what may happen, by the words for it."""
        phases, speeds = np.array(row["phases"]), np.array(row["speeds"])
        return cls(kind=kinds[row["kind"]], phases=phases, speeds=speeds, **{name: row[name] for name in _PLAIN})


# ---- The branches of cycles with rest in a diagram: as plain numbers, of each chatter the first impacts

KEPT_IMPACTS = 8
"""Impacts after each release that are kept, at most: those of a chatter have no last one."""

_TURN = 2.0 * np.pi
_ARRAYS = ("values", "releases", "rests", "times", "speeds", "energies")
_REST_KINDS: dict[str, RestEvent] = {kind.value: kind for kind in RestEvent}


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
        points = tuple(DiagramPoint.of(point, _REST_KINDS) for point in row["points"])
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
        points=tuple(map(_rest_point, branch.points, energies[len(cycles) :].tolist())),
        scales=np.array(scales) if len(scales) == len(cycles) else None,
    )  # fmt: skip


def _rest_point(point: RestBranchPoint, energy: float) -> DiagramPoint:
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


# ---- The branches of a diagram as plain numbers, and as bytes in which an archive keeps them


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


# ---- One branch, found twice: by itself and by switching, from two of its orbits, from both of its ends

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
    return all(_is_near(other, float(line.values[row]), line.times[row]) for row in rows)


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


def goes_through(line: DiagramBranch, periods: int, value: float, times: Array) -> bool:
    """Whether a branch of possible orbits has one with nearly these impacts in so many load periods."""
    return line.possible and (line.impacts, line.periods) == (times.size, periods) and _is_near(line, value, times)


def _is_near(line: DiagramBranch, value: float, times: Array) -> bool:
    """Whether a branch has an orbit near given times."""
    period = _TURN * line.periods
    return any(
        float(np.abs(differences(times, at[None, :], period, _TURN)).max(axis=-1).min()) < _NEAR
        for at in line.times_at(value)
    )


# ---- Roots of the equations beyond an end of a branch: no motions, as the bar would pass the wall or strike backwards

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
