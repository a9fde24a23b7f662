"""What experiments follow: a system under a clock, or a machine that switches itself; which motions are the same."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.drawn_starts import (
    MODE,
    UNIT_OF_TIME,
    done,
    end_starts,
    farthest_port,
    speed_scale,
    starts_from,
    states_of,
)
from percuss.explore.jobs.job import Column, Columns
from percuss.model import Machine, System
from percuss.model.checks import Array, finite
from percuss.model.described import describe_machine, describe_system
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from percuss.simulate import Ensemble, Starts, Stop, Trajectory

# ---- Which motions are the same

CYCLE_KINDS = ("no rest", "rest", "chatter and rest")  # what a periodic motion has in it, by number

DISTANCE = 1e-4  # how far apart, in radians and relative speeds, motions of one label are different attractors


@dataclass(frozen=True)
class Attractor(ShortRepr):
    """A motion that others settle on; dimensionless, phases in radians.

    `number`: 0 for the most frequent. `members`, `first`: how many of the motions settle on it, and the first of them.
    `mark`: what tells it from others of its label. `figures`: its numbers by name, of JSON's types: of a system
    `phases` and `impact_velocities` of the impacts of one cycle, in order of time from the fastest on, empty when it is
    not periodic; of a machine `period`, `impact_velocities` and `blow_energies` of the blows of a period from the
    strongest on, and `energy_lost` in it, per unit of mass; None and empty without a period.
    """

    number: int
    label: str
    members: int
    first: int
    mark: str
    figures: dict[str, Any]


def seconds_of_start(modes: int, clock: bool = True) -> float:
    """Seconds that one start takes until its motion is found, by rule of thumb: the same on every computer."""
    return 3e-4 * (1.0 + modes / 8.0) if clock else 5e-4 * (1.0 + modes / 32.0)


class Hammer(ABC):
    """What is followed: what is kept of its motions, how they are followed, and which of them are the same.

    `kind`: its name in an archive. `columns`: what is kept of every motion. `units`: by which of its scales columns
    are multiplied for SI, and their unit then. `named_by`: the columns that the label of a motion follows from.
    `settled`: the column that is above 0 of those that became periodic. `words`: columns whose numbers stand for words.
    `about`: what a dataset says of the numbers as a whole. `speed`: the scale of speeds by which motions are told
    apart. `states`: the names of the valve's states; none under a clock. `kept`: last impacts kept of each member.
    """

    kind: ClassVar[str]
    columns: ClassVar[Mapping[str, Column]]
    units: ClassVar[Mapping[str, tuple[str, str]]]
    named_by: ClassVar[tuple[str, ...]]
    settled: ClassVar[str]
    what: System | Machine
    at: int
    words: Mapping[str, Sequence[str]]
    about: dict[str, Any]
    speed: float

    def __init__(self) -> None:
        self.states = states_of(self.what)

    @abstractmethod
    def check(self, modes: int) -> None:
        """Raise now what every start would: a resonance, say."""

    @abstractmethod
    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """`columns` of the motions from all starts, each by itself."""

    @classmethod
    @abstractmethod
    def tells_apart(cls, columns: Columns, speed: float) -> Array:
        """The numbers that tell motions of one label apart, shape (motions, numbers); NaN of those that have none."""

    @abstractmethod
    def figures(self, columns: Columns, row: int, motion: Trajectory | None) -> tuple[str, dict[str, Any]]:
        """`Attractor.mark` and `Attractor.figures` of a row; `motion`: the same once more, where it is periodic."""

    def value(self, where: str, name: object, value: object) -> tuple[str, float]:
        """A quantity of starts by its name, and its value as a number; ParameterError for another name or value."""
        third = "state" if self.states else "time"
        if name == third == "state":
            if value in self.states:
                return third, float(self.states.index(str(value)))
            if isinstance(value, int | float) and value in range(len(self.states)):
                return third, float(value)
            raise ParameterError(third, value, f"one of {', '.join(map(repr, self.states[:6]))}")
        if isinstance(name, str) and (name in ("position", "velocity", third) or MODE.fullmatch(name)):
            return name, finite(name, value)
        known = f"one of position, velocity, {third}, u_1, u_2, …, v_1, v_2, …"
        raise ParameterError(where, name, known, "no clock drives the machine" if name == "time" else "")

    def on_a_grid(self, grid: dict[str, Array]) -> Starts:
        """Starts of the striking end from columns of one length by name; what is not named is 0 or as usual."""
        bars = end_starts(self.what.body, self.at, {name: values for name, values in grid.items() if name != "state"})
        if not isinstance(self.what, Machine):
            return bars
        usual = np.array(self.states.index(self.what.valve.start or self.states[0]))
        return bars.with_valve(grid["state"].astype(np.int64) if "state" in grid else usual, self.states)

    @property
    def described(self) -> dict[str, Any]:
        """All that its motions depend on, of JSON's types."""
        what = self.what
        return {self.kind: describe_machine(what) if isinstance(what, Machine) else describe_system(what)}

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """What columns are multiplied by for SI, and their unit then; empty without scales."""
        if not self.what.is_si:
            return {}
        return {name: (float(getattr(self.what, scale)), unit) for name, (scale, unit) in self.units.items()}

    def _ensemble(
        self,
        starts: Starts,
        rows: Any,
        modes: int,
        stop: Stop,
        threads: int | None,
        stopped: Callable[[], bool],
        **more: Any,
    ) -> Ensemble:
        from percuss.simulate import simulate_many

        begun = starts[rows]
        return simulate_many(
            self.what, begun, modes=modes, stop=stop, workers=threads, progress=lambda _: stopped(), **more
        )

    def _of_blocks(
        self, size: int, number: int, stopped: Callable[[], bool], block: Callable[[slice], Columns]
    ) -> Columns:
        parts: list[Columns] = []
        for i in range(0, number, size):
            parts.append(block(slice(i, i + size)))
            if stopped():
                break
        return {
            name: np.concatenate([part[name] for part in parts]).astype(column.dtype, copy=False)
            for name, column in self.columns.items()
        }

    @classmethod
    def labels(cls, columns: Columns) -> npt.NDArray[np.str_]:
        """What motion each is at its end, as `Trajectory.label`."""
        from percuss.simulate.ensemble import labels_of

        return labels_of(*(columns[name] for name in cls.named_by))

    @classmethod
    def matched(cls, columns: Columns, speed: float, distance: float = DISTANCE) -> npt.NDArray[np.int64]:
        """The number of the attractor of each motion, 0 for the most frequent."""
        # Motions of one label are one attractor unless their numbers leave a gap: they are cut apart wherever, in the
        # order of one of the numbers, two neighbours differ by more than `distance`, in radians, relative periods, and
        # speeds relative to their scale plus the speed. What is spread by an early end of a slow approach therefore
        # stays together, and so do motions that differ by whole load periods: their phases are the same. Motions that
        # are not periodic are told apart by their labels alone.
        names, values = cls.marked(columns, speed)
        groups = _grouped(names, values, values, distance)
        groups.sort(key=lambda part: (-part.size, int(part.min())))
        number = np.empty(names.size, dtype=np.int64)
        for i, part in enumerate(groups):
            number[part] = i
        return number

    @classmethod
    def marked(cls, columns: Columns, speed: float) -> tuple[npt.NDArray[np.str_], Array]:
        """The label of each motion, and the numbers that tell it from others of its label, alike where it has none."""
        values = cls.tells_apart(columns, speed)
        return cls.labels(columns), np.where(np.isfinite(values), values, 1e9)

    def attractors(self, tally: StartTally, modes: int, stop: Stop) -> tuple[Attractor, ...]:
        """The attractors that were counted, with the figures of their first members, which are followed once more."""
        from percuss.simulate import run

        found: list[Attractor] = []
        starts = starts_from(tally.rows, self.states) if tally.members.size else None
        for i, (name, many, row) in enumerate(
            zip(tally.label, tally.members.tolist(), tally.first.tolist(), strict=True)
        ):
            assert starts is not None
            again = run(self.what, starts[i], modes=modes, stop=stop) if tally.rows[self.settled][i] > 0 else None
            found.append(Attractor(i, str(name), many, row, *self.figures(tally.rows, i, again)))
        return tuple(found)


class StartTally:
    """What motions settle on, counted as they come: memory for the attractors, not for the motions.

    Motions among which no number leaves a gap stay one attractor whatever comes besides, and of them only the ends
    of each number are needed to tell what else belongs to them: so the numbers are those of `Hammer.matched` for all
    at once, in any portions and any order.

    `label`, `members`, `first`, `rows`: of each attractor, the most frequent first, its label, how many settle on it,
    and the number and the columns of the first of them.
    """

    def __init__(self, hammer: Hammer, distance: float = DISTANCE) -> None:
        self._hammer, self._distance = hammer, distance
        self.label: npt.NDArray[np.str_] = np.empty(0, "U1")
        self.members, self.first = np.empty(0, np.int64), np.empty(0, np.int64)
        self.rows: Columns = {}
        self._low = self._high = np.empty(0)

    def add(self, first: int, columns: Columns) -> None:
        """The motions from number `first` on; those that are not done do not count."""
        here = np.flatnonzero(done(columns))
        if not here.size:
            return
        rows = {name: values[here] for name, values in columns.items()}
        members, number = np.ones(here.size, np.int64), first + here
        label, low, high = self._beside(rows)
        if self.rows:
            rows = {name: np.concatenate([self.rows[name], values]) for name, values in rows.items()}
            members, number = np.append(self.members, members), np.append(self.first, number)
        groups = [
            (-int(members[part].sum()), int(part[np.argmin(number[part])]), part)
            for part in _grouped(label, low, high, self._distance)
        ]
        groups.sort(key=lambda group: (group[0], number[group[1]]))
        self.members, heads = -np.array([many for many, _, _ in groups]), np.array([head for _, head, _ in groups])
        self._low = np.array([low[part].min(axis=0) for *_, part in groups])
        self._high = np.array([high[part].max(axis=0) for *_, part in groups])
        self.label, self.first = label[heads], number[heads]
        self.rows = {name: values[heads] for name, values in rows.items()}

    def numbers(self, columns: Columns) -> npt.NDArray[np.int64]:
        """The number of the attractor of each of some of the motions, 0 for the most frequent."""
        known, found = self.members.size, np.empty(columns["code"].size, dtype=np.int64)
        if found.size:
            for part in _grouped(*self._beside(columns), self._distance):
                found[part[part >= known] - known] = part.min()
        return found

    def _beside(self, columns: Columns) -> tuple[npt.NDArray[np.str_], Array, Array]:
        """Labels, and least and greatest numbers, of the attractors and then of motions."""
        label, values = self._hammer.marked(columns, self._hammer.speed)
        if not self.rows:
            return label, values, values
        return (
            np.append(self.label, label),
            np.concatenate([self._low, values]),
            np.concatenate([self._high, values]),
        )


def _grouped(names: npt.NDArray[np.str_], low: Array, high: Array, distance: float) -> list[npt.NDArray[np.intp]]:
    """Motions of one name, or boxes of them from `low` to `high`, cut apart where one of the numbers leaves a gap."""
    every, key = np.unique(names, return_inverse=True)
    todo, groups = [np.flatnonzero(key == i) for i in range(every.size)], []
    while todo:
        part = todo.pop()
        pieces = _cut(part, low[part], high[part], distance)
        if len(pieces) == 1:
            groups.append(part)
        else:
            todo.extend(pieces)
    return groups


def _cut(part: npt.NDArray[np.intp], low: Array, high: Array, distance: float) -> list[npt.NDArray[np.intp]]:
    """A group, cut at the gaps of the first of the numbers that has any."""
    for j in np.flatnonzero(high.max(axis=0) - low.min(axis=0) > distance):
        order = np.argsort(low[:, j], kind="stable")
        reached = np.maximum.accumulate(high[order, j])
        gaps = np.flatnonzero(low[order[1:], j] - reached[:-1] > distance) + 1
        if gaps.size:
            return np.split(part[order], gaps)
    return [part]


# ---- A system whose load keeps time by itself

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


class ClockedHammer(Hammer):
    """A system: its load keeps time by itself."""

    kind = "system"
    columns = COLUMNS
    units: ClassVar = {
        "position": ("length_scale", "m"),
        **dict.fromkeys(("velocity", "striking_speed", "impact_velocity"), ("speed_scale", "m/s")),
        "blow_energy": ("energy_scale", "J"),
        **dict.fromkeys(
            ("time", "interval_mean", "interval_std", "main_interval_mean", "main_interval_std"), ("time_scale", "s")
        ),
    }
    named_by = ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders")
    settled = "cycle_impacts"

    def __init__(self, what: System) -> None:
        from percuss.simulate import OUTCOMES

        self.what: System = what
        self.at = what.load.at
        super().__init__()
        self.words = {"code": OUTCOMES, "cycle_kind": CYCLE_KINDS}
        self.about = {"scaling": "dimensionless: lengths in bar lengths, times in radians of the load phase"}
        if what.is_si:
            self.about["frequency_Hz"] = what.frequency
        self.speed = float(np.abs(what.load.coefficients).sum())

    def check(self, modes: int) -> None:
        from percuss.simulate.spectrum import Spectrum

        Spectrum(self.what, modes)

    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        harmonics = self.what.load.harmonics

        def simulated(rows: Any, keep: int = _WINDOW) -> Columns:
            many = self._ensemble(starts, rows, modes, stop, threads, stopped, keep=keep)
            return _columns(many, harmonics)

        # simulate_many looks up 16 times for each thread: long motions in small blocks, so that it soon sees `stopped`
        size = int(np.clip(16 * _PORTION // max(stop.most_impacts, 1), 16, _BLOCK))
        found = self._of_blocks(size, len(starts), stopped, simulated)
        for rows, keep in _long(found["cycle_impacts"]):
            if stopped():
                break
            more = simulated(rows, keep)
            for name in ("phase", "striking_speed", "invariants"):
                found[name][rows] = more[name]
        return found

    @classmethod
    def tells_apart(cls, columns: Columns, speed: float) -> Array:
        values: Array = columns["invariants"].copy()
        values[:, :2] /= (speed, speed * speed)
        values[:, 1] = np.sqrt(values[:, 1])
        values[:, :2] = np.arcsinh(values[:, :2])  # differences relative to 1 + x
        return values

    def figures(self, columns: Columns, row: int, motion: Trajectory | None) -> tuple[str, dict[str, Any]]:
        if motion is None or (p := int(columns["cycle_impacts"][row])) > _LONGEST:
            return "", {"phases": [], "impact_velocities": []}
        struck = motion.events.of("impact")
        phases, speeds = struck.phase[-p:], struck.impact_velocity[-p:]
        fast = np.flatnonzero(speeds >= (1.0 - 1e-7) * speeds.max())
        begin = int(fast[np.argmin(phases[fast])])
        phases, speeds = np.roll(phases, -begin).tolist(), np.roll(speeds, -begin).tolist()
        return f"at {phases[0]:.3f}", {"phases": phases, "impact_velocities": speeds}


def _long(impacts: npt.NDArray[np.int64]) -> Iterator[tuple[npt.NDArray[np.intp], int]]:
    """Members whose cycle is longer than what is kept, in portions, and the power of 2 of impacts to keep."""
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
    return {name: made[name] if name in made else np.asarray(getattr(many, name)) for name in COLUMNS}


def invariants_of(
    phases: Array, speeds: Array, impacts: npt.NDArray[np.int64], periods: npt.NDArray[np.int64], harmonics: Any
) -> tuple[Array, Array, Array]:
    """Invariants of the last `impacts` impacts of each row, and phase and speed of the fastest of them."""
    # Sums over the impacts of a cycle do not depend on which of them comes first, and cosine and sine know no seam at
    # 2π; weights v² and v³ leave the smallest impacts of a chatter, of which there may be one more or less, without
    # weight. Phases count modulo the true period of the load, 2π over the greatest common divisor of its harmonics.
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


# ---- A machine that switches its own valve

MACHINE_COLUMNS: dict[str, Column] = {
    "code": Column("int8", meaning="how the simulation ended, its number in percuss.simulate.OUTCOMES"),
    "stall": Column("int8", meaning="where it stalls, its number in percuss.simulate.STALLS; -1: it does not"),
    "impacts": Column("int64", meaning="impacts from the start"),
    "end_time": Column(unit=UNIT_OF_TIME, meaning="time from the start to the last event"),
    "blows": Column("int64", meaning="main blows in a period; 0: none, or no period was found"),
    "valve_cycles": Column("int64", meaning="how often the valve goes through its states in a period; 0: none found"),
    "cycle_kind": Column("int8", meaning="periodic motion without rest (0), with rest (1), with chatter and rest (2)"),
    "wanders": Column("bool", meaning="whether the last changes of the valve do not come near any earlier ones"),
    "period": Column(unit=UNIT_OF_TIME, meaning="of the periodic motion"),
    "blow_speed": Column(meaning="striking speed of the strongest blow of a period"),
    "energy_lost": Column(meaning="what blows, chatter and rest take in a period, per unit of mass"),
}
"""What is kept of every motion."""


class SwitchingHammer(Hammer):
    """A machine: its piston switches its load."""

    kind = "machine"
    columns = MACHINE_COLUMNS
    units: ClassVar = {
        "position": ("length_scale", "m"),
        **dict.fromkeys(("velocity", "blow_speed"), ("speed_scale", "m/s")),
        "energy_lost": ("energy_scale", "J"),
        **dict.fromkeys(("end_time", "period"), ("time_scale", "s")),
    }
    named_by = ("code", "blows", "valve_cycles", "cycle_kind", "wanders", "stall")
    settled = "blows"

    def __init__(self, what: Machine) -> None:
        from percuss.simulate import OUTCOMES, STALLS

        self.what: Machine = what
        self.at = what.at
        super().__init__()
        self.words = {"code": OUTCOMES, "stall": STALLS, "cycle_kind": CYCLE_KINDS, "state": self.states}
        unit = "seconds" if what.is_si else UNIT_OF_TIME
        self.about = {"scaling": f"lengths in bar lengths, times in the {unit}, energies per unit of mass"}
        self.speed = speed_scale(what) or farthest_port(what)

    def check(self, modes: int) -> None:
        self.what.modes(modes)

    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        own = {"blows": "cycle_impacts", "valve_cycles": "cycle_periods", "energy_lost": "energy_lost_per_period"}

        def simulated(rows: slice) -> Columns:
            many = self._ensemble(starts, rows, modes, stop, threads, stopped)
            return {name: getattr(many, own.get(name, name)) for name in MACHINE_COLUMNS}

        return self._of_blocks(_BLOCK // 2, len(starts), stopped, simulated)

    @classmethod
    def tells_apart(cls, columns: Columns, speed: float) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            speeds = columns["blow_speed"], np.sqrt(columns["energy_lost"])
            values = np.column_stack([np.log(columns["period"]), *(np.arcsinh(one / speed) for one in speeds)])
        values[columns["stall"] >= 0] = np.nan
        return values

    def figures(self, columns: Columns, row: int, motion: Trajectory | None) -> tuple[str, dict[str, Any]]:
        period, lost = (float(columns[name][row]) for name in ("period", "energy_lost"))
        known, speeds, energies = not math.isnan(period), [], []
        if motion is not None and (cycle := motion.cycle) is not None and columns["stall"][row] < 0:
            struck, last = motion.events.of("impact"), float(motion.events.time[-1])
            inside = np.flatnonzero(struck.time > last - cycle.period * (1.0 - 1e-9))
            strongest = np.sort(np.argsort(-struck.impact_velocity[inside], kind="stable")[: cycle.impacts])
            main = inside[strongest]  # what bounces is weaker than the blow that it follows
            if main.size:
                main = np.roll(main, -int(np.argmax(struck.impact_velocity[main])))
                speeds, energies = struck.impact_velocity[main].tolist(), struck.kinetic_energy[main].tolist()
        figures = {
            "period": period if known else None,
            "impact_velocities": speeds,
            "blow_energies": energies,
            "energy_lost": lost if known else None,
        }
        return (f"period {period:.4g}" if known else ""), figures


def hammer_of(what: System | Machine) -> Hammer:
    """A system or a machine as an experiment asks it; ParameterError for anything else."""
    if isinstance(what, System):
        return ClockedHammer(what)
    if isinstance(what, Machine):
        return SwitchingHammer(what)
    raise ParameterError("system", what, "a System, or a Machine that switches its own valve")
