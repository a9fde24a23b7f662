"""What the tables of a case file may hold, read from their classes: for the documentation and for ``percuss keys``.

The text below each key of a class is its meaning, what is allowed, and what holds when it is left out.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
import types
import typing
from functools import cache
from typing import Any, Literal, NamedTuple

from pydantic.fields import FieldInfo

from percuss.case.file_format import body_tables as damping_table
from percuss.case.file_format import body_tables as section_tables
from percuss.case.file_format import body_tables as tool_tables
from percuss.case.file_format import load_tables, schema, values
from percuss.case.file_format import load_tables as valve_tables
from percuss.errors import ParameterError

TABLES = {
    "bar": "BarTable",
    "bar.sections": "SectionTable",
    "damping": "DampingTable",
    "body": "BodyTable",
    "contact": "ContactTable",
    "load.harmonic": "HarmonicForce",
    "load.square": "SquareForce",
    "load.steps": "StepsForce",
    "load.fourier": "FourierForce",
    "load.history": "HistoryForce",
    "load.valve": "ValveForce",
    "load.ports": "PortTable",
    "load.chamber": "ChamberTable",
    "load.states": "AreasTable",
    "load.cushion": "CushionTable",
    "load.supply": "SupplyTable",
    "tool": "ToolTable",
    "tool.sections": "ToolSectionTable",
    "rock": "RockTable",
    "blow": "BlowTable",
    "start": "StartTable",
    "simulation": "SimulationTable",
    "system": "SystemTable",
    "plain.tool": "PlainTool",
    "plain.blow": "PlainBlow",
    "plain.load.harmonic": "HarmonicLoad",
    "plain.load.square": "SquareLoad",
    "plain.load.steps": "StepsLoad",
    "plain.load.fourier": "FourierLoad",
    "plain.load.history": "HistoryLoad",
    "plain.load.valve": "ValveLoad",
}
"""The tables by their place in a case file; those of dimensionless cases that differ begin with ``plain``."""

_VALUES: list[tuple[Any, str]] = [
    (values.Length, "length"),
    (values.Area, "area"),
    (values.Frequency, "frequency"),
    (values.Time, "time"),
    (values.Stress, "pressure"),
    (values.Density, "density"),
    (values.Drag, "damping"),
    (values.DampingValue, "number, text with a unit, or list of numbers"),
    (damping_table.BarDamping, "table"),
    (damping_table.SystemDamping, "table"),
    (section_tables.SectionTables, "list of tables"),
    (tool_tables.ToolSections, "list of tables"),
    (valve_tables.States, "table of forces or tables"),
    (valve_tables.PlainStates, "table of numbers"),
    (valve_tables.Ports, "list of tables"),
    (valve_tables.PlainPorts, "list of tables"),
    (valve_tables.ChamberTable, "table"),
    (valve_tables.CushionTable, "table"),
    (valve_tables.PlainCushion, "table"),
    (valve_tables.SupplyTable, "table"),
    (valve_tables.CushionTable, "table"),
    (valve_tables.PlainCushion, "table"),
    (valve_tables.PlainChamber, "table"),
    (valve_tables.PlainSupply, "table"),
    (valve_tables.Reads, '`"centre"` or number'),
    (values.Mass, "mass"),
    (values.NumberOrStiffness, "stiffness"),
    (values.NumberOrDashpot, "dashpot"),
    (values.Stiffness, "stiffness"),
    (values.Flow, "flow"),
    (values.Compliance, "compliance"),
    (values.Restitution, 'number or `"from the blow"`'),
    (values.Velocities, "velocity, or list of velocities"),
    (values.PlainVelocities, "number, or list of numbers"),
    (values.Steps, "list of pairs `[time, force]`"),
    (values.PlainSteps, "list of pairs of numbers"),
    (values.Force, "force"),
    (values.ForceOrPressure, "force or pressure"),
    (values.ForceUnit, "unit of force or pressure"),
    (values.Coefficients, "list of pairs `[re, im]`"),
    (values.Column, "name or number"),
    (values.PlainNumber, "number"),
    (values.Numbers, "list of numbers"),
    (values.NumberOrLength, "number or length"),
    (values.NumberOrVelocity, "number or velocity"),
    (values.NumberOrTime, "number or time"),
    (float, "number"),
    (int, "whole number"),
    (bool, "true or false"),
    (str, "text"),
]


def said_of(table: type[values.Table], key: str) -> dict[str, str]:
    """What the schema says below a key: its ``meaning``, and if it does so ``allowed`` and ``left out``.

    A key without a text has that of the SI form of its load, or of the nearest class before its own with such a key.
    """
    said = _said_in(table.__module__)
    classes = [name for name, thing in vars(sys.modules[table.__module__]).items() if isinstance(thing, type)]
    name = table.__name__
    places = [name, name.replace("Load", "Force"), *classes[classes.index(name) :: -1]]
    text = next((said[place, key] for place in places if (place, key) in said), None)
    if text is None:
        raise LookupError(f"{table.__module__} says nothing below {table.__name__}.{key}")
    meaning, *rest = re.split(r" (?=Allowed: |When left out: )", text)
    found = {"meaning": meaning.rstrip(".")}
    for part in rest:
        name, _, what = part.partition(": ")
        found[name.lower().removeprefix("when ")] = what.rstrip(".")
    return found


class KeyRow(NamedTuple):
    """A key: its values, what holds without it, and its meaning, in Markdown."""

    key: str
    value: str
    without: str
    meaning: str


@cache
def _said_in(module: str) -> dict[tuple[str, str], str]:
    """The texts below the keys of the classes of a module."""
    found = {}
    for thing in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(thing, ast.ClassDef):
            for one, below in zip(thing.body, thing.body[1:], strict=False):
                if isinstance(one, ast.AnnAssign) and isinstance(below, ast.Expr) and isinstance(one.target, ast.Name):
                    text = getattr(below.value, "value", None)
                    if isinstance(text, str):
                        found[thing.name, one.target.id] = " ".join(text.split())
    return found


def table_class(name: str) -> type[values.Table]:
    """The class of a table by its own name, or by one of `TABLES`.

    Raises
    ------
    ParameterError
        When there is none.
    """
    class_name = TABLES.get(name.strip("[]"), name)
    for module in (schema, load_tables):
        found = getattr(module, class_name, None)
        if isinstance(found, type) and issubclass(found, values.Table):
            return found
    raise ParameterError("table", name, f"one of {', '.join(TABLES)}")


def rows_of(table: type[values.Table]) -> list[KeyRow]:
    """The keys that a table declares itself."""
    hints = typing.get_type_hints(table, include_extras=True)
    return [_row(table, key, hints[key], table.model_fields[key]) for key in table.__annotations__]


def _row(table: type[values.Table], key: str, hint: Any, field: FieldInfo) -> KeyRow:
    said = said_of(table, key)
    value = _value(hint)
    if "allowed" in said:
        value += f", {said['allowed']}"
    if field.is_required():
        without = "**needed**"
    else:
        without = said.get("left out") or (f"`{field.default}`" if field.default is not None else "")
    return KeyRow(field.alias or key, value, without, said["meaning"])


def _value(hint: Any) -> str:
    """The kind of value in words."""
    for known, words in _VALUES:
        if hint == known:
            return words
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        return " or ".join(_value(part) for part in typing.get_args(hint) if part is not type(None))
    if typing.get_origin(hint) is Literal:
        return " or ".join(f'`"{word}"`' for word in typing.get_args(hint))
    if typing.get_origin(hint) is typing.Annotated:
        kind, *limits = typing.get_args(hint)
        least = next(part.ge for info in limits for part in info.metadata if hasattr(part, "ge"))
        return f"{_value(kind)}, {least} or greater"
    raise LookupError(f"no words for the values of {hint}")
