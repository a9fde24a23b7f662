"""Which column of a table is the time and which holds the values, and in what unit each is."""

from __future__ import annotations

import difflib
import re

import numpy as np

from percuss.errors import HistoryError, UnitError
from percuss.recordings.arrays import Array
from percuss.recordings.table import RATE_REMEDY, Table, dimension
from percuss.recordings.time_stamps import seconds_of
from percuss.units import TIME_WORDS, known_dimension, split_header, unit_scale

__all__ = ["Column", "find_opposing", "find_time", "find_values", "first_of_two", "seconds", "value_scale"]

Column = str | int


def _find(table: Table, key: Column, option: str) -> int:
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


def _time_like(table: Table, i: int) -> bool:
    words = re.split(r"[\W\d_]+", table.names[i].lower())
    named = table.names[i] != "T" and any(word in TIME_WORDS for word in words)
    return dimension(table.units[i]) == "time" or (named and table.units[i] is None)


def _is_sought(table: Table, i: int) -> bool:
    unit = table.units[i]
    return unit is not None and known_dimension(unit, table.sought.dimensions) is not None


def find_time(table: Table, key: Column | None, column: Column | None) -> int | None:
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
        raise HistoryError(
            f"more than one column could be the time: {table.listing(found)}",
            f'give time_column = "{table.names[found[0]]}", or the one that is meant',
            table.file,
        )
    if found and not table.numeric[found[0]] and found[0] not in table.stamped:
        raise HistoryError(
            f"the time in {table.heading(found[0])} is given neither as numbers nor as times of day",
            f"write the time in seconds, or {RATE_REMEDY}",
            table.file,
        )
    return found[0] if found else None


def find_values(table: Table, key: Column | None, clock: int | None, unit_given: bool) -> int:
    """The column of values: the one that `key` names, else the only one that could be meant."""
    if key is not None:
        value = _find(table, key, "column")
        if value == clock:
            raise HistoryError(f"{table.heading(value)} is both column and time_column", "name two columns", table.file)
        if not table.numeric[value]:
            raise HistoryError(f"{table.heading(value)} does not hold numbers", "give another column", table.file)
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
            raise HistoryError(
                f"more than one column could be the {table.sought.named}: {table.listing(fits)}",
                f"give column = {_key(table, fits[0])}, or the one that is meant",
                table.file,
            )
    seen = table.listing(free) or "none but the time"
    if len(free) == 1:
        raise HistoryError(f"no unit of {table.sought.named} for {seen}", table.sought.unit_remedy, table.file)
    what = (
        f"no column is a {table.sought.named} by its name and unit"
        if any(table.names)
        else "the columns have no headings"
    )
    remedy = f"the file must hold a column of {table.sought.named}"
    if free:
        remedy = f'give column = {_key(table, free[-1])}, or another, with its unit, unit = "{table.sought.unit}"'
    raise HistoryError(f"{what}; the columns of numbers are: {seen}", remedy, table.file)


def find_opposing(table: Table, key: Column, value: int, clock: int | None) -> int:
    """The column of the force or pressure on the opposing face."""
    found = _find(table, key, "opposing_column")
    if found in (value, clock):
        other = "column" if found == value else "time_column"
        raise HistoryError(
            f"{table.heading(found)} is both opposing_column and {other}", "name two columns", table.file
        )
    if not table.numeric[found]:
        raise HistoryError(f"{table.heading(found)} does not hold numbers", "give another column", table.file)
    return found


def _key(table: Table, i: int) -> str:
    unique = table.names[i] and table.names.count(table.names[i]) == 1
    return f'"{table.names[i]}"' if unique else str(i + 1)


def first_of_two(table: Table, value: int, notes: list[str]) -> int | None:
    """Of two columns without headings the first is the time when it increases like one."""
    if len(table.names) != 2 or value != 1:
        return None
    time = table.read([0])[0]
    if not np.all(np.diff(time) > 0):
        return None
    notes.append("the first of two columns without headings is taken as the time")
    return 0


def value_scale(table: Table, value: int) -> tuple[float, str]:
    """What 1 in the column is in SI units, and the quantity."""
    unit = table.units[value]
    if unit is None:
        raise HistoryError(
            f"no unit of {table.sought.named} for {table.heading(value)}", table.sought.unit_remedy, table.file
        )
    try:
        return unit_scale(unit, table.sought.dimensions, "unit")
    except UnitError as error:
        raise HistoryError(
            f'{table.heading(value)}: "{unit}" is not a unit of {table.sought.named}',
            "; ".join(filter(None, [error.remedy, f'give unit = "{table.sought.unit}", or the one that is meant'])),
            table.file,
        ) from None


def seconds(table: Table, clock: int, notes: list[str]) -> Array:
    """The column of time in seconds; stamps of date and time of day count from the first."""
    if clock in table.stamped:
        try:
            return seconds_of(table.stamps(clock))
        except ValueError as error:
            row, what = error.args
            raise HistoryError(
                f"{table.where(row)}: {what}", f"write the time in seconds, or {RATE_REMEDY}", table.file
            ) from None
    return table.read([clock])[0] * _time_scale(table, clock, notes)


def _time_scale(table: Table, clock: int, notes: list[str]) -> float:
    """What 1 in the column of time is in seconds."""
    unit = table.units[clock]
    if unit is None:
        notes.append(f"the time in {table.heading(clock)} has no unit and is taken to be in seconds")
        return 1.0
    try:
        return unit_scale(unit, ("time",), "unit")[0]
    except UnitError as error:
        raise HistoryError(
            f'{table.heading(clock)}: "{unit}" is not a unit of time',
            error.remedy or RATE_REMEDY,
            table.file,
        ) from None
