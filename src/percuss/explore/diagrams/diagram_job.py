"""A diagram as a job: its items are the labels whose branches are traced, and the passes of simulations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.axis import Axis
from percuss.explore.diagrams.lines import DiagramBranch, packed
from percuss.explore.diagrams.passes import fresh_pass, pass_columns, running_pass
from percuss.explore.diagrams.rest_lines import DiagramRestBranch
from percuss.explore.diagrams.rest_tracing import rests_traced
from percuss.explore.diagrams.tracing import labels_up_to, of_label, settled_on, traced
from percuss.explore.family import Family, drives_itself, family_of
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.rough_time import seconds_of_start
from percuss.model import HeldBody, Machine, System
from percuss.model.checks import Array, count, instance
from percuss.steady.periodic.search import MOST_IMPACTS, MOST_PERIODS

if TYPE_CHECKING:
    from percuss.simulate import Stop

__all__ = ["DEFAULT_RUNS", "DEFAULT_UP_TO", "DEFAULT_VALUES", "DiagramJob", "diagram_job"]

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
    """What a diagram carries out; see `diagram`. Its items are the labels, the longer cycles, then the passes.

    Parameters
    ----------
    family
        The systems.
    axis
        The parameter, and the values at which motions are simulated.
    up_to
        The greatest p and n whose orbits are searched for; None for no branches.
    searched
        At how many values of the range they are searched for.
    switch, tries
        As for `percuss.explore.follow` and `percuss.steady.orbits`.
    starts, runs
        Passes from new starts at each value, and motions that are taken along, up and down the values.
    modes, stop, seed
        Of the simulations; the modes also of the branches.
    """

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

    def system(self, value: float) -> System:
        """The system at a value; PercussError where there is none."""
        return self.family.system({self.axis.name: value})

    @cached_property
    def systems(self) -> tuple[System | None, ...]:
        """The systems at the values; None where there is none."""
        return tuple(self._system_or_none(value) for value in self.axis.values.tolist())

    def _system_or_none(self, value: float) -> System | None:
        try:
            return self.system(value)
        except PercussError:
            return None

    @cached_property
    def scales(self) -> Array:
        """Metres per second and joules of a speed and an energy of 1 at each value, 0 without; shape (values, 2)."""
        found = [(s.speed_scale, s.energy_scale) if s is not None and s.is_si else (0.0, 0.0) for s in self.systems]
        return np.array(found)

    @cached_property
    def load_scales(self) -> Array:
        """Σ|p_k| at each value, by which speeds are compared; shape (values,)."""
        return np.array([np.abs(s.load.coefficients).sum() if s is not None else 1.0 for s in self.systems])

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
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        longer = i == len(self.labels)
        search = (
            settled_on(self.labels[-1], self.modes, self.stop, self.seed)
            if longer
            else of_label(self.labels[i], self.modes, self.tries)
        )
        values = self._searched(low, high, _FINER if longer else 1)
        along = (self.family, self.axis.name, (low, high), values)
        lines: list[DiagramBranch | DiagramRestBranch] = []
        if longer:
            lines += rests_traced(*along, self.modes, stopped=stopped)
        lines += traced(*along, search, switch=0 if longer else self.switch, stopped=stopped)
        data, kept = packed(lines, found["branches"].size)
        found["branches"][: len(data)] = np.frombuffer(data, dtype=np.uint8)
        found["branch_bytes"][...], found["left_out"][...] = len(data), len(lines) - kept
        return found

    def _searched(self, low: float, high: float, finer: int) -> list[float]:
        """The values at which orbits are searched for: the middles of as many parts of the range, or of more."""
        number = finer * self.searched
        shares = (np.arange(number) + 0.5) / number
        return [float(value) for value in low + shares * (high - low)]

    def _pass(self, number: int, stopped: Callable[[], bool]) -> Columns:
        systems = self.systems
        if number < self.starts:
            return fresh_pass(systems, self.modes, self.stop, self.seed, number, stopped)
        run = number - self.starts
        places = -(-self.runs // _RANKS)
        place, rank = (run // _RANKS + 0.5) / places, run % _RANKS
        return running_pass(systems, self.modes, self.stop, self.seed, place, rank, stopped)


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
    modes: int = 8,
    stop: Stop | None = None,
    seed: int = 0,
) -> DiagramJob:
    """What `diagram` carries out."""
    from percuss.simulate import Stop
    from percuss.simulate.stop import MAX_MODES

    family = family_of(what)
    if drives_itself(family):
        raise ParameterError(
            "diagram", str(what), "a hammer whose load keeps time by itself",
            "of a machine that switches its own valve 'percuss sweep' maps the motions over a parameter",
        )  # fmt: skip
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
    held = None if made is None or not isinstance(made.body, HeldBody) else made.body
    return job if held is None else replace(job, modes=held.chosen(job.modes))


def _label(up_to: tuple[int, int]) -> tuple[int, int]:
    if not isinstance(up_to, tuple) or len(up_to) != 2:
        raise ParameterError("up_to", up_to, "p and n of the greatest label, such as (4, 4)")
    p, n = count("up_to", up_to[0], most=MOST_IMPACTS), count("up_to", up_to[1], most=MOST_PERIODS)
    if p * n > _MOST_LABELS:
        raise ParameterError("up_to", up_to, f"p and n with at most {_MOST_LABELS} labels up to theirs")
    return p, n
