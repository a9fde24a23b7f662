"""The picture of a best blow beside that of the case as it is: forces at the face and on the rock, shapes, stresses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, legend_above, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["best"]

_SHOWN = 1.5
"""Times the end of the last contact that curves go on for."""


def best(answer: Any) -> Figure:
    """Draw what a search for the best blow has found.

    Parameters
    ----------
    answer
        What `percuss.case.best_answer` gives.

    Raises
    ------
    ParameterError
        For anything else.
    MissingExtraError
        When matplotlib is not installed.
    """
    having("answer", answer, ("own", "best", "spans"), "the answer of percuss.case.best_answer")
    figure = new_figure(10.0, 8.0)
    both = ((answer.own, COLOURS[0], "the case"), (answer.best, COLOURS[1], "best"))
    with style():
        grid = figure.add_gridspec(2, 2)
        _forces(figure.add_subplot(grid[0, 0]), both, "face_force", "(a) force between the faces")
        right = figure.add_subplot(grid[0, 1])
        if answer.own.blow.bit_force is None:
            _stresses(right, both, "(b) greatest stress of each section")
        else:
            _forces(right, both, "bit_force", "(b) force on the rock")
            _stresses(figure.add_subplot(grid[1, 1]), both, "(d) greatest stress of each section")
        _shapes(figure.add_subplot(grid[1, 0]), both)
        titled(figure, answer.own.title)
    return figure


def _forces(axes: Any, both: Any, name: str, title: str) -> None:
    clock, scale = (1e6, 1e-3) if both[0][0].is_si else (1.0, 1.0)
    last = 0.0
    for one, colour, label in both:
        times, values = getattr(one.blow, name).sampled(4000)
        axes.plot(times * clock, values * scale, color=colour, label=label)
        moving = np.flatnonzero(values > 1e-3 * values.max(initial=0.0))
        last = max(last, float(times[moving[-1]]) if moving.size else 0.0)
    axes.set_xlim(0.0, min(_SHOWN * last, float(both[0][0].blow.until)) * clock or None)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel("time [µs]" if both[0][0].is_si else "time [rad]")
    axes.set_ylabel("force [kN]" if both[0][0].is_si else "force")
    axes.set_title(title)
    legend_above(axes)


def _shapes(axes: Any, both: Any) -> None:
    """Areas along striker and rod."""
    axes.set_title("(c) area along striker and rod")
    if not both[0][0].is_si:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "a dimensionless bar has no areas", ha="center", transform=axes.transAxes)
        return
    for one, colour, label in both:
        own, rod = one.pieces
        long = own[-1].end
        known = [piece for piece in rod if np.isfinite(piece.end)]
        edges = [own[0].start - long, *(piece.end - long for piece in own), *(piece.end for piece in known)]
        areas = [1e6 * piece.area for piece in (*own, *known)]
        axes.stairs(areas, edges, color=colour, label=label, baseline=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel("place from the struck face [m]")
    axes.set_ylabel("area [mm²]")
    legend_above(axes)


def _stresses(axes: Any, both: Any, title: str) -> None:
    scale = 1e-6 if both[0][0].is_si else 1.0
    own, rod = both[0][0].peaks
    names = [f"striker {i}" for i in range(len(own))] + [f"rod {i}" for i in range(len(rod))]
    for shift, (one, colour, label) in zip((-0.2, 0.2), both, strict=True):
        values = [scale * max(peak.compression, peak.tension) for part in one.peaks for peak in part]
        axes.bar(np.arange(len(values)) + shift, values, 0.4, color=colour, label=label)
    axes.set_xticks(np.arange(len(names)), names, rotation=30)
    axes.set_ylabel("stress [MPa]" if both[0][0].is_si else "force")
    axes.set_title(title)
    legend_above(axes)
