"""Numbers with their units, as a case has them, taken apart and put together again."""

from __future__ import annotations

import re
from typing import Any

__all__ = ["like", "parsed_quantity"]

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*", re.ASCII)


def parsed_quantity(given: Any) -> tuple[float | None, str]:
    """Number and unit of a value of a case; None where there is no number.

    Examples
    --------
    >>> parsed_quantity("341 mm"), parsed_quantity(0.2)
    ((341.0, 'mm'), (0.2, ''))
    """
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given), ""
    match = _QUANTITY.fullmatch(given) if isinstance(given, str) else None
    return (float(match[1]), match[2]) if match else (None, "")


def like(given: Any, value: float) -> Any:
    """The value as it would stand in place of what is given: with its unit, or as a plain number.

    Examples
    --------
    >>> like("341 mm", 300.0), like(0.2, 0.3), like({"kind": "ratio", "value": 0.001}, 0.002)
    ('300.0 mm', 0.3, {'kind': 'ratio', 'value': 0.002})
    """
    if isinstance(given, dict):
        return {**given, "value": like(given.get("value"), value)}
    if isinstance(given, str):
        return f"{value!r} {parsed_quantity(given)[1]}"
    return int(value) if isinstance(given, int) and value == int(value) else value
