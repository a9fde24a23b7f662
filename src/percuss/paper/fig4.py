"""Fig. 4 of B77: impact phase of the pneumatic hammer over the load factor, for R = 0, 0.1, …, 0.9 (B77 35–39)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.paper.figure import TENTHS, Columns, Figure, branch_rows, pneumatic, stacked

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture

_POINTS = 180  # on each branch
_MOST = 10.0  # beyond the fold of R = 0.9, at 6.05
_SHOWN = 2.0


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 4: columns restitution, load_factor, phase [rad], stable, admissible; s → ∞, d = 0, m = 1."""
    parts = [branch_rows(pneumatic(), r, "load_factor", 0.0, _MOST, _POINTS) for r in TENTHS]
    title = "Fig. 4: impact phase of the pneumatic hammer, $m = 1$, $s \\to \\infty$, $d = 0$"
    return (Figure("fig4", title, stacked(parts), _paint, 6.2, 4.8),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.paper.figure import branch_legend, draw_branches

    axes = picture.add_subplot()
    draw_branches(axes, figure.columns, "load_factor")
    axes.set_xlim(0.0, _SHOWN)
    axes.set_ylim(0.0, math.pi)
    axes.set_yticks([0.0, math.pi / 4, math.pi / 2, 3 * math.pi / 4, math.pi], ["0", "π/4", "π/2", "3π/4", "π"])
    axes.set_xlabel("$p_0/p_1$")
    axes.set_ylabel("impact phase φ")
    _label(axes, figure.columns)
    branch_legend(axes)
    legend = axes.get_legend()
    if legend is not None:
        legend.remove()
    picture.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)


def _label(axes: Axes, columns: Columns) -> None:
    """The number of each curve: at its fold, or at the edge of the picture where the fold lies beyond it."""
    for text in list(axes.texts):
        text.remove()
    for r in np.unique(columns["restitution"]).tolist():
        here = columns["restitution"] == r
        y, phase = columns["load_factor"][here], columns["phase"][here]
        fold = int(np.argmax(y))
        at, shift, side = (float(y[fold]), float(phase[fold])), (-2, 0), "right"
        if y[fold] > _SHOWN:
            last = np.flatnonzero(y > _SHOWN).min()
            inner = np.interp(_SHOWN, y[last - 1 : last + 1], phase[last - 1 : last + 1])
            at, shift, side = (_SHOWN, float(inner)), (3, 0), "left"
        name = f"{r:.1f}" if r else "R = 0"
        axes.annotate(name, at, shift, textcoords="offset points", fontsize=6.5, ha=side, va="center")
