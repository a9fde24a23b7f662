"""Reading a measured history from a file: force or pressure of a load, what a gauge saw, or a series of blows.

Text (comma, semicolon, tab or blank between the columns, decimal comma, headings with units) needs numpy only;
``.mat``, ``.wav``, ``.h5`` and ``.tdms`` need the extra ``[io]``. Nothing is guessed that could be wrong in silence:
what is ambiguous or has no unit is refused, and the refusal names the columns and the key that settles it.
"""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from percuss.errors import HistoryError, ParameterError, UnitError
from percuss.recordings.columns import (
    QUERIES,
    RATE_REMEDY,
    Array,
    Column,
    RecordedTable,
    against_clock,
    as_rate,
    chosen_columns,
    find_time,
    given_scale,
    scales_of,
    seconds,
    without_gaps,
)
from percuss.recordings.file_formats import READERS
from percuss.recordings.text_table import read_text
from percuss.short_repr import ShortRepr
from percuss.units import si, unit_scale

# ---- What a caller says of a recording, checked before its file is opened: path, columns, rate, moments


def _file_path(value: object) -> Path:
    """The path of a file; bytes and the numbers of open files are none."""
    try:
        found = os.fspath(value)  # type: ignore[call-overload]  # whatever is no path is refused below
    except TypeError:
        found = None
    if not isinstance(found, str):
        raise ParameterError("path", value, "a path: text or a pathlib.Path")
    return Path(found)


def _in_hertz(sample_rate: float | str) -> float:
    """A sample rate in Hz, from a number in Hz or from text such as "50 kHz"."""
    rate = si(sample_rate, "frequency" if isinstance(sample_rate, str) else "dimensionless", "sample_rate")
    if rate <= 0.0:
        raise UnitError("sample_rate", sample_rate, 'a frequency greater than 0, such as "50 kHz"')
    return rate


def _in_seconds(value: float | str, name: str) -> float:
    """A moment in s, from a number in s or from text such as "0.2 s"."""
    return si(value, "time" if isinstance(value, str) else "dimensionless", name)


# ---- Whether columns make a usable series: enough samples, finite ones, over a time that increases; and a part of it

_MIN_SAMPLES = 16


def _check_sizes(table: RecordedTable, time: Array, values: list[Array], clock: int, value: int) -> None:
    if time.size != values[0].size:
        remedy = f"name the time that belongs to it, time_column = …, or {RATE_REMEDY}"
        raise table.refused(
            f"{table.heading(value)} has {values[0].size} samples and {table.heading(clock)} {time.size}", remedy
        )


def _check_values(table: RecordedTable, values: list[Array], faces: list[int]) -> None:
    sizes = [v.size for v in values]
    if len(set(sizes)) > 1:
        raise table.refused(
            f"{table.heading(faces[0])} has {sizes[0]} samples, {table.heading(faces[1])} {sizes[1]}",
            "name two columns recorded together",
        )
    if sizes[0] < _MIN_SAMPLES:
        raise table.refused(f"only {sizes[0]} samples", f"at least {_MIN_SAMPLES}{table.query.length} are needed")
    for data, face in zip(values, faces, strict=True):
        bad = np.flatnonzero(np.isinf(data))
        if bad.size:
            raise table.refused(
                f"{table.where(int(bad[0]))}: {table.heading(face)} is {data[bad[0]]} ({bad.size} such values)",
                "an infinite value cannot be used: cut the record there (from, to), or empty the cell",
            )


def _check_time(table: RecordedTable, time: Array, clock: int) -> None:
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        raise table.refused(
            f"{table.where(int(bad[0]))}: {table.heading(clock)} is {time[bad[0]]} ({bad.size} such values)",
            f"a time is needed for every sample: fix or delete these lines, or {RATE_REMEDY}",
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
        raise table.refused(
            f"{table.where(i)}: the time does not increase ({time[i - 1]:.9g} s, then {time[i]:.9g} s)", remedy
        )


def _cut(
    table: RecordedTable, time: Array, values: list[Array], start: float | str | None, end: float | str | None
) -> tuple[Array, list[Array]]:
    if start is None and end is None:
        return time, values
    first = -np.inf if start is None else _in_seconds(start, "from")
    last = np.inf if end is None else _in_seconds(end, "to")
    used = (time >= first) & (time <= last)
    if not first < last or not np.any(used):
        raise table.refused(
            f"nothing lies between {first:.9g} s and {last:.9g} s: "
            f"the record goes from {time[0]:.9g} s to {time[-1]:.9g} s",
            "give from and to inside the record, from before to",
        )
    return time[used], [v[used] if v.size == time.size else v for v in values]


# ---- Reading a measured history from a file: force or pressure of a load, strain or stress or force at a gauge

MAX_BYTES = 64 * 2**20  # the largest file that is read; 40 cycles are enough, and fill a hundredth of it


@dataclass(frozen=True)
class Recording(ShortRepr):
    """A measured history in SI units.

    Attributes
    ----------
    time, values
        Shape (n,), s, strictly increasing, and N for a force, Pa for a pressure or stress, dimensionless for a strain.
    quantity
        What the values are: "force", "pressure" (of a gauge a stress) or "strain".
    path, notes
        The file that they come from, and what was assumed in reading, one sentence each.
    opposing
        Shape (n,), the same for the opposing face, where one was asked for. Its force is subtracted.
    """

    time: Array = field(repr=False)
    values: Array = field(repr=False)
    quantity: Literal["force", "pressure", "strain"]
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
    sensor: Literal["load", "gauge"] = "load",
) -> Recording:
    """Read a history of force or pressure, or what a strain gauge saw.

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
    time_column, sample_rate
        As `column`, for the time, in seconds where it has no unit; or a rate in Hz, or text such as "50 kHz": then no
        column of time is used.
    opposing_column
        As `column`, for the same quantity on the opposing face, in the unit of its own heading, or in `unit`.
    start, end
        The part of the record that is used, both ends with it: in s, or text such as "0.2 s", on the clock of the
        record. Where that has dates or times of day, or none, it begins with 0.
    sensor
        "load" reads a force or a pressure, "gauge" a strain, a stress (told as a pressure) or a force. A strain may be
        in "µm/m", "microstrain", "µε", "mm/m", "%", "m/m" or "1e-6".

    Raises
    ------
    HistoryError
        When the file cannot be read or what is meant cannot be told; names the file, the cause and the remedy.
    UnitError
        When `unit`, `sample_rate`, `start` or `end` is not such a unit or quantity.
    ParameterError
        When `path` is no path, a column is neither a heading nor a number, or `sensor` is none of its words.
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
    path = _file_path(path)
    for option, key in (("column", column), ("time_column", time_column), ("opposing_column", opposing_column)):
        if key is not None and not isinstance(key, str | int):  # True and False are refused with the columns there are
            raise ParameterError(option, key, "the heading of a column, or its number from 1")
    if not isinstance(sensor, str) or sensor not in QUERIES:
        raise ParameterError("sensor", sensor, " or ".join(f'"{word}"' for word in QUERIES))
    _check_file(path)
    table = replace(READERS.get(path.suffix.lower(), read_text)(path), query=QUERIES[sensor])
    rate = None if sample_rate is None else _in_hertz(sample_rate)
    notes: list[str] = []
    given = given_scale(table, unit, path)
    clock, faces = chosen_columns(table, (column, time_column, opposing_column), rate, given is not None, notes)
    scales = scales_of(table, faces, unit, given, notes)
    if rate is None and clock is None and (rate := table.sample_rate) is None:
        raise table.refused(
            f"no column of time among {table.listing(range(len(table.names)))}",
            f'give time_column = "…", or {RATE_REMEDY}',
        )
    values = table.read(faces)
    if sample_rate is not None or clock is None:
        time = np.arange(values[0].size) / cast(float, rate)
        notes += against_clock(table, column, cast(float, rate))
    else:
        time = seconds(table, clock, notes)
        _check_sizes(table, time, values, clock, faces[0])
        _check_time(table, time, clock)
    time, values = _cut(table, time, values, start, end)
    _check_values(table, values, faces)
    time, values = without_gaps(time, values, table, notes)
    found = [v * scale for v, (scale, _) in zip(values, scales, strict=True)]
    opposing = found[1] if len(found) > 1 else None
    return Recording(time, found[0], cast(Any, scales[0][1]), path, tuple(notes), opposing)


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
        raise HistoryError("is empty", "the file must hold a column of values", file)


# ---- Reading measured blows: when each was struck, and what was measured of it

_OF_BLOWS = {
    "rebound_velocity": ("velocity", "rebound speed [m/s]", r"rebound|after|back|return"),
    "rigid_velocity": ("velocity", "striking speed [m/s]", r"strik|impact|before|speed|velocity"),
    "pressure": ("pressure", "pressure [bar]", r"pressure|supply|p\b"),
    "flow": ("flow", "flow [l/min]", r"flow"),
    "peaks": ("", "peak [m/s^2]", r"peak|acc"),
}
"""What may be measured of a blow, by the name of the figure: its dimension, a heading, and words of one; in order."""


@dataclass(frozen=True)
class BlowRecord(ShortRepr):
    """Measured blows in SI units, one after another.

    Attributes
    ----------
    time
        Shape (n,), s, strictly increasing: when each blow was struck.
    figures
        What was measured of each blow, shape (n,), by the name of its figure: ``rigid_velocity`` and
        ``rebound_velocity``, m/s, of the bar as a whole just before and after it, ``pressure``, Pa, and ``flow``, m³/s,
        means of the supply over its cycle. NaN where nothing was measured.
    peaks
        Shape (n,), what an accelerometer saw of each, up to a factor; None without one.
    path, notes
        The file that they come from, and what was assumed in reading, one sentence each.
    """

    time: Array = field(repr=False)
    figures: Mapping[str, Array] = field(default_factory=dict, repr=False)
    peaks: Array | None = field(default=None, repr=False)
    path: Path | None = None
    notes: tuple[str, ...] = ()

    @property
    def file(self) -> str | None:
        """The name of the file, for messages."""
        return None if self.path is None else str(self.path)


def read_blows(path: str | os.PathLike[str]) -> BlowRecord:
    """Read a table of measured blows, a row for each: a column of times, and columns of what was measured.

    Headings say what they hold, and their units: "rebound speed [m/s]", "striking speed [m/s]", "pressure [bar]" and
    "flow [l/min]" of the supply, or "peak [m/s^2]" of an accelerometer, whose unit is of no account. Any other column
    is left out, with a note.

    Raises
    ------
    HistoryError
        When the file cannot be read or what is meant cannot be told; names the file, the cause and the remedy.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "times.csv")
    ...     _ = file.write_text("time [ms],rebound speed [m/s]\\n" + "".join(f"{100 * i},1.5\\n" for i in range(20)))
    ...     record = read_blows(file)
    >>> record.time[:2].tolist(), list(record.figures)
    ([0.0, 0.1], ['rebound_velocity'])
    """
    path = _file_path(path)
    _check_file(path)
    table = READERS.get(path.suffix.lower(), read_text)(path)
    notes: list[str] = []
    clock = find_time(table, None, None)
    if clock is None:
        raise table.refused(
            f"no column of times among {table.listing(range(len(table.names)))}", 'name the column "time [s]"'
        )
    time = seconds(table, clock, notes)
    if time.size < _MIN_SAMPLES:
        raise table.refused(f"only {time.size} blows", f"at least {_MIN_SAMPLES} are needed")
    _check_time(table, time, clock)
    found: dict[str, Array] = {}
    for i in (i for i, good in enumerate(table.numeric) if good and i != clock):
        heading = table.names[i].lower()
        name = next((name for name, (_, _, words) in _OF_BLOWS.items() if re.search(rf"\b({words})", heading)), "")
        if not name:
            notes.append(f"{table.heading(i)} is not used: its heading names nothing that is known of blows")
            continue
        dimension, usual, _ = _OF_BLOWS[name]
        if name in found:
            raise table.refused(f"two columns could be the {usual.partition(' [')[0]}", "leave one of them out")
        scale = 1.0
        if dimension:
            if (unit := table.units[i]) is None:
                raise table.refused(f"no unit of {dimension} for {table.heading(i)}", f'head it so: "{usual}"')
            scale = unit_scale(unit, (dimension,), table.heading(i))[0]
        (values,) = table.read([i])
        found[name] = values * scale * (-1.0 if np.nanmean(values) < 0.0 else 1.0)
    return BlowRecord(time, found, found.pop("peaks", None), path, tuple(notes))
