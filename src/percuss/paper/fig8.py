"""Fig. 8 of B77: the greatest κ at which the hydraulic hammer has a motion with one impact in a period (B77 40)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.explore.boundary_curves.boundary import boundaries
from percuss.paper.figure import DAMPING, KAPPAS, RESTITUTIONS, Figure, hydraulic

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture


def figures(seed: int = 1977) -> tuple[Figure, ...]:
    """Fig. 8: columns restitution, kappa (d = 0), kappa_damped (2πd = 0.03); m = 1, any s."""
    columns = {"restitution": RESTITUTIONS}
    for d, name in ((0.0, "kappa"), (DAMPING, "kappa_damped")):
        plane = ("restitution", RESTITUTIONS), ("kappa", *KAPPAS)
        columns[name] = boundaries(hydraulic(d=d), *plane, kinds=("fold",)).greatest("fold")
    return (Figure("fig8", "Fig. 8: motions of the hydraulic hammer exist below, $m = 1$", columns, _paint),)


def _paint(figure: Figure, picture: Picture) -> None:
    from percuss.plot.canvas import COLOURS

    axes, c = picture.add_subplot(), figure.columns
    axes.plot(c["restitution"], c["kappa"], color=COLOURS[0], label="$d = 0$")
    axes.plot(c["restitution"], c["kappa_damped"], color=COLOURS[0], linestyle=(0, (4, 2)), label="$2\\pi d = 0.03$")
    axes.text(0.6, 1.25, "motions exist, none of them stable", ha="center")
    axes.text(0.2, 1.8, "no motion", ha="center")
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(1.0, 2.0)
    axes.set_xlabel("$R$")
    axes.set_ylabel("$\\kappa$")
    axes.legend(loc="upper left")
