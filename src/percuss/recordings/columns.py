"""What a file of measured series holds, which of its columns are meant, and in what unit each is."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import cast

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError, UnitError
from percuss.units import DIMENSIONS, TIME_WORDS, known_dimension, split_header, unit_scale

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

# ---- What is looked for in a recording: forces and pressures of a load, or strains and stresses of a gauge


@dataclass(frozen=True)
class ColumnQuery:
    """The quantities that a column may be of, how such columns are called, and how messages speak of them.

    `dimensions` are those of `percuss.units`, in the order in which a unit is tried; `words` what the heading of such a
    column begins with; `named` the quantities in a message; `unit` and `heading` a usual unit and a heading with it,
    for remedies; `length` how much of a record is needed besides samples.
    """

    dimensions: tuple[str, ...]
    words: re.Pattern[str]
    named: str
    unit: str
    heading: str
    length: str = ""

    @property
    def unit_remedy(self) -> str:
        """How to say what the unit is."""
        return f'give unit = "{self.unit}" (or "kN", …), or write it in the heading: "{self.heading} [{self.unit}]"'


LOAD = ColumnQuery(
    ("force", "pressure"),
    re.compile(
        r"(p|f|force|kraft|kraeften|druck|press\w*|pressure|tryck|pression|presion|paine|voima|fuerza|load|last)"
        r"(\d|\b|_)",
        re.IGNORECASE,
    ),
    "force or pressure",
    "bar",
    "pressure",
    ", over two whole cycles or more,",
)

_GAUGE = ColumnQuery(
    ("strain", "pressure", "force"),
    re.compile(
        r"(strain|stress|force|gauge|gage|eps|epsilon|ε|sigma|σ|dms|dehnung|spannung|kraft|töjning|tojning|spänning|"
        r"déformation|deformation|contrainte|f)(\d|\b|_)",
        re.IGNORECASE,
    ),
    "strain, stress or force",
    "µm/m",
    "strain",
)

QUERIES = {"load": LOAD, "gauge": _GAUGE}  # by the word that `read_recording` takes


# ---- What a file of measured series holds, before a column is chosen

RATE_REMEDY = 'give the rate of the recorder, in the form sample_rate = "… kHz"'  # where nothing in the file tells it


@dataclass(frozen=True)
class RecordedTable:
    """What a file holds, before a column is chosen."""

    file: str
    names: list[str]  # headings without their units; "" where there is none
    units: list[str | None]
    numeric: list[bool]
    read: Callable[[list[int]], list[Array]]
    where: Callable[[int], str] = lambda i: f"sample {i + 1}"
    sample_rate: float | None = None  # as the file itself says
    stamped: tuple[int, ...] = ()  # columns of dates and times of day, …
    stamps: Callable[[int], list[str]] = lambda i: []  # … and their cells
    query: ColumnQuery = LOAD

    def refused(self, message: str, remedy: str) -> HistoryError:
        """An error that names the file."""
        return HistoryError(message, remedy, self.file)

    def heading(self, i: int) -> str:
        name = f'"{self.names[i]}"' if self.names[i] else f"column {i + 1}"
        return f"{name} [{self.units[i]}]" if self.units[i] else name

    def listing(self, columns: Iterable[int]) -> str:
        shown = [self.heading(i) for i in columns]
        return ", ".join(shown[:12]) + (f" and {len(shown) - 12} more" if len(shown) > 12 else "")


def as_rate(rate: float) -> str:
    """A sample rate as it is written in a case file."""
    return f'"{1e-3 * rate:.6g} kHz"' if rate > 999.9995 else f'"{rate:.6g} Hz"'


def dimension(unit: str | None) -> str | None:
    """What a unit in a heading measures, as far as the closed table knows."""
    return known_dimension(unit, ("time", "force", "pressure", *DIMENSIONS)) if unit else None


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
    """Seconds from the first stamp; half a day back is midnight, zones are ignored, dates count if they change."""
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


# ---- Which column of a table is the time and which holds the values, and in what unit each is

Column = str | int


def _find(table: RecordedTable, key: Column, option: str) -> int:
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


def _find_values(table: RecordedTable, key: Column, option: str, taken: Mapping[str, int | None]) -> int:
    """The column of numbers that `key` names, and that no other option has taken."""
    found = _find(table, key, option)
    for other, column in taken.items():
        if found == column:
            raise table.refused(f"{table.heading(found)} is both {option} and {other}", "name two columns")
    if not table.numeric[found]:
        raise table.refused(f"{table.heading(found)} does not hold numbers", "give another column")
    return found


def _likely_values(table: RecordedTable, clock: int | None, unit_given: bool) -> int:
    """The only column of values that could be meant."""
    free = [i for i, good in enumerate(table.numeric) if good and i != clock and not _time_like(table, i)]
    for fits in (
        [i for i in free if (unit := table.units[i]) is not None and known_dimension(unit, table.query.dimensions)],
        [i for i in free if dimension(table.units[i]) is None and table.query.words.match(table.names[i])],
        free if unit_given else [],
    ):
        if len(fits) == 1:
            return fits[0]
        if fits and not any(table.names) and len(fits) == 2 and clock is None:
            return fits[1]  # two columns without headings: `_first_of_two` checks that the first is a time
        if fits:
            raise table.refused(
                f"more than one column could be the {table.query.named}: {table.listing(fits)}",
                f"give column = {_key(table, fits[0])}, or the one that is meant",
            )
    seen = table.listing(free) or "none but the time"
    if len(free) == 1:
        raise table.refused(f"no unit of {table.query.named} for {seen}", table.query.unit_remedy)
    what = (
        f"no column is a {table.query.named} by its name and unit"
        if any(table.names)
        else "the columns have no headings"
    )
    remedy = f"the file must hold a column of {table.query.named}"
    if free:
        remedy = f'give column = {_key(table, free[-1])}, or another, with its unit, unit = "{table.query.unit}"'
    raise table.refused(f"{what}; the columns of numbers are: {seen}", remedy)


def _key(table: RecordedTable, i: int) -> str:
    unique = table.names[i] and table.names.count(table.names[i]) == 1
    return f'"{table.names[i]}"' if unique else str(i + 1)


def _first_of_two(table: RecordedTable, value: int, notes: list[str]) -> int | None:
    """Of two columns without headings the first is the time when it increases like one."""
    if len(table.names) != 2 or value != 1:
        return None
    time = table.read([0])[0]
    if not np.all(np.diff(time) > 0):
        return None
    notes.append("the first of two columns without headings is taken as the time")
    return 0


def _value_scale(table: RecordedTable, value: int) -> tuple[float, str]:
    """What 1 in the column is in SI units, and the quantity."""
    unit = table.units[value]
    if unit is None:
        raise table.refused(f"no unit of {table.query.named} for {table.heading(value)}", table.query.unit_remedy)
    try:
        return unit_scale(unit, table.query.dimensions, "unit")
    except UnitError as error:
        raise table.refused(
            f'{table.heading(value)}: "{unit}" is not a unit of {table.query.named}',
            "; ".join(filter(None, [error.remedy, f'give unit = "{table.query.unit}", or the one that is meant'])),
        ) from None


def seconds(table: RecordedTable, clock: int, notes: list[str]) -> Array:
    """The column of time in seconds; stamps of date and time of day count from the first."""
    if clock in table.stamped:
        try:
            return seconds_of(table.stamps(clock))
        except ValueError as error:
            row, what = error.args
            raise table.refused(f"{table.where(row)}: {what}", f"write the time in seconds, or {RATE_REMEDY}") from None
    unit, scale = table.units[clock], 1.0
    if unit is None:
        notes.append(f"the time in {table.heading(clock)} has no unit and is taken to be in seconds")
    else:
        try:
            scale = unit_scale(unit, ("time",), "unit")[0]
        except UnitError as error:
            what = f'{table.heading(clock)}: "{unit}" is not a unit of time'
            raise table.refused(what, error.remedy or RATE_REMEDY) from None
    return table.read([clock])[0] * scale


Scale = tuple[float, str]  # what 1 in a column stands for, in SI, and of which quantity


def given_scale(table: RecordedTable, unit: str | None, path: Path) -> Scale | None:
    """What the option `unit` says; a .wav file cannot do without."""
    found = None if unit is None else unit_scale(unit, table.query.dimensions, "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise table.refused(
            "a .wav file holds fractions of full scale, without a unit", 'say what full scale is: unit = "12 MPa"'
        )
    return found


def chosen_columns(
    table: RecordedTable,
    options: tuple[Column | None, Column | None, Column | None],
    rate: float | None,
    has_unit: bool,
    notes: list[str],
) -> tuple[int | None, list[int]]:
    """The number of the column of time, if there is one, and those of the values: of the face, of the opposing one."""
    column, time_column, opposing_column = options
    clock = None if rate is not None and time_column is None else find_time(table, time_column, column)
    taken = {"time_column": clock}
    value = _likely_values(table, clock, has_unit) if column is None else _find_values(table, column, "column", taken)
    faces = [value]
    if opposing_column is not None:
        faces.append(_find_values(table, opposing_column, "opposing_column", {"column": value, **taken}))
    if clock is None and column is None and time_column is None and not any(table.names) and rate is None:
        clock = _first_of_two(table, value, notes)
    return clock, faces


def scales_of(
    table: RecordedTable, faces: list[int], unit: str | None, given: Scale | None, notes: list[str]
) -> list[Scale]:
    """What 1 stands for in each column of values."""
    scales = [given or _value_scale(table, face) for face in faces]
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
        own = _value_scale(table, value)
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


# ---- Samples without a value: how they are left out of a record, and how many may be

MOST_MISSING = 0.1  # the share of the samples that may be missing


def without_gaps(time: Array, values: list[Array], table: RecordedTable, notes: list[str]) -> tuple[Array, list[Array]]:
    """The samples of which all values are there; nothing is filled in: cycles are fitted to samples as they lie."""
    there = np.all(np.isfinite(values), axis=0)
    missing = int(time.size - np.count_nonzero(there))
    if missing == 0:
        return time, values
    first = int(np.argmin(there))
    if missing > MOST_MISSING * time.size:
        raise table.refused(
            f"{missing} of {time.size} samples have no value, the first at {time[first]:.6g} s",
            f"at most {100.0 * MOST_MISSING:.0f} % may be missing: cut the record (from, to), or record again",
        )
    kept = time[there]
    gaps = np.flatnonzero(np.diff(np.concatenate([[1], there.astype(int), [1]])) == -1).size
    longest = float(np.max(np.diff(kept)))
    notes.append(
        f"{missing} of {time.size} samples have no value, in {gaps} gap{'s' if gaps > 1 else ''} of at most "
        f"{1e3 * longest:.3g} ms; they are left out, and nothing is filled in"
    )
    return kept, [v[there] for v in values]
