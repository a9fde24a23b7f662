"""What an experiment follows, as the machinery asks it: a system under a clock, or a machine that switches itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.drawn_starts import (
    MODE,
    drawn_machines,
    end_starts,
    farthest_port,
    named,
    own,
    own_machines,
    speed_scale,
    start_columns,
    start_values,
    starts_from,
)
from percuss.explore.attractors.grouping import (
    COLUMNS,
    MACHINE_COLUMNS,
    Attractor,
    MachineAttractor,
    attractors_of,
    followed,
    labels,
    machine_attractors,
    matched,
    matched_machines,
)
from percuss.explore.attractors.grouping import machine_labels as machine_cycles_labels
from percuss.explore.attractors.grouping import machines_followed as machine_cycles_followed
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.quantities import CYCLE_KINDS
from percuss.explore.rough_time import seconds_of_machine_start, seconds_of_start
from percuss.model import Machine, System
from percuss.model.checks import Array, finite, instance
from percuss.model.described import describe_machine, describe_system, machine_from, system_from

if TYPE_CHECKING:
    from percuss.simulate import Starts, Stop

if TYPE_CHECKING:
    AnyAttractor = Attractor | MachineAttractor


class Hammer(Protocol):
    """Draws starts, follows them, and tells apart what they settle on; made by `hammers.hammer_of`."""

    @property
    def kind(self) -> str:
        """The name under which an archive has it: ``system`` or ``machine``."""
        ...

    @property
    def described(self) -> dict[str, Any]:
        """All that its motions depend on, of JSON's types."""
        ...

    @property
    def columns(self) -> Mapping[str, Column]:
        """What is kept of every motion."""
        ...

    @property
    def words(self) -> Mapping[str, Sequence[str]]:
        """Columns whose numbers stand for words, and the words."""
        ...

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """What columns are multiplied by for SI, and their unit then; empty without scales."""
        ...

    @property
    def about(self) -> dict[str, Any]:
        """What a dataset says of the numbers as a whole."""
        ...

    def check(self, modes: int) -> None:
        """Raise now what every start would: a resonance, say."""
        ...

    # -- starts --

    def named(self, distribution: str, number: int, seed: int, first: int = 0) -> Starts:
        """Starts of a named distribution; see `percuss.explore.attractors.drawn_starts.named`."""
        ...

    def own(self, source: Any, seed: int) -> Starts:
        """The rows of one's own distribution; see `percuss.explore.attractors.drawn_starts.own`."""
        ...

    def value(self, where: str, name: object, value: object) -> tuple[str, float]:
        """A quantity of starts by its name, and its value as a number.

        Raises
        ------
        ParameterError
            When starts have no such quantity, or it no such value.
        """
        ...

    def on_a_grid(self, grid: dict[str, Array]) -> Starts:
        """Starts of the striking end from columns of one length by name; what is not named is 0 or as usual."""
        ...

    def start_columns(self, displacements: int, velocities: int) -> dict[str, Column]:
        """The columns of starts with so many modal amplitudes."""
        ...

    def start_values(self, starts: Starts) -> Columns:
        """Starts as columns."""
        ...

    def starts_from(self, columns: Columns) -> Starts:
        """The starts that columns hold."""
        ...

    # -- motions --

    def rough_seconds(self, modes: int) -> float:
        """What one start takes, by rule of thumb."""
        ...

    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """`columns` of the motions from all starts, each by itself."""
        ...

    def labels(self, columns: Columns) -> npt.NDArray[np.str_]:
        """What motion each is at its end."""
        ...

    def matched(self, columns: Columns, distance: float) -> npt.NDArray[np.int64]:
        """The number of the attractor of each motion, 0 for the most frequent."""
        ...

    def attractors(
        self, columns: Columns, number: npt.NDArray[np.int64], starts: Starts, modes: int, stop: Stop
    ) -> tuple[AnyAttractor, ...]:
        """The attractors behind the numbers, in their order."""
        ...


# ---- A system whose load keeps time by itself, as an experiment asks it

_STATES = "position, velocity, time, u_1, u_2, …, v_1, v_2, …"
_SCALES = {
    "position": ("length_scale", "m"),
    **dict.fromkeys(("velocity", "striking_speed", "impact_velocity"), ("speed_scale", "m/s")),
    "blow_energy": ("energy_scale", "J"),
    **dict.fromkeys(
        ("time", "interval_mean", "interval_std", "main_interval_mean", "main_interval_std"), ("time_scale", "s")
    ),
}


@dataclass(frozen=True)
class ClockedHammer:
    """See `percuss.explore.attractors.hammers.Hammer`."""

    system: System

    @property
    def kind(self) -> str:
        """``system``."""
        return "system"

    @property
    def described(self) -> dict[str, Any]:
        """The system in plain numbers."""
        return {self.kind: describe_system(self.system)}

    @property
    def columns(self) -> Mapping[str, Column]:
        """`COLUMNS`."""
        return COLUMNS

    @property
    def words(self) -> Mapping[str, Sequence[str]]:
        """Outcomes and kinds of cycles."""
        from percuss.simulate import OUTCOMES

        return {"code": OUTCOMES, "cycle_kind": CYCLE_KINDS}

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """By the scales of the system."""
        if not self.system.is_si:
            return {}
        return {name: (float(getattr(self.system, scale)), unit) for name, (scale, unit) in _SCALES.items()}

    @property
    def about(self) -> dict[str, Any]:
        """The scaling, and the frequency in SI."""
        frequency = {"frequency_Hz": self.system.frequency} if self.system.is_si else {}
        return {"scaling": "dimensionless: lengths in bar lengths, times in radians of the load phase", **frequency}

    def check(self, modes: int) -> None:
        """ResonanceError when a harmonic of the load meets an undamped mode."""
        from percuss.simulate.spectrum import Spectrum

        Spectrum(self.system, modes)

    def named(self, distribution: str, number: int, seed: int, first: int = 0) -> Starts:
        """Scaled by the load."""
        return named(self.system, distribution, number, seed, first)

    def own(self, source: Any, seed: int) -> Starts:
        """A file, a function of the seed, or the starts themselves."""
        return own(self.system, source, seed)

    def value(self, where: str, name: object, value: object) -> tuple[str, float]:
        """Position, velocity, load phase or modal amplitude."""
        if isinstance(name, str) and (name in ("position", "velocity", "time") or MODE.fullmatch(name)):
            return name, finite(name, value)
        raise ParameterError(where, name, f"one of {_STATES}")

    def on_a_grid(self, grid: dict[str, Array]) -> Starts:
        """With the load phase."""
        return end_starts(self.system.body, self.system.load.at, grid)

    def start_columns(self, displacements: int, velocities: int) -> dict[str, Column]:
        """With the load phase."""
        return start_columns(displacements, velocities)

    def start_values(self, starts: Starts) -> Columns:
        """Starts as columns."""
        return start_values(_bars(starts))

    def starts_from(self, columns: Columns) -> Starts:
        """The starts that columns hold."""
        return starts_from(columns)

    def rough_seconds(self, modes: int) -> float:
        """By the number of modes."""
        return seconds_of_start(modes)

    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """By `simulate_many`."""
        return followed(self.system, _bars(starts), modes, stop, threads, stopped)

    def labels(self, columns: Columns) -> npt.NDArray[np.str_]:
        """As `Trajectory.label`."""
        return labels(columns)

    def matched(self, columns: Columns, distance: float) -> npt.NDArray[np.int64]:
        """By labels, and the numbers of cycles."""
        return matched(columns, float(np.abs(self.system.load.coefficients).sum()), distance)

    def attractors(
        self, columns: Columns, number: npt.NDArray[np.int64], starts: Starts, modes: int, stop: Stop
    ) -> tuple[Attractor, ...]:
        """With the impacts of a cycle of each."""
        return attractors_of(columns, number, self.system, _bars(starts), modes, stop)


def _bars(starts: Starts) -> Starts:
    from percuss.simulate import Starts

    return instance("starts", starts, Starts)


# ---- A machine that switches its own valve, as an experiment asks it

_TIME = "machine's unit of time"
_STATE = Column("int64", meaning="state of the valve at the start, by its number")
_MACHINE_SCALES = {
    "position": ("length_scale", "m"),
    **dict.fromkeys(("velocity", "blow_speed"), ("speed_scale", "m/s")),
    "energy_lost": ("energy_scale", "J"),
    **dict.fromkeys(("end_time", "period"), ("time_scale", "s")),
}


@dataclass(frozen=True)
class SwitchingHammer:
    """See `percuss.explore.attractors.hammers.Hammer`."""

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
        from percuss.simulate import OUTCOMES, STALLS

        return {"code": OUTCOMES, "stall": STALLS, "cycle_kind": CYCLE_KINDS, "state": self.states}

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """By the scales of the machine."""
        if not self.machine.is_si:
            return {}
        return {name: (float(getattr(self.machine, scale)), unit) for name, (scale, unit) in _MACHINE_SCALES.items()}

    @property
    def about(self) -> dict[str, Any]:
        """The scaling."""
        unit = "seconds" if self.machine.is_si else _TIME
        return {"scaling": f"lengths in bar lengths, times in the {unit}, energies per unit of mass"}

    def check(self, modes: int) -> None:
        """The modes on the chamber are made now."""
        self.machine.modes(modes)

    def named(self, distribution: str, number: int, seed: int, first: int = 0) -> Starts:
        """Scaled by the ports and the valve's forces."""
        return drawn_machines(self.machine, distribution, number, seed, first)

    def own(self, source: Any, seed: int) -> Starts:
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

    def on_a_grid(self, grid: dict[str, Array]) -> Starts:
        """With the state of the valve; its own starting state where none is said."""
        bars = {name: values for name, values in grid.items() if name != "state"}
        usual = self.states.index(self.machine.valve.start or self.states[0])
        state = grid.get("state", np.array(float(usual))).astype(np.int64)
        return end_starts(self.machine.body, self.machine.at, bars).with_valve(state, self.states)

    def start_columns(self, displacements: int, velocities: int) -> dict[str, Column]:
        """With the state of the valve in place of the load phase."""
        columns = start_columns(displacements, velocities)
        del columns["time"]
        if "velocity" in columns:
            unit = f"bar lengths/{_TIME}"
            columns["velocity"] = Column(unit=unit, meaning=columns["velocity"].meaning)
        return {**columns, "state": _STATE}

    def start_values(self, starts: Starts) -> Columns:
        """Starts as columns."""
        own = _switching(starts)
        values = start_values(own)
        del values["time"]
        return {**values, "state": np.array(own.state)}

    def starts_from(self, columns: Columns) -> Starts:
        """The starts that columns hold."""
        bars = starts_from({**columns, "time": np.zeros(columns["position"].shape)})
        return bars.with_valve(columns["state"], self.states)

    def rough_seconds(self, modes: int) -> float:
        """By the number of modes."""
        return seconds_of_machine_start(modes)

    def followed(
        self, starts: Starts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """By `simulate_many`."""
        return machine_cycles_followed(self.machine, _switching(starts), modes, stop, threads, stopped)

    def labels(self, columns: Columns) -> npt.NDArray[np.str_]:
        """As `Trajectory.label`."""
        return machine_cycles_labels(columns)

    def matched(self, columns: Columns, distance: float) -> npt.NDArray[np.int64]:
        """By labels, periods and speeds."""
        scale = speed_scale(self.machine) or farthest_port(self.machine)
        return matched_machines(columns, scale, distance)

    def attractors(
        self, columns: Columns, number: npt.NDArray[np.int64], starts: Starts, modes: int, stop: Stop
    ) -> tuple[MachineAttractor, ...]:
        """With the blows of a period of each."""
        return machine_attractors(columns, number, self.machine, _switching(starts), modes, stop)


def _switching(starts: Starts) -> Starts:
    if starts.state is None:
        raise ParameterError("starts", starts, "starts with the states of a valve: see Starts.with_valve")
    return starts


# ---- The hammers that experiments follow, from systems and machines, and from archives


def hammer_of(what: System | Machine) -> Hammer:
    """A system or a machine as an experiment asks it.

    Raises
    ------
    ParameterError
        For anything else.
    """
    if isinstance(what, System):
        return ClockedHammer(what)
    if isinstance(what, Machine):
        return SwitchingHammer(what)
    raise ParameterError("system", what, "a System, or a Machine that switches its own valve")


def hammer_from(ask: Mapping[str, Any]) -> System | Machine:
    """The system or machine that was asked for in an archive."""
    return machine_from(ask["machine"]) if "machine" in ask else system_from(ask["system"])
