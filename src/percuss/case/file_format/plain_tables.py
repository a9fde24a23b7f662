"""Cases from tables that do not come from a file, and back: what programs and pages exchange."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from percuss.case.case import Case
from percuss.case.file_format.bodies import damping_table, modes_in
from percuss.case.file_format.loads import HistoryLoad
from percuss.case.file_format.reading import case_form, checked_tables
from percuss.case.file_format.schema import PhysicalCase, missing_tables
from percuss.errors import CaseError
from percuss.model import External, Kept, SteppedBar

if TYPE_CHECKING:
    from percuss.case.file_format.plain_form import PlainCase
    from percuss.model import Load, Machine, System

MAX_HARMONICS = 1024
"""The highest harmonic of a case that is taken from tables, unless the caller knows better."""


def case_of(tables: Mapping[str, Any], file: str = "case", harmonics: int = MAX_HARMONICS) -> Case:
    """The case that tables describe, as JSON has them; keys without a value (null) are taken as not given."""
    given = _given(tables)
    load, body = given.get("load"), given.get("body")
    if isinstance(body, dict) and "file" in body:
        remedy = "give its columns: omega, damping, contact and drive"
        raise CaseError(file, "body.file", body["file"], "a case cannot name a table of modes here", remedy)
    if isinstance(load, dict):
        if load.get("kind") == "history":
            remedy = "give the case and its recording together, or the load that the recording gives"
            raise CaseError(file, "load.kind", "history", "a case cannot name a recording here", remedy)
        check_harmonics(load, file, harmonics)
    return Case(_checked(given, file), file)


def _given(table: Mapping[str, Any], deep: int = 2) -> dict[str, Any]:
    """The keys with a value; of a case, of its tables, and of those in them."""
    return {
        key: _given(value, deep - 1) if deep and isinstance(value, dict) else value
        for key, value in table.items()
        if value is not None
    }


def _checked(given: dict[str, Any], file: str) -> PhysicalCase | PlainCase:
    """The tables, checked; what is wrong is looked into only when something is, which takes longer than to be right."""
    form = case_form("system" in given)
    if not missing_tables(form, given) and {"bar", "body", "system"} & given.keys():
        with suppress(ValidationError):
            return form.model_validate(given)
    return checked_tables(given, file)


def check_harmonics(load: Mapping[str, Any], file: str, most: int) -> None:
    """Refuse a load with more harmonics than that, before arrays of their number are made."""
    pairs, breaks = load.get("coefficients"), load.get("breaks")
    number = len(pairs) - 1 if isinstance(pairs, list) else 0
    for key, value in (("harmonic", load.get("harmonic")), ("harmonics", load.get("harmonics"))):
        if isinstance(value, int) and value > most:
            raise CaseError(file, f"load.{key}", value, f"expected at most {most}")
    if number > most:
        raise CaseError(file, "load.coefficients", f"{number + 1} pairs", f"expected at most {most + 1} pairs")
    if isinstance(breaks, list) and len(breaks) > most:
        raise CaseError(file, "load.breaks", f"{len(breaks)} phases", f"expected at most {most} phases")


def json_tables(case: Case) -> dict[str, Any]:
    """The tables of a case as JSON has them; only those that were given."""
    return {name: _json_value(table) for name, table in case.to_dict().items()}


def _json_value(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _json_value(item) for key, item in value.items()}
    return [_json_value(item) for item in value] if isinstance(value, tuple | list) else value


def fourier_table(load: Load) -> dict[str, Any]:
    """The table [load] of a load by its harmonics: in N with a frequency, or in plain numbers."""
    table: dict[str, Any] = {
        "kind": "fourier",
        "coefficients": [[p.real, p.imag] for p in load.coefficients.tolist()],
        **({"at": load.at} if load.at else {}),
    }
    return table if load.frequency is None else {**table, "unit": "N", "frequency": f"{load.frequency!r} Hz"}


def system_table(hammer: System | Machine) -> dict[str, Any]:
    """The table [system] of a system or a machine."""
    body, law, contact = hammer.body, hammer.body.damping, hammer.contact
    table: dict[str, Any] = {"s": body.s, "restitution": contact.restitution}
    if isinstance(body, SteppedBar):
        table |= {"impedances": list(body.impedances), "transit_times": list(body.transit_times)}
    table |= {"d": law.rigid} if isinstance(law, External) else {"damping": damping_table(law)}
    return table if isinstance(contact, Kept) else {**table, "strain": contact.kind}


def without_files(case: Case) -> Case:
    """The same case with what its files hold in their place: a recording's harmonics, a table's columns."""
    load, body = case.tables.load, case.tables.body
    named = None if body is None else body.file
    if not isinstance(load, HistoryLoad) and named is None:
        return case
    tables = json_tables(case)
    if named is not None:
        case.system()  # which says by the key what is wrong with the file
        columns = {name: list(column) for name, column in modes_in(case.folder / named, named).items()}
        tables["body"] = {name: value for name, value in tables["body"].items() if name != "file"} | columns
    if isinstance(load, HistoryLoad):
        table = fourier_table(case.load())
        if load.is_plain:
            table = {key: table[key] for key in ("kind", "coefficients", "at") if key in table}
        tables["load"] = table
    return case_of(tables, case.file)
