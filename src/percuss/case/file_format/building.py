"""From the tables of a case to the objects of the model, with every refusal translated to its key."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from percuss.case.file_format.body_building import plain_body, sized_body
from percuss.case.file_format.contact_building import check_body, contact_of, plain_contact, plain_law, si_law
from percuss.case.file_format.contact_from_blow import restitution_of, timed_law
from percuss.case.file_format.held_building import check_beside, held_body, sized_structure
from percuss.case.file_format.load_building import load_of
from percuss.case.file_format.load_tables import HistoryForce, ValveForce, ValveLoad
from percuss.case.file_format.problems import from_parameter, raise_all, without_blow
from percuss.case.file_format.recorded_load import ReadHistory, history_load
from percuss.case.file_format.schema import PhysicalCase, PlainCase, SystemTable
from percuss.case.file_format.start_and_simulation import checked_simulation, checked_start
from percuss.case.file_format.tool_building import (
    NO_BIT,
    BlowQuestion,
    blow_question,
    plain_target,
    rock_of,
    sized_target,
)
from percuss.case.file_format.valve_building import valve_of
from percuss.errors import CaseError, ParameterError
from percuss.model import Contact, Load, SizedBody, System, Valve
from percuss.model.body import Body
from percuss.model.contact import Timed

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall

__all__ = ["Parts", "check_motion", "extreme", "recording_of", "system_of"]

"""The load of a recording, and what was assumed in reading it."""


class Parts:
    """The objects behind the tables of a case, as far as they can be made without reading a recording.

    Raises
    ------
    CaseError
        With the problems of all tables together.
    """

    def __init__(self, tables: PhysicalCase | PlainCase, file: str, folder: Path = Path(".")) -> None:
        self.bar: SizedBody | None = None
        self.body: Body | None = None
        self.contact: Contact | None = None
        self.load: Load | None = None
        self.valve: Valve | None = None
        self.target: Rod | Wall | None = None
        self.blow: BlowQuestion | None = None
        self._problems: list[CaseError] = []
        self._file = file
        if tables.body is not None:
            self._structure(tables, folder)
        elif isinstance(tables, PhysicalCase):
            if tables.bar.length is None and tables.bar.sections is None:
                remedy = 'give it with its unit, for example length = "341 mm", or give sections'
                self._problems.append(CaseError(file, "bar.length", None, "missing", remedy))
            else:
                self.bar = self._try("bar", tables.bar, sized_body)
            if tables.contact is not None:
                make = partial(contact_of, bar=self.bar, tool=tables.tool is not None)
                self.contact = self._try("contact", tables.contact, make)
        elif tables.system.s is None:
            remedy = "add it, or a table [body] for a structure that is held"
            self._problems.append(CaseError(file, "system.s", None, "missing", remedy))
        elif not _says_its_damping(tables.system):
            remedy = 'add it, or a law of damping: damping = {kind = "ratio", value = 0.001}'
            self._problems.append(CaseError(file, "system.d", None, "missing", remedy))
        else:
            self.body = self._try("system", tables.system, plain_body)
            make = partial(plain_contact, tool=tables.tool is not None)
            self.contact = self._try("system", tables.system, make)
        if isinstance(tables.load, ValveForce | ValveLoad):
            self.valve = self._try("load", tables.load, valve_of)
        elif tables.load is not None and not isinstance(tables.load, HistoryForce):
            self.load = self._try("load", tables.load, load_of)
        self._check_fit(tables)
        self._look_at_blow(tables)
        if tables.start is not None:
            self._try("start", tables.start, checked_start)
        if tables.simulation is not None:
            self._try("simulation", tables.simulation, checked_simulation)
        if self._problems:
            raise_all(self._problems)

    def _structure(self, tables: PhysicalCase | PlainCase, folder: Path) -> None:
        """The structure of the table [body], and its contact, which keeps the strain."""
        unfit = check_beside(tables)
        if unfit is not None:
            name, key, accepted = unfit
            held = getattr(getattr(tables, name), key) if key else None
            self._problems.append(CaseError(self._file, f"{name}.{key}" if key else name, held, f"expected {accepted}"))
            return
        if isinstance(tables, PhysicalCase):
            self.bar = self._try("body", tables.body, lambda table: sized_structure(table, tables, folder))
            if tables.contact is not None:
                make = partial(contact_of, bar=self.bar, tool=False)
                self.contact = self._try("contact", tables.contact, make)
        else:
            self.body = self._try("body", tables.body, lambda table: held_body(table, tables, folder))
            self.contact = self._try("system", tables.system, partial(plain_contact, tool=False))

    def _look_at_blow(self, tables: PhysicalCase | PlainCase) -> None:
        """What the bar strikes, and the blow that is asked for."""
        striker = self.bar or self.body
        if striker is None or tables.body is not None:
            return
        if isinstance(striker, SizedBody):
            assert isinstance(tables, PhysicalCase)
            self._target_in_si(tables, striker)
        else:
            self.target = self._try("tool", tables.tool, lambda table: plain_target(table, striker))
        if self.target is not None:
            self.blow = self._try("blow", tables.blow, lambda table: blow_question(table, striker, self.target))

    def _target_in_si(self, tables: PhysicalCase, bar: SizedBody) -> None:
        before = len(self._problems)
        rock = None if tables.rock is None else self._try("rock", tables.rock, rock_of)
        if tables.rock is not None and tables.tool is None:
            accepted = "expected a table [tool] beside it: what the bar strikes, with the rock at its end"
            self._problems.append(CaseError(self._file, "rock", None, accepted, NO_BIT))
        if len(self._problems) == before:
            make = partial(sized_target, rock=rock, contact=tables.contact, bar=bar)
            self.target = self._try("tool", tables.tool, make)

    def _check_fit(self, tables: PhysicalCase | PlainCase) -> None:
        """Whether the body takes the law of the contact, and the load at its place."""
        body = self.body
        if self.bar is not None:  # the load, and so the time that counts as 1, may be unknown yet
            body = _some_body(self.bar)
        if body is None:
            return
        if (law := self._law(tables)) is not None:
            self._try(*_contact_table(tables), lambda table: check_body(table, law, body))
        if (self.load, self.valve) != (None, None) or isinstance(tables.load, HistoryForce):
            self._try("load", tables.load, lambda table: body.place(table.at))

    def _law(self, tables: PhysicalCase | PlainCase) -> type[Contact] | None:
        """The kind of the contact, whatever its restitution is; None for a case of one blow without a contact."""
        if isinstance(tables, PlainCase):
            return plain_law(tables.system)
        return None if tables.contact is None else si_law(tables.contact, self.bar)

    def contact_of_blow(self, tables: PhysicalCase | PlainCase) -> Contact:
        """The contact whose restitution is that of the blow, which is resolved by waves.

        Raises
        ------
        CaseError
            When the blow gives none.
        """
        law, question = self._law(tables), self.blow
        assert law is not None and question is not None
        name, table = _contact_table(tables)
        found: Contact | None = self._try(name, table, lambda _: law(restitution_of(question)))
        if found is None:
            raise_all(self._problems)
        return found

    def timed(self, tables: PhysicalCase | PlainCase, system: System) -> Timed | None:
        """The law of a blow that takes time, where the case names one.

        Raises
        ------
        CaseError
            When the blow gives none.
        """
        question = self.blow
        assert question is not None
        name, table = _contact_table(tables)
        found: Timed | None = self._try(name, table, lambda own: timed_law(own, question, system))
        if self._problems:
            raise_all(self._problems)
        return found

    def _try(self, name: str, table: BaseModel | None, make: Any) -> Any:
        try:
            return make(table)
        except ParameterError as error:
            given = {} if table is None else table.model_dump(by_alias=True)
            self._problems.append(from_parameter(error, self._file, name, given))
        except ArithmeticError:
            self._problems.append(extreme(self._file, name))
        return None


def _contact_table(tables: PhysicalCase | PlainCase) -> tuple[str, BaseModel | None]:
    """The table that says how the bar leaves what it strikes, and its name."""
    return ("system", tables.system) if isinstance(tables, PlainCase) else ("contact", tables.contact)


def _says_its_damping(table: SystemTable) -> bool:
    """Whether the damping is given, or the bar is stepped: then it has none unless it is given."""
    return (table.d, table.damping, table.impedances, table.transit_times) != (None, None, None, None)


def _some_body(bar: SizedBody) -> Body | None:
    """The body under a load that takes as long as a wave from end to end; None when that is out of scale."""
    try:
        return bar.body(1.0 / bar.transit_time)
    except (ParameterError, ArithmeticError):
        return None


def recording_of(tables: PhysicalCase | PlainCase, file: str, folder: Path) -> ReadHistory | None:
    """The load of the recording that a case names, or None when its load is a formula.

    Raises
    ------
    CaseError
        When the recording cannot be read or used.
    """
    return history_load(tables.load, file, folder) if isinstance(tables.load, HistoryForce) else None


def check_motion(tables: PhysicalCase | PlainCase, file: str) -> None:
    """Refuse a case that describes one blow and no load or contact, when a motion is asked for.

    Raises
    ------
    CaseError
        With the tables that are missing, and the command that works without them.
    """
    missing = [name for name in ("load", "contact") if getattr(tables, name, ...) is None]
    if missing:
        raise_all([without_blow(file, name) for name in missing])


def system_of(tables: PhysicalCase | PlainCase, parts: Parts, load: Load, file: str) -> System:
    """The system of a case.

    Raises
    ------
    CaseError
        When the load does not fit the case.
    """
    contact = parts.contact or parts.contact_of_blow(tables)
    try:
        if parts.bar is None:
            assert parts.body is not None
            system = System(parts.body, load, contact)
        else:
            system = System.from_si(parts.bar, load, contact)
    except ParameterError as error:
        if error.name in _MEANING:
            raise _out_of_scale(error, tables, file) from None
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise extreme(file, "") from None
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


def extreme(file: str, key: str) -> CaseError:
    """The problem of a case whose numbers cannot be computed with."""
    return CaseError(file, key, None, "sizes so large or small that numbers overflow", "check the units")
