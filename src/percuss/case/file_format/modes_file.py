"""A file with a table of modes: omega, damping, contact and drive, as a finite-element program exports them."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from percuss.errors import ParameterError

__all__ = ["COLUMNS", "modes_in"]

COLUMNS = ("omega", "damping", "contact", "drive")
_MOST_BYTES = 10_000_000


def modes_in(path: Path, name: str) -> dict[str, tuple[float, ...]]:
    """The columns of a table of modes; lines that begin with # are remarks.

    Parameters
    ----------
    path, name
        The file, and what the case calls it.

    Raises
    ------
    ParameterError
        For a file that cannot be read; by line and column where something is no number.
    """
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise ParameterError("file", name, f"a table of at most {_MOST_BYTES // 1_000_000} MB")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ParameterError("file", name, f"a file that can be read ({path}: {reason})") from None
    except ValueError:  # not UTF-8, or a null character in the path
        raise ParameterError("file", name, "a text file in UTF-8") from None
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if len(lines) < 2:
        raise ParameterError("file", name, f"a line of names, {', '.join(COLUMNS)}, and a line for each mode")
    between = max(",;\t", key=lines[0][1].count)
    head = [cell.strip().lower() for cell in next(csv.reader([lines[0][1]], delimiter=between))]
    places = {}
    for column in COLUMNS:
        if head.count(column) != 1:
            raise ParameterError("file", name, f"one column {column} (line {lines[0][0]} names: {', '.join(head)})")
        places[column] = head.index(column)
    found: dict[str, list[float]] = {column: [] for column in COLUMNS}
    for number, line in lines[1:]:
        cells = next(csv.reader([line], delimiter=between))
        for column, place in places.items():
            found[column].append(_number(cells[place] if place < len(cells) else "", name, number, column))
    _check(found, name, [number for number, _ in lines[1:]])
    return {column: tuple(values) for column, values in found.items()}


def _number(cell: str, name: str, line: int, column: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        shown = cell.strip() or "nothing"
        raise ParameterError("file", name, f"a finite number in line {line}, column {column}, not {shown[:40]!r}")
    return value


def _check(found: dict[str, list[float]], name: str, lines: list[int]) -> None:
    """What the model would refuse by the number of the mode, told by the line."""
    for line, omega, damping in zip(lines, found["omega"], found["damping"], strict=True):
        if omega <= 0.0:
            remedy = "a body that moves as a whole is a free one: describe it by [bar] or [system]"
            raise ParameterError("file", name, f"omega greater than 0 in line {line}, not {omega:g}", remedy)
        if damping < 0.0:
            raise ParameterError("file", name, f"damping of 0 or more in line {line}, not {damping:g}")
