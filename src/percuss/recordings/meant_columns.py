"""Which columns of a table are meant, and what 1 in them stands for; what is ambiguous is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import cast

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.columns import Column, find_opposing, find_time, find_values, first_of_two, seconds, value_scale
from percuss.recordings.table import Table, as_rate
from percuss.units import unit_scale

__all__ = ["Scale", "against_clock", "given_scale", "meant_columns", "scales_of"]

Scale = tuple[float, str]  # what 1 in a column stands for, in SI, and of which quantity


def given_scale(table: Table, unit: str | None, path: Path) -> Scale | None:
    """What the option `unit` says; a .wav file cannot do without."""
    found = None if unit is None else unit_scale(unit, table.sought.dimensions, "unit")
    if path.suffix.lower() == ".wav" and (unit is None or not re.match(r"\s*[-+.\d]", unit)):
        raise HistoryError(
            "a .wav file holds fractions of full scale, without a unit",
            'say what full scale is: unit = "12 MPa"',
            table.file,
        )
    return found


def meant_columns(
    table: Table,
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


def scales_of(table: Table, faces: list[int], unit: str | None, given: Scale | None, notes: list[str]) -> list[Scale]:
    """What 1 stands for in each column of values."""
    scales = [given or value_scale(table, face) for face in faces]
    if len({quantity for _, quantity in scales}) > 1:
        raise HistoryError(
            f"{table.heading(faces[0])} is a {scales[0][1]}, {table.heading(faces[1])} a {scales[1][1]}",
            "name two columns of the same quantity",
            table.file,
        )
    if given is not None:
        notes += [f for face in faces if (f := _against_heading(table, face, cast(str, unit), given))]
    return scales


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


def against_clock(table: Table, column: Column | None, rate: float) -> list[str]:
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
