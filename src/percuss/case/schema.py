"""What a case file may say: one pydantic model for every table, in the SI form and in the dimensionless form.

The models keep what the file says (SI quantities as text with their units), so that a case can be written back as it
was read; `percuss.case.building` makes the objects. A new load is a new class in one of the two unions at the end; a
new table is a new optional field of both cases.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from percuss.case.values import (
    Area,
    Coefficients,
    Column,
    Damping,
    Density,
    Force,
    ForceOrPressure,
    ForceUnit,
    Frequency,
    Length,
    NumberOrLength,
    NumberOrTime,
    NumberOrVelocity,
    Numbers,
    PlainNumber,
    Stress,
    Table,
)

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
    "PlainSimulation",
    "PlainStart",
    "SimulationTable",
    "SquareForce",
    "SquareLoad",
    "StartTable",
    "SystemTable",
    "table_fields",
]


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


class StartTable(Table):
    """Where a simulation starts: rigid, modal, on a steady motion, or drawn; in SI with units, or in plain numbers."""

    position: NumberOrLength | None = None
    velocity: NumberOrVelocity | None = None
    time: NumberOrTime | None = None
    modal_displacement: Numbers | None = None
    modal_velocity: Numbers | None = None
    orbit: int | None = None
    periods: int | None = None
    random: Literal["rigid", "still", "ringing"] | None = None
    seed: int | None = None


class PlainStart(StartTable):
    """The same beside a dimensionless system, which knows no units."""

    position: PlainNumber | None = None
    velocity: PlainNumber | None = None
    time: PlainNumber | None = None


class SimulationTable(Table):
    """How a simulation is made and when it ends; times with a unit, or in radians of the load's fundamental."""

    modes: int | None = None
    impacts: int | None = None
    time: NumberOrTime | None = None
    periodic: bool | None = None
    tolerance: float | None = None


class PlainSimulation(SimulationTable):
    """The same beside a dimensionless system, which knows no units."""

    time: PlainNumber | None = None


class PhysicalCase(Table):
    """The SI form: [bar], [load], [contact], and what a simulation takes."""

    title: str | None = None
    bar: BarTable
    load: Annotated[HarmonicForce | SquareForce | FourierForce | HistoryForce, Field(discriminator="kind")]
    contact: ContactTable
    start: StartTable | None = None
    simulation: SimulationTable | None = None


class PlainCase(Table):
    """The dimensionless form: [system], [load], and what a simulation takes."""

    title: str | None = None
    system: SystemTable
    load: Annotated[HarmonicLoad | SquareLoad | FourierLoad | HistoryLoad, Field(discriminator="kind")]
    start: PlainStart | None = None
    simulation: PlainSimulation | None = None


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
_TABLES: dict[str, type[Table]] = {
    "bar": BarTable,
    "contact": ContactTable,
    "system": SystemTable,
    "start": StartTable,
    "simulation": SimulationTable,
}


def table_fields(form: type[Table], kind: object) -> dict[str, list[str]]:
    """The keys that every table of a form takes, for a load of the given kind; '' is the top of the file."""
    fields = {"": list(form.model_fields)}
    fields |= {name: list(table.model_fields) for name, table in _TABLES.items() if name in form.model_fields}
    load = _LOADS[form].get(kind) if isinstance(kind, str) else None
    fields["load"] = list(load.model_fields) if load else ["kind"]
    return fields
