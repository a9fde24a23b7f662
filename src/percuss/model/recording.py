"""Reading a measured history of force or pressure from a file.

Text (comma, semicolon, tab or blank between the columns, decimal comma, headings with units) needs numpy only;
``.mat``, ``.wav``, ``.h5`` and ``.tdms`` need the extra ``[io]``. Nothing is guessed that could be wrong in silence:
what is ambiguous or has no unit is refused, and the refusal names the columns and the key that settles it.
"""

from __future__ import annotations

import csv
import difflib
import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, MissingExtraError, UnitError
from percuss.units import DIMENSIONS, TIME_WORDS, known_dimension, si, split_header, unit_scale

__all__ = ["MAX_BYTES", "Recording", "read_recording"]

Array = npt.NDArray[np.float64]
Column = str | int

MAX_BYTES = 64 * 2**20
"""The largest file that is read; 40 cycles are enough, and fill a hundredth of it."""
MIN_SAMPLES = 16

_VALUE_WORDS = re.compile(
    r"(p|f|force|kraft|kraeften|druck|press\w*|pressure|tryck|pression|presion|paine|voima|fuerza|load|last)(\d|\b|_)",
    re.IGNORECASE,
)
_SCALE_REMEDY = 'give unit = "bar" (or "kN", …), or write it in the heading: "pressure [bar]"'


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


@dataclass(frozen=True)
class _Table:
    """What a file holds, before a column is chosen."""

    file: str
    names: list[str]  # headings without their units; "" where there is none
    units: list[str | None]
    numeric: list[bool]
    read: Callable[[list[int]], list[Array]]
    where: Callable[[int], str] = lambda i: f"sample {i + 1}"
    sample_rate: float | None = None  # as the file itself says

    def heading(self, i: int) -> str:
        name = f'"{self.names[i]}"' if self.names[i] else f"column {i + 1}"
        return f"{name} [{self.units[i]}]" if self.units[i] else name

    def listing(self, columns: Iterable[int]) -> str:
        shown = [self.heading(i) for i in columns]
        return ", ".join(shown[:12]) + (f" and {len(shown) - 12} more" if len(shown) > 12 else "")


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
    table = _READERS.get(path.suffix.lower(), _read_text)(path)
    rate = None if sample_rate is None else _rate(sample_rate)
    scale_given = None if unit is None else unit_scale(unit, ("force", "pressure"), "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise HistoryError(
            "a .wav file holds fractions of full scale, without a unit",
            'say what full scale is: unit = "12 MPa"',
            table.file,
        )
    clock = None if rate is not None and time_column is None else _time_column(table, time_column, column)
    value = _value_column(table, column, clock, scale_given is not None)
    notes: list[str] = []
    if clock is None and column is None and time_column is None and not any(table.names) and rate is None:
        clock = _first_of_two(table, value, notes)
    scale, quantity = scale_given or _scale_of(table, value)
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
        time = columns[1] * _time_scale(table, clock, notes)
        _check_time(table, time, clock)
    return Recording(time, columns[0] * scale, cast(Any, quantity), path, tuple(notes))


# -- which column is what --


def _find(table: _Table, key: Column, option: str) -> int:
    """The column that `key` names."""
    every = range(len(table.names))
    if isinstance(key, str):
        wanted = key.strip().casefold()
        plain = [split_header(key)[0].casefold(), wanted]
        full = [f"{table.names[i]} [{table.units[i]}]".casefold() for i in every]
        for matches in (
            [i for i in every if full[i] == wanted],
            [i for i in every if table.names[i].casefold() in plain],
        ):
            if len(matches) == 1:
                return matches[0]
            if matches:
                raise HistoryError(
                    f'{option} = "{key}" fits more than one column: {table.listing(matches)}',
                    f"give the number of the column instead, {option} = {matches[0] + 1}",
                    table.file,
                )
    number = int(key) if isinstance(key, int) or (key.strip().isdecimal() and len(key) < 9) else 0
    if isinstance(key, bool) or not 1 <= number <= len(table.names):
        near = difflib.get_close_matches(str(key), table.names, n=1) if isinstance(key, str) else []
        hint = (
            f'did you mean "{near[0]}"?' if near else f"{option} is a heading or a number from 1 to {len(table.names)}"
        )
        raise HistoryError(f"no column {key!r}; the columns are {table.listing(every)}", hint, table.file)
    return number - 1


def _dimension(unit: str | None) -> str | None:
    """What a unit in a heading measures, as far as the closed table knows."""
    return known_dimension(unit, ("time", "force", "pressure", *DIMENSIONS)) if unit else None


def _time_like(table: _Table, i: int) -> bool:
    words = re.split(r"[\W\d_]+", table.names[i].lower())
    named = table.names[i] != "T" and any(word in TIME_WORDS for word in words)
    return _dimension(table.units[i]) == "time" or (named and table.units[i] is None)


def _time_column(table: _Table, key: Column | None, column: Column | None) -> int | None:
    if key is not None:
        found = [_find(table, key, "time_column")]
    else:
        taken = None if column is None else _find(table, column, "column")
        found = [i for i in range(len(table.names)) if i != taken and _time_like(table, i)]
        named = [i for i in found if table.names[i].lower() in TIME_WORDS]
        found = named if len(named) == 1 else found
    if len(found) > 1:
        raise HistoryError(
            f"more than one column could be the time: {table.listing(found)}",
            f'give time_column = "{table.names[found[0]]}", or the one that is meant',
            table.file,
        )
    if found and not table.numeric[found[0]]:
        raise HistoryError(
            f"the time in {table.heading(found[0])} is not given as numbers",
            'give sample_rate = "50 kHz" instead, or write the time in seconds',
            table.file,
        )
    return found[0] if found else None


def _value_column(table: _Table, key: Column | None, clock: int | None, unit_given: bool) -> int:
    if key is not None:
        value = _find(table, key, "column")
        if value == clock:
            raise HistoryError(f"{table.heading(value)} is both column and time_column", "name two columns", table.file)
        if not table.numeric[value]:
            raise HistoryError(f"{table.heading(value)} does not hold numbers", "give another column", table.file)
        return value
    free = [i for i, good in enumerate(table.numeric) if good and i != clock and not _time_like(table, i)]
    for fits in (
        [i for i in free if _dimension(table.units[i]) in ("force", "pressure")],
        [i for i in free if _dimension(table.units[i]) is None and _VALUE_WORDS.match(table.names[i])],
        free if unit_given else [],
    ):
        if len(fits) == 1:
            return fits[0]
        if fits and not any(table.names) and len(fits) == 2 and clock is None:
            return fits[1]  # two columns without headings: `_first_of_two` checks that the first is a time
        if fits:
            raise HistoryError(
                f"more than one column could be the force or pressure: {table.listing(fits)}",
                f"give column = {_key(table, fits[0])}, or the one that is meant",
                table.file,
            )
    seen = table.listing(free) or "none but the time"
    if len(free) == 1:
        raise HistoryError(f"no unit of force or pressure for {seen}", _SCALE_REMEDY, table.file)
    what = (
        "no column is a force or pressure by its name and unit" if any(table.names) else "the columns have no headings"
    )
    remedy = "the file must hold a column of force or pressure"
    if free:
        remedy = f'give column = {_key(table, free[-1])}, or another, with its unit, unit = "bar"'
    raise HistoryError(f"{what}; the columns of numbers are: {seen}", remedy, table.file)


def _key(table: _Table, i: int) -> str:
    unique = table.names[i] and table.names.count(table.names[i]) == 1
    return f'"{table.names[i]}"' if unique else str(i + 1)


def _first_of_two(table: _Table, value: int, notes: list[str]) -> int | None:
    """Of two columns without headings the first is the time when it increases like one."""
    if len(table.names) != 2 or value != 1:
        return None
    time = table.read([0])[0]
    if not np.all(np.diff(time) > 0):
        return None
    notes.append("the first of two columns without headings is taken as the time")
    return 0


def _scale_of(table: _Table, value: int) -> tuple[float, str]:
    unit = table.units[value]
    if unit is None:
        raise HistoryError(f"no unit of force or pressure for {table.heading(value)}", _SCALE_REMEDY, table.file)
    try:
        return unit_scale(unit, ("force", "pressure"), "unit")
    except UnitError as error:
        raise HistoryError(
            f'{table.heading(value)}: "{unit}" is no unit of force or pressure',
            "; ".join(filter(None, [error.remedy, 'give unit = "bar", or the one that is meant'])),
            table.file,
        ) from None


def _time_scale(table: _Table, clock: int, notes: list[str]) -> float:
    unit = table.units[clock]
    if unit is None:
        notes.append(f"the time in {table.heading(clock)} has no unit and is taken to be in seconds")
        return 1.0
    try:
        return unit_scale(unit, ("time",), "unit")[0]
    except UnitError as error:
        raise HistoryError(
            f'{table.heading(clock)}: "{unit}" is no unit of time',
            error.remedy or 'give sample_rate = "50 kHz"',
            table.file,
        ) from None


def _rate(sample_rate: float | str) -> float:
    rate = si(sample_rate, "frequency" if isinstance(sample_rate, str) else "dimensionless", "sample_rate")
    if rate <= 0.0:
        raise UnitError("sample_rate", sample_rate, 'a frequency greater than 0, such as "50 kHz"')
    return rate


# -- is it a usable series --


def _check_finite(table: _Table, columns: list[Array], numbers: list[int]) -> None:
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


def _check_time(table: _Table, time: Array, clock: int) -> None:
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


# -- text --


def _read_text(path: Path) -> _Table:
    file = str(path)
    lines = _decode(path, file).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    rows = [i for i, line in enumerate(lines) if line and (text := line.lstrip()) and text[0] not in "#%"]
    if not rows:
        raise HistoryError("holds no data", "the file must hold rows of numbers", file)
    form = _Form.of([lines[i] for i in rows[len(rows) // 4 :: max(1, len(rows) // 40)]])
    if not any(form.numeric):
        raise HistoryError(
            f'no column of numbers; the first line is "{lines[rows[0]].strip()[:60]}"',
            "expected rows of numbers with ',', ';', tab or blanks between the columns",
            file,
        )
    first = next((n for n, i in enumerate(rows) if form.fits(lines[i])), len(rows))
    if first and form.some_numbers(lines[rows[first - 1]]):
        first -= 1  # a damaged first row, no heading: refused below with its line
    names, units = _headings(form, [lines[i] for i in rows[:first]], lines[: rows[min(first, len(rows) - 1)]])
    data = rows[first:]

    def read(columns: list[int]) -> list[Array]:
        return _numbers(form, lines, data, columns, file)

    return _Table(file, names, units, form.numeric, read, lambda i: f"line {data[i] + 1}")


def _decode(path: Path, file: str) -> str:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise HistoryError(f"cannot be read ({error.strerror})", "check its permissions", file) from None
    binary = HistoryError(
        "is not text", "expected rows of numbers; .mat, .h5, .tdms and .wav are known by their ending", file
    )
    try:
        if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
            return raw.decode("utf-16")
        if re.search(rb"[\x00-\x08\x0e-\x1b\x7f]", raw[:65536]) or b"\0" in raw:
            raise binary
        try:
            return raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            return raw.decode("cp1252")  # loggers write µ and ² so
    except UnicodeDecodeError:
        raise binary from None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


@dataclass(frozen=True)
class _Form:
    """How the rows are written."""

    delimiter: str | None  # None: blanks
    decimal: str
    quoted: bool
    numeric: list[bool]

    @classmethod
    def of(cls, sample: Sequence[str]) -> _Form:
        """Found by a vote of some rows from all over the file."""
        delimiter = Counter(cls._delimiter(line) for line in sample).most_common(1)[0][0]
        quoted = any('"' in line for line in sample)
        bare = cls(delimiter, ".", quoted, [])
        cells = [bare.cells(line) for line in sample]
        decimal = ","
        if delimiter == "," or not any(re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", c) for row in cells for c in row):
            decimal = "."
        columns = Counter(len(row) for row in cells).most_common(1)[0][0]
        cells = [[c.replace(decimal, ".") for c in row] for row in cells if len(row) == columns]
        numeric = [2 * sum(_is_number(row[j]) for row in cells) >= len(cells) for j in range(columns)]
        return cls(delimiter, decimal, quoted, numeric)

    @staticmethod
    def _delimiter(line: str) -> str | None:
        for delimiter in ";\t":
            if delimiter in line:
                return delimiter
        parts = line.split()
        if len(parts) > 1 and all(re.fullmatch(r"[-+]?\d+(,\d+)?([eE][-+]?\d+)?", part) for part in parts):
            return None  # "0,001 12,5" and "1 12"
        return "," if "," in line else None

    def cells(self, line: str) -> list[str]:
        if self.delimiter is None:
            return line.split()
        if '"' in line:
            return [c.strip() for c in next(csv.reader([line], delimiter=self.delimiter, skipinitialspace=True))]
        return [c.strip() for c in line.split(self.delimiter)]

    def values(self, line: str) -> list[str]:
        return [c.replace(self.decimal, ".") for c in self.cells(line)]

    def fits(self, line: str) -> bool:
        row = self.values(line)
        return len(row) == len(self.numeric) and all(_is_number(c) for c, n in zip(row, self.numeric, strict=True) if n)

    def some_numbers(self, line: str) -> bool:
        row = self.values(line)
        return len(row) == len(self.numeric) and any(_is_number(c) for c, n in zip(row, self.numeric, strict=True) if n)


def _headings(form: _Form, rows: list[str], above: list[str]) -> tuple[list[str], list[str | None]]:
    """Names and units, from the rows above the data or from the last comment there."""
    count = len(form.numeric)
    comments = [line.lstrip(" \t#%") for line in above if line.lstrip()[:1] in ("#", "%")]
    for lines in (rows, comments[-1:]):
        cells = [form.cells(re.sub(r"\s+(?=[\[(])", "", t) if form.delimiter is None else t) for t in lines[-2:]]
        cells = [row for row in cells if len(row) == count]
        if not cells:
            continue
        bare = [c.strip("[](){} ") for c in cells[-1]]
        known = [_dimension(c) in ("time", "force", "pressure") for c in bare]
        if all(known) or (len(cells) == 2 and 2 * sum(known) >= count):  # a row of units
            names = cells[0] if len(cells) == 2 else [""] * count
            return [n.strip() for n in names], [c or None for c in bare]
        pairs = [split_header(c) for c in cells[-1]]
        return [p[0] for p in pairs], [p[1] for p in pairs]
    return [""] * count, [None] * count


def _numbers(form: _Form, lines: list[str], data: list[int], columns: list[int], file: str) -> list[Array]:
    rows = [lines[i] for i in data]
    try:
        if form.quoted or any('"' in row for row in (rows[0], rows[-1])):
            split = [form.values(row) for row in rows]
            if len({len(row) for row in split}) == 1:
                return [np.array([row[j] for row in split]).astype(float) for j in columns]
        else:
            sep = form.delimiter
            sizes = {len(row.split()) for row in rows} if sep is None else {row.count(sep) + 1 for row in rows}
            if sizes == {len(form.numeric)}:
                rows = rows if form.decimal == "." else [row.replace(",", ".") for row in rows]
                table = np.loadtxt(rows, delimiter=sep, usecols=columns, comments=None, ndmin=2)
                return [np.ascontiguousarray(c) for c in table.T]
    except ValueError:
        pass  # found and named below
    for i in data:
        cells = form.values(lines[i])
        if len(cells) != len(form.numeric):
            raise HistoryError(
                f"line {i + 1} has {len(cells)} cells, the others {len(form.numeric)}",
                "every row must have the same columns: mend or delete this line",
                file,
            )
        for j in columns:
            if not _is_number(cells[j]):
                what = f'"{cells[j][:40]}" is not a number' if cells[j] else f"the cell in column {j + 1} is empty"
                raise HistoryError(
                    f"line {i + 1}: {what}", "mend or delete this line, or make it a comment with #", file
                )
    raise HistoryError("the numbers cannot be read", "write them as plain decimal numbers", file)


# -- other formats: each gives named arrays --


def _arrays_table(
    file: str, arrays: Iterable[tuple[str, str | None, npt.NDArray[Any]]], sample_rate: float | None = None
) -> _Table:
    """A table of the one-dimensional numeric arrays, and of the columns of two-dimensional ones."""
    names: list[str] = []
    units: list[str | None] = []
    data: list[Array] = []
    for name, unit, array in arrays:
        flat = np.squeeze(np.asarray(array))
        if flat.dtype.kind not in "iuf" or flat.ndim > 2:
            continue
        if flat.ndim == 0:
            if name.split("/")[-1].lower() in {"fs", "sample_rate", "samplerate", "sampling_rate"} and flat > 0:
                sample_rate = float(flat)
            continue
        block = np.atleast_2d(flat) if flat.ndim == 1 or flat.shape[0] < flat.shape[1] else flat.T
        plain, own = split_header(name)
        for j, row in enumerate(block):
            names.append(plain if len(block) == 1 else f"{plain}:{j + 1}")
            units.append(unit or own)
            data.append(row.astype(float))
    if not data:
        raise HistoryError("holds no array of numbers", "save time and force or pressure as plain arrays", file)
    return _Table(
        file, names, units, [True] * len(data), lambda columns: [data[i] for i in columns], sample_rate=sample_rate
    )


def _damaged(path: Path, kind: str, error: Exception) -> HistoryError:
    return HistoryError(f"is no readable {kind} file ({error})"[:300], "save it again, or export it as CSV", str(path))


def _read_mat(path: Path) -> _Table:
    try:
        from scipy.io import loadmat
    except ImportError:
        raise MissingExtraError("scipy", "io") from None
    try:
        content = loadmat(path)
    except NotImplementedError:  # MATLAB 7.3 writes HDF5
        return _read_h5(path)
    except Exception as error:  # a damaged file raises whatever it happens to hit
        raise _damaged(path, "MATLAB", error) from None
    return _arrays_table(
        str(path), [(k, None, v) for k, v in content.items() if not k.startswith("__") and isinstance(v, np.ndarray)]
    )


def _read_h5(path: Path) -> _Table:
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("h5py", "io") from None
    found: list[tuple[str, str | None, npt.NDArray[Any]]] = []
    rates: list[float] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "iuf":
            unit = next((item.attrs[a] for a in ("unit", "units") if a in item.attrs), None)
            found.append((name, unit.decode() if isinstance(unit, bytes) else unit, item[()]))
            rates.extend(float(item.attrs[a]) for a in ("sample_rate", "fs") if a in item.attrs)

    try:
        with h5py.File(path, "r") as content:
            rates.extend(float(content.attrs[a]) for a in ("sample_rate", "fs") if a in content.attrs)
            content.visititems(visit)
    except Exception as error:  # as above
        raise _damaged(path, "HDF5", error) from None
    return _arrays_table(str(path), found, rates[0] if rates else None)


def _read_tdms(path: Path) -> _Table:
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MissingExtraError("npTDMS", "io") from None
    try:
        groups = TdmsFile.read(path).groups()
        channels = [(group, channel) for group in groups for channel in group.channels()]
        steps = [float(c.properties["wf_increment"]) for _, c in channels if "wf_increment" in c.properties]
        found = [
            (c.name if len(groups) == 1 else f"{g.name}/{c.name}", c.properties.get("unit_string") or None, c[:])
            for g, c in channels
        ]
    except Exception as error:  # as above
        raise _damaged(path, "TDMS", error) from None
    return _arrays_table(str(path), found, 1.0 / steps[0] if steps and steps[0] > 0 else None)


def _read_wav(path: Path) -> _Table:
    try:
        from scipy.io import wavfile
    except ImportError:
        raise MissingExtraError("scipy", "io") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # unknown chunks are of no interest
            rate, data = wavfile.read(path)
    except Exception as error:  # as above
        raise _damaged(path, "WAV", error) from None
    if data.dtype.kind in "iu":
        bits = 8 * data.dtype.itemsize
        data = (data.astype(float) - (128.0 if data.dtype.kind == "u" else 0.0)) / math.ldexp(1.0, bits - 1)
    return _arrays_table(str(path), [("channel", None, data)], float(rate))


_READERS: dict[str, Callable[[Path], _Table]] = {
    ".mat": _read_mat,
    ".h5": _read_h5,
    ".hdf5": _read_h5,
    ".tdms": _read_tdms,
    ".wav": _read_wav,
}
