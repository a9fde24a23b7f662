"""``percuss follow``: an orbit followed through a parameter, to where it ends and to what begins on the way."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from percuss.cli.arguments import (
    MAX_MODES,
    PICTURES,
    Parser,
    check_csv,
    check_picture,
    modes,
    named_case,
    whole,
)
from percuss.cli.long_commands import watching
from percuss.errors import Interrupted

if TYPE_CHECKING:
    import argparse

    from percuss.case import Case

_PATIENCE = 5.0
"""Seconds after which Ctrl-C no longer waits: a long proof asks more seldom."""

_DESCRIPTION = """\
An orbit followed through a parameter, both ways from the value of the case, round folds, until something ends it: the
bar touches the wall between two impacts, an impact dies, the range ends. Folds, flips, pairs of multipliers on the unit
circle and corners at steps of the load are located to 1e-10, and of each it is said what lies beyond. The orbit is a
number in the list of 'percuss orbits', or one near the phases of its impacts, in order of time; or a cycle with rest,
which is followed to where its chatter meets the next release or it ends otherwise. With --curve points of the branch
are followed themselves, through its parameter and the one of --over: the curves in their plane at which motions or
their stability begin and end. After Ctrl-C the answer is what has been followed so far."""

_EXAMPLES = """\
  percuss follow pneumatic-jackleg --orbit 1/1 --along load_factor=0.3:1.2
  percuss follow case.toml --orbit 1/1:2 --along mean=0.5:1 --switch 4 --modes 0 --plot cascade.png
  percuss follow case.toml --orbit 2/1:phases=0.39,2.32 --along restitution=0:0.9 -o branch.csv
  percuss follow laboratory-striker --orbit chatter/1:1 --along load_factor=0.3:1.2 --modes 0
  percuss follow case.toml --orbit chatter/1 --along mean=0.3:1.2 --curve onset --over restitution=0:0.9 --modes 0
  percuss follow case.toml --orbit 2/1:2 --along mean=0.3:1.2 --curve flip,fold --over restitution=0:0.9 --json"""


def _parser() -> Parser:
    parser = Parser("follow", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--orbit", metavar="ORBIT", default="1/1", help="where to begin: 2/1:3, 2/1:phases=1.2,4.5 or "
        "chatter/1:1 (default 1/1:1)")  # fmt: skip
    add("--along", metavar="RANGE", required=True, help="a parameter and its range: load_factor=0.3:1.2; "
        "without a range the motion is followed to its ends")  # fmt: skip
    add("--switch", metavar="DEPTH", type=whole, default=0, help="go on so often at flips to the doubled orbit, and of "
        "a rigid bar at grazings to that with an impact more or less (default 0)")  # fmt: skip
    add("--curve", metavar="POINTS", help="also follow points through two parameters: flip, the first flip, fold:2, "
        "the second fold, several with commas between them, or all; of a cycle with rest onset, touch, death or "
        "release_lost")  # fmt: skip
    add("--over", metavar="RANGE", help="the second parameter, with or without a range: restitution=0:0.9")
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 to {MAX_MODES} (default: the case's, or 32)")
    add("--json", action="store_true", help="print the branches as JSON")
    add("--plot", metavar="FILE", help=f"draw the branches: {', '.join(PICTURES)}")
    add("-o", "--output", metavar="FILE", help="write the branches, or the curves, as a table, .csv")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Follow one orbit; returns the exit code."""
    from percuss.case import branch_answer, point_curves_answer

    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.output is not None:
        check_csv(parser, options.output, options.case)
    if (options.curve is None) != (options.over is None):
        parser.error("arguments --curve and --over: points are followed through two parameters: give both")
    if options.curve is not None:
        _check_plane(parser, options.along, options.over)
    case = named_case(options.case)
    resting = options.orbit.lstrip().startswith(("chatter", "rest"))
    if resting and options.switch:
        parser.error("argument --switch: nothing branches off a cycle with rest: follow an orbit P/N")
    branch: Any
    curves: Any = ()
    with watching(parser, patience=_PATIENCE) as watch:
        try:
            asked: dict[str, Any] = {"switch": options.switch, "modes": options.modes, "halt": watch.asked}
            branch = branch_answer(case, options.orbit, options.along, **asked)
        except Interrupted:  # before the first point of the branch
            raise KeyboardInterrupt from None
        if options.curve is not None and not watch.asked():
            curves = point_curves_answer(case, branch, options.curve, options.along, options.over, halt=watch.asked)
    _tell(options, case, branch, curves)
    if not watch.interrupted:
        return 0
    print("percuss: interrupted: the answer is of what was followed until then", file=sys.stderr)
    return 130


def _tell(options: argparse.Namespace, case: Case, branch: Any, curves: Any) -> None:
    """The files that were asked for, and the answer."""
    from percuss import plot
    from percuss.case.answers.exploring.orbits_answer import branch_dict, branch_report, branch_table
    from percuss.case.answers.exploring.point_curves_answer import point_curves_table
    from percuss.cli.report_printing import answered
    from percuss.whole_file import write_whole

    if options.output is not None:
        asked = options.curve is not None  # also where Ctrl-C has left none of them
        write_whole(options.output, point_curves_table(curves) if asked else branch_table(branch))
    drawn = plot.rest_branch if branch.has_rest else plot.branch
    answered(
        options,
        lambda: branch_dict(branch, curves),
        lambda: branch_report(case.title, branch, curves),
        lambda: plot.curves(curves, case.title) if curves else drawn(branch, case.title),
        table=options.output,
    )


def _check_plane(parser: Parser, along: str, over: str) -> None:
    """Refuse what are not two parameters, before anything is followed."""
    if along.partition("=")[0].strip() == over.partition("=")[0].strip():
        parser.error("argument --over: a second parameter, another than that of --along")
