"""How branches of steady motions are drawn in the manner of B77: solid where stable, dashed where not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from percuss.paper.figure import Columns, segments

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["branch_legend", "draw_branches"]

_DASHES = (0, (4, 2))
_GREY = "#9a9a9a"


def draw_branches(axes: Axes, columns: Columns, name: str, inside: bool = True) -> None:
    """Phase over the parameter, a curve for each R with its number at the fold; grey where the motion is impossible."""
    from percuss.plot.canvas import COLOURS

    for r in np.unique(columns["restitution"]).tolist():
        here = columns["restitution"] == r
        y, phase = columns[name][here], columns["phase"][here]
        stable, possible = columns["stable"][here], columns["admissible"][here]
        for run, whether in segments(possible):
            for part, steady in segments(stable[run]):
                line = "-" if steady else _DASHES
                colour = COLOURS[0] if whether else _GREY
                axes.plot(y[run][part], phase[run][part], color=colour, linestyle=line, linewidth=1.2)
        top = int(np.argmax(y))
        axes.annotate(
            f"{r:.1f}" if r else "R = 0",
            (y[top], phase[top]),
            (-3, 0) if inside else (3, -1),
            textcoords="offset points",
            fontsize=7,
            ha="right" if inside else "left",
            va="center",
            annotation_clip=True,
        )


def branch_legend(axes: Axes) -> None:
    """What the lines mean."""
    from percuss.plot.canvas import COLOURS

    axes.plot([], [], color=COLOURS[0], label="stable (B77's criterion)")
    axes.plot([], [], color=COLOURS[0], linestyle=_DASHES, label="unstable")
    axes.plot([], [], color=_GREY, label="passes through the wall")
    axes.legend(loc="lower right")
