"""``percuss tolerance``: what the tolerances of its numbers do to a hammer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.cli.arguments import JSON, REPORT, command, modes_option, named_case, option, plot_option, whole
from percuss.cli.long_commands import CARRYING, carried

if TYPE_CHECKING:
    import argparse

    from percuss.cli.arguments import Parser


@command(
    """\
What the tolerances of its numbers do to a hammer: the share of the hammers that run, the spread of their figures, the
worst corner, and which tolerance dominates. Without --vary the tolerances are those usual in a drawing: areas 5 %,
ports 0.2 mm, the pressure or the load 10 %, R 0.1.""",
    """\
  percuss tolerance valve-breaker
  percuss tolerance valve-breaker --vary load.pressure=±10bar --vary contact.restitution=0.1..0.2
  percuss tolerance breaker.toml --vary "bar.length=+-1 %" --figures blow_energy,margin --plot spread.png""",
    option("CASE", "a TOML file, '-' for standard input, or a machine's name")._replace(names=("case",)),
    option(
        "--vary KEY=RANGE",
        "a number of the case and its tolerance, KEY=±0.2mm, KEY=±5%% or KEY=LOW..HIGH; may be repeated",
        action="append",
        default=[],
    ),
    option("--figures NAMES", "figures to tell, such as blow_energy,steel.stress (default: those that matter)"),
    option("--samples N", "about how many hammers to compute (default 4096)", whole(64)),
    option("--seed N", "another seed draws other hammers (default 0)", whole()),
    modes_option("default: those of 'percuss steady'"),
    JSON,
    plot_option("the shares of the tolerances, and the figures of all hammers drawn"),
    REPORT,
    *CARRYING,
)
def tolerance(parser: Parser, options: argparse.Namespace) -> int:
    """Draw hammers within tolerances."""
    from percuss import plot
    from percuss.case.answers.exploring.tolerance import SAMPLES, ToleranceAnswer, parsed_tolerance, tolerance_job
    from percuss.cli.report_printing import answered, filed

    case = named_case(options.case)
    given = [parsed_tolerance(words, case) for words in options.vary]
    names = [] if options.figures is None else [name.strip() for name in options.figures.split(",")]
    drawn = {"samples": options.samples or SAMPLES, "seed": options.seed or 0, "modes": options.modes}
    job = tolerance_job(case, given, names, **drawn)
    answer = ToleranceAnswer(case, job, carried(parser, options, job), not given)
    filed(options, case, answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.tolerance(answer), indent=1, report=options.report,
        archive=options.output,
    )  # fmt: skip
