"""Quantities over a parameter curve or plane, and where starts end: drawn at random, or in a plane."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.cli.arguments import (
    CASE,
    MAX_MODES,
    Parser,
    command,
    csv_option,
    modes,
    modes_option,
    named_case,
    names,
    option,
    periods,
    plot_option,
    whole,
)
from percuss.cli.long_commands import CARRYING, carried, carrying, watching
from percuss.errors import ParameterError

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.explore import Boundaries
    from percuss.explore.cells import SweepJob


def _about() -> str:
    from percuss.explore.parameters import LOAD_PARAMETERS, PARAMETERS, PERIODS
    from percuss.explore.quantities import MACHINE_QUANTITIES, QUANTITIES

    numbers = ", ".join(f"{name} ({about.label})" for name, about in PARAMETERS.items())
    loads = ", ".join(f"{word}K ({about})" for word, about in LOAD_PARAMETERS.items())
    followed = [name for name, quantity in QUANTITIES.items() if quantity.group in ("simulation", "lyapunov")]
    struck = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
    switching = [name for name, quantity in MACHINE_QUANTITIES.items() if quantity.group in ("machine", "transfer")]
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
    vocabulary = "\n".join(textwrap.fill(text, 120, break_on_hyphens=False) for text in paragraphs)
    return f"""\
Quantities of a hammer over one parameter or a plane of two: where a steady motion exists, where it is stable and by
what margin, what a blow delivers, and what motion a simulation finds. A range is FROM:TO:NUMBER, with :log after it
for equal ratios, or a list A,B,C; a quantity in SI needs a unit with the numbers.

{vocabulary}"""


@command(
    _about,
    """\
  percuss sweep hydraulic-drifter --x restitution=0:0.9:90 --y load_factor=0.1:1:90 --plot map.png
  percuss sweep case.toml --x frequency="20 Hz:80 Hz:61" --quantity blow_energy,stable,label --csv map.csv
  percuss sweep laboratory-striker --x "rock.stiffness=50:400 kN/mm:36" --quantity rock_efficiency,peak_stress
  percuss sweep valve-breaker --x "pressure=100:200 bar:50" --y "ports[0].behind=60:200 mm:50" --plot map.png
  percuss sweep case.toml --x restitution=0:0.9:200 --y load_factor=0.01:1:200 --quantity label -o map.zarr
  percuss sweep case.toml --x restitution=0:0.9:200 --y load_factor=0.01:1:200 --quantity label -o map.zarr --resume""",
    CASE,
    option("--x RANGE", "a parameter and its values: restitution=0:0.9:200", required=True),
    option("--y RANGE", "a second parameter, for a plane"),
    option(
        "--quantity NAMES",
        "what to compute, separated by commas (default: exists,orbits,phase,reduced_stable,stable,margin, of a valve "
        "stall,blow_energy,rate,stroke)",
        names,
    ),
    option("--periods M", "load periods per impact (default 1)", periods, default=(1,)),
    option(
        "--modes N",
        f"elastic modes for every quantity, 0 to {MAX_MODES} (default: steady motions of the continuous bar with "
        "multipliers of 32 modes; simulations with the case's, or 32)",
        modes,
    ),
    option("--impacts N", "the most impacts per simulation (default: the case's, or 2000)", whole()),
    option("--curves", "also solve for the curves at which motions or their stability end, over --x and --y"),
    option(
        "--overlay FILE",
        "draw curves over the same two parameters into --plot: an answer of 'percuss follow … --curve … --json'",
    ),
    option("--json", "print the map as JSON"),
    csv_option("write the map as a table, a line for each cell, to open in other programs"),
    plot_option("the map"),
    *CARRYING,
)
def sweep(parser: Parser, options: argparse.Namespace) -> int:
    from percuss import plot
    from percuss.case import sweep_job_of
    from percuss.case.answers.exploring.exploration import sweep_dict, sweep_report
    from percuss.case.answers.exploring.point_curves_answer import laid_curves
    from percuss.cli.report_printing import answered
    from percuss.explore import Axis, Sweep

    if len(options.periods) > 1:
        parser.error("argument --periods: one number; to compare several, make m an axis: --y m=1,2,3")
    if options.curves and options.y is None:
        parser.error("argument --curves: boundaries lie in a plane: give --y too")
    laid: Any = ()
    if options.overlay is not None:
        if options.plot is None or options.y is None:
            parser.error("argument --overlay: curves are drawn into the picture of a plane: give --y and --plot too")
        try:
            content = Path(options.overlay).read_bytes()
        except OSError as error:
            raise ParameterError("overlay", options.overlay, "a file that can be read", str(error)) from None
        laid = laid_curves(options.overlay, content)
    case = named_case(options.case)
    axes = [Axis.parsed(text) for text in (options.x, options.y) if text is not None]
    asked = {"periods": options.periods[0], "modes": options.modes, "impacts": options.impacts}
    job = sweep_job_of(case, axes, options.quantity, **asked)
    if options.curves:
        if case.is_machine:
            parser.error(
                "argument --curves: boundaries are those of a load that keeps time; ask for stall to see what stops"
            )
        from percuss.explore.boundary_curves.boundary import checked_boundaries

        checked_boundaries(job.family, **_boundaries(job))
    found = Sweep.shaped(job, carried(parser, options, job))
    curves = _curves(parser, job) if options.curves else None
    return answered(
        options,
        lambda: sweep_dict(case, found, curves),
        lambda: sweep_report(case.title, found, curves, _ranges(job, found), case.notes),
        lambda: plot.sweep(found, case.title, [*(curves.curves if curves else ()), *laid]),
        dataset=found.to_xarray,
        map=options.output,
    )


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


def _ranges(job: SweepJob, found: Any) -> dict[str, Any]:
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


# ---- Random starts, and a plane of starts

_IMPACTS = option("--impacts N", "the most impacts per start (default: the case's, or 2000)", whole(1))
_MODES = modes_option("default: the case's, or 32")


@command(
    """\
Random starts, each followed until its motion is found: the share that ends in each motion, with 95 % intervals.
The same seed gives the same numbers on any machine with any number of workers.

distributions: wall, on the wall, leaving with |N(0, 1)| times the speed of one impact per load period; field, up to
20 bar lengths off the wall, velocity 5 N(0, 1); gentle, on the wall, leaving with 0 to 0.2; each at any load phase. Or
a file of starts: CSV, .npz or .nc with columns among position, velocity and time, or u_0, u_1, …, v_0, v_1, …, time.

Of a machine that switches its own valve: which starts run and which stall. Its starts have a state of the valve, at
random or the column state of a file, and no load phase. S is the distance of the farthest port, V = sqrt(2 S times the
difference of the valve's greatest and least acceleration): wall, leaving with |N(0, 1)| V; field, up to 2 S off the
wall, velocity V N(0, 1); gentle, on the wall, leaving with 0 to V/20.""",
    """\
  percuss experiment hydraulic-drifter --starts 1000
  percuss experiment case.toml --starts 100000 --distribution field --seed 1 --modes 0 -o starts.zarr
  percuss experiment case.toml --starts 1000000 --modes 0 -o starts.zarr --resume --workers 8
  percuss experiment valve-breaker --starts 1000 --distribution field
  percuss experiment case.toml --distribution mine.csv --json""",
    CASE,
    option("--starts N", "how many (default: 100000, or all of a file)", whole(1)),
    option("--distribution NAME", "wall, field, gentle or a FILE of starts (default wall; structures: field)"),
    option("--seed S", "seed of the random numbers (default 0)", whole(), default=0),
    _MODES,
    _IMPACTS,
    option("--json", "print the shares as JSON"),
    plot_option("the shares and the starts"),
    *CARRYING,
)
def experiment(parser: Parser, options: argparse.Namespace) -> int:
    from percuss.case import experiment_job_of
    from percuss.explore.attractors.experiments import carried_experiment

    case = named_case(options.case)
    asked = {"modes": options.modes, "impacts": options.impacts}
    job = experiment_job_of(case, options.starts, options.distribution, options.seed, **asked)
    with carrying(parser, options) as running:
        found = carried_experiment(job, **running)
    return _starts(options, case, "experiment", found)


_WITH_UNIT = re.compile(r"\s*[-+−]?\.?\d")


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


@command(
    """\
A plane of starts, each followed until its motion is found: the basins of attraction as an image. The axes are two of
position (of the striking end, the wall is at 0), velocity and time (load phase in radians), or modal amplitudes u_1,
u_2, …, v_1, v_2, …; all dimensionless, and 0 unless given. For a case in SI, position, velocity and time may
have units; the axes of the result are dimensionless even then. A machine that switches its own valve has no load phase;
--at state=NAME is the state of the valve at the start (default: its own starting state).""",
    """\
  percuss basins hydraulic-drifter --x "time=0:16.6 ms:200" --y "velocity=-12:0 m/s:150" --modes 0 --plot basins.png
  percuss basins mini-breaker --x time=0:6.28:80 --y velocity=-6:-0.1:60 --at position=-0.5
  percuss basins valve-breaker --x "position=-300:-5 mm:60" --y "velocity=-15:15 m/s:60" --at state=power --modes 0
  percuss basins case.toml --x velocity=-5:5:300 --y position=-5:0:300 --at time=1.5 -o basins.zarr""",
    CASE,
    option("--x RANGE", "the horizontal axis: time=0:6.28:200", required=True),
    option("--y RANGE", "the vertical axis: velocity=-6:0:150", required=True),
    option("--at VALUES", "what all starts share: position=-1,time=0.3", _values, default={}),
    _MODES,
    _IMPACTS,
    option("--json", "print the image and its attractors as JSON"),
    plot_option("the image"),
    *CARRYING,
)
def basins(parser: Parser, options: argparse.Namespace) -> int:
    from percuss.case import basins_job_of
    from percuss.explore import Axis, Basins

    case = named_case(options.case)
    asked = {"at": options.at, "modes": options.modes, "impacts": options.impacts}
    job = basins_job_of(case, Axis.parsed(options.x), Axis.parsed(options.y), **asked)
    return _starts(options, case, "basins", Basins.of(job, carried(parser, options, job)))


def _starts(options: argparse.Namespace, case: Case, kind: str, found: Any) -> int:
    """The answer on where starts end."""
    from percuss import plot
    from percuss.case.answers.exploring import exploration
    from percuss.cli.report_printing import answered

    return answered(
        options,
        lambda: getattr(exploration, f"{kind}_dict")(case, found),
        lambda: getattr(exploration, f"{kind}_report")(case.title, found),
        lambda: getattr(plot, kind)(found, case.title),
        **{kind: options.output},
    )
