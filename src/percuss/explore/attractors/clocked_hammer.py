"""A system whose load keeps time by itself, as an experiment asks it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.cycles import COLUMNS, followed
from percuss.explore.attractors.grouping import Attractor, attractors_of, labels, matched
from percuss.explore.attractors.motion_columns import start_columns, start_values, starts_from
from percuss.explore.attractors.own_starts import MODE, end_starts, own
from percuss.explore.attractors.start_distributions import named
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.quantities import CYCLE_KINDS
from percuss.explore.rough_time import seconds_of_start
from percuss.model import System
from percuss.model.checks import Array, finite, instance
from percuss.model.described import describe_system

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import AnyStarts
    from percuss.simulate import Starts, Stop

__all__ = ["ClockedHammer"]

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
    """See `percuss.explore.attractors.hammer.Hammer`."""

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

    def start_values(self, starts: AnyStarts) -> Columns:
        """Starts as columns."""
        return start_values(_bars(starts))

    def starts_from(self, columns: Columns) -> Starts:
        """The starts that columns hold."""
        return starts_from(columns)

    def rough_seconds(self, modes: int) -> float:
        """By the number of modes."""
        return seconds_of_start(modes)

    def followed(
        self, starts: AnyStarts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
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
        self, columns: Columns, number: npt.NDArray[np.int64], starts: AnyStarts, modes: int, stop: Stop
    ) -> tuple[Attractor, ...]:
        """With the impacts of a cycle of each."""
        return attractors_of(columns, number, self.system, _bars(starts), modes, stop)


def _bars(starts: AnyStarts) -> Starts:
    from percuss.simulate import Starts

    return instance("starts", starts, Starts)
