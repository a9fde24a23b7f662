"""Measured histories of force or pressure: read from files, cut into cycles, averaged to one period of a load.

`read_recording` reads a file; `percuss.Load.history` makes a load of a series and keeps its `HistoryReport`. Nothing
here knows of bars and loads. The names are imported when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.recordings.history import HistoryReport
    from percuss.recordings.recording import BlowRecord, Recording, read_blows, read_recording

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
