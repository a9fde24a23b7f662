"""``percuss paper``: B77's figures and claims, reproduced."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.cli.app import raw
from percuss.cli.arguments import Parser, need
from percuss.errors import Interrupted

if TYPE_CHECKING:
    from percuss.paper.claim_common import ClaimsProgress

NAMES = ("fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "elastic", "claims")
ALL = "all"

_DESCRIPTION = """\
The figures of B77 (U. Bjoerkenstam, Impact vibration of a bar, 1977) as CSV, SVG and PNG, made from the theory; the
package's own figures of what an elastic bar adds; and the claims of its section 5, tested and judged.

  fig2, fig3   the loads                            fig6   the same, ten load periods to an impact
  fig4         impact phase, pneumatic hammer       fig7   impact phase, hydraulic hammer
  fig5         range of stable motions over R       fig8   range in which motions exist over R
  elastic      how s changes all this                 claims the claims: claims.json and REPORT.md"""

_EXAMPLES = """\
  percuss paper -o figures
  percuss paper fig4 fig5 -o figures
  percuss paper claims --full --seed 7 -o audit"""


_LOST = "the claim in progress is lost; finished ones are kept, and the same command continues with the next"


def _parser() -> Parser:
    parser = Parser("paper", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("names", metavar="NAME", nargs="*", help=f"{', '.join(NAMES)} or {ALL} (default {ALL})")
    parser.add_argument(
        "-o", "--output", metavar="DIR", required=True, help="directory of the files, created if needed"
    )
    parser.add_argument("--full", action="store_true", help="10^6 starts for each claim; an hour or two, not minutes")
    parser.add_argument("--seed", metavar="N", type=int, default=None, help="seed of all random numbers")
    return parser


def run(arguments: Sequence[str]) -> int:
    """Make what is named; returns the exit code."""
    parser = _parser()
    options = parser.parsed(arguments)
    names = _named(parser, options.names)
    if options.seed is not None and options.seed < 0:
        parser.error(f"argument --seed: '{options.seed}': give a whole number, 0 or greater")
    folder = Path(options.output)
    if folder.exists() and not folder.is_dir():
        parser.error(f"argument -o: '{folder}' is not a directory")
    figures = [name for name in names if name != "claims"]
    seed = {} if options.seed is None else {"seed": options.seed}
    if figures:
        need("matplotlib", "plot")
        from percuss.paper import write_figures

        for path in write_figures(figures, folder, **seed):
            print(path, flush=True)
    if "claims" in names:
        from percuss.paper import claims

        watch = _watch()
        try:
            claims.run(folder, full=options.full, progress=watch, **seed)
        except (Interrupted, KeyboardInterrupt) as stop:
            kept = stop.archive if isinstance(stop, Interrupted) else None
            raise Interrupted(watch.done, watch.steps, kept, _LOST) from None
        for name in ("claims.json", "REPORT.md"):
            print(folder / name)
    return 0


def _named(parser: Parser, given: list[str]) -> list[str]:
    """The names once each, in the order of the paper."""
    for name in given:
        if name not in (*NAMES, ALL):
            from percuss.errors import did_you_mean

            hint = did_you_mean(name, [*NAMES, ALL])
            there_are = f"the names are {', '.join(NAMES)} and {ALL}"
            parser.error(f"argument NAME: '{name}': {there_are}{f' — {hint}' if hint else ''}")
    return [name for name in NAMES if not given or ALL in given or name in given]


class _Watch:
    """Says on stderr which part of the claims is tried, once each, or how far it is when a person looks."""

    def __init__(self) -> None:
        self.part, self.done, self.steps = "", 0, 0

    def __call__(self, progress: ClaimsProgress) -> bool:
        person = sys.stderr is not None and sys.stderr.isatty()
        if person:
            told = f"\r\x1b[K{progress.part}: {progress.done} of {progress.steps}"
            print(told, end="", file=raw(sys.stderr), flush=True)
            if progress.done >= progress.steps:
                print(file=sys.stderr)
        elif progress.part != self.part:
            print(f"trying {progress.part}", file=sys.stderr, flush=True)
        self.part, self.done, self.steps = progress.part, progress.done, progress.steps
        return False


def _watch() -> _Watch:
    return _Watch()
