"""What the tables of a case file are made of: kinds of values, checked and kept as they are written, in both forms."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, get_args, get_origin, get_type_hints

from pydantic import BaseModel, BeforeValidator, ConfigDict, GetCoreSchemaHandler, ValidationInfo

from percuss.errors import ParameterError, UnitError, did_you_mean
from percuss.units import si


@dataclass(frozen=True)
class Kind:
    """What a key's values are: how pydantic checks them, what the reference and a dimensionless case make of it."""

    words: str
    check: Callable[..., Any] | None = None
    dimensions: tuple[str, ...] = ()
    """What text with a unit may be of."""
    plain: Any = None
    """The values in a dimensionless case; None for the same."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        if self.check is None:
            return handler(source)
        return BeforeValidator(self.check).__get_pydantic_core_schema__(source, handler)


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


def _plain_number(value: Any, info: ValidationInfo) -> Any:
    if not _is_number(value) or not math.isfinite(value):
        remedy = "only a case in SI takes units" if isinstance(value, str) else ""
        raise UnitError(info.field_name or "value", value, "a finite number in a dimensionless case", remedy)
    return value


PlainNumber = Annotated[float, Kind("number", _plain_number)]


def _quantity_of(*dimensions: str) -> Kind:
    """Text with a unit; a plain number in a dimensionless case."""
    return Kind(" or ".join(dimensions), _quantity(*dimensions), dimensions, PlainNumber)


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
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("pairs [re, im] of numbers from the mean up, for example [[0.9, 0.0], [1.0, 0.0]]")
    for i, pair in enumerate(value):
        good = isinstance(pair, list | tuple) and len(pair) == 2
        if not good or not all(map(_is_number, pair)):
            raise ValueError(f"pairs [re, im] of numbers; number {i} of the list is {str(pair)[:40]}")
    return tuple(tuple(float(x) for x in pair) for pair in value)


def _number_or(dimension: str, words: str = "") -> Kind:
    """A plain number (dimensionless), or text with a unit of the dimension."""
    quantity = _quantity(dimension)

    def check(value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, str):
            return quantity(value, info)
        if not _is_number(value) or not math.isfinite(value):
            accepted = f"a finite number (dimensionless), or text with a unit of {dimension}"
            raise UnitError(info.field_name or "value", value, accepted)
        return value

    return Kind(words or f"number or {dimension}", check, (dimension,), PlainNumber)


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
) -> Callable[[Any, ValidationInfo], Any]:
    """A check of a list of pairs, a time and the force from then on; it becomes a tuple of pairs."""

    def checked(value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, list | tuple) or not value:
            raise ValueError(f"pairs of a time and the force from then on, for example {example}")
        for i, pair in enumerate(value):
            if not isinstance(pair, list | tuple) or len(pair) != 2:
                found = f"number {i} of the list is {str(pair)[:40]}"
                raise ValueError(f"pairs of a time and the force from then on, for example {example}; {found}")
        return tuple((time(when, info), force(what, info)) for when, what in value)

    return checked


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _damping_value(value: Any, info: ValidationInfo) -> Any:
    """A number, text (whose unit the law decides), or a list of numbers."""
    if isinstance(value, list | tuple):
        return _numbers(value)
    if isinstance(value, str) or (_is_number(value) and math.isfinite(value)):
        return value
    raise UnitError(info.field_name or "value", value, "a finite number, text with a unit, or a list of numbers")


def list_of(what: str, example: str) -> Kind:
    """A list of tables, as a tuple."""

    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or not value:
            raise ValueError(f"a list of {what}, for example [{example}]")
        return tuple(value)

    return Kind("list of tables", check)


FROM_THE_BLOW = "from the blow"  # the restitution of a contact whose blow is resolved by waves


def _restitution(value: Any, info: ValidationInfo) -> Any:
    """A number, or the word for the restitution of the blow."""
    if value == FROM_THE_BLOW or (_is_number(value) and math.isfinite(value)):
        return value
    accepted = "a finite, plain number without quotes" if isinstance(value, str) else "a finite number"
    remedy = did_you_mean(value, [FROM_THE_BLOW])
    raise ParameterError(info.field_name or "restitution", value, f'{accepted}, or "{FROM_THE_BLOW}"', remedy)


Strain = Literal["kept", "reversed"]  # the contact laws by what they do to the strain
Law = Literal["b77", "b77-tau", "b77-blow"]
"""The laws of a blow: what is known of its restitution, its duration and its advance."""

Advance = Literal["kept", "pushed back", "residual penetration"]
"""How far the face of the tool is from one blow to the next."""

Length = Annotated[str, _quantity_of("length")]
Area = Annotated[str, _quantity_of("area")]
Frequency = Annotated[str, _quantity_of("frequency")]
Speed = Annotated[str, _quantity_of("velocity")]
Time = Annotated[str, _quantity_of("time")]
Stress = Annotated[str, _quantity_of("pressure")]
Density = Annotated[str, _quantity_of("density")]
Drag = Annotated[str, _quantity_of("damping")]
Mass = Annotated[str, _quantity_of("mass")]
Stiffness = Annotated[str, _quantity_of("stiffness")]
Dashpot = Annotated[str, _quantity_of("dashpot")]
Attenuation = Annotated[str, _quantity_of("attenuation")]
SpecificEnergy = Annotated[str, _quantity_of("specific energy")]
Flow = Annotated[str, _quantity_of("flow")]
Compliance = Annotated[str, _quantity_of("compliance")]
Volume = Annotated[str, _quantity_of("volume")]
Power = Annotated[str, _quantity_of("power")]
Force = Annotated[str, _quantity_of("force")]
ForceOrPressure = Annotated[str, _quantity_of("force", "pressure")]
ForceUnit = Annotated[str, Kind("unit of force or pressure", _unit)]
NumberOrLength = Annotated[float | str, _number_or("length")]
NumberOrVelocity = Annotated[float | str, _number_or("velocity")]
NumberOrTime = Annotated[float | str, _number_or("time")]
NumberOrStiffness = Annotated[float | str, _number_or("stiffness", "stiffness")]
NumberOrDashpot = Annotated[float | str, _number_or("dashpot", "dashpot")]
NumberOrDensity = Annotated[float | str, _number_or("density", "density, or number of kg/m³")]
Column = Annotated[str | int, Kind("name or number")]
Coefficients = Annotated[tuple[tuple[float, float], ...], Kind("list of pairs `[re, im]`", _pairs)]
Numbers = Annotated[tuple[float, ...], Kind("list of numbers", _numbers)]
DampingValue = Annotated[
    float | str | tuple[float, ...], Kind("number, text with a unit, or list of numbers", _damping_value)
]
Restitution = Annotated[float | str, Kind('number or `"from the blow"`', _restitution)]
PlainVelocities = Annotated[
    float | tuple[float, ...], Kind("number, or list of numbers", _one_or_several(_plain_number))
]
Velocities = Annotated[
    str | tuple[str, ...],
    Kind("velocity, or list of velocities", _one_or_several(_quantity("velocity")), plain=PlainVelocities),
]
PlainSteps = Annotated[
    tuple[tuple[float, float], ...],
    Kind("list of pairs of numbers", _steps(_plain_number, _plain_number, "[[0.0, 0.4], [0.1, -0.2]]")),
]
Steps = Annotated[
    tuple[tuple[str, str], ...],
    Kind(
        "list of pairs `[time, force]`",
        _steps(_quantity("time"), _quantity("force"), '[["0 s", "4 kN"], ["1 ms", "-2 kN"]]'),
        plain=PlainSteps,
    ),
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


class CaseTable(BaseModel):
    """A table of a case file: nothing unknown, nothing changed afterwards, no number guessed from text."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)

    in_plain: ClassVar[dict[str, str | None]] = {}
    """What of the dimensionless form does not follow from this one: the text of a key, None for a key that it lacks."""
    is_plain: ClassVar[bool] = False


def keys_of(table: type[CaseTable]) -> list[str]:
    """The keys of a table as a file has them; one that is a word of Python is another field here."""
    return [field.alias or name for name, field in table.model_fields.items()]


# ---- What the annotations of a table say


@cache
def hints_of(table: type[CaseTable]) -> dict[str, Any]:
    """The annotations of the keys of a table."""
    hints = get_type_hints(table, include_extras=True)
    return {name: hints[name] for name in table.model_fields}


def tables_in(hint: Any) -> list[type[CaseTable]]:
    """The tables that values of an annotation may be."""
    if isinstance(hint, type) and issubclass(hint, CaseTable):
        return [hint]
    return [table for part in get_args(hint) for table in tables_in(part)] if get_origin(hint) is not Literal else []


@cache
def _dimensions(table: type[CaseTable]) -> dict[str, str]:
    """The dimension of each key that text with a unit of one of them may stand for."""

    def kinds(hint: Any) -> list[Kind]:
        return [hint] if isinstance(hint, Kind) else [kind for part in get_args(hint) for kind in kinds(part)]

    found = {name: next(iter(kinds(hint)), Kind("")).dimensions for name, hint in hints_of(table).items()}
    return {name: dimensions[0] for name, dimensions in found.items() if len(dimensions) == 1}


def given_in(table: CaseTable, name: str = "") -> dict[str, Any]:
    """The keys of a table that are given, quantities as numbers in base units."""
    dimensions, found = _dimensions(type(table)), {}
    for key in type(table).model_fields:
        if (value := getattr(table, key)) is not None:
            found[key] = (
                si(value, dimensions[key], name + key) if key in dimensions and isinstance(value, str) else value
            )
    return found


@contextmanager
def keyed(
    name: str = "", keys: Mapping[str, str] | None = None, remedies: Mapping[str, str] | None = None
) -> Iterator[None]:
    """What the model refuses by its own names, by the keys of a case; `name` stands before them."""
    try:
        yield
    except ParameterError as error:
        own, bracket, place = error.name.partition("[")
        found = f"{name}{(keys or {}).get(own, own)}{bracket}{place}"
        remedy = (remedies or {}).get(own, error.remedy)
        raise ParameterError(found, error.value, error.accepted, remedy) from None
