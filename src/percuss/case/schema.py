"""What a case file may say: one pydantic model for every table, in the SI form and in the dimensionless form.

The models keep what the file says (SI quantities as text with their units), so that a case can be written back as it
was read; `percuss.case.building` makes the objects. A new load is a new class in one of the two unions at the end; a
new table (``[start]``, ``[simulation]``) is a new optional field of both cases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo

from percuss.errors import UnitError
from percuss.units import si

__all__ = [
    "BarTable",
    "ContactTable",
    "FourierForce",
    "FourierLoad",
    "HarmonicForce",
    "HarmonicLoad",
    "HistoryForce",
    "HistoryLoad",
    "PhysicalCase",
    "PlainCase",
    "SquareForce",
    "SquareLoad",
    "SystemTable",
    "table_fields",
]


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
    if not isinstance(value, list) or not value:
        raise ValueError("pairs [re, im] of numbers from the mean up, for example [[0.9, 0.0], [1.0, 0.0]]")
    for i, pair in enumerate(value):
        good = isinstance(pair, list) and len(pair) == 2
        if not good or any(isinstance(x, bool) or not isinstance(x, int | float) for x in pair):
            raise ValueError(f"pairs [re, im] of numbers; number {i} of the list is {str(pair)[:40]}")
    return tuple(tuple(float(x) for x in pair) for pair in value)


Length = Annotated[str, BeforeValidator(_quantity("length"))]
Area = Annotated[str, BeforeValidator(_quantity("area"))]
Frequency = Annotated[str, BeforeValidator(_quantity("frequency"))]
Stress = Annotated[str, BeforeValidator(_quantity("pressure"))]
Density = Annotated[str, BeforeValidator(_quantity("density"))]
Damping = Annotated[str, BeforeValidator(_quantity("damping"))]
Force = Annotated[str, BeforeValidator(_quantity("force"))]
ForceOrPressure = Annotated[str, BeforeValidator(_quantity("force", "pressure"))]
ForceUnit = Annotated[str, BeforeValidator(_unit)]
Coefficients = Annotated[tuple[tuple[float, float], ...], BeforeValidator(_pairs)]
Column = str | int


class Table(BaseModel):
    """A table of a case file: nothing unknown, nothing changed afterwards, no number guessed from text."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class BarTable(Table):
    length: Length
    area: Area | None = None
    diameter: Length | None = None
    youngs_modulus: Stress | None = None
    density: Density | None = None
    damping: Damping | None = None
    damping_ratio: float | None = None


class ContactTable(Table):
    restitution: float | None = None
    receiving_area: Area | None = None


class SystemTable(Table):
    s: float
    d: float
    restitution: float


class HarmonicForce(Table):
    kind: Literal["harmonic"]
    mean: ForceOrPressure
    amplitude: ForceOrPressure
    harmonic: int = 1
    area: Area | None = None
    frequency: Frequency


class SquareForce(Table):
    kind: Literal["square"]
    amplitude: ForceOrPressure
    kappa: float
    harmonics: int = 64
    area: Area | None = None
    frequency: Frequency


class FourierForce(Table):
    kind: Literal["fourier"]
    coefficients: Coefficients
    unit: ForceUnit
    area: Area | None = None
    frequency: Frequency


class HistoryForce(Table):
    kind: Literal["history"]
    file: str
    area: Area | None = None
    frequency: Frequency | None = None
    harmonics: Annotated[int, Field(ge=1)] | None = None
    column: Column | None = None
    unit: str | None = None
    time_column: Column | None = None
    sample_rate: Frequency | None = None


class HarmonicLoad(Table):
    kind: Literal["harmonic"]
    mean: float
    amplitude: float
    harmonic: int = 1


class SquareLoad(Table):
    kind: Literal["square"]
    amplitude: float
    kappa: float
    harmonics: int = 64


class FourierLoad(Table):
    kind: Literal["fourier"]
    coefficients: Coefficients


class HistoryLoad(HistoryForce):
    """A recording beside a dimensionless system: `force_scale` is the force that counts as p = 1."""

    force_scale: Force


class PhysicalCase(Table):
    """The SI form: [bar], [load], [contact]."""

    title: str | None = None
    bar: BarTable
    load: Annotated[HarmonicForce | SquareForce | FourierForce | HistoryForce, Field(discriminator="kind")]
    contact: ContactTable


class PlainCase(Table):
    """The dimensionless form: [system], [load]."""

    title: str | None = None
    system: SystemTable
    load: Annotated[HarmonicLoad | SquareLoad | FourierLoad | HistoryLoad, Field(discriminator="kind")]


_LOADS: dict[type[Table], dict[str, type[Table]]] = {
    PhysicalCase: {
        "harmonic": HarmonicForce,
        "square": SquareForce,
        "fourier": FourierForce,
        "history": HistoryForce,
    },
    PlainCase: {
        "harmonic": HarmonicLoad,
        "square": SquareLoad,
        "fourier": FourierLoad,
        "history": HistoryLoad,
    },
}
_TABLES: dict[str, type[Table]] = {"bar": BarTable, "contact": ContactTable, "system": SystemTable}


def table_fields(form: type[Table], kind: object) -> dict[str, list[str]]:
    """The keys that every table of a form takes, for a load of the given kind; '' is the top of the file."""
    fields = {"": list(form.model_fields)}
    fields |= {name: list(table.model_fields) for name, table in _TABLES.items() if name in form.model_fields}
    load = _LOADS[form].get(kind) if isinstance(kind, str) else None
    fields["load"] = list(load.model_fields) if load else ["kind"]
    return fields
