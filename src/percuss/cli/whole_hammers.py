"""What is asked of whole hammers: the best, several side by side, what tolerances do to one, what fits its blows."""

from __future__ import annotations

import argparse
from contextlib import suppress
from typing import TYPE_CHECKING

from percuss.cli.arguments import (
    CASE,
    JSON,
    Parser,
    command,
    key_values,
    made,
    modes_option,
    named_case,
    names,
    need,
    of_file,
    option,
    plot_option,
    report_options,
    whole,
    write_case,
)
from percuss.cli.long_commands import CARRYING, carried, watching
from percuss.errors import Interrupted, ParameterError
from percuss.units import si

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.optimum import SearchProgress

_HAMMERS = 1500

_PATIENCE = 60.0  # seconds that one hammer may take before Ctrl-C loses the best one so far


@command(
    """\
The best hammer over any numbers of the case: the most, or the least, of one figure of the whole hammer, under limits of
any others. Cycle, oil, blow and rock are computed anew for every hammer that is tried, and only those that run are
looked for. The answer says which limits bind and what stands at the end of its range; where nothing keeps all limits,
what comes nearest and which limit costs most. The figures are those of 'percuss compare': blow_energy, blow_rate,
rock_power, rock_energy, rock_share, rate_of_penetration, overall_efficiency, flow, pressure, piston.stress,
steel.stress, steel[0].stress, steel_tension, joint_openings, margin and others.""",
    """\
  percuss design stepped-drifter --most rock_power --vary "bar.sections[2].diameter=34:48mm" --below steel.stress=350MPa
  percuss design valve-drifter --most rock_power --want blow_rate="45 Hz..60 Hz" --below steel.stress=400MPa \\
      --vary load.ports[0].behind=8:24mm --vary bar.diameter=40:56mm -o better.toml --report better.html --plane map.png
  percuss design better.toml --least steel.stress --above rock_power=9kW --vary bar.diameter=40:56mm""",
    CASE,
    option("--most FIGURE", "what there is to be the most of (default: rock_power)"),
    option("--least FIGURE", "what there is to be the least of"),
    option("--want RANGE", "FIGURE=LOW..HIGH, such as blow_rate='60 Hz..70 Hz'; may be repeated", action="append"),
    option("--below LIMIT", "FIGURE=VALUE, such as flow=120l/min; may be repeated", action="append"),
    option("--above LIMIT", "FIGURE=VALUE, such as margin=0.2; may be repeated", action="append"),
    option(
        "--vary RANGE",
        "a number of the case and its limits, such as 'bar.sections[2].length=50:150mm'; may be repeated",
        action="append",
    ),
    option("--hammers N", f"about how many to compute (default {_HAMMERS})", whole(20), default=_HAMMERS),
    option("--seed N", "another seed searches other places (default 0)", whole(), default=0),
    modes_option("default: those of 'percuss steady'"),
    JSON,
    made("-o, --output FILE", "save the best case; given as CASE, a search goes on from it", (".toml",)),
    plot_option("both hammers: their cycles and, with a tool, their blows"),
    plot_option("the plane of the first two ranges about the best: which keep the limits", "--plane FILE"),
    *report_options(),
)
def design(parser: Parser, options: argparse.Namespace) -> int:
    """Search; after Ctrl-C the answer is the best one so far."""
    if options.most is not None and options.least is not None:
        parser.error("argument --least: not with --most: one figure is looked for, the others are limits")
    if not options.vary:
        parser.error("argument --vary: say what may vary: --vary 'bar.sections[2].length=50:150mm'")
    if options.plane is not None and len(options.vary) < 2:
        parser.error("argument --plane: a plane is drawn over the first two of --vary: give two")
    need("io", "scipy")
    from percuss import plot
    from percuss.case import Limit, Span
    from percuss.case import design as designed
    from percuss.case.answers.exploring.design import search_told
    from percuss.case.answers.whole_hammer import whole_figure
    from percuss.cli.report_printing import answered, filed

    case = named_case(options.case)
    figure = options.least or options.most or "rock_power"
    spans = [Span.parsed(words) for words in options.vary]
    limits = [
        Limit.parsed(words, sense, case.is_si)
        for sense in ("want", "below", "above")
        for words in getattr(options, sense) or ()
    ]
    with of_file(case), watching(parser, _PATIENCE) as watch:

        def progress(now: SearchProgress) -> bool:
            return watch.share(now.fraction, search_told(now, whole_figure(figure), case.is_si))

        answer = designed(
            case, spans, figure, limits,
            greatest=options.least is None, modes=options.modes, seed=options.seed, most=options.hammers,
            progress=progress,
        )  # fmt: skip
        plane = None
        if options.plane is not None and answer.complete:
            with suppress(Interrupted):  # the best is not lost
                plot.save(plot.design_plane(answer.plane(progress=progress)), options.plane)
                plane = options.plane
    if options.output is not None:
        write_case(answer.case, options.output)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.comparison(answer.comparison), indent=1,
        cut=f"the best of {answer.hammers} hammers so far" if not answer.complete else "" if plane == options.plane
        else "the plane is left out",
        case=options.output, report=options.report, plane=plane,
    )  # fmt: skip


# ---- Hammers side by side


@command(
    """\
Hammers side by side: where their cases differ, the figures of the motion of each, and by how much they differ from
those of the first, A. They may be of any kinds, all in SI or all dimensionless. Each --set is one more hammer: the last
case with other values of its keys.""",
    """\
  percuss compare hydraulic-drifter heavy-drifter
  percuss compare breaker.toml --set contact.restitution=0.3
  percuss compare valve-breaker --set "pressure=150 bar" --set "pressure=150 bar,ports[0].behind=110 mm" --plot both.png
  percuss compare old.toml new.toml --report change.html""",
    option("CASE", "TOML files, or names of machines", nargs="+")._replace(names=("cases",)),
    option(
        "--set VALUES",
        "one more hammer: the last case with these values, KEY=VALUE,KEY=VALUE; may be repeated",
        key_values,
        action="append",
        default=[],
    ),
    modes_option("default: those of 'percuss steady'"),
    JSON,
    plot_option("their cycles and, where each has a tool, their blows"),
    *report_options(),
)
def compare(_: Parser, options: argparse.Namespace) -> int:
    from percuss import plot
    from percuss.case.answers.exploring.comparison import compare
    from percuss.case.parameters.case_keys import varied_keys
    from percuss.cli.report_printing import answered, filed

    cases = [named_case(name) for name in options.cases]
    names = [case.file for case in cases]
    last = cases[-1]
    known = {key.partition(".")[2]: key for key in varied_keys(last)}  # without its table
    for text, values in options.set:
        with of_file(last):
            cases.append(last.varied({known.get(name, name): value for name, value in values.items()}))
            names.append(f"{last.file}, {text}")
    answer = compare(cases, names, options.modes)
    filed(options.report, options, cases[0], answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.comparison(answer), indent=1, report=options.report
    )


# ---- Hammers within tolerances


@command(
    """\
What the tolerances of its numbers do to a hammer: the share of the hammers that run, the spread of their figures, the
worst corner, and which tolerance dominates. Without --vary the tolerances are the ± of the case, or where it has none
those usual in a drawing: areas and the flow of a pump 5 %, ports 0.2 mm, the pressure or the load 10 %, R 0.1.""",
    """\
  percuss tolerance valve-breaker
  percuss tolerance valve-breaker --vary load.pressure=±10bar --vary contact.restitution=0.1..0.2
  percuss tolerance breaker.toml --vary "bar.length=+-1 %" --figures blow_energy,margin --plot spread.png""",
    CASE,
    option(
        "--vary KEY=RANGE",
        "a number of the case and its tolerance, KEY=±0.2mm, KEY=±5%% or KEY=LOW..HIGH; may be repeated",
        action="append",
        default=[],
    ),
    option("--figures NAMES", "figures to tell, such as blow_energy,steel.stress (default: those that matter)", names),
    option("--samples N", "about how many hammers to compute (default 4096)", whole(64)),
    option("--seed N", "another seed draws other hammers (default 0)", whole()),
    modes_option("default: those of 'percuss steady'"),
    JSON,
    plot_option("the shares of the tolerances, and the figures of all hammers drawn"),
    *report_options(),
    *CARRYING,
)
def tolerance(parser: Parser, options: argparse.Namespace) -> int:
    """Draw hammers within tolerances."""
    from percuss import plot
    from percuss.case.answers.exploring.tolerance import SAMPLES, ToleranceAnswer, tolerance_job
    from percuss.case.parameters.spans import parsed_tolerance
    from percuss.cli.report_printing import answered, filed

    case = named_case(options.case)
    given = [parsed_tolerance(words, case) for words in options.vary]
    drawn = {"samples": options.samples or SAMPLES, "seed": options.seed or 0, "modes": options.modes}
    job = tolerance_job(case, given, options.figures or (), **drawn)
    answer = ToleranceAnswer(case, job, carried(parser, options, job), not given and not case.uncertain)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.tolerance(answer), indent=1, report=options.report,
        archive=options.output,
    )  # fmt: skip


# ---- Numbers of a hammer from its measured blows


@command(
    """\
The numbers of a case with which its steady motion fits measured blows, each with its interval of 95 %, and how far
model and record agree. The file has a row for each blow: its time, and what was measured of it, under such headings as
'time [s]', 'rebound speed [m/s]', 'striking speed [m/s]', 'pressure [bar]', 'peak [m/s^2]'. A record that cannot tell
the numbers is refused, with what it lacks. Without --vary they are R, the pressure or the scale of the load and, of a
load that keeps time, its frequency.""",
    """\
  percuss identify valve-breaker --blows times.csv
  percuss identify breaker.toml --blows times.csv --vary contact.restitution --given bar.diameter=±0.5mm --plot fit.png
  percuss identify valve-breaker --blows times.csv --vary load.pressure=140..180bar --vary load.ports[0].behind \\
      --given "load.states.return.front=±4 %" -o fitted.toml --report fit.html
  percuss identify valve-drifter --pressure 175bar --flow "123 l/min" --rate 68Hz --energy 277J -o built.toml""",
    CASE,
    option("--blows FILE", "the measured blows: .csv and the like"),
    option("--pressure P", "a data sheet in place of blows: the working pressure …"),
    option("--flow Q", "… the flow of the oil …"),
    option("--rate F", "… the blow rate …"),
    option("--energy E", "… and the energy of a blow: what losses explain them"),
    option("--vary KEY", "a number to be found, KEY or KEY=LOW..HIGH; may be repeated", action="append", default=[]),
    option(
        "--given KEY=±HALF",
        "another number, and how far from its value it may lie at 95 %%; may be repeated",
        action="append",
        default=[],
    ),
    modes_option("default: those of 'percuss steady'"),
    JSON,
    made("-o, --output FILE", "save the case with the numbers that fit", (".toml",)),
    plot_option("blows, fit and residuals"),
    *report_options(),
)
def identify(_: Parser, options: argparse.Namespace) -> int:
    """Fit numbers of a case to measured blows."""
    from percuss import plot
    from percuss.case import identify, parsed_tolerance, parsed_unknown
    from percuss.cli.report_printing import answered, filed
    from percuss.recordings import read_blows

    case = named_case(options.case)
    if options.blows is None:
        return _data_sheet(case, options)
    record = read_blows(options.blows)
    vary = [parsed_unknown(words, case) for words in options.vary]
    given = [parsed_tolerance(words, case) for words in options.given]
    answer = identify(case, record, vary, given, modes=options.modes)
    if options.output is not None:
        write_case(answer.best, options.output)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.identify(answer), indent=1,
        case=options.output, report=options.report,
    )  # fmt: skip


_SHEET = {"pressure": "pressure", "flow": "flow", "rate": "frequency", "energy": "energy"}


def _data_sheet(case: Case, options: argparse.Namespace) -> int:
    """What losses explain a data sheet."""
    from percuss import plot
    from percuss.case import data_sheet_answer, machine_answer
    from percuss.cli.report_printing import answered, filed

    lacking = [name for name in _SHEET if getattr(options, name) is None]
    if len(lacking) == len(_SHEET):
        raise ParameterError("--blows", None, "a record of blows, or the figures of a data sheet",
                             "give --blows FILE, or --pressure, --flow, --rate and --energy")  # fmt: skip
    if lacking:
        raise ParameterError(f"--{lacking[0]}", None, "all four of --pressure, --flow, --rate and --energy")
    figures = {name: si(getattr(options, name), of, f"--{name}") for name, of in _SHEET.items()}
    answer = data_sheet_answer(case, **figures)
    if options.output is not None:
        write_case(answer.best, options.output)
    filed(options.report, options, case, answer)
    return answered(
        options, answer.to_json_dict, answer.report, lambda: plot.machine(machine_answer(answer.best, modes=0)),
        indent=1, case=options.output, report=options.report,
    )  # fmt: skip
