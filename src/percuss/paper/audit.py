"""All claims of B77's section 5 that were tried, as one result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from percuss._version import __version__
from percuss.paper.claim_beyond import Finding
from percuss.paper.claim_common import Claim, Size

__all__ = ["Audit"]


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
