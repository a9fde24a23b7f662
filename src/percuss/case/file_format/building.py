"""From the tables of a case to the objects of the model, with every refusal translated to its key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from percuss.case.file_format.problems import from_parameter, raise_all
from percuss.case.file_format.recorded_load import history_load, positive_area, positive_frequency
from percuss.case.file_format.schema import (
    BarTable,
    ContactTable,
    FourierForce,
    FourierLoad,
    HarmonicForce,
    HarmonicLoad,
    HistoryForce,
    PhysicalCase,
    PlainCase,
    SquareForce,
    SquareLoad,
)
from percuss.case.file_format.start_and_simulation import checked_simulation, checked_start
from percuss.errors import CaseError, ParameterError
from percuss.model import Bar, Contact, Kept, Load, System
from percuss.units import si

__all__ = ["Parts", "Recording", "recording_of", "system_of"]

Recording = tuple[Load, tuple[str, ...]]
"""The load of a recording, and what was assumed in reading it."""

AnyLoad = HarmonicForce | SquareForce | FourierForce | HistoryForce | HarmonicLoad | SquareLoad | FourierLoad


class Parts:
    """The objects behind the tables of a case, as far as they can be made without reading a recording.

    Raises
    ------
    CaseError
        With the problems of all tables together.
    """

    def __init__(self, tables: PhysicalCase | PlainCase, file: str) -> None:
        self.bar: Bar | None = None
        self.contact: Contact | None = None
        self.load: Load | None = None
        self._problems: list[CaseError] = []
        self._file = file
        if isinstance(tables, PhysicalCase):
            self.bar = self._try("bar", tables.bar, _bar)
            self.contact = self._try("contact", tables.contact, lambda table: _contact(table, self.bar))
        else:
            self._try("system", tables.system, _check_system)
        if not isinstance(tables.load, HistoryForce):
            self.load = self._try("load", tables.load, _load)
        if tables.start is not None:
            self._try("start", tables.start, checked_start)
        if tables.simulation is not None:
            self._try("simulation", tables.simulation, checked_simulation)
        if self._problems:
            raise_all(self._problems)

    def _try(self, name: str, table: BaseModel, make: Any) -> Any:
        try:
            return make(table)
        except ParameterError as error:
            self._problems.append(from_parameter(error, self._file, name, table.model_dump(by_alias=True)))
        except ArithmeticError:
            self._problems.append(_extreme(self._file, name))
        return None


def recording_of(tables: PhysicalCase | PlainCase, file: str, folder: Path) -> Recording | None:
    """The load of the recording that a case names, or None when its load is a formula.

    Raises
    ------
    CaseError
        When the recording cannot be read or used.
    """
    return history_load(tables.load, file, folder) if isinstance(tables.load, HistoryForce) else None


def system_of(tables: PhysicalCase | PlainCase, parts: Parts, load: Load, file: str) -> System:
    """The system of a case.

    Raises
    ------
    CaseError
        When the load does not fit the case.
    """
    try:
        if isinstance(tables, PlainCase):
            table = tables.system
            system = System(s=table.s, d=table.d, restitution=table.restitution, load=load)
        else:
            assert parts.bar is not None and parts.contact is not None
            system = System.from_si(parts.bar, load, parts.contact)
    except ParameterError as error:
        if error.name in ("s", "d", "load"):
            raise _out_of_scale(error, tables, file) from None
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise _extreme(file, "") from None
    return system


def _out_of_scale(error: ParameterError, tables: PhysicalCase | PlainCase, file: str) -> CaseError:
    """A dimensionless number that no hammer has, told in the words of the case."""
    if isinstance(tables, PlainCase):
        key = "load" if error.name == "load" else f"system.{error.name}"
        return CaseError(file, key, error.value, f"expected {error.accepted}", "check the scales")
    meaning = {"s": "the wave speed C/(LΩ) is s", "d": "the damping D/(MΩ) is d", "load": "the load P/(M L² Ω²)"}
    remedy = "check the units of length, frequency, damping and force"
    return CaseError(file, meaning[error.name], error.value, f"expected {error.accepted}", remedy)


def _extreme(file: str, key: str) -> CaseError:
    return CaseError(file, key, None, "sizes so large or small that numbers overflow", "check the units")


# -- the parts ------------------------------------------------------------------------------------------------------


def _bar(table: BarTable) -> Bar:
    sizes: dict[str, Any] = {}
    for name, dimension in _BAR_UNITS.items():
        text = getattr(table, name)
        if text is not None:
            sizes[name] = si(text, dimension, name)
            if sizes[name] <= 0.0 and name != "damping":  # 0 means "not given" to Bar
                raise ParameterError(name, text, f"a {dimension} greater than 0")
    if table.damping is not None and table.damping_ratio is not None:
        raise ParameterError("damping_ratio", table.damping_ratio, "either damping or damping_ratio, not both")
    if (table.area is None) == (table.diameter is None):
        raise ParameterError("diameter", table.diameter, "either a diameter or an area")
    drag = sizes.pop("damping", None)
    return Bar(**sizes, damping_ratio=table.damping_ratio, drag=drag)


_BAR_UNITS = {
    "length": "length",
    "area": "area",
    "diameter": "length",
    "youngs_modulus": "pressure",
    "density": "density",
    "damping": "damping",
}


def _contact(table: ContactTable, bar: Bar | None) -> Contact | None:
    if table.receiving_area is None:
        if table.restitution is None:
            raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area")
        return Kept(table.restitution)
    if table.restitution is not None:
        raise ParameterError("receiving_area", table.receiving_area, "either restitution or receiving_area, not both")
    receiving = si(table.receiving_area, "area", "receiving_area")
    return None if bar is None else Kept(receiving_area=receiving, area=bar.area)


def _check_system(table: Any) -> None:
    System(s=table.s, d=table.d, restitution=table.restitution, load=Load.harmonic(1.0, 1.0))


def _load(table: AnyLoad) -> Load:
    if isinstance(table, HarmonicForce | SquareForce | FourierForce):
        return _force(table)
    if isinstance(table, HarmonicLoad):
        return Load.harmonic(table.mean, table.amplitude, table.harmonic)
    if isinstance(table, SquareLoad):
        return Load.square(table.amplitude, table.kappa, table.harmonics)
    assert isinstance(table, FourierLoad)
    return Load.fourier(_complex(table.coefficients))


def _force(table: HarmonicForce | SquareForce | FourierForce) -> Load:
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
    return Load.fourier([unit * p for p in _complex(table.coefficients)], frequency=frequency)


def _complex(pairs: tuple[tuple[float, float], ...]) -> list[complex]:
    return [complex(re, im) for re, im in pairs]
