"""Numbers for people to read."""

from __future__ import annotations

import math

__all__ = ["counted", "number", "ordinal", "percent", "quantity"]

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def counted(size: int, what: str) -> str:
    """So many of a thing.

    Examples
    --------
    >>> counted(1, "mode"), counted(32, "mode")
    ('1 mode', '32 modes')
    """
    return f"{size} {what}{'s' if size != 1 else ''}"


def number(value: float, digits: int = 4) -> str:
    """A plain number with so many digits.

    Examples
    --------
    >>> number(2.0 / 3.0), number(-0.0), number(1234567.0)
    ('0.6667', '0', '1.235e+06')
    """
    return f"{value + 0.0:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A value in a base unit with the prefix that suits it.

    Examples
    --------
    >>> quantity(5700.0, "J"), quantity(-1782.4, "N", 3), quantity(0.0, "m")
    ('5.7 kJ', '-1.78 kN', '0 m')
    """
    if value == 0.0 or not math.isfinite(value):
        return f"{number(value, digits)} {unit}"
    size = float(f"{abs(value):.{digits - 1}e}")
    power = min(max(3 * math.floor(math.log10(size) / 3.0), -9), 9)
    return f"{number(value / 10.0**power, digits)} {_PREFIXES[power]}{unit}"


def percent(fraction: float, digits: int = 3) -> str:
    """A fraction in percent.

    Examples
    --------
    >>> percent(0.0123)
    '1.23 %'
    """
    return f"{number(100.0 * fraction, digits)} %"


def ordinal(value: int) -> str:
    """The place of a thing in its row.

    Examples
    --------
    >>> ordinal(1), ordinal(12), ordinal(23)
    ('1st', '12th', '23rd')
    """
    ending = "th" if value % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(value % 10, "th")
    return f"{value}{ending}"
