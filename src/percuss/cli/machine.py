"""``percuss machine``: how a hammer runs whose piston switches its own valve."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.cli.arguments import MAX_MODES, PICTURES, Parser, check_csv, check_picture, modes, named_case, of_file
from percuss.errors import HistoryError, PercussError
from percuss.units import si

if TYPE_CHECKING:
    import argparse

    from percuss.case import Case, MachineAnswer, RecordedAnswer

_DESCRIPTION = """\
How a hammer runs whose piston switches its own valve ([load] of the kind "valve"): blow energy, rate, stroke, oil flow
and power, stability, margins, and how they follow pressure, ports and delays. No clock drives it, so that there is no
phase. A recording, or steps of a load, are read as the force of such a machine: its ports and delays, by where the
piston is as the force switches, its cycle, and the verdict with the valve beside that under a clock."""

_EXAMPLES = """\
  percuss machine valve-breaker
  percuss machine valve-drifter --plot drifter.png
  percuss new valve-breaker -o breaker.toml
  percuss machine breaker.toml --modes 0
  percuss machine breaker.toml --json -o cycle.csv
  percuss machine recorded.toml --blows blows.txt"""


def _parser() -> Parser:
    parser = Parser("machine", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    parser.add_argument(
        "--modes", metavar="N", type=modes, help=f"elastic modes, 0 (a rigid piston) to {MAX_MODES} (default 32)"
    )
    parser.add_argument("--json", action="store_true", help="print the answer as JSON")
    parser.add_argument("--plot", metavar="FILE", help=f"draw the answer: {', '.join(PICTURES)}")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the cycle over time as a table, .csv")
    read = parser.add_argument_group("reading a recorded load")
    read.add_argument("--blow", metavar="TIME", help='when a blow was recorded, such as "12.4 ms" (on its clock)')
    read.add_argument("--blows", metavar="FILE", help="a text file with the times of all blows in s, one in a line")
    read.add_argument("--longest-delay", metavar="TIME", help='the longest delay of the valve, such as "10 ms"')
    return parser


def run(arguments: Sequence[str]) -> int:
    """Answer for one machine; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.output is not None:
        check_csv(parser, options.output, options.case)
    answer, record = _answer(parser, options)
    if options.output is not None:
        if answer.cycle is None:
            raise PercussError(f"{answer.name}: there is no cycle to write", "see the report without -o")
        from percuss.case.answers.machine_figures import cycle_table
        from percuss.whole_file import write_whole

        write_whole(options.output, cycle_table(answer.machine, answer.cycle))
    from percuss import plot
    from percuss.case.answers.machine_answer import machine_report
    from percuss.case.answers.recorded_answer import recorded_report
    from percuss.cli.report_printing import answered

    answered(
        options, (record or answer).to_json_dict,
        lambda: machine_report(answer) if record is None else recorded_report(record), lambda: plot.machine(answer),
        indent=1, table=options.output,
    )  # fmt: skip
    return 0


def _answer(parser: Parser, options: argparse.Namespace) -> tuple[MachineAnswer, RecordedAnswer | None]:
    """How the machine runs; of a load that is a recording or steps also how it was read."""
    from percuss.case import machine_answer

    case = named_case(options.case)
    record = None
    with of_file(case):
        if case.is_machine or not case.is_readable:
            for option in asked_of_record(options):
                parser.error(f"argument {option}: only for a recorded load, or one of steps, which {case.file} has not")
            answer = machine_answer(case, options.modes)
        else:
            record = read_record(case, options)
            answer = record.answer
    for warning in answer.warnings:
        print(f"percuss: warning: {warning}", file=sys.stderr)
    return answer, record


# ---- ``percuss machine`` of a recorded load: what is said of its blows, and the answer

_OPTIONS = ("blow", "blows", "longest_delay")


def asked_of_record(options: argparse.Namespace) -> list[str]:
    """The options that were given which only a recorded load has."""
    return [f"--{name.replace('_', '-')}" for name in _OPTIONS if getattr(options, name) is not None]


def read_record(case: Case, options: argparse.Namespace) -> RecordedAnswer:
    """The answer for a load that is a recording, or steps."""
    from percuss.case import recorded_answer

    longest, unit = options.longest_delay, "time" if case.is_si else "dimensionless"
    return recorded_answer(
        case,
        options.modes,
        blow=None if options.blow is None else si(options.blow, "time", "--blow"),
        blows=None if options.blows is None else _times(options.blows),
        longest_delay=None if longest is None else si(longest, unit, "--longest-delay"),
    )


def _times(path: str) -> list[float]:
    """The times of the blows, one in a line."""
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise HistoryError(f"cannot be read ({error})", "give a text file", path) from None
    found = []
    for number, line in enumerate(lines, 1):
        try:
            if line.strip():
                found.append(float(line))
        except ValueError:
            raise HistoryError(f"line {number} is {line!r:.40}", "give one time in s in a line", path) from None
    return found
