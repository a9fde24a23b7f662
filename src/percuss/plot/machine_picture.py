"""The picture of a machine that switches its own valve: its cycle, the force, the work, and what pressure changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, legend_above, new_figure, style, titled
from percuss.plot.trajectory_picture import titled_motion, wall

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.machine_answer import MachineAnswer
    from percuss.case.answers.machine_figures import Course
    from percuss.case.answers.simulation_answer import SimulationAnswer
    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.simulate import Events, Trajectory

_NEAR = 0.06  # of the stroke: the name of a port so near to the wall stands below its line


class _Scales:
    """What a unit of the machine is on the axes, and what they are called."""

    def __init__(self, machine: Machine, greatest_force: float) -> None:
        si = machine.is_si
        kilo = si and greatest_force * machine.force_scale >= 500.0
        self.time = 1e3 * machine.time_scale if si else 1.0
        self.length = 1e3 * machine.length_scale if si else 1.0
        self.force = machine.force_scale * (1e-3 if kilo else 1.0) if si else 1.0
        self.time_label = "time after the blow [ms]" if si else "time after the blow"
        self.length_label = "position [mm]" if si else "position"
        self.force_label = ("force [kN]" if kilo else "force [N]") if si else "force"


def machine(answer: MachineAnswer) -> Figure:
    """Draw the answer for a machine that switches its own valve.

    Four panels: (a) the piston over a cycle, with the ports, their uncoverings, the switches and the blows; (b) the
    force on it, and the pressure of a supply that follows it; (c) the force over the place,
    whose loop is the work of a cycle; (d) energy and rate over the pressure,
    or over the flow of the pump.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.

    Examples
    --------
    >>> from percuss.case import load_case, machine_answer
    >>> from percuss.plot import machine
    >>> len(machine(machine_answer(load_case("valve-drifter"), modes=0)).axes)
    5
    """
    having("answer", answer, ("title", "motion", "curve"), "an answer, such as percuss.case.machine_answer gives")
    figure = new_figure(11.0, 7.0)
    with style():
        if answer.cycle is None:
            _nothing(figure.add_subplot(), answer)
        else:
            _panels(figure, answer)
        titled(figure, f"{answer.title} — {answer.outcome}{' ' + answer.label if answer.label else ''}")
    return figure


def _nothing(axes: Any, answer: MachineAnswer) -> None:
    obstacle = answer.motion.obstacle
    text = "" if obstacle is None else f"{obstacle.value}\n{obstacle.words}\n{obstacle.remedy}"
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=INK, fontsize=11, wrap=True)
    axes.set_axis_off()


def _panels(figure: Figure, answer: MachineAnswer) -> None:
    course = answer.course
    scales = _Scales(answer.machine, float(np.abs(course.force).max()))
    grid = figure.add_gridspec(2, 3)
    _position(figure.add_subplot(grid[0, :2]), answer, course, scales)
    _force(figure.add_subplot(grid[1, :2]), answer, course, scales)
    _loop(figure.add_subplot(grid[0, 2]), answer, course, scales)
    _pressures(figure.add_subplot(grid[1, 2]), answer)


# -- over the cycle ---------------------------------------------------------------------------------------------------


def _position(axes: Any, answer: MachineAnswer, course: Course, scales: _Scales) -> None:
    cycle, low = answer.cycle, float(course.centre.min()) * scales.length
    assert cycle is not None
    wall(axes)
    _shade(axes, course.times * scales.time, _pushes(answer, course))
    axes.plot(course.times * scales.time, course.centre * scales.length, color=INK)
    farthest = float(course.times[course.centre.argmin()]) * scales.time  # nothing else is near the ports there
    look: dict[str, Any] = {"color": COLOURS[3], "fontsize": 7.5, "ha": "center", "textcoords": "offset points"}
    for i, port in enumerate(answer.machine.valve.ports):
        if port.behind is not None:
            edge = -port.behind * scales.length
            low = min(low, edge)
            axes.axhline(edge, color=COLOURS[3], linewidth=0.9, linestyle=(0, (5, 3)))
            name = f"ports[{i}]: {port.to}"
            at_wall = edge > _NEAR * float(course.centre.min()) * scales.length
            axes.annotate(name, (farthest, edge), (0, -10 if at_wall else 3), **look)
    marks = {"linestyle": "none", "zorder": 3, "clip_on": False}
    for kind, marker, colour, times in (
        ("port uncovered", "^", COLOURS[3], [one.time for one in cycle.uncoverings]),
        ("valve switches", "s", COLOURS[0], [one.time for one in cycle.switches]),
    ):
        if times:
            at = cycle.position(np.array(times), "centre") * scales.length
            axes.plot(np.array(times) * scales.time, at, marker, color=colour, label=kind, markersize=5, **marks)
    blows = cycle.blow_times * scales.time
    axes.plot(blows, 0.0 * blows, "o", color=COLOURS[1], label="blow", markersize=5, **marks)
    axes.set_xlim(0.0, cycle.period * scales.time)
    axes.set_ylim(1.12 * low, -0.12 * low)
    axes.set_title("(a) the centre of the piston")
    axes.set_xlabel(scales.time_label)
    axes.set_ylabel(scales.length_label)
    legend_above(axes, columns=4)


def _pushes(answer: MachineAnswer, course: Course) -> Any:
    return np.array([answer.machine.valve.force(state) > 0.0 for state in course.states])


def _shade(axes: Any, times: Array, pushes: Any, step: Any = None) -> None:
    """A ground for the times at which the valve pushes toward the wall."""
    look: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.15, "linewidth": 0.0, "label": "valve pushes"}
    axes.fill_between(times, 0.0, 1.0, where=pushes, transform=axes.get_xaxis_transform(), step=step, **look)


def _force(axes: Any, answer: MachineAnswer, course: Course, scales: _Scales) -> None:
    cycle = answer.cycle
    assert cycle is not None
    axes.axhline(0.0, color=INK, linewidth=0.6)
    _shade(axes, course.times * scales.time, _pushes(answer, course))
    axes.plot(course.times * scales.time, course.force * scales.force, color=COLOURS[0])
    axes.set_xlim(0.0, cycle.period * scales.time)
    _named_force(axes, answer.machine, "(b)", scales.time_label, scales.force_label)
    if course.pressure is not None:
        unit = answer.machine.pressure
        pressure = course.pressure * (1.0 if unit is None else unit / 1e5)
        other = axes.twinx()
        other.spines["right"].set_visible(True)
        other.plot(course.times * scales.time, pressure, color=COLOURS[1])
        other.set_ylabel("pressure" if unit is None else "pressure [bar]", color=COLOURS[1])
        other.tick_params(axis="y", colors=COLOURS[1])
        other.set_ylim(bottom=0.0)


def _named_force(axes: Any, machine: Machine, mark: str, time: str, force: str) -> None:
    gas = machine.valve.chamber
    with_gas = ", with the gas" if gas.force or gas.stiffness else ""
    axes.set_title(f"{mark} the force on the piston, positive toward the wall{with_gas}")
    axes.set_xlabel(time)
    axes.set_ylabel(force)


def _loop(axes: Any, answer: MachineAnswer, course: Course, scales: _Scales) -> None:
    cycle, machine = answer.cycle, answer.machine
    assert cycle is not None
    x, force = course.centre * scales.length, course.force * scales.force
    axes.fill(x, force, color=COLOURS[5], alpha=0.2, linewidth=0.0)
    axes.plot(x, force, color=COLOURS[0])
    axes.axvline(0.0, color=INK, linewidth=2.5)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    work = f"{cycle.work * machine.energy_scale:.4g} J" if machine.is_si else f"{cycle.work:.4g}"
    axes.set_title(f"(c) the loop: {work} a cycle")
    axes.set_xlabel(scales.length_label)
    axes.set_ylabel(scales.force_label)


# -- the pressure -----------------------------------------------------------------------------------------------------


def _pressures(axes: Any, answer: MachineAnswer) -> None:
    machine, cycle = answer.machine, answer.cycle
    assert cycle is not None
    over, bar, label = _varied(machine)
    axes.set_title(f"(d) energy and rate over the {over}")
    running = [one for one in answer.curve if one.energy is not None and one.rate is not None]
    if not running:
        axes.text(0.5, 0.5, "does not run", transform=axes.transAxes, ha="center", va="center", color=INK)
        return
    at = bar * np.array([one.pressure for one in running])
    energy = np.array([1.0 + (one.energy or 0.0) for one in running])
    rate = np.array([1.0 + (one.rate or 0.0) for one in running])
    if machine.is_si:
        energy, rate = energy * cycle.blow_energy * machine.energy_scale, rate * 60.0 * cycle.blows / cycle.period
    other = axes.twinx()
    other.spines["right"].set_visible(True)
    _line(axes, at, energy, "o", COLOURS[1], "blow energy [J]" if machine.is_si else "blow energy, relative")
    _line(other, at, rate, "^", COLOURS[0], "blows/min" if machine.is_si else "rate, relative")
    axes.axvline(bar, color=INK, linewidth=0.7, linestyle=(0, (5, 3)))
    stopped = [bar * one.pressure for one in answer.curve if one.energy is None]
    for group in (
        [value for value in stopped if value < at.min()],
        [value for value in stopped if value > at.max()],
    ):
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


def _line(axes: Any, at: Array, values: Array, marker: str, colour: str, label: str) -> None:
    axes.plot(at, values, marker=marker, markersize=3, color=colour)
    axes.set_ylabel(label, color=colour)
    axes.tick_params(axis="y", colors=colour)
    axes.set_ylim(bottom=0.0, top=1.08 * float(values.max()))


# ---- The picture of a simulated motion of a machine that switches its own valve: piston, force, blows, phase portrait

CYCLES = 4
"""Cycles of a periodic motion that are shown; of others as many times the changes that two cycles would have."""

MOST_EVENTS = 120
"""Events shown of a motion that is not periodic."""

_POINTS = 2400
_MARKS = {
    "impact": ("o", COLOURS[1], "blow", 5.0),
    "port": ("^", COLOURS[3], "port uncovered", 5.0),
    "valve": ("s", COLOURS[0], "valve switches", 5.0),
    "rest": ("v", COLOURS[4], "rest", 6.0),
    "release": ("D", COLOURS[2], "release", 4.0),
}


class _Shown:
    """The last part of a motion, sampled, with the factors of its axes."""

    def __init__(self, motion: Trajectory) -> None:
        self.motion = motion
        si, machine = motion.machine.is_si, motion.machine
        self.first, self.last, self.what = _window(motion)
        inside = (motion.events.time >= self.first) & (motion.events.time <= self.last)
        self.events: Events = motion.events[inside]
        edges = np.unique(np.clip(self.events.time, self.first, self.last))
        self.times = np.unique(np.concatenate([np.linspace(self.first, self.last, _POINTS), edges]))
        self.centre, self.force = motion.centre(self.times), motion.force(self.times)
        sides = [(edges, motion.bar_velocity(1.0, edges, "left")[0])]
        sides.append((self.times, motion.bar_velocity(1.0, self.times)[0]))
        joined = np.concatenate([times for times, _ in sides])
        order = np.argsort(joined, kind="stable")  # the side before an event comes first
        self.velocity = np.concatenate([values for _, values in sides])[order]
        self.gap = np.interp(joined[order], self.times, motion.gap(self.times))
        self.clock = 1e3 * machine.time_scale if si else 1.0
        self.length = 1e3 * machine.length_scale if si else 1.0
        self.speed = machine.speed_scale if si else 1.0
        self.newtons = 1e-3 * machine.force_scale if si else 1.0
        self.labels = ("time [ms]", "position [mm]", "force [kN]", "m/s") if si else ("time", "position", "force", "")


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
    over the whole motion; (c) the force on the piston, with the ground dark where the valve pushes toward the wall; (d)
    the phase portrait of the striking end.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.

    Examples
    --------
    >>> from percuss.case import load_case, simulation_answer
    >>> from percuss.plot import machine_motion as picture
    >>> case = load_case("valve-drifter").changed(simulation={"modes": 0})
    >>> len(picture(simulation_answer(case)).axes)
    4
    """
    title, moved = titled_motion(motion, clocked=False)
    figure = new_figure(11.0, 7.0)
    with style():
        grid = figure.add_gridspec(2, 3)
        shown = _Shown(moved)
        _motion_position(figure.add_subplot(grid[0, :2]), shown)
        _speeds(figure.add_subplot(grid[0, 2]), shown)
        _motion_force(figure.add_subplot(grid[1, :2]), shown)
        _portrait(figure.add_subplot(grid[1, 2]), shown)
        titled(figure, f"{title} — {moved.label}" if title else moved.label)
    return figure


def _motion_shade(axes: Any, shown: _Shown) -> None:
    forces = shown.motion.mechanism.forces
    _shade(axes, shown.times * shown.clock, forces[shown.motion.state(shown.times)] > 0.0, "post")


def _motion_position(axes: Any, shown: _Shown) -> None:
    times, centre = shown.times * shown.clock, shown.centre * shown.length
    low = float(centre.min())
    axes.axhline(0.0, color=INK, linewidth=2.5)
    _motion_shade(axes, shown)
    axes.plot(times, centre, color=INK)
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
    for i, port in enumerate(shown.motion.machine.valve.ports):
        if port.behind is not None:
            edge = -port.behind * shown.length
            low = min(low, edge)
            axes.axhline(edge, color=COLOURS[3], linewidth=0.9, linestyle=(0, (5, 3)))
            name, place = f"ports[{i}]: {port.to}", (1.0, edge)
            look = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "ha": "right"}
            axes.annotate(
                name, place, (-3, 3 if edge < 0.1 * low else -10), color=COLOURS[3], fontsize=7.5, bbox=ground, **look
            )
    for kind, (marker, colour, name, size) in reversed(_MARKS.items()):  # blows on top
        at = shown.events.of(kind).time
        if at.size:
            heights = 0.0 * at if kind == "impact" else np.interp(at, shown.times, centre)
            key = {"color": colour, "markersize": size, "linestyle": "none", "zorder": 3, "clip_on": False}
            axes.plot(at * shown.clock, heights, marker, label=name, **key)
    axes.set_ylim(1.12 * low if low < 0.0 else -1.0, -0.12 * low if low < 0.0 else 0.12)
    _ends(axes, shown)
    axes.set_title(f"(a) the piston: {shown.what}")
    axes.set_xlabel(shown.labels[0])
    axes.set_ylabel(shown.labels[1])
    legend_above(axes, columns=6)


def _ends(axes: Any, shown: _Shown) -> None:
    room = 0.005 * (shown.last - shown.first) or 0.5
    axes.set_xlim((shown.first - room) * shown.clock, (shown.last + room) * shown.clock)
    axes.ticklabel_format(axis="x", useOffset=False)


def _speeds(axes: Any, shown: _Shown) -> None:
    struck, cycle = shown.motion.events.of("impact"), shown.motion.cycle
    axes.set_title("(b) striking speeds")
    axes.set_xlabel(shown.labels[0])
    axes.set_ylabel("striking speed [m/s]" if shown.labels[3] else "striking speed")
    if not len(struck):
        axes.text(0.5, 0.5, "no impact", transform=axes.transAxes, ha="center", va="center", color=INK)
        return
    first = 0 if cycle is None else cycle.first
    parts: list[tuple[Array, Array, str, str]] = [
        (struck.time[first:], struck.impact_velocity[first:], COLOURS[1], "settled" if cycle is not None else "")
    ]
    if first:
        parts.append((struck.time[:first], struck.impact_velocity[:first], COLOURS[5], "transient"))
    for time, speed, colour, name in parts:
        key: dict[str, Any] = {"markersize": 3.5, "markeredgewidth": 0.0, "rasterized": time.size > 5000}
        axes.plot(time * shown.clock, speed * shown.speed, "o", color=colour, label=name or None, **key)
    axes.set_ylim(bottom=0.0, top=1.08 * float(struck.impact_velocity.max()) * shown.speed or 1.0)
    axes.locator_params(axis="x", nbins=5)
    if cycle is not None:
        axes.legend(loc="lower right")


def _motion_force(axes: Any, shown: _Shown) -> None:
    axes.axhline(0.0, color=INK, linewidth=0.6)
    _motion_shade(axes, shown)
    axes.plot(shown.times * shown.clock, shown.force * shown.newtons, color=COLOURS[0])
    _ends(axes, shown)
    _named_force(axes, shown.motion.machine, "(c)", shown.labels[0], shown.labels[2])


def _portrait(axes: Any, shown: _Shown) -> None:
    axes.axvline(0.0, color=INK, linewidth=2.5)
    axes.axhline(0.0, color=INK, linewidth=0.4)
    axes.plot(shown.gap * shown.length, shown.velocity * shown.speed, color=COLOURS[0], linewidth=0.9)
    axes.set_title("(d) phase portrait of the striking end")
    axes.set_xlabel(shown.labels[1])
    axes.set_ylabel(f"velocity [{shown.labels[3]}]" if shown.labels[3] else "velocity")
    axes.set_xmargin(0.08)
