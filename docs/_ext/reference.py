"""The generated part of the reference: a comment ``<!-- percuss: … -->`` in a page becomes a table or a list.

``commands``
    Every command with its arguments, from the parsers of the command line.
``keys TABLE``
    The keys of a table of the case file, from its class in `percuss.case.file_format` and the texts below its fields.
``units``
    The units that are known at once, from `percuss.units`.
"""

from __future__ import annotations

import argparse
import re
import sys
import types
import typing
from typing import Any, Literal
from unittest import mock

from pydantic.fields import FieldInfo
from sphinx.pycode import ModuleAnalyzer

from percuss.case.file_format import (
    damping_table,
    load_tables,
    schema,
    section_tables,
    tool_tables,
    values,
    valve_tables,
)
from percuss.cli.app import COMMANDS
from percuss.cli.app import run as run_command
from percuss.cli.parser import Parser
from percuss.units import _TABLE as UNITS

__all__ = ["commands", "expanded", "keys", "parser_of", "said_of", "setup", "units"]

_MARK = re.compile(r"^<!-- percuss: (\w+)(?: (\w+))? -->$", re.MULTILINE)


def expanded(text: str) -> str:
    """A page with everything generated in its place."""
    makers = {"commands": commands, "keys": keys, "units": units}
    return _MARK.sub(lambda mark: makers[mark[1]](*filter(None, [mark[2]])), text)


def _escaped(text: str) -> str:
    """Plain text as Markdown, options and what stands in quotes as code."""
    parts = re.split(r"(?<![\w=:'-])(--?[a-z][a-z-]*|(?:\w+=)?'[^']+')", text)
    parts[::2] = [re.sub(r"([\\`*_$<\[|{#])", r"\\\1", part) for part in parts[::2]]
    parts[1::2] = ["`" + re.sub(r"^'(.*)'$", r"\1", code) + "`" for code in parts[1::2]]
    return "".join(parts)


# -- commands ----------------------------------------------------------------------------------------------------------


class _Found(Exception):
    """Carries the parser out of a command that was about to use it."""


def parser_of(command: str) -> Parser:
    """The parser of a command, which each command makes when it runs."""

    def caught(self: Parser, arguments: object) -> typing.NoReturn:
        raise _Found(self)

    with mock.patch.object(Parser, "parsed", caught):
        try:
            run_command([command])
        except _Found as found:
            parser: Parser = found.args[0]
            return parser
    raise LookupError(f"'percuss {command}' does not parse its arguments by percuss.cli.parser.Parser")


def commands() -> str:
    """A section for every command."""
    return "\n\n".join(_command(name) for name in COMMANDS)


def _command(name: str) -> str:
    parser = parser_of(name)
    parts = [f"## `percuss {name}`", f"*{_escaped(COMMANDS[name])}*"]
    parts += [_paragraph(text) for text in re.split(r"\n\n|\n(?=\w+: )", parser.description or "")]
    with mock.patch.dict("os.environ", {"COLUMNS": "86"}):
        usage = parser.format_usage().removeprefix("usage: ")
    indented = re.sub(r"\n {7}", "\n", usage).rstrip()
    parts.append(f"```text\n{indented}\n```")
    parts += [_argument(parser, action) for action in parser._actions if action.dest != "help"]
    title, _, lines = (parser.epilog or "").partition("\n")
    examples = "\n".join(f"$ {line.strip()}" for line in lines.splitlines())
    parts.append(f"{title.capitalize()}\n\n```console\n{examples}\n```")
    return "\n\n".join(parts)


def _paragraph(text: str) -> str:
    """Running text; what is laid out in columns stays so."""
    return f"```text\n{text}\n```" if text.startswith("  ") else _escaped(text)


def _argument(parser: Parser, action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else f" {action.metavar}"
    forms = [f"`{option}{value}`" for option in action.option_strings] or [f"`{action.metavar}`"]
    text = parser._get_formatter()._expand_help(action)
    needed = " (needed)" if action.required and action.option_strings else ""
    return f"{', '.join(forms)}\n: {_escaped(text)}{needed}"


# -- the case file -----------------------------------------------------------------------------------------------------

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
    said = ModuleAnalyzer.for_module(table.__module__).find_attr_docs()
    classes = [name for name, thing in vars(sys.modules[table.__module__]).items() if isinstance(thing, type)]
    name = table.__name__
    places = [name, name.replace("Load", "Force"), *classes[classes.index(name) :: -1]]
    text = next((" ".join(said[place, key]).strip() for place in places if (place, key) in said), None)
    if text is None:
        raise LookupError(f"{table.__module__} says nothing below {table.__name__}.{key}")
    meaning, *rest = re.split(r" (?=Allowed: |When left out: )", text)
    found = {"meaning": meaning.rstrip(".")}
    for part in rest:
        name, _, what = part.partition(": ")
        found[name.lower().removeprefix("when ")] = what.rstrip(".")
    return found


def keys(table_name: str) -> str:
    """The keys that a table declares itself, as a table with their values, what holds without them, and the meaning."""
    table = next(getattr(module, table_name) for module in (schema, load_tables) if hasattr(module, table_name))
    hints = typing.get_type_hints(table, include_extras=True)
    rows = [_row(table, key, hints[key], table.model_fields[key]) for key in table.__annotations__]
    return "\n".join(["| key | value | when left out | meaning |", "|---|---|---|---|", *rows])


def _row(table: type[values.Table], key: str, hint: Any, field: FieldInfo) -> str:
    said = said_of(table, key)
    value = _value(hint)
    if "allowed" in said:
        value += f", {said['allowed']}"
    if field.is_required():
        without = "**needed**"
    else:
        without = said.get("left out") or (f"`{field.default}`" if field.default is not None else "")
    return f"| `{field.alias or key}` | {value} | {without} | {said['meaning']} |"


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


def units() -> str:
    """The dimensions and the units that the closed table has."""
    rows = [
        f"| {name} | {', '.join(f'`{unit}`' for unit in known if unit)} | `{example.split(' or ')[0]}` |"
        for name, (_, _, example, known) in UNITS.items()
        if name != "dimensionless"
    ]
    return "\n".join(["| dimension | units | for example |", "|---|---|---|", *rows])


# -- Sphinx ------------------------------------------------------------------------------------------------------------


def setup(app: Any) -> dict[str, bool]:
    """Expand pages as they are read, and read those that are generated every time."""
    generated: set[str] = set()

    def read(_app: Any, name: str, source: list[str]) -> None:
        made = expanded(source[0])
        if made != source[0]:
            generated.add(name)
        source[0] = made

    app.connect("source-read", read)
    app.connect("env-get-outdated", lambda *_: ["case-file", "commands"])
    return {"parallel_read_safe": True}
