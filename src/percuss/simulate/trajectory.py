"""A simulated motion that can be balanced, continued, saved and read again."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, callback
from percuss.shown import Shown
from percuss.simulate.events import Cycle, label_of
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.stop import OUTCOMES, Stop, further

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.engine import Progress
    from percuss.simulate.simulated_motion import EnergyBalance

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Trajectory(SimulatedMotion):
    """A simulated motion; made by `run`, and by `Trajectory.load` from a file.

    All quantities are dimensionless (theory §1): lengths in bar lengths, times in radians of the load's fundamental.
    Times are absolute: `begin_time` is the load phase of the start, and the load has phase t at the time t.

    Attributes
    ----------
    system, modes
        What moved, and N, the number of its elastic modes.
    events
        The event table.
    states
        The state after each event in the form of the engine, shape (events, 2N + 2): gap, u_0', amplitudes; see
        `displacement` and `velocity` for u_n and u_n'.
    outcome
        How it ended: ``impacts``, ``time``, ``rest``, ``periodic``, ``departed``, ``work``, ``memory``,
        ``cancelled`` or ``unresolved``; see `percuss.simulate.OUTCOMES`.
    label
        What motion it is at the end: ``z=p/n`` (p impacts in n load periods, no rest), ``chatter/n`` (a cycle of n
        load periods with complete chatter and rest), ``rest/n`` (with rest, but finitely many impacts), ``rest`` (for
        good), ``departed``, ``aperiodic`` (the last 64 impacts come back to no state up to 32 impacts before, to 1e-3
        of phase and speed), ``undecided``; ``rest/?`` or ``chatter/?`` where `period_unresolved`.
    cycle
        The periodic motion, or None when none was found.
    stop
        The rule it was stopped by.
    begin_time, end_time
        First and last time (rad) for which the motion is known.
    """

    # -- energy --

    def energy_balance(self, first: float | None = None, last: float | None = None) -> EnergyBalance:
        """The energy that the load put in and where it went, between two times (default: the whole motion).

        The work of the load and of damping are integrated over the closed forms, flight by flight, with Gauss's rule.
        """
        from percuss.simulate.simulated_motion import energy_balance

        return energy_balance(self, first, last)

    # -- going on --

    def continued(self, stop: Stop | None = None, progress: Callable[[Progress], object] | None = None) -> Trajectory:
        """The same motion followed further, with the same bits as if it had never been interrupted.

        Parameters
        ----------
        stop
            The new rule; impacts and time count from the start of the motion, not from here. None: as many impacts
            again, whether a periodic motion is found or not.
        progress
            See `run`.
        """
        from percuss.simulate.engine import go_on

        callback("progress", progress)
        return go_on(self, further(stop, self.stop, self.impacts), progress)

    # -- files --

    def to_xarray(self) -> xarray.Dataset:
        """The event table, the states and all that is needed to go on, with names and units."""
        from percuss.simulate.motion_files import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a NetCDF file that `Trajectory.load` reads."""
        from percuss.simulate.motion_files import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """The motion in a NetCDF file; `continued` goes on from it bit for bit.

        Raises
        ------
        PercussError
            When the file cannot be read or is not a trajectory.
        """
        from percuss.simulate.motion_files import read

        return read(path, cls)

    def __str__(self) -> str:
        count = len(self.events)
        return (
            f"Trajectory {self.label}: {self.impacts} impacts, {count} event{'s' if count != 1 else ''} in "
            f"{(self.end_time - self.begin_time) / _TURN:.6g} load periods, {self.modes} modes, "
            f"ended by {self.outcome}"
        )


# ---- The results of many motions: one row each, with their labels and shares

_MOST_TOLD = 5


@dataclass(frozen=True)
class EnsembleProgress:
    """How far an ensemble has come: members done, of how many."""

    done: int
    members: int

    @property
    def fraction(self) -> float:
        """0 to 1."""
        return self.done / self.members


@dataclass(frozen=True)
class Ensemble(Shown):
    """The results of many motions; one row each, in the order in which they were given. All dimensionless.

    Attributes
    ----------
    modes
        N, the elastic modes of all.
    code
        How each ended: its number in `OUTCOMES`; see `outcome`.
    impacts
        From the start.
    end_time
        Load time (rad) of the last event.
    first, cycle_impacts, cycle_periods, cycle_kind
        The periodic motion of each: the impact (from 0) it begins at, p impacts, n load periods, and without rest (0),
        with rest (1) or with chatter (2); −1, 0, 0, 0 when none was found, and −1, 0, 0 and its kind when the number of
        its load periods hangs on rounding.
    wanders
        Whether the last impacts come near none of the ones before; see `Trajectory.label`.
    blow_rate, main_blow_rate, interval_mean, interval_std, main_interval_mean, main_interval_std
        As in `Summary`; over one cycle when a periodic motion was found, else after `discarded` impacts; NaN with
        fewer than two.
    impact_velocity, blow_energy
        Means over the main blows among the same impacts.
    energy_lost_per_period
        Taken by impacts, chatter and rest in the same time, per load period.
    last_time, last_phase, last_velocity
        Load time, phase and striking speed of the last impacts, shape (members, asked for), ascending, with NaN in
        front where there were fewer; None unless asked for.
    trajectories
        The whole motions; empty unless asked for.
    """

    modes: int
    code: npt.NDArray[np.int8]
    impacts: npt.NDArray[np.int64]
    end_time: Array
    first: npt.NDArray[np.int64]
    cycle_impacts: npt.NDArray[np.int64]
    cycle_periods: npt.NDArray[np.int64]
    cycle_kind: npt.NDArray[np.int8]
    wanders: npt.NDArray[np.bool_]
    blow_rate: Array
    main_blow_rate: Array
    interval_mean: Array
    interval_std: Array
    main_interval_mean: Array
    main_interval_std: Array
    impact_velocity: Array
    blow_energy: Array
    energy_lost_per_period: Array
    last_time: Array | None = None
    last_phase: Array | None = None
    last_velocity: Array | None = None
    trajectories: tuple[Trajectory, ...] = field(default=(), repr=False)

    def __str__(self) -> str:
        shares = list(self.shares.items())
        told = ", ".join(f"{name} {share:.3g}" for name, share in shares[:_MOST_TOLD])
        more = f", and {len(shares) - _MOST_TOLD} more labels" if len(shares) > _MOST_TOLD else ""
        return f"Ensemble: {len(self)} motions with {self.modes} modes; shares {told}{more}"

    def __len__(self) -> int:
        return int(self.code.size)

    @property
    def outcome(self) -> npt.NDArray[np.str_]:
        """How each ended, in words; shape (members,)."""
        return np.array(OUTCOMES)[self.code]

    @cached_property
    def label(self) -> npt.NDArray[np.str_]:
        """What motion each is at its end, as `Trajectory.label`; shape (members,)."""
        keys = np.stack(
            [self.code, self.cycle_impacts, self.cycle_periods, self.cycle_kind, self.wanders.astype(np.int64)], axis=1
        )
        kinds, which = np.unique(keys, axis=0, return_inverse=True)
        names = [
            label_of(OUTCOMES[code], Cycle(0, int(p), int(n), int(kind)) if n else None, bool(wanders), kind)
            for code, p, n, kind, wanders in kinds.tolist()
        ]
        return np.array(names, dtype=str)[which.reshape(-1)]

    @property
    def shares(self) -> dict[str, float]:
        """The share of the members that ends in each motion, the most frequent first."""
        found = Counter(self.label.tolist())
        return {name: number / len(self) for name, number in found.most_common()}

    def to_xarray(self) -> xarray.Dataset:
        """All columns, over the dimensions ``member`` and ``last``."""
        from percuss.simulate.motion_files import ensemble_dataset

        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: values for name, values in columns.items() if isinstance(values, np.ndarray)}
        return ensemble_dataset(self.modes, {"label": self.label, "outcome": self.outcome, **arrays})
