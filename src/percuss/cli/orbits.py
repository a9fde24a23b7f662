"""Orbits with any number of impacts: searched for, followed through a parameter, and as a diagram of all motions."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from percuss.cli.arguments import (
    CASE,
    NETCDF,
    Parser,
    command,
    csv_option,
    made,
    modes_option,
    named_case,
    names,
    option,
    orbit_label,
    plot_option,
    whole,
)
from percuss.cli.long_commands import CARRYING, SELDOM, carrying, watching
from percuss.errors import Interrupted

if TYPE_CHECKING:
    from percuss.steady import FoundOrbits

_SEED = option("--seed N", "of the random starts (default 0)", whole(), default=0)


@command(
    """\
The orbits z=p/n of a hammer: its periodic motions with p impacts in n load periods, stable and unstable, found without
a guess; of a machine whose piston switches the valve p/n, with p blows in n cycles of the valve. Of one impact in a
cycle under a clock, and of two of a rigid bar, they are proved to be all there are; of more, those that a search finds
from simulated motions and from random times, with an estimate of the share of random times that lead to others. Each is
proved to stay off the wall between its impacts, and of a machine to do nothing else in between. Cycles in which the bar
comes to rest on the wall, at the end of complete chatter or without restitution, are chatter/n and rest/n: all of them
are found. All numbers are dimensionless: phases of the load in rad, speeds in the scales of the case. After Ctrl-C the
answer is what has been found so far.""",
    """\
  percuss orbits pneumatic-jackleg --label 2/1
  percuss orbits case.toml --label 1/1 --up-to 3/2 --modes 0
  percuss orbits case.toml --label 3/2 --tries 5000 --json
  percuss orbits pneumatic-jackleg --label chatter/1
  percuss orbits valve-breaker --up-to 2/2 --modes 4""",
    CASE,
    option(
        "--label P/N",
        "impacts and periods of a cycle, of the load or the valve, or chatter/N or rest/N with rest (default 1/1)",
        orbit_label,
        default="1/1",
    ),
    option(
        "--up-to P/N",
        "also all labels with more impacts or periods, up to these, and the cycles with rest of as many periods",
        orbit_label,
    ),
    modes_option("default: the case's, or 32"),
    option("--tries N", "random starts for each label (default 400)", whole(), default=400),
    option(
        "--motions N",
        "motions simulated to start from where they nearly come back (default 64; 0 for none)",
        whole(),
        default=64,
    ),
    option(
        "--switch",
        "start also from what begins at flips, and of rigid bars at grazings, of shorter orbits followed through the "
        "mean load",
    ),
    _SEED,
    option("--json", "print the orbits as JSON"),
)
def orbits(parser: Parser, options: argparse.Namespace) -> int:
    from percuss.case import orbits_answer
    from percuss.case.answers.exploring.orbits_answer import (
        is_rest_label,
        orbits_dict,
        orbits_report,
        parsed_label,
        rest_cycles_answer,
        rest_cycles_dict,
        rest_report,
    )
    from percuss.case.answers.facts import counted
    from percuss.cli.report_printing import answered
    from percuss.halting import halting

    case = named_case(options.case)
    if any(is_rest_label(label) for label in (options.label, options.up_to or "")) and options.up_to is not None:
        parser.error(
            "argument --up-to: give the label of cycles with rest alone; up to an orbit P/N they are listed, too"
        )
    if is_rest_label(options.label) and not case.is_machine:
        cycles, label = rest_cycles_answer(case, modes=options.modes), options.label
        return answered(
            options, lambda: rest_cycles_dict(cycles, label), lambda: rest_report(case.title, cycles, label), indent=1
        )
    labels, last = [options.label], (0, 0)
    if options.up_to is not None:
        first, last = parsed_label(options.label), parsed_label(options.up_to)
        if last[0] < first[0] or last[1] < first[1]:
            parser.error(f"argument --up-to: '{options.up_to}': at least the impacts and periods of --label")
        labels = [f"{p}/{n}" for n in range(first[1], last[1] + 1) for p in range(first[0], last[0] + 1)]
    asked = {name: getattr(options, name) for name in ("modes", "tries", "seed", "motions", "switch")}
    found: list[FoundOrbits] = []
    resting = None
    with watching(parser, SELDOM) as watch:
        for label in labels:
            with suppress(Interrupted):
                found.append(orbits_answer(case, label, **asked, progress=watch.asked))
            if watch.interrupted:
                break
        free = not case.is_machine and case.system().body.is_free
        if options.up_to is not None and free and not watch.interrupted:
            with suppress(Interrupted), halting(watch.asked):
                resting = rest_cycles_answer(case, modes=options.modes, most=last[1])
    if not found:
        raise KeyboardInterrupt
    rests = (
        []
        if resting is None
        else sorted({cycle.label for cycle in resting if cycle.periods >= parsed_label(options.label)[1]})
    )

    def data() -> Any:
        answers = [orbits_dict(one) for one in found]
        answers += [] if resting is None else [rest_cycles_dict(resting, label) for label in rests]
        return answers if options.up_to is not None else answers[0]

    mode = "elastic mode" if case.tables.body is None else "mode"
    done = f"the search is done for {sum(not one.interrupted for one in found)} of {counted(len(labels), 'label')}"
    return answered(
        options, data, lambda: orbits_report(case.title, found, resting, rests, mode), indent=1,
        cut=done if watch.interrupted else "",
    )  # fmt: skip


# ---- An orbit followed through a parameter


@command(
    """\
An orbit followed through a parameter, both ways from the value of the case, round folds, until something ends it: the
bar touches the wall between two impacts, an impact dies, the range ends. Folds, flips, pairs of multipliers on the unit
circle and corners at steps of the load are located to 1e-10, and of each it is said what lies beyond. The orbit is a
number in the list of 'percuss orbits', or one near the phases of its impacts, in order of time; or a cycle with rest,
which is followed to where its chatter meets the next release or it ends otherwise. With --curve points of the branch
are followed themselves, through its parameter and the one of --over: the curves in their plane at which motions or
their stability begin and end. A range that does not hold the value of the case begins at its end that is nearest to it.
Of a hammer whose piston switches its own valve the ends are also where two events of the valve exchange their order,
where the piston turns just at a port, and where the pressure of its pump is gone. After Ctrl-C the answer is what has
been followed so far.""",
    """\
  percuss follow pneumatic-jackleg --orbit 1/1 --along load_factor=0.3:1.2
  percuss follow case.toml --orbit 1/1:2 --along mean=0.5:1 --switch 4 --modes 0 --plot cascade.png
  percuss follow case.toml --orbit 2/1:phases=0.39,2.32 --along restitution=0:0.9 -o branch.csv
  percuss follow laboratory-striker --orbit chatter/1:1 --along load_factor=0.3:1.2 --modes 0
  percuss follow case.toml --orbit chatter/1 --along mean=0.3:1.2 --curve onset --over restitution=0:0.9 --modes 0
  percuss follow case.toml --orbit 2/1:2 --along mean=0.3:1.2 --curve flip,fold --over restitution=0:0.9 --json""",
    CASE,
    option("--orbit ORBIT", "where to begin: 2/1:3, 2/1:phases=1.2,4.5 or chatter/1:1 (default 1/1:1)", default="1/1"),
    option(
        "--along RANGE",
        "a parameter and its range: load_factor=0.3:1.2; without a range the motion is followed to its ends",
        required=True,
    ),
    option(
        "--switch DEPTH",
        "go on so often at flips to the doubled orbit, and of a rigid bar at grazings to that with an impact more or "
        "less (default 0)",
        whole(),
        default=0,
    ),
    option(
        "--curve POINTS",
        "also follow points through two parameters: flip, the first flip, fold:2, the second fold, several with commas "
        "between them, or all; of a cycle with rest onset, touch, death or release_lost",
    ),
    option("--over RANGE", "the second parameter, with or without a range: restitution=0:0.9"),
    modes_option("default: the case's, or 32"),
    option("--json", "print the branches as JSON"),
    plot_option("the branches"),
    made("-o, --output FILE", "write the branches, or the curves, as a table, .csv", (".csv",)),
)
def follow(parser: Parser, options: argparse.Namespace) -> int:
    from percuss import plot
    from percuss.atomic_write import write_whole
    from percuss.case import branch_answer, point_curves_answer
    from percuss.case.answers.exploring.orbits_answer import begun_at, branch_dict, branch_report, branch_table
    from percuss.case.answers.exploring.point_curves_answer import point_curves_table
    from percuss.cli.report_printing import answered

    if (options.curve is None) != (options.over is None):
        parser.error("arguments --curve and --over: points are followed through two parameters: give both")
    along, over = ((text or "").partition("=")[0].strip() for text in (options.along, options.over))
    case = named_case(options.case)
    curves: Any = ()
    of_curves = options.curve is not None and along != over  # over its own parameter a point stays where it is
    with watching(parser, SELDOM) as watch:
        try:
            asked: dict[str, Any] = {"switch": options.switch, "modes": options.modes, "progress": watch.asked}
            branch = branch_answer(case, options.orbit, options.along, **asked)
        except Interrupted:  # before the first point of the branch
            raise KeyboardInterrupt from None
        if of_curves and not watch.asked():
            curves = point_curves_answer(case, branch, options.curve, options.along, options.over, progress=watch.asked)
    begun = begun_at(case, options.along)
    if options.output is not None:  # of curves also where Ctrl-C has left none of them
        write_whole(options.output, point_curves_table(curves) if of_curves else branch_table(branch))
    return answered(
        options,
        lambda: branch_dict(branch, curves, begun),
        lambda: branch_report(case.title, branch, curves, begun, over if along == over else ""),
        lambda: plot.curves(curves, case.title) if curves else plot.branch(branch, case.title),
        table=options.output,
        cut="the answer is of what was followed until then" if watch.interrupted else "",
    )


# ---- All motions over one parameter

_SIZES = ("searched", "switch", "tries", "starts", "runs", "modes", "seed")


def _shown(text: str) -> tuple[str, ...]:
    found = names(text)
    wrong = [name for name in found if name not in ("phase", "speed", "energy")]
    if wrong:
        raise argparse.ArgumentTypeError(f"'{wrong[0]}': give some of phase, speed, energy")
    return found


@command(
    """\
All motions of a hammer over one parameter: what simulations settle on, from many starts and up and down the parameter,
as points; orbits searched for up to a label, stable and unstable, followed through the whole range and on at flips and
grazings, as lines; what happens on them, as marks. After Ctrl-C the answer is what has been found so far.""",
    """\
  percuss diagram pneumatic-jackleg --along load_factor=0.3:1.2 --plot diagram.png
  percuss diagram case.toml --along "frequency=40 Hz:80 Hz:40" --label 1/1 --show speed,energy --plot diagram.svg
  percuss diagram case.toml --along restitution=0:0.9:40 --modes 0 -o diagram.zarr --csv diagram.csv
  percuss diagram case.toml --along restitution=0:0.9:40 --modes 0 -o diagram.zarr --resume""",
    CASE,
    option(
        "--along RANGE",
        "a parameter and its range, load_factor=0.3:1.2; with the number of values to simulate behind it, if not 120",
        required=True,
    ),
    option(
        "--label P/N",
        "search for orbits with up to so many impacts and load periods (default 3/3)",
        orbit_label,
        default="3/3",
    ),
    option(
        "--switch DEPTH",
        "go on so often at flips to the doubled orbit, and of a rigid bar at grazings to that with an impact more or "
        "less (default 2)",
        whole(),
        default=2,
    ),
    option("--searched N", "values at which orbits are searched for (default 5)", whole(), default=5),
    option("--tries N", "random starts of each search (default 100)", whole(), default=100),
    option("--starts N", "simulations from random starts at each value (default 8)", whole(), default=8),
    option(
        "--runs N",
        "motions that are taken along, up and down the values, each simulation from where the one before ended "
        "(default 6)",
        whole(),
        default=6,
    ),
    modes_option("default: the case's, or 32"),
    _SEED,
    option("--json", "print the diagram as JSON"),
    csv_option("write points and branches as a table, a line for each impact"),
    made("--netcdf FILE", "write points and branches as a NetCDF file, .nc", (".nc",), NETCDF),
    plot_option("the diagram"),
    option(
        "--show NAMES",
        "what the picture shows: some of phase,speed,energy (default phase,speed)",
        _shown,
        default=("phase", "speed"),
    ),
    *CARRYING,
)
def diagram(parser: Parser, options: argparse.Namespace) -> int:
    from percuss import plot
    from percuss.case import diagram_job_of
    from percuss.case.answers.exploring.diagram_answer import diagram_dict, diagram_report
    from percuss.cli.report_printing import answered
    from percuss.explore.diagrams.diagram import Diagram, carried_diagram

    case, code = named_case(options.case), 0
    asked = {name: getattr(options, name) for name in _SIZES}
    job = diagram_job_of(case, options.along, up_to=options.label, **asked)
    try:
        with carrying(parser, options) as running:
            found = carried_diagram(job, **running)
    except Interrupted as stop:
        if not isinstance(stop.partial, Diagram) or not stop.done:
            raise
        print(f"\npercuss: {stop}", file=sys.stderr)
        found, code = stop.partial, 130
    mode = "elastic mode" if case.tables.body is None else "mode"
    answered(
        options, lambda: diagram_dict(case, found), lambda: diagram_report(case.title, found, mode),
        lambda: plot.diagram(found, case.title, options.show), dataset=found.to_xarray, diagram=options.output,
    )  # fmt: skip
    return code
