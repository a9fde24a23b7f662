"""A map as a job: its cells, what is asked of them, and which questions have no answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError
from percuss.explore.axis import Axis
from percuss.explore.cells import NO_START, Asked, cell_columns, failure
from percuss.explore.family import Family, family_of
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.parameters import PERIODS
from percuss.explore.planes import fits_plane, plane_columns
from percuss.explore.quantities import DEFAULT_QUANTITIES, QUANTITIES, checked, columns_of, needs
from percuss.explore.rough_time import seconds_of_cell, seconds_of_plane_cell
from percuss.model import System
from percuss.model.checks import Array, count, instance, mapping
from percuss.stability.verdict import DEFAULT_MODES
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop

__all__ = ["SweepJob", "SystemFunction", "sweep_job"]

SystemFunction = Callable[[System], float]
"""One's own quantity of a map."""

_MOST_IMPACTS = 10**7


@dataclass(frozen=True, eq=False)
class SweepJob:
    """A map as a job: its items are the cells, the last axis running fastest.

    Attributes
    ----------
    family
        Gives the system of each cell.
    axes
        One or more.
    quantities
        Names; see `percuss.explore.QUANTITIES`.
    periods
        m, where it is no axis.
    modes
        N, of the steady motions, their multipliers and the simulations; None for the steady motions of the continuous
        bar, multipliers of 32 modes, and simulations of `simulated`.
    simulated
        N of the simulations.
    start
        Of the simulations; None for that of the family.
    stop
        Of the simulations.
    impacts, discard
        Of a Lyapunov exponent.
    functions
        One's own quantities, by name.
    """

    family: Family
    axes: tuple[Axis, ...]
    quantities: tuple[str, ...]
    periods: int
    modes: int | None
    simulated: int
    start: Start | None
    stop: Stop
    impacts: int
    discard: int
    functions: tuple[tuple[str, SystemFunction], ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of cells along the axes of the map."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    @property
    def rough_seconds(self) -> float:
        """What all cells take, by rule of thumb."""
        groups = needs(self.quantities)
        if self._is_plane:
            return self.size * seconds_of_plane_cell(groups, self.multiplier_modes)
        return self.size * seconds_of_cell(groups, self.multiplier_modes, self.simulated, len(self.functions))

    @property
    def _is_plane(self) -> bool:
        return not self.functions and fits_plane(self.family, [axis.name for axis in self.axes], self.quantities)

    @property
    def multiplier_modes(self) -> int:
        """N of the exact multipliers."""
        return DEFAULT_MODES if self.modes is None else self.modes

    @cached_property
    def is_si(self) -> bool:
        """Whether the systems have scales: energies are in J then."""
        for at in (0, self.size // 2, self.size - 1):
            try:
                return self.family.system(self._system_values(self.cell(at))).is_si
            except PercussError:
                continue
        return False

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the quantities asked for, and the outcome of each cell."""
        own = {name: Column(meaning=f"of {_qualified(function)}") for name, function in self.functions}
        return {**columns_of(self.quantities, self.is_si), **own}

    @property
    def ask(self) -> dict[str, Any]:
        """Axes, quantities, the family and the options."""
        wanted = needs(self.quantities)
        simulated = bool(wanted & {"simulation", "lyapunov"})
        ask: dict[str, Any] = {
            "kind": "sweep",
            "percuss": ASK_FORMAT,
            "axes": [axis.to_json_dict() for axis in self.axes],
            "quantities": list(self.quantities),
            "periods": self.periods,
            "modes": self.multiplier_modes if wanted & {"orbits", "exact"} or not simulated else self.simulated,
            "family": self.family.describe(),
        }
        if self.modes is not None and wanted & {"orbits", "exact"}:
            ask["cut"] = self.modes
        if simulated:
            if ask["modes"] != self.simulated:
                ask["simulated"] = self.simulated
            ask["start"] = None if self.start is None else _described(self.start, self.simulated)
            ask["stop"] = {"impacts": self.stop.impacts, "time": self.stop.time, "tolerance": self.stop.tolerance}
            if "lyapunov" in self.quantities:
                ask["lyapunov"] = {"impacts": self.impacts, "discard": self.discard}
        if self.functions:
            ask["functions"] = {name: _qualified(function) for name, function in self.functions}
        return ask

    def cell(self, i: int) -> dict[str, float]:
        """The parameters of cell number `i`."""
        at = np.unravel_index(i, self.shape)
        return {axis.name: float(axis.values[j]) for axis, j in zip(self.axes, at, strict=True)}

    def _system_values(self, cell: Mapping[str, float]) -> dict[str, float]:
        return {name: value for name, value in cell.items() if name != PERIODS}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The columns of the cells `first` … `last` − 1."""
        asked = Asked(
            self.quantities,
            self.multiplier_modes,
            self.modes,
            self.simulated,
            self.stop,
            self.impacts,
            self.discard,
            self.is_si,
        )
        if self._is_plane:
            return self._by_plane(asked, first, last)
        systems: list[System | None] = []
        starts: list[Start | None] = []
        outcomes, periods = [], []
        for i in range(first, last):
            if stopped():
                break
            cell = self.cell(i)
            system, start, outcome = None, None, 0
            try:
                system = self.family.system(self._system_values(cell))
                start = self._start(cell)
            except (PercussError, ArithmeticError) as error:
                outcome = failure(error) if system is None else NO_START
            systems.append(system)
            starts.append(start)
            outcomes.append(outcome)
            periods.append(int(cell.get(PERIODS, self.periods)))
        found = cell_columns(asked, systems, outcomes, periods, starts, stopped)
        for name, function in self.functions:
            found[name] = _values(function, systems, found["outcome"])
        return found

    def _start(self, cell: Mapping[str, float]) -> Start | None:
        """The start of a cell's simulation; None when nothing is simulated."""
        if not needs(self.quantities) & {"simulation", "lyapunov"}:
            return None
        if self.start is not None:
            return self.start
        from percuss.simulate import Start

        of_family = getattr(self.family, "start", None)
        return Start.rigid() if of_family is None else of_family(self._system_values(cell), self.simulated)

    def _by_plane(self, asked: Asked, first: int, last: int) -> Columns:
        """All cells at once where only R, the load factor and m differ: the closed form over arrays."""
        at = np.unravel_index(np.arange(first, last), self.shape)
        values = {axis.name: axis.values[j] for axis, j in zip(self.axes, at, strict=True)}
        periods = values.pop(PERIODS, np.full(last - first, float(self.periods))).astype(int)
        return plane_columns(asked, self.family.system({}), values, periods)


def sweep_job(
    what: System | Family,
    *axes: Axis | str,
    quantities: Sequence[str] = DEFAULT_QUANTITIES,
    periods: int = 1,
    modes: int | None = None,
    simulated: int = DEFAULT_MODES,
    start: Start | None = None,
    stop: Stop | None = None,
    impacts: int = 2000,
    discard: int = 500,
    functions: Mapping[str, SystemFunction] | None = None,
) -> SweepJob:
    """The job of a sweep, checked; see `sweep`.

    Parameters
    ----------
    simulated
        Elastic modes of the simulations, when `modes` does not say it.
    """
    from percuss.simulate import Start, Stop

    family = family_of(what)
    own = _checked_functions({} if functions is None else functions)
    names = checked(quantities) if quantities or not own else ()
    spans = tuple(axis if isinstance(axis, Axis) else Axis.parsed(axis) for axis in axes)
    _check_axes(family, spans)
    number = None if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    job = SweepJob(
        family=family,
        axes=spans,
        quantities=names,
        periods=count("periods", periods, most=MAX_PERIODS),
        modes=number,
        simulated=count("modes", simulated, least=0, most=MAX_MODES) if number is None else number,
        start=None if start is None else instance("start", start, Start),
        stop=Stop() if stop is None else instance("stop", stop, Stop),
        impacts=count("impacts", impacts, least=10, most=_MOST_IMPACTS),
        discard=count("discard", discard, least=0, most=_MOST_IMPACTS),
        functions=own,
    )
    _check_some(job)
    return job


def _check_some(job: SweepJob) -> None:
    """The refusal of the first cell, when none of several over the map has a system: then the question is wrong."""
    refused: list[Exception] = []
    some = np.unique([[0, n // 3, n // 2, 2 * n // 3, n - 1] for n in job.shape], axis=1)
    for place in product(*some.tolist()):
        cell = job.cell(int(np.ravel_multi_index(place, job.shape)))
        try:
            job.family.system(job._system_values(cell))
            return
        except (PercussError, ArithmeticError) as error:
            refused.append(error)
    raise refused[0]


def _check_axes(family: Family, axes: tuple[Axis, ...]) -> None:
    if not axes:
        raise ParameterError("axes", None, "one or more axes, such as restitution=0:0.9:200")
    names = [axis.name for axis in axes]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ParameterError("axes", twice[0], "each parameter on one axis only")
    for axis in axes:
        if axis.name == PERIODS and (axis.unit or np.any(axis.values % 1.0) or not _whole(axis.values)):
            raise ParameterError(PERIODS, axis.values, f"whole numbers from 1 to {MAX_PERIODS}")
    family.check({axis.name: axis.unit for axis in axes if axis.name != PERIODS})


def _checked_functions(functions: Mapping[str, SystemFunction]) -> tuple[tuple[str, SystemFunction], ...]:
    for name, function in mapping("functions", functions, "functions of a system by name").items():
        if name in QUANTITIES or name == "outcome" or not str(name).isidentifier():
            raise ParameterError("functions", name, "a name of one word that no quantity has")
        if not callable(function):
            raise ParameterError(name, function, "a function of a system")
    return tuple(functions.items())


def _qualified(function: SystemFunction) -> str:
    """What the function is called, with its module."""
    return f"{function.__module__}.{getattr(function, '__qualname__', type(function).__name__)}"


def _values(function: SystemFunction, systems: Sequence[System | None], outcome: npt.NDArray[Any]) -> Array:
    """The function of every system; where it fails NaN, and the outcome says so."""
    found = np.full(len(outcome), np.nan)
    for i, system in enumerate(systems):
        if system is not None:
            try:
                found[i] = function(system)
            except (PercussError, ArithmeticError) as error:
                outcome[i] = failure(error)
    return found


def _whole(values: Array) -> bool:
    return bool(values.min() >= 1 and values.max() <= MAX_PERIODS)


def _described(start: Start, modes: int) -> dict[str, Any]:
    """A start in JSON's types."""
    displacement, velocity, gap = start.state(modes)
    return {
        "displacement": np.asarray(displacement).tolist(),
        "velocity": np.asarray(velocity).tolist(),
        "gap": float(gap),
        "time": start.time,
    }
