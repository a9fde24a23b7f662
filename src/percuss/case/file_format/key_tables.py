"""What the tables of a case file may hold, read from their classes: for the documentation and for ``percuss keys``.

The text below each key of a class is its meaning, what is allowed, and what holds when it is left out.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from percuss.case.file_format import bodies, contact, loads, oil, start_and_simulation, steel
from percuss.case.file_format.plain_form import plain_form
from percuss.case.file_format.values import CaseTable, Kind, hints_of
from percuss.errors import ParameterError

_LOADS: dict[str, type[CaseTable]] = {
    f"load.{get_args(load.model_fields['kind'].annotation)[0]}": load
    for load in (
        loads.HarmonicLoad,
        loads.SquareLoad,
        loads.StepsLoad,
        loads.FourierLoad,
        loads.HistoryLoad,
        loads.ValveLoad,
    )
}
_STRUCK: dict[str, type[CaseTable]] = {"tool": contact.ToolTable, "blow": contact.BlowTable}

TABLES: dict[str, type[CaseTable]] = {
    "bar": bodies.BarTable,
    "bar.sections": bodies.SectionTable,
    "damping": bodies.DampingTable,
    "body": bodies.BodyTable,
    "contact": contact.ContactTable,
    **_LOADS,
    "load.ports": loads.PortTable,
    "load.chamber": loads.ChamberTable,
    "load.states": loads.AreasTable,
    "load.cushion": loads.CushionTable,
    "load.supply": oil.SupplyTable,
    "load.supply.accumulator": oil.GasAccumulatorTable,
    "load.supply.relief": oil.ReliefTable,
    "load.supply.leakage": oil.FlowAtTable,
    "load.chambers": oil.OilChamberTable,
    "load.orifices": oil.OrificeTable,
    "load.orifices.in": oil.PassageTable,
    "load.passage": oil.WaysTable,
    "load.oil": oil.OilTable,
    **_STRUCK,
    "tool.sections": contact.ToolSectionTable,
    "tool.joints": contact.JointTable,
    "feed": contact.FeedTable,
    "rock": contact.RockTable,
    "drilling": contact.DrillingTable,
    "steel": steel.SteelTable,
    "steel.tool": steel.ToolSteelTable,
    "start": start_and_simulation.StartTable,
    "simulation": start_and_simulation.SimulationTable,
    "system": bodies.SystemTable,
    **{f"plain.{name}": plain_form(table) for name, table in (_STRUCK | _LOADS).items()},
}
"""The tables by their place in a case file; those of dimensionless cases that differ begin with ``plain``."""


def table_class(name: str) -> type[CaseTable]:
    """The class of a table by its own name, or by one of `TABLES`."""
    by_class = {table.__name__: table for table in TABLES.values()}
    found = TABLES.get(name.strip("[]")) or by_class.get(name)
    if found is None:
        raise ParameterError("table", name, f"one of {', '.join(TABLES)}")
    return found


class KeyRow(NamedTuple):
    """A key: its values, what holds without it, and its meaning, in Markdown."""

    key: str
    value: str
    without: str
    meaning: str


def rows_of(table: type[CaseTable]) -> list[KeyRow]:
    """The keys that a table declares itself."""
    return [_row(table, key) for key in table.__annotations__ if key in table.model_fields]


def _row(table: type[CaseTable], key: str) -> KeyRow:
    said, field = said_of(table, key), table.model_fields[key]
    value = _words(hints_of(table)[key]) + (f", {said['allowed']}" if "allowed" in said else "")
    default = "" if field.default is None else f"`{field.default}`"
    without = "**needed**" if field.is_required() else said.get("left out") or default
    return KeyRow(field.alias or key, value, without, said["meaning"])


def said_of(table: type[CaseTable], key: str) -> dict[str, str]:
    """What the schema says below a key: ``meaning``, ``allowed``, ``left out``; else that of its SI form or base."""
    own = [one for one in table.mro() if issubclass(one, CaseTable)]
    said = _said_in(table.__module__)
    names = [one.__name__ for one in own]
    declared = next(name for name in names if any(name == there for there, _ in said))
    before = list(dict.fromkeys(there for there, _ in said))
    places = [*names, *before[: before.index(declared)][::-1]]
    here = table.in_plain.get(key) if table.is_plain else None
    text = here or next((said[place, key] for place in places if (place, key) in said), None)
    if text is None:
        raise LookupError(f"{table.__module__} says nothing below {table.__name__}.{key}")
    meaning, *rest = re.split(r" (?=Allowed: |When left out: )", text)
    found = {"meaning": meaning.rstrip(".")}
    for part in rest:
        name, _, what = part.partition(": ")
        found[name.lower().removeprefix("when ")] = what.rstrip(".")
    return found


@cache
def _said_in(module: str) -> dict[tuple[str, str], str]:
    found = {}
    for thing in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(thing, ast.ClassDef):
            for one, below in zip(thing.body, thing.body[1:], strict=False):
                if isinstance(one, ast.AnnAssign) and isinstance(below, ast.Expr) and isinstance(one.target, ast.Name):
                    text = getattr(below.value, "value", None)
                    if isinstance(text, str):
                        found[thing.name, one.target.id] = " ".join(text.split())
    return found


_WORDS = {float: "number", int: "whole number", bool: "true or false", str: "text"}


def _words(hint: Any) -> str:
    if isinstance(hint, type):
        return "table" if issubclass(hint, CaseTable) else _WORDS[hint]
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return " or ".join(_words(part) for part in parts if part is not type(None))
    if origin is Literal:
        return " or ".join(f'`"{word}"`' for word in parts)
    if origin is Annotated:
        kind = next((part for part in parts if isinstance(part, Kind)), None)
        if kind is not None:
            return kind.words
        infos = [part for info in parts[1:] for part in getattr(info, "metadata", ())]
        least = next((f", {part.ge} or greater" for part in infos if hasattr(part, "ge")), "")
        return f"{_words(parts[0])}{least}"
    raise LookupError(f"no words for the values of {hint}")
