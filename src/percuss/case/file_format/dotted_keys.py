"""Dotted keys of a case, such as ``bar.sections[1].length``: what stands there, and the tables with something else."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["value_at", "with_value"]

_STEP = re.compile(r"\[(\d{1,9})\]|\.?([^.\[\]]+)")

Step = str | int


def value_at(tables: Any, key: str) -> Any:
    """What stands under a key; None where there is nothing.

    Examples
    --------
    >>> value_at({"bar": {"sections": [{"length": "120 mm"}]}}, "bar.sections[0].length")
    '120 mm'
    """
    for step in _steps(key):
        if isinstance(step, int):
            tables = tables[step] if isinstance(tables, list | tuple) and step < len(tables) else None
        else:
            tables = tables.get(step) if isinstance(tables, Mapping) else None
    return tables


def with_value(tables: Any, key: str, value: Any) -> Any:
    """A copy of the tables with another value under a key; None takes the key away.

    Raises
    ------
    LookupError
        For a key inside what is no table, or of a list that is not so long.

    Examples
    --------
    >>> with_value({"system": {"s": 5.0, "impedances": [2.0, 1.0]}}, "system.impedances[1]", 3.0)
    {'system': {'s': 5.0, 'impedances': [2.0, 3.0]}}
    """
    return _replaced(tables, _steps(key), value)


def _steps(key: str) -> list[Step]:
    return [int(place) if place else name for place, name in _STEP.findall(key)]


def _replaced(held: Any, steps: Sequence[Step], value: Any) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(step, int):
        if not isinstance(held, list | tuple) or step >= len(held):
            raise LookupError(step)
        return [*held[:step], _replaced(held[step], rest, value), *held[step + 1 :]]
    if not isinstance(held, Mapping):
        raise LookupError(step)
    if value is None and not rest:
        return {name: item for name, item in held.items() if name != step}
    return {**held, step: _replaced(held.get(step, {}), rest, value)}
