"""``percuss blow``: what one blow of a hammer does, resolved by waves; the sizes that give the best one."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.cli.arguments import (
    CASE,
    JSON,
    NETCDF,
    PICTURES,
    Parser,
    command,
    csv_option,
    made,
    named_case,
    need,
    of_file,
    option,
    plot_option,
    report_options,
    whole,
    write_case,
)
from percuss.errors import CaseError, HistoryError, ParameterError, PercussError, UnitError
from percuss.units import si

if TYPE_CHECKING:
    import argparse

    from percuss.case import BlowAnswer, Case
    from percuss.optimum import SearchProgress
    from percuss.simulate import Progress

_BLOWS = 1500

_PATIENCE = 60.0  # seconds that one blow may take before Ctrl-C loses the best one so far


@command(
    """\
What one blow of a hammer does to the tool and the rock that it strikes, by waves in bar and tool: contacts, forces,
stresses, where the energy goes, what comes back. The case describes what is struck in the tables [tool] and [rock];
[load] and [contact] are not needed.""",
    """\
  percuss blow stepped-drifter
  percuss blow case.toml --velocity "9.5 m/s" --plot blow.png
  percuss blow case.toml --gauge 0.8m --csv gauge.csv
  percuss blow case.toml --gauge 0.8m --measured gauge.csv --unit "µm/m" --plot blow.png
  percuss blow stepped-drifter --fatigue --plot fatigue.png
  percuss blow case.toml --from-motion --json > blow.json
  percuss blow stepped-drifter --best rock-energy --vary "bar.sections[2].length=50:150mm" --below 350MPa""",
    CASE,
    option("--velocity V", "speed of the striker, such as '9.5 m/s' (default: [blow], or steady motion)"),
    option("--from-motion", "start from all of the steady motion, with the strain in the bar"),
    option("--until T", "end of the window, such as '3 ms' (default: [blow], or until the blow is over)"),
    option(
        "--cells N",
        "of blows that follow each other with their waves: cells of the bar, 16 or more, on a lattice (default: exact "
        "waves, or where they have too many pieces 400 cells)",
        whole(16, 100_000),
    ),
    option("--fatigue", "safety factors and hours to failure of bar and tool, with the steel of [steel]"),
    option("--gauge X", "place on the rod, from its struck face, such as 0.8m, where waves are told of"),
    option("--measured FILE", "a record of strain, stress or force at the gauge, laid over the computed one"),
    option("--column NAME", "its column of values, by heading or number (default: the only one that fits)"),
    option("--unit UNIT", "what 1 in it is, such as 'µm/m', '1e-6' or MPa (default: its heading)"),
    option("--sample-rate RATE", "of the record, such as '1 MHz' (default: its column of time)"),
    option(
        "--measured-sign",
        "compression in the record (default: the sign that fits better)",
        choices=("auto", "positive", "negative"),
        default="auto",
    ),
    JSON,
    made(
        "-o, --output FILE", "save forces and waves over time as NetCDF, for xarray; with --best the best case as TOML"
    ),
    csv_option("write the same as a table"),
    plot_option("the blow"),
    *report_options(),
    option(
        "--best WHAT", "search for the best sizes: rock-energy, efficiency, incident-energy, or the least peak-stress"
    ),
    option(
        "--vary RANGE",
        "with --best: a number of the case and its limits, such as 'bar.sections[2].length=50:150mm'; may be repeated",
        action="append",
    ),
    option("--below STRESS", "with --best: no stress in bar and tool above this, such as 300MPa"),
    option("--blows N", f"with --best: how many blows to compute (default {_BLOWS})", whole(20)),
    option("--seed N", "with --best: another seed searches other places (default 0)", whole()),
)
def blow(parser: Parser, options: argparse.Namespace) -> int:
    """Resolve one blow of one case, or search for the best one."""
    from percuss import plot
    from percuss.cli.report_printing import answered, filed

    if options.best is not None:
        _check_best(parser, options)
        return _best(parser, options)
    _check(parser, options)
    case = named_case(options.case)
    asked = getattr(case.tables, "blow", None)
    if asked is not None and asked.between == "waves":
        return _repeated(parser, options, case)
    if options.cells is not None:
        parser.error('argument --cells: only with between = "waves" in [blow]')
    answer = _answer(parser, options, case)
    if options.measured is not None:
        answer = _with_record(parser, answer, options)
    from percuss.case.answers.blows.blow_answer import blow_dataset, blow_report

    if options.output is not None:
        from percuss.atomic_write import write_dataset

        write_dataset(blow_dataset(answer), options.output)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, lambda: blow_report(answer), lambda: plot.blow(answer),
        dataset=lambda: blow_dataset(answer), indent=1, waves=options.output, report=options.report,
    )  # fmt: skip


def _repeated(parser: Parser, options: argparse.Namespace, case: Case) -> int:
    """Blows that follow each other, each with the waves of those before it; after Ctrl-C those so far."""
    from percuss import plot
    from percuss.case import repeated_answer
    from percuss.case.answers.blows.repeated_answer import repeated_dataset, repeated_report
    from percuss.cli.long_commands import watching
    from percuss.cli.report_printing import answered, filed

    for name in ("from_motion", "until", "fatigue", "gauge", "measured", "output"):
        if getattr(options, name):
            told = name.replace("_", "-")
            parser.error(f'argument --{told}: of one blow; [blow] has between = "waves"')
    velocity = _value(parser, case, "--velocity", options.velocity, "velocity")
    with watching(parser, _PATIENCE) as watch, of_file(case):

        def progress(now: Progress) -> bool:
            return watch.share(now.fraction, f"blow {now.impacts}")

        answer = repeated_answer(case, velocity, cells=options.cells, progress=progress)
    asked = case.blow_question().number
    cut = "" if len(answer.train.blows) == asked else f"{len(answer.train.blows)} of {asked} blows"
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, lambda: repeated_report(answer), lambda: plot.repeated(answer),
        dataset=lambda: repeated_dataset(answer), indent=1, cut=cut, report=options.report,
    )  # fmt: skip


def _check(parser: Parser, options: argparse.Namespace) -> None:
    if options.velocity is not None and options.from_motion:
        parser.error("argument --velocity: either a speed or --from-motion, which takes that of the steady motion")
    for needed, given in (
        ("best", ("vary", "below", "blows", "seed")),
        ("measured", ("column", "unit", "sample_rate")),
    ):
        for name in given if getattr(options, needed) is None else ():
            if getattr(options, name) is not None:
                why = "such as --best rock-energy" if needed == "best" else "whose record it describes"
                parser.error(f"argument --{name.replace('_', '-')}: only with --{needed}, {why}")
    if options.fatigue:
        need("io", "rainflow")
    if options.output is not None:
        if options.output.lower().endswith((".toml", ".csv", ".json", *PICTURES)):
            parser.error(f"argument -o: '{options.output}': waves are saved as NetCDF, in a file that ends in .nc")
        need(*NETCDF)


def _answer(parser: Parser, options: argparse.Namespace, case: Case) -> BlowAnswer:
    from percuss.case import blow_answer

    velocity = _value(parser, case, "--velocity", options.velocity, "velocity")
    until = _value(parser, case, "--until", options.until, "time")
    gauge = _value(parser, case, "--gauge", options.gauge, "length")
    with of_file(case):
        try:
            return blow_answer(
                case, velocity, until=until, gauge=gauge, whole_field=options.from_motion, fatigue=options.fatigue
            )
        except ParameterError as error:
            name = {"x": "gauge", "until": "until"}.get(error.name)
            if isinstance(error, CaseError) or name is None or getattr(options, name) is None:
                raise
            unit = " m" if case.is_si and error.accepted[-1].isdigit() else ""
            told = f"{error.accepted}{unit}{error.remedy and ': ' + error.remedy}"
            parser.error(f"argument --{name}: '{getattr(options, name)}': {told}")


def _with_record(parser: Parser, answer: BlowAnswer, options: argparse.Namespace) -> BlowAnswer:
    """The answer with what was measured at its gauge."""
    from percuss.case import measured_gauge

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


_PLAIN = {
    "velocity": "lengths per radian", "time": "radians", "length": "a time of a wave in radians", "pressure": "a force",
}  # fmt: skip
"""What a plain number is in a dimensionless case."""


def _value(parser: Parser, case: Case, option: str, text: str | None, dimension: str) -> float | None:
    """The value of an option: with a unit for a case in SI, else a plain number."""
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


# ---- ``--best``: the sizes that give the best blow, searched for within ranges


def _check_best(parser: Parser, options: argparse.Namespace) -> None:
    from percuss.blow.best import OBJECTIVES

    if options.best not in OBJECTIVES:
        parser.error(f"argument --best: '{options.best}': give one of {', '.join(OBJECTIVES)}")
    if not options.vary:
        parser.error("argument --best: say what may vary: --vary 'bar.sections[2].length=50:150mm'")
    own = ("velocity", "until", "from_motion", "fatigue", "gauge", "measured", "column", "unit", "sample_rate", "csv")
    for name in (*own, "report"):
        if getattr(options, name):
            told = name.replace("_", "-")
            parser.error(f"argument --{told}: not with --best, which asks the case as it is; save it with -o, then "
                f"'percuss blow' of that file takes --{told}")  # fmt: skip
    if options.output is not None:
        parser.check_file("-o", options.output, (".toml",))
    need("io", "scipy")


def _best(parser: Parser, options: argparse.Namespace) -> int:
    """Search; after Ctrl-C the answer is the best one so far."""
    from percuss import plot
    from percuss.case import Span, best_answer
    from percuss.case.answers.exploring.best_answer import best_report
    from percuss.cli.long_commands import watching
    from percuss.cli.report_printing import answered

    case = named_case(options.case)
    spans = [Span.parsed(text) for text in options.vary]
    below = _value(parser, case, "--below", options.below, "pressure")
    most, seed = options.blows or _BLOWS, options.seed or 0
    with watching(parser, _PATIENCE) as watch:

        def progress(now: SearchProgress) -> bool:
            return watch.share(now.fraction, f"{min(now.tried, now.most)} of {now.most} blows")

        answer = best_answer(case, spans, options.best, below=below, seed=seed, most=most, progress=progress)
    if options.output is not None:
        write_case(answer.case, options.output)
    return answered(
        options, answer.to_json_dict, lambda: best_report(answer), lambda: plot.best(answer), indent=1,
        cut="" if answer.complete else f"the best of {answer.blows} blows so far", case=options.output,
    )  # fmt: skip
