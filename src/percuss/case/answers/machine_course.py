"""The course of a cycle of a machine that switches itself: where the bar is, and what acts on it, at any times."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from percuss.steady.self_excited import RigidCycle, pressure_over

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import MachineTrajectory
    from percuss.steady.self_excited import ValveCycle

__all__ = ["Course", "course_from_start", "course_of", "cycle_table"]


@dataclass(frozen=True)
class Course:
    """A cycle over time, in the units of the machine.

    Attributes
    ----------
    times
        Increasing, from 0 to the period; each change of the state stands there twice.
    striking_end, centre
        Displacement, 0 at the wall and negative behind it.
    force
        On the bar, with that of the chamber, positive toward the wall.
    states
        The state of the valve at each time.
    pressure
        Of a supply that follows the piston, as a multiple of the one for which the forces of the states hold; None
        where it is constant.
    """

    times: Array
    striking_end: Array
    centre: Array
    force: Array
    states: tuple[str, ...]
    pressure: Array | None = None


def course_of(machine: Machine, cycle: ValveCycle, points: int = 800) -> Course:
    """The course of a cycle at so many times and at every change of the state."""
    changes = [switch.time for switch in cycle.switches]
    times = np.sort(np.concatenate([np.linspace(0.0, cycle.period, points), changes, changes]))
    states, at = [], cycle.switches[-1].to if cycle.switches else str(machine.valve.start)
    waiting = list(cycle.switches)
    passed = 0
    for time in times.tolist():
        while waiting and (time > waiting[0].time or (time == waiting[0].time and passed)):
            at, passed = waiting.pop(0).to, 0
        passed += bool(waiting) and time == waiting[0].time
        states.append(at)
    valve = machine.valve
    pressure = pressure_over(cycle, times) if valve.supply is not None and isinstance(cycle, RigidCycle) else None
    oil = np.array([dict(valve.pairs)[state] for state in states]) * (1.0 if pressure is None else pressure)
    force = oil + valve.chamber.force - valve.chamber.stiffness * cycle.position(times, 0.0)
    end, centre = cycle.position(times, 1.0) + 0.0, cycle.position(times, "centre") + 0.0
    return Course(times, end, centre, force, tuple(states), pressure)


def course_from_start(motion: MachineTrajectory, blows: int, points: int = 800) -> Course:
    """The course of a simulated motion up to so many blows, or to its end; changes of the state stand there twice."""
    struck = motion.blow_times
    end = float(struck[blows - 1]) if 0 < blows <= struck.size else motion.end_time
    changes = motion.events.of("valve").time
    changes = changes[changes <= end]
    even = np.linspace(motion.begin_time, end, points)
    before = np.maximum(np.nextafter(changes, -np.inf), motion.begin_time)
    times = np.sort(np.concatenate([even, before, changes, struck[struck <= end]]))
    names = [name for name, _ in motion.machine.valve.pairs]
    states = tuple(names[number] for number in motion.state(times).tolist())
    begun = times - motion.begin_time
    return Course(begun, motion.gap(times) + 0.0, motion.centre(times) + 0.0, motion.force(times), states)


def cycle_table(machine: Machine, cycle: ValveCycle) -> str:
    """The course as a table in CSV: in SI where the machine has scales."""
    course, names = course_of(machine, cycle), ("times", "striking_end", "centre", "force")
    units, scales = ("",) * 4, (1.0,) * 4
    if machine.is_si:
        units = ("_s", "_m", "_m", "_N")
        scales = (machine.time_scale, machine.length_scale, machine.length_scale, machine.force_scale)
    heads = [name.removesuffix("s") + unit for name, unit in zip(names, units, strict=True)]
    columns = [scale * getattr(course, name) for name, scale in zip(names, scales, strict=True)]
    if course.pressure is not None:
        heads.append("pressure_Pa" if machine.pressure is not None else "pressure")
        columns.append(course.pressure * (1.0 if machine.pressure is None else machine.pressure))
    rows = zip(*(column.tolist() for column in columns), course.states, strict=True)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*heads, "state"])
    writer.writerows(rows)
    return text.getvalue()
