"""Reading a measured history of force or pressure from a file.

Text (comma, semicolon, tab or blank between the columns, decimal comma, headings with units) needs numpy only;
``.mat``, ``.wav``, ``.h5`` and ``.tdms`` need the extra ``[io]``. Nothing is guessed that could be wrong in silence:
what is ambiguous or has no unit is refused, and the refusal names the columns and the key that settles it.
"""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from percuss.errors import HistoryError, UnitError
from percuss.model.checks import Array
from percuss.model.columns import Column, find_time, find_values, first_of_two, time_scale, value_scale
from percuss.model.file_formats import READERS
from percuss.model.table import Table
from percuss.model.text_table import read_text
from percuss.units import si, unit_scale

__all__ = ["MAX_BYTES", "Recording", "read_recording"]

MAX_BYTES = 64 * 2**20
"""The largest file that is read; 40 cycles are enough, and fill a hundredth of it."""
MIN_SAMPLES = 16


@dataclass(frozen=True)
class Recording:
    """A measured history in SI units.

    Attributes
    ----------
    time
        Shape (n,), s, strictly increasing.
    values
        Shape (n,), N for a force, Pa for a pressure.
    quantity
        What the values are: "force" or "pressure".
    path
        The file that they come from.
    notes
        What was assumed in reading, one sentence each.
    """

    time: Array = field(repr=False)
    values: Array = field(repr=False)
    quantity: Literal["force", "pressure"]
    path: Path
    notes: tuple[str, ...] = ()


def read_recording(
    path: str | os.PathLike[str],
    *,
    column: Column | None = None,
    unit: str | None = None,
    time_column: Column | None = None,
    sample_rate: float | str | None = None,
) -> Recording:
    """Read a history of force or pressure.

    Parameters
    ----------
    path
        ``.csv``, ``.tsv``, ``.txt`` and the like, or ``.mat``, ``.wav``, ``.h5``, ``.tdms`` with the extra ``[io]``.
    column
        The heading of the values, with or without its unit, or the number of the column, from 1. Needed where more
        than one column could be meant.
    unit
        What 1 in the column stands for, such as "bar" or, for a sensor, "12 MPa"; overrides the heading. In a
        ``.wav`` file 1 is full scale, so there it is the pressure or force at full scale.
    time_column
        As `column`, for the time. A column of time without a unit is taken to be in seconds.
    sample_rate
        In Hz, or text such as "50 kHz"; then no column of time is used.

    Raises
    ------
    HistoryError
        When the file cannot be read or what is meant cannot be told; names the file, the cause and the remedy.
    UnitError
        When `unit` or `sample_rate` is no such unit or quantity.
    MissingExtraError
        When the file needs a package of the extra ``[io]`` that is not installed.
    """
    path = Path(path)
    _check_file(path)
    table = READERS.get(path.suffix.lower(), read_text)(path)
    rate = None if sample_rate is None else _rate(sample_rate)
    scale_given = None if unit is None else unit_scale(unit, ("force", "pressure"), "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise HistoryError(
            "a .wav file holds fractions of full scale, without a unit",
            'say what full scale is: unit = "12 MPa"',
            table.file,
        )
    clock = None if rate is not None and time_column is None else find_time(table, time_column, column)
    value = find_values(table, column, clock, scale_given is not None)
    notes: list[str] = []
    if clock is None and column is None and time_column is None and not any(table.names) and rate is None:
        clock = first_of_two(table, value, notes)
    scale, quantity = scale_given or value_scale(table, value)
    if rate is not None:
        clock = None
    elif clock is None and (rate := table.sample_rate) is None:
        raise HistoryError(
            f"no column of time among {table.listing(range(len(table.names)))}",
            'give time_column = "…", or sample_rate = "50 kHz"',
            table.file,
        )
    columns = table.read([value] if clock is None else [value, clock])
    _check_finite(table, columns, [value] if clock is None else [value, clock])
    if clock is None:
        time = np.arange(columns[0].size) / cast(float, rate)
    else:
        time = columns[1] * time_scale(table, clock, notes)
        _check_time(table, time, clock)
    return Recording(time, columns[0] * scale, cast(Any, quantity), path, tuple(notes))


def _rate(sample_rate: float | str) -> float:
    rate = si(sample_rate, "frequency" if isinstance(sample_rate, str) else "dimensionless", "sample_rate")
    if rate <= 0.0:
        raise UnitError("sample_rate", sample_rate, 'a frequency greater than 0, such as "50 kHz"')
    return rate


# -- is it a usable series --


def _check_finite(table: Table, columns: list[Array], numbers: list[int]) -> None:
    sizes = [c.size for c in columns]
    if len(set(sizes)) > 1:
        raise HistoryError(
            f"{table.heading(numbers[0])} has {sizes[0]} samples and the time {sizes[1]}",
            'give sample_rate = "50 kHz"',
            table.file,
        )
    if sizes[0] < MIN_SAMPLES:
        raise HistoryError(
            f"only {sizes[0]} samples", f"at least {MIN_SAMPLES}, over two whole cycles or more, are needed", table.file
        )
    for data, number in zip(columns, numbers, strict=True):
        bad = np.flatnonzero(~np.isfinite(data))
        if bad.size:
            raise HistoryError(
                f"{table.where(int(bad[0]))}: {table.heading(number)} is {data[bad[0]]} ({bad.size} such values)",
                "NaN and infinity cannot be used: cut the record there, or fill the gap",
                table.file,
            )


def _check_time(table: Table, time: Array, clock: int) -> None:
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if back.size:
        i = int(back[0]) + 1
        raise HistoryError(
            f"{table.where(i)}: the time does not increase ({time[i - 1]:.9g} s, then {time[i]:.9g} s)",
            'sort the record, or ignore its time with sample_rate = "50 kHz"',
            table.file,
        )


def _check_file(path: Path) -> None:
    file = str(path)
    try:
        if path.is_dir():
            raise HistoryError("is a directory", "name a file of text (.csv, …), .mat, .h5, .tdms or .wav", file)
        if not path.exists():
            near = difflib.get_close_matches(path.name, [p.name for p in path.parent.glob("*")][:1000], n=1)
            raise HistoryError(
                "there is no such file", f'did you mean "{near[0]}"?' if near else "check the path", file
            )
        if not path.is_file():
            raise HistoryError("is not a regular file", "save the record in a file", file)
        size = path.stat().st_size
    except (OSError, ValueError) as error:
        raise HistoryError(f"cannot be read ({error})", "check the path and its permissions", file) from None
    if size > MAX_BYTES:
        raise HistoryError(
            f"has {size / 2**20:.0f} MB; at most {MAX_BYTES // 2**20} MB are read",
            "cut some 50 cycles out of the record, or save it with fewer columns",
            file,
        )
    if size == 0:
        raise HistoryError("is empty", "the file must hold a column of force or pressure", file)
