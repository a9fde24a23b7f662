"""One's own quantities of a map: functions of a system, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError
from percuss.explore.cells import failure
from percuss.explore.machine_quantities import MACHINE_QUANTITIES
from percuss.explore.quantities import QUANTITIES
from percuss.model import Machine, System
from percuss.model.checks import Array, mapping

__all__ = ["SystemFunction", "checked_functions", "function_values", "qualified"]

SystemFunction = Callable[[System], float] | Callable[[Machine], float]
"""One's own quantity of a map, of a system or of a machine that switches its own valve."""


def checked_functions(functions: Mapping[str, SystemFunction]) -> tuple[tuple[str, SystemFunction], ...]:
    for name, function in mapping("functions", functions, "functions of a system by name").items():
        if name in QUANTITIES or name in MACHINE_QUANTITIES or name == "outcome" or not str(name).isidentifier():
            raise ParameterError("functions", name, "a name of one word that no quantity has")
        if not callable(function):
            raise ParameterError(name, function, "a function of a system")
    return tuple(functions.items())


def qualified(function: SystemFunction) -> str:
    """What the function is called, with its module."""
    return f"{function.__module__}.{getattr(function, '__qualname__', type(function).__name__)}"


def function_values(
    function: Callable[[Any], float], systems: Sequence[System | Machine | None], outcome: npt.NDArray[Any]
) -> Array:
    """The function of every system or machine; where it fails NaN, and the outcome says so."""
    found = np.full(len(outcome), np.nan)
    for i, system in enumerate(systems):
        if system is not None:
            try:
                found[i] = function(system)
            except (PercussError, ArithmeticError) as error:
                outcome[i] = failure(error)
    return found
