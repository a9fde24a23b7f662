"""``percuss blow --best``: the sizes that give the best blow, searched for within ranges."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from percuss.case.answers.numerals import number, percent
from percuss.cli.files import check_not_the_case, check_picture, check_target, named_case, need, tell_made
from percuss.cli.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.cli.simulate_arguments import whole
from percuss.errors import PercussError

if TYPE_CHECKING:
    import argparse

    from percuss.case import BestAnswer, Case, Span
    from percuss.cli.long_commands import Watch
    from percuss.cli.parser import Parser

__all__ = ["add_best", "check_best", "run_best"]

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
    if options.plot is not None:
        from percuss import plot

        plot.save(plot.best(answer), options.plot)
    if options.json:
        import json

        print(json.dumps(answer.to_json_dict(), indent=1, allow_nan=False))
    else:
        from percuss.cli.report_printing import show

        show(best_report(answer))
    tell_made(options.json, case=options.output, picture=options.plot)
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
    from percuss.blow.best import OBJECTIVES
    from percuss.blow.figures import FIGURES

    name = OBJECTIVES[answer.objective][0]
    own, best = (f"{_value(answer, name, value)}" for value in answer.figures[name])
    limit = "" if answer.below is None else answer.own.units.stress(answer.below)
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
    from percuss.blow.figures import FIGURES

    own, best = answer.figures[name]
    return FIGURES[name].label, _value(answer, name, own), _value(answer, name, best), _change(own, best)


def _value(answer: BestAnswer, name: str, value: float | None) -> str:
    tell: dict[str, Any] = {
        "rock_energy": answer.own.units.energy,
        "incident_energy": answer.own.units.energy,
        "rock_efficiency": percent,
        "ringing": percent,
        "peak_stress": answer.own.units.stress,
        "contact_duration": answer.own.units.time,
    }
    return "-" if value is None else tell.get(name, number)(value)


def _change(own: float | None, best: float | None) -> str:
    return "" if not own or best is None else f"{100.0 * (best / own - 1.0):+.1f} %"
