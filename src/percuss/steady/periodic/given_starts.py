"""Where the starts of a search come from: random times, and rows of times that are given."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, numbers

__all__ = ["RANDOM", "given_rows"]

RANDOM = "random times"
"""What starts are called that nobody gave."""

_LATEST = 1e12  # rad


def given_rows(near: object, impacts: int, periods: int) -> dict[str, Array]:
    """Rows of times to start from, by where they come from, each of the shape (K, p); they may be none."""
    if near is None:
        return {}
    if not isinstance(near, Mapping):
        raise ParameterError("near", near, 'rows of times by their source, as {"a guess": [[0.4, 2.3]]}, or None')
    return {_source(name): _rows(f"near[{name!r}]", rows, impacts, periods) for name, rows in near.items()}


def _source(name: object) -> str:
    if not isinstance(name, str) or not name or name == RANDOM:
        raise ParameterError("near", name, "words for where the starts come from")
    return name


def _rows(name: str, rows: object, impacts: int, periods: int) -> Array:
    accepted = f"rows of {impacts} increasing times within {periods} load period{'s' if periods > 1 else ''}"
    found = numbers(name, rows, accepted)
    if not found.size:
        return np.empty((0, impacts))
    orderly = found.ndim == 2 and found.shape[1] == impacts and bool(np.all(np.abs(found) <= _LATEST))
    if not orderly or np.any(np.diff(found) <= 0.0) or np.any(np.ptp(found, axis=1) >= 2.0 * math.pi * periods):
        raise ParameterError(name, rows, accepted)
    return found
