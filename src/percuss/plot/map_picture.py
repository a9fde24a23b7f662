"""The picture of a sweep: a panel for every quantity, lines over one parameter, colours over two."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from percuss.errors import ParameterError
from percuss.model.checks import having, several, text
from percuss.plot.canvas import new_figure, style, titled
from percuss.plot.map_line import line
from percuss.plot.map_plane import CURVES, boundaries, on_plane, plane
from percuss.steady.figures import FIGURES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.plot.map_axes import Curve, Map

__all__ = ["sweep"]

_TITLES = {
    **{name: figure.label for name, figure in FIGURES.items()},
    "exists": "steady motion exists",
    "orbits": "steady motions",
    "reduced_stable": "stable, reduced criterion",
    "reduced_margin": "stability margin, reduced criterion",
    "stable": "stable, exact multipliers",
    "margin": "stability margin, exact multipliers",
    "margin_rhythm": "rhythm margin",
    "margin_ringing": "ringing margin",
    "reason": "stable, or why not",
    "admissible": "stays off the wall between impacts",
    "rest": "can rest on the wall",
    "label": "motion found by simulation",
    "blow_rate": "blows per load period",
    "blow_scatter": "scatter of the blows",
    "main_blow_rate": "main blows per load period",
    "main_blow_scatter": "scatter of the main blows",
    "lyapunov": "Lyapunov exponent",
    "phases": "impact phases",
    "stall": "runs, or what keeps it from running",
    "runs": "runs with one blow a cycle",
    "starts": "starts from rest on the wall",
    "rate": "blow rate",
    "speed": "striking speed",
    "flow": "flow from the supply",
    "duty": "part of the cycle pushed",
    "multiplier": "greatest multiplier",
}


def sweep(found: Map, title: str = "", curves: Sequence[Curve] = ()) -> Figure:
    """Draw a map: every quantity over one parameter or over a plane of two.

    Parameters
    ----------
    found
        A `percuss.explore.Sweep`.
    title
        Above all panels.
    curves
        Boundaries over a plane, as `percuss.explore.boundaries` gives them, or curves of `percuss.explore.follow_point`
        over the same two parameters, drawn into every panel.

    Raises
    ------
    ParameterError
        For a map over three parameters or more.
    MissingExtraError
        When matplotlib is not installed.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import sweep
    >>> from percuss.plot import sweep as picture
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> found = sweep(system, "restitution=0:0.9:10", "load_factor=0.1:1:10", quantities=["orbits"], workers=1)
    >>> picture(found).axes[0].get_title(loc="left")
    'steady motions'
    """
    having("found", found, ("axes", "quantities", "columns", "words"), "a map, as percuss.explore.sweep gives it")
    text("title", title)
    curves = [on_plane(curve, found.axes) for curve in several("curves", curves, CURVES)]
    if len(found.axes) > 2:
        names = ", ".join(axis.name for axis in found.axes)
        raise ParameterError("axes", names, "one or two parameters for a picture", "export the map, or fix a parameter")
    flat = len(found.axes) == 2
    shown = [name for name in found.quantities if not flat or name != "phases"]
    if not shown:
        raise ParameterError("quantities", list(found.quantities), "a quantity that a plane can show: phase, for one")
    across = min(3, len(shown))
    down = math.ceil(len(shown) / across)
    figure = new_figure(1.2 + 4.3 * across, 0.9 + 3.5 * down)
    with style():
        grid = figure.add_gridspec(down, across)
        key: dict[str, Any] = {}
        for i, name in enumerate(shown):
            ax = figure.add_subplot(grid[i // across, i % across])
            if flat:
                key |= plane(figure, ax, found, name)
                key |= boundaries(ax, curves)
            else:
                key |= line(ax, found, name)
            unit = found.columns[name].unit if name in found.columns else ""
            ax.set_title(_TITLES.get(name, name) + (f" [{unit}]" if unit else ""))
        if key:
            figure.legend(key.values(), key.keys(), loc="outside lower left", ncols=6)
        titled(figure, title)
    return figure
