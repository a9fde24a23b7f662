"""A machine that switches its own valve, as an experiment asks it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.machine_attractors import MachineAttractor, machine_attractors, matched_machines
from percuss.explore.attractors.machine_cycles import MACHINE_COLUMNS, followed, labels
from percuss.explore.attractors.machine_draws import drawn_machines, farthest_port, own_machines, speed_scale
from percuss.explore.attractors.motion_columns import start_columns, start_values, starts_from
from percuss.explore.attractors.own_starts import MODE, end_starts
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.quantities import CYCLE_KINDS
from percuss.explore.rough_time import seconds_of_machine_start
from percuss.model import Machine
from percuss.model.checks import Array, finite, instance
from percuss.model.described import describe_machine

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import AnyStarts
    from percuss.simulate import MachineStarts, Stop

__all__ = ["SwitchingHammer"]

_TIME = "machine's unit of time"
_STATE = Column("int64", meaning="state of the valve at the start, by its number")
_SCALES = {
    "position": ("length_scale", "m"),
    **dict.fromkeys(("velocity", "blow_speed"), ("speed_scale", "m/s")),
    "energy_lost": ("energy_scale", "J"),
    **dict.fromkeys(("end_time", "period"), ("time_scale", "s")),
}


@dataclass(frozen=True)
class SwitchingHammer:
    """See `percuss.explore.attractors.hammer.Hammer`."""

    machine: Machine

    @property
    def kind(self) -> str:
        """``machine``."""
        return "machine"

    @property
    def described(self) -> dict[str, Any]:
        """The machine in plain numbers."""
        return {self.kind: describe_machine(self.machine)}

    @property
    def columns(self) -> Mapping[str, Column]:
        """`MACHINE_COLUMNS`."""
        return MACHINE_COLUMNS

    @property
    def states(self) -> tuple[str, ...]:
        """The names of the valve's states."""
        return tuple(name for name, _ in self.machine.valve.pairs)

    @property
    def words(self) -> Mapping[str, Sequence[str]]:
        """Outcomes, places of stalls, kinds of cycles, and states."""
        from percuss.simulate import MACHINE_OUTCOMES, STALLS

        return {"code": MACHINE_OUTCOMES, "stall": STALLS, "cycle_kind": CYCLE_KINDS, "state": self.states}

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """By the scales of the machine."""
        if not self.machine.is_si:
            return {}
        return {name: (float(getattr(self.machine, scale)), unit) for name, (scale, unit) in _SCALES.items()}

    @property
    def about(self) -> dict[str, Any]:
        """The scaling."""
        unit = "seconds" if self.machine.is_si else _TIME
        return {"scaling": f"lengths in bar lengths, times in the {unit}, energies per unit of mass"}

    def check(self, modes: int) -> None:
        """The modes on the chamber are made now."""
        self.machine.modes(modes)

    def named(self, distribution: str, number: int, seed: int, first: int = 0) -> MachineStarts:
        """Scaled by the ports and the valve's forces."""
        return drawn_machines(self.machine, distribution, number, seed, first)

    def own(self, source: Any, seed: int) -> MachineStarts:
        """A file, a function of the seed, or the starts themselves."""
        return own_machines(self.machine, source, seed)

    def value(self, where: str, name: object, value: object) -> tuple[str, float]:
        """Position, velocity or modal amplitude, and the state of the valve by its name or number."""
        if name == "state":
            if value in self.states:
                return "state", float(self.states.index(str(value)))
            if isinstance(value, int | float) and value in range(len(self.states)):
                return "state", float(value)
            raise ParameterError("state", value, f"one of {', '.join(map(repr, self.states[:6]))}")
        if isinstance(name, str) and (name in ("position", "velocity") or MODE.fullmatch(name)):
            return name, finite(name, value)
        known = "position, velocity, state, u_1, u_2, …, v_1, v_2, …"
        remedy = "no clock drives the machine" if name == "time" else ""
        raise ParameterError(where, name, f"one of {known}", remedy)

    def on_a_grid(self, grid: dict[str, Array]) -> MachineStarts:
        """With the state of the valve; its own starting state where none is said."""
        from percuss.simulate import MachineStarts

        bars = {name: values for name, values in grid.items() if name != "state"}
        usual = self.states.index(self.machine.valve.start or self.states[0])
        state = grid.get("state", np.array(float(usual))).astype(np.int64)
        return MachineStarts(end_starts(self.machine.body, self.machine.at, bars), state, self.states)

    def start_columns(self, displacements: int, velocities: int) -> dict[str, Column]:
        """With the state of the valve in place of the load phase."""
        columns = start_columns(displacements, velocities)
        del columns["time"]
        if "velocity" in columns:
            unit = f"bar lengths/{_TIME}"
            columns["velocity"] = Column(unit=unit, meaning=columns["velocity"].meaning)
        return {**columns, "state": _STATE}

    def start_values(self, starts: AnyStarts) -> Columns:
        """Starts as columns."""
        own = _switching(starts)
        values = start_values(own.bars)
        del values["time"]
        return {**values, "state": own.state.copy()}

    def starts_from(self, columns: Columns) -> MachineStarts:
        """The starts that columns hold."""
        from percuss.simulate import MachineStarts

        bars = starts_from({**columns, "time": np.zeros(columns["position"].shape)})
        return MachineStarts(bars, columns["state"], self.states)

    def rough_seconds(self, modes: int) -> float:
        """By the number of modes."""
        return seconds_of_machine_start(modes)

    def followed(
        self, starts: AnyStarts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """By `simulate_machines`."""
        return followed(self.machine, _switching(starts), modes, stop, threads, stopped)

    def labels(self, columns: Columns) -> npt.NDArray[np.str_]:
        """As `MachineTrajectory.label`."""
        return labels(columns)

    def matched(self, columns: Columns, distance: float) -> npt.NDArray[np.int64]:
        """By labels, periods and speeds."""
        scale = speed_scale(self.machine) or farthest_port(self.machine)
        return matched_machines(columns, scale, distance)

    def attractors(
        self, columns: Columns, number: npt.NDArray[np.int64], starts: AnyStarts, modes: int, stop: Stop
    ) -> tuple[MachineAttractor, ...]:
        """With the blows of a period of each."""
        return machine_attractors(columns, number, self.machine, _switching(starts), modes, stop)


def _switching(starts: AnyStarts) -> MachineStarts:
    from percuss.simulate import MachineStarts

    return instance("starts", starts, MachineStarts)
