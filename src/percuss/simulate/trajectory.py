"""A simulated motion that can be continued, saved and read again."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from percuss.model.checks import callback
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.stop import Stop, further

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.engine import Progress


@dataclass(frozen=True)
class Trajectory(SimulatedMotion):
    """A simulated motion; made by `run`, and by `Trajectory.load` from a file.

    Of a system all quantities are dimensionless (theory §1): lengths in bar lengths, times in radians of the load's
    fundamental. Times are absolute: `begin_time` is the load phase of the start, and the load has phase t at the time
    t. Of a machine lengths are those of the bar, times in the machine's unit: seconds for a machine made from SI, with
    energies per kilogram of it and bar length squared, see `Machine`.

    Attributes
    ----------
    hammer, modes
        What moved, and N, the number of its elastic modes; see `system` and `machine`.
    events
        The event table.
    states
        The state after each event in the form of the engine, shape (events, 2N + 2): gap, u_0', amplitudes; see
        `displacement` and `velocity` for u_n and u_n'. Of a machine with a supply one number more, see `pressure`.
    start, resting
        The state at the start, in the same form, and whether the bar rests on the wall there.
    outcome
        How it ended: one of `percuss.simulate.OUTCOMES`.
    label
        What motion it is at the end: ``z=p/n`` (p impacts in n load periods, no rest), ``chatter/n`` (a cycle of n
        load periods with complete chatter and rest), ``rest/n`` (with rest, but finitely many impacts), ``rest`` (for
        good), ``departed``, ``aperiodic`` (the last 64 impacts come back to no state up to 32 impacts before, to 1e-3
        of phase and speed), ``undecided``; ``rest/?`` or ``chatter/?`` where `period_unresolved`. Of a machine
        ``runs n/m``, n blows in a valve cycle and m valve cycles until it repeats; ``double blow n/m`` with n of 2 or
        more; ``runs with rest n/m``; ``cycles without blow``; ``stalls (…)``, see `percuss.simulate.STALLS`;
        ``irregular``, or ``undecided`` where too little was followed to tell.
    cycle
        The periodic motion, or None when none was found.
    stop
        The rule it was stopped by.
    begin_time, end_time
        First and last time for which the motion is known.
    snapshot
        What `continued` goes on from.
    """

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
        from percuss.simulate.motion_files import continued

        callback("progress", progress)
        return replace(self, **continued(self, further(stop, self.stop, self.impacts), progress))

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
        from percuss.simulate.motion_files import motion_from, opened

        return motion_from(*opened(path), cls)
