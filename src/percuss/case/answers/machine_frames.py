"""A machine that switches itself as pictures in time: where its bar is over a cycle, and what acts on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.machine_answer import cycle_dict, headline, machine_answer, machine_numbers
from percuss.case.answers.machine_figures import course_from_start, course_of
from percuss.case.answers.motion_frames import Frames
from percuss.case.answers.numerals import counted, plain, quantity
from percuss.case.answers.numerals import json_number as number
from percuss.case.answers.numerals import number as numerals_number
from percuss.model.checks import count

if TYPE_CHECKING:
    from percuss.case.answers.machine_figures import Course
    from percuss.case.answers.simulation_answer import MachineMotion
    from percuss.case.case import Case
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import MachineTrajectory
    from percuss.simulate.machine.machine_events import MachineEvent


def machine_frames(case: Case, *, modes: int | None = None, points: int = 401, whole: bool = True) -> Frames:
    """The cycle of a machine that switches itself, in SI or in the units of the machine, with its answer.

    At every change of the state there are two more `points`. `whole`: also margins, sensitivities, the curve over the
    pressure and whether it starts from rest, which take longer than the cycle.
    """
    answer = machine_answer(case, modes)
    machine = answer.machine
    told = answer.to_json_dict() if whole else cycle_dict(answer)
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


# ---- The first sentence of the answer for a machine that switches itself from a start: one home for terminal and page


def from_this_start(answer: MachineMotion) -> str:
    """How the motion ends, in one sentence."""
    motion, machine, cycle = answer.motion, answer.machine, answer.motion.cycle
    text = f"From this start the machine {_in_words(motion.label)}"
    if cycle is None or not motion.impacts:
        return f"{text}."
    if not machine.is_si:
        return f"{text}: strongest blow {numerals_number(cycle.blow_speed)}, period {numerals_number(cycle.period)}."
    rate = cycle.blows / (cycle.period * machine.time_scale)
    energy = float(motion.blow_energies[-max(cycle.blows, 1) :].max()) * machine.energy_scale
    return (
        f"{text}: {quantity(energy, 'J')} at {numerals_number(rate)} Hz ({numerals_number(60.0 * rate)} blows/min), "
        f"{numerals_number(cycle.blow_speed * machine.speed_scale)} m/s, after {counted(cycle.first, 'impact')}."
    )


def _in_words(label: str) -> str:
    """The label behind "the machine"."""
    if label.startswith(("runs", "stalls", "cycles")):
        return label
    return {"undecided": "has not settled yet", "irregular": "strikes irregularly"}.get(label, f"ends as '{label}'")


# ---- A machine that switches itself from a start, as pictures in time: its first blows, in the form of a cycle


def start_frames(found: MachineMotion, blows: int = 12, points: int = 2000) -> Frames:
    """The first blows of a simulated motion, at most so many, with the header and the arrays of a cycle."""
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
