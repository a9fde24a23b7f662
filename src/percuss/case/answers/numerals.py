"""Numbers for people to read, and for JSON."""

from __future__ import annotations

import csv
import io
import math
import shlex
from collections.abc import Iterable, Sequence
from typing import Any

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def counted(size: int, what: str) -> str:
    """So many of a thing: ``1 mode``, ``32 modes``."""
    return f"{size} {what}{'s' if size != 1 else ''}"


def number(value: float, digits: int = 4) -> str:
    """A plain number with so many digits; −0 is 0."""
    return f"{value + 0.0:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A value in a base unit with the prefix that suits it.

    >>> quantity(5700.0, "J"), quantity(-1782.4, "N", 3), quantity(0.0, "m"), quantity(math.inf, "s")
    ('5.7 kJ', '-1.78 kN', '0 m', 'inf s')
    """
    if value == 0.0 or not math.isfinite(value):
        return f"{number(value, digits)} {unit}"
    size = float(f"{abs(value):.{digits - 1}e}")
    power = min(max(3 * math.floor(math.log10(size) / 3.0), -9), 9)
    return f"{number(value / 10.0**power, digits)} {_PREFIXES[power]}{unit}"


def measured(value: float, unit: str, digits: int = 4) -> str:
    """A value in its unit, with a prefix where it can have one: ``5.7 kJ``, ``9.1 m/s``, ``2.993 N·s``, ``0.4``."""
    if unit.isalpha() and unit != "rad":
        return quantity(value, unit, digits)
    return f"{number(value, digits)} {unit}".rstrip()


def percent(fraction: float, digits: int = 3) -> str:
    """A fraction in percent: ``1.23 %``."""
    return f"{number(100.0 * fraction, digits)} %"


def every(periods: int) -> str:
    """How often something comes that comes once in so many load periods."""
    return "every load period" if periods == 1 else f"in {periods} load periods"


def rhythm(label: str, blow: str = "blow") -> str:
    """What a label z=p/n says.

    >>> rhythm("z=1/2"), rhythm("z=3/1")
    ('one blow in 2 load periods', '3 blows every load period')
    """
    impacts, periods = (int(part) for part in label.removeprefix("z=").split("/"))
    return f"{f'one {blow}' if impacts == 1 else f'{impacts} {blow}s'} {every(periods)}"


def ordinal(value: int) -> str:
    """The place of a thing in its row.

    >>> ordinal(1), ordinal(12), ordinal(23)
    ('1st', '12th', '23rd')
    """
    ending = "th" if value % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(value % 10, "th")
    return f"{value}{ending}"


def as_typed(name: str) -> str:
    """The name of a case as it is to be typed again: '-' for standard input, quoted where a shell needs it."""
    return "-" if name == "<stdin>" else shlex.quote(name)


def table_text(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return text.getvalue()


# ---- Values for JSON: every number finite or null, numpy's kinds as Python's own


def json_number(value: Any) -> float | int | None:
    """A finite number as Python has it, or None."""
    if value is None or isinstance(value, int):
        return value if value is None else int(value)
    found = float(value)
    return found if math.isfinite(found) else None


def numbers(values: Iterable[Any]) -> list[float | int | None]:
    """A list of the values, each finite or None."""
    found: list[float | int | None] = plain_value(values if hasattr(values, "tolist") else list(values))
    return found


def picked(one: object, names: str) -> dict[str, Any]:
    """Attributes as JSON has them, by their names, which stand with spaces between."""
    return {name: plain_value(getattr(one, name)) for name in names.split()}


def plain(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers made finite or None; text, truth values, lists and tables of them as they are."""
    return {key: plain_value(value) for key, value in values.items()}


def plain_value(value: Any) -> Any:
    """The same of one value; a complex number is a pair."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return plain(value)
    if isinstance(value, tuple | list):
        return [plain_value(item) for item in value]
    if isinstance(value, complex):
        return [json_number(value.real), json_number(value.imag)]
    return value if isinstance(value, str | bool) else json_number(value)
