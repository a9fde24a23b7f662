"""Which motions are the same: attractors, told apart by labels and by the numbers of their cycles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.drawn_starts import some
from percuss.explore.jobs.job import Column, Columns
from percuss.model.checks import Array
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.model import Machine, System
    from percuss.simulate import Ensemble, Start, Starts, Stop


# ---- Motions followed to the cycles that they settle on, and the numbers by which cycles are told apart

INVARIANTS = 8
_BLOCK = 2048  # members at once: the impacts kept of them take some MB
_PORTION = 1_000_000  # impacts between two looks at whether the answer is still wanted
_WINDOW = 256  # last impacts kept; the engine classifies by as many
_LONGEST = 1 << 16  # impacts of the longest cycle whose impacts are looked at
_KEPT = 1 << 20  # impacts kept at once, some tens of MB

COLUMNS: dict[str, Column] = {
    "code": Column("int8", meaning="how the simulation ended, its number in percuss.simulate.OUTCOMES"),
    "impacts": Column("int64", meaning="impacts from the start"),
    "first": Column("int64", fill=-2, meaning="impact, from 0, at which the periodic motion begins; -1: none found"),
    "cycle_impacts": Column("int64", meaning="impacts of the periodic motion; 0: none found"),
    "cycle_periods": Column("int64", unit="load periods", meaning="length of the periodic motion; 0: none found"),
    "cycle_kind": Column("int8", meaning="periodic motion without rest (0), with rest (1), with chatter and rest (2)"),
    "wanders": Column("bool", meaning="whether the last impacts do not come near any earlier ones"),
    "phase": Column(unit="rad", meaning="load phase of the fastest impact of the periodic motion"),
    "striking_speed": Column(meaning="speed of the fastest impact of the periodic motion"),
    "invariants": Column(shape=(INVARIANTS,), meaning="of the set of impacts of the periodic motion"),
    "blow_rate": Column(unit="1/load period", meaning="impacts per load period"),
    "main_blow_rate": Column(unit="1/load period", meaning="impacts per load period, each chatter counted once"),
    "interval_mean": Column(unit="rad", meaning="mean time between impacts"),
    "interval_std": Column(unit="rad", meaning="standard deviation of the time between impacts"),
    "main_interval_mean": Column(unit="rad", meaning="mean time between main blows"),
    "main_interval_std": Column(unit="rad", meaning="standard deviation of the time between main blows"),
    "impact_velocity": Column(meaning="mean striking speed of the main blows"),
    "blow_energy": Column(meaning="mean kinetic energy just before a main blow"),
}
"""What is kept of every motion."""


def followed(
    system: System, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
) -> Columns:
    """`COLUMNS` of the motions from all starts, each by itself."""
    from percuss.simulate import simulate_many

    parts: list[Columns] = []
    # simulate_many looks up 16 times for each thread: long motions in small blocks, so that it soon sees `stopped`
    size = int(np.clip(16 * _PORTION // max(stop.most_impacts, 1), 16, _BLOCK))
    for i in range(0, len(starts), size):
        block = some(starts, slice(i, i + size))
        many = simulate_many(
            system, block, modes=modes, stop=stop, keep=_WINDOW, threads=threads, progress=lambda _: stopped()
        )
        parts.append(_columns(many, system.load.harmonics))
        if stopped():
            break
    found = {name: np.concatenate([part[name] for part in parts]) for name in COLUMNS}
    for rows, keep in _long(found["cycle_impacts"]):
        if stopped():
            break
        again = simulate_many(system, some(starts, rows), modes=modes, stop=stop, keep=keep, threads=threads)
        more = _columns(again, system.load.harmonics)
        for name in ("phase", "striking_speed", "invariants"):
            found[name][rows] = more[name]
    return found


def _long(impacts: npt.NDArray[np.int64]) -> Iterator[tuple[npt.NDArray[np.intp], int]]:
    """Members whose cycle is longer than what is kept of all, in portions, and how many impacts to keep of them.

    That number is the power of 2 that their own cycle asks for, so that nothing depends on the company of a member: the
    engine looks for cycles in as many impacts as are kept.
    """
    keep = _WINDOW
    while keep < _LONGEST:
        keep *= 2
        rows = np.flatnonzero((impacts > keep // 2) & (impacts <= keep))
        at_once = max(_KEPT // keep, 1)
        for i in range(0, rows.size, at_once):
            yield rows[i : i + at_once], keep


def _columns(many: Ensemble, harmonics: npt.NDArray[np.int64]) -> Columns:
    assert many.last_phase is not None and many.last_velocity is not None
    kept = many.last_phase.shape[1]
    impacts = np.where(many.cycle_impacts <= kept, many.cycle_impacts, 0)
    invariants, phase, speed = invariants_of(
        many.last_phase, many.last_velocity, impacts, many.cycle_periods, harmonics
    )
    made: Columns = {"phase": phase, "striking_speed": speed, "invariants": invariants}
    for name, column in COLUMNS.items():
        if name not in made:
            made[name] = np.asarray(getattr(many, name)).astype(column.dtype)
    return made


def invariants_of(
    phases: Array, speeds: Array, impacts: npt.NDArray[np.int64], periods: npt.NDArray[np.int64], harmonics: Any
) -> tuple[Array, Array, Array]:
    """Invariants of the last `impacts` impacts of each row, and phase and speed of the fastest of them.

    Sums over the impacts of a cycle do not depend on which of them comes first, and cosine and sine know no seam at
    2π; weights v² and v³ leave the smallest impacts of a chatter, of which there may be one more or less, without
    weight. Phases count modulo the true period of the load, 2π over the greatest common divisor of its harmonics.
    """
    turn = float(reduce(math.gcd, (int(k) for k in harmonics), 0) or 1)
    rows, most = impacts.size, int(impacts.max(initial=0))
    sums = np.zeros((INVARIANTS, rows))
    top, at = np.full(rows, -1.0), np.full(rows, np.nan)  # speeds of impacts are not below 0
    for j in range(most):  # one impact of all rows after the other: the same sums, to the bit, whatever the other rows
        here = impacts > j
        phi = np.where(here, phases[:, phases.shape[1] - 1 - j], 0.0)
        v = np.where(here, speeds[:, phases.shape[1] - 1 - j], 0.0)
        square = v * v
        cube = square * v
        c, s = np.cos(turn * phi), np.sin(turn * phi)
        for k, term in enumerate((square, cube, square * c, square * s, cube * c, cube * s)):
            sums[k] += term
        sums[6] += square * (c - s) * (c + s)  # cos 2φ and sin 2φ
        sums[7] += square * (2.0 * c * s)
        # the fastest; of several equally fast ones that of the least phase
        better = here & np.where(np.abs(v - top) <= 1e-7 * v, phi < at, v > top)
        top, at = np.where(better, v, top), np.where(better, phi, at)
    none = impacts == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        square, cube = sums[0].copy(), sums[1].copy()
        sums[0], sums[1] = cube / square, square / periods
        sums[2:4] /= square
        sums[4:6] /= cube
        sums[6:8] /= square
    sums[:, none] = np.nan
    return np.ascontiguousarray(sums.T), np.where(none, np.nan, at), np.where(none, np.nan, top)


Impacts = tuple[tuple[float, ...], tuple[float, ...]]


def cycles_of(
    columns: Columns, which: npt.NDArray[np.intp], system: System, starts: Starts, modes: int, stop: Stop
) -> list[Impacts]:
    """Phases and striking speeds of one cycle of some of the motions, in order of time from the fastest impact on."""
    from percuss.simulate import simulate_many

    found: list[Impacts] = [((), ())] * which.size
    settled = columns["cycle_impacts"][which]
    short = np.flatnonzero((settled > 0) & (settled <= _WINDOW))
    for rows, keep in [*([(short, _WINDOW)] if short.size else []), *_long(settled)]:
        many = simulate_many(system, some(starts, which[rows]), modes=modes, stop=stop, keep=keep, threads=1)
        assert many.last_phase is not None and many.last_velocity is not None
        for i, row in enumerate(rows.tolist()):
            p = int(many.cycle_impacts[i])
            if 0 < p <= keep:
                found[row] = _from_fastest(many.last_phase[i, keep - p :], many.last_velocity[i, keep - p :])
    return found


def _from_fastest(phases: Array, speeds: Array) -> Impacts:
    fast = np.flatnonzero(speeds >= (1.0 - 1e-7) * speeds.max())
    begin = int(fast[np.argmin(phases[fast])])
    return tuple(np.roll(phases, -begin).tolist()), tuple(np.roll(speeds, -begin).tolist())


# ---- Which motions are the same: attractors, told apart by labels and by the numbers of their cycles

DISTANCE = 1e-4
"""How far apart, in radians and relative speeds, motions of one label are different attractors."""

_FINITE = {"rest": 0, "departed": 1, "aperiodic": 2, "undecided": 3, "rest/?": 4, "chatter/?": 5}


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
    key = np.where(kind > 0, _FINITE["rest/?"] + kind - 1, key)
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


_PERIODIC = 6  # the least key of a motion with a cycle


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


# ---- Motions of machines that switch their own valves, followed to what they settle on, as columns of numbers

_MACHINE_BLOCK = 1024  # members at once

MACHINE_COLUMNS: dict[str, Column] = {
    "code": Column("int8", meaning="how the simulation ended, its number in percuss.simulate.OUTCOMES"),
    "stall": Column("int8", meaning="where it stalls, its number in percuss.simulate.STALLS; -1: it does not"),
    "impacts": Column("int64", meaning="impacts from the start"),
    "end_time": Column(unit="machine's unit of time", meaning="time from the start to the last event"),
    "blows": Column("int64", meaning="main blows in a period; 0: none, or no period was found"),
    "valve_cycles": Column("int64", meaning="how often the valve comes to the same state in a period; 0: none found"),
    "cycle_kind": Column("int8", meaning="periodic motion without rest (0), with rest (1), with chatter and rest (2)"),
    "wanders": Column("bool", meaning="whether the last changes of the valve do not come near any earlier ones"),
    "period": Column(unit="machine's unit of time", meaning="of the periodic motion"),
    "blow_speed": Column(meaning="striking speed of the strongest blow of a period"),
    "energy_lost": Column(meaning="what blows, chatter and rest take in a period, per unit of mass"),
}
"""What is kept of every motion."""


def machines_followed(
    machine: Machine,
    starts: Starts,
    modes: int,
    stop: Stop,
    threads: int | None,
    stopped: Callable[[], bool],
) -> Columns:
    """`MACHINE_COLUMNS` of the motions from all starts, each by itself."""
    from percuss.simulate import simulate_many

    parts: list[Columns] = []
    own = {"blows": "cycle_impacts", "valve_cycles": "cycle_periods", "energy_lost": "energy_lost_per_period"}
    for first in range(0, len(starts), _MACHINE_BLOCK):
        block = some(starts, slice(first, first + _MACHINE_BLOCK))
        many = simulate_many(machine, block, modes=modes, stop=stop, threads=threads, progress=lambda _: stopped())
        parts.append({name: getattr(many, own.get(name, name)) for name in MACHINE_COLUMNS})
        if stopped():
            break
    return {
        name: np.concatenate([part[name] for part in parts]).astype(column.dtype)
        for name, column in MACHINE_COLUMNS.items()
    }


def motion_keys(columns: Columns) -> npt.NDArray[np.int64]:
    """A whole number for each label: equal keys, equal labels; from `PERIODIC` on of motions with a period."""
    from percuss.simulate import STALLS

    blows, turns = columns["blows"].astype(np.int64), columns["valve_cycles"].astype(np.int64)
    rests = np.minimum(columns["cycle_kind"].astype(np.int64), 1)
    size = int(blows.max(initial=0)) + 1
    key = np.where(columns["wanders"], len(STALLS), len(STALLS) + 1)
    key = np.where(turns > 0, PERIODIC + rests + 2 * (blows + size * turns), key)
    return np.asarray(np.where(columns["stall"] >= 0, columns["stall"].astype(np.int64), key), dtype=np.int64)


PERIODIC = 8


def machine_labels(columns: Columns) -> npt.NDArray[np.str_]:
    """What motion each is at its end, as `Trajectory.label`."""
    key = motion_keys(columns)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    return np.array([_machine_label(columns, int(i)) for i in first], dtype=str)[which.reshape(-1)]


def _machine_label(columns: Columns, i: int) -> str:
    from percuss.simulate import STALLS, Cycle
    from percuss.simulate.events import machine_label

    stall, turns = int(columns["stall"][i]), int(columns["valve_cycles"][i])
    cycle = None
    if turns:
        numbers = (float(columns[name][i]) for name in ("period", "energy_lost", "blow_speed"))
        cycle = Cycle(0, int(columns["blows"][i]), turns, int(columns["cycle_kind"][i]), *numbers)
    return machine_label(STALLS[stall] if stall >= 0 else "", cycle, bool(columns["wanders"][i]))


def blows_of(machine: Machine, start: Start, modes: int, stop: Stop) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Speeds and energies of the blows of one period, in order of time from the strongest on; empty without a period.

    The motion from a start, followed once more. Bounces of a chatter are no blows of their own.
    """
    from percuss.simulate import run

    motion = run(machine, start, modes=modes, stop=stop)
    cycle = motion.cycle
    if cycle is None or not cycle.impacts:
        return (), ()
    struck = motion.events.of("impact")
    last = float(motion.events.time[-1])
    inside = np.flatnonzero(struck.time > last - cycle.period * (1.0 - 1e-9))
    strongest = np.sort(np.argsort(-struck.impact_velocity[inside], kind="stable")[: cycle.impacts])
    main = inside[strongest]  # what bounces is weaker than the blow that it follows
    if not main.size:
        return (), ()
    order = np.roll(main, -int(np.argmax(struck.impact_velocity[main])))
    return tuple(struck.impact_velocity[order].tolist()), tuple(struck.kinetic_energy[order].tolist())


# ---- What machines that switch their own valves settle on, told apart by labels and by the numbers of their cycles


@dataclass(frozen=True)
class MachineAttractor(Shown):
    """A motion of a machine that others settle on; dimensionless.

    Parameters
    ----------
    number
        0 for the most frequent.
    label
        As `Trajectory.label` has it.
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
    columns: Columns, number: npt.NDArray[np.int64], machine: Machine, starts: Starts, modes: int, stop: Stop
) -> tuple[MachineAttractor, ...]:
    """The attractors behind the numbers; the blows are those of the first member, followed once more."""
    if not number.size:
        return ()
    _, first, members = np.unique(number, return_index=True, return_counts=True)
    names = machine_labels({name: columns[name][first] for name in columns if columns[name].shape == number.shape})
    found = []
    for i, row in enumerate(first.tolist()):
        settles = columns["blows"][row] > 0 and columns["stall"][row] < 0
        blows = blows_of(machine, starts[row], modes, stop) if settles else ((), ())
        period, lost = float(columns["period"][row]), float(columns["energy_lost"][row])
        found.append(MachineAttractor(i, str(names[i]), int(members[i]), row, period, *blows, lost))
    return tuple(found)
