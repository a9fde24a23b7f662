"""Pictures of sweeps, a panel for every quantity, lines over one parameter, colours over two; and of many starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss import palette
from percuss.errors import ParameterError
from percuss.explore.parameters import label_of
from percuss.model.checks import having, several, text
from percuss.palette import FAMILIES, family_of
from percuss.plot.canvas import COLOURS, INK, canvas, patches_beside, ramp
from percuss.steady.figures import FIGURES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from percuss.explore import Axis, Basins, Experiment, Sweep
    from percuss.explore.attractors.experiments import Share
    from percuss.explore.boundary_curves.boundary import BoundaryCurve
    from percuss.model import Machine, System


# ---- What a map hands to its pictures, and the axes of their panels

_UNANSWERED = 2  # outcomes from this one on, and −1, leave a cell without a value; see percuss.explore.quantities


def answered_cells(found: Sweep) -> np.ndarray[Any, Any]:
    outcome = np.asarray(found["outcome"])
    return np.asarray((outcome >= 0) & (outcome < _UNANSWERED))


def is_signed(name: str) -> bool:
    return "margin" in name or name == "lyapunov"


def _named(axis: Axis) -> str:
    name = label_of(axis.name)
    return f"{name} [{axis.unit}]" if axis.unit else name


def _spans(values: np.ndarray[Any, Any]) -> bool:
    """Whether the values are at equal ratios rather than at equal distances."""
    if values.size < 4 or values.min() <= 0.0:
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-6 * abs(ratios[0] - 1.0) and np.ptp(np.diff(values)) > 1e-6 * np.ptp(values))


def cell_edges(axis: Axis) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The borders of the cells, halfway between the values; one value has a cell of a tenth of it."""
    values = axis.values
    if values.size == 1:
        half = 0.5 if axis.name == "m" else 0.05 * abs(float(values[0])) or 0.5
        return np.array([values[0] - half, values[0] + half])
    at = np.log(values) if _spans(values) else values
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2.0 * at[0] - middle[0]], middle, [2.0 * at[-1] - middle[-1]]])
    return np.exp(edges) if _spans(values) else edges


def lay_out(axis: Axis, side: Any, limits: tuple[float, float]) -> None:
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
        ticks = round_ticks(*limits)
    else:
        return
    side.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
    side.set_minor_locator(NullLocator())
    side.axes.set(**{f"{side.axis_name}lim": limits})


def round_ticks(low: float, high: float) -> list[float]:
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


# ---- Found motions in a map: the seven families, each always in its own colour and hatch

_HATCH_COLOUR = "#ffffff"


def is_motions(name: str) -> bool:
    """Whether a quantity is the label of a motion that was found."""
    return name == "label"


def family_numbers(labels: np.ndarray[Any, Any]) -> npt.NDArray[np.int64]:
    """The number of the family of every label; −1 where there is none."""
    kinds, where = np.unique(labels, return_inverse=True)
    numbers = np.array([family_of(str(kind)) if kind else -1 for kind in kinds], dtype=np.int64)
    return numbers[where].reshape(labels.shape)


def families(ax: Axes, x: Any, y: Any, labels: np.ndarray[Any, Any], answered: Any) -> Any:
    """Cells (edges x and y) in the colours and hatches of their families, with a legend; "" for no label."""
    from matplotlib.colors import ListedColormap

    numbers = family_numbers(labels)
    shown = np.ma.masked_where((numbers < 0) | ~answered, numbers)
    colours = ListedColormap([family.colour.light for family in FAMILIES])
    top = len(FAMILIES) - 0.5
    ax.pcolormesh(x, y, shown.T, shading="flat", rasterized=True, cmap=colours, vmin=-0.5, vmax=top)
    looks = []
    for i in np.unique(shown.compressed()).tolist():
        family = FAMILIES[i]
        look = {"facecolor": family.colour.light, "edgecolor": _HATCH_COLOUR, "hatch": 4 * family.hatch, "lw": 0.0}
        looks.append(look | {"label": family.name})
        if family.hatch:
            _hatched(ax, x, y, (shown == i).filled(False), 2 * family.hatch)
    patches_beside(ax, looks)
    return shown


def _hatched(ax: Axes, x: Any, y: Any, here: Any, hatch: str) -> None:
    """One patch of all the cells, so that its lines go on from cell to cell; runs of cells are one rectangle."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    corners = []
    for j in range(here.shape[1]):
        ends = np.flatnonzero(np.diff(np.concatenate([[False], here[:, j], [False]]).astype(int)))
        for first, last in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
            left, right, low, high = x[first], x[last], y[j], y[j + 1]
            corners.append([(left, low), (right, low), (right, high), (left, high), (left, low)])
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * len(corners)
    path = Path(np.array(corners, dtype=float).reshape(-1, 2), codes)
    ax.add_patch(PathPatch(path, facecolor="none", edgecolor=_HATCH_COLOUR, hatch=hatch, lw=0.0))


# ---- Words in the cells of a map: which there are, in which order, and what stands where there is none

MOST_WORDS = 12  # labels with a colour of their own: the most frequent; the others share one

HATCH = palette.BOTH["none"]  # on white: no value


def no_value() -> dict[str, Any]:
    from matplotlib.patches import Patch

    return {"no value": Patch(facecolor="white", edgecolor=HATCH, hatch="////", lw=0.4)}


def words_of(found: Sweep, name: str, values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], list[str]] | None:
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


# ---- A panel of a map over one parameter

RESTS = palette.BOTH["rest"]  # of what comes to rest


def line(ax: Axes, found: Sweep, name: str) -> dict[str, Any]:
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


# ---- A panel of a map over a plane of two parameters, and the boundaries drawn into it

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


def plane(figure: Figure, ax: Axes, found: Sweep, name: str) -> dict[str, Any]:
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

    if not names:
        return
    _mesh(ax, x, y, shown, cmap=ListedColormap(list(colours)), vmin=-0.5, vmax=len(names) - 0.5)
    patches_beside(ax, [{"facecolor": c, "label": name} for c, name in zip(colours, names, strict=True)])


def _mesh(ax: Axes, x: Any, y: Any, values: Any, **options: Any) -> Any:
    return ax.pcolormesh(x, y, values.T, shading="flat", rasterized=True, **options)


class _Laid(NamedTuple):
    kind: str
    x: np.ndarray[Any, np.dtype[np.float64]]
    y: np.ndarray[Any, np.dtype[np.float64]]


def on_plane(curve: Any, axes: Sequence[Axis]) -> BoundaryCurve | _Laid:
    """A curve as it lies in the plane of two axes; one that says its parameters whatever their order."""
    if not hasattr(curve, "parameters"):
        having("curves", curve, ("kind", "x", "y"), CURVES)
        laid: BoundaryCurve | _Laid = curve
        return laid
    having("curves", curve, ("kind", "units", "real"), CURVES)
    known = dict(zip(zip(curve.parameters, curve.units, strict=True), curve.real.T, strict=True))
    try:
        x, y = (known[axis.name, axis.unit] for axis in axes)
    except (KeyError, ValueError):
        told = " and ".join(f"{axis.name} [{axis.unit}]" if axis.unit else axis.name for axis in axes)
        raise ParameterError("curves", ", ".join(curve.parameters), f"curves over {told}") from None
    return _Laid(curve.kind, x, y)


def boundaries(ax: Axes, curves: Sequence[BoundaryCurve | _Laid]) -> dict[str, Any]:
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


# ---- The picture of a sweep: a panel for every quantity, lines over one parameter, colours over two

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


def sweep(found: Sweep, title: str = "", curves: Sequence[Any] = ()) -> Figure:
    """Draw a map: every quantity over one parameter or over a plane of two.

    Parameters
    ----------
    curves
        Boundaries over a plane, as `percuss.explore.boundaries` gives them, or curves of `percuss.explore.follow_point`
        over the same two parameters, drawn into every panel.

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
    with canvas(1.2 + 4.3 * across, 0.9 + 3.5 * down, text("title", title)) as figure:
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
    return figure


# ---- The pictures of where starts end: the shares of an experiment, and basins of attraction as an image

MOST_SHOWN = 10  # attractors with a line or a colour of their own: the most frequent
MOST_POINTS = 20_000  # starts drawn; of more an even choice
_REST = "#B5B5B5"
_NAMES = {
    "time": "load phase of the start [rad]",
    "velocity": "velocity of the start",
    "position": "position of the start [bar lengths]",
}
_SI_NAMES = {
    "time": "time of the start, from the beginning of a load period [ms]",
    "velocity": "velocity of the start [m/s]",
    "position": "position of the start [mm]",
}


def experiment(found: Experiment, title: str = "") -> Figure:
    """Draw an experiment: the shares of the attractors with their intervals, and the starts in their colours.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import experiment
    >>> from percuss.plot import experiment as picture
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> len(picture(experiment(system, 200, modes=0, workers=1)).axes)
    2
    """
    having("found", found, ("shares", "attractor", "columns"), "what percuss.explore.experiment gives")
    with canvas(10.5, 4.4, text("title", title)) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
        _bars(left, found.shares)
        _scatter(right, found)
    return figure


def basins(found: Basins, title: str = "") -> Figure:
    """Draw basins of attraction as an image: each start in the colour of the attractor that it leads to.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import basins
    >>> from percuss.plot import basins as picture
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    >>> found = basins(system, ("time", 0.0, 6.2, 16), ("velocity", -6.0, -0.1, 10), modes=0, workers=1)
    >>> picture(found).axes[0].get_xlabel()
    'load phase of the start [rad]'
    """
    from matplotlib.colors import ListedColormap

    having("found", found, ("shares", "image", "x", "y"), "what percuss.explore.basins gives")
    with canvas(7.5, 5.0, text("title", title)) as figure:
        ax = figure.add_subplot()
        ax.set_facecolor("white")
        n = min(len(found.shares), MOST_SHOWN)
        image = np.ma.masked_less(np.minimum(found.image, MOST_SHOWN), 0)
        colours = [_colour(i) for i in range(MOST_SHOWN + 1)]
        (x, x_name), (y, y_name) = (_axis(name, values, found.system) for name, values in (found.x, found.y))
        ax.pcolormesh(
            x, y, image, shading="nearest", cmap=ListedColormap(colours), vmin=-0.5,
            vmax=MOST_SHOWN + 0.5, rasterized=True,
        )  # fmt: skip
        ax.set(xlabel=x_name, ylabel=y_name)
        looks = [{"facecolor": _colour(i), "label": _name(found.shares, i)} for i in range(n)]
        others = len(found.shares) - n
        patches_beside(ax, [*looks, {"facecolor": _REST, "label": f"{others} others"}] if others else looks)
    return figure


def _axis(name: str, values: Any, system: System | Machine) -> tuple[np.ndarray[Any, Any], str]:
    """Values of a start and their name on an axis, in SI where the system has scales."""
    found = np.asarray(values, dtype=float)
    if not system.is_si or name not in _SI_NAMES:
        unit = " [bar lengths/rad]" if name == "velocity" and hasattr(system, "load") else ""
        return found, _NAMES.get(name, name) + unit
    scales = {"time": 1e3 * system.time_scale, "velocity": system.speed_scale, "position": 1e3 * system.length_scale}
    return found * scales[name], _SI_NAMES[name]


def _colour(i: int) -> str:
    return palette.AREAS[i] if i < MOST_SHOWN else _REST


def _name(shares: Sequence[Share], i: int) -> str:
    """The label, and what else tells it from others where several have the same one."""
    share = shares[i]
    alone = sum(other.label == share.label for other in shares) == 1
    return share.label if alone else f"{share.label} {share.attractor.mark}".rstrip()


def _bars(ax: Axes, shares: Sequence[Share]) -> None:
    shown = list(shares[:MOST_SHOWN])
    places = np.arange(len(shown))
    share, low, high = (np.array([getattr(s, name) for s in shown]) for name in ("share", "low", "high"))
    ax.barh(places, share, color=[_colour(i) for i in range(len(shown))], height=0.7)
    ax.errorbar(share, places, xerr=np.abs([share - low, high - share]), fmt="none", ecolor=INK, capsize=2.5, lw=1.0)
    ax.set_yticks(places, [_name(shares, i) for i in range(len(shown))])
    ax.invert_yaxis()
    ax.set_xlim(0.0, min(1.0, 1.12 * float(high.max())))
    ax.set_xlabel("share of the starts, with 95 % intervals")
    rest = len(shares) - len(shown)
    ax.set_title("(a) attractors" + (f"; {rest} more are rarer" if rest else ""))


def _scatter(ax: Axes, found: Experiment) -> None:
    number = found.attractor
    (x, x_name), (y, y_name) = _plane(ax, found)
    step = max(1, -(-number.size // MOST_POINTS))
    size = float(np.clip(3000.0 / (number.size / step), 0.3, 14.0))
    for i in range(min(int(number.max()), MOST_SHOWN), -1, -1):  # the most frequent last, over the others' edges
        here = np.flatnonzero(np.minimum(number, MOST_SHOWN) == i)[::step]
        ax.scatter(x[here], y[here], s=size, color=_colour(i), linewidths=0.0, rasterized=True)
    ax.set(xlabel=x_name, ylabel=y_name, title="(b) starts in the colour of what they lead to")


_Line = tuple[np.ndarray[Any, Any], str]


def _plane(ax: Axes, found: Experiment) -> tuple[_Line, _Line]:
    """The two quantities over which starts are drawn; of a machine the position, or at one place the state."""
    columns = found.columns
    speed = columns.get("velocity", columns.get("start_velocity"))
    assert speed is not None
    velocity = speed if speed.ndim == 1 else speed[:, 0]
    if "time" in columns:
        name, values = ("velocity", velocity) if np.ptp(velocity) else ("position", columns["position"])
        return _axis("time", columns["time"], found.system), _axis(name, values, found.system)
    if np.ptp(columns["position"]) > 0.0:
        return _axis("position", columns["position"], found.system), _axis("velocity", velocity, found.system)
    states = found.hammer.words["state"]
    ax.set_yticks(range(len(states)), list(states))
    spread = 0.6 * ((np.arange(velocity.size) * _GOLDEN) % 1.0 - 0.5)
    return _axis("velocity", velocity, found.system), (columns["state"] + spread, "state of the valve at the start")


_GOLDEN = 0.6180339887498949  # fills a strip evenly, the same every time
