"""The canvas of all pictures: figure, style, colours, saving. The only door to matplotlib."""

from __future__ import annotations

import io
import math
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.atomic_write import write_whole
from percuss.errors import ParameterError, extra_package
from percuss.model import Machine, System
from percuss.model.checks import having
from percuss.model.checks import path as checked_path
from percuss.short_repr import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.figure import Figure
    from matplotlib.gridspec import SubplotSpec

    from percuss.model.checks import Array
    from percuss.palette import Colour
    from percuss.steady.recorded.force_record import MeasuredForce

SUFFIXES = (".png", ".svg", ".pdf")  # what a picture can be saved as

INK = "#333333"

COLOURS = tuple(kind.light for kind in palette.KINDS)  # kinds of things: blue, vermilion, green, purple, orange, sky
_STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.4,
    "hatch.linewidth": 0.7,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.75,
    "mathtext.fontset": "dejavusans",
    "legend.fontsize": 7.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "percuss",
    "path.simplify_threshold": 0.3,
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of the given size in inches, without any global state (no pyplot)."""
    made: Figure = extra_package("matplotlib.figure", "plot").Figure(figsize=(width, height), layout="constrained")
    return made


@contextmanager
def canvas(width: float, height: float, title: str = "") -> Iterator[Figure]:
    """An empty figure, drawn on in this package's style; above it the title of a case, as one line of plain text."""
    figure = new_figure(width, height)
    with style():
        yield figure
        if title:
            figure.suptitle(one_line(title), x=0.01, ha="left", fontsize=11, fontweight="bold", parse_math=False)


def legend_above(axes: Axes, columns: int = 3) -> None:
    """The legend at the right of the title, where it covers nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.2, frameon=False,
                columnspacing=1.2)  # fmt: skip


def nothing(axes: Axes, text: str, height: float = 0.5) -> None:
    """What stands in a panel that has nothing to show."""
    axes.text(0.5, height, text, transform=axes.transAxes, ha="center", va="center", color=INK)


def wall(axes: Axes, tool: object = None) -> None:
    """A line where the wall is, or the tool, with its name."""
    axes.axhline(0.0, color=INK, linewidth=2.5)
    place: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "ha": "right"}
    axes.annotate("wall" if tool is None else "tool", (1.0, 0.0), (0, 4), **place)


def measured_panels(figure: Figure, cell: SubplotSpec, measured: MeasuredForce | None) -> tuple[Axes, Axes | None]:
    """The panel of a force and, where it was measured, a lower one for what the model leaves of it."""
    if measured is None:
        return figure.add_subplot(cell), None
    cells = cell.subgridspec(2, 1, height_ratios=(3.0, 1.0), hspace=0.05)
    upper = figure.add_subplot(cells[0])
    return upper, figure.add_subplot(cells[1], sharex=upper)


def draw_measured(axes: Axes, lower: Axes, measured: MeasuredForce, cycle: float, units: Units) -> None:
    """A recorded force over that of the model, every cycle on the first, which is so long; below it the residual."""
    begun = np.flatnonzero(np.diff(np.floor(measured.turns))) + 1
    rows = (cycle * (measured.turns % 1.0), measured.measured, measured.model)
    at, force, model = (np.insert(row, begun, np.nan) for row in rows)
    look: dict[str, Any] = {"linewidth": 0.5, "alpha": 0.5, "rasterized": True, "zorder": 2.5}
    (line,) = axes.plot(at, force * units.force, color=COLOURS[4], label=f"measured, {begun.size + 1} cycles", **look)
    shown = [handle for name, handle in named_once(axes).items() if name.startswith("stable")]
    axes.legend(handles=[*shown, line], loc="upper center")
    lower.plot(at, (force - model) * units.force, color=INK, **look)
    lower.axhline(0.0, color=INK, linewidth=0.6)
    unit = units.force_label.partition("[")[2]
    lower.set(xlabel=axes.get_xlabel(), ylabel=f"residual\n[{unit}" if unit else "residual")
    axes.set_xlabel("")
    axes.tick_params(labelbottom=False)


def phase_axis(axes: Axes) -> None:
    """The phase of the load, from left to right."""
    axes.set_xlim(0.0, 2.0 * math.pi)
    axes.set_xticks([0.5 * math.pi * i for i in range(5)], ["0", "π/2", "π", "3π/2", "2π"])
    axes.set_xlabel("phase of the load")


def named_once(axes: Axes) -> dict[str, Any]:
    """What the legend of a panel would name, each name once."""
    handles, labels = axes.get_legend_handles_labels()
    return dict(zip(labels, handles, strict=True))


def segments(truth: np.ndarray[Any, Any]) -> list[tuple[slice, bool]]:
    """The runs of equal truth along a curve, each with the first point of the next so that no gap shows."""
    starts = [0, *(np.flatnonzero(np.diff(truth)) + 1).tolist(), truth.size]
    return [(slice(a, min(b + 1, truth.size)), bool(truth[a])) for a, b in pairwise(starts)]


def patches_beside(axes: Axes, looks: Sequence[dict[str, Any]]) -> None:
    """A legend of areas beside a panel: of each its face, its label, and what else it has."""
    from matplotlib.patches import Patch

    plain: dict[str, Any] = {"edgecolor": INK, "lw": 0.4}
    handles = [Patch(**(plain | look)) for look in looks]
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.3)


def ramp(stops: Sequence[str | Colour]) -> LinearSegmentedColormap:
    """A ramp of the palette, on its light ground, as matplotlib takes it."""
    from matplotlib.colors import LinearSegmentedColormap

    light = [stop if isinstance(stop, str) else stop.light for stop in stops]
    return LinearSegmentedColormap.from_list("percuss", light)


def style() -> AbstractContextManager[None]:
    """A context in which things are drawn and saved in this package's style."""
    from matplotlib import rc_context

    return rc_context(_STYLE)  # type: ignore[arg-type]  # its keys are a long list of literals


def reword(figure: Figure, words: Callable[[str], str]) -> None:
    """Give a picture other words, line by line; those of ticks, and their numbers, when they are drawn."""
    from matplotlib.text import Text

    if words is str:
        return

    def lines(text: str) -> str:
        return "\n".join(one if one[:1] == one[-1:] == "$" else words(one) for one in text.split("\n"))

    def also(ticks: Callable[[Any], list[str]]) -> Callable[[Any], list[str]]:
        return lambda values: [lines(one) for one in ticks(values)]

    for text in figure.findobj(Text):
        text.set_text(lines(text.get_text()))
    axes = {axis for one in figure.axes for axis in (one.xaxis, one.yaxis)}
    for formatter in {axis.get_major_formatter() for axis in axes}:
        formatter.format_ticks = also(formatter.format_ticks)  # type: ignore[assignment, method-assign]


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a picture; the suffix says what it is: .png, .svg or .pdf.

    Returns
    -------
    Path
        Where it was written: whole, or not at all. What was there before stays when drawing or writing fails.

    Raises
    ------
    PercussError
        When the file cannot be written.
    """
    having("figure", figure, ("savefig",), "a figure, such as percuss.plot.steady gives")
    target = Path(checked_path("path", path))
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError("path", str(path), f"a name that ends in {', '.join(SUFFIXES)}")
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}[suffix]  # same answer, same bytes
    buffer = io.BytesIO()
    with style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")  # such as 🔨 in a title: a box in its place
        figure.savefig(buffer, format=suffix[1:], dpi=150, metadata=undated)
    write_whole(target, buffer.getvalue())
    return target


# ---- Units on the axes: factors and labels that turn dimensionless results into SI where the system has scales


@dataclass(frozen=True)
class Units:
    """What one unit of each quantity is on the axis, and what the axis is called."""

    time_label: str
    force_label: str
    length_label: str
    speed_label: str
    stress_label: str
    time: float = 1.0
    force: float = 1.0
    length: float = 1.0
    speed: float = 1.0
    stress: float = 1.0


_PLAIN = Units(
    "time after impact [rad]", "load p [dimensionless]", "gap u(1, t)", "velocity of the striking end", "strain u_x"
)
_PLAIN_MACHINE = Units("time", "force", "position", "velocity", "strain u_x")


def units_of(hammer: System | Machine, greatest: float | None = None) -> Units:
    """ms, kN, mm, m/s and MPa for a hammer in SI, else radians and 1; by the `greatest` force, or the load's."""
    of_machine = isinstance(hammer, Machine)
    if not hammer.is_si:
        return _PLAIN_MACHINE if of_machine else _PLAIN
    force = max(abs(p) for p in hammer.load.coefficients) if isinstance(hammer, System) else greatest or 0.0
    kilo = force * hammer.force_scale >= 500.0
    return Units(
        "time [ms]" if of_machine else "time after impact [ms]",
        "force [kN]" if kilo else "force [N]",
        "position [mm]" if of_machine else "striking end [mm]",
        "velocity [m/s]" if of_machine else "velocity of the striking end [m/s]",
        "stress [MPa]",
        1e3 * hammer.time_scale,
        hammer.force_scale * (1e-3 if kilo else 1.0),
        1e3 * hammer.length_scale,
        hammer.speed_scale,
    )


def stress_of(system: System, x: Array, strain: Array) -> Array:
    """What `Units.stress_label` names, at the places x: the stress in MPa of an SI system, else the strain itself."""
    return system.stress(x, strain) / 1e6 if system.is_si else strain


def draw_waves(
    figure: Figure, axes: Axes, system: System, strain: Array, span: tuple[float, float], units: Units
) -> None:
    """The stress over time and place, or the strain of a system without units: shape (places, times), even in both."""
    field = stress_of(system, np.linspace(0.0, 1.0, len(strain)), strain)
    size = float(np.percentile(np.abs(field), 99.5)) or float(np.abs(field).max()) or 1.0
    picture = axes.imshow(
        field,
        extent=(*span, 0.0, units.length),
        aspect="auto",
        origin="lower",
        interpolation="bilinear",
        cmap=ramp(palette.STRAIN),
        vmin=-size,
        vmax=size,
    )
    axes.set_ylabel("from the driven end [mm]" if system.is_si else "x (0 driven end, 1 striking end)")
    figure.colorbar(picture, ax=axes, label=f"{units.stress_label}, {palette.SIGN}", pad=0.01)
