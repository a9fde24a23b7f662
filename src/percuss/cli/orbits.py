"""``percuss orbits``: the periodic motions with any number of impacts in any number of load periods."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from percuss.cli.arguments import MAX_MODES, Parser, modes, named_case, whole
from percuss.cli.long_commands import watching
from percuss.errors import Interrupted
from percuss.halting import halting

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.steady import FoundOrbits

_MOST = 8
"""Modes that a line names."""

PATIENCE = 5.0
"""Seconds after which Ctrl-C no longer waits for a batch of tries."""

_DESCRIPTION = """\
The orbits z=p/n of a hammer: its periodic motions with p impacts in n load periods, stable and unstable, found without
a guess. Of one impact in a cycle, and of two of a rigid bar, they are proved to be all there are; of more, those that a
search finds from simulated motions and from random times, with an estimate of the share of random times that lead to
others. Each is proved to stay off the wall between its impacts. Cycles in which the bar comes to rest on the wall, at
the end of complete chatter or without restitution, are chatter/n and rest/n: all of them are found. All numbers are
dimensionless: phases of the load in rad, speeds in the scales of the case. After Ctrl-C the answer is what has been
found so far."""

_EXAMPLES = """\
  percuss orbits pneumatic-jackleg --label 2/1
  percuss orbits case.toml --label 1/1 --up-to 3/2 --modes 0
  percuss orbits case.toml --label 3/2 --tries 5000 --json
  percuss orbits pneumatic-jackleg --label chatter/1"""


def _parser() -> Parser:
    parser = Parser("orbits", _DESCRIPTION, _EXAMPLES)
    add = parser.add_argument
    add("case", metavar="CASE", help="a TOML file, '-' for standard input, or a machine's name")
    add(
        "--label",
        metavar="P/N",
        type=typed_label,
        default="1/1",
        help="impacts and load periods of a cycle, or chatter/N or rest/N for cycles with rest (default 1/1)",
    )
    add("--up-to", metavar="P/N", type=typed_label, help="also all labels with more impacts or periods, up to "
        "these, and the cycles with rest of as many periods")  # fmt: skip
    add("--modes", metavar="N", type=modes, help=f"elastic modes, 0 to {MAX_MODES} (default: the case's, or 32)")
    add("--tries", metavar="N", type=whole, default=400, help="random starts for each label (default 400)")
    add("--motions", metavar="N", type=whole, default=64, help="motions simulated to start from where they nearly come "
        "back (default 64; 0 for none)")  # fmt: skip
    add("--switch", action="store_true", help="start also from what begins at flips, and of rigid bars at grazings, of "
        "shorter orbits followed through the mean load")  # fmt: skip
    add("--seed", metavar="N", type=whole, default=0, help="of the random starts (default 0)")
    add("--json", action="store_true", help="print the orbits as JSON")
    return parser


def typed_label(text: str) -> str:
    """P/N as it was typed, looked at."""
    from percuss.case.answers.exploring.orbits_answer import is_rest_label, parsed_label
    from percuss.errors import ParameterError

    try:
        if not is_rest_label(text):
            parsed_label(text)
    except ParameterError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def run(arguments: Sequence[str]) -> int:
    """Search for the orbits of a case; returns the exit code."""
    from percuss.case.answers.exploring.orbits_answer import (
        is_rest_label,
        orbits_dict,
        orbits_report,
        parsed_label,
        rest_cycles_answer,
        rest_cycles_dict,
    )
    from percuss.case.answers.numerals import counted

    parser = _parser()
    options = parser.parsed(arguments)
    case = named_case(options.case)
    if any(is_rest_label(label) for label in (options.label, options.up_to or "")):
        if options.up_to is not None:
            parser.error(
                "argument --up-to: give the label of cycles with rest alone; up to an orbit P/N they are listed, too"
            )
        return _resting(case, options)
    first = parsed_label(options.label)
    last = first if options.up_to is None else parsed_label(options.up_to)
    if last[0] < first[0] or last[1] < first[1]:
        parser.error(f"argument --up-to: '{options.up_to}': at least the impacts and periods of --label")
    labels = [f"{p}/{n}" for n in range(first[1], last[1] + 1) for p in range(first[0], last[0] + 1)]
    if last[0] > 1:
        from percuss.cli.simulation_progress import orbits_ready

        orbits_ready()
    with watching(parser, patience=PATIENCE) as watch:
        found = []
        for label in labels:
            with suppress(Interrupted):
                found.append(_searched(case, label, options, watch.asked))
            if watch.interrupted:
                break
        resting = None
        if options.up_to is not None and case.system().body.is_free and not watch.interrupted:
            with suppress(Interrupted), halting(watch.asked):
                resting = rest_cycles_answer(case, modes=options.modes, most=last[1])
    if not found:
        raise KeyboardInterrupt
    rests = [] if resting is None else sorted({cycle.label for cycle in resting.cycles if cycle.periods >= first[1]})
    if options.json:
        answers = [orbits_dict(one) for one in found]
        answers += [] if resting is None else [rest_cycles_dict(resting, label) for label in rests]
        print(json.dumps(answers if options.up_to is not None else answers[0], indent=1, allow_nan=False))
    else:
        from percuss.cli.report_printing import show

        mode = "elastic mode" if case.tables.body is None else "mode"
        show(orbits_report(case.title, found, resting, rests, mode))
    if watch.interrupted:
        done = sum(not one.halted for one in found)
        print(
            f"percuss: interrupted: the search is done for {done} of {counted(len(labels), 'label')}", file=sys.stderr
        )
        return 130
    return 0


def _searched(case: Case, label: str, options: argparse.Namespace, halt: Callable[[], bool]) -> FoundOrbits:
    from percuss.case import orbits_answer

    return orbits_answer(
        case,
        label,
        modes=options.modes,
        tries=options.tries,
        seed=options.seed,
        motions=options.motions,
        switch=options.switch,
        halt=halt,
    )


def _resting(case: Case, options: argparse.Namespace) -> int:
    """The cycles with rest of a label; returns the exit code."""
    from percuss.case.answers.exploring.orbits_answer import rest_cycles_answer, rest_cycles_dict

    label = options.label
    found = rest_cycles_answer(case, modes=options.modes)
    from percuss.case.answers.exploring.orbits_answer import rest_report
    from percuss.cli.report_printing import answered

    answered(options, lambda: rest_cycles_dict(found, label), lambda: rest_report(case.title, found, label), indent=1)
    return 0
