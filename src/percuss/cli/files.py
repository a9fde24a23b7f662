"""The files that commands take and make: found, or refused before anything is computed."""

from __future__ import annotations

import os
import shlex
import sys
from typing import TYPE_CHECKING

from percuss.errors import CaseError, MissingExtraError

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.cli.parser import Parser

__all__ = [
    "PICTURES",
    "as_typed",
    "check_csv",
    "check_not_the_case",
    "check_picture",
    "check_table",
    "check_target",
    "named_case",
    "need",
    "tell_made",
]

PICTURES = (".png", ".svg", ".pdf")
"""What a picture can be saved as."""


def check_picture(parser: Parser, path: str) -> None:
    """Refuse what cannot be drawn before anything is computed."""
    if not path.lower().endswith(PICTURES):
        parser.error(f"argument --plot: '{path}': the name must end in {', '.join(PICTURES[:-1])} or {PICTURES[-1]}")
    check_target(parser, "--plot", path)
    need("matplotlib", "plot")


def check_table(parser: Parser, path: str) -> None:
    """Refuse what no table is written to, before anything is computed; other programs know one by its name."""
    if not path.lower().endswith(".csv"):
        printed = " ('--json' prints the values)" if path == "-" else ""
        parser.error(f"argument --csv: '{path}': give the name of a file that ends in .csv{printed}")
    check_target(parser, "--csv", path)
    need("xarray", "io")


def check_csv(parser: Parser, path: str, case: str) -> None:
    """Refuse an -o that is no table, no place for a file, or the case itself."""
    if not path.lower().endswith(".csv"):
        parser.error(f"argument -o: '{path}': the name must end in .csv")
    check_target(parser, "-o", path)
    check_not_the_case(parser, path, case)


def check_target(parser: Parser, option: str, path: str) -> None:
    """Refuse a place where no file can be written."""
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        parser.error(f"argument {option}: '{path}': there is no folder '{folder}'")
    if os.path.isdir(path) or not os.path.basename(path):
        parser.error(f"argument {option}: '{path}' is a directory")
    if os.path.exists(path) and not os.path.isfile(path):
        parser.error(f"argument {option}: '{path}' is not a regular file")
    place = os.path.dirname(os.path.realpath(path))  # a file is written beside its place, and then takes it
    if not os.access(place, os.W_OK) or (os.path.exists(path) and not os.access(path, os.W_OK)):
        parser.error(f"argument {option}: '{path}' cannot be written")


def check_not_the_case(parser: Parser, path: str, case: str) -> None:
    """Refuse to write over the case that is asked."""
    if os.path.exists(case) and os.path.exists(path) and os.path.samefile(case, path):
        parser.error(f"argument -o: '{path}' is the case itself")


def need(package: str, extra: str) -> None:
    """Refuse when an optional package is not installed.

    Raises
    ------
    MissingExtraError
        Which says how to install it.
    """
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise MissingExtraError(package, extra)


def tell_made(quietly: bool, **paths: str | None) -> None:
    """One line for every file that was made; `quietly`, when standard output holds JSON, among the messages."""
    for what, path in paths.items():
        if path is not None:
            print(f"{what}: {path}", file=sys.stderr if quietly else sys.stdout)


def named_case(name: str) -> Case:
    """The case in a file, or of a machine of the catalogue; a file goes first.

    Raises
    ------
    CaseError
        When there is neither, or the file is not a case.
    """
    from percuss.case import Case, load_case
    from percuss.case.catalogue.sample_cases import is_sample, sample_names
    from percuss.case.file_format.suggest import did_you_mean

    if is_sample(name) and not os.path.isfile(name):
        return load_case(name)
    if name != "-" and not os.path.exists(name):
        near = [entry for entry in _entries(os.path.dirname(name)) if entry.endswith(".toml")]
        remedy = did_you_mean(name, [*near, *sample_names()])
        what = "no such file" if name.endswith(".toml") else "no such file, and no machine of this name"
        raise CaseError(name, "", None, what, remedy or "'percuss machines' lists the machines")
    return Case.read(name)


def as_typed(name: str) -> str:
    """The name of a case as it is to be typed again: '-' for standard input, quoted where a shell needs it."""
    return "-" if name == "<stdin>" else shlex.quote(name)


def _entries(folder: str) -> list[str]:
    try:
        return [os.path.join(folder, entry) for entry in os.listdir(folder or ".")]
    except OSError:
        return []
