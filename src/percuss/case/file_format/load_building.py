"""From the table [load] of a case to a load, except recordings."""

from __future__ import annotations

from percuss.case.file_format.load_tables import (
    AnyLoad,
    FourierForce,
    FourierLoad,
    HarmonicForce,
    HarmonicLoad,
    SquareForce,
    SquareLoad,
    StepsForce,
    StepsLoad,
)
from percuss.case.file_format.recorded_load import positive_area, positive_frequency
from percuss.errors import ParameterError
from percuss.model import Load
from percuss.units import si

__all__ = ["load_of"]

_MOST_STEPS = 1000
"""Steps of a load; each of the thousands of harmonics is a sum over them."""

_Formula = HarmonicForce | SquareForce | StepsForce | FourierForce


def load_of(table: AnyLoad) -> Load:
    """The load that a formula describes: in N with its frequency, or dimensionless.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    return _formula(table).acting_at(table.at)


def _formula(table: AnyLoad) -> Load:
    if isinstance(table, StepsForce | StepsLoad) and len(table.breaks) > _MOST_STEPS:
        raise ParameterError("breaks", f"{len(table.breaks)} phases", f"at most {_MOST_STEPS}")
    if isinstance(table, _Formula):
        return _force(table)
    if isinstance(table, HarmonicLoad):
        return Load.harmonic(table.mean, table.amplitude, table.harmonic)
    if isinstance(table, SquareLoad):
        return Load.square(table.amplitude, table.kappa, table.harmonics)
    if isinstance(table, StepsLoad):
        return Load.steps(table.breaks, table.values, table.harmonics)
    assert isinstance(table, FourierLoad)
    return Load.fourier(_complex(table.coefficients))


def _force(table: _Formula) -> Load:
    frequency = positive_frequency(table.frequency, "frequency")
    area = None if table.area is None else positive_area(table.area)

    def newtons(text: str, name: str) -> float:
        if area is not None:
            return si(text, "pressure", name) * area
        try:
            return si(text, "force", name)
        except ParameterError as error:
            remedy = 'a pressure also needs the area that it acts on: area = "6.5 cm^2"'
            raise ParameterError(name, text, error.accepted, remedy) from None

    if isinstance(table, HarmonicForce):
        mean, amplitude = newtons(table.mean, "mean"), newtons(table.amplitude, "amplitude")
        return Load.harmonic(mean, amplitude, table.harmonic, frequency=frequency)
    if isinstance(table, SquareForce):
        amplitude = newtons(table.amplitude, "amplitude")
        return Load.square(amplitude, table.kappa, table.harmonics, frequency=frequency)
    unit = newtons(f"1 {table.unit}", "unit")
    if isinstance(table, StepsForce):
        return Load.steps(table.breaks, [unit * p for p in table.values], table.harmonics, frequency=frequency)
    return Load.fourier([unit * p for p in _complex(table.coefficients)], frequency=frequency)


def _complex(pairs: tuple[tuple[float, float], ...]) -> list[complex]:
    return [complex(re, im) for re, im in pairs]
