"""The picture of a sweep: a panel for every quantity, lines over one parameter, colours over two."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from percuss.errors import ParameterError
from percuss.plot.canvas import COLOURS, INK, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["SHADES", "sweep"]

MOST_WORDS = 12
"""Labels with a colour of their own: the most frequent; the others share one."""

SHADES = (*COLOURS, "#F0E442", "#000000", "#9900FF", "#663300", "#330099", "#00FF99")
"""Twelve colours, no two of which are near each other, whatever colour vision one has."""

_NO = "#E4E4E4"
_OTHERS = "#9A9A9A"
_RESTS = "#F0E442"
_HATCH = "#B8B8B8"  # on white: no value
_UNANSWERED = 2  # outcomes from this one on, and −1, leave a cell without a value; see percuss.explore.quantities

_TITLES = {
    "exists": "steady motion exists",
    "orbits": "steady motions",
    "phase": "impact phase",
    "reduced_stable": "stable, reduced criterion",
    "reduced_margin": "stability margin, reduced criterion",
    "stable": "stable, exact multipliers",
    "margin": "stability margin, exact multipliers",
    "reason": "stable, or why not",
    "admissible": "keeps off the wall between impacts",
    "impact_velocity": "striking speed",
    "blow_energy": "blow energy",
    "power": "percussive power",
    "rest": "can rest on the wall",
    "label": "motion found by simulation",
    "blow_rate": "blows per load period",
    "blow_scatter": "scatter of the blows",
    "main_blow_rate": "main blows per load period",
    "main_blow_scatter": "scatter of the main blows",
    "lyapunov": "Lyapunov exponent",
    "phases": "impact phases",
}
_NAMES = {"restitution": "restitution R", "load_factor": "load factor p₀/p₁", "kappa": "κ", "m": "load periods m"}


class _Axis(Protocol):
    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def values(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...


class _Map(Protocol):
    """A sweep: axes, quantities and their arrays."""

    @property
    def axes(self) -> Sequence[_Axis]: ...
    @property
    def quantities(self) -> Sequence[str]: ...
    @property
    def columns(self) -> Mapping[str, Any]: ...
    @property
    def words(self) -> Mapping[str, Sequence[str]]: ...
    def __getitem__(self, quantity: str) -> np.ndarray[Any, Any]: ...


class _Curve(Protocol):
    """A boundary: its kind and its points."""

    @property
    def kind(self) -> str: ...
    @property
    def x(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...
    @property
    def y(self) -> np.ndarray[Any, np.dtype[np.float64]]: ...


_LINES = {"fold": "-", "flip": "--", "neimark-sacker": ":", "grazing": "-."}
_KINDS = {"neimark-sacker": "Neimark–Sacker"}


def sweep(found: _Map, title: str = "", curves: Sequence[_Curve] = ()) -> Figure:
    """Draw a map: every quantity over one parameter or over a plane of two.

    Parameters
    ----------
    found
        A `percuss.explore.Sweep`.
    title
        Above all panels.
    curves
        Boundaries over a plane, as `percuss.explore.boundaries` gives them, drawn into every panel.

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
    if len(found.axes) > 2:
        names = ", ".join(axis.name for axis in found.axes)
        raise ParameterError("axes", names, "one or two parameters for a picture", "export the map, or fix a parameter")
    plane = len(found.axes) == 2
    shown = [name for name in found.quantities if not plane or name != "phases"]
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
            if plane:
                key |= _plane(figure, ax, found, name)
                key |= _boundaries(ax, curves)
            else:
                key |= _line(ax, found, name)
            unit = found.columns[name].unit if name in found.columns else ""
            ax.set_title(_TITLES.get(name, name) + (f" [{unit}]" if unit else ""))
        if key:
            figure.legend(key.values(), key.keys(), loc="outside lower left", ncols=6)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold", parse_math=False)
    return figure


def _answered(found: _Map) -> np.ndarray[Any, Any]:
    """Where the cells have values at all."""
    outcome = np.asarray(found["outcome"])
    return np.asarray((outcome >= 0) & (outcome < _UNANSWERED))


# -- axes -----------------------------------------------------------------------------------------------------------


def _named(axis: _Axis) -> str:
    name = _NAMES.get(axis.name, axis.name)
    return f"{name} [{axis.unit}]" if axis.unit else name


def _spans(values: np.ndarray[Any, Any]) -> bool:
    """Whether the values are at equal ratios rather than at equal distances."""
    if values.size < 4 or values.min() <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios[0] - 1.0) and np.ptp(np.diff(values)) > 1e-6 * np.ptp(values))


def _edges(axis: _Axis) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The borders of the cells, halfway between the values; one value has a cell of a tenth of it."""
    values = axis.values
    if values.size == 1:
        half = 0.5 if axis.name == "m" else 0.05 * abs(float(values[0])) or 0.5
        return np.array([values[0] - half, values[0] + half])
    at = np.log(values) if _spans(values) else values
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(edges) if _spans(values) else edges


def _lay_out(axis: _Axis, side: Any, limits: tuple[float, float]) -> None:
    """Scale and ticks of the x or y axis (`side`) of a panel."""
    from matplotlib.ticker import NullLocator

    side.axes.set(**{f"{side.axis_name}label": _named(axis)})
    if _spans(axis.values):
        side.axes.set(**{f"{side.axis_name}scale": "log"})
    side.axes.set(**{f"{side.axis_name}lim": limits})
    if axis.values.size == 1 or (axis.name == "m" and axis.values.size <= 12):
        ticks = axis.values.tolist()
    elif axis.name == "m":
        ticks = [tick for tick in side.get_major_locator().tick_values(*limits) if tick == round(tick)]
    elif _spans(axis.values):
        ticks = _round(*limits)
    else:
        return
    side.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
    side.set_minor_locator(NullLocator())
    side.axes.set(**{f"{side.axis_name}lim": limits})


def _round(low: float, high: float) -> list[float]:
    """Ticks for a logarithmic scale: 1, 2 and 5 times powers of ten, only those in long ranges; more in short ones."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    digits: tuple[tuple[float, ...], ...] = ((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9))
    found: list[float] = []
    for steps in digits:
        found = [tick for power in decades for digit in steps if low <= (tick := float(f"{digit}e{power}")) <= high]
        if len(found) >= 4:
            return found
    if len(found) >= 2:
        return found
    from matplotlib.ticker import MaxNLocator

    return [float(tick) for tick in MaxNLocator(4).tick_values(low, high) if low <= tick <= high]


# -- over one parameter ---------------------------------------------------------------------------------------------


def _line(ax: Axes, found: _Map, name: str) -> dict[str, Any]:
    """One panel; what its marks mean."""
    from matplotlib.ticker import MaxNLocator

    axis, values, answered = found.axes[0], found[name], _answered(found)
    x = axis.values
    dot: dict[str, Any] = {"marker": "o", "ms": 6.0 if x.size == 1 else 2.0, "color": COLOURS[0]}
    words = _words(found, name, values)
    if words is not None:
        numbers, names = words
        ax.plot(x, np.where((numbers < 0) | ~answered, np.nan, numbers), "o", ms=max(3.0, dot["ms"]), color=COLOURS[0])
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
        if _is_signed(name):
            ax.axhline(0.0, color=INK, lw=0.6)
            _window(ax, name, values)
    edges = _edges(axis)
    _lay_out(axis, ax.xaxis, (float(edges.min()), float(edges.max())))
    return _rests(ax, x, values) | _unanswered(ax, edges, answered)


def _window(ax: Axes, name: str, values: np.ndarray[Any, Any]) -> None:
    """Of margins, which have no lower end: down to −1 at the most, where some are above 0."""
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
        color=_RESTS,
        mec=INK,
        mew=0.6,
        clip_on=False,
        transform=ax.get_xaxis_transform(),
    )
    return {"−∞: comes to rest": marks[0]}


def _unanswered(ax: Axes, edges: np.ndarray[Any, Any], answered: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Hatched bands where there is no value."""
    for i in np.flatnonzero(~answered):
        ax.axvspan(edges[i], edges[i + 1], facecolor="white", edgecolor=_HATCH, hatch="////", lw=0.0, zorder=0)
    return _no_value() if not answered.all() else {}


def _no_value() -> dict[str, Any]:
    from matplotlib.patches import Patch

    return {"no value": Patch(facecolor="white", edgecolor=_HATCH, hatch="////", lw=0.4)}


# -- over two -------------------------------------------------------------------------------------------------------


def _plane(figure: Figure, ax: Axes, found: _Map, name: str) -> dict[str, Any]:
    """One panel; what its marks mean."""
    values, answered = found[name], _answered(found)
    x, y = (_edges(axis) for axis in found.axes)
    words = _words(found, name, values)
    key: dict[str, Any] = {}
    if words is not None:
        places, names = words
        shown = np.ma.masked_where((places < 0) | ~answered, places)
        colours = [SHADES[i % len(SHADES)] if word != "others" else _OTHERS for i, word in enumerate(names)]
        _patches(ax, x, y, shown, colours, names)
    elif values.dtype == bool:
        shown = np.ma.masked_where(~answered, values.astype(int))
        _patches(ax, x, y, shown, [_NO, COLOURS[0]], ["no", "yes"])
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
        _lay_out(axis, side, (float(edges.min()), float(edges.max())))
    if np.any(np.ma.getmaskarray(shown)):
        ax.patch.set(facecolor="white", edgecolor=_HATCH, hatch="////", linewidth=0.0)
        key |= _no_value()
    return key


def _is_signed(name: str) -> bool:
    return "margin" in name or name == "lyapunov"


def _shaded(figure: Figure, ax: Axes, x: Any, y: Any, shown: Any, name: str) -> None:
    """Numbers in shades, with the bar that says what they mean."""
    from matplotlib.colors import LogNorm

    if not shown.count():
        return
    options: dict[str, Any] = {"cmap": "viridis"}
    bar: dict[str, Any] = {}
    if _is_signed(name):
        options, bar = _signed(shown.compressed(), name)
    elif "phase" in name:
        options = {"cmap": "twilight", "vmin": 0.0, "vmax": 2.0 * math.pi}
        bar = {"ticks": [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi, 2.0 * math.pi]}
    elif 0.0 < 30.0 * shown.min() < shown.max():
        options["norm"] = LogNorm()
        bar = {"ticks": _round(float(shown.min()), float(shown.max())), "format": "%g"}
    made = figure.colorbar(_mesh(ax, x, y, shown, **options), ax=ax, pad=0.01, **bar)
    made.minorticks_off()
    if "phase" in name and not _is_signed(name):
        made.set_ticklabels(["0", "π/2", "π", "3π/2", "2π"])


def _signed(values: np.ndarray[Any, Any], name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Red where unstable, blue where stable, each side by its own greatest value but not beyond 1."""
    from matplotlib.colors import TwoSlopeNorm

    low, high = float(-values.min()), float(values.max())
    below, above = (min(1.0, reach) if reach > 1e-12 else 0.0 for reach in (low, high))
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    below, above = below or above or 1.0, above or below or 1.0
    options = {"cmap": "RdBu" if "margin" in name else "RdBu_r", "norm": TwoSlopeNorm(0.0, -below, above)}
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

    _mesh(ax, x, y, np.ma.masked_where(~here, np.zeros(here.shape)), cmap=ListedColormap([_RESTS]))
    return {"−∞: comes to rest": Patch(facecolor=_RESTS, edgecolor=INK, lw=0.4)}


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


def _boundaries(ax: Axes, curves: Sequence[_Curve]) -> dict[str, Any]:
    """Curves with a white rim; the lines of their kinds."""
    from matplotlib.lines import Line2D

    limits = ax.get_xlim(), ax.get_ylim()
    key: dict[str, Any] = {}
    for curve in curves:
        line = _LINES.get(curve.kind, "-")
        ax.plot(curve.x, curve.y, line, color="white", lw=2.6)
        ax.plot(curve.x, curve.y, line, color=INK, lw=1.1)
        key[_KINDS.get(curve.kind, curve.kind)] = Line2D([], [], color=INK, lw=1.1, ls=line)
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])
    return key


# -- words ----------------------------------------------------------------------------------------------------------


def _words(found: _Map, name: str, values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], list[str]] | None:
    """Numbers of words and the words, for labels and what is kept as numbers of words; −1 where there is nothing."""
    if name in found.words:
        words = list(found.words[name])
        present = [i for i in range(len(words)) if np.any(values == i)]
        numbers = np.full(values.shape, -1)
        for at, i in enumerate(present):
            numbers[values == i] = at
        return numbers, [words[i] for i in present]
    if values.dtype.kind != "U":
        return None
    kinds, counts = np.unique(values, return_counts=True)
    ordered = [kind for kind in kinds[np.argsort(-counts, kind="stable")].tolist() if kind]
    names = sorted(ordered[:MOST_WORDS], key=_order)
    numbers = np.full(values.shape, -1)
    for at, kind in enumerate(names):
        numbers[values == kind] = at
    if len(ordered) > MOST_WORDS:
        numbers[(numbers < 0) & (values != "")] = len(names)
        names.append("others")
    return numbers, names


def _order(label: str) -> tuple[int, str, int, int]:
    """Periodic motions by p and n first, then those with rest, then the others."""
    head, _, tail = label.partition("=" if label.startswith("z=") else "/")
    p, _, n = tail.partition("/")
    first, second = (int(part) if part.isdecimal() else 0 for part in (p, n))
    return ("z", "rest", "chatter").index(head) if head in ("z", "rest", "chatter") else 9, head, first, second
