"""``percuss machine``: how a hammer runs whose piston switches its own valve."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.files import PICTURES, check_not_the_case, check_picture, check_target, named_case, tell_made
from percuss.cli.parser import MAX_MODES, Parser, modes
from percuss.errors import CaseError, PercussError

if TYPE_CHECKING:
    from percuss.case import MachineAnswer

__all__ = ["run"]

_DESCRIPTION = """\
How a hammer runs whose piston switches its own valve ([load] of the kind "valve"): blow energy, rate, stroke, oil flow
and power, stability, margins, and how they follow pressure, ports and delays. No clock drives it, so that there is no
phase."""

_EXAMPLES = """\
  percuss machine valve-breaker
  percuss machine valve-drifter --plot drifter.png
  percuss new valve-breaker -o breaker.toml
  percuss machine breaker.toml --modes 0
  percuss machine breaker.toml --json -o cycle.csv"""


def _parser() -> Parser:
    parser = Parser("machine", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    parser.add_argument(
        "--modes", metavar="N", type=modes, help=f"elastic modes, 0 (a rigid piston) to {MAX_MODES} (default 32)"
    )
    parser.add_argument("--json", action="store_true", help="print the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help=f"draw the answer: {', '.join(PICTURES)}")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the cycle over time as a table, .csv")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Answer for one machine; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.output is not None:
        if not options.output.lower().endswith(".csv"):
            parser.error(f"argument -o: '{options.output}': the name must end in .csv")
        check_target(parser, "-o", options.output)
        check_not_the_case(parser, options.output, options.case)
    answer = _answer(options.case, options.modes)
    text = _json(answer) if options.json else ""
    if options.output is not None:
        if answer.cycle is None:
            raise PercussError(f"{answer.name}: there is no cycle to write", "see the report without -o")
        from percuss.case.answers.machine_course import cycle_table
        from percuss.whole_file import write_whole

        write_whole(options.output, cycle_table(answer.machine, answer.cycle))
    if options.plot is not None:
        from percuss import plot

        plot.save(plot.machine(answer), options.plot)
    if options.json:
        print(text)
    else:
        from percuss.cli.machine_report import machine_report
        from percuss.cli.report_printing import show

        show(machine_report(answer))
    tell_made(options.json, table=options.output, picture=options.plot)
    return 0


def _answer(name: str, kept: int | None) -> MachineAnswer:
    from percuss.case import machine_answer

    case = named_case(name)
    try:
        answer = machine_answer(case, kept)
    except CaseError:
        raise
    except PercussError as error:  # the floors below do not know the file
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error
    for warning in answer.warnings:
        print(f"percuss: warning: {warning}", file=sys.stderr)
    return answer


def _json(answer: MachineAnswer) -> str:
    import json

    return json.dumps(answer.to_json_dict(), indent=1, allow_nan=False)
