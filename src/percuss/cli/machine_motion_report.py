"""A simulated motion of a machine that switches its own valve, as the report that a person reads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.machine_start_in_words import from_this_start
from percuss.case.answers.machine_units import in_units
from percuss.case.answers.numerals import counted, number
from percuss.cli.machine_report import machine_section
from percuss.cli.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.simulate.machine.fed_trajectory import FedTrajectory

if TYPE_CHECKING:
    from percuss.case.answers.machine_motion import MachineMotion

__all__ = ["machine_motion_report"]


def machine_motion_report(answer: MachineMotion, last: int | None) -> Report:
    """The report of `percuss simulate` for a machine, with the `last` events; None shows all of them."""
    motion, machine = answer.motion, answer.machine
    sections: list[Section | Grid] = [machine_section(answer.name, machine, answer.notes, math.inf)]
    rows = [
        ("ended", f"{motion.outcome}, after {counted(motion.impacts, 'impact')} and {_time(answer, motion.end_time)}"),
        ("modes", counted(motion.modes, "elastic mode") if motion.modes else "rigid piston"),
    ]
    if isinstance(motion, FedTrajectory):
        rows.append(("pressure", _pressures(motion)))
    if motion.cycle is not None:
        rows.append(("period", in_units(machine, motion.cycle.period, "time")))
    sections.append(Section("Motion", tuple(rows)))
    if last != 0 and len(motion.events):
        sections.append(_events_grid(answer, last))
    tone = GOOD if motion.label.startswith("runs") else PLAIN if motion.label == "undecided" else BAD
    return Report(answer.title, from_this_start(answer), tone, tuple(sections))


def _pressures(motion: FedTrajectory) -> str:
    """The pressure of a supply at the start, and after the last blow."""
    unit = motion.machine.pressure
    last = motion.blow_times[-1:] if motion.impacts else motion.end_time
    values = [float(motion.states[0, 2]), float(motion.pressure(last)[0])]
    first, then = (number(value) if unit is None else f"{number(value * unit / 1e5)} bar" for value in values)
    return f"{first} at the start, {then} {'at the last blow' if motion.impacts else 'at the end'}"


def _time(answer: MachineMotion, time: float) -> str:
    return in_units(answer.machine, time, "time")


def _events_grid(answer: MachineMotion, last: int | None) -> Grid:
    """The last events, one a line."""
    events, machine = list(answer.motion.events), answer.machine
    shown = events if last is None else events[max(len(events) - last, 0) :]
    rows = []
    for event in shown:
        what = event.kind
        if event.kind == "port":
            what = f"ports[{event.port}] demands"
        if event.kind == "valve":
            what = f"valve: {event.state}"
        speed = in_units(machine, event.velocity, "speed")
        rows.append((what, _time(answer, event.time), speed))
    heading = "Events" if len(shown) == len(events) else f"The last {len(shown)} of {len(events)} events"
    return Grid(heading, ("event", "time", "speed toward the wall"), tuple(rows))
