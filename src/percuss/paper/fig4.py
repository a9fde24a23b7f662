"""Fig. 4 of B77: impact phase of the pneumatic hammer over the load factor, for R = 0, 0.1, …, 0.9 (B77 35–39)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.paper.figure import Figure
from percuss.paper.limits import TENTHS, branch_rows, pneumatic, stacked

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

__all__ = ["figures"]

_POINTS = 180  # on each branch
_MOST = 10.0  # beyond the fold of R = 0.9, at 6.05
_SHOWN = 2.0


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 4: columns restitution, load_factor, phase [rad], stable, admissible; s → ∞, d = 0, m = 1."""
    parts = [branch_rows(pneumatic(), r, "load_factor", 0.0, _MOST, _POINTS) for r in TENTHS]
    title = "Fig. 4: impact phase of the pneumatic hammer, $m = 1$, $s \\to \\infty$, $d = 0$"
    return (Figure("fig4", title, stacked(parts), _paint, 6.2, 4.8),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.paper.drawing import branch_legend, draw_branches

    axes = picture.add_subplot()
    draw_branches(axes, figure.columns, "load_factor")
    axes.set_xlim(0.0, _SHOWN)
    axes.set_ylim(0.0, math.pi)
    axes.set_yticks([0.0, math.pi / 4, math.pi / 2, 3 * math.pi / 4, math.pi], ["0", "π/4", "π/2", "3π/4", "π"])
    axes.set_xlabel("$p_0/p_1$")
    axes.set_ylabel("impact phase φ")
    branch_legend(axes)
