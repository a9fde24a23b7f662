"""``percuss simulate``: how a hammer moves from a start, impact by impact."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, NoReturn

from percuss.cli.arguments import (
    MAX_MODES,
    PICTURES,
    Parser,
    check_not_the_case,
    check_picture,
    check_target,
    events,
    modes,
    named_case,
    need,
    of_file,
    start_keys,
    time_or_text,
    up_to,
    whole,
)
from percuss.errors import CaseError

if TYPE_CHECKING:
    import argparse

    from percuss.case import Case, SimulationAnswer

_DESCRIPTION = """\
How a hammer moves from a start: every impact, chatter, rest and release, and what motion it settles on. The tables
[start] and [simulation] of the case hold the same settings as the options; options take precedence."""

_EXAMPLES = """\
  percuss simulate mini-breaker
  percuss simulate case.toml --start position=-1,velocity=0,time=0.3 --impacts 2000
  percuss simulate case.toml --start random --seed 7 --json > run.json
  percuss simulate case.toml --start orbit:2 -o run.nc --plot run.png
  percuss simulate heavy-drifter --contact waves
  percuss simulate valve-breaker -o breaker.nc --plot breaker.png
  percuss simulate --resume run.nc --impacts 5000 -o longer.nc"""

_START = """\
keys of [start]: position=-1,velocity=0,time=0.3 (plain numbers are dimensionless; with units for a case in SI:
position='-3 cm'), orbit:K for steady motion number K of 'percuss steady' (orbit:K,velocity=0.01: disturbed),
random, random:still or random:ringing"""

LEAST_CELLS, MOST_CELLS = 16, 100_000

LAST = 10
"""Events in the report for people."""


def _parser() -> Parser:
    parser = Parser("simulate", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", nargs="?", help="a TOML file, '-' for standard input, or a machine's name")
    add("--impacts", metavar="N", type=whole, help="end after N impacts (default 2000)")
    add("--time", metavar="T", type=time_or_text, help="end after T radians of the load, or '2 s' for a case in SI")
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 (a rigid bar) to {MAX_MODES} (default 32)")
    add("--start", metavar="START", type=start_keys, help=_START)
    add(
        "--contact",
        choices=("law", "waves"),
        default="law",
        help="'law' (default): the law of [contact]; 'waves': every contact resolved by waves, beside the law's motion",
    )
    add("--cells", metavar="N", type=up_to(MOST_CELLS), help="with waves: cells of the bar, 16 or more (default 400)")
    add("--quiet", action="store_true", help="with waves: all ringing ends between blows")
    add("--seed", metavar="S", type=whole, help="seed of a random start (default 0)")
    add("--full", action="store_true", help="keep going after a periodic motion is found")
    add("--resume", metavar="FILE", help="continue the motion that -o saved; N and T count from its start")
    add("--json", action="store_true", help="print the answer as JSON")
    add("--events", metavar="WHICH", type=events, help="all, last:K or none (default: all in JSON, else last:10)")
    add("-o", "--output", metavar="FILE", help="save the motion as NetCDF, for xarray and for --resume")
    add("--plot", metavar="FILE", help=f"draw the motion: {', '.join(PICTURES)}")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Simulate one case; returns the exit code, 130 when the simulation was interrupted."""
    parser = _parser()
    options = parser.parsed(arguments)
    _check(parser, options)
    if options.contact == "waves":
        return _by_waves(parser, options)
    case = None if options.resume is not None else _case(parser, options)
    answer = _resumed(options) if case is None else _answered(case)
    return _told(options, answer)


def _told(options: argparse.Namespace, answer: SimulationAnswer) -> int:
    """The answer written and printed."""
    from percuss import plot
    from percuss.case.answers.simulation_answer import motion_report
    from percuss.cli.report_printing import answered

    if options.output is not None:
        answer.motion.save(options.output)
    last = LAST if options.events is None else options.events[0]
    shown = None if options.events is None else last
    drawn = plot.trajectory if answer.motion.is_clocked else plot.machine_motion
    answered(
        options, lambda: answer.to_json_text(shown), lambda: motion_report(answer, last), lambda: drawn(answer),
        motion=options.output,
    )  # fmt: skip
    return 130 if answer.motion.outcome == "cancelled" else 0


def _by_waves(parser: Parser, options: argparse.Namespace) -> int:
    """The motion with every contact resolved by waves."""
    from percuss.case import waves_answer
    from percuss.case.answers.waves_answer import waves_report
    from percuss.cli.report_printing import answered
    from percuss.cli.simulation_progress import watched, waves_ready

    case = _case(parser, options)
    cells = {} if options.cells is None else {"cells": options.cells}
    with watched(waves_ready) as watch, of_file(case):
        answer = waves_answer(case, watch, quiet=options.quiet, **cells)
    last = None if options.events is None else options.events[0]
    shown = LAST if options.events is None else last
    answered(options, lambda: answer.to_json_text(last), lambda: waves_report(answer, shown))
    return 130 if answer.motion.outcome == "cancelled" else 0


def _check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse what cannot be answered or written before anything is computed."""
    if options.contact == "waves":
        for name in ("resume", "modes", "output", "plot"):
            if getattr(options, name) is not None:
                parser.error(f"--{name} cannot be used with --contact waves")
        if options.cells is not None and options.cells < LEAST_CELLS:
            parser.error(f"argument --cells: '{options.cells}': give {LEAST_CELLS} or more")
    elif options.cells is not None or options.quiet:
        parser.error(f"--{'quiet' if options.quiet else 'cells'} is for --contact waves")
    if options.resume is not None:
        for name in ("case", "start", "modes", "seed"):
            if getattr(options, name) is not None:
                parser.error(
                    f"{'CASE' if name == 'case' else f'--{name}'} cannot be used with --resume: the file has it"
                )
        _need_netcdf()
    elif options.case is None:
        parser.error("the following arguments are required: CASE (or --resume FILE)")
    if options.output is not None:
        check_target(parser, "-o", options.output)
        if options.case is not None:
            check_not_the_case(parser, options.output, options.case)
        _need_netcdf()
    if options.plot is not None:
        check_picture(parser, options.plot)
        if options.output is not None and os.path.abspath(options.output) == os.path.abspath(options.plot):
            parser.error("argument --plot: the picture and the motion (-o) need different names")


def _need_netcdf() -> None:
    for package in ("xarray", "h5netcdf"):
        need(package, "io")


def _answered(case: Case) -> SimulationAnswer:
    from percuss.case import simulation_answer
    from percuss.cli.simulation_progress import law_ready, machine_ready, watched

    with watched(machine_ready if case.is_machine else law_ready) as watch, of_file(case):
        return simulation_answer(case, watch)


def _case(parser: Parser, options: argparse.Namespace) -> Case:
    """The case with what the options say."""
    case = named_case(options.case)
    if not case.is_machine or options.contact == "waves":
        case.system()  # the recording is read, and may be refused, before the options are looked at
    try:
        return _changed(case, options)
    except CaseError as error:
        _as_option(parser, error)


def _resumed(options: argparse.Namespace) -> SimulationAnswer:
    from percuss.case import resumed_answer
    from percuss.cli.simulation_progress import watched

    with watched() as watch:
        return resumed_answer(options.resume, options.impacts, options.time, watch)


def _changed(case: Case, options: argparse.Namespace) -> Case:
    """The case with what the options say in place of its tables."""
    start = options.start
    if options.seed is not None:
        given = case.to_dict().get("start") or {}
        start = {**(given if start is None else start), "seed": options.seed}
    wanted = {name: getattr(options, name) for name in ("modes", "impacts", "time")}
    simulation = {name: value for name, value in wanted.items() if value is not None}
    if options.full:
        simulation["periodic"] = False
    return case.changed(start, simulation or None)


def _as_option(parser: Parser, error: CaseError) -> NoReturn:
    """A refusal of a table of the case, told of the option that said so."""
    first = getattr(error, "problems", (error,))[0]
    table, _, name = first.key.partition(".")
    remedy = f" — {first.remedy}" if first.remedy else ""
    option = f"--start: {name} =" if table == "start" else f"--{name}:"
    parser.error(f"argument {option} {first.value!r}: {first.accepted}{remedy}")
