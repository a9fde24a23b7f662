"""The table [load] of a case file: one pydantic model for every kind of load, in SI and in plain numbers.

A new load is a new class for each form, and a place in the two unions at the end. The text below a key is what the
reference prints; what stands there for a key of one load holds for its dimensionless form, and for the loads after it
that say nothing.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from percuss.case.file_format.values import (
    Area,
    Coefficients,
    Column,
    Force,
    ForceOrPressure,
    ForceUnit,
    Frequency,
    Numbers,
    Table,
    Time,
)
from percuss.case.file_format.valve_tables import ValveForce, ValveLoad

__all__ = [
    "AnyLoad",
    "FourierForce",
    "FourierLoad",
    "HarmonicForce",
    "HarmonicLoad",
    "HistoryForce",
    "HistoryLoad",
    "PhysicalLoad",
    "PlainLoad",
    "SquareForce",
    "SquareLoad",
    "StepsForce",
    "StepsLoad",
    "ValveForce",
    "ValveLoad",
]


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
    at: int = 0
    """Where the load acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""


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
    at: int = 0


class StepsForce(Table):
    kind: Literal["steps"]
    breaks: Numbers
    """Load phases at which the load jumps, in radians, increasing, from 0 to less than 2π. Allowed: from 2 to 1000 of
    them."""
    values: Numbers
    """The load from each of these phases to the next. Allowed: one for each phase."""
    unit: ForceUnit
    """Unit of the values."""
    harmonics: int = 64
    """How many Fourier coefficients are kept beside the exact steps. Allowed: 1 to 4096."""
    area: Area | None = None
    frequency: Frequency
    at: int = 0


class FourierForce(Table):
    kind: Literal["fourier"]
    coefficients: Coefficients
    """Fourier coefficients from $p_0$ (the mean, imaginary part 0) up. Allowed: 1 to 4097 pairs."""
    unit: ForceUnit
    """Unit of the coefficients."""
    area: Area | None = None
    frequency: Frequency
    at: int = 0


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
    at: int = 0


class HarmonicLoad(Table):
    kind: Literal["harmonic"]
    mean: float
    amplitude: float
    harmonic: int = 1
    at: int = 0


class SquareLoad(Table):
    kind: Literal["square"]
    amplitude: float
    kappa: float
    harmonics: int = 64
    at: int = 0


class StepsLoad(Table):
    kind: Literal["steps"]
    breaks: Numbers
    values: Numbers
    harmonics: int = 64
    at: int = 0


class FourierLoad(Table):
    kind: Literal["fourier"]
    coefficients: Coefficients
    at: int = 0


class HistoryLoad(HistoryForce):
    """A recording beside a dimensionless system: `force_scale` is the force that counts as p = 1."""

    force_scale: Force
    """The force that counts as $p = 1$. Allowed: greater than 0."""


PhysicalLoad = HarmonicForce | SquareForce | FourierForce | HistoryForce | StepsForce | ValveForce
"""The loads of the SI form."""

PlainLoad = HarmonicLoad | SquareLoad | FourierLoad | HistoryLoad | StepsLoad | ValveLoad
"""The loads of the dimensionless form."""

AnyLoad = PhysicalLoad | PlainLoad
