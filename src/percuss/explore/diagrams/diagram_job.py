"""A diagram as a job: its items are the labels whose branches are traced, and the passes of simulations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.attractors.drawn_starts import FIELD_DEPTH, FIELD_SPEED
from percuss.explore.attractors.hammers import COLUMNS, ClockedHammer, invariants_of, seconds_of_start
from percuss.explore.continuation.branch import Branch
from percuss.explore.diagrams.diagram_lines import packed
from percuss.explore.diagrams.machine_diagram import machine_branches, machine_pass
from percuss.explore.diagrams.tracing import SettledCycle, labels_up_to, of_label, rests_traced, settled_on, traced
from percuss.explore.family import Axis, Family, SwitchingFamily, drives_itself, family_of
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model import HeldBody, Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, count, instance
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS

if TYPE_CHECKING:
    from percuss.simulate import Ensemble, Start, Stop, Trajectory


# ---- Simulations over the values of a parameter: from new starts at each, or one motion taken along up and down

KEPT = 64
"""Impacts that are kept of a motion: those of its cycle, or its last ones."""

UNKNOWN = -1
"""The code of a value at which nothing was simulated."""

_WINDOW = 256
_LOOKED = 32  # random starts among whose motions one is chosen to be taken along
_TURN = 2.0 * np.pi


_OF_PASSES = {
    **{
        name: COLUMNS[name]
        for name in ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders", "blow_energy", "invariants")
    },
    "phases": Column(shape=(KEPT,), unit="rad", meaning="load phases of the impacts"),
    "speeds": Column(shape=(KEPT,), meaning="striking speeds of the impacts"),
}


def pass_columns(values: int) -> dict[str, Column]:
    """What is kept of the motions at so many values."""
    return {name: replace(column, shape=(values, *column.shape)) for name, column in _OF_PASSES.items()}


def _empty(values: int) -> Columns:
    """Nothing known yet: what is kept, and the times of the impacts, which stay here."""
    kept = {
        name: np.full(column.shape, column.empty, dtype=column.dtype) for name, column in pass_columns(values).items()
    }
    return {**kept, "times": np.full((values, KEPT), np.nan)}


def fresh_pass(
    systems: Sequence[System | None], modes: int, stop: Stop, seed: int, number: int, stopped: Callable[[], bool]
) -> Columns:
    """A new random start for each system in every pass: half of them as in ``wall``, half as in ``field``."""
    from percuss.simulate import simulate_many

    found = _empty(len(systems))
    there = [i for i, system in enumerate(systems) if system is not None]
    if not there:
        return found
    known = [system for system in systems if system is not None]
    starts = [start for _, start in zip(there, _starts(known, seed, number), strict=True)]
    many = simulate_many(
        known, starts, modes=modes, stop=stop, keep=_WINDOW, workers=1, progress=lambda _: stopped()
    )  # fmt: skip
    for row, i in enumerate(there):
        _put(found, i, many, row, _last(many, row), known[row])
    return found


def running_pass(
    systems: Sequence[System | None],
    modes: int,
    stop: Stop,
    seed: int,
    place: float,
    rank: int,
    stopped: Callable[[], bool],
) -> Columns:
    """One motion taken along both ways from its `place`, where starts settle on it, by rank of frequency."""
    found, first = _empty(len(systems)), min(int(place * len(systems)), len(systems) - 1)
    here = systems[first]
    begun = None if here is None else _begun(here, modes, stop, seed, rank)
    if begun is None:
        return found
    settled = None
    for ways in (range(first, len(systems)), range(first - 1, -1, -1)):
        start: Start | None = begun if settled is None else settled
        for i in ways:
            system = systems[i]
            if stopped() or system is None or start is None:
                break
            start = _followed(found, i, system, start, modes, stop)
            settled = start if i == first else settled
    return found


def _begun(system: System, modes: int, stop: Stop, seed: int, rank: int) -> Start | None:
    """A start that settles on the motion of a rank; None where there are fewer."""
    from percuss.simulate import simulate_many

    starts = [start for number in (0, 1) for start in _starts([system] * (_LOOKED // 2), seed, number)]
    many = simulate_many(system, starts, modes=modes, stop=stop, keep=_WINDOW, workers=1)
    rows = _empty(len(starts))
    for i in range(len(starts)):
        _put(rows, i, many, i, _last(many, i), system)
    number = ClockedHammer.matched(rows, ClockedHammer(system).speed)
    return starts[int(np.argmax(number == rank))] if rank <= int(number.max()) else None


def _followed(found: Columns, i: int, system: System, start: Start, modes: int, stop: Stop) -> Start | None:
    """Simulate at value number i; the state in which the motion ends."""
    from percuss.simulate import simulate_many

    start = _at_wall(system, start)
    many = simulate_many(system, start, modes=modes, stop=stop, keep="everything", workers=1)
    motion = many.trajectories[0]
    events = motion.events[motion.events.kind == "impact"]
    struck = np.stack([events.phase, events.impact_velocity, events.time])[:, -_WINDOW:]
    _put(found, i, many, 0, struck, system)
    return _end(motion)


def _starts(systems: Sequence[System], seed: int, number: int) -> Iterator[Start]:
    from percuss.simulate import Start

    random = np.random.default_rng([seed, number])
    for system in systems:
        phase, speed, depth = _TURN * random.random(), random.standard_normal(), random.random()
        if number % 2:
            yield Start.rigid(-FIELD_DEPTH * depth, FIELD_SPEED * speed, phase)
        else:
            scale = _TURN * abs(system.load.mean) / system.contact.impulse
            yield Start.rigid(0.0, -max(scale * abs(speed), 1e-3), phase)


def _end(motion: Trajectory) -> Start | None:
    """The state after the last event, as a start; None of a motion that has left for good, or never struck."""
    from percuss.simulate import Start

    if motion.outcome == "departed" or not len(motion.events):
        return None
    u, v = motion.displacement[-1], motion.velocity[-1]
    return Start(tuple(u.tolist()), tuple(v.tolist()), float(motion.events.phase[-1]), gap=0.0)


def _at_wall(system: System, start: Start) -> Start:
    """The end of another system's motion as a start: a structure whose wall was elsewhere is bent until it is there."""
    from percuss.simulate import Start
    from percuss.simulate.spectrum import units

    body, modes = system.body, len(start.displacement) - 1
    if not isinstance(body, HeldBody) or not modes:
        return start
    u, shape = np.array(start.displacement[1:]), body.bent(modes, system.load.at)
    by = body.gap - float(u @ units(body.modes(modes, system.load.at)))
    return Start((-body.gap, *(u + by * shape).tolist()), start.velocity, start.time, gap=0.0)


def _last(many: Ensemble, row: int) -> Array:
    assert many.last_phase is not None and many.last_velocity is not None and many.last_time is not None
    return np.stack([many.last_phase[row], many.last_velocity[row], many.last_time[row]])


def _put(found: Columns, i: int, many: Ensemble, row: int, struck: Array, system: System) -> None:
    """The motion of one system as a row; of its last impacts the phases, speeds and times."""
    phases, speeds, times = struck
    for name in ("code", "cycle_impacts", "cycle_periods", "cycle_kind", "wanders", "blow_energy"):
        found[name][i] = getattr(many, name)[row]
    p = int(many.cycle_impacts[row])
    short = np.array([p if p <= phases.size else 0])
    lasting = np.array([int(many.cycle_periods[row])])
    invariants, _, _ = invariants_of(phases[None], speeds[None], short, lasting, system.load.harmonics)
    found["invariants"][i] = invariants[0]
    if str(many.outcome[row]) in ("rest", "departed"):
        return
    wanted = min(p or KEPT, phases.size)
    last = np.arange(phases.size - wanted, phases.size)
    last = last[np.isfinite(phases[last])]
    if last.size > KEPT:  # of a long chatter the fastest
        last = np.sort(last[np.argsort(speeds[last])[-KEPT:]])
    found["phases"][i, : last.size] = phases[last]
    found["speeds"][i, : last.size] = speeds[last]
    found["times"][i, : last.size] = times[last]


# ---- A diagram as a job: its items are the labels whose branches are traced, and the passes of simulations

DEFAULT_VALUES = 120
"""Values of the parameter at which motions are simulated, unless others are asked for."""

DEFAULT_UP_TO = (3, 3)
"""The greatest label whose branches are traced, unless another is asked for."""

DEFAULT_RUNS = 6
"""Motions that are taken along the values, unless another number is asked for."""

_RANKS = 3  # of the motions at one place that are taken along
_FINER = 5  # times as many values, at which longer cycles and those with rest are looked for
_ROOM = 1 << 21  # bytes of the branches of a label
_MOST_PASSES, _MOST_SEARCHED, _MOST_LABELS = 1000, 200, 256
_SECONDS_OF_BRANCH = 2.0
_MOST_TRIES, _MOST_DEPTH = 10**6, 16


@dataclass(frozen=True, eq=False)
class DiagramJob:
    """What a diagram carries out; see `diagram`. Its items are the labels, the longer cycles, then the passes."""

    family: Family
    axis: Axis
    up_to: tuple[int, int] | None
    searched: int
    switch: int
    tries: int
    starts: int
    runs: int
    modes: int
    stop: Stop
    seed: int

    @cached_property
    def labels(self) -> tuple[tuple[int, int], ...]:
        """p and n of the labels whose branches are traced."""
        return () if self.up_to is None else tuple(labels_up_to(self.up_to))

    @property
    def passes(self) -> int:
        """How many passes of simulations there are."""
        return self.starts + self.runs

    @property
    def size(self) -> int:
        """Number of items."""
        return self.traces + self.passes

    @property
    def traces(self) -> int:
        """Items that trace branches: one for each label, and one for longer cycles, settled on or with rest."""
        return len(self.labels) + 1 if self.labels else 0

    @property
    def rough_seconds(self) -> float:
        """What all items take, by rule of thumb."""
        simulated = self.passes * len(self.axis) * seconds_of_start(self.modes)
        return simulated + len(self.labels) * _SECONDS_OF_BRANCH * (1.0 + self.modes / 8.0)

    @property
    def columns(self) -> Mapping[str, Column]:
        """The branches of the labels as bytes, and the motions of the passes."""
        return {
            "branches": Column("uint8", (_ROOM if self.labels else 1,), fill=0, meaning="of a label, compressed JSON"),
            "branch_bytes": Column("int64", meaning="how many bytes they are; 0 for a pass"),
            "left_out": Column("int64", meaning="branches for which there was no room"),
            **pass_columns(len(self.axis)),
        }

    @property
    def ask(self) -> dict[str, Any]:
        """The family, the values and the options."""
        return {
            "kind": "diagram",
            "machine": drives_itself(self.family),
            "percuss": ASK_FORMAT,
            "along": self.axis.to_json_dict(),
            "family": self.family.describe(),
            "labels": [f"{p}/{n}" for p, n in self.labels],
            "traces": self.traces,
            "searched": self.searched,
            "switch": self.switch,
            "tries": self.tries,
            "starts": self.starts,
            "runs": self.runs,
            "modes": self.modes,
            "stop": {"impacts": self.stop.impacts, "time": self.stop.time, "tolerance": self.stop.tolerance},
            "seed": self.seed,
            "scales": self.scales.tolist(),
            "load_scales": self.load_scales.tolist(),
        }

    # -- the systems --

    def system(self, value: float) -> Any:
        """The system, or the machine, at a value; PercussError where there is none."""
        values = {self.axis.name: value}
        return self.family.machine(values) if drives_itself(self.family) else self.family.system(values)

    @cached_property
    def systems(self) -> tuple[Any, ...]:
        """The systems, or the machines, at the values; None where there is none."""
        found: list[Any] = []
        for value in self.axis.values.tolist():
            found.append(None)
            with suppress(PercussError):
                found[-1] = self.system(value)
        return tuple(found)

    @cached_property
    def scales(self) -> Array:
        """Metres per second and joules of a speed and an energy of 1 at each value, 0 without; shape (values, 2)."""
        found = [(s.speed_scale, s.energy_scale) if s is not None and s.is_si else (0.0, 0.0) for s in self.systems]
        return np.array(found)

    @cached_property
    def load_scales(self) -> Array:
        """Σ|p_k| at each value, by which speeds are compared; shape (values,)."""
        return np.array([np.abs(s.load.coefficients).sum() if isinstance(s, System) else 1.0 for s in self.systems])

    # -- the items --

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The items `first` … `last` − 1."""
        rows = [self._item(i, stopped) for i in range(first, last)]
        return {name: np.stack([row[name] for row in rows]) for name in self.columns}

    def _item(self, i: int, stopped: Callable[[], bool]) -> Columns:
        found: Columns = {
            name: np.full(column.shape, column.empty, dtype=column.dtype) for name, column in self.columns.items()
        }
        found["branch_bytes"][...] = found["left_out"][...] = 0
        if i >= self.traces:
            return found | self._pass(i - self.traces, stopped)
        if drives_itself(self.family):
            return self._traced_of_machines(self.family, i, found, stopped)
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        longer = i == len(self.labels)
        number = (_FINER if longer else 1) * self.searched
        shares = (np.arange(number) + 0.5) / number  # the middles of as many parts of the range
        values = [float(value) for value in low + shares * (high - low)]
        if longer:
            search = settled_on(self.labels[-1], self.modes, self.stop, self.seed)
        else:
            search = of_label(self.labels[i], self.modes, self.tries)
        along = (self.family, self.axis.name, (low, high), values)
        lines: list[Branch] = rests_traced(*along, self.modes, stopped=stopped) if longer else []
        settled = [
            one
            for one in self._settled(stopped)
            if (longer and one.label not in self.labels) or (not longer and one.label == self.labels[i])
        ]
        switch = 0 if longer else self.switch
        lines += traced(*along, search, switch=switch, modes=self.modes, stopped=stopped, settled=settled)
        return _with_lines(found, lines)

    def _traced_of_machines(
        self, family: SwitchingFamily, i: int, found: Columns, stopped: Callable[[], bool]
    ) -> Columns:
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        label = self.labels[i] if i < len(self.labels) else None
        number = (_FINER if label is None else 1) * self.searched
        values = low + (np.arange(number) + 0.5) / number * (high - low)
        if label is None:  # windows are narrow: wherever motions are simulated, too
            values = np.union1d(values, self.axis.values)
        lines = machine_branches(
            family, self.axis.name, (low, high), values.tolist(), label, switch=self.switch * (label is not None),
            tries=self.tries, modes=self.modes, stopped=stopped,
        )  # fmt: skip
        return _with_lines(found, lines)

    def _settled(self, stopped: Callable[[], bool]) -> list[SettledCycle]:
        """The cycles without rest that passes settle on, simulated once in each process; none once unwanted."""
        if not self._cycles:
            found: list[SettledCycle] = []
            for number in range(self.passes):
                done = self._pass(number, stopped)
                if stopped():
                    return []
                self._early[number] = done
                for i in np.flatnonzero((done["cycle_kind"] == 0) & (done["cycle_impacts"] > 0)).tolist():
                    times = done["times"][i][np.isfinite(done["times"][i])]
                    p, n = int(done["cycle_impacts"][i]), int(done["cycle_periods"][i])
                    if times.size == p <= MOST_IMPACTS and n <= MOST_PERIODS:
                        found.append(SettledCycle(float(self.axis.values[i]), times, n))
            self._cycles.append(found)
        return self._cycles[0]

    @cached_property
    def _early(self) -> dict[int, Columns]:
        """Passes that were simulated to see what they settle on, each until it is asked for."""
        return {}

    @cached_property
    def _cycles(self) -> list[list[SettledCycle]]:
        """What that is, once it is known."""
        return []

    def _pass(self, number: int, stopped: Callable[[], bool]) -> Columns:
        if number in self._early:
            return self._early.pop(number)
        systems = self.systems
        if drives_itself(self.family):
            known, along = _empty(len(systems)), number >= self.starts
            machine_pass(systems, self.modes, self.stop, self.seed + 7919 * number, known, along, stopped)
            return known
        if number < self.starts:
            return fresh_pass(systems, self.modes, self.stop, self.seed, number, stopped)
        run = number - self.starts
        places = -(-self.runs // _RANKS)
        place, rank = (run // _RANKS + 0.5) / places, run % _RANKS
        return running_pass(systems, self.modes, self.stop, self.seed, place, rank, stopped)


def _with_lines(found: Columns, lines: list[Branch]) -> Columns:
    """A row with branches as bytes, as many as there is room for."""
    data, kept = packed(lines, found["branches"].size)
    found["branches"][: len(data)] = np.frombuffer(data, dtype=np.uint8)
    found["branch_bytes"][...], found["left_out"][...] = len(data), len(lines) - kept
    return found


def diagram_job(
    what: System | Machine | Family,
    axis: Axis,
    *,
    up_to: tuple[int, int] | None = DEFAULT_UP_TO,
    searched: int = 5,
    switch: int = 2,
    tries: int = 100,
    starts: int = 8,
    runs: int = DEFAULT_RUNS,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    seed: int = 0,
) -> DiagramJob:
    """What `diagram` carries out."""
    from percuss.simulate import Stop
    from percuss.simulate.stop import MAX_MODES

    family = family_of(what)
    instance("axis", axis, Axis)
    if len(axis) < 2:
        raise ParameterError(axis.name, axis.values.tolist(), "at least two values", "a diagram is over a range")
    family.check({axis.name: axis.unit})
    wanted = None if up_to is None else _label(up_to)
    job = DiagramJob(
        family, axis, wanted, count("searched", searched, most=_MOST_SEARCHED),
        count("switch", switch, least=0, most=_MOST_DEPTH), count("tries", tries, most=_MOST_TRIES),
        count("starts", starts, least=0, most=_MOST_PASSES), count("runs", runs, least=0, most=_MOST_PASSES),
        count("modes", modes, least=0, most=MAX_MODES), Stop() if stop is None else instance("stop", stop, Stop),
        count("seed", seed, least=0),
    )  # fmt: skip
    if not job.size:
        raise ParameterError("starts", starts, "1 or more, where no orbits are searched for")
    made = next((system for system in job.systems if system is not None), None)
    if made is None:
        job.system(float(axis.values[0]))  # which says why there is none
    return job if made is None else replace(job, modes=made.body.chosen(job.modes))


def _label(up_to: tuple[int, int]) -> tuple[int, int]:
    if not isinstance(up_to, tuple) or len(up_to) != 2:
        raise ParameterError("up_to", up_to, "p and n of the greatest label, such as (4, 4)")
    p, n = count("up_to", up_to[0], most=MOST_IMPACTS), count("up_to", up_to[1], most=MOST_PERIODS)
    if p * n > _MOST_LABELS:
        raise ParameterError("up_to", up_to, f"p and n with at most {_MOST_LABELS} labels up to theirs")
    return p, n
