"""What was asked for, as text: the same ask is the same text, and two that differ can be told apart part by part."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Any

__all__ = ["canonical", "differences", "digest", "parsed"]

_DEEPEST = 60
"""Tables in tables; what asks go through calls itself for each."""

_SHOWN = 6
"""Differences that a message lists."""


def canonical(ask: dict[str, Any]) -> str:
    """The ask as JSON, its keys in order; numbers keep all their digits, infinity included.

    Examples
    --------
    >>> canonical({"s": float("inf"), "d": 0.1, "axes": (1, 2)})
    '{"axes":[1,2],"d":0.1,"s":Infinity}'
    """
    return json.dumps(ask, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def digest(ask: dict[str, Any]) -> str:
    """SHA-256 of the canonical text."""
    return hashlib.sha256(canonical(ask).encode()).hexdigest()


def parsed(text: str) -> dict[str, Any]:
    """The ask of a canonical text.

    Raises
    ------
    ValueError
        When it is none: no table, or tables in tables without end.

    Examples
    --------
    >>> parsed('{"s":Infinity}')
    {'s': inf}
    """
    try:
        found = json.loads(text)
        deep = _depth(found)
    except RecursionError:
        deep = _DEEPEST + 1
    if deep > _DEEPEST:
        raise ValueError(f"a question nested more than {_DEEPEST} tables deep")
    if not isinstance(found, dict):
        raise ValueError("a question that is not a table")
    return found


def _depth(value: Any) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if inner is None else 1 + max(map(_depth, inner), default=0)


def differences(old: dict[str, Any], new: dict[str, Any]) -> str:
    """Which parts of two asks differ, in words; empty when none does.

    Examples
    --------
    >>> differences({"seed": 1, "system": {"s": 20.0}}, {"seed": 2, "system": {"s": 20.0}})
    'seed: 1 in the archive, 2 asked for'
    """
    # through JSON, so that a tuple and a list of the same numbers do not differ
    one, other = json.loads(canonical(old)), json.loads(canonical(new))
    found = list(_parts("kind", one.get("kind"), other.get("kind"))) or list(_parts("", one, other))
    more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return "; ".join(found[:_SHOWN]) + more


def _parts(name: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            inner = f"{name}.{key}" if name else key
            if key not in new:
                yield f"{inner}: {_short(old[key])} in the archive, not asked for"
            elif key not in old:
                yield f"{inner}: not in the archive, {_short(new[key])} asked for"
            else:
                yield from _parts(inner, old[key], new[key])
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (one, other) in enumerate(zip(old, new, strict=True)):
            yield from _parts(f"{name}[{_name_of(one, other, i)}]", one, other)
    elif json.dumps(old) != json.dumps(new):  # as text: 1 and true, 0.0 and −0.0 differ, NaN and NaN do not
        yield f"{name}: {_short(old)} in the archive, {_short(new)} asked for"


def _name_of(old: Any, new: Any, position: int) -> object:
    """A list of named things is told by their names where they agree."""
    names = [item.get("name") if isinstance(item, dict) else None for item in (old, new)]
    return names[0] if names[0] is not None and names[0] == names[1] else position


def _short(value: Any, limit: int = 60) -> str:
    if isinstance(value, list) and len(value) > 4:
        return f"{len(value)} values from {_short(value[0], 20)} to {_short(value[-1], 20)}"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= limit else text[: limit - 1] + "…"
