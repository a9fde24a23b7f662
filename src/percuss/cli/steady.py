"""``percuss steady``: every steady motion of a hammer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.files import PICTURES, check_picture, named_case, tell_made
from percuss.cli.parser import MAX_MODES, Parser, modes, periods
from percuss.errors import CaseError, PercussError

if TYPE_CHECKING:
    from percuss.case import SteadyAnswer

__all__ = ["run"]

_DESCRIPTION = """\
Every steady motion with one impact per m load periods: whether it is possible, whether it is stable and by what
margin, and what it means in joules, hertz, metres per second and megapascals."""

_EXAMPLES = """\
  percuss steady hydraulic-drifter
  percuss steady case.toml --periods 1..3 --plot case.png
  percuss steady case.toml --json > answer.json"""


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
    parser.add_argument("--plot", metavar="FILE", help=f"draw the answer: {', '.join(PICTURES)}")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Answer for one case; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
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
    tell_made(options.json, picture=options.plot)
    return 0


def _answer(name: str, asked: tuple[int, ...], kept: int | None) -> SteadyAnswer:
    from percuss.case import steady_answer

    case = named_case(name)
    try:
        return steady_answer(case, asked, kept)
    except CaseError:
        raise
    except PercussError as error:  # the floors below do not know the file
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error


def _json(answer: SteadyAnswer) -> str:
    import json

    return json.dumps(answer.to_json_dict(), indent=1, allow_nan=False)
