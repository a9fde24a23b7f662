"""The range in which a parameter is varied, its value where that begins, and what counts as a step of it."""

from __future__ import annotations

import math

from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS
from percuss.model import System
from percuss.model.checks import finite, numbers

_UNITS = 4.0  # of the range of the parameter, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


def range_around(between: object, here: float) -> tuple[float, float]:
    """The ends of a range that holds a value, checked; an endless one for None."""
    if between is None:
        return -math.inf, math.inf
    ends = numbers("between", between, "two numbers, the smaller first")
    if ends.shape != (2,) or not ends[0] < ends[1] or not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"two numbers around {here:.9g}, the value that is followed")
    return float(ends[0]), float(ends[1])


def value_at(system: System, name: str, given: float | None) -> float:
    """The value of a parameter: the given one, or that of a dimensionless one."""
    if given is not None:
        return finite("value", given)
    found = PARAMETERS[name].get(system) if name in PARAMETERS else None
    if found is None:
        raise ParameterError("value", None, f"the value of {name} that belongs to what is followed")
    return found


def unit_of(bounds: tuple[float, float], here: float) -> float:
    """By how much a parameter changes for a step of 1, a power of 2, so that nothing is rounded by it."""
    scale, (low, high) = max(1.0, abs(here)), bounds
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))
