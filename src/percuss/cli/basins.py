"""``percuss basins``: a plane of starts, and what motion each leads to."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence

from percuss.cli.arguments import MAX_MODES, PICTURES, Parser, check_picture, modes, named_case, whole
from percuss.cli.long_commands import add_carrying, carried

_DESCRIPTION = """\
A plane of starts, each followed until its motion is found: the basins of attraction as an image. The axes are two of
position (of the striking end, the wall is at 0), velocity and time (load phase in radians), or modal amplitudes u_1,
u_2, …, v_1, v_2, …; all dimensionless, and 0 unless given. For a case in SI, position, velocity and time may
have units; the axes of the result are dimensionless even then. A machine that switches its own valve has no load phase;
--at state=NAME is the state of the valve at the start (default: its own starting state)."""

_EXAMPLES = """\
  percuss basins hydraulic-drifter --x "time=0:16.6 ms:200" --y "velocity=-12:0 m/s:150" --modes 0 --plot basins.png
  percuss basins mini-breaker --x time=0:6.28:80 --y velocity=-6:-0.1:60 --at position=-0.5
  percuss basins valve-breaker --x "position=-300:-5 mm:60" --y "velocity=-15:15 m/s:60" --at state=power --modes 0
  percuss basins case.toml --x velocity=-5:5:300 --y position=-5:0:300 --at time=1.5 -o basins.zarr"""


_WITH_UNIT = re.compile(r"\s*[-+−]?\.?\d")


def _parser() -> Parser:
    parser = Parser("basins", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--x", metavar="RANGE", required=True, help="the horizontal axis: time=0:6.28:200")
    add("--y", metavar="RANGE", required=True, help="the vertical axis: velocity=-6:0:150")
    add("--at", metavar="VALUES", type=_values, default={}, help="what all starts share: position=-1,time=0.3")
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 to {MAX_MODES} (default: the case's, or 32)")
    add("--impacts", metavar="N", type=whole, help="the most impacts per start (default: the case's, or 2000)")
    add("--json", action="store_true", help="print the image and its attractors as JSON")
    add("--plot", metavar="FILE", help=f"draw the image: {', '.join(PICTURES)}")
    add_carrying(parser)
    return parser


def _values(text: str) -> dict[str, float | str]:
    """``position=-1,time=0.3`` as numbers by name; with a unit (``-30 mm``), and of a state, they stay text."""
    found: dict[str, float | str] = {}
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            if not name.strip() or not (_WITH_UNIT.match(value) or name.strip() == "state"):
                told = f"'{text}': give NAME=NUMBER, for example position=-1,time=0.3"
                raise argparse.ArgumentTypeError(told) from None
            found[name.strip()] = value.strip()
    return found


def run(arguments: Sequence[str]) -> int:
    """Make one image; returns the exit code."""
    from percuss.case import basins_job_of
    from percuss.explore import Axis, Basins

    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.impacts == 0:
        parser.error("argument --impacts: at least one impact")
    case = named_case(options.case)
    x, y = Axis.parsed(options.x), Axis.parsed(options.y)
    job = basins_job_of(case, x, y, at=options.at, modes=options.modes, impacts=options.impacts)
    found = Basins.of(job, carried(parser, options, job))
    from percuss import plot
    from percuss.case.answers.exploring.exploration import basins_dict, basins_report
    from percuss.cli.report_printing import answered

    answered(
        options, lambda: basins_dict(case, found), lambda: basins_report(case.title, found),
        lambda: plot.basins(found, case.title), basins=options.output,
    )  # fmt: skip
    return 0
