"""Basins of attraction: where the motions of a plane of starts end, as an image."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.drawn_starts import done, mode_of
from percuss.explore.attractors.experiments import StartsFollowed, StartsJob, checked_question
from percuss.explore.attractors.hammers import DISTANCE, Hammer
from percuss.explore.family import Axis
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, mapping, non_negative

if TYPE_CHECKING:
    import xarray

    from percuss.simulate import Starts, Stop


# ---- What an image of basins carries out: the starts of a plane, each followed by itself

Line = Axis | str | tuple[str, float, float, int] | tuple[str, Sequence[float]]


@dataclass(frozen=True, eq=False)
class BasinsJob(StartsJob):
    """The starts of a plane, row by row from the first value of y on; see `basins`. `at`: what all have in common."""

    x: tuple[str, tuple[float, ...]]
    y: tuple[str, tuple[float, ...]]
    at: tuple[tuple[str, float], ...] = ()

    @property
    def size(self) -> int:
        return len(self.x[1]) * len(self.y[1])

    @cached_property
    def _lines(self) -> tuple[Array, Array]:
        return np.array(self.x[1]), np.array(self.y[1])

    def starts(self, first: int, last: int) -> Starts:
        over, up = self._lines
        rows = np.arange(first, last)
        grid = {name: np.full(rows.size, value) for name, value in self.at}
        grid[self.x[0]] = over[rows % over.size]
        grid[self.y[0]] = up[rows // over.size]
        return self.hammer.on_a_grid(grid)

    @property
    def amplitudes(self) -> tuple[int, int]:
        n = 1 + max(mode_of(name) for name in (self.x[0], self.y[0], *(name for name, _ in self.at)))
        return n, n

    @property
    def asked(self) -> dict[str, Any]:
        x, y = ({"name": name, "values": list(values)} for name, values in (self.x, self.y))
        return {"kind": "basins", "x": x, "y": y, "at": dict(self.at)}


def basins_job(
    system: System | Machine,
    x: Line,
    y: Line,
    *,
    at: Mapping[str, float | str] | None = None,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    threads: int | None = 1,
) -> BasinsJob:
    """What `basins` carries out."""
    hammer, kept, stop = checked_question(system, modes, stop)
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
    return BasinsJob(system, kept, stop, threads, lines[0], lines[1], fixed)


def _line(hammer: Hammer, axis: str, line: Line) -> tuple[str, tuple[float, ...]]:
    line = Axis.of(line, axis)
    if line.unit:
        remedy = "divide by a scale of the system: length_scale, speed_scale or time_scale"
        raise ParameterError(line.name, f"values in {line.unit}", "dimensionless numbers", remedy)
    return hammer.value(axis, line.name, float(line.values[0]))[0], tuple(line.values.tolist())


# ---- The image of them


@dataclass(frozen=True, eq=False, kw_only=True)
class Basins(StartsFollowed):
    """Which attractor every start of a plane leads to; made by `basins`.

    Parameters
    ----------
    system, modes, stop
        What was followed.
    x, y
        Names and values of the axes; dimensionless, times in radians.
    at
        What all starts have in common.
    columns
        One row for each start, row by row of the image; those not done have the code −1.
    distance
        What tells attractors of one label apart.
    """

    x: tuple[str, tuple[float, ...]]
    y: tuple[str, tuple[float, ...]]
    at: tuple[tuple[str, float], ...]

    @classmethod
    def from_archive(cls, archive: Any) -> Basins:
        """The basins that an archive holds; starts that are not done are −1 in the image."""
        ask, columns = archive.ask, {name: np.asarray(values) for name, values in archive.read().items()}
        x, y = ((ask[axis]["name"], tuple(float(v) for v in ask[axis]["values"])) for axis in "xy")
        at = tuple((str(name), float(value)) for name, value in ask["at"].items())
        return cls(columns=columns, x=x, y=y, at=at, **cls._asked_in(ask))

    def _imaged(self, known: npt.NDArray[Any], empty: Any) -> npt.NDArray[Any]:
        """What is known of the starts that are done as an image."""
        found = np.full(self.columns["code"].size, empty, dtype=known.dtype)
        found[done(self.columns)] = known
        return found.reshape(len(self.y[1]), len(self.x[1]))

    @cached_property
    def image(self) -> npt.NDArray[np.int64]:
        """The number of the attractor of each start, 0 for the most frequent; shape (y, x)."""
        return self._imaged(self.numbers, -1)

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each start ends in, empty where it is not done; shape (y, x)."""
        return self._imaged(self.hammer.labels(self.known), "")

    def to_xarray(self) -> xarray.Dataset:
        """All columns over the dimensions of the plane, and the attractors, with units and meanings."""
        (x, over), (y, up) = self.x, self.y
        about = {"title": f"percuss basins: {y} over {x}", **{f"at_{name}": value for name, value in self.at}}
        found = self._dataset_over((y, x), self.image, about, but=(x, y))
        for name, values in ((x, over), (y, up)):
            unit = self._about[name].unit if name in self._about else "1"
            found = found.assign_coords({name: (name, np.array(values), {"units": unit, **self._si_of(name)})})
        return found

    def __str__(self) -> str:
        rows, columns = self.image.shape
        head = f"Basins: {columns} × {rows} starts, {self.y[0]} over {self.x[0]}, {self.modes} modes"
        return "\n".join([head, *(f"  {i}: {s.label}, {s.share:.2%}" for i, s in enumerate(self.shares))])


def basins(
    system: System | Machine,
    x: Line,
    y: Line,
    *,
    at: Mapping[str, float | str] | None = None,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    distance: float = DISTANCE,
    **running: Any,
) -> Basins:
    """Follow a plane of starts to the attractors that they lead to.

    Parameters
    ----------
    system
        What moves, dimensionless: a system whose load keeps time, or a machine that switches its own valve.
    x, y
        The axes: text such as ``"time=0:6.2:32"``, ``(name, first, last, number)``, ``(name, values)`` or an `Axis`
        without a unit; dimensionless. Names are ``position`` (of the striking end, the wall is at 0), ``velocity``,
        ``time`` (load phase in radians), and the modal amplitudes ``u_1``, ``u_2``, …, ``v_1``, ``v_2``, …; a machine
        has no load phase.
    at
        The same for all starts, by name; 0 where nothing is said. Of a machine also ``state``, that of the valve by its
        name: its own starting state where nothing is said.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop, distance, running
        As in `experiment`.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = basins(system, ("time", 0.0, 6.2, 32), ("velocity", -6.0, -0.1, 20), modes=0, workers=1)
    >>> found.image.shape, [attractor.label for attractor in found.attractors]
    ((20, 32), ['chatter/1', 'z=2/2'])
    """
    job = basins_job(system, x, y, at=at, modes=modes, stop=stop)
    apart = non_negative("distance", distance)
    from percuss.explore.jobs.carrying_out import carry_out

    return Basins.of(job, carry_out(job, **running), apart)
