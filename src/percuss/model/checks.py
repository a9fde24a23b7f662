"""Checks that every object of the model makes of itself when it is made."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError

__all__ = ["array", "count", "finite", "instance", "non_negative", "positive", "unit_interval"]

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


def finite(name: str, value: object, accepted: str = "a finite number") -> float:
    """`value` as a float; ParameterError when it is no number, NaN or infinite."""
    if isinstance(value, bool | str | bytes):
        raise ParameterError(name, value, accepted)
    try:
        number = float(value)  # type: ignore[arg-type]  # whatever cannot become a float is refused below
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(name, value, accepted) from None
    if not math.isfinite(number):
        raise ParameterError(name, value, accepted)
    return number


def positive(name: str, value: object) -> float:
    """`value` as a float greater than zero."""
    number = finite(name, value, "a finite number greater than 0")
    if number <= 0.0:
        raise ParameterError(name, value, "a finite number greater than 0")
    return number


def non_negative(name: str, value: object) -> float:
    """`value` as a float not less than zero."""
    number = finite(name, value, "a finite number, 0 or greater")
    if number < 0.0:
        raise ParameterError(name, value, "a finite number, 0 or greater")
    return number


def unit_interval(name: str, value: object) -> float:
    """`value` as a float in [0, 1]."""
    number = finite(name, value, "a number from 0 to 1")
    if not 0.0 <= number <= 1.0:
        raise ParameterError(name, value, "a number from 0 to 1")
    return number


Kind = TypeVar("Kind")


def instance(name: str, value: object, kind: type[Kind]) -> Kind:
    """`value`, when it is an object of the given kind."""
    if not isinstance(value, kind):
        raise ParameterError(name, value, f"an object of the class {kind.__name__}")
    return value


def array(name: str, values: object, low: float, high: float) -> Array:
    """`values` as a one-dimensional array (a number as an array of one) of finite numbers from `low` to `high`."""
    accepted = f"numbers from {low:g} to {high:g}" if np.isfinite(high) else "finite numbers"
    try:
        numbers = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise ParameterError(name, values, accepted) from None
    if numbers.ndim != 1:
        raise ParameterError(name, f"shape {numbers.shape}", "a number or a one-dimensional array")
    if not np.all(np.isfinite(numbers) & (numbers >= low) & (numbers <= high)):
        raise ParameterError(name, values, accepted)
    return numbers


def count(name: str, value: object, least: int = 1, most: int | None = None) -> int:
    """`value` as an int between `least` and `most`."""
    accepted = f"a whole number, {least} or greater" if most is None else f"a whole number from {least} to {most}"
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ParameterError(name, value, accepted)
    number = int(value)
    if number < least or (most is not None and number > most):
        raise ParameterError(name, value, accepted)
    return number
