"""The sizes of sections as parameters: ``tool.sections[2].length`` is the length of the second one, counted from 1."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from percuss.case.parameters.quantity_text import parsed_quantity
from percuss.errors import ParameterError

__all__ = ["check_number", "section_keys", "with_sizes"]

_KEY = re.compile(r"(\w+)\.sections\[(\d{1,9})\]\.(\w+)")


def section_keys(name: str, table: Mapping[str, Any]) -> list[str]:
    """The keys of the sizes that the sections of a table have, in their order.

    Examples
    --------
    >>> section_keys("tool", {"sections": [{"length": "1 m", "diameter": "38 mm"}, {"diameter": "60 mm"}]})
    ['tool.sections[1].length', 'tool.sections[1].diameter', 'tool.sections[2].diameter']
    """
    sections = enumerate(table.get("sections") or (), 1)
    return [
        f"{name}.sections[{i}].{key}"
        for i, section in sections
        for key, value in section.items()
        if parsed_quantity(value)[0] is not None
    ]


def check_number(key: str, tables: Mapping[str, Any]) -> None:
    """Refuse the number of a section that the case does not have; any other key is not looked at.

    Raises
    ------
    ParameterError
        With how many there are.
    """
    if (match := _KEY.fullmatch(key)) is None or not (sections := (tables.get(match[1]) or {}).get("sections")):
        return
    if not 1 <= int(match[2]) <= len(sections):
        raise ParameterError("parameter", key, f"a section from 1 to {len(sections)}, as the case has so many")


def with_sizes(tables: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """The values with those of sections put into the whole lists, by the keys of the lists.

    Examples
    --------
    >>> tool = {"sections": [{"length": "1 m", "diameter": "38 mm"}, {"diameter": "60 mm"}]}
    >>> with_sizes({"tool": tool}, {"tool.sections[2].diameter": "50 mm", "tool.gap": "1 mm"})["tool.sections"][1]
    {'diameter': '50 mm'}
    """
    found: dict[str, Any] = {}
    for key, value in values.items():
        if (match := _KEY.fullmatch(key)) is None:
            found[key] = value
            continue
        name = f"{match[1]}.sections"
        sections = found.get(name) or [dict(section) for section in tables[match[1]]["sections"]]
        sections[int(match[2]) - 1][match[3]] = value
        found[name] = sections
    return found
