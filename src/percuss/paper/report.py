"""The audit as a page that people read."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from percuss.paper.claim_ends import starts_each

if TYPE_CHECKING:
    from percuss.paper.audit import Audit
    from percuss.paper.claim_common import Claim, Table

__all__ = ["report", "table_text"]

_SOURCE = (
    "U. Björkenstam, *Impact vibration of a bar*, International Journal of Mechanical Sciences **19** (1977) 471–481, "
    "cited as B77"
)
_STARTS = """All starts are rigid, with a load phase uniform over a period:

- `wall`: on the wall, leaving with the speed |N(0, 1)| · 2πp_0/(1 + R);
- `field`: position uniform in [−20, 0], velocity 5 · N(0, 1);
- `gentle`: on the wall, leaving with a speed uniform in (0, 0.2).

The starts of a distribution are drawn once, with one seed: all rows of a table have the same ones ({shared:,} of each
distribution in claim a), those of `wall` in units of its speed. Rows can therefore be compared start by start, but
chance does the same to all of them: the interval of a row holds for that row, and one over several rows is too narrow.

A motion is called `z=p/n` when it has p impacts in n load periods and no rest, `chatter/n` or `rest/n` when it is a
cycle of n load periods in which the bar lies on the wall for some time, after complete chatter or after finitely many
impacts, `rest` when it lies there for good, `aperiodic` when the last impacts come near none of those before, and
`undecided` when none of this could be shown. Intervals in brackets are Wilson's, 95 %."""


def report(audit: Audit) -> str:
    """The whole page, in Markdown."""
    from percuss._version import __version__

    parts = [
        "# The claims of B77, tested",
        f"Source: {_SOURCE}. Made by percuss {__version__}: {audit.size.starts:,} starts for each claim, at most "
        f"{audit.size.impacts:,} impacts each, seed {audit.seed}. Every verdict is computed from the numbers by the "
        "rule stated with it; `claims.json` has the numbers.",
        _verdicts(audit.claims),
        "## The starts, and the names of motions",
        _STARTS.format(shared=starts_each(audit.size)),
        *(_claim(claim) for claim in audit.claims),
        "## What the paper does not report",
        *(f"### {found.title}\n\n{found.text}\n\n{table_text(found.table)}" for found in audit.findings),
    ]
    return "\n\n".join(parts) + "\n"


def _verdicts(claims: tuple[Claim, ...]) -> str:
    rows = [f"| {claim.letter} | {claim.claim} | **{claim.verdict.verdict}** |" for claim in claims]
    return "\n".join(["| | claim | verdict |", "| --- | --- | --- |", *rows])


def _claim(claim: Claim) -> str:
    numbers = "\n".join(f"- {name}: {_cell(value)}" for name, value in claim.numbers.items())
    return "\n\n".join(
        [
            f"## {claim.letter}. {claim.title[0].upper()}{claim.title[1:]}",
            f"**Claim.** {claim.claim}",
            f"**What was done.** {claim.done} In all {claim.starts:,} motions.",
            f"**Rule.** {claim.rule}",
            f"**Verdict: {claim.verdict.verdict}.** {claim.verdict.where[:1].upper()}{claim.verdict.where[1:]}.",
            *(claim.remarks),
            f"**Numbers.**\n\n{numbers}",
            *(table_text(table) for table in claim.tables),
        ]
    )


def table_text(table: Table) -> str:
    """A table in Markdown, its title above."""
    head = f"| {' | '.join(table.columns)} |"
    line = f"| {' | '.join('---' for _ in table.columns)} |"
    rows = [f"| {' | '.join(_cell(cell) for cell in row)} |" for row in table.rows]
    return "\n".join([f"*{table.title}*", "", head, line, *rows])


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and abs(value) < 1e-9:
        return "0"
    if isinstance(value, float):
        return "–" if not math.isfinite(value) else f"{value:.4g}" if abs(value - 1.0) > 1e-2 else f"{value:.7g}"
    return str(value).replace("|", "\\|")
