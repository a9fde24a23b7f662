"""The picture of a simulated motion: its last flights, its history, its map, and the waves in the bar."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, Units, canvas, draw_waves, nothing, phase_axis, units_of, wall

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.simulation_answer import SimulationAnswer
    from percuss.model.checks import Array
    from percuss.simulate import Events, Trajectory


def titled_motion(shown: Any, clocked: bool) -> tuple[str, Trajectory]:
    """The title, "" for a motion alone, and the motion; refuses what is neither such a motion nor holds one."""
    from percuss.simulate import Trajectory

    accepted = f"a Trajectory of a {'system' if clocked else 'machine'}, or the answer that holds one"
    alone = isinstance(shown, Trajectory)
    if not alone:
        having("motion", shown, ("title", "motion"), accepted)
    title, motion = ("", shown) if alone else (shown.title, shown.motion)
    if motion.is_clocked != clocked:
        raise ParameterError("motion", str(motion), accepted)
    return title, motion


# ---- The part of a simulated motion that its picture shows at full resolution: the last cycles or flights

_TURN = 2.0 * math.pi

LONG_CYCLE = 12  # load periods of a cycle that is too long to be shown twice

MOST_VALUES = 4_000_000  # samples times modes


@dataclass(frozen=True)
class Window:
    """A stretch of a motion from `first` to `last` (rad), with a word for what it is."""

    motion: Trajectory
    first: float
    last: float
    what: str

    @cached_property
    def events(self) -> Events:
        time = self.motion.events.time
        return self.motion.events[(time >= self.first) & (time <= self.last)]

    def _grid(self, points: int) -> Array:
        most = max(MOST_VALUES // (self.motion.modes + 1), 200)
        return np.linspace(self.first, self.last, min(points, most))

    @cached_property
    def _jumps(self) -> Array:
        """Times of events, at most 500 of them, at which the velocity jumps."""
        times = np.unique(np.clip(self.events.time, self.first, self.last))
        return times[-500:]

    @cached_property
    def times(self) -> Array:
        """Sample times, those of the events among them."""
        return np.unique(np.concatenate([self._grid(2400), self._jumps]))

    @cached_property
    def gap(self) -> Array:
        return np.minimum(self.motion.gap(self.times), 0.0)

    @cached_property
    def velocity(self) -> tuple[Array, Array]:
        """Times, each event's twice, and the velocity of the striking end there."""
        return self._both_sides(lambda t, side: self.motion.bar_velocity(1.0, t, side)[0])

    @cached_property
    def energy(self) -> tuple[Array, Array]:
        """Times, each event's twice, and the energy of the bar there."""
        return self._both_sides(lambda t, side: self.motion.energy(t, side))

    def _both_sides(self, quantity: Any) -> tuple[Array, Array]:
        times = np.concatenate([self._jumps, self.times])
        values = np.concatenate([quantity(self._jumps, "left"), quantity(self.times, "right")])
        order = np.argsort(times, kind="stable")  # the side before an event comes first
        return times[order], values[order]

    @cached_property
    def strain(self) -> tuple[Array, float, float]:
        """Strain at even places, (101, samples), and its first and last time: where waves can be told apart."""
        trips = 240.0 * self.motion.system.body.transit_time  # 120 times to the other end and back
        first = max(self.first, self.last - min(max(0.5 * (self.last - self.first), 2.0 * _TURN), trips))
        times = np.linspace(first, self.last, min(720, max(MOST_VALUES // (self.motion.modes + 1), 200)))
        return self.motion.strain(np.linspace(0.0, 1.0, 101), times), first, self.last


def window_of(motion: Trajectory) -> Window:
    """Two cycles of a periodic motion; all of a short motion; the last eight load periods and four blows of another."""
    first, last = motion.begin_time, motion.end_time
    cycle = re.fullmatch(r"(?:z=\d+|chatter|rest)/(\d+)", motion.label)
    if cycle is not None and int(cycle[1]) <= LONG_CYCLE:
        start = last - 2.0 * int(cycle[1]) * _TURN
        return Window(motion, max(start, first), last, "the last two cycles")
    blows = motion.events.of("impact").time[motion.main_blows]
    few = blows.size <= 60 and (last - first <= 12.0 * _TURN or motion.system.load.is_constant)
    if few or blows.size < 4:
        return Window(motion, first, last, "the whole motion")
    start = min(last - 8.0 * _TURN, float(blows[-4]))
    return Window(motion, max(start, first), last, "the last flights")


# ---- The picture of a simulated motion: its last flights, its history, its map, and the waves in the bar

MOST_POINTS = 20_000  # points of a scatter; of more impacts an even choice is drawn


_MARKS = {
    "impact": ("o", COLOURS[1], 4.0),
    "grazing": ("|", COLOURS[3], 9.0),
    "chatter": ("s", COLOURS[4], 5.0),
    "rest": ("v", COLOURS[0], 6.0),
    "release": ("^", COLOURS[2], 6.0),
}


_RAISED = {"chatter": 7.0, "rest": 14.0, "release": 14.0}
"""Points above the wall: a chatter ends where rest begins, and neither is to hide the impacts before it."""


def trajectory(motion: Trajectory | SimulationAnswer) -> Figure:
    """Draw a simulated motion, or the answer that holds one.

    Five panels: (a) the gap over the last cycles or flights with the events marked; (b) striking speeds over the whole
    motion; (c) load phase and striking speed of every impact: the impact map; (d) the phase portrait of the striking
    end; (e) the stress along the bar over time, or the energy where no waves run.

    Examples
    --------
    >>> from percuss import Load, Start, System, run
    >>> from percuss.plot import trajectory
    >>> system = System(s=20.0, d=0.0048, restitution=0.2, load=Load.harmonic(0.9, 1.0))
    >>> len(trajectory(run(system, Start.rigid(time=0.3), modes=8)).axes) >= 5
    True
    """
    title, moved = titled_motion(motion, clocked=True)
    units = units_of(moved.system)
    with canvas(11.0, 7.0, f"{title} — {moved.label}" if title else moved.label) as figure:
        grid = figure.add_gridspec(2, 3)
        window = window_of(moved)
        _gap(figure.add_subplot(grid[0, :2]), window, units)
        clock, label = _clock(moved, units, moved.end_time)
        draw_speeds(figure.add_subplot(grid[0, 2]), moved, units.speed, clock, label)
        _map(figure.add_subplot(grid[1, 0]), moved, units)
        draw_portrait(figure.add_subplot(grid[1, 1]), window, units)
        _waves(figure, figure.add_subplot(grid[1, 2]), window, units)
    return figure


def _clock(motion: Trajectory, units: Units, span: float) -> tuple[float, str]:
    """What one radian is on a time axis of that span, and what the axis is called."""
    if not motion.system.is_si:
        return (1.0, "time [rad]") if motion.system.load.is_constant else (1.0 / _TURN, "time [load periods]")
    seconds = span * units.time >= 5e3
    return (units.time * 1e-3, "time [s]") if seconds else (units.time, "time [ms]")


def _gap(axes: Any, window: Window, units: Units) -> None:
    from matplotlib.transforms import offset_copy

    motion = window.motion
    clock, label = _clock(motion, units, window.last)
    wall(axes)
    axes.plot(window.times * clock, window.gap * units.length, color=INK, linewidth=1.1)
    for kind, (marker, colour, size) in reversed(_MARKS.items()):  # impacts on top
        times = window.events.of(kind).time
        if times.size:
            key = {"marker": marker, "color": colour, "markersize": size, "linestyle": "none", "clip_on": False}
            place = offset_copy(axes.transData, axes.figure, y=_RAISED.get(kind, 0.0), units="points")
            axes.plot(times * clock, np.zeros(times.size), label=kind, zorder=3, transform=place, **key)
    if len(window.events):
        axes.legend(loc="lower right", ncols=5)
        low = float(window.gap.min()) * units.length
        axes.set_ylim(1.25 * low if low < 0.0 else -1.0, -0.16 * low if low < 0.0 else 0.16)
    else:
        nothing(axes, "no impact in the time that was followed", 0.06)
    _time_axis(axes, window.first, window.last, clock, few=False)
    axes.set(title="(a) the striking end: " + window.what, xlabel=label, ylabel=units.length_label)


def _time_axis(axes: Any, first: float, last: float, clock: float, few: bool = True) -> None:
    """A time axis with some room for a mark at its very end, and `few` figures where there is no room for more."""
    room = 0.005 * (last - first) or 0.5
    axes.set_xlim((first - room) * clock, (last + room) * clock)
    axes.locator_params(axis="x", nbins=4 if few else "auto")
    axes.ticklabel_format(axis="x", useOffset=False)


def _thinned(events: Events) -> Events:
    """At most `MOST_POINTS` of the events, always the same; by chance, for an even choice may beat with a cycle."""
    if len(events) <= MOST_POINTS:
        return events
    return events[np.sort(np.random.default_rng(0).choice(len(events), MOST_POINTS, replace=False))]


def _parts_of(motion: Trajectory) -> list[tuple[Events, str, str]]:
    """The impacts before and in the settled part, with their colours and names; all as one when no cycle was found."""
    struck = motion.events.of("impact")
    if motion.transient is None:
        return [(_thinned(struck), COLOURS[1], "")]
    before, after = struck[: motion.transient], struck[motion.transient :]
    return [(_thinned(before), COLOURS[5], "transient"), (_thinned(after), COLOURS[1], "settled")]


def draw_speeds(axes: Any, motion: Trajectory, speed: float, clock: float, label: str) -> None:
    """The striking speeds over the whole motion; `speed` and `clock` are what one of them is on the axes."""
    axes.set(title="(b) striking speeds", xlabel=label)
    size = 1.5 if motion.impacts > 2000 else 3.0
    _scatter(axes, motion, speed, size, lambda part: part.time * clock)
    _time_axis(axes, motion.begin_time, motion.end_time, clock)
    if motion.transient is not None:
        axes.legend(loc="best")


def _map(axes: Any, motion: Trajectory, units: Units) -> None:
    axes.set_title("(c) impact map")
    phase_axis(axes)
    size = 0.8 if motion.impacts > 5000 else 1.5 if motion.impacts > 500 else 3.5
    _scatter(axes, motion, units.speed, size, lambda part: part.phase)


def _scatter(axes: Any, motion: Trajectory, speed: float, size: float, place: Callable[[Events], Any]) -> None:
    """Striking speeds over whatever `place` takes from the impacts."""
    axes.set_ylabel("striking speed [m/s]" if motion.hammer.is_si else "striking speed")
    if not motion.impacts:
        nothing(axes, "no impact")
        return
    for part, colour, name in _parts_of(motion):
        look = {"markersize": size, "markeredgewidth": 0.0, "rasterized": len(part) > 5000, "label": name or None}
        look |= {"clip_on": not len(part), "zorder": 3}  # bounces lie on the axis
        axes.plot(place(part), part.impact_velocity * speed, "o", color=colour, **look)
    axes.set_ylim(0.0, 1.08 * speed * float(motion.events.of("impact").impact_velocity.max()) or 1.0)


def draw_portrait(axes: Any, window: Window, units: Units) -> None:
    """The velocity of the striking end over its gap."""
    axes.set(title="(d) phase portrait: " + window.what, xlabel=units.length_label, ylabel=units.speed_label)
    axes.axvline(0.0, color=INK, linewidth=2.5)
    axes.axhline(0.0, color=INK, linewidth=0.4)
    times, velocity = window.velocity
    gap = np.interp(times, window.times, window.gap)
    axes.plot(gap * units.length, velocity * units.speed, color=COLOURS[0], linewidth=0.9)
    axes.set_xmargin(0.08)


def _waves(figure: Figure, axes: Any, window: Window, units: Units) -> None:
    motion = window.motion
    clock, label = _clock(motion, units, window.last)
    axes.set_xlabel(label)
    if not motion.modes or motion.system.body.transit_time == 0.0:  # no waves run through it
        of = " of the rigid bar" if motion.system.body.is_free else ""
        axes.set_title(f"(e) energy{of}: {window.what}")
        times, energy = window.energy
        axes.plot(times * clock, energy * (motion.system.energy_scale if motion.system.is_si else 1.0), color=INK)
        _time_axis(axes, window.first, window.last, clock)
        name = "kinetic energy" if motion.system.body.is_free else "energy"
        axes.set_ylabel(f"{name} [J]" if motion.system.is_si else name)
        return
    what = units.stress_label.split(" [")[0]
    axes.set_title(f"(e) {what} along the bar, the end of (a),\nwithout that of the blows")
    if window.last <= window.first:
        nothing(axes, "nothing has moved")
        return
    strain, first, last = window.strain
    draw_waves(figure, axes, motion.system, strain, (first * clock, last * clock), units)
    _time_axis(axes, first, last, clock)
