"""Measured histories of force or pressure: read from files, cut into cycles, averaged to one period of a load.

`read_recording` reads a file; `percuss.Load.history` makes a load of a series and keeps its `HistoryReport`. Nothing
here knows of bars and loads. The names are imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.recordings.history import HistoryReport as HistoryReport
    from percuss.recordings.recording import Recording as Recording
    from percuss.recordings.recording import read_recording as read_recording

_HOME = {"HistoryReport": "history", "Recording": "recording", "read_recording": "recording"}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
