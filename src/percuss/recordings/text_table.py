"""Tables in text: what stands between the columns, the decimal sign and the headings are found from the rows."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.columns import Array, RecordedTable, dimension, is_stamp
from percuss.units import split_header

LONGEST_LINE = 20_000  # characters of one line: millions of columns would be looked at one by one


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
    if first and form.delimiter == "," and 2 * len(form.cells(lines[rows[first - 1]])) == len(form.numeric):
        raise HistoryError(
            f"line {rows[first] + 1} has twice as many cells as the headings: decimal commas stand between commas",
            "save it with decimal points, or with semicolons between the columns",
            file,
        )
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
    remedy = "expected rows of numbers; .mat, .h5, .tdms and .wav are recognised by their extension"
    if path.suffix.lower() in (".xlsx", ".xlsm", ".xls", ".ods"):
        remedy = "save the sheet as CSV: a file of a spreadsheet program is not read"
    binary = HistoryError("is not text", remedy, file)
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
