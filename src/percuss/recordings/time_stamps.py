"""Stamps of date and time of day, as loggers write them, turned into seconds from the first one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date

import numpy as np

from percuss.recordings.arrays import Array

__all__ = ["is_stamp", "seconds_of"]

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

    Raises
    ------
    ValueError
        With the number of the first cell that is not a stamp, or whose date is ambiguous, and why.
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
