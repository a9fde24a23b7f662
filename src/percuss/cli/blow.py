"""``percuss blow``: what one blow of a hammer does, resolved by waves."""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from percuss.case.answers.facts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.case.answers.numerals import number, percent
from percuss.cli.arguments import (
    PICTURES,
    Parser,
    check_not_the_case,
    check_picture,
    check_table,
    check_target,
    named_case,
    need,
    whole,
)
from percuss.errors import CaseError, ParameterError, PercussError

if TYPE_CHECKING:
    import argparse

    from percuss.case import BestAnswer, BlowAnswer, Case, Span
    from percuss.cli.long_commands import Watch


# ---- ``percuss blow --best``: the sizes that give the best blow, searched for within ranges

_BLOWS = 1500

_PATIENCE = 60.0
"""Seconds that one blow may take, compilation included, before Ctrl-C loses the best one so far."""


def add_best(parser: Parser) -> None:
    """The options of the search."""
    add = parser.add_argument
    add("--best", metavar="WHAT", help="search for the best sizes: rock-energy, efficiency, incident-energy, or the "
        "least peak-stress")  # fmt: skip
    add("--vary", metavar="RANGE", action="append", help="with --best: a number of the case and its limits, such as "
        "'bar.sections[2].length=50:150mm'; may be repeated")  # fmt: skip
    add("--below", metavar="STRESS", help="with --best: no stress in bar and tool above this, such as 300MPa")
    add("--blows", metavar="N", type=whole, help=f"with --best: how many blows to compute (default {_BLOWS})")
    add("--seed", metavar="N", type=whole, help="with --best: another seed searches other places (default 0)")


def check_best(parser: Parser, options: argparse.Namespace) -> bool:
    """Whether a search is asked for; refuses what does not go with it, or without it."""
    if options.best is None:
        for name in ("vary", "below", "blows", "seed"):
            if getattr(options, name) is not None:
                parser.error(f"argument --{name}: only with --best, such as --best rock-energy")
        return False
    from percuss.blow.best import OBJECTIVES

    if options.best not in OBJECTIVES:
        parser.error(f"argument --best: '{options.best}': give one of {', '.join(OBJECTIVES)}")
    if not options.vary:
        parser.error("argument --best: say what may vary: --vary 'bar.sections[2].length=50:150mm'")
    if options.blows is not None and options.blows < 20:
        parser.error("argument --blows: a whole number, 20 or greater")
    for name in ("velocity", "until", "from_motion", "gauge", "measured", "column", "unit", "sample_rate", "csv"):
        if getattr(options, name):
            option = name.replace("_", "-")
            parser.error(f"argument --{option}: not with --best, which asks the case as it is; save it with -o, then "
                f"'percuss blow' of that file takes --{option}")  # fmt: skip
    if options.output is not None:
        if not options.output.lower().endswith(".toml"):
            parser.error(f"argument -o: '{options.output}': with --best the name of a case: it must end in .toml")
        check_target(parser, "-o", options.output)
        check_not_the_case(parser, options.output, options.case)
    if options.plot is not None:
        check_picture(parser, options.plot)
    need("scipy", "io")
    return True


def run_best(parser: Parser, options: argparse.Namespace) -> int:
    """Search; returns the exit code, 130 when the search was interrupted."""
    case = named_case(options.case)
    answer = _searched(parser, options, case)
    if options.output is not None:
        from percuss.whole_file import write_whole

        write_whole(options.output, _text(answer.case, options.output))
    from percuss import plot
    from percuss.cli.report_printing import answered

    answered(
        options,
        answer.to_json_dict,
        lambda: best_report(answer),
        lambda: plot.best(answer),
        indent=1,
        case=options.output,
    )
    if not answer.complete:
        print(f"percuss: interrupted: the best of {answer.blows} blows so far", file=sys.stderr)
        return 130
    return 0


def _text(case: Case, path: str) -> str:
    """The case as a file at a path; a recording is named from the folder of the file."""
    name = getattr(case.tables.load, "file", None)
    if name is None or os.path.isabs(name):
        return case.to_toml()
    there = os.path.relpath(case.folder / name, os.path.dirname(path) or ".")
    return case.varied({"load.file": there.replace(os.sep, "/")}).to_toml()


def _searched(parser: Parser, options: argparse.Namespace, case: Case) -> BestAnswer:
    from percuss.case import Span, best_answer
    from percuss.cli.long_commands import watching

    most, seed = options.blows or _BLOWS, options.seed or 0
    spans = [Span.parsed(text) for text in options.vary]
    below = _stress(parser, options.below, case)
    with watching(parser, _PATIENCE) as watch:
        told = _told(watch)
        return best_answer(case, spans, options.best, below=below, seed=seed, most=most, progress=told)


def _stress(parser: Parser, text: str | None, case: Case) -> float | None:
    from percuss.units import si

    if text is None:
        return None
    try:
        value = si(text, "pressure", "--below") if case.is_si else float(text)
    except PercussError as error:
        parser.error(f"argument {error}")
    except ValueError:
        parser.error(f"argument --below: '{text}': the case is dimensionless, give a force")
    if not 0.0 < value < float("inf"):
        parser.error(f"argument --below: '{text}': give a stress greater than 0")
    return value


def _told(watch: Watch) -> Callable[[int, int], bool]:
    """The progress of a search as the bar takes it."""
    from percuss.explore.jobs.progress import JobProgress

    begun: list[float] = []

    def told(done: int, most: int) -> bool:
        now = time.monotonic()
        begun[:] = begun or [now]
        rate = done / (now - begun[0]) if done > 1 and now > begun[0] else float("nan")
        done = min(done, most)
        return watch(JobProgress(done, most, rate, (most - done) / rate, 0))

    return told


# -- report ------------------------------------------------------------------------------------------------------------


def best_report(answer: BestAnswer) -> Report:
    """The best sizes and what they change, against the case as it is."""
    from percuss.blow.best import FIGURES, OBJECTIVES

    name = OBJECTIVES[answer.objective][0]
    own, best = (f"{_best_value(answer, name, value)}" for value in answer.figures[name])
    limit = "" if answer.below is None else answer.own.tell(answer.below, "stress")
    if answer.allowed:
        summary = f"The best blow found: {FIGURES[name].label} {best}; the case as it is: {own}."
        summary += f" No stress is above {limit}." if limit else ""
    else:
        summary = f"No blow within these ranges keeps its stresses below {limit}; this one has the least."
    if not answer.complete:
        summary += " The search was interrupted: this is the best so far."
    searched = [("blows", f"{answer.blows}, seed {answer.seed}")]
    searched += [
        ("range", f"{s.name} from {number(s.low)} to {number(s.high)} {s.unit}".rstrip()) for s in answer.spans
    ]
    sizes = tuple(_size(*one) for one in zip(answer.spans, answer.own_values, answer.values, strict=True))
    figures = tuple(_figure(answer, name) for name in answer.figures if answer.figures[name] != (None, None))
    return Report(
        answer.own.title,
        summary,
        BAD if not answer.allowed else GOOD if answer.complete else PLAIN,
        (
            Section("The search", tuple(searched)),
            Grid("Sizes", ("key", "the case", "best", "change"), sizes),
            Grid("The blow", ("figure", "the case", "best", "change"), figures),
        ),
    )


def _size(span: Span, own: float | None, best: float) -> tuple[str, ...]:
    unit = f" {span.unit}" if span.unit else ""
    ends = {span.low: ", at the lower limit", span.high: ", at the upper limit"}
    told = f"{number(best, 6)}{unit}{ends.get(best, '')}"
    return span.name, "-" if own is None else f"{number(own, 6)}{unit}", told, _change(own, best)


def _figure(answer: BestAnswer, name: str) -> tuple[str, ...]:
    from percuss.blow.best import FIGURES

    own, best = answer.figures[name]
    return FIGURES[name].label, _best_value(answer, name, own), _best_value(answer, name, best), _change(own, best)


def _best_value(answer: BestAnswer, name: str, value: float | None) -> str:
    if value is None:
        return "-"
    if name in ("rock_efficiency", "ringing"):
        return percent(value)
    return answer.own.tell(value, _DIMENSIONS.get(name, ""))


_DIMENSIONS = {
    "rock_energy": "energy",
    "incident_energy": "energy",
    "peak_stress": "stress",
    "contact_duration": "time",
}


def _change(own: float | None, best: float | None) -> str:
    return "" if not own or best is None else f"{100.0 * (best / own - 1.0):+.1f} %"


# ---- ``percuss blow``: what one blow of a hammer does, resolved by waves

_DESCRIPTION = """\
What one blow of a hammer does to the tool and the rock that it strikes, by waves in bar and tool: contacts, forces,
stresses, where the energy goes, what comes back. The case describes what is struck in the tables [tool] and [rock];
[load] and [contact] are not needed."""

_EXAMPLES = """\
  percuss blow stepped-drifter
  percuss blow case.toml --velocity "9.5 m/s" --plot blow.png
  percuss blow case.toml --gauge 0.8m --csv gauge.csv
  percuss blow case.toml --gauge 0.8m --measured gauge.csv --unit "µm/m" --plot blow.png
  percuss blow case.toml --from-motion --json > blow.json
  percuss blow stepped-drifter --best rock-energy --vary "bar.sections[2].length=50:150mm" --below 350MPa"""


def _parser() -> Parser:
    parser = Parser("blow", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--velocity", metavar="V", help="speed of the striker, such as '9.5 m/s' (default: [blow], or steady motion)")
    add("--from-motion", action="store_true", help="start from all of the steady motion, with the strain in the bar")
    add("--until", metavar="T", help="end of the window, such as '3 ms' (default: [blow], or until the blow is over)")
    add("--gauge", metavar="X", help="place on the rod, from its struck face, such as 0.8m, where waves are told of")
    add(
        "--measured",
        metavar="FILE",
        help="a record of strain, stress or force at the gauge, laid over the computed one",
    )
    add("--column", metavar="NAME", help="its column of values, by heading or number (default: the only one that fits)")
    add("--unit", metavar="UNIT", help="what 1 in it is, such as 'µm/m', '1e-6' or MPa (default: its heading)")
    add("--sample-rate", metavar="RATE", help="of the record, such as '1 MHz' (default: its column of time)")
    add("--measured-sign", choices=("auto", "positive", "negative"), default="auto",
        help="compression in the record (default: the sign that fits better)")  # fmt: skip
    add("--json", action="store_true", help="print the answer as JSON")
    add("-o", "--output", metavar="FILE", help="save forces and waves over time as NetCDF, for xarray; with --best the "
        "best case as TOML")  # fmt: skip
    add("--csv", metavar="FILE", help="write the same as a table")
    add("--plot", metavar="FILE", help=f"draw the blow: {', '.join(PICTURES)}")
    add_best(parser)
    return parser


def run(arguments: Sequence[str]) -> int:
    """Resolve one blow of one case; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    if check_best(parser, options):
        return run_best(parser, options)
    _check(parser, options)
    answer = _answer(parser, options)
    if options.measured is not None:
        answer = _with_record(parser, answer, options)
    if options.output is not None or options.csv is not None:
        _save(answer, options)
    from percuss import plot
    from percuss.case.answers.blow_answer import blow_report
    from percuss.cli.report_printing import answered

    answered(
        options, answer.to_json_dict, lambda: blow_report(answer), lambda: plot.blow(answer), indent=1,
        waves=options.output, table=options.csv,
    )  # fmt: skip
    return 0


def _check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse what cannot be written before anything is computed."""
    if options.velocity is not None and options.from_motion:
        parser.error("argument --velocity: either a speed or --from-motion, which takes that of the steady motion")
    if options.measured is None:
        for name in ("column", "unit", "sample_rate"):
            if getattr(options, name) is not None:
                parser.error(f"argument --{name.replace('_', '-')}: only with --measured, whose record it describes")
    if options.output is not None:
        if options.output.lower().endswith((".toml", ".csv", ".json", *PICTURES)):
            parser.error(f"argument -o: '{options.output}': waves are saved as NetCDF, in a file that ends in .nc")
        check_target(parser, "-o", options.output)
        check_not_the_case(parser, options.output, options.case)
        for package in ("xarray", "h5netcdf"):
            need(package, "io")
    if options.csv is not None:
        check_table(parser, options.csv)
    if options.plot is not None:
        check_picture(parser, options.plot)


def _answer(parser: Parser, options: argparse.Namespace) -> BlowAnswer:
    from percuss.case import blow_answer

    case = named_case(options.case)
    velocity = _value(parser, case, "--velocity", options.velocity, "velocity")
    until = _value(parser, case, "--until", options.until, "time")
    gauge = _value(parser, case, "--gauge", options.gauge, "length")
    try:
        return blow_answer(case, velocity, until=until, gauge=gauge, whole_field=options.from_motion)
    except CaseError:
        raise
    except ParameterError as error:
        option, text = {"x": ("--gauge", options.gauge), "until": ("--until", options.until)}.get(
            error.name, ("", None)
        )
        if text is not None:
            unit = " m" if case.is_si and error.accepted[-1].isdigit() else ""
            parser.error(f"argument {option}: '{text}': {error.accepted}{unit}{error.remedy and ': ' + error.remedy}")
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error
    except PercussError as error:  # the floors below do not know the file
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error


def _with_record(parser: Parser, answer: BlowAnswer, options: argparse.Namespace) -> BlowAnswer:
    """The answer with what was measured at its gauge."""
    from dataclasses import replace

    from percuss.case import measured_gauge
    from percuss.errors import HistoryError, UnitError

    try:
        found = measured_gauge(
            answer,
            options.measured,
            column=options.column,
            unit=options.unit,
            sample_rate=options.sample_rate,
            sign=options.measured_sign,
        )
    except UnitError as error:
        parser.error(f"argument --{error.name.replace('_', '-')}: {error}")
    except ParameterError as error:
        raise PercussError(f"--measured: {error.accepted}", error.remedy) from error
    except HistoryError as error:  # its remedies name the keys of a case file
        remedy = error.remedy.replace('give time_column = "…", or ', "")
        raise PercussError(error.message, re.sub(r"\b(column|unit|sample_rate) = ", _as_option, remedy)) from error
    return replace(answer, measured=found)


def _as_option(key: re.Match[str]) -> str:
    return f"--{key[1].replace('_', '-')} "


_PLAIN = {"velocity": "lengths per radian", "time": "radians", "length": "a time of a wave in radians"}
"""What a plain number is in a dimensionless case."""


def _value(parser: Parser, case: Case, option: str, text: str | None, dimension: str) -> float | None:
    """The value of an option: with a unit for a case in SI, else a plain number."""
    from percuss.units import si

    if text is None:
        return None
    if case.is_si:
        try:
            value = si(text, dimension, option)
        except PercussError as error:
            parser.error(f"argument {error}")
    else:
        try:
            value = float(text)
        except ValueError:
            parser.error(f"argument {option}: '{text}': the case is dimensionless, give {_PLAIN[dimension]}")
    least = "0 or a number greater than 0" if dimension == "length" else "a number greater than 0"
    if not 0.0 <= value < float("inf") or (value == 0.0 and dimension != "length"):
        parser.error(f"argument {option}: '{text}': give {least}")
    return value


def _save(answer: BlowAnswer, options: argparse.Namespace) -> None:
    from percuss.case.answers.blow_answer import blow_dataset
    from percuss.explore.jobs.archive_export import write_csv, write_netcdf

    found = blow_dataset(answer)
    if options.output is not None:
        write_netcdf(found, options.output)
    if options.csv is not None:
        write_csv(found, options.csv)
