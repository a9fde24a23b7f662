"""The dispatcher's answer to "how does this machine move from this start?", its valve being switched by the piston."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, numbers, plain
from percuss.case.answers.told_motion import ToldMotion
from percuss.case.case import checked_case
from percuss.model.checks import callback

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import Machine
    from percuss.simulate import MachineTrajectory, Progress

__all__ = ["MachineMotion", "machine_motion"]


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
            "outcome": motion.outcome,
            "label": motion.label,
            "modes": int(motion.modes),
            "begin_time": number(motion.begin_time),
            "end_time": number(motion.end_time),
            "cycle": None if cycle is None else plain(asdict(cycle)),
            "pressure": _pressure(motion),
            "events": _events(motion, last),
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
    from percuss.simulate.machine.fed_trajectory import FedTrajectory

    if not isinstance(motion, FedTrajectory):
        return None
    unit = motion.machine.pressure or 1.0
    return {
        "at_start": number(float(motion.states[0, 2]) * unit),
        "after_blows": numbers(motion.pressure(motion.blow_times) * unit),
        "at_end": number(float(motion.pressure(motion.end_time)[0]) * unit),
    }


def _events(motion: MachineTrajectory, last: int | None) -> list[dict[str, Any]]:
    events, machine = motion.events, motion.machine
    first = 0 if last is None else max(len(events) - last, 0)
    seconds = machine.time_scale if machine.is_si else None
    return [
        {
            "kind": event.kind,
            "time": number(event.time),
            "time_s": None if seconds is None else number(event.time * seconds),
            "speed": number(event.velocity),
            "rebound_velocity": number(event.rebound_velocity),
            "energy_lost": number(event.energy_lost),
            "kinetic_energy": number(event.kinetic_energy),
            "port": event.port,
            "to": event.state,
            "resolved": int(event.resolved),
        }
        for event in list(events)[first:]
    ]
