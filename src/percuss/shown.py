"""How results look at a prompt and in a notebook: one line, and a table; never thousands of numbers."""

from __future__ import annotations

from dataclasses import Field, fields
from html import escape
from typing import Any, ClassVar

__all__ = ["Shown"]

LONG = 240
"""Characters of a line; a result that would need more shows its summary instead, …"""
LONGEST = 600
"""… or, without one, is cut off here."""
_SHORT = 60
_LEFT = 'style="text-align:left"'
_FEW = 6


class Shown:
    """A dataclass that prints as one short line, and as a table in a notebook.

    Everything follows from its fields, and from `__str__` where there is one. Arrays are told by what they are, short
    ones by their values.

    Examples
    --------
    >>> import numpy as np
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Found(Shown):
    ...     phase: float
    ...     moduli: object
    >>> Found(1.5, np.array([0.5, 0.25]))
    Found(phase=1.5, moduli=[0.5, 0.25])
    >>> Found(1.5, np.zeros((20, 3)))
    Found(phase=1.5, moduli=<20 × 3 float64>)
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "__repr__" not in cls.__dict__:  # else the decorator would write its own
            cls.__repr__ = Shown.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        name = type(self).__name__
        inside = ", ".join(f"{key}={_line(value)}" for key, value in _facts(self))
        if len(inside) > LONG and (summary := _summary(self)):
            return f"<{summary}>"
        return f"{name}({inside if len(inside) <= LONGEST else inside[:LONGEST].rstrip() + '…'})"

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        rows = []
        for key, value in _facts(self):
            inner = list(value) if isinstance(value, tuple) and value and isinstance(value[0], Shown) else None
            lines = [_line(value)] if inner is None else [str(one).split("\n")[0] for one in inner[: 2 * _FEW]]
            if inner is not None and len(inner) > len(lines):
                lines.append(f"… {len(inner) - len(lines)} more")
            cell = "<br>".join(escape(line) for line in lines)
            rows.append(f"<tr><th {_LEFT}>{escape(key)}</th><td {_LEFT}>{cell}</td></tr>")
        caption = escape(_summary(self) or type(self).__name__)
        return f"<table><caption>{caption}</caption><tbody>{''.join(rows)}</tbody></table>"


def _facts(result: Any) -> list[tuple[str, Any]]:
    return [(f.name, getattr(result, f.name)) for f in fields(result) if f.repr and not f.name.startswith("_")]


def _summary(result: object) -> str:
    """The first line of what a result says of itself; "" when it says nothing."""
    return "" if type(result).__str__ is object.__str__ else str(result).split("\n")[0]


def _line(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, Shown):
        text = _summary(value)
        return f"<{text[:_SHORT]}{'…' * (len(text) > _SHORT)}>" if text else f"<{type(value).__name__}>"
    shape = getattr(value, "shape", None)
    if shape is not None and hasattr(value, "dtype"):
        if len(shape) == 1 and shape[0] <= _FEW:
            return f"[{', '.join(f'{x:.6g}' if value.dtype.kind in 'fc' else str(x) for x in value)}]"
        return f"<{' × '.join(str(n) for n in shape)} {value.dtype}>" if shape else str(value)
    if isinstance(value, tuple | list):
        if len(value) > _FEW:
            return f"<{len(value)} of {type(value[0]).__name__}>"
        inside = ", ".join(_line(one) for one in value)
        return f"[{inside}]" if isinstance(value, list) else f"({inside}{',' * (len(value) == 1)})"
    if isinstance(value, dict):
        inside = ", ".join(f"{key}: {_line(value[key])}" for key in list(value)[:_FEW])
        return f"{{{inside}{', …' * (len(value) > _FEW)}}}"
    text = repr(value)
    return text if len(text) <= 2 * _SHORT else text[: 2 * _SHORT] + "…"
