"""The tables of a case file, checked: in SI units or dimensionless, whichever it is meant in."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from percuss.case.file_format.problems import from_validation, raise_all
from percuss.case.file_format.schema import PhysicalCase, PlainCase, missing_tables, table_fields
from percuss.case.file_format.suggest import did_you_mean
from percuss.errors import CaseError

__all__ = ["checked_tables"]


def checked_tables(data: dict[str, Any], file: str) -> PhysicalCase | PlainCase:
    """The tables of a parsed file.

    Raises
    ------
    CaseError
        When they are no case; with every problem of the file.
    """
    form = _form(data, file)
    missing, found = _missing(form, data), None
    try:
        tables = form.model_validate(data)
        if not missing:
            return tables
    except ValidationError as error:
        found = error
    load = data.get("load")
    kind = load.get("kind") if isinstance(load, dict) else None
    raise_all(from_validation(found, file, data, table_fields(form, kind), missing))


def _missing(form: type[PhysicalCase] | type[PlainCase], data: dict[str, Any]) -> list[str]:
    """The tables that the file lacks: [bar] where nothing else tells of what strikes."""
    near = any(did_you_mean(key, ["bar"]) for key in data if key not in form.model_fields)
    bar = form is PhysicalCase and not {"bar", "body"} & data.keys() and not near
    return [*(["bar"] if bar else []), *missing_tables(form, data)]


def _form(data: dict[str, Any], file: str) -> type[PhysicalCase] | type[PlainCase]:
    """Which of the two forms a file is meant in."""
    physical, plain = {"bar", "contact"} & data.keys(), "system" in data
    if physical and plain:
        names = " and ".join(f"[{name}]" for name in sorted(physical))
        remedy = f"keep [system] for plain numbers, or {names} for SI units"
        raise CaseError(
            file,
            "system",
            None,
            f"a case has either [system] or [bar] and [contact]; this one also has {names}",
            remedy,
        )
    near = {did_you_mean(key, ["bar", "contact", "system"]) for key in data}
    return PlainCase if plain or (not physical and "did you mean 'system'?" in near) else PhysicalCase
