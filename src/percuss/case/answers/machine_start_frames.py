"""A machine that switches itself from a start, as pictures in time: its first blows, in the form of a cycle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, plain
from percuss.case.answers.machine_course import course_from_start
from percuss.case.answers.machine_frames import course_arrays, of_machine
from percuss.case.answers.machine_json import machine_numbers
from percuss.case.answers.machine_start_in_words import from_this_start
from percuss.case.answers.motion_frames import Frames
from percuss.case.answers.numerals import counted
from percuss.model.checks import count

if TYPE_CHECKING:
    from percuss.case.answers.machine_course import Course
    from percuss.case.answers.machine_motion import MachineMotion
    from percuss.simulate import MachineTrajectory
    from percuss.simulate.machine.machine_events import MachineEvent

__all__ = ["start_frames"]


def start_frames(found: MachineMotion, blows: int = 12, points: int = 2000) -> Frames:
    """The first blows of a simulated motion, with the header and the arrays of a cycle.

    Parameters
    ----------
    blows
        Shown at most.
    points
        Instants; at each blow and each change of the state there are more.

    Examples
    --------
    >>> from percuss.case import load_case, machine_motion
    >>> found = start_frames(machine_motion(load_case("valve-drifter").changed(simulation={"modes": 0})), blows=3)
    >>> found.header["label"], len(found.header["answer"]["blows"])
    ('runs 1/1', 3)
    """
    motion, machine = found.motion, found.machine
    count("blows", blows)
    course = course_from_start(motion, blows, count("points", points, least=2))
    length = float(course.times[-1])
    events = motion.events
    shown = [event for event in events if event.time - motion.begin_time <= length]
    header = {
        "title": found.title,
        "modes": motion.modes,
        "label": motion.label,
        "sentence": f"{from_this_start(found)} {_shown(motion, shown)}",
        "answer": _answer_from_start(found, course, shown),
        **of_machine(machine),
    }
    struck = events.of("impact").time - motion.begin_time
    return Frames(plain(header), course_arrays(machine, course, struck))


def _shown(motion: MachineTrajectory, shown: Sequence[MachineEvent]) -> str:
    words = counted(sum(event.kind == "impact" for event in shown), "blow")
    return f"Shown: all of it, {words}." if len(shown) == len(motion.events) else f"Shown: the first {words}."


def _answer_from_start(found: MachineMotion, course: Course, shown: Sequence[MachineEvent]) -> dict[str, Any]:
    """The part of the answer for a cycle that a picture reads, of a motion from its start."""
    motion, machine = found.motion, found.machine
    begin = motion.begin_time
    each = {kind: [event for event in shown if event.kind == kind] for kind in ("impact", "port", "valve")}
    return {
        "machine": machine_numbers(machine),
        "period": number(float(course.times[-1])),
        "stroke": number(max(-float(course.striking_end.min()), 0.0)),
        "first_state": machine.valve.pairs[motion.first_state][0],
        "blows": [
            {"time": number(e.time - begin), "speed": number(e.velocity), "energy": number(e.kinetic_energy)}
            for e in each["impact"]
        ],
        "ports": [{"port": e.port, "time": number(e.time - begin)} for e in each["port"]],
        "valve": [{"time": number(e.time - begin), "to": e.state} for e in each["valve"]],
        "si": None,
    }
