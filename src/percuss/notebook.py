"""A progress bar in notebooks, for long calls whose caller gives no progress callback."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from typing import Any, Protocol, TypeVar

__all__ = ["duration", "watched"]

PATIENCE = 1.0
"""Seconds before a bar is shown: what is done by then needs none."""
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
