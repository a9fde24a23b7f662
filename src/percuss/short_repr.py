"""How results look at a prompt and in a notebook: one line, and a table; never thousands of numbers."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import Field, fields
from html import escape
from importlib import import_module
from typing import Any, ClassVar, Protocol, TypeVar

LONG = 240  # characters of a line; a result that would need more shows its summary instead, …
LONGEST = 600  # … or, without one, is cut off here
_SHORT = 60
_LEFT = 'style="text-align:left"'
_FEW = 6


class ShortRepr:
    """A dataclass that prints as one short line, and as a table in a notebook.

    Everything follows from its fields, and from `__str__` where there is one. Arrays are told by what they are, short
    ones by their values.

    Examples
    --------
    >>> import numpy as np
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Found(ShortRepr):
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
            cls.__repr__ = ShortRepr.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        name = type(self).__name__
        inside = ", ".join(f"{key}={_line(value)}" for key, value in _facts(self))
        if len(inside) > LONG and (summary := _summary(self)):
            return f"<{summary}>"
        return f"{name}({inside if len(inside) <= LONGEST else inside[:LONGEST].rstrip() + '…'})"

    def _repr_html_(self) -> str:
        rows = []
        for key, value in _facts(self):
            inner = list(value) if isinstance(value, tuple) and value and isinstance(value[0], ShortRepr) else None
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
    if isinstance(value, ShortRepr):
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


# ---- A progress bar in notebooks, for long calls whose caller gives no progress callback

PATIENCE = 1.0  # seconds before a bar is shown: what is done by then needs none
_STEP = 0.2  # seconds between two pictures
_busy: ContextVar[bool] = ContextVar("percuss_bar", default=False)  # what a long call calls itself has no bar


class _Fraction(Protocol):
    @property
    def fraction(self) -> float: ...


Seen = TypeVar("Seen", bound=_Fraction, contravariant=True)


@contextmanager
def watched(progress: Callable[[Seen], object] | None) -> Iterator[Callable[[Seen], object] | None]:
    """`progress` itself; without one, in a notebook, a bar that is gone at the end; else None."""
    if progress is not None or _busy.get() or not in_notebook():
        yield progress
        return
    bar = _Bar()
    before = _busy.set(True)
    try:
        yield bar
    finally:
        _busy.reset(before)
        bar.close()


def in_notebook() -> bool:
    """Whether a kernel that shows HTML runs this; a terminal is none, and nothing is imported to find out."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return getattr(shell, "kernel", None) is not None


class _Bar:
    """Called with how far a call has come; draws at most five times a second."""

    def __init__(self) -> None:
        self._begun = self._drawn = time.monotonic()
        self._handle: Any = None

    def __call__(self, progress: _Fraction) -> None:
        now = time.monotonic()
        if now - self._begun < PATIENCE or now - self._drawn < _STEP:
            return
        self._drawn = now
        shown = import_module("IPython.display")
        done = min(max(progress.fraction, 0.0), 1.0)
        left = f"about {duration((now - self._begun) * (1.0 - done) / done)} left" if done > 0.0 else "…"
        picture = shown.HTML(f'<progress value="{done:.4f}" max="1"></progress> {done:.0%}, {left}')
        if self._handle is None:
            self._handle = shown.display(picture, display_id=True)
        else:
            self._handle.update(picture)

    def close(self) -> None:
        if self._handle is not None:
            self._handle.update(import_module("IPython.display").HTML(""))


def duration(seconds: float) -> str:
    """A time for people, in notebooks and terminals.

    Examples
    --------
    >>> duration(42.3), duration(150), duration(9000), duration(864000), duration(1e12)
    ('42 s', '2.5 min', '2.5 h', '10 days', '3.17e+04 years')
    """
    for size, name in ((365.0 * 86400.0, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.{3 if seconds > 100.0 * size else 2}g} {name}"
    return f"{seconds:.0f} s"


# ---- Text that anybody may have written, such as titles, keys and commands of files, with all that steers written out
#
# Characters that move the cursor of a terminal, colour, ring or turn the line around become ``\u001b`` and the like:
# they can be read in text, in a picture and on a page, and in JSON they mean what they meant.


# control characters but for tab and line feed, and those that change the direction of writing
_STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
_ALSO_LINES = re.compile(f"[\n\u2028\u2029]|{_STEERS.pattern}")


def escape_control(text: str) -> str:
    """The text with all that steers a terminal written out."""
    return _STEERS.sub(_written_out, text)


def one_line(text: str) -> str:
    """A text made harmless as `neutral` does, and without line breaks, for a place inside a line."""
    return _ALSO_LINES.sub(_written_out, text)


def _written_out(found: re.Match[str]) -> str:
    return f"\\u{ord(found[0]):04x}"
