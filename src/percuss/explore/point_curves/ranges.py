"""The ranges in which two parameters are varied, and by how much each changes for what counts as a step of 1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

from percuss.errors import ParameterError
from percuss.model.checks import numbers, several

__all__ = ["Ranges", "ranges_around", "units_of"]

Ranges: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

_ENDLESS = (-math.inf, math.inf)
_TWO = "two ranges, or None for one without ends"
_UNITS = 4.0  # of a range, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


def ranges_around(between: Sequence[tuple[float, float] | None] | None, here: tuple[float, float]) -> Ranges:
    """Two ranges that hold a place, checked; an endless one for None."""
    if between is None:
        return _ENDLESS, _ENDLESS
    given = several("between", between, _TWO)
    if len(given) != 2:
        raise ParameterError("between", between, _TWO)
    first, second = (_around(between, one, value) for one, value in zip(given, here, strict=True))
    return first, second


def _around(between: object, given: object, here: float) -> tuple[float, float]:
    if given is None:
        return _ENDLESS
    ends = numbers("between", given, _TWO)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise ParameterError("between", between, f"{_TWO}, each from a lower to a higher value")
    if not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"a range around {here:.9g}, the point")
    return float(ends[0]), float(ends[1])


def units_of(bounds: Ranges, here: tuple[float, float]) -> tuple[float, float]:
    """By how much each parameter changes for a step of 1, powers of 2, so that nothing is rounded by it."""
    first, second = (_unit(low, high, value) for (low, high), value in zip(bounds, here, strict=True))
    return first, second


def _unit(low: float, high: float, value: float) -> float:
    scale = max(1.0, abs(value))
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))
