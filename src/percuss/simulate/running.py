"""`run`: the only public door to the kernels for a single motion."""

from __future__ import annotations

from collections.abc import Callable

from percuss.model import HeldBody, System
from percuss.model.checks import callback, count, instance
from percuss.notebook import watched
from percuss.simulate.engine import Progress
from percuss.simulate.flight import Anchor
from percuss.simulate.going_on import ending
from percuss.simulate.held_release import followed
from percuss.simulate.kernels.codes import RESTING
from percuss.simulate.snapshot import begin
from percuss.simulate.start import Start
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.simulate.tables import prepared
from percuss.simulate.trajectory import Trajectory

__all__ = ["run"]


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
    wanted, body = count("modes", modes, least=0, most=MAX_MODES), system.body
    spectrum, table = prepared(system, body.chosen(wanted) if isinstance(body, HeldBody) else wanted)
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
        stretch = followed(spectrum, table, snapshot, stop, start.time, watch)
    return Trajectory(
        system=system,
        modes=spectrum.modes,
        start=anchor,
        resting=int(count_["mode"]) == RESTING,
        begin_time=start.time,
        **ending(system, stretch, stop, start.time),
    )
