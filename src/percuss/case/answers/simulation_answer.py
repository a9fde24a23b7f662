"""The dispatcher's answer to "how does this hammer move from this start?"."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from percuss.case.answers.numerals import counted, heading_dict, numbers, picked, plain
from percuss.case.answers.numerals import json_number as number
from percuss.case.answers.orbits_answer import orbit_dict
from percuss.case.case import checked_case
from percuss.errors import ParameterError
from percuss.model.checks import Array, callback, count, positive
from percuss.shown import Shown
from percuss.simulate import Stop, Trajectory
from percuss.stability import orbit_multipliers
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Machine, System
    from percuss.recordings.history import HistoryReport
    from percuss.simulate import MachineTrajectory, Progress, Summary
    from percuss.steady import PeriodicOrbit


# ---- That the load held a bar on the wall before the time of a contact was over, in words and as JSON

_COARSE = 0.01


def held_down_in_words(shares: Array) -> tuple[tuple[str, str], ...]:
    """A row of a report, from what each such rest gave up of the greatest blow; none where there was none."""
    if not shares.size:
        return ()
    most = float(shares.max())
    text = (
        f"at {counted(int(shares.size), 'rest')} the load turned the rebound within the time of one contact, and held "
        f"the bar on the wall; that gave up {100.0 * most:.2g} % of the energy of the greatest blow, at most"
    )
    return (("held down", text + (": for so soft a bar the law is coarse" if most > _COARSE else "")),)


def held_down_dict(shares: Array) -> dict[str, Any] | None:
    """How often, and the greatest share of the energy of the greatest blow that was given up so."""
    return {"rests": int(shares.size), "greatest_share": number(shares.max())} if shares.size else None


# ---- A simulated motion in plain values with the names that other programs read; every number finite or null


def motion_dict(motion: Trajectory, warnings: Sequence[str], last: int | None = None) -> dict[str, Any]:
    """The JSON object of a motion, with so many last events, or all."""
    return {
        **picked(motion, "outcome label modes begin_time end_time transient period_unresolved"),
        "held_down": held_down_dict(motion.events.held_down),
        "warnings": list(warnings),
        "events": _events(motion, last),
        "summary": plain(asdict(motion.summary)),
    }


def _events(motion: Trajectory, last: int | None) -> list[dict[str, Any]]:
    events, system = motion.events, motion.system
    part = events if last is None else events[max(len(events) - last, 0) :]
    seconds = system.time_scale if system.is_si else None
    names = "kind time phase impact_velocity rebound_velocity energy_lost resolved"
    return [
        {**picked(event, names), "time_s": None if seconds is None else number(event.time * seconds)} for event in part
    ]


# ---- A motion that is told event by event, or impact by impact, as JSON


class ToldMotion(Shown, ABC):
    """A motion that is told event by event, or impact by impact."""

    ROWS: ClassVar[str] = "events"
    """The key of the list."""

    @abstractmethod
    def _told(self, last: int | None) -> dict[str, Any]:
        """The JSON object, with so many last rows or all of them."""

    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values, as `percuss simulate --json` prints it.

        Parameters
        ----------
        last
            The number of last events to keep, by waves of impacts; all by default.

        Raises
        ------
        ParameterError
            When `last` is no such number.
        """
        return self._told(None if last is None else count("last", last, least=0))

    def to_json_text(self, last: int | None = None) -> str:
        """The same as text, one line for each event or impact."""
        tree = self.to_json_dict(last)
        rows = [json.dumps(row, allow_nan=False) for row in tree[self.ROWS]]
        text = json.dumps({**tree, self.ROWS: []}, indent=1, allow_nan=False)
        if not rows:
            return text
        key = f'\n "{self.ROWS}": ['  # keys of objects within stand further in, and no text has a line break
        return text.replace(key + "]", key + "\n  " + ",\n  ".join(rows) + "\n ]")


# ---- The dispatcher's answer to "how does this machine move from this start?", its valve being switched by the piston


@dataclass(frozen=True)
class MachineMotion(ToldMotion):
    """A simulated motion of a machine that switches its own valve.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    motion
        The motion.
    notes
        What was assumed, one sentence each.
    """

    name: str
    title: str
    motion: MachineTrajectory
    notes: tuple[str, ...] = ()

    @property
    def machine(self) -> Machine:
        """The machine that moved."""
        return self.motion.machine

    def _told(self, last: int | None) -> dict[str, Any]:
        motion, cycle = self.motion, self.motion.cycle
        return {
            "case": self.name,
            "title": self.title,
            "notes": list(self.notes),
            **picked(motion, "outcome label modes begin_time end_time"),
            "cycle": None if cycle is None else plain(asdict(cycle)),
            "pressure": _pressure(motion),
            "held_down": held_down_dict(motion.events.held_down),
            "events": _machine_events(motion, last),
        }


def machine_motion(case: Case, progress: Callable[[Progress], object] | None = None) -> MachineMotion:
    """The motion of a machine that the tables [start] and [simulation] of a case describe.

    Parameters
    ----------
    progress
        Called now and then; the motion ends as ``cancelled`` when it returns something true.

    Raises
    ------
    CaseError
        When the load of the case is another, or the start does not fit it.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> case = load_case("valve-drifter").changed(simulation={"modes": 0})
    >>> machine_motion(case).motion.label
    'runs 1/1'
    """
    from percuss.simulate import run_machine  # loads the compiler

    checked_case(case)
    callback("progress", progress)
    machine, simulation = case.machine(), case.simulation()
    start = case.start(simulation.modes)
    motion = run_machine(machine, start, modes=simulation.modes, stop=simulation.stop, progress=progress)
    return MachineMotion(case.file, case.title, motion, case.notes)


def _pressure(motion: MachineTrajectory) -> dict[str, Any] | None:
    """Of a supply, in Pa, or as a multiple of that of the states where it is not known."""
    from percuss.simulate.machine.fed_running import FedTrajectory

    if not isinstance(motion, FedTrajectory):
        return None
    unit = motion.machine.pressure or 1.0
    return {
        "at_start": number(float(motion.states[0, 2]) * unit),
        "after_blows": numbers(motion.pressure(motion.blow_times) * unit),
        "at_end": number(float(motion.pressure(motion.end_time)[0]) * unit),
    }


def _machine_events(motion: MachineTrajectory, last: int | None) -> list[dict[str, Any]]:
    events, machine = motion.events, motion.machine
    first = 0 if last is None else max(len(events) - last, 0)
    seconds = machine.time_scale if machine.is_si else None
    return [
        {
            **picked(event, "kind time rebound_velocity energy_lost kinetic_energy port resolved"),
            "time_s": None if seconds is None else number(event.time * seconds),
            "speed": number(event.velocity),
            "to": event.state,
        }
        for event in list(events)[first:]
    ]


# ---- The dispatcher's answer to "how does this hammer move from this start?"


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
