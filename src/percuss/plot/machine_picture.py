"""The picture of a machine that switches its own valve: its cycle, the force, the work, and what pressure changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, legend_above, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.model import Machine
    from percuss.model.checks import Array
    from percuss.steady.self_excited import SelfExcited, ValveCycle

__all__ = ["machine"]


_NEAR = 0.06  # of the stroke: the name of a port so near to the wall stands below its line


class _Course(Protocol):
    """A cycle over time."""

    @property
    def times(self) -> Array: ...
    @property
    def striking_end(self) -> Array: ...
    @property
    def centre(self) -> Array: ...
    @property
    def force(self) -> Array: ...
    @property
    def states(self) -> tuple[str, ...]: ...
    @property
    def pressure(self) -> Array | None: ...


class _Running(Protocol):
    """Energy and rate at another pressure, relative to those of the case."""

    @property
    def pressure(self) -> float: ...
    @property
    def energy(self) -> float | None: ...
    @property
    def rate(self) -> float | None: ...


class _Answer(Protocol):
    """The answer for a machine that switches its own valve."""

    @property
    def title(self) -> str: ...
    @property
    def outcome(self) -> str: ...
    @property
    def label(self) -> str: ...
    @property
    def machine(self) -> Machine: ...
    @property
    def motion(self) -> SelfExcited: ...
    @property
    def cycle(self) -> ValveCycle | None: ...
    @property
    def course(self) -> _Course: ...
    @property
    def curve(self) -> Sequence[_Running]: ...


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


def machine(answer: _Answer) -> Figure:
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


def _nothing(axes: Any, answer: _Answer) -> None:
    obstacle = answer.motion.obstacle
    text = "" if obstacle is None else f"{obstacle.value}\n{obstacle.words}\n{obstacle.remedy}"
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=INK, fontsize=11, wrap=True)
    axes.set_axis_off()


def _panels(figure: Figure, answer: _Answer) -> None:
    course = answer.course
    scales = _Scales(answer.machine, float(np.abs(course.force).max()))
    grid = figure.add_gridspec(2, 3)
    _position(figure.add_subplot(grid[0, :2]), answer, course, scales)
    _force(figure.add_subplot(grid[1, :2]), answer, course, scales)
    _loop(figure.add_subplot(grid[0, 2]), answer, course, scales)
    _pressures(figure.add_subplot(grid[1, 2]), answer)


# -- over the cycle ---------------------------------------------------------------------------------------------------


def _position(axes: Any, answer: _Answer, course: _Course, scales: _Scales) -> None:
    cycle, low = answer.cycle, float(course.centre.min()) * scales.length
    assert cycle is not None
    axes.axhline(0.0, color=INK, linewidth=2.5)
    axes.annotate(
        "wall", (1.0, 0.0), (0, 4), xycoords=("axes fraction", "data"), textcoords="offset points", ha="right"
    )
    _shade(axes, answer, course, scales)
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


def _shade(axes: Any, answer: _Answer, course: _Course, scales: _Scales) -> None:
    """A ground for the times at which the valve pushes toward the wall."""
    pushes = np.array([answer.machine.valve.force(state) > 0.0 for state in course.states])
    axes.fill_between(
        course.times * scales.time,
        0.0,
        1.0,
        where=pushes,
        transform=axes.get_xaxis_transform(),
        color=COLOURS[5],
        alpha=0.15,
        linewidth=0.0,
        label="valve pushes",
    )


def _force(axes: Any, answer: _Answer, course: _Course, scales: _Scales) -> None:
    cycle = answer.cycle
    assert cycle is not None
    axes.axhline(0.0, color=INK, linewidth=0.6)
    _shade(axes, answer, course, scales)
    axes.plot(course.times * scales.time, course.force * scales.force, color=COLOURS[0])
    axes.set_xlim(0.0, cycle.period * scales.time)
    gas = answer.machine.valve.chamber
    with_gas = ", with the gas" if gas.force or gas.stiffness else ""
    axes.set_title(f"(b) the force on the piston, positive toward the wall{with_gas}")
    axes.set_xlabel(scales.time_label)
    axes.set_ylabel(scales.force_label)
    if course.pressure is not None:
        unit = answer.machine.pressure
        pressure = course.pressure * (1.0 if unit is None else unit / 1e5)
        other = axes.twinx()
        other.spines["right"].set_visible(True)
        other.plot(course.times * scales.time, pressure, color=COLOURS[1])
        other.set_ylabel("pressure" if unit is None else "pressure [bar]", color=COLOURS[1])
        other.tick_params(axis="y", colors=COLOURS[1])
        other.set_ylim(bottom=0.0)


def _loop(axes: Any, answer: _Answer, course: _Course, scales: _Scales) -> None:
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


def _pressures(axes: Any, answer: _Answer) -> None:
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
