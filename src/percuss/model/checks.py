"""Checks that every object of the model makes of itself when it is made."""

from __future__ import annotations

import inspect
import math
import os
from collections.abc import Callable, Iterable, Mapping
from numbers import Complex, Real
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

DEFAULT_MODES = 32
"""Elastic modes where nobody names a number: of simulations and orbits, and of the multipliers of a continuous bar."""

_NO_NUMBERS = (bool, str, bytes, bytearray, np.bool_, np.complexfloating)  # though `float` takes them


def finite(name: str, value: object, accepted: str = "a finite number") -> float:
    """`value` as a float; ParameterError when it is not a number, NaN or infinite."""
    if type(value) is float and math.isfinite(value):
        return value
    if isinstance(value, _NO_NUMBERS):
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


MOST_FORCE = 1e100  # far beyond any load: the squares of forces stay in the range of double precision


def force(name: str, value: object, least: float = 2.3e-308) -> float:
    """`value` as a float that is 0, or of a size from `least` on; what is smaller by default has lost digits."""
    number = finite(name, value)
    if number != 0.0 and not least <= abs(number) <= MOST_FORCE:
        raise ParameterError(name, value, f"0, or a size from {least:g} to {MOST_FORCE:g}", "check the scales")
    return number


Kind = TypeVar("Kind")


def instance(name: str, value: object, kind: Callable[..., Kind]) -> Kind:
    """`value`, when it is an object of the given class, which may be an abstract one."""
    assert isinstance(kind, type)
    if not isinstance(value, kind):
        raise ParameterError(name, value, f"an object of the class {kind.__name__}")
    return cast("Kind", value)


def flag(name: str, value: object) -> bool:
    """`value`, when it is True or False: anything else that is true or not is more likely a slip."""
    if not isinstance(value, bool | np.bool_):
        raise ParameterError(name, value, "True or False")
    return bool(value)


def text(name: str, value: object, accepted: str = "text") -> str:
    """`value`, when it is text."""
    if not isinstance(value, str):
        raise ParameterError(name, value, accepted)
    return value


def choice(name: str, value: object, *options: str) -> None:
    """Refuse what is none of the words."""
    if not isinstance(value, str) or value not in options:
        raise ParameterError(name, value, f"one of {', '.join(map(repr, options))}")


def path(name: str, value: object) -> str:
    """`value` as the name of a file; a number would be taken for an open file."""
    try:
        found = os.fspath(value)  # type: ignore[call-overload]  # whatever is no path is refused below
    except TypeError:
        found = None
    if not isinstance(found, str):
        raise ParameterError(name, value, "a path: text or a pathlib.Path")
    return found


def callback(name: str, value: object) -> None:
    """Refuse what cannot be called, and is not None; before anything long begins."""
    if value is not None and not callable(value):
        raise ParameterError(name, value, "a function, or None")


def several(name: str, values: Iterable[Kind], accepted: str) -> tuple[Kind, ...]:
    """`values` as a tuple; a text is not taken for its letters."""
    try:
        if isinstance(values, str | bytes | bytearray | Mapping):
            raise TypeError
        return tuple(values)
    except TypeError:
        raise ParameterError(name, values, accepted) from None


def mapping(name: str, value: object, accepted: str) -> Mapping[str, Any]:
    """`value`, when it is a dict, or behaves like one, whose keys are texts."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise ParameterError(name, value, accepted)
    return value


def having(name: str, value: object, attributes: tuple[str, ...], accepted: str) -> None:
    """Refuse an object without these attributes, and a class that should be an object of it."""
    # looked up without being computed: properties of results can be dear
    there = (inspect.getattr_static(value, one, None) is not None or hasattr(value, one) for one in attributes)
    if isinstance(value, type) or not all(there):
        raise ParameterError(name, value, accepted)


def numbers(name: str, values: object, accepted: str = "finite numbers", *, nan: bool = False) -> Array:
    """`values` in any shape as floats, no texts, truth values or complex; finite, or `nan` for what is not there."""
    if isinstance(values, float) and math.isfinite(values):
        return np.asarray(values, dtype=float)
    try:
        given = np.asarray(values)
        real = given.dtype.kind in "iuf" or all(isinstance(x, Real) and not isinstance(x, bool) for x in given.flat)
        if not real or given.dtype.kind == "b":
            raise ParameterError(name, values, accepted)
        found = np.asarray(given, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError(name, values, accepted) from None
    if np.isinf(found).any() if nan else not np.isfinite(found).all():
        raise ParameterError(name, values, accepted)
    return found


def complex_numbers(name: str, values: object, accepted: str) -> ComplexArray:
    """`values` as complex numbers in their shape; no texts, truth values or other objects."""
    if isinstance(values, np.ndarray) and values.dtype == complex:
        return values.copy()
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "iufc" and not all(
            isinstance(x, Complex) and not isinstance(x, bool) for x in given.flat
        ):
            raise ParameterError(name, values, accepted)
        if given.dtype.kind == "b":
            raise ParameterError(name, values, accepted)
        return np.array(given, dtype=complex)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError(name, values, accepted) from None


def array(name: str, values: object, low: float, high: float) -> Array:
    """`values` as a one-dimensional array (a number as an array of one) of finite numbers from `low` to `high`."""
    accepted = f"numbers from {low:g} to {high:g}" if np.isfinite(high) else "finite numbers"
    found = np.atleast_1d(numbers(name, values, accepted))
    if found.ndim != 1:
        raise ParameterError(name, f"shape {found.shape}", "a number or a one-dimensional array")
    if not np.all((found >= low) & (found <= high)):
        raise ParameterError(name, values, accepted)
    return found


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def workers(threads: object) -> int:
    """So many threads, by default as many as cores."""
    return cores() if threads is None else count("threads", threads, most=1024)


def count(name: str, value: object, least: int = 1, most: int | None = None) -> int:
    """`value` as an int between `least` and `most`."""
    accepted = f"a whole number, {least} or greater" if most is None else f"a whole number from {least} to {most}"
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise ParameterError(name, value, accepted)
    number = int(value)
    if number < least or (most is not None and number > most):
        raise ParameterError(name, value, accepted)
    return number
