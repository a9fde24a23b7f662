"""A simulated motion that can be continued, saved and read again; and `run`, which makes one."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from percuss.model import Machine, System
from percuss.model.checks import callback, count, instance
from percuss.shown import watched
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop, further

if TYPE_CHECKING:
    import pandas
    import xarray

    from percuss.simulate.engine import Clocked, Progress
    from percuss.simulate.spectrum import Anchor
    from percuss.simulate.valve import SelfSwitching


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

    def to_pandas(self) -> pandas.DataFrame:
        """The table of events, a row each: time, kind, and the columns of `Events`; of a machine the valve's state."""
        from percuss.simulate.motion_files import to_table

        return to_table(self)

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


# ---- A motion followed from its start


def run(
    system: System | Machine,
    start: Start | None = None,
    *,
    modes: int = 32,
    stop: Stop | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> Trajectory:
    """Follow the bar from a start: every impact, chatter, rest and release (B77 section 5, theory §§3, 8).

    Of a machine every port and change of the valve besides. The blow, the crossings of ports and the orders that are
    due compete, and the first one is proved to be the first, ringing included. A machine whose valve can never switch
    again stalls, which is proved too; the blows that are left are followed.

    Parameters
    ----------
    system
        What moves: a system under a clock, all of it dimensionless; or a machine that switches its own valve, with
        times in its unit.
    start
        The state and the load phase at the beginning; `Start.rigid()` by default, at rest one bar length off the wall.
        A machine starts at rest on the wall by default, with the valve's own starting state, and at the start's time.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When to end; see `Stop`, of a machine its time in the machine's unit. By default after 2000 impacts, or when a
        periodic motion or rest for good is found.
    progress
        Called now and then with a `Progress`; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    ParameterError
        For a start beyond the wall, with more modes than `modes`, or with a state that the valve does not have.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).

    Examples
    --------
    >>> from percuss import Load, Start, Stop, System, run
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=8)
    >>> print(motion.label, motion.outcome)
    chatter/1 periodic
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> motion = run(machine, modes=0)
    >>> print(motion.label, round(motion.cycle.period, 6))
    runs 1/1 3.148923
    """
    if not isinstance(system, Machine):
        instance("system", system, System)
    usual = Start.rigid(0.0) if isinstance(system, Machine) else Start.rigid()
    start = usual if start is None else instance("start", start, Start)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    moved, anchor, resting = _begun(system, count("modes", modes, least=0, most=MAX_MODES), start, stop)
    with watched(progress) as watch:
        made = moved.followed(stop, start.time, watch)
    return Trajectory(
        hammer=system, modes=moved.modes, start=anchor, resting=resting, stop=stop, begin_time=start.time, **made
    )


def _begun(
    system: System | Machine, modes: int, start: Start, stop: Stop
) -> tuple[Clocked | SelfSwitching, Anchor, bool]:
    if isinstance(system, System):
        from percuss.simulate.engine import Clocked  # the compiler

        return Clocked.begun(system, modes, start)
    from percuss.simulate.valve import SelfSwitching, mechanism  # more kernels

    return SelfSwitching.begun(mechanism(system, modes), start, stop)


def compiled() -> bool:
    """Whether numba's cache holds the kernels for this processor, so that using them takes a moment and not a minute.

    False too where that cannot be told, such as with numba's compiler switched off.
    """
    from numba.core.registry import cpu_target

    from percuss.simulate.kernels.motion import follow

    try:  # what numba calls its own; a test sees to it that this still answers
        index = follow._cache._cache_file._load_index()
        machine = cpu_target.target_context.codegen().magic_tuple()
        return any(key[1] == machine for key in index)
    except Exception:
        return False
