"""Basins of attraction: where the motions of a plane of starts end, as an image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.explore.attractors.basin_job import BasinsJob, Line, basins_job
from percuss.explore.attractors.grouping import DISTANCE
from percuss.explore.attractors.hammer import Hammer
from percuss.explore.attractors.hammers import hammer_from, hammer_of
from percuss.explore.attractors.motion_columns import done
from percuss.explore.attractors.motion_dataset import dataset_of, si_attributes
from percuss.explore.attractors.shares import Share, share_of
from percuss.explore.jobs.job import Columns
from percuss.model import Machine, System
from percuss.model.checks import non_negative
from percuss.shown import Shown

if TYPE_CHECKING:
    import xarray

    from percuss.explore.attractors.hammer import AnyAttractor
    from percuss.simulate import Stop

__all__ = ["Basins", "BasinsJob", "basins", "basins_job"]


@dataclass(frozen=True, eq=False)
class Basins(Shown):
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

    system: System | Machine
    modes: int
    stop: Stop
    x: tuple[str, tuple[float, ...]]
    y: tuple[str, tuple[float, ...]]
    at: tuple[tuple[str, float], ...]
    columns: Columns = field(repr=False)
    distance: float = DISTANCE

    @classmethod
    def of(cls, job: BasinsJob, columns: Columns, distance: float = DISTANCE) -> Basins:
        """The result of a job."""
        return cls(job.system, job.modes, job.stop, job.x, job.y, job.at, columns, distance)

    @classmethod
    def from_archive(cls, archive: Any) -> Basins:
        """The basins that an archive holds; starts that are not done are −1 in the image."""
        from percuss.simulate import Stop

        ask = archive.ask
        axes = [(ask[axis]["name"], tuple(float(v) for v in ask[axis]["values"])) for axis in "xy"]
        columns = {name: np.asarray(values) for name, values in archive.read().items()}
        at = tuple((str(name), float(value)) for name, value in ask["at"].items())
        return cls(
            hammer_from(ask), int(ask["modes"]), Stop(**ask["stop"]), axes[0], axes[1], at, columns
        )  # fmt: skip

    @cached_property
    def hammer(self) -> Hammer:
        """What was followed, as it is asked."""
        return hammer_of(self.system)

    @cached_property
    def _known(self) -> Columns:
        whole = done(self.columns)
        return {name: values[whole] for name, values in self.columns.items()}

    @cached_property
    def _numbers(self) -> npt.NDArray[np.int64]:
        return self.hammer.matched(self._known, self.distance)

    @cached_property
    def image(self) -> npt.NDArray[np.int64]:
        """The number of the attractor of each start, 0 for the most frequent; shape (y, x)."""
        found = np.full(self.columns["code"].size, -1, dtype=np.int64)
        found[done(self.columns)] = self._numbers
        return found.reshape(len(self.y[1]), len(self.x[1]))

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each start ends in, empty where it is not done; shape (y, x)."""
        names = self.hammer.labels(self._known)
        found = np.full(self.columns["code"].size, "", dtype=f"<U{max(names.dtype.itemsize // 4, 1)}")
        found[done(self.columns)] = names
        return found.reshape(len(self.y[1]), len(self.x[1]))

    @cached_property
    def attractors(self) -> tuple[AnyAttractor, ...]:
        """The attractors, the most frequent first."""
        known, hammer = self._known, self.hammer
        return hammer.attractors(known, self._numbers, hammer.starts_from(known), self.modes, self.stop)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        """The share of the starts of the plane that leads to each; a grid is no random sample, mind the intervals."""
        return tuple(share_of(attractor, self._numbers.size) for attractor in self.attractors)

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """All columns over the dimensions of the plane, and the attractors, with units and meanings."""
        (x, over), (y, up) = self.x, self.y
        columns = {name: values for name, values in self.columns.items() if name not in (x, y)}
        found = dataset_of(
            columns,
            (y, x),
            self.image,
            self.shares,
            self.hammer,
            {
                "title": f"percuss basins: {y} over {x}",
                "modes": self.modes,
                self.hammer.kind: str(self.system),
                **{f"at_{name}": value for name, value in self.at},
            },
        )
        known = self.hammer.start_columns(1, 1)
        for name, values in ((x, over), (y, up)):
            unit = known[name].unit if name in known else "1"
            attributes = {"units": unit, **si_attributes(name, self.hammer)}
            found = found.assign_coords({name: (name, np.array(values), attributes)})
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
    modes: int = 0,
    stop: Stop | None = None,
    distance: float = DISTANCE,
    threads: int | None = 1,
    **running: Any,
) -> Basins:
    """Follow a plane of starts to the attractors that they lead to.

    Parameters
    ----------
    system
        What moves, dimensionless: a system whose load keeps time, or a machine that switches its own valve.
    x, y
        The axes: ``(name, first, last, number)``, ``(name, values)`` or an `Axis` without a unit; dimensionless. Names
        are ``position`` (of the striking end, the wall is at 0), ``velocity``, ``time`` (load phase in radians), and
        the modal amplitudes ``u_1``, ``u_2``, …, ``v_1``, ``v_2``, …; a machine has no load phase.
    at
        The same for all starts, by name; 0 where nothing is said. Of a machine also ``state``, that of the valve by its
        name: its own starting state where nothing is said.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop, distance, threads, running
        As in `experiment`.

    Raises
    ------
    ParameterError
        For unknown names, units, starts beyond the wall or amplitudes of modes that are not kept.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = basins(system, ("time", 0.0, 6.2, 32), ("velocity", -6.0, -0.1, 20), workers=1)
    >>> found.image.shape, [attractor.label for attractor in found.attractors]
    ((20, 32), ['chatter/1', 'z=2/2'])
    """
    job = basins_job(system, x, y, at=at, modes=modes, stop=stop, threads=threads)
    apart = non_negative("distance", distance)
    from percuss.explore.jobs.carrying_out import carry_out

    return Basins.of(job, carry_out(job, **running), apart)
