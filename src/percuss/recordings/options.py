"""What a caller says of a recording, checked before its file is opened: path, columns, rate, moments."""

from __future__ import annotations

import os
from pathlib import Path

from percuss.errors import ParameterError, UnitError
from percuss.units import si

__all__ = ["check_column", "file_path", "in_hertz", "in_seconds"]


def file_path(value: object) -> Path:
    """The path of a file; bytes and the numbers of open files are none.

    Raises
    ------
    ParameterError
        When `value` is neither text nor a path.
    """
    try:
        found = os.fspath(value)  # type: ignore[call-overload]  # whatever is no path is refused below
    except TypeError:
        found = None
    if not isinstance(found, str):
        raise ParameterError("path", value, "a path: text or a pathlib.Path")
    return Path(found)


def check_column(name: str, key: object) -> None:
    """Refuse what can name no column; None leaves the choice to the reader.

    Raises
    ------
    ParameterError
        When `key` is neither text nor a whole number.
    """
    if key is not None and not isinstance(key, str | int):  # True and False are refused with the columns there are
        raise ParameterError(name, key, "the heading of a column, or its number from 1")


def in_hertz(sample_rate: float | str) -> float:
    """A sample rate in Hz, from a number in Hz or from text such as "50 kHz".

    Raises
    ------
    UnitError
        When it is not such a quantity, or not greater than 0.
    """
    rate = si(sample_rate, "frequency" if isinstance(sample_rate, str) else "dimensionless", "sample_rate")
    if rate <= 0.0:
        raise UnitError("sample_rate", sample_rate, 'a frequency greater than 0, such as "50 kHz"')
    return rate


def in_seconds(value: float | str, name: str) -> float:
    """A moment in s, from a number in s or from text such as "0.2 s".

    Raises
    ------
    UnitError
        When it is not such a quantity.
    """
    return si(value, "time" if isinstance(value, str) else "dimensionless", name)
