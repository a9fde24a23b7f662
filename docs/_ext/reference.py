"""The generated part of the reference: a comment ``<!-- percuss: … -->`` in a page becomes a table or a list.

``commands``
    Every command with its arguments, from the parsers of the command line.
``keys TABLE``
    The keys of a table of the case file, from its class in `percuss.case.file_format` and the texts below its fields.
``facts TABLE``
    The keys of a part of an answer in JSON, from the figures that `percuss.case.answers` declares.
``units``
    The units that are known at once, from `percuss.units`.
"""

from __future__ import annotations

import argparse
import re
from typing import Any
from unittest import mock

from percuss.case.answers.blows.blow_answer import GAUGE, MEASURED, PULSE, ROCK, ROD, STRIKER
from percuss.case.answers.blows.drilling_answer import BLOW, DRILLING, HELD, STATIC
from percuss.case.answers.blows.repeated_answer import IN_TRAIN, REPEATED
from percuss.case.answers.blows.transfer import FATIGUE, SECTION, STEEL, TRANSFER
from percuss.case.answers.blows.valve_waves_answer import VALVE_WAVES
from percuss.case.answers.blows.waves_answer import IMPACT, SETTLED
from percuss.case.answers.facts import Fact, reference_of
from percuss.case.answers.machine_answer import MARGINS, PRESSURE, STABILITY
from percuss.case.answers.machine_figures import BLANK, CYCLE, OIL, POWER
from percuss.case.answers.simulation_answer import EVENT
from percuss.case.answers.steady_answer import (
    DRAG,
    END,
    ENERGY,
    MULTIPLIERS,
    PERIOD,
    REDUCED,
    REST,
    TIMED,
    TIMED_PERIOD,
    WAVEFORM,
)
from percuss.case.answers.steady_answer import ORBIT as STEADY
from percuss.case.answers.whole_hammer import UNCERTAIN
from percuss.case.file_format.key_tables import rows_of, said_of, table_class
from percuss.cli.app import COMMANDS, command_of
from percuss.cli.arguments import Parser
from percuss.steady.figures import REPORTED
from percuss.units import _TABLE as UNITS

__all__ = ["commands", "expanded", "facts", "keys", "parser_of", "said_of", "setup", "units"]

_MARK = re.compile(r"^<!-- percuss: (\w+)(?: (\w+))? -->$", re.MULTILINE)


def expanded(text: str) -> str:
    """A page with everything generated in its place."""
    makers = {"commands": commands, "facts": facts, "keys": keys, "units": units}
    return _MARK.sub(lambda mark: makers[mark[1]](*filter(None, [mark[2]])), text)


ORBIT = [Fact(key, "", one.figure.meaning, "", lambda _: None) for key, one in REPORTED.items()]
"""The figures of a steady motion with their units."""

FACTS = {
    "machine": (*CYCLE, *POWER),
    "oil": OIL,
    "blank": BLANK,
    "settled": SETTLED,
    "impact": IMPACT,
    "ends": END,
    "event": EVENT,
    "blow": (*STRIKER, *ROD, *ROCK, *HELD, *DRILLING),
    "static": STATIC,
    "perblow": BLOW,
    "pulse": PULSE,
    "valvewaves": VALVE_WAVES,
    "repeated": REPEATED,
    "intrain": IN_TRAIN,
    "gauge": GAUGE,
    "measured": MEASURED,
    "fatigue": FATIGUE,
    "steel": STEEL,
    "fatiguesection": SECTION,
    "period": PERIOD,
    "rest": REST,
    "motion": STEADY,
    "reduced": REDUCED,
    "multipliers": MULTIPLIERS,
    "waveform": WAVEFORM,
    "energy": ENERGY,
    "drag": DRAG,
    "timed": TIMED,
    "timedperiod": TIMED_PERIOD,
    "margins": (*STABILITY, *MARGINS),
    "pressure": PRESSURE,
    "orbit": ORBIT,
    "transfer": TRANSFER,
    "uncertain": UNCERTAIN,
}


def facts(table: str) -> str:
    """The figures of a part of an answer without units; with them if the name ends in ``_si``, both in ``_all``."""
    name, _, which = table.partition("_")
    return reference_of(FACTS[name], {"": False, "si": True, "all": None}[which])


def _escaped(text: str) -> str:
    """Plain text as Markdown, options and what stands in quotes as code."""
    parts = re.split(r"(?<![\w=:'-])(--?[a-z][a-z-]*|(?:\w+=)?'[^']+')", text)
    parts[::2] = [re.sub(r"([\\`*_$<\[|{#])", r"\\\1", part) for part in parts[::2]]
    parts[1::2] = ["`" + re.sub(r"^'(.*)'$", r"\1", code) + "`" for code in parts[1::2]]
    return "".join(parts)


# -- commands ----------------------------------------------------------------------------------------------------------


def parser_of(command: str) -> Parser:
    """The parser of a command."""
    return command_of(command).parser()


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


def keys(table_name: str) -> str:
    """The keys that a table declares itself, as a table with their values, what holds without them, and the meaning."""
    rows = [
        f"| `{row.key}` | {row.value} | {row.without} | {row.meaning} |" for row in rows_of(table_class(table_name))
    ]
    return "\n".join(["| key | value | when left out | meaning |", "|---|---|---|---|", *rows])


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
