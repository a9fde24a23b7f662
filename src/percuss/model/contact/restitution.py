"""The coefficient of restitution R, and what else is a function of it alone; of numbers and of arrays."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array, numbers

__all__ = ["impedance_ratio", "restitution_of_ratio", "restitutions"]

X = TypeVar("X", float, Array)


def impedance_ratio(restitution: X) -> X:
    """(1 − R)/(1 + R): the impedance of a bar over that of the receiving rod from which it rebounds so (B77 10).

    0 of a rigid wall, R = 1; 1 of a rod like the bar, R = 0. It is also half the sum of the velocities before and after
    an impact over half their difference, which is how it comes into the level of B77 (14) and the bounds of B77 (36).

    Examples
    --------
    >>> impedance_ratio(0.6), restitution_of_ratio(0.25)
    (0.25, 0.6)
    """
    return (1.0 - restitution) / (1.0 + restitution)


def restitution_of_ratio(ratio: X) -> X:
    """R of an `impedance_ratio`, the function backwards, which is itself; from 0 to 1 for ratios from 1 to 0."""
    return (1.0 - ratio) / (1.0 + ratio)


def restitutions(values: npt.ArrayLike) -> Array:
    """An array of coefficients of restitution that has been looked at.

    Raises
    ------
    ParameterError
        When one of them is no number from 0 to 1.
    """
    found = numbers("restitution", values, "numbers from 0 to 1")
    if not (np.all(found >= 0.0) and np.all(found <= 1.0)):
        raise ParameterError("restitution", values, "numbers from 0 to 1")
    return found
