"""``percuss sweep``: quantities of a hammer over a parameter curve or plane."""

from __future__ import annotations

import argparse
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.cli.arguments import (
    MAX_MODES,
    PICTURES,
    Parser,
    check_picture,
    check_table,
    modes,
    named_case,
    periods,
    whole,
)
from percuss.cli.long_commands import add_carrying, carried, watching
from percuss.errors import ParameterError

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.case.answers.exploring.point_curves_answer import LaidCurve
    from percuss.explore import Boundaries, Sweep
    from percuss.explore.cells import SweepJob
    from percuss.explore.sweeps import Range

_ABOUT = """\
Quantities of a hammer over one parameter or a plane of two: where a steady motion exists, where it is stable and by
what margin, what a blow delivers, and what motion a simulation finds. A range is FROM:TO:NUMBER, with :log after it
for equal ratios, or a list A,B,C; a quantity in SI needs a unit with the numbers."""

_EXAMPLES = """\
  percuss sweep hydraulic-drifter --x restitution=0:0.9:90 --y load_factor=0.1:1:90 --plot map.png
  percuss sweep case.toml --x frequency="20 Hz:80 Hz:61" --quantity blow_energy,stable,label --csv map.csv
  percuss sweep laboratory-striker --x "rock.stiffness=50:400 kN/mm:36" --quantity rock_efficiency,peak_stress
  percuss sweep valve-breaker --x "pressure=100:200 bar:50" --y "ports[0].behind=60:200 mm:50" --plot map.png
  percuss sweep case.toml --x restitution=0:0.9:200 --y load_factor=0.01:1:200 --quantity label -o map.zarr
  percuss sweep case.toml --x restitution=0:0.9:200 --y load_factor=0.01:1:200 --quantity label -o map.zarr --resume"""


def _parser() -> Parser:
    parser = Parser("sweep", f"{_ABOUT}\n\n{_vocabulary()}", _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--x", metavar="RANGE", required=True, help="a parameter and its values: restitution=0:0.9:200")
    add("--y", metavar="RANGE", help="a second parameter, for a plane")
    add("--quantity", metavar="NAMES", type=_names, help="what to compute, separated by commas (default: exists,orbits,"
        "phase,reduced_stable,stable,margin, of a valve stall,blow_energy,rate,stroke)")  # fmt: skip
    add("--periods", metavar="M", type=periods, default=(1,), help="load periods per impact (default 1)")
    add("--modes", metavar="N", type=modes, help=f"elastic modes for every quantity, 0 to {MAX_MODES} (default: steady "
        "motions of the continuous bar with multipliers of 32 modes; simulations with the case's, or 32)")  # fmt: skip
    add("--impacts", metavar="N", type=whole, help="the most impacts per simulation (default: the case's, or 2000)")
    add(
        "--curves",
        action="store_true",
        help="also solve for the curves at which motions or their stability end, over --x and --y",
    )
    add(
        "--overlay",
        metavar="FILE",
        help="draw curves over the same two parameters into --plot: an answer of 'percuss follow … --curve … --json'",
    )
    add("--json", action="store_true", help="print the map as JSON")
    add("--csv", metavar="FILE", help="write the map as a table, a line for each cell, to open in other programs")
    add("--plot", metavar="FILE", help=f"draw the map: {', '.join(PICTURES)}")
    add_carrying(parser)
    return parser


def _vocabulary() -> str:
    """The parameters and the quantities that there are."""
    from percuss.explore.parameters import LOAD_PARAMETERS, PARAMETERS, PERIODS
    from percuss.explore.quantities import MACHINE_QUANTITIES, QUANTITIES

    numbers = ", ".join(f"{name} ({about.label})" for name, about in PARAMETERS.items())
    loads = ", ".join(f"{word}K ({about})" for word, about in LOAD_PARAMETERS.items())
    followed = [name for name, quantity in QUANTITIES.items() if quantity.group in ("simulation", "lyapunov")]
    struck = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
    switching = [name for name, quantity in MACHINE_QUANTITIES.items() if quantity.group == "machine"]
    steady = [name for name in QUANTITIES if name not in (*followed, *struck)]
    paragraphs = (
        "parameters: any number of the case file, bar.length or length for short, sections[0].length; load.scale, a "
        f"factor on the load; dimensionless: {numbers}; {loads}; {PERIODS}, the load periods per impact.",
        f"quantities: {', '.join(steady)}; by simulation: {', '.join(followed)}; of one "
        f"blow by waves, as 'percuss blow' has it: {', '.join(struck)}.",
        "of a piston that switches its own valve, parameters: pressure, states.NAME, chamber.force, chamber.stiffness, "
        "ports[0].behind, ports[0].delay and the numbers of the bar and the contact; quantities: "
        f"{', '.join(switching)}; and of one blow.",
    )
    return "\n".join(textwrap.fill(text, 120, break_on_hyphens=False) for text in paragraphs)


def _names(text: str) -> tuple[str, ...]:
    """Names with commas between them."""
    found = tuple(name.strip() for name in text.split(",") if name.strip())
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}': give one or more names, for example stable,label")
    return found


def run(arguments: Sequence[str]) -> int:
    """Make one map; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    if options.csv is not None:
        check_table(parser, options.csv)
    if len(options.periods) > 1:
        parser.error("argument --periods: one number; to compare several, make m an axis: --y m=1,2,3")
    if options.curves and options.y is None:
        parser.error("argument --curves: boundaries lie in a plane: give --y too")
    if options.overlay is not None and (options.plot is None or options.y is None):
        parser.error("argument --overlay: curves are drawn into the picture of a plane: give --y and --plot too")
    laid = _laid(options.overlay)
    case = named_case(options.case)
    job = _job(case, options)
    if options.curves and case.is_machine:
        parser.error(
            "argument --curves: boundaries are those of a load that keeps time; ask for stall to see what stops"
        )
    if options.curves:
        from percuss.explore.boundary_curves.boundary import checked_boundaries

        checked_boundaries(job.family, **_boundaries(job))
    found = _swept(parser, options, job)
    curves = _curves(parser, job) if options.curves else None
    if options.csv is not None:
        from percuss.explore.jobs.archive_export import write_csv

        write_csv(found.dataset, options.csv)
    from percuss import plot
    from percuss.case.answers.exploring.exploration import sweep_dict, sweep_report
    from percuss.cli.report_printing import answered

    answered(
        options,
        lambda: sweep_dict(case, found, curves),
        lambda: sweep_report(case.title, found, curves, _ranges(job, found), case.notes),
        lambda: plot.sweep(found, case.title, [*(curves.curves if curves else ()), *laid]),
        map=options.output,
        table=options.csv,
    )
    return 0


def _laid(path: str | None) -> tuple[LaidCurve, ...]:
    """The curves of a file."""
    if path is None:
        return ()
    from percuss.case.answers.exploring.point_curves_answer import laid_curves

    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise ParameterError("overlay", path, "a file that can be read", str(error)) from None
    return laid_curves(path, content)


def _job(case: Case, options: argparse.Namespace) -> SweepJob:
    from percuss.case import sweep_job_of
    from percuss.explore import Axis

    axes = [Axis.parsed(text) for text in (options.x, options.y) if text is not None]
    return sweep_job_of(
        case,
        axes,
        options.quantity,
        periods=options.periods[0],
        modes=options.modes,
        impacts=options.impacts,
    )


def _swept(parser: Parser, options: argparse.Namespace, job: SweepJob) -> Sweep:
    from percuss.explore import Sweep

    return Sweep.shaped(job, carried(parser, options, job))


def _boundaries(job: SweepJob) -> dict[str, Any]:
    """What `boundaries` is asked for a map: by the criterion that the map is made by, and as far as it reaches."""
    from percuss.explore.quantities import needs

    x, y = job.axes
    wanted = needs(job.quantities)
    exact, steady = bool(wanted & {"exact", "simulation", "lyapunov"}), bool(wanted & {"orbits", "exact"})
    return {
        "x": x,
        "y": (y.name, float(y.values.min()), float(y.values.max())),
        "periods": job.periods,
        "criterion": "exact" if exact else "reduced",
        "modes": job.modes if steady or not exact else job.simulated,
        "kinds": ("fold", "flip", "neimark-sacker"),
    }


def _ranges(job: SweepJob, found: Sweep) -> dict[str, tuple[Range, ...]]:
    """Along one axis: where what is yes or no is yes."""
    from percuss.explore.sweeps import true_ranges

    if len(job.axes) != 1:
        return {}
    return {name: true_ranges(job, found, name) for name in job.quantities if found[name].dtype == bool}


def _curves(parser: Parser, job: SweepJob) -> Boundaries | None:
    """The boundaries of a map; None when a person does not want to wait for them."""
    from percuss.explore import boundaries

    try:
        with watching(parser) as watch:
            found = boundaries(job.family, **_boundaries(job), progress=watch)
        if watch.interrupted:
            raise KeyboardInterrupt
        return replace(found, curves=found.of_stability)
    except KeyboardInterrupt:
        print("percuss: interrupted: the map is complete, but its boundaries are left out", file=sys.stderr)
        return None
