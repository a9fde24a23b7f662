"""The audit of what B77 claims in its section 5 (theory §8, a to f), and what it does not tell."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from percuss._version import __version__
from percuss.errors import PercussError
from percuss.model.checks import count
from percuss.paper.claim_beyond import Finding, beyond
from percuss.paper.claim_common import HOLDS, NOT, PARTLY, Claim, ClaimsProgress, Size, Trial
from percuss.paper.claim_ends import claim_a, ends_of
from percuss.paper.claim_hydraulic import claim_d, scatters_of
from percuss.paper.claim_periods import claim_b, claim_c
from percuss.paper.claim_ranges import claim_e
from percuss.paper.claim_stiffness import claim_f
from percuss.paper.report import report

__all__ = ["DEFAULT", "FULL", "HOLDS", "NOT", "PARTLY", "Audit", "Claim", "ClaimsProgress", "Size", "audit", "run"]

DEFAULT = Size(starts=60_000)
FULL = Size(starts=1_000_000)


@dataclass(frozen=True)
class Audit:
    """All claims tried, and what was found besides.

    Parameters
    ----------
    size, seed
        How much was tried for each claim, and the seed of all starts.
    claims
        a to f.
    findings
        What B77 does not tell.
    """

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
    trial = Trial(size, count("seed", seed, least=0), progress)
    ends, scatters = ends_of(trial), scatters_of(trial)
    claims = (
        claim_a(trial, ends),
        claim_b(trial),
        claim_c(trial),
        claim_d(trial, scatters),
        claim_e(trial, scatters),
        claim_f(trial),
    )
    return Audit(size, seed, claims, tuple(beyond(trial, ends)))


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
        When `progress` asked for the end; nothing is written then.
    """
    target = Path(directory)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PercussError(f"{target}: cannot be made: {error.strerror or error}", "give another folder") from None
    if not os.access(target, os.W_OK):
        raise PercussError(f"{target}: cannot be written to", "give another folder")
    found = audit(size or (FULL if full else DEFAULT), seed, progress)
    text = json.dumps(found.to_json_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    for name, content in (("claims.json", text), ("REPORT.md", report(found))):
        try:
            (target / name).write_text(content, encoding="utf-8")
        except OSError as error:
            raise PercussError(
                f"{target / name}: cannot be written: {error.strerror or error}", "make room, or give another folder"
            ) from None
    return found
