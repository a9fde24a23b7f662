"""``percuss blow``: what one blow of a hammer does, resolved by waves."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from percuss.cli.blow_best import add_best, check_best, run_best
from percuss.cli.files import (
    PICTURES,
    check_not_the_case,
    check_picture,
    check_table,
    check_target,
    named_case,
    need,
    tell_made,
)
from percuss.cli.parser import Parser
from percuss.errors import CaseError, ParameterError, PercussError

if TYPE_CHECKING:
    import argparse

    from percuss.case import BlowAnswer, Case

__all__ = ["run"]

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
    text = _json(answer) if options.json else ""
    if options.output is not None or options.csv is not None:
        _save(answer, options)
    if options.plot is not None:
        from percuss import plot

        plot.save(plot.blow(answer), options.plot)
    if options.json:
        print(text)
    else:
        from percuss.cli.blow_report import blow_report
        from percuss.cli.report_printing import show

        show(blow_report(answer))
    tell_made(options.json, waves=options.output, table=options.csv, picture=options.plot)
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
    from percuss.case.answers.blow_dataset import blow_dataset
    from percuss.explore.jobs.archive_export import write_csv, write_netcdf

    found = blow_dataset(answer)
    if options.output is not None:
        write_netcdf(found, options.output)
    if options.csv is not None:
        write_csv(found, options.csv)


def _json(answer: BlowAnswer) -> str:
    import json

    return json.dumps(answer.to_json_dict(), indent=1, allow_nan=False)
