"""The audit of what B77 claims in its section 5 (theory §8, a to f), and what it does not tell."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from percuss._version import __version__
from percuss.atomic_write import write_whole
from percuss.errors import Interrupted, PercussError
from percuss.model.checks import count
from percuss.paper.claim_common import Claim, ClaimsProgress, ClaimTable, Size, Trial, Verdict
from percuss.paper.claim_hydraulic import Finding, Scatter, beyond, claim_d, scatters_of
from percuss.paper.claim_pneumatic import StartsEnd, claim_a, claim_b, claim_c, ends_of, starts_each
from percuss.paper.claim_stability import claim_e, claim_f

# ---- All claims of B77's section 5 that were tried, as one result


@dataclass(frozen=True)
class Audit:
    """All claims tried, a to f, how much was tried for each, and what was found besides that B77 does not tell."""

    size: Size
    seed: int
    claims: tuple[Claim, ...]
    findings: tuple[Finding, ...]

    def to_json_dict(self) -> dict[str, Any]:
        """What ``claims.json`` holds."""
        return {
            "percuss": __version__,
            "starts_per_claim": self.size.starts,
            "impacts": self.size.impacts,
            "seed": self.seed,
            "claims": {claim.letter: claim.to_json_dict() for claim in self.claims},
            "beyond": [
                {"title": found.title, "text": found.text, "rows": found.table.records()} for found in self.findings
            ],
        }


# ---- The audit as a page that people read

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
    verdicts = [f"| {claim.letter} | {claim.claim} | **{claim.verdict.verdict}** |" for claim in audit.claims]
    parts = [
        "# The claims of B77, tested",
        f"Source: {_SOURCE}. Made by percuss {__version__}: {audit.size.starts:,} starts for each claim, at most "
        f"{audit.size.impacts:,} impacts each, seed {audit.seed}. Every verdict is computed from the numbers by the "
        "rule stated with it; `claims.json` has the numbers.",
        "\n".join(["| | claim | verdict |", "| --- | --- | --- |", *verdicts]),
        "## The starts, and the names of motions",
        _STARTS.format(shared=starts_each(audit.size)),
        *(_claim_section(claim) for claim in audit.claims),
        "## What the paper does not report",
        *(f"### {found.title}\n\n{found.text}\n\n{table_text(found.table)}" for found in audit.findings),
    ]
    return "\n\n".join(parts) + "\n"


def _claim_section(claim: Claim) -> str:
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


def table_text(table: ClaimTable) -> str:
    """A table in Markdown, its title above."""
    lines = (table.columns, ["---"] * len(table.columns), *([_cell(cell) for cell in row] for row in table.rows))
    return "\n".join([f"*{table.title}*", "", *(f"| {' | '.join(line)} |" for line in lines)])


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


# ---- The audit of what B77 claims in its section 5 (theory §8, a to f), and what it does not tell

DEFAULT = Size(starts=60_000)
FULL = Size(starts=1_000_000)

PART = "claims.part.json"  # the finished claims of an audit that is not

LOST = "the claim in progress is lost, finished ones are kept: ask for the same again to continue"


def audit(size: Size = DEFAULT, seed: int = 1, progress: Callable[[ClaimsProgress], object] | None = None) -> Audit:
    """Try every claim and write nothing; see `run`. The same seed gives the same numbers."""
    return _tried(Trial(size, count("seed", seed, least=0), progress), lambda _, make, __: make())


Keep = Callable[[str, Callable[[], Any], Callable[[Any], Any]], Any]
"""A part of the audit: its name, what makes it, and what makes it of JSON's types."""


def _tried(trial: Trial, keep: Keep) -> Audit:
    ends: list[StartsEnd] = keep("ends", lambda: ends_of(trial), _ends)
    a = keep("a", lambda: claim_a(trial, ends), _claim)
    b = keep("b", lambda: claim_b(trial), _claim)
    c = keep("c", lambda: claim_c(trial), _claim)
    scatters = keep("scatters", lambda: scatters_of(trial), lambda rows: [Scatter(**row) for row in rows])
    d = keep("d", lambda: claim_d(trial, scatters), _claim)
    e = keep("e", lambda: claim_e(trial, scatters), _claim)
    f = keep("f", lambda: claim_f(trial), _claim)
    return Audit(trial.size, trial.seed, (a, b, c, d, e, f), tuple(beyond(trial, ends)))


def run(
    directory: str | os.PathLike[str],
    full: bool = False,
    seed: int = 1,
    progress: Callable[[ClaimsProgress], object] | None = None,
    *,
    size: Size | None = None,
) -> Audit:
    """Try every claim and write ``claims.json`` and ``REPORT.md``.

    Parameters
    ----------
    directory
        Made when it does not exist; files of these names are replaced.
    full
        10⁶ starts for each claim; a few minutes become an hour or so.
    progress
        Called with a `ClaimsProgress`; something true ends the audit.
    size
        Instead of the two sizes.

    Raises
    ------
    PercussError
        When the files cannot be written.
    Interrupted
        When `progress` asked for the end, or after Ctrl-C. The finished claims are kept in ``claims.part.json``, and
        the same call goes on with the next.
    """
    target = Path(directory)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PercussError(f"{target}: cannot be made: {error.strerror or error}", "give another folder") from None
    if not os.access(target, os.W_OK):
        raise PercussError(f"{target}: cannot be written to", "give another folder")
    trial = Trial(size or (FULL if full else DEFAULT), count("seed", seed, least=0), progress)
    parts = _Parts(target / PART, trial)
    try:
        found = _tried(trial, parts.keep)
    except Interrupted as stop:
        kept = str(parts.path) if parts.path.exists() else None
        raise Interrupted(stop.done, stop.size, kept, LOST) from None
    text = json.dumps(found.to_json_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    for name, content in (("claims.json", text), ("REPORT.md", report(found))):
        write_whole(target / name, content)
    with suppress(OSError):
        parts.path.unlink()
    return found


# -- finished parts -------------------------------------------------------------------------------------------------


class _Parts:
    """The finished parts of an audit of one size, seed and version, in a file: the next run goes on with the others."""

    def __init__(self, path: Path, trial: Trial) -> None:
        self.path = path
        self.tree: dict[str, Any] = {"percuss": __version__, **asdict(trial.size), "seed": trial.seed}
        kept: dict[str, Any] = {}
        with suppress(OSError, ValueError, KeyError, TypeError, RecursionError):  # no such file, or none of ours
            found = json.loads(path.read_text(encoding="utf-8"))
            kept = dict(found.pop("parts")) if isinstance(found, dict) else {}
            kept = kept if found == self.tree else {}
        self.tree["parts"] = kept

    def keep(self, name: str, make: Callable[[], Any], revive: Callable[[Any], Any]) -> Any:
        """A part from the file, or made and written there; either way as it is read from there."""
        parts = self.tree["parts"]
        if name in parts:
            with suppress(ValueError, KeyError, TypeError, AttributeError):
                return revive(parts[name])
        made = make()
        plain = [asdict(item) for item in made] if isinstance(made, list) else asdict(made)
        parts[name] = json.loads(json.dumps(plain, default=lambda number: number.tolist()))
        write_whole(self.path, json.dumps(self.tree, ensure_ascii=False))
        return revive(parts[name])


def _claim(tree: Any) -> Claim:
    tables = tuple(
        ClaimTable(table["title"], tuple(table["columns"]), tuple(tuple(row) for row in table["rows"]))
        for table in tree["tables"]
    )
    verdict, remarks = Verdict(**tree["verdict"]), tuple(tree["remarks"])
    return Claim(**{**tree, "verdict": verdict, "tables": tables, "remarks": remarks})


def _ends(rows: Any) -> list[StartsEnd]:
    return [
        StartsEnd(**{**row, "labels": {name: tuple(share) for name, share in row["labels"].items()}}) for row in rows
    ]
