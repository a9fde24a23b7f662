"""Samples without a value: how they are left out of a record, and how many may be."""

from __future__ import annotations

import numpy as np

from percuss.errors import HistoryError
from percuss.recordings.arrays import Array
from percuss.recordings.table import Table

__all__ = ["MOST_MISSING", "without_gaps"]

MOST_MISSING = 0.1
"""The share of the samples that may be missing."""


def without_gaps(time: Array, values: list[Array], table: Table, notes: list[str]) -> tuple[Array, list[Array]]:
    """The samples of which all values are there; nothing is filled in, as the cycles are fitted to samples as they lie.

    Raises
    ------
    HistoryError
        When more than `MOST_MISSING` of the samples are missing.
    """
    there = np.all(np.isfinite(values), axis=0)
    missing = int(time.size - np.count_nonzero(there))
    if missing == 0:
        return time, values
    first = int(np.argmin(there))
    if missing > MOST_MISSING * time.size:
        raise HistoryError(
            f"{missing} of {time.size} samples have no value, the first at {time[first]:.6g} s",
            f"at most {100.0 * MOST_MISSING:.0f} % may be missing: cut the record (from, to), or record again",
            table.file,
        )
    kept = time[there]
    gaps = np.flatnonzero(np.diff(np.concatenate([[1], there.astype(int), [1]])) == -1).size
    longest = float(np.max(np.diff(kept)))
    notes.append(
        f"{missing} of {time.size} samples have no value, in {gaps} gap{'s' if gaps > 1 else ''} of at most "
        f"{1e3 * longest:.3g} ms; they are left out, and nothing is filled in"
    )
    return kept, [v[there] for v in values]
