"""The picture of a machine that switches its own valve: its cycle, the force, the work, and what pressure changes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from percuss.model.checks import having
from percuss.plot.canvas import (
    COLOURS,
    INK,
    Units,
    canvas,
    draw_measured,
    legend_above,
    measured_panels,
    nothing,
    units_of,
    wall,
)
from percuss.plot.trajectory_picture import Window, draw_portrait, draw_speeds, titled_motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.machine_answer import MachineAnswer
    from percuss.case.answers.machine_figures import CycleCurve
    from percuss.case.answers.recorded_answer import RecordedAnswer
    from percuss.case.answers.simulation_answer import SimulationAnswer
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import Trajectory
    from percuss.steady.recorded.force_record import MeasuredForce

_NEAR = 0.06  # of the stroke: the name of a port so near to the wall stands below its line
_MARKS = {
    "release": ("D", COLOURS[2], "release", 4.0),
    "rest": ("v", COLOURS[4], "rest", 6.0),
    "valve": ("s", COLOURS[0], "valve switches", 5.0),
    "port": ("^", COLOURS[3], "port uncovered", 5.0),
    "impact": ("o", COLOURS[1], "blow", 5.0),
}


def _draw_positions(
    axes: Any,
    machine: Machine,
    units: Units,
    times: Array,
    centre: Array,
    marks: dict[str, tuple[Array, Array]],
    tool: object = None,
) -> None:
    """The piston over time, with the wall or the tool, the ports, and what happens: by its kind, times and places."""
    low = float(centre.min()) * units.length
    wall(axes, tool)
    axes.plot(times * units.time, centre * units.length, color=INK)
    look: dict[str, Any] = {"color": COLOURS[3], "fontsize": 7.5, "ha": "right", "textcoords": "offset points"}
    look["bbox"] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
    for i, port in enumerate(machine.valve.ports):
        if port.behind is not None:
            edge = -port.behind * units.length
            below = edge > _NEAR * float(centre.min()) * units.length
            low = min(low, edge)
            axes.axhline(edge, color=COLOURS[3], linewidth=0.9, linestyle=(0, (5, 3)))
            place = {"xy": (1.0, edge), "xycoords": ("axes fraction", "data"), "xytext": (-3, -10 if below else 3)}
            axes.annotate(f"ports[{i}]: {port.to}", **place, **look)
    for kind, (marker, colour, name, size) in _MARKS.items():  # blows on top
        at, heights = marks.get(kind, (np.zeros(0), np.zeros(0)))
        if at.size:
            key = {"color": colour, "markersize": size, "linestyle": "none", "zorder": 3, "clip_on": False}
            axes.plot(at * units.time, heights * units.length, marker, label=name, **key)
    axes.set_ylim(1.12 * low if low < 0.0 else -1.0, -0.12 * low if low < 0.0 else 0.12)
    legend_above(axes, columns=6)


def _draw_force(axes: Any, machine: Machine, units: Units, mark: str, times: Array, force: Array) -> None:
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.plot(times * units.time, force * units.force, color=COLOURS[0])
    gas = machine.valve.chamber
    with_gas = ", with the gas" if gas.force or gas.stiffness else ""
    title = f"{mark} the force on the piston, positive toward the blow{with_gas}"
    axes.set(title=title, xlabel=units.time_label, ylabel=units.force_label)


def _shade(axes: Any, times: Array, pushes: Any, step: Any = None) -> None:
    look: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.15, "linewidth": 0.0, "label": "valve pushes"}
    axes.fill_between(times, 0.0, 1.0, where=pushes, transform=axes.get_xaxis_transform(), step=step, **look)


# ---- The cycle of a machine


def machine(answer: MachineAnswer | RecordedAnswer) -> Figure:
    """Draw the answer for a machine that switches its own valve, or for a record that was read as one.

    Four panels: (a) the piston over a cycle, with the ports, their uncoverings, the switches and the blows; (b) the
    force on it, and the pressure of a supply that follows it, or the recorded force, cycle for cycle, with what the
    machine leaves of it; (c) the force over the place, whose loop is the work of a cycle; (d) energy and rate over the
    pressure, or over the flow of the pump.

    Examples
    --------
    >>> from percuss.case import load_case, machine_answer
    >>> from percuss.plot import machine
    >>> len(machine(machine_answer(load_case("valve-drifter"), modes=0)).axes)
    5
    """
    measured: MeasuredForce | None = getattr(answer, "measured", None)
    answer = cast("MachineAnswer", getattr(answer, "answer", answer))
    having("answer", answer, ("title", "motion", "curve"), "an answer, such as percuss.case.machine_answer gives")
    with canvas(11.0, 7.0, f"{answer.title} — {answer.outcome}{' ' + answer.label if answer.label else ''}") as figure:
        if answer.cycle is None:
            axes, obstacle = figure.add_subplot(), answer.motion.obstacle
            text = "" if obstacle is None else f"{obstacle.value}\n{obstacle.words}\n{obstacle.remedy}"
            nothing(axes, text)
            axes.texts[0].set(fontsize=11, wrap=True)
            axes.set_axis_off()
        else:
            _panels(figure, answer, measured)
    return figure


def _panels(figure: Figure, answer: MachineAnswer, measured: MeasuredForce | None) -> None:
    course, cycle, machine = answer.course, answer.cycle, answer.machine
    assert cycle is not None
    units = units_of(machine, float(np.abs(course.force).max()))
    units = replace(units, time_label=f"time after the blow{' [ms]' if machine.is_si else ''}")
    grid = figure.add_gridspec(2, 3)
    position, (force, left) = figure.add_subplot(grid[0, :2]), measured_panels(figure, grid[1, :2], measured)
    pushes = np.array([machine.valve.force(state) > 0.0 for state in course.states])
    for axes in (position, force):
        _shade(axes, course.times * units.time, pushes)
        axes.set_xlim(0.0, cycle.period * units.time)
    marks = {"impact": (cycle.blow_times, 0.0 * cycle.blow_times)}
    for kind, happened in (("port", cycle.uncoverings), ("valve", cycle.switches)):
        times = np.array([one.time for one in happened])
        marks[kind] = (times, cycle.position(times, "centre") if times.size else times)
    _draw_positions(position, machine, units, course.times, course.centre, marks, answer.tool)
    position.set(title="(a) the piston", xlabel=units.time_label, ylabel=units.length_label)
    _draw_force(force, machine, units, "(b)", course.times, course.force)
    if measured is not None and left is not None:
        draw_measured(force, left, measured, cycle.period * units.time, units)
    if course.pressure is not None:
        unit = machine.pressure
        other = _second_axis(force, "pressure" if unit is None else "pressure [bar]", COLOURS[1])
        pressure = course.pressure * (1.0 if unit is None else unit / 1e5)
        other.plot(course.times * units.time, pressure, color=COLOURS[1])
        other.set_ylim(bottom=0.0)
    _loop(figure.add_subplot(grid[0, 2]), answer, course, units)
    _pressures(figure.add_subplot(grid[1, 2]), answer)


def _second_axis(axes: Any, label: str, colour: str) -> Any:
    """An axis of its own on the right."""
    other = axes.twinx()
    other.spines["right"].set_visible(True)
    other.set_ylabel(label, color=colour)
    other.tick_params(axis="y", colors=colour)
    return other


def _loop(axes: Any, answer: MachineAnswer, course: CycleCurve, units: Units) -> None:
    cycle, machine = answer.cycle, answer.machine
    assert cycle is not None
    x, force = course.centre * units.length, course.force * units.force
    axes.fill(x, force, color=COLOURS[5], alpha=0.2, linewidth=0.0)
    axes.plot(x, force, color=COLOURS[0])
    axes.axvline(0.0, color=INK, linewidth=2.5)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    work = f"{cycle.work * machine.energy_scale:.4g} J" if machine.is_si else f"{cycle.work:.4g}"
    axes.set(title=f"(c) the loop: {work} a cycle", xlabel=units.length_label, ylabel=units.force_label)


# -- the pressure -----------------------------------------------------------------------------------------------------


def _pressures(axes: Any, answer: MachineAnswer) -> None:
    machine, cycle = answer.machine, answer.cycle
    assert cycle is not None
    over, bar, label = _varied(machine)
    axes.set_title(f"(d) energy and rate over the {over}")
    running = [one for one in answer.curve if one.energy is not None and one.rate is not None]
    if not running:
        nothing(axes, "does not run")
        return
    at = bar * np.array([one.pressure for one in running])
    energy = np.array([1.0 + (one.energy or 0.0) for one in running])
    rate = np.array([1.0 + (one.rate or 0.0) for one in running])
    if machine.is_si:
        energy, rate = energy * cycle.main_energy * machine.energy_scale, rate * 60.0 * cycle.blows / cycle.period
    axes.set_ylabel("blow energy [J]" if machine.is_si else "blow energy, relative", color=COLOURS[1])
    axes.tick_params(axis="y", colors=COLOURS[1])
    other = _second_axis(axes, "blows/min" if machine.is_si else "rate, relative", COLOURS[0])
    for one, values, marker, colour in ((axes, energy, "o", COLOURS[1]), (other, rate, "^", COLOURS[0])):
        one.plot(at, values, marker=marker, markersize=3, color=colour)
        one.set_ylim(bottom=0.0, top=1.08 * float(values.max()))
    axes.axvline(bar, color=INK, linewidth=0.7, linestyle=(0, (5, 3)))
    stopped = [bar * one.pressure for one in answer.curve if one.energy is None]
    for group in ([value for value in stopped if value < at.min()], [value for value in stopped if value > at.max()]):
        if group:
            middle = 0.5 * (group[0] + group[-1])
            axes.text(middle, 0.03 * axes.get_ylim()[1], "does not run", rotation=90, ha="center", color=INK)
    lowest, highest = answer.curve[0].pressure * bar, answer.curve[-1].pressure * bar
    axes.set_xlim(lowest, highest)
    axes.set_xlabel(label)


def _varied(machine: Machine) -> tuple[str, float, str]:
    """What the curve goes over: its name, its value in the case, and how the axis is called."""
    supply, unit = machine.valve.supply, machine.pressure
    if supply is not None:
        flow = supply.flow if unit is None else 6e4 * supply.flow * machine.power_scale / unit
        return "flow", flow, "flow of the pump" if unit is None else "flow of the pump [l/min]"
    if unit is None:
        return "pressure", 1.0, "forces of the valve, relative"
    return "pressure", unit / 1e5, "pressure of the supply [bar]"


# ---- The picture of a simulated motion of a machine that switches its own valve: piston, force, blows, phase portrait

CYCLES = 4  # cycles of a periodic motion that are shown; of others as many times the changes that two cycles would have

MOST_EVENTS = 120  # events shown of a motion that is not periodic


def _window(motion: Trajectory) -> tuple[float, float, str]:
    """The part that is shown: the last cycles, or the last events."""
    begin, end, times = motion.begin_time, motion.end_time, motion.events.time
    if motion.cycle is not None and len(times):
        first = float(times[-1]) - CYCLES * motion.cycle.period
        return max(first, begin), float(times[-1]), "the last cycles" if first > begin else "the whole motion"
    if len(times) <= MOST_EVENTS:
        return begin, end, "the whole motion"
    return float(times[-MOST_EVENTS]), end, "the last flights"


def machine_motion(motion: Trajectory | SimulationAnswer) -> Figure:
    """Draw a simulated motion of a machine, or the answer that holds one.

    Four panels: (a) the centre of the piston over the last cycles, with ports, blows and switches; (b) striking speeds
    over the whole motion; (c) the force on the piston, with the ground dark where the valve, or the oil
    that flows, pushes toward the wall; (d) the phase portrait of the striking end.

    Examples
    --------
    >>> from percuss.case import load_case, simulation_answer
    >>> from percuss.plot import machine_motion as picture
    >>> case = load_case("valve-drifter").changed(simulation={"modes": 0})
    >>> len(picture(simulation_answer(case)).axes)
    4
    """
    title, moved = titled_motion(motion, clocked=False)
    with canvas(11.0, 7.0, f"{title} — {moved.label}" if title else moved.label) as figure:
        grid = figure.add_gridspec(2, 3)
        shown = Window(moved, *_window(moved))
        times, machine = shown.times, moved.machine
        centre, force = moved.centre(times), moved.force(times)
        units = units_of(machine, float(np.abs(force).max()))
        upper, lower = figure.add_subplot(grid[0, :2]), figure.add_subplot(grid[1, :2])
        pushes = (force if machine.valve.flows else moved.mechanism.forces[moved.state(times)]) > 0.0
        marks = {}
        for kind in _MARKS:
            at = shown.events.of(kind).time
            marks[kind] = (at, 0.0 * at if kind == "impact" else np.interp(at, times, centre))
        room = 0.005 * (shown.last - shown.first) or 0.5
        for axes in (upper, lower):
            _shade(axes, times * units.time, pushes, "post")
            axes.set_xlim((shown.first - room) * units.time, (shown.last + room) * units.time)
            axes.ticklabel_format(axis="x", useOffset=False)
        _draw_positions(upper, machine, units, times, centre, marks)
        upper.set(title=f"(a) the piston: {shown.what}", xlabel=units.time_label, ylabel=units.length_label)
        _draw_force(lower, machine, units, "(c)", times, force)
        draw_speeds(figure.add_subplot(grid[0, 2]), moved, units.speed, units.time, units.time_label)
        draw_portrait(figure.add_subplot(grid[1, 2]), shown, units)
    return figure
