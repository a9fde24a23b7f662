"""The audit of what B77 claims in its section 5 (theory §8, a to f), and what it does not tell."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from percuss._version import __version__
from percuss.errors import Interrupted, PercussError
from percuss.model.checks import count
from percuss.paper.audit import Audit
from percuss.paper.claim_beyond import beyond
from percuss.paper.claim_common import HOLDS, NOT, PARTLY, Claim, ClaimsProgress, Size, Table, Trial, Verdict
from percuss.paper.claim_ends import End, claim_a, ends_of
from percuss.paper.claim_hydraulic import Scatter, claim_d, scatters_of
from percuss.paper.claim_periods import claim_b, claim_c
from percuss.paper.claim_ranges import claim_e
from percuss.paper.claim_stiffness import claim_f
from percuss.paper.report import report
from percuss.whole_file import write_whole

__all__ = ["DEFAULT", "FULL", "HOLDS", "NOT", "PARTLY", "Audit", "Claim", "ClaimsProgress", "Size", "audit", "run"]

DEFAULT = Size(starts=60_000)
FULL = Size(starts=1_000_000)

PART = "claims.part.json"
"""The finished claims of an audit that is not."""

LOST = "the claim in progress is lost, finished ones are kept: ask for the same again to continue"


def audit(size: Size = DEFAULT, seed: int = 1, progress: Callable[[ClaimsProgress], object] | None = None) -> Audit:
    """Try every claim.

    Parameters
    ----------
    size
        How much is tried for each.
    seed
        Of all starts; the same seed gives the same numbers.
    progress
        Called with a `ClaimsProgress`; something true ends the audit.

    Raises
    ------
    Interrupted
        When `progress` asked for the end.
    """
    return _tried(Trial(size, count("seed", seed, least=0), progress), lambda _, make, __: make())


Keep = Callable[[str, Callable[[], Any], Callable[[Any], Any]], Any]
"""A part of the audit: its name, what makes it, and what makes it of JSON's types."""


def _tried(trial: Trial, keep: Keep) -> Audit:
    ends: list[End] = keep("ends", lambda: ends_of(trial), _ends)
    a = keep("a", lambda: claim_a(trial, ends), _claim)
    b = keep("b", lambda: claim_b(trial), _claim)
    c = keep("c", lambda: claim_c(trial), _claim)
    scatters: list[Scatter] = keep(
        "scatters", lambda: scatters_of(trial), lambda rows: [Scatter(**row) for row in rows]
    )
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
    seed
        Of all starts.
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
        Table(table["title"], tuple(table["columns"]), tuple(tuple(row) for row in table["rows"]))
        for table in tree["tables"]
    )
    verdict, remarks = Verdict(**tree["verdict"]), tuple(tree["remarks"])
    return Claim(**{**tree, "verdict": verdict, "tables": tables, "remarks": remarks})


def _ends(rows: Any) -> list[End]:
    return [End(**{**row, "labels": {name: tuple(share) for name, share in row["labels"].items()}}) for row in rows]
