"""The picture of branches of orbits: phases of the impacts over the parameter, and what happens where."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import having, text
from percuss.plot.canvas import COLOURS, INK, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import Branch

__all__ = ["EVENT_MARKS", "branch"]

EVENT_MARKS = {
    "fold": "s", "flip": "D", "neimark_sacker": "o", "grazing_touch": "v", "grazing_impact_dies": "^", "corner": "P",
    "branch_point": "x", "nonsmooth_fold": "X", "sticking": "*", "onset": "<", "release_lost": ">",
    "label_changes": "p",
}  # fmt: skip
_JUMP = np.pi  # from which on a phase has gone round


def branch(found: Branch, title: str = "") -> Figure:
    """Draw branches: the phases of the impacts, above them the speeds; stable parts solid, unstable ones dashed.

    Parameters
    ----------
    found
        A `percuss.explore.Branch`, drawn with those that were switched to from it.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When it is no branch.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import follow
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    >>> len(branch(follow(orbit_near(system, [2.2], modes=0), "mean", (0.75, 0.9))).axes)
    2
    """
    having("found", found, ("points", "family", "values"), "a percuss.explore.Branch")
    if not len(found.values):
        raise ParameterError("found", str(found), "a branch with points")
    text("title", title, "a text")
    with style():
        figure = new_figure(6.4, 6.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        marks: dict[str, object] = {}
        for number, one in enumerate(found.family()):
            colour = COLOURS[number % len(COLOURS)]
            for ax, rows in ((upper, one.speeds), (lower, one.phases)):
                _lines(ax, one, rows, colour, one.label if ax is upper else "")
            _marked(upper, lower, one, marks)
        upper.set_ylabel("speed at the impacts, dimensionless")
        lower.set_ylabel("phase of the impacts [rad]")
        lower.set_xlabel(found.parameter)
        lower.set_ylim(0.0, 2.0 * np.pi)
        lower.set_yticks([0.0, np.pi, 2.0 * np.pi], ["0", "π", "2π"])
        _legend(upper)
        titled(figure, title)
    return figure


def _lines(ax: Axes, one: Branch, rows: np.ndarray, colour: str, label: str) -> None:
    """One line for each impact, cut where the stability changes and where a phase goes round."""
    changes = np.flatnonzero(np.diff(one.stable.astype(int))) + 1
    cuts = [0, *changes.tolist(), one.values.size]
    for start, stop in pairwise(cuts):
        part = slice(start, min(stop + 1, one.values.size))
        solid = bool(one.stable[start])
        for row in rows.T:
            y = np.array(row[part])
            gone = np.flatnonzero(np.abs(np.diff(y)) > _JUMP) + 1
            x = np.insert(one.values[part], gone, np.nan)
            ax.plot(x, np.insert(y, gone, np.nan), "-" if solid else "--", color=colour, label=label or "_", lw=1.2)
            label = ""


def _marked(upper: Axes, lower: Axes, one: Branch, marks: dict[str, object]) -> None:
    for point in one.points:
        mark = EVENT_MARKS.get(point.kind.value)
        if mark is None:
            continue
        label = "_" if mark in marks else point.kind.value.replace("_", " ")
        marks[mark] = point
        for ax, heights in ((upper, point.orbit.speeds), (lower, point.orbit.phases)):
            x = np.full(heights.size, point.value)
            ax.plot(x, heights, mark, color=INK, ms=4.0, label=label if ax is upper else "_", ls="")


def _legend(ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    kept = dict(zip(labels, handles, strict=True))
    ax.legend(kept.values(), kept.keys(), loc="best", ncols=2)
