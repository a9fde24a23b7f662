"""A figure as a value: the columns of its table, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.whole_file import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

__all__ = ["Figure", "segments"]

Columns = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Figure:
    """One figure.

    Parameters
    ----------
    name
        Of its files: ``fig5`` for fig5.csv, fig5.svg and fig5.png.
    title
        What it shows.
    columns
        The table, arrays of equal shape (n,) by name; numbers, truth values or words.
    paint
        Draws the figure onto an empty picture.
    width, height
        Of the picture, in inches.
    marks
        What the picture shows besides the table, by name.
    """

    name: str
    title: str
    columns: Columns
    paint: Callable[[Figure, Picture], None] = field(repr=False)
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
        """The picture.

        Raises
        ------
        MissingExtraError
            When matplotlib is not installed.
        """
        from percuss.plot.canvas import new_figure, style

        picture = new_figure(self.width, self.height)
        with style():
            self.paint(self, picture)
            picture.suptitle(self.title, x=0.01, ha="left", fontsize=10, fontweight="bold")
        return picture

    def write_csv(self, path: str | Path) -> Path:
        """Write the table.

        Raises
        ------
        PercussError
            When the file cannot be written.
        """
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


def segments(truth: npt.NDArray[np.bool_]) -> list[tuple[slice, bool]]:
    """The runs of equal truth along a curve, each with the first point of the next so that no gap shows.

    Examples
    --------
    >>> import numpy as np
    >>> segments(np.array([True, True, False]))
    [(slice(0, 3, None), True), (slice(2, 3, None), False)]
    """
    starts = [0, *(np.flatnonzero(np.diff(truth)) + 1).tolist(), truth.size]
    return [(slice(a, min(b + 1, truth.size)), bool(truth[a])) for a, b in pairwise(starts)]
