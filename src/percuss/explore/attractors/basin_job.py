"""What an image of basins carries out: the starts of a plane, each followed by itself."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.attractors.cycles import COLUMNS, followed
from percuss.explore.attractors.motion_columns import start_columns, start_values
from percuss.explore.axis import Axis
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.rough_time import seconds_of_start
from percuss.model import System
from percuss.model.checks import Array, count, finite, instance, mapping, numbers
from percuss.model.described import describe_system

if TYPE_CHECKING:
    from percuss.simulate import Starts, Stop

__all__ = ["BasinsJob", "Line", "basins_job"]

Line = Axis | tuple[str, float, float, int] | tuple[str, Sequence[float]]

_STATES = "position, velocity, time, u_1, u_2, …, v_1, v_2, …"
_MODE = re.compile(r"[uv]_([1-9]\d{0,3})")


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
        Of `simulate_many` for one portion; the numbers do not depend on it.
    """

    system: System
    modes: int
    stop: Stop
    x: tuple[str, tuple[float, ...]]
    y: tuple[str, tuple[float, ...]]
    at: tuple[tuple[str, float], ...] = ()
    threads: int | None = 1

    @cached_property
    def _lines(self) -> tuple[Array, Array]:
        return np.array(self.x[1]), np.array(self.y[1])

    def starts(self, first: int, last: int) -> Starts:
        """The starts `first` … `last` − 1."""
        over, up = self._lines
        rows = np.arange(first, last)
        values = {"position": 0.0, "velocity": 0.0, "time": 0.0, **dict(self.at)}
        grid = {name: np.full(rows.size, value) for name, value in values.items()}
        grid[self.x[0]] = over[rows % over.size]
        grid[self.y[0]] = up[rows // over.size]
        return _starts(self.system, grid)

    @property
    def size(self) -> int:
        """Number of starts."""
        return len(self.x[1]) * len(self.y[1])

    @property
    def rough_seconds(self) -> float:
        """What all starts take, by rule of thumb."""
        return self.size * seconds_of_start(self.modes)

    @property
    def columns(self) -> Mapping[str, Column]:
        """`COLUMNS`, and the starts."""
        n = 1 + max(_mode_of(name) for name in (self.x[0], self.y[0], *(name for name, _ in self.at)))
        return {**start_columns(n, n), **COLUMNS}

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        return {
            "kind": "basins",
            "percuss": ASK_FORMAT,
            "system": describe_system(self.system),
            "x": {"name": self.x[0], "values": list(self.x[1])},
            "y": {"name": self.y[0], "values": list(self.y[1])},
            "at": dict(self.at),
            "modes": self.modes,
            "stop": asdict(self.stop),
        }

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        part = self.starts(first, last)
        return {**start_values(part), **followed(self.system, part, self.modes, self.stop, self.threads, stopped)}


def _mode_of(name: str) -> int:
    """n of an amplitude u_n or v_n; 0 for the rest."""
    found = _MODE.fullmatch(name)
    return int(found[1]) if found else 0


def _starts(system: System, grid: dict[str, Array]) -> Starts:
    """Starts of the striking end from columns by name, position, velocity and time among them."""
    from percuss.simulate import Starts
    from percuss.simulate.spectrum import units

    most = max(map(_mode_of, grid))
    u, v = (np.zeros((grid["time"].size, most + 1)) for _ in "uv")
    for name, column in grid.items():
        if _mode_of(name):
            (u if name[0] == "u" else v)[:, _mode_of(name)] = column
    u[:, 0] = grid["position"] - u[:, 1:] @ units(system.body.modes(most, system.load.at))
    v[:, 0] = grid["velocity"]
    return Starts(u, v, grid["position"], grid["time"])


def basins_job(
    system: System,
    x: Line,
    y: Line,
    *,
    at: Mapping[str, float] | None = None,
    modes: int = 0,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> BasinsJob:
    """What `basins` carries out."""
    from percuss.simulate import Stop
    from percuss.simulate.spectrum import Spectrum

    instance("system", system, System)
    kept = count("modes", modes, least=0, most=4096)
    Spectrum(system, kept)  # a resonance is an error here, not in a worker
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    count("impacts", stop.impacts)
    lines = [_line(axis, line) for axis, line in (("x", x), ("y", y))]
    if lines[0][0] == lines[1][0]:
        raise ParameterError("y", lines[1][0], f"another quantity than that of x: {_STATES}")
    held = {} if at is None else mapping("at", at, f"numbers by name: {_STATES}")
    fixed = tuple(sorted((_known_name("at", name), finite(name, value)) for name, value in held.items()))
    for name, values in (*lines, *((name, (value,)) for name, value in fixed)):
        if name == "position" and max(values) > 0.0:
            raise ParameterError("position", max(values), "0 (on the wall) or less", "the wall is at 0")
        if _mode_of(name) > kept:
            raise ParameterError(name, f"a mode above {kept}", f"modes up to {kept}", "use more modes")
    twice = [name for name, _ in fixed if name in (lines[0][0], lines[1][0])]
    if twice:
        raise ParameterError("at", twice[0], "a quantity that is not on an axis")
    return BasinsJob(system, kept, stop, lines[0], lines[1], fixed, threads)


def _line(axis: str, line: Line) -> tuple[str, tuple[float, ...]]:
    if not isinstance(line, Axis):
        if not isinstance(line, tuple | list) or len(line) not in (2, 4) or not isinstance(line[0], str):
            raise ParameterError(axis, line, "(name, first, last, number), (name, values) or an Axis")
        line = Axis.linear(*line) if len(line) == 4 else Axis(line[0], numbers(line[0], line[1]))
    if line.unit:
        remedy = "divide by a scale of the system: length_scale, speed_scale or time_scale"
        raise ParameterError(line.name, f"values in {line.unit}", "dimensionless numbers", remedy)
    return _known_name(axis, line.name), tuple(line.values.tolist())


def _known_name(where: str, name: object) -> str:
    if isinstance(name, str) and (name in ("position", "velocity", "time") or _MODE.fullmatch(name)):
        return name
    raise ParameterError(where, name, f"one of {_STATES}")
