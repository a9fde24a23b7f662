"""Fig. 5 of B77: the range of load factors with a stable motion of the pneumatic hammer, over R (B77 38, 39)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.explore.boundary_curves.boundary import boundaries
from percuss.paper.figure import DAMPING, RESTITUTIONS, Figure, pneumatic

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

_MOST = 100.0  # beyond the fold of R = 0.99, at 63.3


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 5: columns restitution, lower, upper (d = 0), lower_damped, upper_damped (2πd = 0.03); s → ∞, m = 1."""
    columns = {"restitution": RESTITUTIONS}
    for d, ending in ((0.0, ""), (DAMPING, "_damped")):
        found = boundaries(
            pneumatic(d=d), ("restitution", RESTITUTIONS), ("load_factor", 0.0, _MOST), kinds=("fold", "flip")
        )
        columns[f"lower{ending}"], columns[f"upper{ending}"] = found.greatest("flip"), found.greatest("fold")
    title = "Fig. 5: stable motions of the pneumatic hammer, $m = 1$, $s \\to \\infty$"
    return (Figure("fig5", title, columns, _paint),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS

    axes, c = picture.add_subplot(), figure.columns
    axes.fill_between(c["restitution"], c["lower"], c["upper"], color=COLOURS[0], alpha=0.10, linewidth=0)
    for ending, line, name in (("", "-", "$d = 0$"), ("_damped", (0, (4, 2)), "$2\\pi d = 0.03$")):
        axes.plot(c["restitution"], c[f"upper{ending}"], color=COLOURS[0], linestyle=line, label=f"upper, {name}")
        axes.plot(c["restitution"], c[f"lower{ending}"], color=COLOURS[1], linestyle=line, label=f"lower, {name}")
    axes.text(0.82, 1.4, "stable", ha="center")
    axes.text(0.25, 1.2, "no motion", ha="center")
    axes.text(0.62, 0.35, "unstable", ha="center")
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 2.0)
    axes.set_xlabel("$R$")
    axes.set_ylabel("$p_0/p_1$")
    axes.legend(loc="upper left")
