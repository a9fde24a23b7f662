"""What a case file may say: one pydantic model for every table, in the SI form and in the dimensionless form.

The models keep what the file says (SI quantities as text with their units), so that a case can be written back as it
was read; `percuss.case.file_format.building` makes the objects. A new load is a new class in one of the two unions at
the end; a new table is a new optional field of both cases. The text below a key is what the reference prints; what
stands there for a key of one load holds for its dimensionless form, and for the loads after it that say nothing.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from percuss.case.file_format.values import (
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
    Time,
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
    "keys_of",
    "table_fields",
]


class BarTable(Table):
    length: Length
    """Length from the driven to the striking end. Allowed: greater than 0."""
    area: Area | None = None
    """Area of the cross-section. Allowed: greater than 0. When left out: `diameter` is needed."""
    diameter: Length | None = None
    """Diameter of a solid round bar. Allowed: greater than 0. When left out: `area` is needed."""
    youngs_modulus: Stress | None = None
    """Young's modulus of the material. Allowed: greater than 0. When left out: steel, `"210 GPa"`."""
    density: Density | None = None
    """Density of the material. Allowed: greater than 0. When left out: steel, `"7850 kg/m^3"`."""
    damping: Damping | None = None
    """Force per velocity and per metre of bar. Allowed: 0 or greater. When left out: as `damping_ratio` gives."""
    damping_ratio: float | None = None
    """The same as a fraction of the critical damping of the first elastic mode. Allowed: 0 or greater. When left out:
    none."""


class ContactTable(Table):
    restitution: float | None = None
    """Coefficient of restitution. Allowed: 0 to 1. When left out: `receiving_area` is needed."""
    receiving_area: Area | None = None
    """Cross-section of a long rod of the same material that is struck. Allowed: at least that of the bar. When left
    out: `restitution` is needed."""


class SystemTable(Table):
    s: float
    r"""Wave speed $C/(L\Omega)$. Allowed: greater than 0."""
    d: float
    r"""Damping $D/(M\Omega)$. Allowed: 0 or greater."""
    restitution: float
    """Coefficient of restitution. Allowed: 0 to 1."""


class HarmonicForce(Table):
    kind: Literal["harmonic"]
    """The kind of load, which decides the other keys."""
    mean: ForceOrPressure
    """Mean of the load, positive toward the wall."""
    amplitude: ForceOrPressure
    """Amplitude of the alternating part."""
    harmonic: int = 1
    """The multiple of the fundamental. Allowed: 1 to 4096."""
    area: Area | None = None
    """The area that a pressure acts on. Allowed: greater than 0. When left out: the load is a force."""
    frequency: Frequency
    """Frequency of the fundamental. Allowed: greater than 0."""


class SquareForce(Table):
    kind: Literal["square"]
    amplitude: ForceOrPressure
    """The load alternates between plus and minus this value. Allowed: greater than 0."""
    kappa: float
    """The load is positive for a fraction κ/2 of each period. Allowed: between 0 and 2."""
    harmonics: int = 64
    """How many Fourier coefficients are kept beside the exact steps. Allowed: 1 to 4096."""
    area: Area | None = None
    frequency: Frequency


class FourierForce(Table):
    kind: Literal["fourier"]
    coefficients: Coefficients
    """Fourier coefficients from $p_0$ (the mean, imaginary part 0) up. Allowed: 1 to 4097 pairs."""
    unit: ForceUnit
    """Unit of the coefficients."""
    area: Area | None = None
    frequency: Frequency


class HistoryForce(Table):
    kind: Literal["history"]
    file: str
    """Path relative to the case file; CSV or other text, or `.mat`, `.wav`, `.h5`, `.tdms` with `percuss[io]`."""
    area: Area | None = None
    frequency: Frequency | None = None
    """Frequency of the fundamental. Allowed: greater than 0. When left out: found from the record."""
    harmonics: Annotated[int, Field(ge=1)] | None = None
    """How many harmonics to keep. When left out: those that stand out from the scatter of the cycles."""
    column: Column | None = None
    """Which column or channel holds the values. When left out: the header tells."""
    unit: str | None = None
    """Unit of the values, of force or pressure. When left out: the header tells."""
    time_column: Column | None = None
    """Which column or channel holds the times. When left out: the header tells."""
    sample_rate: Frequency | None = None
    """Sample rate, for a file that holds no times, or wrong ones. Allowed: greater than 0. When left out: the file
    tells."""
    opposing_column: Column | None = None
    """Which column or channel holds the pressure (or force) on the opposing face, which pushes back: the load is
    pressure × `area` − opposing pressure × `opposing_area`. When left out: there is none."""
    opposing_area: Area | None = None
    """The area that the opposing pressure acts on. Allowed: greater than 0."""
    start: Time | None = Field(None, alias="from")
    """Where the part of the record that is used begins, on the clock of the record; dates and times of day count from
    the first sample. When left out: at the first sample."""
    end: Time | None = Field(None, alias="to")
    """Where that part ends. When left out: at the last sample."""


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
    """The force that counts as $p = 1$. Allowed: greater than 0."""


class StartTable(Table):
    """Where a simulation starts: rigid, modal, on a steady motion, or drawn; in SI with units, or in plain numbers."""

    position: NumberOrLength | None = None
    """Rigid: position of the bar. With `orbit`, added to that motion, and 0 unless given. Allowed: 0 (on the wall) or
    less. When left out: −1."""
    velocity: NumberOrVelocity | None = None
    """Rigid: velocity of the bar, positive toward the wall. With `orbit`, added to that motion. When left out: 0."""
    time: NumberOrTime | None = None
    """Load phase at the start, in radians; not allowed with `orbit`. When left out: 0."""
    modal_displacement: Numbers | None = None
    r"""Modal: $u_0, u_1, \dots$, where $u(x) = u_0 + 2\sum u_n\cos n\pi x$. With `orbit`, added to that
    motion. When left out: 0."""
    modal_velocity: Numbers | None = None
    r"""Modal: $u_0', u_1', \dots$. With `orbit`, added to that motion. When left out: 0."""
    orbit: int | None = None
    """Just after the impact of this steady motion, numbered as `percuss steady` does. Allowed: 1 or greater."""
    periods: int | None = None
    """With `orbit`: load periods per impact of that motion. Allowed: 1 or greater. When left out: 1."""
    random: Literal["rigid", "still", "ringing"] | None = None
    """A random start: undeformed, undeformed and at rest, or with ringing modes."""
    seed: int | None = None
    """With `random`; the same seed gives the same start. Allowed: 0 or greater. When left out: 0."""


class PlainStart(StartTable):
    """Where a simulation of a dimensionless system starts: the keys of `StartTable` without units."""

    position: PlainNumber | None = None
    velocity: PlainNumber | None = None
    time: PlainNumber | None = None


class SimulationTable(Table):
    """How a simulation is made and when it ends; times with a unit, or in radians of the load's fundamental."""

    modes: int | None = None
    """Elastic modes; 0 is a rigid bar. Allowed: 0 to 4096. When left out: 32."""
    impacts: int | None = None
    """End after this many impacts. Allowed: 0 to 1e9. When left out: 2000, or a million with `time`."""
    time: NumberOrTime | None = None
    """End after this time from the start, in radians. Allowed: greater than 0. When left out: `impacts` decides."""
    periodic: bool | None = None
    """Whether to end when a periodic motion is found. When left out: true."""
    tolerance: float | None = None
    """How closely a state must return to count as the same. Allowed: 1e-13 to 0.1. When left out: 1e-9."""


class PlainSimulation(SimulationTable):
    """How a dimensionless system is simulated: the keys of `SimulationTable` without units."""

    time: PlainNumber | None = None


class PhysicalCase(Table):
    """The SI form: [bar], [load], [contact], and what a simulation takes."""

    title: str | None = None
    """Free text."""
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
    fields = {"": keys_of(form)}
    fields |= {name: keys_of(table) for name, table in _TABLES.items() if name in form.model_fields}
    load = _LOADS[form].get(kind) if isinstance(kind, str) else None
    fields["load"] = keys_of(load) if load else ["kind"]
    return fields


def keys_of(table: type[Table]) -> list[str]:
    """The keys of a table as a file has them; one that is a word of Python is another field here."""
    return [field.alias or name for name, field in table.model_fields.items()]
