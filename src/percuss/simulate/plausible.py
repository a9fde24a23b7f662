"""What numbers of a saved motion must be before anything is made of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

_MOST = 1e100
"""No number of a motion is greater: its square must not overflow."""


def true(good: object, what: str) -> None:
    """Refuse what does not hold."""
    if not good:
        raise ValueError(f"{what} is impossible")


def shaped(name: str, values: npt.NDArray[Any], dtype: npt.DTypeLike, shape: tuple[int, ...]) -> None:
    """Refuse another type or shape."""
    true(isinstance(values, np.ndarray) and values.dtype == np.dtype(dtype), f"the type of {name}")
    true(values.shape == shape, f"the shape {values.shape} of {name}")


def numbers(name: str, values: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    """Refuse what is not an array of finite numbers of this shape."""
    shaped(name, values, np.float64, shape)
    true(np.all(np.abs(values) <= _MOST), f"a value of {name}")  # false of NaN too


def within(name: str, values: npt.ArrayLike, low: float, high: float) -> None:
    """Refuse numbers outside of an interval, and NaN."""
    array = np.asarray(values)
    true(np.all((array >= low) & (array <= high)), f"a value of {name}")
