"""The picture of a simulated motion of a machine that switches its own valve: piston, force, blows, phase portrait."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.plot.canvas import COLOURS, INK, legend_above, new_figure, style, titled
from percuss.plot.titled_motion import TitledMotion, titled_motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.model.checks import Array
    from percuss.simulate import MachineEvents, MachineTrajectory

__all__ = ["machine_motion"]

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

    def __init__(self, motion: MachineTrajectory) -> None:
        self.motion = motion
        si, machine = motion.machine.is_si, motion.machine
        self.first, self.last, self.what = _window(motion)
        inside = (motion.events.time >= self.first) & (motion.events.time <= self.last)
        self.events: MachineEvents = motion.events[inside]
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


def _window(motion: MachineTrajectory) -> tuple[float, float, str]:
    """The part that is shown: the last cycles, or the last events."""
    begin, end, times = motion.begin_time, motion.end_time, motion.events.time
    if motion.cycle is not None and len(times):
        first = float(times[-1]) - CYCLES * motion.cycle.period
        return max(first, begin), float(times[-1]), "the last cycles" if first > begin else "the whole motion"
    if len(times) <= MOST_EVENTS:
        return begin, end, "the whole motion"
    return float(times[-MOST_EVENTS]), end, "the last flights"


def machine_motion(motion: MachineTrajectory | TitledMotion[MachineTrajectory]) -> Figure:
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
    >>> from percuss.case import load_case, machine_motion
    >>> from percuss.plot import machine_motion as picture
    >>> case = load_case("valve-drifter").changed(simulation={"modes": 0})
    >>> len(picture(machine_motion(case)).axes)
    4
    """
    from percuss.simulate import MachineTrajectory

    title, moved = titled_motion(motion, MachineTrajectory)
    figure = new_figure(11.0, 7.0)
    with style():
        grid = figure.add_gridspec(2, 3)
        shown = _Shown(moved)
        _position(figure.add_subplot(grid[0, :2]), shown)
        _speeds(figure.add_subplot(grid[0, 2]), shown)
        _force(figure.add_subplot(grid[1, :2]), shown)
        _portrait(figure.add_subplot(grid[1, 2]), shown)
        titled(figure, f"{title} — {moved.label}" if title else moved.label)
    return figure


def _shade(axes: Any, shown: _Shown) -> None:
    """A ground for the times at which the valve pushes toward the wall."""
    forces = shown.motion.mechanism.forces
    pushes = forces[shown.motion.state(shown.times)] > 0.0
    look: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.15, "linewidth": 0.0, "label": "valve pushes"}
    times, across = shown.times * shown.clock, axes.get_xaxis_transform()
    axes.fill_between(times, 0.0, 1.0, where=pushes, transform=across, step="post", **look)


def _position(axes: Any, shown: _Shown) -> None:
    times, centre = shown.times * shown.clock, shown.centre * shown.length
    low = float(centre.min())
    axes.axhline(0.0, color=INK, linewidth=2.5)
    _shade(axes, shown)
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
        (struck.time[first:], struck.velocity[first:], COLOURS[1], "settled" if cycle is not None else "")
    ]
    if first:
        parts.append((struck.time[:first], struck.velocity[:first], COLOURS[5], "transient"))
    for time, speed, colour, name in parts:
        key: dict[str, Any] = {"markersize": 3.5, "markeredgewidth": 0.0, "rasterized": time.size > 5000}
        axes.plot(time * shown.clock, speed * shown.speed, "o", color=colour, label=name or None, **key)
    axes.set_ylim(bottom=0.0, top=1.08 * float(struck.velocity.max()) * shown.speed or 1.0)
    axes.locator_params(axis="x", nbins=5)
    if cycle is not None:
        axes.legend(loc="lower right")


def _force(axes: Any, shown: _Shown) -> None:
    axes.axhline(0.0, color=INK, linewidth=0.6)
    _shade(axes, shown)
    axes.plot(shown.times * shown.clock, shown.force * shown.newtons, color=COLOURS[0])
    _ends(axes, shown)
    gas = shown.motion.machine.valve.chamber
    with_gas = ", with the gas" if gas.force or gas.stiffness else ""
    axes.set_title(f"(c) the force on the piston, positive toward the wall{with_gas}")
    axes.set_xlabel(shown.labels[0])
    axes.set_ylabel(shown.labels[2])


def _portrait(axes: Any, shown: _Shown) -> None:
    axes.axvline(0.0, color=INK, linewidth=2.5)
    axes.axhline(0.0, color=INK, linewidth=0.4)
    axes.plot(shown.gap * shown.length, shown.velocity * shown.speed, color=COLOURS[0], linewidth=0.9)
    axes.set_title("(d) phase portrait of the striking end")
    axes.set_xlabel(shown.labels[1])
    axes.set_ylabel(f"velocity [{shown.labels[3]}]" if shown.labels[3] else "velocity")
    axes.set_xmargin(0.08)
