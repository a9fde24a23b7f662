"""Tables in text: what stands between the columns, the decimal sign and the headings are found from the rows."""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import cast

import numpy as np

from percuss.errors import HistoryError, UnitError
from percuss.recordings.table import RATE_REMEDY, Array, RecordedTable, as_rate, dimension
from percuss.units import TIME_WORDS, known_dimension, split_header, unit_scale

# ---- Stamps of date and time of day, as loggers write them, turned into seconds from the first one

_STAMP = re.compile(
    r"""(?:(?P<date>\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4})[T\s]+)?   # 2026-03-01, 01.03.2026, 3/1/2026
        (?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second>\d{2})(?:[.,:](?P<fraction>\d{1,12}))?)?
        \s*(?P<half>[AaPp]\.?[Mm]\.?)?
        \s*(?P<zone>Z|UTC|[-+]\d{2}:?\d{2})?""",
    re.VERBOSE,
)
_DAY = 86400.0


def is_stamp(cell: str) -> bool:
    """Whether a cell is a time of day, with or without a date before it."""
    return _STAMP.fullmatch(cell.strip()) is not None


def seconds_of(cells: Sequence[str]) -> Array:
    """Seconds from the first stamp.

    A time of day that falls back by more than half a day has passed midnight. The time zone is left alone: it is that
    of one recorder. The date counts only where it changes.
    """
    seconds = np.empty(len(cells))
    days: dict[str, int] = {}
    for i, cell in enumerate(cells):
        match = _STAMP.fullmatch(cell.strip())
        if match is None:
            raise ValueError(i, f'"{cell[:40]}" is not a time of day')
        hour = int(match["hour"])
        if match["half"]:
            hour = hour % 12 + (12 if match["half"][0] in "Pp" else 0)
        fraction = float(f"0.{match['fraction']}") if match["fraction"] else 0.0
        seconds[i] = 3600.0 * hour + 60.0 * int(match["minute"]) + int(match["second"] or 0) + fraction
        day = match["date"] or ""
        if day not in days:
            days[day] = i
    order = {day: _ordinal(day, i) for day, i in days.items()} if len(days) > 1 else {}
    if order:
        first = min(order.values())
        for i, cell in enumerate(cells):
            match = _STAMP.fullmatch(cell.strip())
            assert match is not None
            seconds[i] += _DAY * (order[match["date"] or ""] - first)
    else:
        seconds += _DAY * np.concatenate([[0.0], np.cumsum(np.diff(seconds) < -0.5 * _DAY)])
    return np.asarray(seconds - seconds[0])


def _ordinal(day: str, i: int) -> int:
    """The number of a day; with strokes a date may mean two days, and is refused."""
    parts = re.split(r"[-/.]", day)
    if len(parts[0]) == 4:
        year, month, number = map(int, parts)
    elif len(parts[-1]) == 4 and "/" not in day:
        number, month, year = map(int, parts)
    else:
        raise ValueError(i, f'the date "{day}" can be read in more than one way')
    try:
        return date(year, month, number).toordinal()
    except ValueError:
        raise ValueError(i, f'"{day}" is not a date') from None


# ---- Tables in text: what stands between the columns, the decimal sign and the headings are found from the rows

LONGEST_LINE = 20_000
"""Characters of one line: millions of columns would be looked at one by one."""


def read_text(path: Path) -> RecordedTable:
    """The table in a file of text."""
    file = str(path)
    lines = _decode(path, file).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if max(map(len, lines)) > LONGEST_LINE:
        raise HistoryError(f"a line of more than {LONGEST_LINE} characters", "write a line for each sample", file)
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

    def cells(column: int) -> list[str]:
        rows = [form.cells(lines[i]) for i in data]
        return [row[column] if column < len(row) else "" for row in rows]

    where = "line {}".format
    stamped = tuple(j for j, stamp in enumerate(form.stamped) if stamp)
    return RecordedTable(
        file, names, units, form.numeric, read, lambda i: where(data[i] + 1), stamped=stamped, stamps=cells
    )


def _decode(path: Path, file: str) -> str:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise HistoryError(f"cannot be read ({error.strerror})", "check its permissions", file) from None
    binary = HistoryError(
        "is not text", "expected rows of numbers; .mat, .h5, .tdms and .wav are recognised by their extension", file
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


_MISSING = frozenset({"", "-", "--", "---", "na", "n/a", "#n/a", "nan", "null", "none"})


def _is_missing(cell: str) -> bool:
    """Whether a cell says that there is no value: nothing, NaN, or one of the words and signs that loggers write."""
    return cell.lower() in _MISSING


@dataclass(frozen=True)
class _Form:
    """How the rows are written."""

    delimiter: str | None  # None: blanks
    decimal: str
    quoted: bool
    numeric: list[bool]
    stamped: list[bool]

    @classmethod
    def of(cls, sample: Sequence[str]) -> _Form:
        """Found by a vote of some rows from all over the file."""
        delimiter = Counter(cls._delimiter(line) for line in sample).most_common(1)[0][0]
        quoted = any('"' in line for line in sample)
        bare = cls(delimiter, ".", quoted, [], [])
        cells = [bare.cells(line) for line in sample]
        decimal = ","
        if delimiter == "," or not any(re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", c) for row in cells for c in row):
            decimal = "."
        columns = Counter(len(row) for row in cells).most_common(1)[0][0]
        raw = [row for row in cells if len(row) == columns]
        cells = [[c.replace(decimal, ".") for c in row] for row in raw]
        numeric = [2 * sum(_is_number(row[j]) for row in cells) >= len(cells) for j in range(columns)]
        stamped = [not numeric[j] and 2 * sum(is_stamp(row[j]) for row in raw) >= len(raw) for j in range(columns)]
        return cls(delimiter, decimal, quoted, numeric, stamped)

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
        if len(row) != len(self.numeric):
            return False
        cells = [c for c, n in zip(row, self.numeric, strict=True) if n]
        return all(_is_number(c) or _is_missing(c) for c in cells) and any(_is_number(c) for c in cells)

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
        known = [dimension(c) in ("time", "force", "pressure", "strain") for c in bare]
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
                "every row must have the same columns: fix or delete this line",
                file,
            )
        for j in columns:
            if not (_is_number(cells[j]) or _is_missing(cells[j])):
                raise HistoryError(
                    f'line {i + 1}: "{cells[j][:40]}" is not a number',
                    "fix or delete this line, or make it a comment with #",
                    file,
                )
    rows_of = [form.values(row) for row in rows]
    return [np.array([math.nan if _is_missing(row[j]) else float(row[j]) for row in rows_of]) for j in columns]


# ---- Which column of a table is the time and which holds the values, and in what unit each is

Column = str | int


def _find(table: RecordedTable, key: Column, option: str) -> int:
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
                raise table.refused(
                    f'{option} = "{key}" fits more than one column: {table.listing(matches)}',
                    f"give the number of the column instead, {option} = {matches[0] + 1}",
                )
    number = int(key) if isinstance(key, int) or (key.strip().isdecimal() and len(key) < 9) else 0
    if isinstance(key, bool) or not 1 <= number <= len(table.names):
        near = difflib.get_close_matches(str(key), table.names, n=1) if isinstance(key, str) else []
        hint = (
            f'did you mean "{near[0]}"?' if near else f"{option} is a heading or a number from 1 to {len(table.names)}"
        )
        raise table.refused(f"no column {key!r}; the columns are {table.listing(every)}", hint)
    return number - 1


def _time_like(table: RecordedTable, i: int) -> bool:
    words = re.split(r"[\W\d_]+", table.names[i].lower())
    named = table.names[i] != "T" and any(word in TIME_WORDS for word in words)
    return dimension(table.units[i]) == "time" or (named and table.units[i] is None)


def _is_sought(table: RecordedTable, i: int) -> bool:
    unit = table.units[i]
    return unit is not None and known_dimension(unit, table.sought.dimensions) is not None


def find_time(table: RecordedTable, key: Column | None, column: Column | None) -> int | None:
    """The column of time: the one that `key` names, else the only one like a time; None when there is none."""
    if key is not None:
        found = [_find(table, key, "time_column")]
    else:
        taken = None if column is None else _find(table, column, "column")
        found = [i for i in range(len(table.names)) if i != taken and _time_like(table, i)]
        if not any(table.numeric[i] for i in found):
            found = [i for i in table.stamped if i != taken] or found
        named = [i for i in found if table.names[i].lower() in TIME_WORDS]
        found = named if len(named) == 1 else found
    if len(found) > 1:
        raise table.refused(
            f"more than one column could be the time: {table.listing(found)}",
            f'give time_column = "{table.names[found[0]]}", or the one that is meant',
        )
    if found and not table.numeric[found[0]] and found[0] not in table.stamped:
        raise table.refused(
            f"the time in {table.heading(found[0])} is given neither as numbers nor as times of day",
            f"write the time in seconds, or {RATE_REMEDY}",
        )
    return found[0] if found else None


def find_values(table: RecordedTable, key: Column | None, clock: int | None, unit_given: bool) -> int:
    """The column of values: the one that `key` names, else the only one that could be meant."""
    if key is not None:
        value = _find(table, key, "column")
        if value == clock:
            raise table.refused(f"{table.heading(value)} is both column and time_column", "name two columns")
        if not table.numeric[value]:
            raise table.refused(f"{table.heading(value)} does not hold numbers", "give another column")
        return value
    free = [i for i, good in enumerate(table.numeric) if good and i != clock and not _time_like(table, i)]
    for fits in (
        [i for i in free if _is_sought(table, i)],
        [i for i in free if dimension(table.units[i]) is None and table.sought.words.match(table.names[i])],
        free if unit_given else [],
    ):
        if len(fits) == 1:
            return fits[0]
        if fits and not any(table.names) and len(fits) == 2 and clock is None:
            return fits[1]  # two columns without headings: `first_of_two` checks that the first is a time
        if fits:
            raise table.refused(
                f"more than one column could be the {table.sought.named}: {table.listing(fits)}",
                f"give column = {_key(table, fits[0])}, or the one that is meant",
            )
    seen = table.listing(free) or "none but the time"
    if len(free) == 1:
        raise table.refused(f"no unit of {table.sought.named} for {seen}", table.sought.unit_remedy)
    what = (
        f"no column is a {table.sought.named} by its name and unit"
        if any(table.names)
        else "the columns have no headings"
    )
    remedy = f"the file must hold a column of {table.sought.named}"
    if free:
        remedy = f'give column = {_key(table, free[-1])}, or another, with its unit, unit = "{table.sought.unit}"'
    raise table.refused(f"{what}; the columns of numbers are: {seen}", remedy)


def find_opposing(table: RecordedTable, key: Column, value: int, clock: int | None) -> int:
    """The column of the force or pressure on the opposing face."""
    found = _find(table, key, "opposing_column")
    if found in (value, clock):
        other = "column" if found == value else "time_column"
        raise table.refused(f"{table.heading(found)} is both opposing_column and {other}", "name two columns")
    if not table.numeric[found]:
        raise table.refused(f"{table.heading(found)} does not hold numbers", "give another column")
    return found


def _key(table: RecordedTable, i: int) -> str:
    unique = table.names[i] and table.names.count(table.names[i]) == 1
    return f'"{table.names[i]}"' if unique else str(i + 1)


def first_of_two(table: RecordedTable, value: int, notes: list[str]) -> int | None:
    """Of two columns without headings the first is the time when it increases like one."""
    if len(table.names) != 2 or value != 1:
        return None
    time = table.read([0])[0]
    if not np.all(np.diff(time) > 0):
        return None
    notes.append("the first of two columns without headings is taken as the time")
    return 0


def value_scale(table: RecordedTable, value: int) -> tuple[float, str]:
    """What 1 in the column is in SI units, and the quantity."""
    unit = table.units[value]
    if unit is None:
        raise table.refused(f"no unit of {table.sought.named} for {table.heading(value)}", table.sought.unit_remedy)
    try:
        return unit_scale(unit, table.sought.dimensions, "unit")
    except UnitError as error:
        raise table.refused(
            f'{table.heading(value)}: "{unit}" is not a unit of {table.sought.named}',
            "; ".join(filter(None, [error.remedy, f'give unit = "{table.sought.unit}", or the one that is meant'])),
        ) from None


def seconds(table: RecordedTable, clock: int, notes: list[str]) -> Array:
    """The column of time in seconds; stamps of date and time of day count from the first."""
    if clock in table.stamped:
        try:
            return seconds_of(table.stamps(clock))
        except ValueError as error:
            row, what = error.args
            raise table.refused(f"{table.where(row)}: {what}", f"write the time in seconds, or {RATE_REMEDY}") from None
    return table.read([clock])[0] * _time_scale(table, clock, notes)


def _time_scale(table: RecordedTable, clock: int, notes: list[str]) -> float:
    """What 1 in the column of time is in seconds."""
    unit = table.units[clock]
    if unit is None:
        notes.append(f"the time in {table.heading(clock)} has no unit and is taken to be in seconds")
        return 1.0
    try:
        return unit_scale(unit, ("time",), "unit")[0]
    except UnitError as error:
        raise table.refused(
            f'{table.heading(clock)}: "{unit}" is not a unit of time', error.remedy or RATE_REMEDY
        ) from None


# ---- Which columns of a table are meant, and what 1 in them stands for; what is ambiguous is refused

Scale = tuple[float, str]  # what 1 in a column stands for, in SI, and of which quantity


def given_scale(table: RecordedTable, unit: str | None, path: Path) -> Scale | None:
    """What the option `unit` says; a .wav file cannot do without."""
    found = None if unit is None else unit_scale(unit, table.sought.dimensions, "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise table.refused(
            "a .wav file holds fractions of full scale, without a unit", 'say what full scale is: unit = "12 MPa"'
        )
    return found


def meant_columns(
    table: RecordedTable,
    options: tuple[Column | None, Column | None, Column | None],
    rate: float | None,
    has_unit: bool,
    notes: list[str],
) -> tuple[int | None, list[int]]:
    """The number of the column of time, if there is one, and those of the values: of the face, of the opposing one."""
    column, time_column, opposing_column = options
    clock = None if rate is not None and time_column is None else find_time(table, time_column, column)
    value = find_values(table, column, clock, has_unit)
    faces = [value]
    if opposing_column is not None:
        faces.append(find_opposing(table, opposing_column, value, clock))
    if clock is None and column is None and time_column is None and not any(table.names) and rate is None:
        clock = first_of_two(table, value, notes)
    return clock, faces


def scales_of(
    table: RecordedTable, faces: list[int], unit: str | None, given: Scale | None, notes: list[str]
) -> list[Scale]:
    """What 1 stands for in each column of values."""
    scales = [given or value_scale(table, face) for face in faces]
    if len({quantity for _, quantity in scales}) > 1:
        raise table.refused(
            f"{table.heading(faces[0])} is a {scales[0][1]}, {table.heading(faces[1])} a {scales[1][1]}",
            "name two columns of the same quantity",
        )
    if given is not None:
        notes += [f for face in faces if (f := _against_heading(table, face, cast(str, unit), given))]
    return scales


def _against_heading(table: RecordedTable, value: int, unit: str, given: tuple[float, str]) -> str:
    """What to say of a `unit` that differs from that of the heading."""
    try:
        own = value_scale(table, value)
    except HistoryError:  # no unit that could be compared
        return ""
    if own == given:
        return ""
    differs = "not the quantity in" if own[1] != given[1] else f"{given[0] / own[0]:.6g} times the unit in"
    return f'unit = "{unit}" is used for {table.heading(value)}: {differs} the heading'


def against_clock(table: RecordedTable, column: Column | None, rate: float) -> list[str]:
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
