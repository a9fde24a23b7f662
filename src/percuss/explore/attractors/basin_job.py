"""What an image of basins carries out: the starts of a plane, each followed by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.attractors.hammer import Hammer
from percuss.explore.attractors.hammers import hammer_of
from percuss.explore.attractors.own_starts import mode_of
from percuss.explore.axis import Axis
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model import Machine, System
from percuss.model.checks import Array, count, instance, mapping, numbers

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import AnyStarts
    from percuss.simulate import Stop

__all__ = ["BasinsJob", "Line", "basins_job"]

Line = Axis | tuple[str, float, float, int] | tuple[str, Sequence[float]]


@dataclass(frozen=True, eq=False)
class BasinsJob:
    """The starts of a plane, row by row from the first value of y on; see `basins`.

    Parameters
    ----------
    system, modes, stop
        What is followed, with how many elastic modes, and until when.
    x, y
        Names and values of the axes.
    at
        What all starts have in common.
    threads
        Of one portion; the numbers do not depend on it.
    """

    system: System | Machine
    modes: int
    stop: Stop
    x: tuple[str, tuple[float, ...]]
    y: tuple[str, tuple[float, ...]]
    at: tuple[tuple[str, float], ...] = ()
    threads: int | None = 1

    @cached_property
    def _lines(self) -> tuple[Array, Array]:
        return np.array(self.x[1]), np.array(self.y[1])

    @cached_property
    def hammer(self) -> Hammer:
        """What is followed, as it is asked."""
        return hammer_of(self.system)

    def starts(self, first: int, last: int) -> AnyStarts:
        """The starts `first` … `last` − 1."""
        over, up = self._lines
        rows = np.arange(first, last)
        grid = {name: np.full(rows.size, value) for name, value in self.at}
        grid[self.x[0]] = over[rows % over.size]
        grid[self.y[0]] = up[rows // over.size]
        return self.hammer.on_a_grid(grid)

    @property
    def size(self) -> int:
        """Number of starts."""
        return len(self.x[1]) * len(self.y[1])

    @property
    def rough_seconds(self) -> float:
        """What all starts take, by rule of thumb."""
        return self.size * self.hammer.rough_seconds(self.modes)

    @property
    def columns(self) -> Mapping[str, Column]:
        """The numbers of the motions, and the starts."""
        n = 1 + max(mode_of(name) for name in (self.x[0], self.y[0], *(name for name, _ in self.at)))
        return {**self.hammer.start_columns(n, n), **self.hammer.columns}

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        return {
            "kind": "basins",
            "percuss": ASK_FORMAT,
            **self.hammer.described,
            "x": {"name": self.x[0], "values": list(self.x[1])},
            "y": {"name": self.y[0], "values": list(self.y[1])},
            "at": dict(self.at),
            "modes": self.modes,
            "stop": asdict(self.stop),
        }

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        part, hammer = self.starts(first, last), self.hammer
        return {**hammer.start_values(part), **hammer.followed(part, self.modes, self.stop, self.threads, stopped)}


def basins_job(
    system: System | Machine,
    x: Line,
    y: Line,
    *,
    at: Mapping[str, float | str] | None = None,
    modes: int = 0,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> BasinsJob:
    """What `basins` carries out."""
    from percuss.simulate import Stop

    hammer = hammer_of(system)
    kept = count("modes", modes, least=0, most=4096)
    hammer.check(kept)  # a resonance is an error here, not in a worker
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    count("impacts", stop.impacts)
    lines = [_line(hammer, axis, line) for axis, line in (("x", x), ("y", y))]
    if lines[0][0] == lines[1][0]:
        raise ParameterError("y", lines[1][0], "another quantity than that of x")
    held = {} if at is None else mapping("at", at, "numbers by name")
    fixed = tuple(sorted(hammer.value("at", name, value) for name, value in held.items()))
    for name, values in (*lines, *((name, (value,)) for name, value in fixed)):
        if name == "position" and max(values) > 0.0:
            raise ParameterError("position", max(values), "0 (on the wall) or less", "the wall is at 0")
        if mode_of(name) > kept:
            raise ParameterError(name, f"a mode above {kept}", f"modes up to {kept}", "use more modes")
    twice = [name for name, _ in fixed if name in (lines[0][0], lines[1][0])]
    if twice:
        raise ParameterError("at", twice[0], "a quantity that is not on an axis")
    return BasinsJob(system, kept, stop, lines[0], lines[1], fixed, threads)


def _line(hammer: Hammer, axis: str, line: Line) -> tuple[str, tuple[float, ...]]:
    if not isinstance(line, Axis):
        if not isinstance(line, tuple | list) or len(line) not in (2, 4) or not isinstance(line[0], str):
            raise ParameterError(axis, line, "(name, first, last, number), (name, values) or an Axis")
        line = Axis.linear(*line) if len(line) == 4 else Axis(line[0], numbers(line[0], line[1]))
    if line.unit:
        remedy = "divide by a scale of the system: length_scale, speed_scale or time_scale"
        raise ParameterError(line.name, f"values in {line.unit}", "dimensionless numbers", remedy)
    return hammer.value(axis, line.name, float(line.values[0]))[0], tuple(line.values.tolist())
