"""Maps: quantities of a system over a parameter curve or plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.axis import Axis
from percuss.explore.cells import label_text
from percuss.explore.family import Family
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.machine_quantities import STALLS
from percuss.explore.own_quantities import SystemFunction
from percuss.explore.quantities import CELL_OUTCOMES, REASONS
from percuss.explore.sweep_job import SweepJob
from percuss.explore.sweep_question import sweep_job
from percuss.model import Machine, System
from percuss.shown import Shown

if TYPE_CHECKING:
    import xarray

    from percuss.explore.jobs.archive import Archive
    from percuss.simulate import Start, Stop

__all__ = ["Sweep", "sweep"]


@dataclass(frozen=True, eq=False)
class Sweep(Shown):
    """A map: the columns of all cells.

    Attributes
    ----------
    axes
        The parameters and their values.
    quantities
        What was asked for.
    arrays
        By column, of the map's shape, and of one item's shape behind it.
    columns
        What they hold.
    ask
        All that was asked.
    """

    axes: tuple[Axis, ...]
    quantities: tuple[str, ...]
    arrays: dict[str, np.ndarray[Any, Any]]
    columns: Mapping[str, Column]
    ask: dict[str, Any]

    def __str__(self) -> str:
        over = " × ".join(f"{len(axis)} values of {axis.name}" for axis in self.axes)
        return f"Sweep: {over}; {', '.join(self.quantities)}"

    @classmethod
    def from_archive(cls, archive: Archive) -> Sweep:
        """The map in an archive; cells that are not done hold the fill values of their columns."""
        ask = archive.ask
        axes = tuple(Axis(a["name"], a["values"], a["unit"]) for a in ask["axes"])
        return cls._shaped(axes, _asked(ask), archive.read(), archive.columns, ask)

    @classmethod
    def shaped(cls, job: SweepJob, flat: Columns) -> Sweep:
        """The result of a job, in the map's shape."""
        return cls._shaped(job.axes, _asked(job.ask), flat, job.columns, job.ask)

    @classmethod
    def _shaped(
        cls,
        axes: tuple[Axis, ...],
        quantities: tuple[str, ...],
        flat: Columns,
        columns: Mapping[str, Column],
        ask: dict[str, Any],
    ) -> Sweep:
        shape = tuple(len(axis) for axis in axes)
        arrays = {name: np.asarray(flat[name]).reshape(*shape, *columns[name].shape) for name in columns}
        return cls(axes, quantities, arrays, columns, ask)

    @property
    def words(self) -> dict[str, tuple[str, ...]]:
        """What is kept as the number of a word, and the words."""
        return {"outcome": CELL_OUTCOMES, "reason": REASONS, "stall": STALLS}

    def __getitem__(self, quantity: str) -> np.ndarray[Any, Any]:
        """One quantity over the map; labels in words."""
        if quantity == "label" and "label" in self.quantities:
            return label_text(self.arrays)
        if quantity not in self.arrays:
            known = [name for name in (*self.quantities, "outcome")]
            raise ParameterError("quantity", quantity, f"one of {', '.join(known)}")
        return self.arrays[quantity]

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """The map with named coordinates and units, labels in words."""
        from percuss.explore.dataset import map_dataset

        return map_dataset(self.axes, self.quantities, self.arrays, self.columns, self.words)


def _asked(ask: Mapping[str, Any]) -> tuple[str, ...]:
    """All quantities of a map, one's own last."""
    return (*ask["quantities"], *ask.get("functions", ()))


def sweep(
    what: System | Machine | Family,
    *axes: Axis | str,
    quantities: Sequence[str] | None = None,
    periods: int = 1,
    modes: int | None = None,
    start: Start | None = None,
    stop: Stop | None = None,
    impacts: int = 2000,
    discard: int = 500,
    functions: Mapping[str, SystemFunction] | None = None,
    **running: Any,
) -> Sweep:
    """Quantities of a system over a parameter curve (one axis), a plane (two), or more.

    Parameters
    ----------
    what
        A system, or a machine that switches its own valve, whose dimensionless parameters are varied; or a family, such
        as `percuss.case.CaseFamily`.
    axes
        `Axis`, or text such as ``"restitution=0:0.9:200"``; ``m`` is the load periods per impact. The names are those
        of the family's parameters.
    quantities
        Names of `percuss.explore.QUANTITIES`, for machines of `percuss.explore.MACHINE_QUANTITIES`; by default some of
        those that cost little.
    periods
        m, when it is no axis.
    modes
        N: every quantity is that of the bar of modes 0 … N. None, as elsewhere: the steady motions are those of the
        continuous bar, the exact multipliers, the simulations and the machines take 32 modes.
    start, stop
        Of the simulations. By default each starts at rest one bar length off the wall, or as the case says, and ends
        when its motion is found, after 2000 impacts at the latest.
    impacts, discard
        Of a Lyapunov exponent: the impacts it is taken from, and those that are let pass before.
    functions
        One's own quantities by name: functions of a system or machine that return a number. Worker processes import
        them: from a module, or from the main part of a script whose call stands under a main guard. One that raises a
        `PercussError` or divides by 0 leaves NaN.
    **running
        How it is carried out: ``workers``, ``archive``, ``resume``, ``pool``, ``progress``; see
        `percuss.explore.carry_out`.

    Returns
    -------
    Sweep
        With a value in every cell; what could not be computed in one is its ``outcome``.

    Raises
    ------
    ParameterError
        For parameters and quantities that there are not, or axes that do not go together.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import sweep
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> found = sweep(system, "restitution=0.2,0.6", "load_factor=0.4,0.9", quantities=["orbits", "stable"], workers=1)
    >>> found["orbits"]
    array([[2, 0],
           [2, 2]], dtype=int16)
    >>> found.dataset["stable"].sel(restitution=0.6).values
    array([False,  True])
    """
    from percuss.explore.jobs.carrying_out import carry_out

    job = sweep_job(
        what, *axes, quantities=quantities, periods=periods, modes=modes, start=start, stop=stop, impacts=impacts,
        discard=discard, functions=functions,
    )  # fmt: skip
    return Sweep.shaped(job, carry_out(job, **running))
