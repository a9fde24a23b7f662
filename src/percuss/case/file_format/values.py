"""The kinds of values in a case file: numbers, text with a unit, lists; checked and kept as they are written."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationInfo

from percuss.errors import ParameterError, UnitError, did_you_mean
from percuss.units import si

# ---- The kinds of values in a case file: numbers, text with a unit, lists; checked and kept as they are written


def _quantity(*dimensions: str) -> Callable[[Any, ValidationInfo], Any]:
    """A check that text is a number with a unit of one of the dimensions; the text itself is kept."""

    def check(value: Any, info: ValidationInfo) -> Any:
        name = info.field_name or "value"
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise UnitError(name, value, f"text with a number and a unit of {' or '.join(dimensions)}")
        refusals = []
        for dimension in dimensions:
            try:
                si(value, dimension, name)
                return value
            except UnitError as error:
                refusals.append(error)
        accepted = " or ".join(error.accepted for error in refusals)
        raise UnitError(name, value, accepted, refusals[0].remedy)

    return check


def _unit(value: Any, info: ValidationInfo) -> Any:
    """A check that text is a unit of force or pressure."""
    name = info.field_name or "unit"
    for dimension in ("force", "pressure"):
        try:
            if isinstance(value, str):
                si(f"1 {value}", dimension, name)
                return value
        except UnitError:
            continue
    raise UnitError(name, value, 'a unit of force such as "kN", or of pressure such as "bar" beside an area')


def _pairs(value: Any) -> Any:
    """Lists of two numbers as tuples; what has another form is refused with its place."""
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("pairs [re, im] of numbers from the mean up, for example [[0.9, 0.0], [1.0, 0.0]]")
    for i, pair in enumerate(value):
        good = isinstance(pair, list | tuple) and len(pair) == 2
        if not good or not all(map(_is_number, pair)):
            raise ValueError(f"pairs [re, im] of numbers; number {i} of the list is {str(pair)[:40]}")
    return tuple(tuple(float(x) for x in pair) for pair in value)


def _number_or(dimension: str) -> Callable[[Any, ValidationInfo], Any]:
    """A check that a value is a plain number (dimensionless), or text with a unit of the dimension."""
    quantity = _quantity(dimension)

    def check(value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, str):
            return quantity(value, info)
        if not _is_number(value) or not math.isfinite(value):
            accepted = f"a finite number (dimensionless), or text with a unit of {dimension}"
            raise UnitError(info.field_name or "value", value, accepted)
        return value

    return check


def _plain_number(value: Any, info: ValidationInfo) -> Any:
    """A check that a value is a plain number."""
    if not _is_number(value) or not math.isfinite(value):
        remedy = "only a case in SI takes units" if isinstance(value, str) else ""
        raise UnitError(info.field_name or "value", value, "a finite number in a dimensionless case", remedy)
    return value


def _numbers(value: Any) -> Any:
    """A list of numbers as a tuple."""
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("a list of numbers, for example [1.0, 0.01]")
    for i, number in enumerate(value):
        if not _is_number(number):
            raise ValueError(f"a list of numbers; number {i} of the list is {str(number)[:40]}")
        if not math.isfinite(number):
            raise ValueError(f"a list of finite numbers; number {i} of the list is {number}")
    return tuple(float(number) for number in value)


def _one_or_several(check: Callable[[Any, ValidationInfo], Any]) -> Callable[[Any, ValidationInfo], Any]:
    """A check of one value, or of each in a list, which becomes a tuple."""

    def checked(value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, list | tuple):
            return check(value, info)
        if not value:
            raise ValueError("one value, or a list of one for each section")
        return tuple(check(one, info) for one in value)

    return checked


def _steps(
    time: Callable[[Any, ValidationInfo], Any], force: Callable[[Any, ValidationInfo], Any], example: str
) -> Any:
    """A check of a list of pairs, a time and the force from then on; it becomes a tuple of pairs."""

    def checked(value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, list | tuple) or not value:
            raise ValueError(f"pairs of a time and the force from then on, for example {example}")
        for i, pair in enumerate(value):
            if not isinstance(pair, list | tuple) or len(pair) != 2:
                found = f"number {i} of the list is {str(pair)[:40]}"
                raise ValueError(f"pairs of a time and the force from then on, for example {example}; {found}")
        return tuple((time(when, info), force(what, info)) for when, what in value)

    return BeforeValidator(checked)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _damping_value(value: Any, info: ValidationInfo) -> Any:
    """A number, text (whose unit the law decides), or a list of numbers."""
    if isinstance(value, list | tuple):
        return _numbers(value)
    if isinstance(value, str) or (_is_number(value) and math.isfinite(value)):
        return value
    raise UnitError(info.field_name or "value", value, "a finite number, text with a unit, or a list of numbers")


FROM_THE_BLOW = "from the blow"
"""The restitution of a contact whose blow is resolved by waves."""


def _restitution(value: Any, info: ValidationInfo) -> Any:
    """A number, or the word for the restitution of the blow."""
    if value == FROM_THE_BLOW or (_is_number(value) and math.isfinite(value)):
        return value
    accepted = "a finite, plain number without quotes" if isinstance(value, str) else "a finite number"
    remedy = did_you_mean(value, [FROM_THE_BLOW])
    raise ParameterError(info.field_name or "restitution", value, f'{accepted}, or "{FROM_THE_BLOW}"', remedy)


Length = Annotated[str, BeforeValidator(_quantity("length"))]
Area = Annotated[str, BeforeValidator(_quantity("area"))]
Frequency = Annotated[str, BeforeValidator(_quantity("frequency"))]
Time = Annotated[str, BeforeValidator(_quantity("time"))]
Stress = Annotated[str, BeforeValidator(_quantity("pressure"))]
Density = Annotated[str, BeforeValidator(_quantity("density"))]
Drag = Annotated[str, BeforeValidator(_quantity("damping"))]
Mass = Annotated[str, BeforeValidator(_quantity("mass"))]
Stiffness = Annotated[str, BeforeValidator(_quantity("stiffness"))]
Flow = Annotated[str, BeforeValidator(_quantity("flow"))]
Compliance = Annotated[str, BeforeValidator(_quantity("compliance"))]
Force = Annotated[str, BeforeValidator(_quantity("force"))]
ForceOrPressure = Annotated[str, BeforeValidator(_quantity("force", "pressure"))]
ForceUnit = Annotated[str, BeforeValidator(_unit)]
Coefficients = Annotated[tuple[tuple[float, float], ...], BeforeValidator(_pairs)]
Column = str | int
PlainNumber = Annotated[float, BeforeValidator(_plain_number)]
Numbers = Annotated[tuple[float, ...], BeforeValidator(_numbers)]
DampingValue = Annotated[float | str | tuple[float, ...], BeforeValidator(_damping_value)]
NumberOrLength = Annotated[float | str, BeforeValidator(_number_or("length"))]
NumberOrVelocity = Annotated[float | str, BeforeValidator(_number_or("velocity"))]
NumberOrStiffness = Annotated[float | str, BeforeValidator(_number_or("stiffness"))]
NumberOrDashpot = Annotated[float | str, BeforeValidator(_number_or("dashpot"))]
NumberOrTime = Annotated[float | str, BeforeValidator(_number_or("time"))]
Restitution = Annotated[float | str, BeforeValidator(_restitution)]
Velocities = Annotated[str | tuple[str, ...], BeforeValidator(_one_or_several(_quantity("velocity")))]
PlainVelocities = Annotated[float | tuple[float, ...], BeforeValidator(_one_or_several(_plain_number))]
Steps = Annotated[
    tuple[tuple[str, str], ...],
    _steps(_quantity("time"), _quantity("force"), '[["0 s", "4 kN"], ["1 ms", "-2 kN"]]'),
]
PlainSteps = Annotated[
    tuple[tuple[float, float], ...],
    _steps(_plain_number, _plain_number, "[[0.0, 0.4], [0.1, -0.2]]"),
]


def number_of(key: str, given: float | str, dimension: str) -> float:
    """What a key holds as a number, in base units where it has a unit."""
    return si(given, dimension, key) if isinstance(given, str) else float(given)


def above_zero(key: str, given: float | str, dimension: str, remedy: str = "") -> float:
    """The same, of a key whose number must be greater than 0."""
    value = number_of(key, given, dimension)
    if not value > 0.0:
        article = "an" if dimension[0] in "aeiou" else "a"
        raise ParameterError(key, given, f"{article} {dimension} greater than 0", remedy)
    return value


class Table(BaseModel):
    """A table of a case file: nothing unknown, nothing changed afterwards, no number guessed from text."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)
