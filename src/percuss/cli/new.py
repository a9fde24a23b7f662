"""``percuss new``: a commented sample case to start from."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from percuss.cli.arguments import Parser
from percuss.errors import PercussError
from percuss.whole_file import write_whole

_DESCRIPTION = """\
Print the commented case of a machine or a structure of the catalogue, or write it to a file, together with the
history or the table of modes that the case names, if any."""

_EXAMPLES = """\
  percuss new hydraulic-drifter -o drifter.toml
  percuss new pile-hammer
  percuss new stopped-beam -o beam.toml"""


def run(arguments: Sequence[str]) -> int:
    """Print or write a sample case; returns the exit code."""
    parser = Parser("new", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("machine", metavar="MACHINE", help="a name that 'percuss machines' lists")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=lambda name: None if name == "-" else name,
        help="write the case to FILE, and what it names beside it ('-': print it, as without -o)",
    )
    parser.add_argument("--force", action="store_true", help="overwrite existing files")
    options = parser.parsed(arguments)

    from percuss.case.catalogue.sample_cases import file_beside, machine_text

    text, beside = machine_text(options.machine), file_beside(options.machine)
    if options.output is None:
        print(text, end="")
        if beside is not None:
            note = f"note: the case names {beside}; 'percuss new {options.machine} -o FILE' writes it as well"
            print(note, file=sys.stderr)
        return 0
    case = Path(options.output)
    files = [case] if beside is None else [case, case.with_name(beside)]
    _check(parser, files, options.force)
    _write(files, text, options.machine)
    print(f"wrote {' and '.join(str(file) for file in files)}; next: percuss {_command(options.machine)} {case}")
    return 0


def _command(name: str) -> str:
    """The command that answers for a machine of the catalogue."""
    from percuss.case.catalogue.sample_cases import MACHINES

    return "machine" if any(machine.valve for machine in MACHINES if machine.name == name) else "steady"


def _check(parser: Parser, files: list[Path], force: bool) -> None:
    """Refuse before anything is written."""
    folder = files[0].parent
    if not folder.is_dir():
        parser.error(f"argument -o: '{files[0]}': there is no folder '{folder}'")
    if len(files) == 2 and files[0].name == files[1].name:
        parser.error(f"argument -o: '{files[0]}' is a file that the case names; give the case another name")
    for file in files:
        if file.is_dir():
            parser.error(f"argument -o: '{file}' is a directory; name a file")
        if os.path.lexists(file) and not force:  # also a link to nothing: what it names is not ours to make
            parser.error(f"'{file}' exists; give another name, or use --force to overwrite it")


def _write(files: list[Path], text: str, name: str) -> None:
    """Write what the case names first, so that it never stands without it; leave nothing behind on failure."""
    new = [file for file in files if not os.path.lexists(file)]
    try:
        if len(files) == 2:
            from percuss.case.catalogue.sample_cases import write_beside

            write_beside(name, files[1])
        write_whole(files[0], text)
    except PercussError:
        for file in new:
            with suppress(OSError):
                file.unlink()
        raise
