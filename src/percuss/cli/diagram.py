"""``percuss diagram``: all motions of a hammer over one parameter."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.arguments import (
    MAX_MODES,
    PICTURES,
    Parser,
    check_picture,
    check_table,
    check_target,
    modes,
    named_case,
    need,
    whole,
)
from percuss.cli.long_commands import add_carrying, carrying
from percuss.cli.orbits import typed_label
from percuss.errors import Interrupted

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.explore import Diagram

_DESCRIPTION = """\
All motions of a hammer over one parameter: what simulations settle on, from many starts and up and down the parameter,
as points; orbits searched for up to a label, stable and unstable, followed through the whole range and on at flips and
grazings, as lines; what happens on them, as marks. After Ctrl-C the answer is what has been found so far."""

_EXAMPLES = """\
  percuss diagram pneumatic-jackleg --along load_factor=0.3:1.2 --plot diagram.png
  percuss diagram case.toml --along "frequency=40 Hz:80 Hz:40" --label 1/1 --show speed,energy --plot diagram.svg
  percuss diagram case.toml --along restitution=0:0.9:40 --modes 0 -o diagram.zarr --csv diagram.csv
  percuss diagram case.toml --along restitution=0:0.9:40 --modes 0 -o diagram.zarr --resume"""


def _parser() -> Parser:
    parser = Parser("diagram", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--along", metavar="RANGE", required=True, help="a parameter and its range, load_factor=0.3:1.2; with the "
        "number of values to simulate behind it, if not 120")  # fmt: skip
    add("--label", metavar="P/N", type=typed_label, default="3/3", help="search for orbits with up to so many impacts "
        "and load periods (default 3/3)")  # fmt: skip
    add("--switch", metavar="DEPTH", type=whole, default=2, help="go on so often at flips to the doubled orbit, and of "
        "a rigid bar at grazings to that with an impact more or less (default 2)")  # fmt: skip
    add("--searched", metavar="N", type=whole, default=5, help="values at which orbits are searched for (default 5)")
    add("--tries", metavar="N", type=whole, default=100, help="random starts of each search (default 100)")
    add("--starts", metavar="N", type=whole, default=8, help="simulations from random starts at each value (default 8)")
    add("--runs", metavar="N", type=whole, default=6, help="motions that are taken along, up and down the values, each "
        "simulation from where the one before ended (default 6)")  # fmt: skip
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 to {MAX_MODES} (default: the case's, or 8)")
    add("--seed", metavar="N", type=whole, default=0, help="of the random starts (default 0)")
    add("--json", action="store_true", help="print the diagram as JSON")
    add("--csv", metavar="FILE", help="write points and branches as a table, a line for each impact")
    add("--netcdf", metavar="FILE", help="write points and branches as a NetCDF file, .nc")
    add("--plot", metavar="FILE", help=f"draw the diagram: {', '.join(PICTURES)}")
    add("--show", metavar="NAMES", type=_shown, default=("phase", "speed"), help="what the picture shows: some of "
        "phase,speed,energy (default phase,speed)")  # fmt: skip
    add_carrying(parser)
    return parser


def _shown(text: str) -> tuple[str, ...]:
    found = tuple(name.strip() for name in text.split(","))
    wrong = [name for name in found if name not in ("phase", "speed", "energy")]
    if wrong:
        raise argparse.ArgumentTypeError(f"'{wrong[0]}': give some of phase, speed, energy")
    return found


def run(arguments: Sequence[str]) -> int:
    """Make one diagram; returns the exit code."""
    from percuss.case import diagram_job_of

    parser = _parser()
    options = parser.parsed(arguments)
    _check_files(parser, options)
    case = named_case(options.case)
    job = diagram_job_of(
        case, options.along, up_to=options.label, searched=options.searched, switch=options.switch,
        tries=options.tries, starts=options.starts, runs=options.runs, modes=options.modes, seed=options.seed,
    )  # fmt: skip
    from percuss.explore.diagrams.diagram import Diagram, carried_diagram

    try:
        with carrying(parser, options) as running:
            found = carried_diagram(job, **running)
    except Interrupted as stop:
        if not isinstance(stop.partial, Diagram) or not stop.done:
            raise
        print(f"\npercuss: {stop}", file=sys.stderr)
        _tell(options, case, stop.partial)
        return 130
    _tell(options, case, found)
    return 0


def _check_files(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse what cannot be written before anything is computed."""
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.csv is not None:
        check_table(parser, options.csv)
    if options.netcdf is not None:
        if not options.netcdf.lower().endswith(".nc"):
            parser.error(f"argument --netcdf: '{options.netcdf}': the name must end in .nc")
        check_target(parser, "--netcdf", options.netcdf)
        need("h5netcdf", "io")


def _tell(options: argparse.Namespace, case: Case, found: Diagram) -> None:
    """Files and answer."""
    if options.csv is not None:
        from percuss.explore.jobs.archive_export import write_csv

        write_csv(found.dataset, options.csv)
    if options.netcdf is not None:
        from percuss.explore.jobs.archive_export import write_netcdf

        write_netcdf(found.dataset, options.netcdf)
    from percuss import plot
    from percuss.case.answers.exploring.diagram_answer import diagram_dict, diagram_report
    from percuss.cli.report_printing import answered

    mode = "elastic mode" if case.tables.body is None else "mode"
    answered(
        options, lambda: diagram_dict(case, found), lambda: diagram_report(case.title, found, mode),
        lambda: plot.diagram(found, case.title, options.show), diagram=options.output, table=options.csv,
        data=options.netcdf,
    )  # fmt: skip
