"""`run`: the only public door to the kernels for a single motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import callback, count, instance
from percuss.notebook import watched
from percuss.simulate.engine import Progress, Stretch, follow
from percuss.simulate.events import Events
from percuss.simulate.flight import Anchor
from percuss.simulate.kernels.layout import LOST_CYCLE, RESTING
from percuss.simulate.restored import restored
from percuss.simulate.snapshot import begin
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.simulate.summary import Cycle, label_of
from percuss.simulate.tables import prepared
from percuss.simulate.trajectory import Trajectory

__all__ = ["cycle_of", "go_on", "run", "unresolved"]

_ARRAYS = ("z", "now", "count", "cycle", "past", "sums")


def run(
    system: System,
    start: Start | None = None,
    *,
    modes: int = 32,
    stop: Stop | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> Trajectory:
    """Follow the bar from a start: every impact, chatter, rest and release (B77 section 5, theory §§3, 8).

    Parameters
    ----------
    system
        What moves; all of it dimensionless.
    start
        The state and the load phase at the beginning; `Start.rigid()` by default, at rest one bar length off the wall.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When to end; see `Stop`. By default after 2000 impacts, or when a periodic motion or rest for good is found.
    progress
        Called now and then with a `Progress`; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    ParameterError
        For a start beyond the wall or with more modes than `modes`.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).

    Examples
    --------
    >>> from percuss import Load, Start, Stop, System, run
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=8)
    >>> print(motion.label, motion.outcome)
    chatter/1 periodic
    """
    instance("system", system, System)
    start = Start.rigid() if start is None else instance("start", start, Start)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    spectrum, table = prepared(system, count("modes", modes, least=0, most=MAX_MODES))
    snapshot = begin(spectrum, table, start)
    now, count_ = snapshot.now[0], snapshot.count[0]
    anchor = Anchor(
        float(now["phase"]),
        int(count_["piece"]),
        float(now["gap"]),
        float(now["rigid_rate"]),
        snapshot.z.copy(),
    )
    with watched(progress) as watch:
        stretch = follow(table, snapshot, stop, start.time, watch)
    return _trajectory(system, spectrum.modes, stretch, anchor, int(count_["mode"]) == RESTING, stop, start.time)


def go_on(motion: Trajectory, stop: Stop, progress: Callable[[Progress], object] | None = None) -> Trajectory:
    """A motion followed further."""
    snapshot = restored(motion)
    with watched(progress) as watch:
        stretch = follow(prepared(motion.system, motion.modes)[1], snapshot, stop, motion.begin_time, watch)
    whole = Stretch(
        Events.of_all([motion.events, stretch.events]),
        np.concatenate([motion.states, stretch.states]),
        stretch.snapshot,
        stretch.outcome,
        stretch.wanders,
    )
    return _trajectory(motion.system, motion.modes, whole, motion.start, motion.resting, stop, motion.begin_time)


def cycle_of(count: npt.NDArray[Any]) -> Cycle | None:
    """The confirmed cycle that the engine's whole numbers tell of."""
    if count["confirmed"][0] < 2:
        return None
    names = ("found_at", "cycle_impacts", "cycle_periods", "cycle_kind")
    first, impacts, periods, kind = (int(count[name][0]) for name in names)
    return Cycle(first - 1, impacts, periods, kind)


def unresolved(count: npt.NDArray[Any]) -> bool:
    """Whether the engine's whole numbers tell of equal releases with a number of load periods that is lost."""
    return bool(count["verdict"][0] == LOST_CYCLE)


def _trajectory(
    system: System, modes: int, stretch: Stretch, start: Anchor, resting: bool, stop: Stop, begin_time: float
) -> Trajectory:
    state = stretch.snapshot
    cycle = cycle_of(state.count)
    wanders = not system.load.is_constant and stretch.wanders
    end = state.time if stretch.outcome != "time" or stop.time is None else begin_time + stop.time
    return Trajectory(
        system=system,
        modes=modes,
        events=stretch.events,
        states=stretch.states,
        start=start,
        resting=resting,
        snapshot={name: getattr(state, name) for name in _ARRAYS},
        outcome=stretch.outcome,
        label=label_of(stretch.outcome, cycle, wanders or unresolved(state.count)),
        cycle=cycle,
        stop=stop,
        begin_time=begin_time,
        end_time=max(end, begin_time),
    )
