"""Fig. 6 of B77: the same as Fig. 5 with ten load periods to an impact, near the bar's first resonance (B77 37, 39).

B77 measures frequencies from the impact, so that the load is its tenth harmonic, p_0 + p_10 cos 10t, and sπ = 10.1 and
10.01. Here frequencies are measured from the load: p_0 + p_1 cos t with m = 10 and sπ = 1.01 and 1.001. The forces of
the two scalings differ by the factor m² = 100, the mean and the amplitude alike: p_0/p_10 there is p_0/p_1 here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.explore.boundary_curves.boundary import boundaries
from percuss.paper.figure import RESTITUTIONS, STIFF, Figure, pneumatic

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

PERIODS = 10
_SPEEDS = {"": STIFF, "_10_1": 1.01 / math.pi, "_10_01": 1.001 / math.pi}


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 6: columns restitution, upper, lower (sπ → ∞), lower_10_1, lower_10_01, all as p_0/p_10; d = 0, m = 10."""
    columns = {"restitution": RESTITUTIONS}
    plane = ("restitution", RESTITUTIONS), ("load_factor", 0.0, 10.0), PERIODS
    for ending, s in _SPEEDS.items():
        found = boundaries(pneumatic(s), *plane, kinds=("fold", "flip"))
        if not ending:
            columns["upper"] = found.greatest("fold")
        columns[f"lower{ending}"] = found.greatest("flip")
    title = "Fig. 6: stable motions of the pneumatic hammer, $m = 10$, $d = 0$"
    return (Figure("fig6", title, columns, _paint),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS

    axes, c = picture.add_subplot(), figure.columns
    lines = (
        ("upper", "-", COLOURS[0], "upper, any $s$"),
        ("lower", "-", COLOURS[1], "lower, $s\\pi \\to \\infty$"),
        ("lower_10_1", (0, (6, 2)), COLOURS[1], "lower, B77's $s\\pi = 10.1$"),
        ("lower_10_01", (0, (2, 2)), COLOURS[1], "lower, B77's $s\\pi = 10.01$"),
    )
    for name, line, colour, label in lines:
        axes.plot(c["restitution"], c[name], color=colour, linestyle=line, label=label)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 0.6)
    axes.set_xlabel("$R$")
    axes.set_ylabel("$p_0/p_{10}$  (here: $p_0/p_1$ with $m = 10$)")
    axes.legend(loc="upper left")
