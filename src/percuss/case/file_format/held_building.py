"""From the table [body] of a case to the structure that it describes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from percuss.case.file_format.body_building import plain_damping, sized_body
from percuss.case.file_format.body_table import BodyTable
from percuss.case.file_format.modes_file import COLUMNS, modes_in
from percuss.case.file_format.schema import PhysicalCase, PlainCase
from percuss.errors import ParameterError
from percuss.model import Bar, HeldBody, ModalBody, Mounted, SizedBody
from percuss.model.body import SizedModes, SizedMounted
from percuss.units import si

__all__ = ["check_beside", "held_body", "sized_structure"]

_OF_KIND = {"modes": ("file", *COLUMNS), "mounted": ("spring", "dashpot", "mass")}


def held_body(table: BodyTable, tables: PlainCase, folder: Path) -> HeldBody:
    """The structure of a dimensionless case.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    _check_keys(table)
    gap = _number(table, "gap", 0.0)
    if table.kind == "modes":
        with _by_the_case():
            return ModalBody(**_columns(table, folder), gap=gap)
    if table.mass is not None:
        raise ParameterError("mass", table.mass, "no mass: it is 1 in a dimensionless case")
    s = tables.system.s
    stiffness, dashpot = _needed(table, "spring"), _number(table, "dashpot", 0.0)
    with_s = {} if s is None else {"s": s, "damping": plain_damping(tables.system)}
    with _by_the_case():
        return Mounted(stiffness, dashpot, gap=gap, **with_s)  # type: ignore[arg-type]


def sized_structure(table: BodyTable, tables: PhysicalCase, folder: Path) -> SizedBody:
    """The structure of a case in SI.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    _check_keys(table)
    gap = 0.0 if table.gap is None else _si(table, "gap", "length")
    if table.kind == "modes":
        with _by_the_case():
            return SizedModes(**_columns(table, folder), gap=gap)
    spring = _si(table, "spring", "stiffness") if table.spring is not None else _needed(table, "spring")
    dashpot = 0.0 if table.dashpot is None else _si(table, "dashpot", "dashpot")
    bar = None
    if "bar" in tables.model_fields_set:
        found = sized_body(tables.bar)
        if not isinstance(found, Bar):
            raise ParameterError("kind", table.kind, "a bar of one section in [bar]")
        if table.mass is not None:
            raise ParameterError("mass", table.mass, "either a mass or a table [bar], not both")
        bar = found
    elif table.mass is None:
        raise ParameterError("mass", None, 'a mass with its unit, for example "5 kg", or a table [bar]')
    mass = 1.0 if table.mass is None else si(table.mass, "mass", "mass")
    with _by_the_case():
        return SizedMounted(spring, dashpot, bar, mass, gap)


def check_beside(tables: PhysicalCase | PlainCase) -> tuple[str, str, str] | None:
    """The table, key and words of what does not go with [body]; None for nothing."""
    table = tables.body
    assert table is not None
    for name in ("tool", "rock", "blow"):
        if getattr(tables, name, None) is not None:
            return name, "", "no such table beside [body]: its contact is with a rigid wall"
    struck = tables.system if isinstance(tables, PlainCase) else tables.contact
    if struck is not None and struck.law not in (None, "b77"):
        return "contact" if isinstance(tables, PhysicalCase) else "system", "law", 'only "b77" beside [body]'
    if struck is not None and struck.strain == "reversed":
        return "contact" if isinstance(tables, PhysicalCase) else "system", "strain", 'only "kept" beside [body]'
    if tables.load is not None and tables.load.kind == "valve":
        return "load", "kind", "a load that keeps time beside [body]"
    if tables.load is not None and tables.load.at:
        return "load", "at", "0 beside [body]: its table says where the load acts"
    if isinstance(tables, PlainCase):
        unfit = {"s", "d", "damping"} if table.kind == "modes" or tables.system.s is None else set()
        unfit |= {"impedances", "transit_times"}
        for name in sorted(unfit & tables.system.model_fields_set):
            return "system", name, "no such key beside this [body]"
    elif table.kind == "modes" and "bar" in tables.model_fields_set:
        return "bar", "", "no table [bar] beside a table of modes"
    return None


def _check_keys(table: BodyTable) -> None:
    for kind, names in _OF_KIND.items():
        for name in names:
            if kind != table.kind and getattr(table, name) is not None:
                raise ParameterError(name, getattr(table, name), f'nothing: it belongs to kind = "{kind}"')


def _columns(table: BodyTable, folder: Path) -> dict[str, Any]:
    """The columns by the names that the model has for them."""
    given = {name: getattr(table, name) for name in COLUMNS if getattr(table, name) is not None}
    if table.file is not None:
        if given:
            raise ParameterError("file", table.file, f"either a file or {', '.join(given)}, not both")
        given = modes_in(folder / table.file, table.file)
    for name in COLUMNS:
        if name not in given:
            raise ParameterError(name, None, 'a list of numbers, or file = "modes.csv" with all columns')
    return {"delta" if name == "damping" else name: values for name, values in given.items()}


@contextmanager
def _by_the_case() -> Iterator[None]:
    """A refusal of the model told in the words of the case."""
    try:
        yield
    except ParameterError as error:
        name, bracket, place = error.name.partition("[")
        key = {"delta": "damping", "stiffness": "spring", "rigid_mass": "mass"}.get(name, name)
        raise ParameterError(f"{key}{bracket}{place}", error.value, error.accepted, error.remedy) from None


def _number(table: BodyTable, name: str, default: float) -> float:
    value = getattr(table, name)
    if isinstance(value, str):
        raise ParameterError(name, value, "a plain number in a dimensionless case", "only a case in SI takes units")
    return default if value is None else float(value)


def _needed(table: BodyTable, name: str) -> float:
    if getattr(table, name) is None:
        raise ParameterError(name, None, f"the {name} of a body that is mounted")
    return _number(table, name, math.nan)


def _si(table: BodyTable, name: str, dimension: str) -> float:
    value = getattr(table, name)
    if not isinstance(value, str):
        raise ParameterError(name, value, f"text with a number and a unit of {dimension} in a case in SI")
    return si(value, dimension, name)
