"""The dispatcher's answer to "how does this hammer move from this start?"."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import heading_dict
from percuss.case.answers.machine_motion import MachineMotion
from percuss.case.answers.orbits_json import orbit_dict
from percuss.case.answers.simulation_json import motion_dict
from percuss.case.answers.told_motion import ToldMotion
from percuss.case.case import checked_case
from percuss.errors import ParameterError
from percuss.model.checks import callback, count, positive
from percuss.simulate import Stop, Trajectory
from percuss.stability import orbit_multipliers
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.recordings.history import HistoryReport
    from percuss.simulate import MachineTrajectory, Progress, Summary
    from percuss.steady import PeriodicOrbit

__all__ = ["SimulationAnswer", "resumed_answer", "simulation_answer"]


@dataclass(frozen=True)
class SimulationAnswer(ToldMotion):
    """A simulated motion of a case.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    motion
        The motion: events, summary, fields.
    notes
        What was assumed in reading the recording.
    """

    name: str
    title: str
    motion: Trajectory
    notes: tuple[str, ...] = ()

    @property
    def system(self) -> System:
        """The system that moved."""
        return self.motion.system

    @property
    def summary(self) -> Summary:
        """Means over the settled part of the motion."""
        return self.motion.summary

    @cached_property
    def orbit(self) -> PeriodicOrbit | None:
        """The periodic orbit that the motion has settled on, see `percuss.explore.orbit_of`; or None."""
        from percuss.explore import orbit_of  # loads the compiler

        return orbit_of(self.motion)

    @property
    def history(self) -> HistoryReport | None:
        """What was found in the recording, or None when the load is a formula or the motion comes from a file."""
        return self.system.load.report

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        return tuple(_warnings(self.motion))

    def _told(self, last: int | None) -> dict[str, Any]:
        heading = heading_dict(self.name, self.title, self.system, self.notes)
        found = self.orbit
        orbit = None if found is None else orbit_dict(found, orbit_multipliers(found).values)
        return {**heading, **motion_dict(self.motion, self.warnings, last), "orbit": orbit}


def simulation_answer(case: Case, progress: Callable[[Progress], object] | None = None) -> SimulationAnswer:
    """The motion that the tables [start] and [simulation] of a case describe; see `Case.changed` for others.

    Parameters
    ----------
    progress
        Called now and then; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    CaseError
        When the start does not fit the case, or its recording cannot be used.
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.

    Examples
    --------
    >>> from percuss.case import Case
    >>> case = Case.from_text('''
    ... [system]
    ... s = 20.0
    ... d = 0.0048
    ... restitution = 0.2
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.9
    ... amplitude = 1.0
    ... [simulation]
    ... modes = 0
    ... ''')
    >>> answer = simulation_answer(case)
    >>> answer.motion.label, answer.motion.outcome
    ('chatter/1', 'periodic')
    """
    from percuss.simulate import run  # loads the compiler

    checked_case(case)
    callback("progress", progress)
    simulation = case.simulation()
    start = case.start(simulation.modes)
    motion = run(case.system(), start, modes=simulation.modes, stop=simulation.stop, progress=progress)
    return SimulationAnswer(case.file, case.title, motion, case.notes)


def resumed_answer(
    path: str | os.PathLike[str],
    impacts: int | None = None,
    time: float | str | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> SimulationAnswer | MachineMotion:
    """The motion of a file that `save` of a trajectory wrote, followed further with the same bits.

    Parameters
    ----------
    impacts, time
        When to end, both counted from the start of the motion; time in radians (of a machine: its unit), or text
        with a unit where the file has scales. None for both: as many impacts again. A periodic motion that is found
        does not end it.

    Raises
    ------
    PercussError
        When the file cannot be read or holds no trajectory.
    ParameterError
        When the motion in the file already goes as far.
    """
    from percuss.simulate.saved_motion import saved_motion  # loads the compiler

    callback("progress", progress)
    motion = saved_motion(path)
    if impacts is None and time is None:
        stop = None
    else:
        if time is not None:
            time = _plain(motion, time) if isinstance(time, str) else positive("time", time)
        if impacts is not None:
            impacts = count("impacts", impacts)
        gone = motion.end_time - motion.begin_time
        if impacts is not None and impacts <= motion.impacts:
            raise ParameterError("impacts", impacts, f"more than the {motion.impacts} that the file holds")
        if time is not None and time <= gone:
            raise ParameterError("time", time, f"more than the {gone:.6g} that the file holds")
        tolerance = motion.stop.tolerance
        stop = replace(Stop(impacts=impacts, time=time), periodic=False, tolerance=tolerance)
    name, title = os.fspath(path), Path(path).stem
    if isinstance(motion, Trajectory):
        return SimulationAnswer(name, title, motion.continued(stop, progress))
    return MachineMotion(name, title, motion.continued(stop, progress))


def _plain(motion: Trajectory | MachineTrajectory, text: str) -> float:
    """A time without its unit."""
    moved = motion.system if isinstance(motion, Trajectory) else motion.machine
    if not moved.is_si:
        raise ParameterError("time", text, "a plain number: the file has no scales")
    return si(text, "time", "time") / moved.time_scale


def _warnings(motion: Trajectory) -> list[str]:
    found = []
    touches = len(motion.events.of("grazing"))
    if touches:
        some = "one touch" if touches == 1 else f"{touches} touches"
        found.append(f"{some} so slight that rounding hides whether the bar strikes or misses; it goes on unchanged")
    if motion.outcome == "work":
        found.append("ended early: one flight hovers before the wall for longer than can be followed")
    if motion.outcome == "memory":
        found.append("ended early: the record has reached 1 GB; continue a saved motion, or use fewer modes")
    if motion.outcome == "cancelled":
        found.append("ended early: interrupted; the figures are those of the part that was computed")
    if motion.label == "undecided" and motion.outcome in ("impacts", "time"):
        found.append("no periodic motion found yet, and too few impacts to call it aperiodic: simulate for longer")
    if motion.outcome == "departed":
        found.append("the bar has left the wall for good: the load does not push it back")
    return found
