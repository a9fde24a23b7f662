"""The picture of a branch of cycles with rest: releases, rests and the first impacts over the parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import having, text
from percuss.plot.branch_picture import EVENT_MARKS
from percuss.plot.canvas import COLOURS, INK, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import RestBranch

__all__ = ["rest_branch"]

_MOST = 6
"""Impacts that are drawn: those of a chatter have no last one."""


def rest_branch(found: RestBranch, title: str = "") -> Figure:
    """Draw cycles with rest: when the bar is let go, strikes and comes to rest; above, how fast it strikes.

    Parameters
    ----------
    found
        A `percuss.explore.RestBranch`. Its first impacts are drawn.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When it is no such branch.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import follow_rest_cycle
    >>> from percuss.steady import rest_cycles
    >>> (cycle,) = rest_cycles(System(5.0, 0.0, 0.5, Load.harmonic(0.8, 1.0)), modes=0).cycles
    >>> len(rest_branch(follow_rest_cycle(cycle, "mean", (0.7, 0.9), points=3)).axes)
    2
    """
    having("found", found, ("points", "cycles", "values"), "a percuss.explore.RestBranch")
    if not len(found.values):
        raise ParameterError("found", str(found), "a branch with points")
    text("title", title, "a text")
    drawn = min(_MOST, *(cycle.speeds.size for cycle in found.cycles))
    rests = min(cycle.release_phases.size for cycle in found.cycles)
    with style():
        figure = new_figure(6.4, 6.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        for impact in range(drawn):
            label = "_" if impact else found.label
            _line(upper, found.values, [cycle.speeds[impact] for cycle in found.cycles], COLOURS[0], "-", label)
            label = "_" if impact else f"impact{'s' if drawn > 1 else ''}"
            _line(lower, found.values, [cycle.phases[impact] for cycle in found.cycles], COLOURS[0], "-", label)
        for rest in range(rests):
            for name, colour, dashes in (("release", COLOURS[1], "-."), ("rest", COLOURS[2], "--")):
                phases = [getattr(cycle, f"{name}_phases")[rest] for cycle in found.cycles]
                _line(lower, found.values, phases, colour, dashes, "_" if rest else name)
        for point in found.points:
            _marked(upper, lower, point.value, point.kind.value, point.cycle.speeds[:drawn], point.cycle.phases[:drawn])
        upper.set_ylabel("speed at the impacts, dimensionless")
        lower.set_ylabel("phase [rad]")
        lower.set_xlabel(found.parameter)
        lower.set_ylim(0.0, 2.0 * np.pi)
        lower.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])
        upper.legend(loc="best")
        lower.legend(loc="best", ncols=3)
        titled(figure, title)
    return figure


def _line(ax: Axes, x: np.ndarray, heights: list[float], colour: str, dashes: str, label: str) -> None:
    """A line, cut where a phase goes round."""
    y = np.array(heights)
    gone = np.flatnonzero(np.abs(np.diff(y)) > np.pi) + 1
    ax.plot(np.insert(x, gone, np.nan), np.insert(y, gone, np.nan), dashes, color=colour, label=label, lw=1.2)


def _marked(upper: Axes, lower: Axes, value: float, kind: str, speeds: np.ndarray, phases: np.ndarray) -> None:
    mark = EVENT_MARKS.get(kind)
    if mark is None:
        return
    for ax, heights in ((upper, speeds), (lower, phases)):
        told = kind.replace("_", " ") if ax is upper else "_"
        ax.plot(np.full(len(heights), value), heights, mark, color=INK, ms=4.0, ls="", label=told)
