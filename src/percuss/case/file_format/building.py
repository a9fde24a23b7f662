"""From the tables of a case to the objects of the model, with every refusal translated to its key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from percuss.case.file_format.body_building import contact_of, plain_body, plain_contact, sized_body
from percuss.case.file_format.load_building import load_of
from percuss.case.file_format.load_tables import HistoryForce
from percuss.case.file_format.problems import from_parameter, raise_all
from percuss.case.file_format.recorded_load import history_load
from percuss.case.file_format.schema import PhysicalCase, PlainCase, SystemTable
from percuss.case.file_format.start_and_simulation import checked_simulation, checked_start
from percuss.errors import CaseError, ParameterError
from percuss.model import Contact, Load, SizedBody, System
from percuss.model.body import Body

__all__ = ["Parts", "Recording", "recording_of", "system_of"]

Recording = tuple[Load, tuple[str, ...]]
"""The load of a recording, and what was assumed in reading it."""


class Parts:
    """The objects behind the tables of a case, as far as they can be made without reading a recording.

    Raises
    ------
    CaseError
        With the problems of all tables together.
    """

    def __init__(self, tables: PhysicalCase | PlainCase, file: str) -> None:
        self.bar: SizedBody | None = None
        self.body: Body | None = None
        self.contact: Contact | None = None
        self.load: Load | None = None
        self._problems: list[CaseError] = []
        self._file = file
        if isinstance(tables, PhysicalCase):
            if tables.bar.length is None and tables.bar.sections is None:
                remedy = 'give it with its unit, for example length = "341 mm", or give sections'
                self._problems.append(CaseError(file, "bar.length", None, "missing", remedy))
            else:
                self.bar = self._try("bar", tables.bar, sized_body)
            self.contact = self._try("contact", tables.contact, lambda table: contact_of(table, self.bar))
        elif not _says_its_damping(tables.system):
            remedy = 'add it, or a law of damping: damping = {kind = "ratio", value = 0.001}'
            self._problems.append(CaseError(file, "system.d", None, "missing", remedy))
        else:
            self.body = self._try("system", tables.system, plain_body)
            self.contact = self._try("system", tables.system, plain_contact)
        if not isinstance(tables.load, HistoryForce):
            self.load = self._try("load", tables.load, load_of)
        self._check_fit(tables)
        if tables.start is not None:
            self._try("start", tables.start, checked_start)
        if tables.simulation is not None:
            self._try("simulation", tables.simulation, checked_simulation)
        if self._problems:
            raise_all(self._problems)

    def _check_fit(self, tables: PhysicalCase | PlainCase) -> None:
        """Whether the body takes the law of the contact, and the load at its place."""
        body = self.body
        if self.bar is not None:  # the load, and so the time that counts as 1, may be unknown yet
            body = _some_body(self.bar)
        if body is None:
            return
        contact = self.contact
        if contact is not None:
            name = "contact" if isinstance(tables, PhysicalCase) else "system"
            self._try(name, getattr(tables, name), lambda _: contact.check(body))
        if self.load is not None or isinstance(tables.load, HistoryForce):
            self._try("load", tables.load, lambda table: body.place(table.at))

    def _try(self, name: str, table: BaseModel, make: Any) -> Any:
        try:
            return make(table)
        except ParameterError as error:
            self._problems.append(from_parameter(error, self._file, name, table.model_dump(by_alias=True)))
        except ArithmeticError:
            self._problems.append(_extreme(self._file, name))
        return None


def _says_its_damping(table: SystemTable) -> bool:
    """Whether the damping is given, or the bar is stepped: then it has none unless it is given."""
    return (table.d, table.damping, table.impedances, table.transit_times) != (None, None, None, None)


def _some_body(bar: SizedBody) -> Body | None:
    """The body under a load that takes as long as a wave from end to end; None when that is out of scale."""
    try:
        return bar.body(1.0 / bar.transit_time)
    except (ParameterError, ArithmeticError):
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
            assert parts.body is not None and parts.contact is not None
            system = System(parts.body, load, parts.contact)
        else:
            assert parts.bar is not None and parts.contact is not None
            system = System.from_si(parts.bar, load, parts.contact)
    except ParameterError as error:
        if error.name in _MEANING:
            raise _out_of_scale(error, tables, file) from None
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise _extreme(file, "") from None
    return system


_MEANING = {
    "s": "the wave speed C/(LΩ) is s",
    "d": "the damping D/(MΩ) is d",
    "eta": "the damping ηΩ",
    "load": "the load P/(M L² Ω²)",
}
"""What of a system may be out of scale, by the name that the model has for it."""


def _out_of_scale(error: ParameterError, tables: PhysicalCase | PlainCase, file: str) -> CaseError:
    """A dimensionless number that no hammer has, told in the words of the case."""
    if isinstance(tables, PlainCase):
        key = "load" if error.name == "load" else f"system.{error.name}"
        return CaseError(file, key, error.value, f"expected {error.accepted}", "check the scales")
    remedy = "check the units of length, frequency, damping and force"
    return CaseError(file, _MEANING[error.name], error.value, f"expected {error.accepted}", remedy)


def _extreme(file: str, key: str) -> CaseError:
    return CaseError(file, key, None, "sizes so large or small that numbers overflow", "check the units")
