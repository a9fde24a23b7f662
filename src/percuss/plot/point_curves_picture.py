"""The picture of curves over two parameters: folds, flips, grazings …, and the points of codimension two on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.parameters import label_of
from percuss.model.checks import having, several, text
from percuss.plot.canvas import COLOURS, INK, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import PointCurve, RestPointCurve

__all__ = ["curves"]

_ENDS = ("limit", "parameter_end", "stopped", "closed", "lost", "load_stops_pushing")
_WORDS = {
    "grazing_touch": "touch", "grazing_impact_dies": "dying impact", "neimark_sacker": "Neimark–Sacker points",
}  # fmt: skip
_MARKS = "sD^vPX*op<>h"


def curves(found: Sequence[PointCurve | RestPointCurve], title: str = "") -> Figure:
    """Draw curves of `percuss.explore.follow_point` over their two parameters; thin and dotted where no orbit is.

    Parameters
    ----------
    found
        The curves, all of them over the same two parameters.
    title
        What stands above.

    Raises
    ------
    ParameterError
        When there are none, or over different parameters.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import BranchEvent, follow, follow_point
    >>> from percuss.steady import orbit_near
    >>> system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.65, 1.0))
    >>> branch = follow(orbit_near(system, [0.35, 2.2], modes=0), "mean", (0.64, 0.7))
    >>> flip, = branch.at(BranchEvent.FLIP)
    >>> len(curves([follow_point(flip, ("restitution", "mean"), ((0.49, 0.51), (0.5, 0.8)))]).axes)
    1
    """
    kept = several("found", found, "curves of percuss.explore.follow_point")
    for one in kept:
        having("found", one, ("event", "parameters", "values", "is_orbit"), "curves of percuss.explore.follow_point")
    if not kept or len({(one.parameters, one.units) for one in kept}) > 1:
        raise ParameterError("found", str(len(kept)), "one curve or more, all over the same two parameters")
    text("title", title, "a text")
    with style():
        figure = new_figure(6.4, 4.8)
        ax = figure.subplots()
        kinds = list(dict.fromkeys((one.event.value, one.label) for one in kept))
        for one in kept:
            _line(ax, one, COLOURS[kinds.index((one.event.value, one.label)) % len(COLOURS)])
        _marked(ax, kept)
        for name, unit, side in zip(kept[0].parameters, kept[0].units, "xy", strict=True):
            ax.set(**{f"{side}label": f"{label_of(name)} [{unit}]" if unit else label_of(name)})
        handles, labels = ax.get_legend_handles_labels()
        shown = dict(zip(labels, handles, strict=True))
        figure.legend(shown.values(), shown.keys(), loc="outside lower left", ncols=3)
        titled(figure, title)
    return figure


def _line(ax: Axes, one: PointCurve | RestPointCurve, colour: str) -> None:
    name = f"{_WORDS.get(one.event.value, one.event.value)} of {one.label}"
    ax.plot(*one.values.T, ":", color=colour, lw=0.8)
    ax.plot(*one.real.T, "-", color=colour, lw=1.4, label=name)


def _marked(ax: Axes, found: Sequence[PointCurve | RestPointCurve]) -> None:
    marks: dict[str, Any] = {}
    for one in found:
        for point in one.points:
            word = point.kind.value
            if word in _ENDS:
                continue
            mark = marks.setdefault(word, _MARKS[len(marks) % len(_MARKS)])
            place = np.array(point.values)[:, None]
            ax.plot(*place, mark, color=INK, ms=4.5, ls="", label=word.replace("_", " "))
