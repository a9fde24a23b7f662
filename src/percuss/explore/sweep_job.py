"""A map as a job: its cells, and what is asked of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import PercussError
from percuss.explore.axis import Axis
from percuss.explore.blow_cells import StrikingFamily, blow_columns
from percuss.explore.cells import NO_START, Asked, cell_columns, failure
from percuss.explore.family import Family, drives_itself
from percuss.explore.jobs.job import ASK_FORMAT, Column, Columns
from percuss.explore.machine_cells import machine_columns
from percuss.explore.machine_quantities import known_quantities
from percuss.explore.own_quantities import SystemFunction, function_values, qualified
from percuss.explore.parameters import PERIODS
from percuss.explore.planes import fits_plane, plane_columns
from percuss.explore.quantities import Group, columns_of, needs
from percuss.explore.rough_time import seconds_of_cell, seconds_of_plane_cell
from percuss.model import Machine, System
from percuss.stability.verdict import DEFAULT_MODES

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop

__all__ = ["SweepJob"]


@dataclass(frozen=True, eq=False)
class SweepJob:
    """A map as a job: its items are the cells, the last axis running fastest.

    Attributes
    ----------
    family
        Gives the system, or the machine, of each cell.
    axes
        One or more.
    quantities
        Names; see `percuss.explore.QUANTITIES`, and `percuss.explore.MACHINE_QUANTITIES` for machines.
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
    def groups(self) -> set[Group]:
        """The groups of what is asked."""
        return needs(self.quantities, known_quantities(self.family))

    @property
    def rough_seconds(self) -> float:
        """What all cells take, by rule of thumb."""
        groups = self.groups
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

    @property
    def asks_systems(self) -> bool:
        """Whether anything is asked of the motion; a case of one blow alone has no system."""
        return bool(self.functions) or bool(self.groups - {"blow"})

    @cached_property
    def is_si(self) -> bool:
        """Whether the systems have scales: energies are in J then."""
        family = self.family
        if isinstance(family, StrikingFamily) and not drives_itself(family):
            return family.is_si
        make = family.machine if drives_itself(family) else family.system
        for at in (0, self.size // 2, self.size - 1):
            try:
                return make(self.system_values(self.cell(at))).is_si
            except PercussError:
                continue
        return False

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the quantities asked for, and the outcome of each cell."""
        own = {name: Column(meaning=f"of {qualified(function)}") for name, function in self.functions}
        return {**columns_of(self.quantities, self.is_si, known_quantities(self.family)), **own}

    @property
    def ask(self) -> dict[str, Any]:
        """Axes, quantities, the family and the options."""
        wanted = self.groups
        simulated = bool(wanted & {"simulation", "lyapunov"})
        of_machines = drives_itself(self.family)
        ask: dict[str, Any] = {
            "kind": "sweep",
            "percuss": ASK_FORMAT,
            "axes": [axis.to_json_dict() for axis in self.axes],
            "quantities": list(self.quantities),
            **({"machines": True} if of_machines else {"periods": self.periods}),
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
            ask["functions"] = {name: qualified(function) for name, function in self.functions}
        return ask

    def cell(self, i: int) -> dict[str, float]:
        """The parameters of cell number `i`."""
        at = np.unravel_index(i, self.shape)
        return {axis.name: float(axis.values[j]) for axis, j in zip(self.axes, at, strict=True)}

    def system_values(self, cell: Mapping[str, float]) -> dict[str, float]:
        """Those of a cell's parameters that its system has."""
        return {name: value for name, value in cell.items() if name != PERIODS}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """The columns of the cells `first` … `last` − 1."""
        if self._is_plane:
            return self._by_plane(first, last)
        cells = [self.cell(i) for i in range(first, last)]
        whats: Sequence[System | Machine | None]
        if drives_itself(self.family):
            asked = self.quantities, self.multiplier_modes, self.is_si
            found, whats = machine_columns(self.family, cells, *asked, stopped)
        else:
            found, whats = self._of_systems(cells, stopped)
        if isinstance(self.family, StrikingFamily) and "blow" in self.groups:
            blow_columns(found, self.family, cells[: len(whats)], stopped)
        for name, function in self.functions:
            found[name] = function_values(function, whats, found["outcome"])
        return found

    @property
    def _asked(self) -> Asked:
        return Asked(
            self.quantities,
            self.multiplier_modes,
            self.modes,
            self.simulated,
            self.stop,
            self.impacts,
            self.discard,
            self.is_si,
        )

    def _of_systems(
        self, cells: Sequence[Mapping[str, float]], stopped: Callable[[], bool]
    ) -> tuple[Columns, list[System | None]]:
        """The columns of cells, one by one, and their systems."""
        systems: list[System | None] = []
        starts: list[Start | None] = []
        outcomes, periods = [], []
        for cell in cells:
            if stopped():
                break
            system, start, outcome = None, None, 0
            try:
                if self.asks_systems:
                    system = self.family.system(self.system_values(cell))
                    start = self._start(cell)
            except (PercussError, ArithmeticError) as error:
                outcome = failure(error) if system is None else NO_START
            systems.append(system)
            starts.append(start)
            outcomes.append(outcome)
            periods.append(int(cell.get(PERIODS, self.periods)))
        return cell_columns(self._asked, systems, outcomes, periods, starts, stopped), systems

    def _start(self, cell: Mapping[str, float]) -> Start | None:
        """The start of a cell's simulation; None when nothing is simulated."""
        if not self.groups & {"simulation", "lyapunov"}:
            return None
        if self.start is not None:
            return self.start
        from percuss.simulate import Start

        of_family = getattr(self.family, "start", None)
        return Start.rigid() if of_family is None else of_family(self.system_values(cell), self.simulated)

    def _by_plane(self, first: int, last: int) -> Columns:
        """All cells at once where only R, the load factor and m differ: the closed form over arrays."""
        at = np.unravel_index(np.arange(first, last), self.shape)
        values = {axis.name: axis.values[j] for axis, j in zip(self.axes, at, strict=True)}
        periods = values.pop(PERIODS, np.full(last - first, float(self.periods))).astype(int)
        return plane_columns(self._asked, self.family.system({}), values, periods)


def _described(start: Start, modes: int) -> dict[str, Any]:
    """A start in JSON's types."""
    displacement, velocity, gap = start.state(modes)
    return {
        "displacement": np.asarray(displacement).tolist(),
        "velocity": np.asarray(velocity).tolist(),
        "gap": float(gap),
        "time": start.time,
    }
