"""``percuss experiment``: random starts, and where they end."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.cli.arguments import MAX_MODES, PICTURES, Parser, check_picture, modes, named_case, whole
from percuss.cli.long_commands import add_carrying, carried

_DESCRIPTION = """\
Random starts, each followed until its motion is found: the share that ends in each motion, with 95 % intervals.
The same seed gives the same numbers on any machine with any number of workers.

distributions: wall, on the wall, leaving with |N(0, 1)| times the speed of one impact per load period; field, up to
20 bar lengths off the wall, velocity 5 N(0, 1); gentle, on the wall, leaving with 0 to 0.2; each at any load phase. Or
a file of starts: CSV, .npz or .nc with columns among position, velocity and time, or u_0, u_1, …, v_0, v_1, …, time.

Of a machine that switches its own valve: which starts run and which stall. Its starts have a state of the valve, at
random or the column state of a file, and no load phase. S is the distance of the farthest port, V = sqrt(2 S times the
difference of the valve's greatest and least acceleration): wall, leaving with |N(0, 1)| V; field, up to 2 S off the
wall, velocity V N(0, 1); gentle, on the wall, leaving with 0 to V/20."""

_EXAMPLES = """\
  percuss experiment hydraulic-drifter --starts 1000
  percuss experiment case.toml --starts 100000 --distribution field --seed 1 --modes 0 -o starts.zarr
  percuss experiment case.toml --starts 1000000 --modes 0 -o starts.zarr --resume --workers 8
  percuss experiment valve-breaker --starts 1000 --distribution field
  percuss experiment case.toml --distribution mine.csv --json"""


def _parser() -> Parser:
    parser = Parser("experiment", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add("--starts", metavar="N", type=whole, help="how many (default: 100000, or all of a file)")
    add(
        "--distribution",
        metavar="NAME",
        help="wall, field, gentle or a FILE of starts (default wall; structures: field)",
    )
    add("--seed", metavar="S", type=whole, default=0, help="seed of the random numbers (default 0)")
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 to {MAX_MODES} (default: the case's, or 32)")
    add("--impacts", metavar="N", type=whole, help="the most impacts per start (default: the case's, or 2000)")
    add("--json", action="store_true", help="print the shares as JSON")
    add("--plot", metavar="FILE", help=f"draw the shares and the starts: {', '.join(PICTURES)}")
    add_carrying(parser)
    return parser


def run(arguments: Sequence[str]) -> int:
    """Make one experiment; returns the exit code."""
    from percuss.case import experiment_job_of

    parser = _parser()
    options = parser.parsed(arguments)
    if options.plot is not None:
        check_picture(parser, options.plot)
    for name, value in (("starts", options.starts), ("impacts", options.impacts)):
        if value == 0:
            parser.error(f"argument --{name}: at least one {name.removesuffix('s')}")
    case = named_case(options.case)
    job = experiment_job_of(
        case, options.starts, options.distribution, options.seed, modes=options.modes, impacts=options.impacts
    )
    from percuss.explore.attractors.experiments import Experiment

    found = Experiment.of(job, carried(parser, options, job))
    from percuss import plot
    from percuss.case.answers.exploring.exploration import experiment_dict, experiment_report
    from percuss.cli.report_printing import answered

    answered(
        options, lambda: experiment_dict(case, found), lambda: experiment_report(case.title, found),
        lambda: plot.experiment(found, case.title), experiment=options.output,
    )  # fmt: skip
    return 0
