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

from percuss.errors import HistoryError
from percuss.recordings.arrays import Array
from percuss.recordings.columns import Column, find_opposing, find_time, find_values, first_of_two, seconds, value_scale
from percuss.recordings.file_formats import READERS
from percuss.recordings.gaps import without_gaps
from percuss.recordings.options import check_column, file_path, in_hertz, in_seconds
from percuss.recordings.table import RATE_REMEDY, Table, as_rate
from percuss.recordings.text_table import read_text
from percuss.shown import Shown
from percuss.units import unit_scale

__all__ = ["MAX_BYTES", "Recording", "read_recording"]

MAX_BYTES = 64 * 2**20
"""The largest file that is read; 40 cycles are enough, and fill a hundredth of it."""
MIN_SAMPLES = 16


@dataclass(frozen=True)
class Recording(Shown):
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
    opposing
        Shape (n,), the same for the opposing face, where one was asked for. Its force is subtracted.
    """

    time: Array = field(repr=False)
    values: Array = field(repr=False)
    quantity: Literal["force", "pressure"]
    path: Path
    notes: tuple[str, ...] = ()
    opposing: Array | None = field(default=None, repr=False)


def read_recording(
    path: str | os.PathLike[str],
    *,
    column: Column | None = None,
    unit: str | None = None,
    time_column: Column | None = None,
    sample_rate: float | str | None = None,
    opposing_column: Column | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
) -> Recording:
    """Read a history of force or pressure.

    Samples without a value (NaN, an empty cell) are left out, and nothing is filled in; `notes` says how many. More
    than a tenth of them is refused here, and a gap longer than a quarter of a period where the cycles are fitted.

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
    opposing_column
        As `column`, for the same quantity on the opposing face, in the unit of its own heading, or in `unit`.
    start, end
        The part of the record that is used, both ends with it: in s, or text such as "0.2 s", on the clock of the
        record. Where that has dates or times of day, or none, it begins with 0.

    Raises
    ------
    HistoryError
        When the file cannot be read or what is meant cannot be told; names the file, the cause and the remedy.
    UnitError
        When `unit`, `sample_rate`, `start` or `end` is not such a unit or quantity.
    ParameterError
        When `path` is no path, or a column is neither a heading nor a number.
    MissingExtraError
        When the file needs a package of the extra ``[io]`` that is not installed.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "force.csv")
    ...     _ = file.write_text("time [s],force [kN]\\n" + "".join(f"{i / 100},{i % 10}\\n" for i in range(40)))
    ...     recording = read_recording(file)
    >>> recording.quantity, recording.values[:3].tolist()
    ('force', [0.0, 1000.0, 2000.0])
    """
    path = file_path(path)
    for option, key in (("column", column), ("time_column", time_column), ("opposing_column", opposing_column)):
        check_column(option, key)
    _check_file(path)
    table = READERS.get(path.suffix.lower(), read_text)(path)
    rate = None if sample_rate is None else in_hertz(sample_rate)
    scale_given = None if unit is None else unit_scale(unit, ("force", "pressure"), "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise HistoryError(
            "a .wav file holds fractions of full scale, without a unit",
            'say what full scale is: unit = "12 MPa"',
            table.file,
        )
    clock = None if rate is not None and time_column is None else find_time(table, time_column, column)
    value = find_values(table, column, clock, scale_given is not None)
    faces = [value]
    if opposing_column is not None:
        faces.append(find_opposing(table, opposing_column, value, clock))
    notes: list[str] = []
    if clock is None and column is None and time_column is None and not any(table.names) and rate is None:
        clock = first_of_two(table, value, notes)
    scales = [scale_given or value_scale(table, face) for face in faces]
    if len({quantity for _, quantity in scales}) > 1:
        raise HistoryError(
            f"{table.heading(faces[0])} is a {scales[0][1]}, {table.heading(faces[1])} a {scales[1][1]}",
            "name two columns of the same quantity",
            table.file,
        )
    if scale_given is not None:
        notes += [f for face in faces if (f := _against_heading(table, face, cast(str, unit), scale_given))]
    if rate is None and clock is None and (rate := table.sample_rate) is None:
        raise HistoryError(
            f"no column of time among {table.listing(range(len(table.names)))}",
            f'give time_column = "…", or {RATE_REMEDY}',
            table.file,
        )
    values = table.read(faces)
    if sample_rate is not None or clock is None:
        time = np.arange(values[0].size) / cast(float, rate)
        notes += _against_clock(table, column, cast(float, rate))
    else:
        time = seconds(table, clock, notes)
        _check_sizes(table, time, values, clock, value)
        _check_time(table, time, clock)
    time, values = _cut(table, time, values, start, end)
    _check_values(table, values, faces)
    time, values = without_gaps(time, values, table, notes)
    found = [v * scale for v, (scale, _) in zip(values, scales, strict=True)]
    opposing = found[1] if len(found) > 1 else None
    return Recording(time, found[0], cast(Any, scales[0][1]), path, tuple(notes), opposing)


def _against_heading(table: Table, value: int, unit: str, given: tuple[float, str]) -> str:
    """What to say of a `unit` that differs from that of the heading."""
    try:
        own = value_scale(table, value)
    except HistoryError:  # no unit that could be compared
        return ""
    if own == given:
        return ""
    differs = "not the quantity in" if own[1] != given[1] else f"{given[0] / own[0]:.6g} times the unit in"
    return f'unit = "{unit}" is used for {table.heading(value)}: {differs} the heading'


def _against_clock(table: Table, column: Column | None, rate: float) -> list[str]:
    """What to say of a sample rate that differs from that of a column of time."""
    try:
        clock = find_time(table, None, column)
        step = float(np.median(np.diff(seconds(table, clock, [])))) if clock is not None else 0.0
    except HistoryError:  # no column that could be compared
        return []
    if not step > 0.0 or abs(step * rate - 1.0) < 1e-3:
        return []
    assert clock is not None
    return [f"sample_rate = {as_rate(rate)} is used; the time in {table.heading(clock)} says {as_rate(1.0 / step)}"]


# -- is it a usable series --


def _check_sizes(table: Table, time: Array, values: list[Array], clock: int, value: int) -> None:
    if time.size != values[0].size:
        remedy = f"name the time that belongs to it, time_column = …, or {RATE_REMEDY}"
        raise HistoryError(
            f"{table.heading(value)} has {values[0].size} samples and {table.heading(clock)} {time.size}",
            remedy,
            table.file,
        )


def _check_values(table: Table, values: list[Array], faces: list[int]) -> None:
    sizes = [v.size for v in values]
    if len(set(sizes)) > 1:
        raise HistoryError(
            f"{table.heading(faces[0])} has {sizes[0]} samples, {table.heading(faces[1])} {sizes[1]}",
            "name two columns recorded together",
            table.file,
        )
    if sizes[0] < MIN_SAMPLES:
        raise HistoryError(
            f"only {sizes[0]} samples", f"at least {MIN_SAMPLES}, over two whole cycles or more, are needed", table.file
        )
    for data, face in zip(values, faces, strict=True):
        bad = np.flatnonzero(np.isinf(data))
        if bad.size:
            raise HistoryError(
                f"{table.where(int(bad[0]))}: {table.heading(face)} is {data[bad[0]]} ({bad.size} such values)",
                "an infinite value cannot be used: cut the record there (from, to), or empty the cell",
                table.file,
            )


def _check_time(table: Table, time: Array, clock: int) -> None:
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        raise HistoryError(
            f"{table.where(int(bad[0]))}: {table.heading(clock)} is {time[bad[0]]} ({bad.size} such values)",
            f"a time is needed for every sample: fix or delete these lines, or {RATE_REMEDY}",
            table.file,
        )
    steps = np.diff(time)
    back = np.flatnonzero(steps <= 0.0)
    if back.size:
        i = int(back[0]) + 1
        remedy = f"sort the record, or ignore its time and {RATE_REMEDY}"
        if time[-1] > time[0]:  # a clock that is too coarse for the samples still tells their mean rate
            steps = steps[steps > 0.0]
            coarse = 2 * steps.size < time.size and not np.any(np.diff(time) < 0.0)
            rate = (time.size - 1) / (time[-1] - time[0]) if coarse else 1.0 / float(np.median(steps))
            remedy = f"sort the record, or ignore its time with sample_rate = {as_rate(rate)}, if that is right"
        raise HistoryError(
            f"{table.where(i)}: the time does not increase ({time[i - 1]:.9g} s, then {time[i]:.9g} s)",
            remedy,
            table.file,
        )


def _cut(
    table: Table, time: Array, values: list[Array], start: float | str | None, end: float | str | None
) -> tuple[Array, list[Array]]:
    """The part of the record from `start` to `end`."""
    if start is None and end is None:
        return time, values
    first = -np.inf if start is None else in_seconds(start, "from")
    last = np.inf if end is None else in_seconds(end, "to")
    used = (time >= first) & (time <= last)
    if not first < last or not np.any(used):
        raise HistoryError(
            f"nothing lies between {first:.9g} s and {last:.9g} s: "
            f"the record goes from {time[0]:.9g} s to {time[-1]:.9g} s",
            "give from and to inside the record, from before to",
            table.file,
        )
    return time[used], [v[used] if v.size == time.size else v for v in values]


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
