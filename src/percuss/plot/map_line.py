"""A panel of a map over one parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.plot.canvas import COLOURS, INK
from percuss.plot.map_axes import answered_cells, cell_edges, is_signed, lay_out
from percuss.plot.map_families import family_numbers, is_motions
from percuss.plot.map_words import HATCH, no_value, words_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from percuss.plot.map_axes import Map

__all__ = ["RESTS", "line"]

RESTS = palette.BOTH["rest"]
"""Of what comes to rest."""


def line(ax: Axes, found: Map, name: str) -> dict[str, Any]:
    """One panel; what its marks mean."""
    from matplotlib.ticker import MaxNLocator

    axis, values, answered = found.axes[0], found[name], answered_cells(found)
    x = axis.values
    dot: dict[str, Any] = {"marker": "o", "ms": 6.0 if x.size == 1 else 2.0, "color": COLOURS[0]}
    words = words_of(found, name, values)
    if words is not None:
        numbers, names = words
        seen = np.where((numbers < 0) | ~answered, np.nan, numbers)
        for colour, here in _in_colours(name, values):
            ax.plot(x[here], seen[here], "o", ms=max(3.0, dot["ms"]), color=colour)
        ax.set_yticks(range(len(names)), names)
    elif values.dtype == bool:
        ax.step(x, np.where(answered, values.astype(float), np.nan), where="mid", **dot)
        ax.set_yticks([0.0, 1.0], ["no", "yes"])
        ax.set_ylim(-0.2, 1.2)
    elif values.ndim == 2:
        ax.plot(x, values, ls="", **dot)
    elif values.dtype.kind in "iu":
        ax.step(x, np.where((values < 0) | ~answered, np.nan, values), where="mid", **dot)
        ax.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    else:
        ax.plot(x, np.where(np.isfinite(values), values, np.nan), **dot)
        if is_signed(name):
            ax.axhline(0.0, color=INK, lw=0.6)
            _window(ax, name, values)
    edges = cell_edges(axis)
    lay_out(axis, ax.xaxis, (float(edges.min()), float(edges.max())))
    return _rests(ax, x, values) | _unanswered(ax, edges, answered)


def _in_colours(name: str, values: np.ndarray[Any, Any]) -> list[tuple[str, Any]]:
    """Which points have which colour: found motions that of their family."""
    if not is_motions(name):
        return [(COLOURS[0], slice(None))]
    numbers = family_numbers(values)
    return [(palette.FAMILIES[i].colour.light, numbers == i) for i in np.unique(numbers[numbers >= 0])]


def _window(ax: Axes, name: str, values: np.ndarray[Any, Any]) -> None:
    """Set the window of a panel of margins, which have no lower end: down to −1 at the most where some are above 0."""
    low = float(np.min(values[np.isfinite(values)], initial=0.0))
    if "margin" in name and low < -1.0 and np.any(values > -1.0):
        ax.set_ylim(-1.05, max(0.1, 1.08 * float(np.nanmax(values))))
        ax.text(1.0, 0.02, f"down to −{-low:.2g}", transform=ax.transAxes, ha="right", va="bottom", fontsize=7.5)


def _rests(ax: Axes, x: np.ndarray[Any, Any], values: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Marks at the foot of the panel where the value is −∞."""
    if values.dtype.kind != "f" or not np.isneginf(values).any():
        return {}
    here = x[np.isneginf(values)] if values.ndim == 1 else x[np.isneginf(values).any(axis=1)]
    marks = ax.plot(
        here,
        np.full(here.size, 0.03),
        "v",
        ms=6.0,
        color=RESTS,
        mec=INK,
        mew=0.6,
        clip_on=False,
        transform=ax.get_xaxis_transform(),
    )
    return {"−∞: comes to rest": marks[0]}


def _unanswered(ax: Axes, edges: np.ndarray[Any, Any], answered: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Hatched bands where there is no value."""
    for i in np.flatnonzero(~answered):
        ax.axvspan(edges[i], edges[i + 1], facecolor="white", edgecolor=HATCH, hatch="////", lw=0.0, zorder=0)
    return no_value() if not answered.all() else {}
