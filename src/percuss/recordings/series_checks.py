"""Whether columns make a usable series: enough samples, finite ones, over a time that increases; and a part of it."""

from __future__ import annotations

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.arrays import Array
from percuss.recordings.options import in_seconds
from percuss.recordings.table import RATE_REMEDY, Table, as_rate

__all__ = ["check_sizes", "check_time", "check_values", "cut"]

MIN_SAMPLES = 16


def check_sizes(table: Table, time: Array, values: list[Array], clock: int, value: int) -> None:
    if time.size != values[0].size:
        remedy = f"name the time that belongs to it, time_column = …, or {RATE_REMEDY}"
        raise HistoryError(
            f"{table.heading(value)} has {values[0].size} samples and {table.heading(clock)} {time.size}",
            remedy,
            table.file,
        )


def check_values(table: Table, values: list[Array], faces: list[int]) -> None:
    sizes = [v.size for v in values]
    if len(set(sizes)) > 1:
        raise HistoryError(
            f"{table.heading(faces[0])} has {sizes[0]} samples, {table.heading(faces[1])} {sizes[1]}",
            "name two columns recorded together",
            table.file,
        )
    if sizes[0] < MIN_SAMPLES:
        raise HistoryError(
            f"only {sizes[0]} samples", f"at least {MIN_SAMPLES}{table.sought.length} are needed", table.file
        )
    for data, face in zip(values, faces, strict=True):
        bad = np.flatnonzero(np.isinf(data))
        if bad.size:
            raise HistoryError(
                f"{table.where(int(bad[0]))}: {table.heading(face)} is {data[bad[0]]} ({bad.size} such values)",
                "an infinite value cannot be used: cut the record there (from, to), or empty the cell",
                table.file,
            )


def check_time(table: Table, time: Array, clock: int) -> None:
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


def cut(
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
