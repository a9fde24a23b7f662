"""A simulated motion that can be balanced, continued, saved and read again."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.checks import callback
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.stop import Stop, further

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.balance import EnergyBalance
    from percuss.simulate.engine import Progress

__all__ = ["Trajectory"]

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
        of phase and speed; or `period_unresolved`), ``undecided``.
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
        from percuss.simulate.balance import energy_balance

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
        from percuss.simulate.going_on import go_on

        callback("progress", progress)
        return go_on(self, further(stop, self.stop, self.impacts), progress)

    # -- files --

    def to_xarray(self) -> xarray.Dataset:
        """The event table, the states and all that is needed to go on, with names and units."""
        from percuss.simulate.netcdf import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a NetCDF file that `Trajectory.load` reads."""
        from percuss.simulate.netcdf import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """The motion in a NetCDF file; `continued` goes on from it bit for bit.

        Raises
        ------
        PercussError
            When the file cannot be read or is not a trajectory.
        """
        from percuss.simulate.netcdf import read

        return read(path, cls)

    def __str__(self) -> str:
        count = len(self.events)
        return (
            f"Trajectory {self.label}: {self.impacts} impacts, {count} event{'s' if count != 1 else ''} in "
            f"{(self.end_time - self.begin_time) / _TURN:.6g} load periods, {self.modes} modes, "
            f"ended by {self.outcome}"
        )
