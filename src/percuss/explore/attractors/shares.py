"""Shares of the attractors over a parameter: the same random starts at each of its values."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import extra_package
from percuss.explore.attractors.experiments import Experiment, ExperimentJob, experiment_job, wilson
from percuss.explore.attractors.hammers import DISTANCE
from percuss.explore.family import Axis, Family, drives_itself, family_of
from percuss.explore.jobs.archive_export import OfValues
from percuss.explore.jobs.archive_layout import canonical, parsed
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, count, non_negative

if TYPE_CHECKING:
    import pandas
    import xarray

    from percuss.simulate import Starts, Stop

DEFAULT_STARTS = 1000
"""At each value, unless another number is asked for."""


@dataclass(frozen=True, eq=False)
class SharesJob:
    """The experiments of all values one after the other; see `shares`."""

    axis: Axis
    each: tuple[ExperimentJob, ...]

    @property
    def size(self) -> int:
        """Starts of all values."""
        return sum(job.size for job in self.each)

    @property
    def rough_seconds(self) -> float:
        """What all starts take, by rule of thumb."""
        return sum(job.rough_seconds for job in self.each)

    @property
    def columns(self) -> Mapping[str, Column]:
        """Those of an experiment."""
        return self.each[0].columns

    @property
    def ask(self) -> dict[str, Any]:
        """What the numbers depend on."""
        asked = {"along": self.axis.to_json_dict(), "each": [job.ask for job in self.each]}
        return {"percuss": ASK_FORMAT, "kind": "shares", **asked}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The motions from starts `first` … `last` − 1."""
        number = self.each[0].size
        parts = [
            self.each[i].compute(max(first - i * number, 0), min(last - i * number, number), stopped)
            for i in range(first // number, (last - 1) // number + 1)
        ]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


@dataclass(frozen=True, eq=False)
class Shares(OfValues):
    """The shares of the attractors over a parameter; made by `shares`.

    Parameters
    ----------
    axis
        The parameter and its values.
    experiments
        The experiment at each value.
    """

    axis: Axis
    experiments: tuple[Experiment, ...]

    @classmethod
    def of(cls, ask: Mapping[str, Any], columns: Columns, distance: float = DISTANCE) -> Shares:
        """The result of a job, by what was asked for."""
        along, cut = ask["along"], np.cumsum([one["starts"] for one in ask["each"]])[:-1]
        parts = {name: np.split(np.asarray(values), cut) for name, values in columns.items()}
        every = [{name: values[i] for name, values in parts.items()} for i in range(len(ask["each"]))]
        made = (Experiment.of_done(asked, rows, distance) for asked, rows in zip(ask["each"], every, strict=True))
        return cls(Axis(along["name"], along["values"], along["unit"]), tuple(made))

    @classmethod
    def from_archive(cls, archive: Any) -> Shares:
        """What an archive holds, of those starts that are done."""
        return cls.of(archive.ask, archive.read())

    @cached_property
    def lines(self) -> tuple[tuple[int, ...], ...]:
        """The attractors as lines over the values: of each the number of its attractor at every value, or −1.

        Of one label those that are nearest to each other are one line.
        """
        lines: list[list[int]] = []
        ends: list[tuple[str, Array]] = []
        for i, one in enumerate(self.experiments):
            marks = one.hammer.tells_apart(one.counted.rows, one.hammer.speed) if len(one) else ()
            here = [(a.label, np.nan_to_num(mark)) for a, mark in zip(one.attractors, marks, strict=True)]
            pairs = sorted(
                (float(np.abs(end[1] - at[1]).max(initial=0.0)), j, k)
                for j, end in enumerate(ends)
                for k, at in enumerate(here)
                if end[0] == at[0]
            )
            met: dict[int, int] = {}
            for _, j, k in pairs:
                if k not in met and j not in met.values():
                    met[k] = j
            for k, at in enumerate(here):
                if k not in met:
                    met[k] = len(lines)
                    lines.append([-1] * len(self.axis))
                    ends.append(at)
                lines[met[k]][i], ends[met[k]] = k, at
        return tuple(map(tuple, lines))

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """The label of each line."""
        first = [next((i, k) for i, k in enumerate(line) if k >= 0) for line in self.lines]
        return tuple(self.experiments[i].attractors[k].label for i, k in first)

    @property
    def members(self) -> Any:
        """How many starts end in each line; shape (values, lines)."""
        counts = [[one.members for one in found.attractors] for found in self.experiments]
        return np.array([[row[line[i]] if line[i] >= 0 else 0 for line in self.lines] for i, row in enumerate(counts)])

    def to_xarray(self) -> xarray.Dataset:
        """The share of each line at each value with its interval of 95 %, and the starts that it is counted from."""
        name, members, numbers = self.axis.name, self.members, [len(one) for one in self.experiments]
        low, high = np.array([[wilson(int(k), n) for k in row] for row, n in zip(members, numbers, strict=True)]).T
        dims, per = (name, "line"), np.maximum(numbers, 1)[:, None]
        variables = {
            "share": (dims, members / per, {"long_name": "part of the starts"}),
            "low": (dims, low.T, {"long_name": "lower end of its interval of 95 %"}),
            "high": (dims, high.T, {"long_name": "upper end of its interval of 95 %"}),
            "members": (dims, members, {"long_name": "starts that end there"}),
            "label": ("line", np.array(self.labels, dtype=object), {"long_name": "motion"}),
        }
        coordinates: dict[str, Any] = {name: self.axis.coordinate(), "line": np.arange(len(self.lines))}
        about = {"title": f"percuss shares over {name}", "starts": max(numbers), "modes": self.experiments[0].modes}
        made: xarray.Dataset = extra_package("xarray", "io").Dataset(variables, coordinates, about)
        return made

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each attractor at each value: the parameter, line, label, members, share and its interval."""
        columns = (self.axis.name, "line", "label", "members", "share", "low", "high")
        rows = [
            (value, number, share.label, share.members, share.share, share.low, share.high)
            for i, value in enumerate(self.axis.values.tolist())
            for number, line in enumerate(self.lines)
            if line[i] >= 0
            for share in [self.experiments[i].shares[line[i]]]
        ]
        made: pandas.DataFrame = extra_package("pandas", "io").DataFrame(rows, columns=columns)
        return made

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        asked = {"along": self.axis.to_json_dict(), "each": [one.ask for one in self.experiments]}
        columns = {
            name: np.concatenate([one.columns[name] for one in self.experiments]).tolist()
            for name in self.experiments[0].columns
        }
        return {"ask": canonical(asked), "columns": columns, "distance": self.experiments[0].distance}

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Shares:
        """`as_json` backwards."""
        return cls.of(parsed(row["ask"]), {name: np.array(v) for name, v in row["columns"].items()}, row["distance"])

    def __str__(self) -> str:
        low, high = float(self.axis.values.min()), float(self.axis.values.max())
        over = f"{len(self.axis)} values of {self.axis.name} from {low:.6g} to {high:.6g}"
        head = f"Shares: {over}, {len(self.experiments[0])} starts each, {self.experiments[0].modes} modes"
        shares = self.members / np.maximum([len(one) for one in self.experiments], 1)[:, None]
        found = zip(self.labels, shares.T, (shares > 0.0).sum(axis=0).tolist(), strict=True)
        told = [f"  {label}: at {n} value{'s' * (n != 1)}, up to {part.max():.2%}" for label, part, n in found]
        return "\n".join([head, *told])


def shares(
    what: System | Machine | Family,
    along: Axis | str | tuple[Any, ...],
    starts: int = DEFAULT_STARTS,
    distribution: str | os.PathLike[str] | Starts | Callable[[int], Starts] = "wall",
    seed: int = 0,
    *,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    distance: float = DISTANCE,
    **running: Any,
) -> Shares:
    """The shares of the attractors over a parameter: an `experiment` at each of its values, and their lines.

    Parameters
    ----------
    what
        A system, or a machine that switches its own valve, whose dimensionless parameters are varied; or a family, such
        as `percuss.case.CaseFamily`.
    along
        The parameter and its values: text, ``"restitution=0:0.9:31"``, ``(name, values)``, ``(name, first, last,
        number)`` or an `Axis`.
    starts
        How many at each value.
    distribution, seed, modes, stop, distance, running
        As in `experiment`. The same numbers are drawn at each value.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = shares(system, "load_factor=0.7:0.8:2", 200, seed=1, modes=0, workers=1)
    >>> found.labels
    ('chatter/1', 'z=2/2', 'z=1/1')
    """
    family, axis, apart = family_of(what), Axis.of(along, "along"), non_negative("distance", distance)
    number = count("starts", starts)
    family.check({axis.name: axis.unit})
    hammers = family.machine if drives_itself(family) else family.system
    each = [
        experiment_job(hammers({axis.name: value}), number, distribution, seed, modes=modes, stop=stop)
        for value in axis.values.tolist()
    ]
    from percuss.explore.jobs.carrying_out import carry_out

    job = SharesJob(axis, tuple(each))
    return Shares.of(job.ask, carry_out(job, **running), apart)
