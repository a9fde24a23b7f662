"""The sine of x less x, exact for small x."""

from __future__ import annotations

import math

import numpy as np

from percuss.model.checks import Array

__all__ = ["excess", "excess_of"]


def excess_of(x: float) -> float:
    """Of a number."""
    if abs(x) >= 1.0:
        return math.sin(x) - x
    y, series = x * x, 1.0
    for j in range(19, 3, -2):
        series = 1.0 - y * series / ((j - 1.0) * j)
    return -x * y / 6.0 * series


def excess(x: Array) -> Array:
    """Of an array."""
    small = np.abs(x) < 1.0
    y = np.where(small, x, 0.0) ** 2
    series = np.ones_like(y)
    for j in range(19, 3, -2):  # 1 − x²/20 + …, by Horner's rule
        series = 1.0 - y * series / ((j - 1.0) * j)
    return np.asarray(np.where(small, -x * y / 6.0 * series, np.sin(x) - x))
