"""What one hammer does: its steady motions, the cycle of a machine that switches itself, and simulated motions."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from percuss.cli.arguments import (
    CASE,
    JSON,
    NETCDF,
    NO_PLAUSIBILITY,
    Parser,
    command,
    events,
    made,
    modes_option,
    named_case,
    names,
    need,
    of_file,
    option,
    periods,
    plot_option,
    report_options,
    start_keys,
    time_or_text,
    whole,
)
from percuss.errors import CaseError, HistoryError, PercussError
from percuss.units import si

if TYPE_CHECKING:
    import argparse

    from matplotlib.figure import Figure

    from percuss.case import Case, MachineAnswer, RecordedAnswer
    from percuss.case.answers.facts import Report
    from percuss.case.answers.steady_answer import CaseReach, Ends
    from percuss.case.answers.whole_hammer import FigureUncertainty
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle

MAX_STARTS = 1000


@command(
    """\
Every steady motion with one impact per m load periods: whether it is possible, whether it is stable and by what
margin, and what it means in joules, hertz, metres per second and megapascals. After Ctrl-C while --reach moves the
parameters, the answer has those that are done. A hammer whose piston switches its own valve is answered for as by
'percuss machine'.""",
    """\
  percuss steady hydraulic-drifter
  percuss steady case.toml --periods 1..3 --plot case.png
  percuss steady hydraulic-drifter --report drifter.html
  percuss steady heavy-drifter --reach
  percuss steady mini-breaker --reach-of load.mean,load.frequency --report drifter.html
  percuss steady case.toml --json > answer.json""",
    CASE,
    option("--periods M", "load periods per impact: 2, 1..4 or 1,3 (default 1)", periods, default=(1,)),
    modes_option(
        "default: as many as the tolerance needs, and 32 for the multipliers",
        "elastic modes in sums and multipliers, 0 to",
    ),
    option(
        "--starts N",
        f"random starts to follow, up to {MAX_STARTS}; 0 for none, which is quicker (default: 24 once the simulator is "
        "compiled on this computer, none with --json)",
        whole(0, MAX_STARTS, " ('percuss experiment' follows more)"),
    ),
    option(
        "--reach", "also how far the load and other parameters may move before the motion is lost, and what comes then"
    ),
    option("--reach-of NAMES", "the same of these parameters of 'percuss sweep', separated by commas", names),
    NO_PLAUSIBILITY,
    JSON,
    plot_option("the answer"),
    *report_options(),
)
def steady(parser: Parser, options: argparse.Namespace) -> int:
    """Answer for one case; a machine that switches itself has an answer of its own."""
    from percuss import plot
    from percuss.case.answers.steady_report import steady_report
    from percuss.cli.report_printing import answered, filed

    case, cut = named_case(options.case), ""
    reaches = options.reach or options.reach_of is not None
    if case.is_machine:
        from percuss.case import machine_answer

        _refuse(parser, options, "a hammer whose piston switches its own valve", _NOT_OF_MACHINES)
        with of_file(case):
            machine = replace(machine_answer(case, options.modes), uncertainty=_uncertainty(case, options.modes))
            if reaches:
                cycle = (
                    machine.cycle if machine.runs and machine.cycle is not None and not machine.cycle.rests else None
                )
                rows, cut = _reached(parser, options, case, cycle)
                machine = replace(machine, reach=rows)
            return _told_machine(options, case, machine, cut=cut)
    from percuss.case import steady_answer

    held = case.tables.body is not None
    if held:
        _refuse(parser, options, "a structure that is held", _NOT_OF_STRUCTURES)
    with _undisturbed(), of_file(case):
        answer = steady_answer(case, options.periods, options.modes)
        answer = replace(answer, plausibility=not options.no_plausibility)
        if answer.running:
            answer = replace(answer, uncertainty=_uncertainty(case, options.modes, answer.running[0].orbit.periods))
        answer = answer if held else replace(answer, starts=_ends(case, options))
    if reaches:
        chosen = answer.chosen
        stable = chosen is not None and chosen.orbit.admissible and chosen.stability.stable
        rows, cut = _reached(parser, options, case, chosen.orbit if chosen is not None and stable else None)
        answer = replace(answer, reach=rows)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, lambda: steady_report(answer), lambda: plot.steady(answer), indent=1, cut=cut,
        report=options.report,
    )  # fmt: skip


def _uncertainty(case: Case, modes: int | None, periods: int = 1) -> FigureUncertainty | None:
    """What the ± of its numbers leaves of the figures of a case that has some."""
    if not case.uncertain:
        return None
    from percuss.case import uncertainty_of

    return uncertainty_of(case, modes, periods)


_NOT_OF_STRUCTURES = {
    "starts": "'percuss experiment' follows its starts",
}
_NOT_OF_MACHINES = {
    "starts": "'percuss experiment' follows its starts",
    "periods": "it has no load period, its rhythm is its own",
}
"""Options that have no meaning for a kind of hammer, and what to ask instead."""


def _refuse(parser: Parser, options: argparse.Namespace, kind: str, without: dict[str, str]) -> None:
    for name, instead in without.items():
        if getattr(options, name) not in (None, False, 0, (1,)):
            parser.error(f"argument --{name.replace('_', '-')}: not for {kind}: {instead}")


def _reached(
    parser: Parser, options: argparse.Namespace, case: Case, orbit: Orbit | ValveCycle | None
) -> tuple[tuple[CaseReach, ...], str]:
    """How far parameters may move; after Ctrl-C of as many as are known, and of how many that is."""
    from percuss.case.answers.exploring.reach_answer import reach_answer, varied_parameters
    from percuss.cli.long_commands import SELDOM, watching

    wanted = varied_parameters(case, options.reach_of)  # which refuses what is unknown
    if orbit is None:
        return (), ""
    with watching(parser, SELDOM) as watch:
        found = reach_answer(case, orbit, options.reach_of, modes=options.modes, progress=watch.asked)
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


def _ends(case: Case, options: argparse.Namespace) -> Ends:
    """Random starts; without being asked only where the simulator need not be compiled first."""
    from percuss.case.answers.facts import as_typed
    from percuss.case.answers.steady_answer import STARTS, ends_of, not_followed

    starts = 0 if options.json and options.starts is None else options.starts
    if starts == 0:
        return not_followed("none were asked for")
    from percuss.compiled import is_compiled  # loads the compiler
    from percuss.simulate.kernels.motion import follow

    if not is_compiled(follow):
        if starts is None:
            return not_followed(
                "the simulator has not been compiled on this computer yet; "
                f"'percuss steady {as_typed(case.file)} --starts {STARTS}' does it, and is quick from then on"
            )
        print("percuss: compiling the simulator once, about 20 s", file=sys.stderr, flush=True)
        gc.enable()  # compiling leaves many cycles
    return ends_of(case, STARTS if starts is None else starts, options.modes)


# ---- The report on a hammer: its motion, how far it may be moved, its blow and its fatigue in one file


@command(
    """\
The report on a hammer, of any kind, as one file to print and sign, HTML or PDF: on the first page the answer, a drawing
of bar and tool to scale, the few figures that matter, how far load and sizes may move before it stops, and what is
assumed; then its blow by waves and the fatigue of its steel, where it has a tool; then all figures, and the case.""",
    """\
  percuss report valve-drifter -o drifter.html
  percuss report breaker.toml -o breaker.pdf --paper letter --no-reach""",
    CASE,
    modes_option("default: those of 'percuss steady'"),
    option("--no-reach", "leave out how far parameters may move, which takes most of the time"),
    NO_PLAUSIBILITY,
    *report_options("-o, --output FILE", required=True),
)
@_undisturbed()
def report(parser: Parser, options: argparse.Namespace) -> int:
    """Answer, blow and fatigue of one case as a file."""
    from percuss.case import MachineAnswer
    from percuss.case.answers.reported import reported_answers
    from percuss.cli.report_printing import filed

    case, cut = named_case(options.case), ""
    options.reach_of = None
    with of_file(case):
        if case.is_si and case.tables.tool is not None:
            need("io", "rainflow")
        answer, blow = reported_answers(case, options.modes)
        answer = replace(answer, plausibility=not options.no_plausibility)
        whole = answer.whole
    rests = isinstance(answer, MachineAnswer) and answer.cycle is not None and bool(answer.cycle.rests)
    if whole.runs and not (options.no_reach or rests):
        rows, cut = _reached(parser, options, case, whole.motion)
        answer = replace(answer, reach=rows)
    filed(options.output, options, case, answer, blow)
    print(f"report: {options.output}")
    if cut:
        print(f"percuss: interrupted: {cut}", file=sys.stderr)
    return 130 if cut else 0


# ---- A machine that switches its own valve, or a recorded load read as one

_OF_A_RECORD = ("blow", "blows", "longest_delay")


@command(
    """\
How a hammer runs whose piston switches its own valve ([load] of the kind "valve"): blow energy, rate, stroke, oil flow
and power, stability, margins, and how they follow pressure, ports and delays. No clock drives it, so that there is no
phase. A recording, or steps of a load, are read as the force of such a machine: its ports and delays, by where the
piston is as the force switches, its cycle, and the verdict with the valve beside that under a clock.""",
    """\
  percuss machine valve-breaker
  percuss machine valve-drifter --plot drifter.png
  percuss new valve-breaker -o breaker.toml
  percuss machine breaker.toml --modes 0
  percuss machine breaker.toml --json -o cycle.csv
  percuss machine recorded.toml --blows blows.txt""",
    CASE,
    modes_option("default 32", "elastic modes, 0 (a rigid piston) to"),
    NO_PLAUSIBILITY,
    JSON,
    plot_option("the answer"),
    *report_options(),
    made("-o, --output FILE", "write the cycle over time as a table, .csv", (".csv",)),
    option("--blow TIME", 'of a recorded load: when a blow was recorded, such as "12.4 ms" (on its clock)'),
    option("--blows FILE", "of a recorded load: a text file with the times of all blows in s, one in a line"),
    option("--longest-delay TIME", 'of a recorded load: the longest delay of the valve, such as "10 ms"'),
)
def machine(parser: Parser, options: argparse.Namespace) -> int:
    from percuss.case import machine_answer

    case, record = named_case(options.case), None
    with of_file(case):
        if case.is_machine or not case.is_readable:
            for name in _OF_A_RECORD:
                if getattr(options, name) is not None:
                    parser.error(f"argument --{name.replace('_', '-')}: only for a recorded load, or one of steps, "
                        f"which {case.file} has not")  # fmt: skip
            answer = replace(machine_answer(case, options.modes), uncertainty=_uncertainty(case, options.modes))
        else:
            record = read_record(case, options)
            answer = record.answer
    return _told_machine(options, case, answer, record, options.output)


def _told_machine(
    options: argparse.Namespace,
    case: Case,
    answer: MachineAnswer,
    record: RecordedAnswer | None = None,
    output: str | None = None,
    cut: str = "",
) -> int:
    """The answer for a machine, or for a record that was read as one, written and printed."""
    from percuss import plot
    from percuss.cli.report_printing import answered, filed

    answer = replace(answer, plausibility=not options.no_plausibility)
    record = None if record is None else replace(record, answer=answer)
    for warning in answer.warnings:
        print(f"percuss: warning: {warning}", file=sys.stderr)
    if output is not None:
        if answer.cycle is None:
            raise PercussError(f"{answer.name}: there is no cycle to write", "see the report without -o")
        from percuss.atomic_write import write_whole
        from percuss.case.answers.machine_figures import cycle_table

        write_whole(output, cycle_table(answer.machine, answer.cycle))

    def report() -> Report:
        if record is not None:
            from percuss.case.answers.recorded_answer import recorded_report

            return recorded_report(record)
        from percuss.case.answers.machine_answer import machine_report

        return machine_report(answer)

    told = (record or answer).to_json_dict
    filed(options.report, options, case, record or answer)
    files = {"table": output, "report": options.report}
    return answered(options, told, report, lambda: plot.machine(record or answer), indent=1, cut=cut, **files)


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


# ---- Simulated motions

LAST = 10  # events in the report for people


@command(
    """\
How a hammer moves from a start: every impact, chatter, rest and release, and what motion it settles on. The tables
[start] and [simulation] of the case hold the same settings as the options; options take precedence.""",
    """\
  percuss simulate mini-breaker
  percuss simulate case.toml --start position=-1,velocity=0,time=0.3 --impacts 2000
  percuss simulate case.toml --start random --seed 7 --json > run.json
  percuss simulate case.toml --start orbit:2 -o run.nc --plot run.png
  percuss simulate heavy-drifter --contact waves
  percuss simulate valve-breaker -o breaker.nc --plot breaker.png
  percuss simulate --resume run.nc --impacts 5000 -o longer.nc""",
    option("CASE", "a TOML file, '-' for standard input, or a machine's name", nargs="?"),
    option("--impacts N", "end after N impacts (default 2000)", whole()),
    option("--time T", "end after T radians of the load, or '2 s' for a case in SI", time_or_text),
    modes_option("default 32"),
    option(
        "--start START",
        "keys of [start]: position=-1,velocity=0,time=0.3 (plain numbers are dimensionless; with units for a case in "
        "SI: position='-3 cm'), orbit:K for steady motion number K of 'percuss steady' (orbit:K,velocity=0.01: "
        "disturbed), random, random:still or random:ringing",
        start_keys,
    ),
    option(
        "--contact",
        "'law' (default): the law of [contact]; 'waves': every contact resolved by waves, beside the law's motion",
        choices=("law", "waves"),
        default="law",
    ),
    option("--cells N", "with waves: cells of the bar, 16 or more (default 400)", whole(16, 100_000)),
    option("--quiet", "with waves: all ringing ends between blows"),
    option("--seed S", "seed of a random start (default 0)", whole()),
    option("--full", "keep going after a periodic motion is found"),
    option("--resume FILE", "continue the motion that -o saved; N and T count from its start"),
    JSON,
    option("--events WHICH", "all, last:K or none (default: all in JSON, else last:10)", events),
    made("-o, --output FILE", "save the motion as NetCDF, for xarray and for --resume", (), NETCDF),
    plot_option("the motion"),
)
def simulate(parser: Parser, options: argparse.Namespace) -> int:
    """Simulate one case; the exit code is 130 when the simulation was interrupted."""
    from percuss import plot
    from percuss.case.answers.simulation_answer import motion_report
    from percuss.cli.long_commands import watching
    from percuss.cli.report_printing import answered

    _check(parser, options)
    case = None if options.resume is not None else _asked(parser, options)
    with watching(parser, float("inf")) as watch:  # however seldom it asks, what is done is kept
        answer = _followed(options, case, lambda now: watch.share(now.fraction, f"{now.impacts} impacts"))
    if options.output is not None:
        answer.motion.save(options.output)
    last = None if options.events is None else options.events[0]
    shown = LAST if options.events is None else last
    report: Any = motion_report
    if options.contact == "waves" and case is not None and case.is_machine:
        from percuss.case.answers.blows.valve_waves_answer import valve_waves_report as report
    elif options.contact == "waves":
        from percuss.case.answers.blows.waves_answer import waves_report as report

    def drawn() -> Figure:
        if options.contact == "waves":
            return plot.by_waves(answer)
        return plot.trajectory(answer) if answer.motion.is_clocked else plot.machine_motion(answer)

    answered(options, lambda: answer.to_json_text(last), lambda: report(answer, shown), drawn, motion=options.output)
    return 130 if answer.motion.outcome == "interrupted" else 0


def _followed(options: argparse.Namespace, case: Case | None, progress: Callable[[Any], bool]) -> Any:
    """The motion of a case or, without one, of the file that is resumed."""
    from percuss.case import resumed_answer, simulation_answer

    if case is None:
        return resumed_answer(options.resume, options.impacts, options.time, progress)
    with of_file(case):
        if options.contact != "waves":
            return simulation_answer(case, progress)
        from percuss.case import valve_waves_answer, waves_answer

        cells = {} if options.cells is None else {"cells": options.cells}
        if case.is_machine:
            return valve_waves_answer(case, progress, **cells)
        return waves_answer(case, progress, quiet=options.quiet, **cells)


def _check(parser: Parser, options: argparse.Namespace) -> None:
    if options.contact == "waves":
        for name in ("resume", "modes", "output"):
            if getattr(options, name) is not None:
                parser.error(f"--{name} cannot be used with --contact waves")
    elif options.cells is not None or options.quiet:
        parser.error(f"--{'quiet' if options.quiet else 'cells'} is for --contact waves")
    if options.resume is not None:
        for name in ("case", "start", "modes", "seed"):
            if getattr(options, name) is not None:
                told = "CASE" if name == "case" else f"--{name}"
                parser.error(f"{told} cannot be used with --resume: the file has it")
        need(*NETCDF)
    elif options.case is None:
        parser.error("the following arguments are required: CASE (or --resume FILE)")
    if None not in (options.output, options.plot) and os.path.abspath(options.output) == os.path.abspath(options.plot):
        parser.error("argument --plot: the picture and the motion (-o) need different names")


def _asked(parser: Parser, options: argparse.Namespace) -> Case:
    case, start = named_case(options.case), options.start
    if not case.is_machine:
        case.system()  # the recording is read, and may be refused, before the options are looked at
    if options.seed is not None:
        given = case.to_dict().get("start") or {}
        start = {**(given if start is None else start), "seed": options.seed}
    wanted = {name: getattr(options, name) for name in ("modes", "impacts", "time")}
    simulation = {name: value for name, value in wanted.items() if value is not None}
    if options.full:
        simulation["periodic"] = False
    try:
        return case.changed(start, simulation or None)
    except CaseError as error:
        _as_option(parser, error)


def _as_option(parser: Parser, error: CaseError) -> NoReturn:
    """A refusal of a table of the case, told of the option that said so."""
    first = getattr(error, "problems", (error,))[0]
    table, _, name = first.key.partition(".")
    remedy = f" — {first.remedy}" if first.remedy else ""
    told = f"--start: {name} =" if table == "start" else f"--{name}:"
    parser.error(f"argument {told} {first.value!r}: {first.accepted}{remedy}")
