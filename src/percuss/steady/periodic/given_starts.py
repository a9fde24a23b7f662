"""Where the starts of a search come from: random times, and rows of times that are given."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array, numbers

__all__ = ["RANDOM", "rows_of_times"]

RANDOM = "random times"
"""What starts are called that nobody gave."""

_LATEST = 1e12  # rad


def rows_of_times(name: str, rows: npt.ArrayLike, impacts: int, periods: int) -> Array:
    """Rows of times to start from, shape (K, p); they may be none."""
    accepted = f"rows of {impacts} increasing times within {periods} load period{'s' if periods > 1 else ''}"
    if not isinstance(name, str) or not name or name == RANDOM:
        raise ParameterError("near", name, "a word for where the starts come from")
    if not np.size(rows):
        return np.empty((0, impacts))
    found = numbers(f"near[{name!r}]", rows, accepted)
    orderly = found.ndim == 2 and found.shape[1] == impacts and bool(np.all(np.abs(found) <= _LATEST))
    if not orderly or np.any(np.diff(found) <= 0.0) or np.any(np.ptp(found, axis=1) >= 2.0 * math.pi * periods):
        raise ParameterError(f"near[{name!r}]", rows, accepted)
    return found
