"""A panel of a map over a plane of two parameters, and the boundaries drawn into it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss import palette
from percuss.errors import ParameterError
from percuss.model.checks import having
from percuss.plot.canvas import COLOURS, INK, ramp
from percuss.plot.map_axes import answered_cells, cell_edges, is_signed, lay_out, round_ticks
from percuss.plot.map_families import families, is_motions
from percuss.plot.map_line import RESTS
from percuss.plot.map_words import HATCH, no_value, words_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.plot.map_axes import Axis, Curve, Map

__all__ = ["CURVES", "boundaries", "on_plane", "plane"]

CURVES = "curves, as percuss.explore.boundaries and percuss.explore.follow_point give them"

SHADES = palette.AREAS
_NO = palette.VERDICTS["none"].light
_STABLE = ("stable", "reduced_stable")
_OTHERS = "#9A9A9A"
_LINES: dict[str, Any] = {
    "fold": "-", "flip": "--", "neimark-sacker": ":", "grazing": "-.", "grazing_touch": "-.",
    "grazing_impact_dies": (0, (5, 1, 1, 1, 1, 1)), "corner": (0, (8, 2)), "neimark_sacker": ":",
}  # fmt: skip
_KINDS = {
    "neimark-sacker": "Neimark–Sacker", "neimark_sacker": "Neimark–Sacker", "grazing_touch": "touch",
    "grazing_impact_dies": "impact dies",
}  # fmt: skip


def plane(figure: Figure, ax: Axes, found: Map, name: str) -> dict[str, Any]:
    """One panel; what its marks mean."""
    values, answered = found[name], answered_cells(found)
    x, y = (cell_edges(axis) for axis in found.axes)
    key: dict[str, Any] = {}
    words = None if is_motions(name) else words_of(found, name, values)
    if is_motions(name):
        shown = families(ax, x, y, values, answered)
    elif words is not None:
        places, names = words
        shown = np.ma.masked_where((places < 0) | ~answered, places)
        colours = [SHADES[i % len(SHADES)] if word != "others" else _OTHERS for i, word in enumerate(names)]
        _patches(ax, x, y, shown, colours, names)
    elif values.dtype == bool:
        shown = np.ma.masked_where(~answered, values.astype(int))
        yes = palette.VERDICTS["stable"].light if name in _STABLE else COLOURS[0]
        _patches(ax, x, y, shown, [_NO, yes], ["no", "yes"])
    elif values.dtype.kind in "iu":
        here = (values >= 0) & answered
        present = np.unique(values[here])
        shown = np.ma.masked_where(~here, np.searchsorted(present, values))
        colours = [SHADES[number % len(SHADES) - 1] if number else _NO for number in present.tolist()]
        _patches(ax, x, y, shown, colours, [str(number) for number in present.tolist()])
    else:
        shown = np.ma.masked_invalid(values)
        _shaded(figure, ax, x, y, shown, name)
        if np.isneginf(values).any():
            key |= _resting(ax, x, y, np.isneginf(values))
            shown = np.ma.masked_where(np.isnan(values), values)
    for axis, side, edges in zip(found.axes, (ax.xaxis, ax.yaxis), (x, y), strict=True):
        lay_out(axis, side, (float(edges.min()), float(edges.max())))
    if np.any(np.ma.getmaskarray(shown)):
        ax.patch.set(facecolor="white", edgecolor=HATCH, hatch="////", linewidth=0.0)
        key |= no_value()
    return key


def _shaded(figure: Figure, ax: Axes, x: Any, y: Any, shown: Any, name: str) -> None:
    """Numbers in shades, with the bar that says what they mean."""
    from matplotlib.colors import LogNorm

    if not shown.count():
        return
    options: dict[str, Any] = {"cmap": ramp(palette.SHARES)}
    bar: dict[str, Any] = {}
    if is_signed(name):
        options, bar = _signed(shown.compressed(), name)
    elif "phase" in name:
        options = {"cmap": "twilight", "vmin": 0.0, "vmax": 2.0 * math.pi}
        bar = {"ticks": [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi, 2.0 * math.pi]}
    elif 0.0 < 30.0 * shown.min() < shown.max():
        options["norm"] = LogNorm()
        bar = {"ticks": round_ticks(float(shown.min()), float(shown.max())), "format": "%g"}
    made = figure.colorbar(_mesh(ax, x, y, shown, **options), ax=ax, pad=0.01, **bar)
    made.minorticks_off()
    if "phase" in name and not is_signed(name):
        made.set_ticklabels(["0", "π/2", "π", "3π/2", "2π"])


def _signed(values: np.ndarray[Any, Any], name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Orange where unstable, green where stable, each side by its own greatest value but not beyond 1."""
    from matplotlib.colors import TwoSlopeNorm

    low, high = float(-values.min()), float(values.max())
    below, above = (min(1.0, reach) if reach > 1e-12 else 0.0 for reach in (low, high))
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    below, above = below or above or 1.0, above or below or 1.0
    stops = palette.STABILITY if "margin" in name else palette.STABILITY[::-1]
    options = {"cmap": ramp(stops), "norm": TwoSlopeNorm(0.0, -below, above)}
    return options, {"extend": ends[low > below, high > above], "ticks": _about_zero(below, above)}


def _about_zero(below: float, above: float) -> list[float]:
    """Ticks of a scale with 0 in its middle and an end of its own on either side."""
    from matplotlib.ticker import MaxNLocator

    low, high = (MaxNLocator(4).tick_values(0.0, end) for end in (below, above))
    return [*(-float(t) for t in low[::-1] if 0.0 < t <= below), 0.0, *(float(t) for t in high if 0.0 < t <= above)]


def _resting(ax: Axes, x: Any, y: Any, here: Any) -> dict[str, Any]:
    """The cells whose value is −∞, in a colour of their own."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    _mesh(ax, x, y, np.ma.masked_where(~here, np.zeros(here.shape)), cmap=ListedColormap([RESTS]))
    return {"−∞: comes to rest": Patch(facecolor=RESTS, edgecolor=INK, lw=0.4)}


def _patches(ax: Axes, x: Any, y: Any, shown: Any, colours: Sequence[str], names: Sequence[str]) -> None:
    """Numbers of kinds in their colours, with a legend beside the panel."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    if not names:
        return
    _mesh(ax, x, y, shown, cmap=ListedColormap(list(colours)), vmin=-0.5, vmax=len(names) - 0.5)
    handles = [Patch(facecolor=c, edgecolor=INK, lw=0.4, label=name) for c, name in zip(colours, names, strict=True)]
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3)


def _mesh(ax: Axes, x: Any, y: Any, values: Any, **options: Any) -> Any:
    return ax.pcolormesh(x, y, values.T, shading="flat", rasterized=True, **options)


class _Laid(NamedTuple):
    kind: str
    x: np.ndarray[Any, np.dtype[np.float64]]
    y: np.ndarray[Any, np.dtype[np.float64]]


def on_plane(curve: Any, axes: Sequence[Axis]) -> Curve:
    """A curve as it lies in the plane of two axes; one that says its parameters whatever their order.

    Raises
    ------
    ParameterError
        For a curve over other parameters, or in other units.
    """
    if not hasattr(curve, "parameters"):
        having("curves", curve, ("kind", "x", "y"), CURVES)
        laid: Curve = curve
        return laid
    having("curves", curve, ("kind", "units", "real"), CURVES)
    known = dict(zip(zip(curve.parameters, curve.units, strict=True), curve.real.T, strict=True))
    try:
        x, y = (known[axis.name, axis.unit] for axis in axes)
    except (KeyError, ValueError):
        told = " and ".join(f"{axis.name} [{axis.unit}]" if axis.unit else axis.name for axis in axes)
        raise ParameterError("curves", ", ".join(curve.parameters), f"curves over {told}") from None
    return _Laid(curve.kind, x, y)


def boundaries(ax: Axes, curves: Sequence[Curve]) -> dict[str, Any]:
    """Curves with a white rim; the lines of their kinds."""
    from matplotlib.lines import Line2D

    limits = ax.get_xlim(), ax.get_ylim()
    key: dict[str, Any] = {}
    for curve in curves:
        line = _LINES.get(curve.kind, "-")
        ax.plot(curve.x, curve.y, ls=line, color="white", lw=2.6)
        ax.plot(curve.x, curve.y, ls=line, color=INK, lw=1.1)
        key[_KINDS.get(curve.kind, curve.kind)] = Line2D([], [], color=INK, lw=1.1, ls=line)
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])
    return key
