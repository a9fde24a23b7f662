"""Which motions are the same: attractors, told apart by labels and by the numbers of their cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.cycles import COLUMNS, cycles_of
from percuss.explore.jobs.job import Columns
from percuss.model.checks import Array
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.simulate import Starts, Stop

__all__ = ["DISTANCE", "Attractor", "attractors_of", "grouped", "labels", "matched"]

DISTANCE = 1e-4
"""How far apart, in radians and relative speeds, motions of one label are different attractors."""

_FINITE = {"rest": 0, "departed": 1, "aperiodic": 2, "undecided": 3}


@dataclass(frozen=True)
class Attractor(Shown):
    """A motion that others settle on; dimensionless, phases and times in radians.

    Parameters
    ----------
    number
        0 for the most frequent.
    label
        As `Trajectory.label` has it.
    members, first
        How many of the motions settle on it, and the first of them.
    phases, impact_velocities
        Of the impacts of one cycle, in order of time from the fastest on; empty when it is not periodic.
    blow_rate, main_blow_rate
        Impacts per load period, means over the members; main: a completed chatter counted once. NaN without impacts.
    scatter, main_scatter
        Standard deviation of the times between impacts over their mean, mean over the members.
    impact_velocity, blow_energy
        Of the main blows, means over the members.
    """

    number: int
    label: str
    members: int
    first: int
    phases: tuple[float, ...]
    impact_velocities: tuple[float, ...]
    blow_rate: float
    main_blow_rate: float
    scatter: float
    main_scatter: float
    impact_velocity: float
    blow_energy: float

    @property
    def mark(self) -> str:
        """What tells it from others of its label: the phase of its fastest impact."""
        return f"at {self.phases[0]:.3f}" if self.phases else ""

    @property
    def figures(self) -> dict[str, Any]:
        """Phases and speeds of its impacts by name, of JSON's types."""
        return {"phases": list(self.phases), "impact_velocities": list(self.impact_velocities)}


def _keys(columns: Columns) -> npt.NDArray[np.int64]:
    """A whole number for each label: equal keys, equal labels."""
    from percuss.simulate import OUTCOMES

    code, n = columns["code"].astype(np.int64), columns["cycle_periods"].astype(np.int64)
    kind, p = columns["cycle_kind"].astype(np.int64), columns["cycle_impacts"].astype(np.int64)
    key = np.where(columns["wanders"], _FINITE["aperiodic"], _FINITE["undecided"])
    key = np.where(n > 0, _PERIODIC + kind + 3 * (n * (int(p.max(initial=0)) + 1) + np.where(kind == 0, p, 0)), key)
    for name in ("rest", "departed"):
        key = np.where(code == OUTCOMES.index(name), _FINITE[name], key)
    return np.asarray(key, dtype=np.int64)


def labels(columns: Columns) -> npt.NDArray[np.str_]:
    """What motion each is at its end, as `Trajectory.label`."""
    key = _keys(columns)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    return np.array([_label(columns, int(i), int(key[i])) for i in first], dtype=str)[which.reshape(-1)]


def _label(columns: Columns, i: int, key: int) -> str:
    if key < _PERIODIC:
        return next(name for name, number in _FINITE.items() if number == key)
    p, n, kind = (int(columns[name][i]) for name in ("cycle_impacts", "cycle_periods", "cycle_kind"))
    return (f"z={p}/{n}", f"rest/{n}", f"chatter/{n}")[kind]


def matched(columns: Columns, scale: float, distance: float = DISTANCE) -> npt.NDArray[np.int64]:
    """The number of the attractor of each motion, 0 for the most frequent.

    Motions of one label are one attractor unless their invariants leave a gap: they are cut apart wherever, in the
    order of one of the numbers, two neighbours differ by more than `distance`. What is spread by an early end of a slow
    approach therefore stays together, and so do motions that differ by whole load periods: their phases are the same.
    Motions that are not periodic are told apart by their labels alone.

    Parameters
    ----------
    columns
        At least ``code``, ``cycle_*``, ``wanders`` and ``invariants`` of `COLUMNS`, shape (motions, …).
    scale
        Speed scale Σ|p_k| of the load.
    distance
        In radians, and in speeds relative to the scale plus the speed; dimensionless.
    """
    key = _keys(columns)
    values = columns["invariants"].copy()
    values[:, :2] /= (scale, scale * scale)
    values[:, 1] = np.sqrt(values[:, 1])
    values[:, :2] = np.arcsinh(values[:, :2])  # differences relative to 1 + x
    return grouped(key, values, _PERIODIC, distance)


_PERIODIC = 4  # the least key of a motion with a cycle


def grouped(key: npt.NDArray[np.int64], values: Array, periodic_from: int, distance: float) -> npt.NDArray[np.int64]:
    """The number of the group of each motion, 0 for the greatest; see `matched`.

    Parameters
    ----------
    key
        Equal for motions that may be of one group, shape (motions,).
    values
        The numbers that tell motions of one key apart, shape (motions, numbers).
    periodic_from
        The least key of motions that have such numbers.
    distance
        The least gap between two groups.
    """
    values = np.where(np.isfinite(values), values, 1e9)
    order = np.argsort(key, kind="stable")
    cuts = np.flatnonzero(np.diff(key[order])) + 1
    groups: list[npt.NDArray[np.intp]] = []
    todo = [(part, bool(key[part[0]] >= periodic_from)) for part in np.split(order, cuts) if part.size]
    while todo:
        part, periodic = todo.pop()
        pieces = _cut(part, values[part], distance) if periodic else [part]
        if len(pieces) == 1:
            groups.append(part)
        else:
            todo.extend((piece, True) for piece in pieces)
    groups.sort(key=lambda part: (-part.size, int(part.min())))
    number = np.empty(key.size, dtype=np.int64)
    for i, part in enumerate(groups):
        number[part] = i
    return number


def _cut(part: npt.NDArray[np.intp], values: Array, distance: float) -> list[npt.NDArray[np.intp]]:
    """A group, cut at the gaps of the first of the numbers that has any."""
    for j in np.flatnonzero(values.max(axis=0) - values.min(axis=0) > distance):
        order = np.argsort(values[:, j], kind="stable")
        gaps = np.flatnonzero(np.diff(values[order, j]) > distance) + 1
        if gaps.size:
            return np.split(part[order], gaps)
    return [part]


def attractors_of(
    columns: Columns, number: npt.NDArray[np.int64], system: System, starts: Starts, modes: int, stop: Stop
) -> tuple[Attractor, ...]:
    """The attractors behind the numbers; the impacts are those of the first member, followed once more.

    `starts`: of the motions, in the same order.
    """
    if not number.size:
        return ()
    _, first, members = np.unique(number, return_index=True, return_counts=True)
    cycles = cycles_of(columns, first, system, starts, modes, stop)
    means = {name: _means(columns[name], number) for name in _MEANS}
    for name in ("interval", "main_interval"):
        with np.errstate(divide="ignore", invalid="ignore"):
            means[name] = _means(columns[f"{name}_std"] / columns[f"{name}_mean"], number)
    names = labels({name: columns[name][first] for name in COLUMNS})
    return tuple(
        Attractor(
            i, str(names[i]), int(members[i]), int(first[i]), *cycles[i],
            *(float(means[name][i]) for name in (*_MEANS[:2], "interval", "main_interval", *_MEANS[2:])),
        )
        for i in range(first.size)
    )  # fmt: skip


_MEANS = ("blow_rate", "main_blow_rate", "impact_velocity", "blow_energy")


def _means(values: Array, number: npt.NDArray[np.int64]) -> Array:
    """The mean of each group over what is known of it; NaN when nothing is."""
    known = np.isfinite(values)
    most = int(number.max()) + 1
    sums = np.bincount(number[known], weights=values[known], minlength=most)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(sums / np.bincount(number[known], minlength=most))
