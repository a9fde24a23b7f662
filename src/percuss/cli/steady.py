"""``percuss steady``: every steady motion of a hammer."""

from __future__ import annotations

import argparse
import gc
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import as_typed
from percuss.cli.arguments import (
    MAX_MODES,
    PICTURES,
    Parser,
    check_picture,
    check_target,
    modes,
    named_case,
    need,
    of_file,
    periods,
    up_to,
)

if TYPE_CHECKING:
    from percuss.case import Case, SteadyAnswer
    from percuss.case.answers.steady_answer import CaseReach, Ends
    from percuss.steady import Orbit

MAX_STARTS = 1000

PATIENCE = 5.0
"""Seconds after which Ctrl-C no longer waits while a motion is followed: a long proof asks more seldom."""

_DESCRIPTION = """\
Every steady motion with one impact per m load periods: whether it is possible, whether it is stable and by what
margin, and what it means in joules, hertz, metres per second and megapascals. After Ctrl-C while --reach moves the
parameters, the answer has those that are done."""

_EXAMPLES = """\
  percuss steady hydraulic-drifter
  percuss steady case.toml --periods 1..3 --plot case.png
  percuss steady hydraulic-drifter --report drifter.html
  percuss steady heavy-drifter --reach
  percuss steady mini-breaker --reach-of load.mean,load.frequency --report drifter.html
  percuss steady case.toml --json > answer.json"""


def _parser() -> Parser:
    parser = Parser("steady", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add(
        "--periods", metavar="M", type=periods, default=(1,), help="load periods per impact: 2, 1..4 or 1,3 (default 1)"
    )
    add("--modes", metavar="N", type=modes, help=f"elastic modes in sums and multipliers, 0 to {MAX_MODES} (default: "
        "as many as the tolerance needs, and 32 for the multipliers)")  # fmt: skip
    add("--starts", metavar="N", type=up_to(MAX_STARTS, " ('percuss experiment' follows more)"), help="random starts "
        f"to follow, up to {MAX_STARTS}; 0 for none, which is quicker (default: 24 once the simulator is compiled on "
        "this computer, none with --json)")  # fmt: skip
    add("--reach", action="store_true", help="also how far the load and other parameters may move before the motion is "
        "lost, and what comes then")  # fmt: skip
    add("--reach-of", metavar="NAMES", type=_names, help="the same of these parameters of 'percuss sweep', separated "
        "by commas")  # fmt: skip
    add("--json", action="store_true", help="print the answer as JSON")
    add("--plot", metavar="FILE", help=f"draw the answer: {', '.join(PICTURES)}")
    add("--report", metavar="FILE", help="write figures and pictures into one HTML file")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Answer for one case; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.report is not None:
        _check_report(parser, options.report)
    if options.reach_of == ():
        parser.error("argument --reach-of: names of parameters, with commas between them")
    case = named_case(options.case)
    if case.tables.body is not None:
        return _of_structure(parser, case, options)
    starts = 0 if options.json and options.starts is None else options.starts
    with _undisturbed():
        case, answer = _answer(case, options.periods, options.modes, starts)
    cut = ""
    if options.reach or options.reach_of is not None:
        answer, cut = _with_reach(parser, options, case, answer)
    from percuss import plot
    from percuss.case.answers.steady_report import steady_report
    from percuss.cli.report_printing import answered

    if options.report is not None:
        from percuss.html_report import report_html
        from percuss.whole_file import write_whole

        write_whole(options.report, report_html(case, answer))
    answered(
        options, answer.to_json_dict, lambda: steady_report(answer), lambda: plot.steady(answer), indent=1,
        report=options.report,
    )  # fmt: skip
    if cut:
        print(f"percuss: interrupted: {cut}", file=sys.stderr)
    return 130 if cut else 0


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _with_reach(
    parser: Parser, options: argparse.Namespace, case: Case, answer: SteadyAnswer
) -> tuple[SteadyAnswer, str]:
    """The answer with how far parameters may move, and what Ctrl-C left out."""
    chosen = answer.chosen
    stable = chosen is not None and chosen.orbit.admissible and chosen.stability.stable
    rows, cut = _reached(parser, options, case, chosen.orbit if chosen is not None and stable else None)
    return replace(answer, reach=rows), cut


def _reached(
    parser: Parser, options: argparse.Namespace, case: Case, orbit: Orbit | None
) -> tuple[tuple[CaseReach, ...], str]:
    """How far parameters may move; after Ctrl-C of as many as are known, and of how many that is."""
    from percuss.case.answers.exploring.reach_answer import reach_answer, varied_parameters
    from percuss.cli.long_commands import watching

    wanted = varied_parameters(case, options.reach_of)  # which refuses what is unknown
    if orbit is None:
        return (), ""
    with watching(parser, patience=PATIENCE) as watch:
        found = reach_answer(case, orbit, options.reach_of, modes=options.modes, halt=watch.asked)
    cut = f"how far {len(found)} of {len(wanted)} parameters may move is known" if watch.interrupted else ""
    return found, cut


@contextmanager
def _undisturbed() -> Iterator[None]:
    """No look for cycles meanwhile: what is imported and loaded is much, and all of it stays."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def _check_report(parser: Parser, path: str) -> None:
    if not path.lower().endswith((".html", ".htm")):
        parser.error(f"argument --report: '{path}': the name must end in .html")
    check_target(parser, "--report", path)
    need("matplotlib", "plot")


def _of_structure(parser: Parser, case: Case, options: argparse.Namespace) -> int:
    """The answer for a structure that is held."""
    if options.report is not None:
        parser.error(
            "argument --report: its pages are of a free bar (waveform, level, blows); of a structure that is held "
            "--plot FILE draws the motions and --json gives all numbers"
        )
    if options.starts:
        parser.error("argument --starts: not for a structure that is held; 'percuss experiment' follows its starts")
    from percuss import plot
    from percuss.case import structure_answer
    from percuss.case.answers.steady_report import structure_report
    from percuss.cli.report_printing import answered

    answer, cut = structure_answer(case, options.periods, options.modes), ""
    if options.reach or options.reach_of is not None:
        rows, cut = _reached(parser, options, case, None if answer.chosen is None else answer.chosen.orbit)
        answer = replace(answer, reach=rows)
    answered(options, answer.to_json_dict, lambda: structure_report(answer), lambda: plot.steady(answer), indent=1)
    if cut:
        print(f"percuss: interrupted: {cut}", file=sys.stderr)
    return 130 if cut else 0


def _answer(case: Case, asked: tuple[int, ...], kept: int | None, starts: int | None) -> tuple[Case, SteadyAnswer]:
    from percuss.case import steady_answer

    with of_file(case):
        answer = steady_answer(case, asked, kept)
        return case, replace(answer, starts=_ends(case, kept, starts))


def _ends(case: Case, kept: int | None, starts: int | None) -> Ends:
    """Random starts; without being asked only where the simulator need not be compiled first."""
    from percuss.case.answers.steady_answer import STARTS, ends_of, not_followed

    if starts == 0:
        return not_followed("none were asked for")
    from percuss.simulate.running import compiled  # loads the compiler

    if compiled():
        return ends_of(case, STARTS if starts is None else starts, kept)
    if starts is None:
        return not_followed(
            "the simulator has not been compiled on this computer yet; "
            f"'percuss steady {as_typed(case.file)} --starts {STARTS}' does it, and is quick from then on"
        )
    print("percuss: compiling the simulator, which takes up to a minute", file=sys.stderr, flush=True)
    gc.enable()  # compiling leaves many cycles
    return ends_of(case, starts, kept)
