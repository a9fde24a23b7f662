"""`run`: the only public door to the kernels for a single motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from percuss.model import Machine, System
from percuss.model.checks import callback, count, instance
from percuss.shown import watched
from percuss.simulate.engine import Clocked, Progress
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.simulate.trajectory import Trajectory

if TYPE_CHECKING:
    from percuss.simulate.flights import Anchor
    from percuss.simulate.valve import SelfSwitching


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
