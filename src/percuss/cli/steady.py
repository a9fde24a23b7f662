"""``percuss steady``: every steady motion of a hammer."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.parser import MAX_MODES, Parser, modes, periods
from percuss.errors import CaseError, PercussError

if TYPE_CHECKING:
    from percuss.case import Case, SteadyAnswer

__all__ = ["run"]

_DESCRIPTION = """\
Every steady motion with one impact per m load periods: whether it is possible, whether it is stable and by what
margin, and what it means in joules, hertz, metres per second and megapascals."""

_EXAMPLES = """\
  percuss steady hydraulic-drifter
  percuss steady case.toml --periods 1..3 --plot case.png
  percuss steady case.toml --json > answer.json"""

_SUFFIXES = (".png", ".svg", ".pdf")


def _parser() -> Parser:
    parser = Parser("steady", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    parser.add_argument(
        "--periods",
        metavar="M",
        type=periods,
        default=(1,),
        help="load periods per impact: 2, 1..4 or 1,3 (default 1)",
    )
    parser.add_argument(
        "--modes",
        metavar="N",
        type=modes,
        help=f"elastic modes of sums and multipliers, 0 to {MAX_MODES} (default: as many as the tolerance needs, "
        "and 32 for the multipliers)",
    )
    parser.add_argument("--json", action="store_true", help="print the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help=f"draw the answer: {', '.join(_SUFFIXES)}")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Answer for one case; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        _check_plot(parser, options.plot)
    answer = _answer(options.case, options.periods, options.modes)
    text = _json(answer) if options.json else ""
    if options.plot is not None:
        from percuss import plot

        plot.save(plot.steady(answer), options.plot)
    if options.json:
        print(text)
    else:
        from percuss.cli.report import steady_report
        from percuss.cli.show import show

        show(steady_report(answer))
    if options.plot is not None:
        print(f"picture: {options.plot}", file=sys.stderr if options.json else sys.stdout)
    return 0


def _check_plot(parser: Parser, path: str) -> None:
    """Refuse what cannot be drawn before anything is computed."""
    from importlib.util import find_spec

    from percuss.errors import MissingExtraError

    if not path.lower().endswith(_SUFFIXES):
        parser.error(f"argument --plot: '{path}': the name must end in {', '.join(_SUFFIXES[:-1])} or {_SUFFIXES[-1]}")
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        parser.error(f"argument --plot: '{path}': there is no folder '{folder}'")
    if os.path.isdir(path):
        parser.error(f"argument --plot: '{path}' is a directory")
    if find_spec("matplotlib") is None:
        raise MissingExtraError("matplotlib", "plot")


def _answer(name: str, asked: tuple[int, ...], kept: int | None) -> SteadyAnswer:
    from percuss.case import steady_answer

    case = named_case(name)
    try:
        return steady_answer(case, asked, kept)
    except CaseError:
        raise
    except PercussError as error:  # the floors below do not know the file
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error


def named_case(name: str) -> Case:
    """The case in a file, or of a machine of the catalogue; a file goes first.

    Raises
    ------
    CaseError
        When there is neither, or the file is not a case.
    """
    from percuss.case import MACHINES, Case, load_case
    from percuss.case.catalogue import is_machine
    from percuss.case.suggest import did_you_mean

    if is_machine(name) and not os.path.isfile(name):
        return load_case(name)
    if name != "-" and not os.path.exists(name):
        near = [entry for entry in _entries(os.path.dirname(name)) if entry.endswith(".toml")]
        remedy = did_you_mean(name, [*near, *(machine.name for machine in MACHINES)])
        what = "no such file" if name.endswith(".toml") else "no such file, and no machine of this name"
        raise CaseError(name, "", None, what, remedy or "'percuss machines' lists the machines")
    return Case.read(name)


def _entries(folder: str) -> list[str]:
    try:
        return [os.path.join(folder, entry) for entry in os.listdir(folder or ".")]
    except OSError:
        return []


def _json(answer: SteadyAnswer) -> str:
    import json

    return json.dumps(answer.to_json_dict(), indent=1, allow_nan=False)
