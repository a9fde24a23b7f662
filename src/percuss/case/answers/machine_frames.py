"""A machine that switches itself as pictures in time: where its bar is over a cycle, and what acts on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number, plain
from percuss.case.answers.machine_answer import machine_answer
from percuss.case.answers.machine_course import course_of
from percuss.case.answers.machine_in_words import headline
from percuss.case.answers.machine_json import cycle_dict, machine_dict
from percuss.case.answers.motion_frames import Frames

if TYPE_CHECKING:
    from percuss.case.answers.machine_course import Course
    from percuss.case.case import Case
    from percuss.model import Machine
    from percuss.model.checks import Array

__all__ = ["course_arrays", "machine_frames", "of_machine"]


def machine_frames(case: Case, *, modes: int | None = None, points: int = 401, whole: bool = True) -> Frames:
    """The cycle of a machine that switches itself, in SI or in the units of the machine, with its answer.

    Parameters
    ----------
    modes
        Elastic modes; 32 by default, 0 for a rigid piston.
    points
        Instants of the cycle; at every change of the state there are two more.
    whole
        Also what takes longer than the cycle: margins, sensitivities, the curve over the pressure, whether it starts
        from rest.

    Raises
    ------
    CaseError
        When the load of the case is another.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> found = machine_frames(load_case("valve-drifter"), modes=0, points=50, whole=False)
    >>> found.arrays["centre"].shape, found.header["states"]
    ((54,), ['return', 'power'])
    """
    answer = machine_answer(case, modes)
    machine = answer.machine
    told = machine_dict(answer) if whole else cycle_dict(answer)
    header = {
        "title": answer.title,
        "modes": answer.motion.modes,
        "whole": whole,
        "runs": answer.runs,
        "sentence": headline(answer) if whole or not answer.runs else None,
        "answer": told,
        **of_machine(machine),
    }
    if answer.cycle is None:
        return Frames(plain(header), {})
    course = course_of(machine, answer.cycle, points)
    return Frames(plain(header), course_arrays(machine, course, np.asarray(answer.cycle.blow_times)[:-1]))


def of_machine(machine: Machine) -> dict[str, Any]:
    """What a picture needs of the machine itself."""
    pairs = machine.valve.pairs
    return {
        "units": "SI" if machine.is_si else "dimensionless",
        "scales": _scales(machine),
        "states": [name for name, _ in pairs],
        "forces": [number(_in(machine, "force", machine.valve.force(name))) for name, _ in pairs],
        "stiffness": number(machine.valve.chamber.stiffness * _stiffness(machine)),
        "pressure_Pa": number(machine.pressure),
    }


def course_arrays(machine: Machine, course: Course, blows: Array) -> dict[str, Any]:
    """A course over time; the velocity is the mean one between two instants, in the middle between them."""
    names = {name: i for i, (name, _) in enumerate(machine.valve.pairs)}
    length, time = _in(machine, "length", 1.0), _in(machine, "time", 1.0)
    steps = np.diff(course.times)
    struck = np.searchsorted(blows, course.times[:-1], side="right") != np.searchsorted(blows, course.times[1:])
    goes = (steps > 1e-9 * course.times[-1]) & ~struck
    return {
        "t": course.times * time,
        "striking_end": course.striking_end * length,
        "centre": course.centre * length,
        "force": course.force * _in(machine, "force", 1.0),
        "state": np.array([names[state] for state in course.states], dtype=np.int16),
        "velocity_t": 0.5 * (course.times[1:] + course.times[:-1])[goes] * time,
        "velocity": np.diff(course.centre)[goes] / steps[goes] * length / time,
    }


def _in(machine: Machine, kind: str, value: float) -> float:
    """A value in SI where the machine has scales: a "length", "time" or "force"."""
    return value * float(getattr(machine, f"{kind}_scale")) if machine.is_si else value


def _stiffness(machine: Machine) -> float:
    return machine.force_scale / machine.length_scale if machine.is_si else 1.0


def _scales(machine: Machine) -> dict[str, float] | None:
    """What a unit of the answer is in SI."""
    if not machine.is_si:
        return None
    units = {"length": "m", "time": "s", "speed": "m_s", "force": "N", "energy": "J"}
    return {f"{kind}_{unit}": float(getattr(machine, f"{kind}_scale")) for kind, unit in units.items()}
