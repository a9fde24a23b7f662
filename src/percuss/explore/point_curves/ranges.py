"""The ranges in which two parameters are varied, and by how much each changes for what counts as a step of 1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import numbers

__all__ = ["Ranges", "ranges_around", "units_of"]

Ranges: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

_UNITS = 4.0  # of a range, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


def ranges_around(between: Sequence[tuple[float, float]] | None, here: tuple[float, float]) -> Ranges:
    """Two ranges that hold a place, checked; endless ones for None."""
    if between is None:
        return (-math.inf, math.inf), (-math.inf, math.inf)
    ends = numbers("between", between, "a range of each parameter")
    if ends.shape != (2, 2) or not np.all(ends[:, 0] < ends[:, 1]):
        raise ParameterError("between", between, "two ranges, each from a lower to a higher value")
    if not all(low <= value <= high for (low, high), value in zip(ends.tolist(), here, strict=True)):
        raise ParameterError("between", between, f"ranges around {here[0]:.9g} and {here[1]:.9g}, the point")
    return (float(ends[0, 0]), float(ends[0, 1])), (float(ends[1, 0]), float(ends[1, 1]))


def units_of(bounds: Ranges, here: tuple[float, float]) -> tuple[float, float]:
    """By how much each parameter changes for a step of 1, powers of 2, so that nothing is rounded by it."""
    first, second = (_unit(low, high, value) for (low, high), value in zip(bounds, here, strict=True))
    return first, second


def _unit(low: float, high: float, value: float) -> float:
    scale = max(1.0, abs(value))
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))
