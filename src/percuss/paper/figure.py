"""A figure as a value: the columns of its table, and how it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.atomic_write import write_whole
from percuss.errors import PercussError
from percuss.explore.boundary_curves.boundary import admissible_on
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import Line, MotionArc
from percuss.explore.family import SystemFamily
from percuss.model import Load, System
from percuss.model.checks import Array
from percuss.stability.verdict import schur_quotients

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture

Columns = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, eq=False)
class PaperFigure:
    """One figure.

    Parameters
    ----------
    name
        Of its files: ``fig5`` for fig5.csv, fig5.svg and fig5.png.
    columns
        The table, arrays of equal shape (n,) by name; numbers, truth values or words.
    marks
        What the picture shows besides the table, by name.
    """

    name: str
    title: str
    columns: Columns
    paint: Callable[[PaperFigure, Picture], None] = field(repr=False)
    width: float = 5.2
    height: float = 4.4
    marks: Columns = field(default_factory=dict, repr=False)

    @property
    def rows(self) -> int:
        """Rows of the table."""
        return int(next(iter(self.columns.values())).size)

    def csv(self) -> str:
        """The table as CSV: a line of names, then numbers with all their digits, true and false; nan where none."""
        columns = [_texts(column) for column in self.columns.values()]
        lines = [",".join(self.columns), *(",".join(row) for row in zip(*columns, strict=True))]
        return "\n".join(lines) + "\n"

    def draw(self) -> Picture:
        """The picture."""
        from percuss.plot.canvas import new_figure, style

        picture = new_figure(self.width, self.height)
        with style():
            self.paint(self, picture)
            picture.suptitle(self.title, x=0.01, ha="left", fontsize=10, fontweight="bold")
        return picture

    def write_csv(self, path: str | Path) -> Path:
        """Write the table."""
        target = Path(path)
        write_whole(target, self.csv())
        return target

    def write(self, directory: str | Path) -> tuple[Path, ...]:
        """Write CSV, SVG and PNG into a directory, which is made when it is not there."""
        from percuss.plot import save

        folder = Path(directory)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PercussError(f"{folder}: cannot be made: {error.strerror or error}") from None
        picture = self.draw()
        table = self.write_csv(folder / f"{self.name}.csv")
        return (table, *(save(picture, folder / f"{self.name}{suffix}") for suffix in (".svg", ".png")))


def _texts(column: npt.NDArray[Any]) -> list[str]:
    if column.dtype.kind == "b":
        return ["true" if value else "false" for value in column.tolist()]
    return [value if isinstance(value, str) else repr(value) for value in column.tolist()]


# ---- How branches of steady motions are drawn in the manner of B77: solid where stable, dashed where not

_DASHES = (0, (4, 2))
_GREY = "#9a9a9a"


def draw_branches(axes: Axes, columns: Columns, name: str, inside: bool = True) -> None:
    """Phase over the parameter, a curve for each R with its number at the fold; grey where the motion is impossible."""
    from percuss.plot.canvas import COLOURS, segments

    for r in np.unique(columns["restitution"]).tolist():
        here = columns["restitution"] == r
        y, phase = columns[name][here], columns["phase"][here]
        stable, possible = columns["stable"][here], columns["admissible"][here]
        for run, whether in segments(possible):
            for part, steady in segments(stable[run]):
                line = "-" if steady else _DASHES
                colour = COLOURS[0] if whether else _GREY
                axes.plot(y[run][part], phase[run][part], color=colour, linestyle=line, linewidth=1.2)
        top = int(np.argmax(y))
        axes.annotate(
            f"{r:.1f}" if r else "R = 0",
            (y[top], phase[top]),
            (-3, 0) if inside else (3, -1),
            textcoords="offset points",
            fontsize=7,
            ha="right" if inside else "left",
            va="center",
            annotation_clip=True,
        )


def branch_legend(axes: Axes) -> None:
    """What the lines mean."""
    from percuss.plot.canvas import COLOURS

    axes.plot([], [], color=COLOURS[0], label="stable (B77's criterion)")
    axes.plot([], [], color=COLOURS[0], linestyle=_DASHES, label="unstable")
    axes.plot([], [], color=_GREY, label="passes through the wall")
    axes.legend(loc="lower right")


# ---- What the figures of B77 share: the systems in the limit s → ∞, the values of R, branches as rows

STIFF = 1e7  # s of the limit s → ∞: σ falls off like 1/(12 s²) or faster and is below rounding there

DAMPING = 0.03 / (2.0 * math.pi)  # d of B77's damped curves, 2πd = 0.03

RESTITUTIONS = np.linspace(0.0, 0.99, 100)  # R of the curves over R

KAPPAS = (1.0 + 1e-6, 2.0 - 1e-6)  # the range of κ in which the square wave pushes

TENTHS = tuple(i / 10 for i in range(10))  # R of the families of curves


def pneumatic(s: float = STIFF, d: float = 0.0) -> System:
    """p(t) = p_0 + cos t; R and p_0 are set by what is asked."""
    return System(s=s, d=d, restitution=0.0, load=Load.harmonic(1.0, 1.0))


def hydraulic(s: float = STIFF, d: float = 0.0) -> System:
    """The square wave with q = 1, exact between its jumps; R and κ are set by what is asked."""
    return System(s=s, d=d, restitution=0.0, load=Load.square(1.0, 1.5, 8))


def branch_rows(
    system: System, restitution: float, name: str, low: float, high: float, points: int
) -> dict[str, npt.NDArray[Any]]:
    """All steady motions of one R, m = 1, along a parameter, up to the fold and down; admissible as the rigid bar's."""
    line = Line(SystemFamily(system), {"restitution": restitution}, name, low, high, 1, 0)
    parts = []
    for way, stretch in zip((1, -1), folds_and_stretches(line, 33)[1], strict=True):
        rows = _rows(stretch, points)
        order = np.argsort(way * rows[0])
        parts.append([row[order] for row in rows])
    y, phase, stable, admissible = (np.concatenate(column) for column in zip(*parts, strict=True))
    return {
        "restitution": np.full(y.size, restitution),
        name: y,
        "phase": phase,
        "stable": stable.astype(bool),
        "admissible": admissible.astype(bool),
    }


def _rows(stretch: MotionArc, points: int) -> tuple[Array, Array, Array, Array]:
    t = (np.arange(points) + 0.5) / points  # the ends are folds, or the end of the range
    y, phase = stretch.place(t)
    first, second = schur_quotients(*stretch.quadratic(t))
    stable = (first < 1.0) & (second < 1.0)
    return y, phase, stable.astype(float), admissible_on(stretch, t, 7).astype(float)


def stacked(parts: list[dict[str, npt.NDArray[Any]]]) -> dict[str, npt.NDArray[Any]]:
    """The rows of several tables of equal columns, one after the other."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
