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

__all__ = ["sweep"]

MOST_WORDS = 12
"""Labels with a colour of their own: the most frequent; the others share one."""

_NOTHING = "#F2F2F2"
_OTHERS = "#9A9A9A"
_SHADES = (*COLOURS, "#F0E442", "#4D4D4D", "#88CCEE", "#882255", "#117733", "#DDCC77")

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
    shown = [name for name in found.quantities if len(found.axes) == 1 or name != "phases"]
    if not shown:
        raise ParameterError("quantities", list(found.quantities), "a quantity that a plane can show: phase, for one")
    across = min(3, len(shown))
    down = math.ceil(len(shown) / across)
    figure = new_figure(1.2 + 4.3 * across, 0.6 + 3.5 * down)
    with style():
        grid = figure.add_gridspec(down, across)
        for i, name in enumerate(shown):
            ax = figure.add_subplot(grid[i // across, i % across])
            (_line if len(found.axes) == 1 else _plane)(figure, ax, found, name)
            unit = found.columns[name].unit if name in found.columns else ""
            ax.set_title(_TITLES.get(name, name) + (f" [{unit}]" if unit else ""))
            ax.set_xlabel(_named(found.axes[0]))
            if len(found.axes) == 2:
                ax.set_ylabel(_named(found.axes[1]))
                _boundaries(ax, curves)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=11, fontweight="bold")
    return figure


def _named(axis: _Axis) -> str:
    name = _NAMES.get(axis.name, axis.name)
    return f"{name} [{axis.unit}]" if axis.unit else name


def _spans(values: np.ndarray[Any, Any]) -> bool:
    """Whether the values are at equal ratios rather than at equal distances."""
    if values.size < 4 or values.min() <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios[0] - 1.0) and np.ptp(np.diff(values)) > 1e-6 * np.ptp(values))


def _boundaries(ax: Axes, curves: Sequence[_Curve]) -> None:
    limits = ax.get_xlim(), ax.get_ylim()
    for curve in curves:
        ax.plot(curve.x, curve.y, _LINES.get(curve.kind, "-"), color="white", lw=2.6)
        ax.plot(curve.x, curve.y, _LINES.get(curve.kind, "-"), color=INK, lw=1.1)
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])


# -- over one parameter ---------------------------------------------------------------------------------------------


def _line(_: Figure, ax: Axes, found: _Map, name: str) -> None:
    from matplotlib.ticker import MaxNLocator

    x, values = found.axes[0].values, found[name]
    if _spans(x):
        ax.set_xscale("log")
    words = _words(found, name, values)
    if words is not None:
        numbers, names = words
        ax.plot(x, np.where(numbers < 0, np.nan, numbers), "o", ms=3.0, color=COLOURS[0])
        ax.set_yticks(range(len(names)), names)
    elif values.dtype == bool:
        ax.step(x, values.astype(float), where="mid", color=COLOURS[0])
        ax.set_yticks([0.0, 1.0], ["no", "yes"])
        ax.set_ylim(-0.2, 1.2)
    elif values.ndim == 2:
        ax.plot(x, values, ".", ms=3.0, color=COLOURS[0])
    elif values.dtype.kind in "iu":
        ax.step(x, np.where(values < 0, np.nan, values), where="mid", color=COLOURS[0])
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    else:
        ax.plot(x, np.where(np.isfinite(values), values, np.nan), color=COLOURS[0], marker=".", ms=3.0)
        if "margin" in name or name == "lyapunov":
            ax.axhline(0.0, color=INK, lw=0.6)


# -- over two -------------------------------------------------------------------------------------------------------


def _plane(figure: Figure, ax: Axes, found: _Map, name: str) -> None:
    from matplotlib.colors import ListedColormap, LogNorm, TwoSlopeNorm

    x, y, values = found.axes[0].values, found.axes[1].values, found[name]
    ax.set_xscale("log" if _spans(x) else "linear")
    ax.set_yscale("log" if _spans(y) else "linear")
    ax.set_facecolor(_NOTHING)
    words = _words(found, name, values)
    if words is not None:
        places, names = words
        colours = [_SHADES[i % len(_SHADES)] if word != "others" else _OTHERS for i, word in enumerate(names)]
        _mesh(ax, x, y, np.ma.masked_less(places, 0), cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) - 0.5)
        _legend(ax, colours, names)
    elif values.dtype == bool:
        _mesh(ax, x, y, values.astype(float), cmap=ListedColormap([_NOTHING, COLOURS[0]]), vmin=0.0, vmax=1.0)
        _legend(ax, [COLOURS[0], _NOTHING], ["yes", "no"])
    elif values.dtype.kind in "iu":
        present = [int(number) for number in np.unique(values) if number >= 0]
        colours = [_SHADES[number % len(_SHADES) - 1] if number else _NOTHING for number in present] or [_NOTHING]
        places = np.searchsorted(present, values) if present else np.zeros(values.shape)
        shown = np.ma.masked_where(values < 0, places)
        _mesh(ax, x, y, shown, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(colours) - 0.5)
        _legend(ax, colours[: len(present)], [str(number) for number in present])
    else:
        shown = np.ma.masked_invalid(values)
        if ("margin" in name or name == "lyapunov") and shown.count() and shown.min() < 0.0 < shown.max():
            reach = float(np.quantile(np.abs(shown.compressed()), 0.98))
            mesh = _mesh(ax, x, y, shown, cmap="RdBu", norm=TwoSlopeNorm(0.0, -max(reach, 1e-12), max(reach, 1e-12)))
        elif "phase" in name:
            mesh = _mesh(ax, x, y, shown, cmap="twilight", vmin=0.0, vmax=2.0 * math.pi)
        elif shown.count() and 0.0 < 30.0 * shown.min() < shown.max():
            mesh = _mesh(ax, x, y, shown, cmap="viridis", norm=LogNorm())
        else:
            mesh = _mesh(ax, x, y, shown, cmap="viridis")
        figure.colorbar(mesh, ax=ax, pad=0.01)


def _mesh(ax: Axes, x: Any, y: Any, values: Any, **options: Any) -> Any:
    return ax.pcolormesh(x, y, values.T, shading="nearest", rasterized=True, **options)


def _legend(ax: Axes, colours: Sequence[str], names: Sequence[str]) -> None:
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=c, edgecolor=INK, lw=0.4, label=name) for c, name in zip(colours, names, strict=True)]
    ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3)


def _words(found: _Map, name: str, values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], list[str]] | None:
    """Numbers of words and the words, for labels and what is kept as numbers of words; −1 where there is nothing."""
    if name in found.words:
        words = list(found.words[name])
        present = [i for i in range(len(words)) if np.any(values == i)]
        numbers = np.full(values.shape, -1)
        for at, i in enumerate(present):
            numbers[values == i] = at
        return numbers, [words[i] for i in present] or ["nothing"]
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
    return numbers, names or ["nothing"]


def _order(label: str) -> tuple[int, str, int, int]:
    """Periodic motions by p and n first, then those with rest, then the others."""
    head, _, tail = label.partition("=" if label.startswith("z=") else "/")
    p, _, n = tail.partition("/")
    first, second = (int(part) if part.isdecimal() else 0 for part in (p, n))
    return ("z", "rest", "chatter").index(head) if head in ("z", "rest", "chatter") else 9, head, first, second
