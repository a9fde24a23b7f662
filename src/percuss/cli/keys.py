"""``percuss keys``: the tables of a case file and what may stand in them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.arguments import Parser

if TYPE_CHECKING:
    from percuss.case.file_format.key_tables import KeyRow

_DESCRIPTION = """\
The tables of a case file, or the keys of one: their values, what holds when they are left out, what they mean."""

_EXAMPLES = """\
  percuss keys
  percuss keys tool
  percuss keys load.valve"""

_WIDTH = 100


def run(arguments: Sequence[str]) -> int:
    """Print the tables, or the keys of one; returns the exit code."""
    parser = Parser("keys", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("table", metavar="TABLE", nargs="?", help="its name, as 'percuss keys' lists it")
    options = parser.parsed(arguments)

    from percuss.case.file_format.key_tables import TABLES, rows_of, table_class

    if options.table is None:
        for name in TABLES:
            about = (table_class(name).__doc__ or "").partition("\n")[0]
            print(f"{name:<21}{about}")
        return 0
    print("\n\n".join(map(_told, rows_of(table_class(options.table)))))
    return 0


def _told(row: KeyRow) -> str:
    value, without, meaning = (re.sub(r"[`*$]", "", text) for text in row[1:])
    needed = "needed" if without == "needed" else f"when left out: {without}" if without else ""
    lines = [f"{row.key} = {value}", *filter(None, [needed]), f"{meaning}."]
    return "\n".join(
        textwrap.fill(line, _WIDTH, initial_indent="    " * (i > 0), subsequent_indent="    ")
        for i, line in enumerate(lines)
    )
