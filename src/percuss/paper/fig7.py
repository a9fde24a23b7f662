"""Fig. 7 of B77: impact phase of the hydraulic hammer over κ, for R = 0, 0.1, …, 0.9; no motion is stable (B77 41)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.paper.figure import KAPPAS, TENTHS, Figure, branch_rows, hydraulic, stacked

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

_POINTS = 90  # on each branch


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 7: columns restitution, kappa, phase [rad], stable, admissible; s → ∞, d = 0, m = 1."""
    parts = [branch_rows(hydraulic(), r, "kappa", *KAPPAS, _POINTS) for r in TENTHS]
    title = "Fig. 7: impact phase of the hydraulic hammer, $m = 1$, $s \\to \\infty$, $d = 0$"
    return (Figure("fig7", title, stacked(parts), _paint, 6.2, 4.8),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.paper.figure import branch_legend, draw_branches

    axes = picture.add_subplot()
    draw_branches(axes, figure.columns, "kappa", inside=False)
    axes.set_xlim(1.0, 2.0)
    axes.set_ylim(0.0, 2.0 * math.pi)
    axes.set_yticks([i * math.pi / 2 for i in range(5)], ["0", "π/2", "π", "3π/2", "2π"])
    axes.set_xlabel("$\\kappa$")
    axes.set_ylabel("impact phase φ")
    branch_legend(axes)
