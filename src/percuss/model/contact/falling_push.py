"""Chatter under a push that falls to 0: whether it is over before, and by how much (theory, Onset of chatter).

Where the push is j τ, a time τ before it vanishes, an impact is told by q = w/(j τ²), w the speed after it. The next
one follows σ τ later, q = σ/2 − σ²/6, and has q' = R (σ/2 − σ²/3)/(1 − σ)². One q comes back to itself, c: below it
the impacts pile up before the push is gone, above it they do not, and at c they pile up as it goes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

_STEPS, _MOST = 24, 100_000
_NEAR = 1e-9  # share of c within which the map is its derivative


@dataclass(frozen=True)
class FallingPush:
    """What happens under a push that falls to 0, for a restitution R in [0, 1)."""

    restitution: float

    @cached_property
    def shrinking(self) -> float:
        """1 − σ of the motion that ends as the push does: (3 − σ)(1 − σ)² = R (3 − 2σ), one root on [0, 1]."""
        left = 1.0
        for _ in range(_STEPS):  # each divides the error by 6 at least
            left = math.sqrt(self.restitution * (1.0 + 2.0 * left) / (2.0 + left))
        return left

    @property
    def flight(self) -> float:
        """σ of that motion."""
        return 1.0 - self.shrinking

    @cached_property
    def critical(self) -> float:
        """The value c of q."""
        return self.flight / 2.0 - self.flight**2 / 6.0

    @cached_property
    def growth(self) -> float:
        """The factor dq'/dq at c: R²/(1 − σ)⁵, as (t, w²/2) keeps its area in a flight; above 1. inf for R = 0."""
        left = self.shrinking
        return ((2.0 + left) / (1.0 + 2.0 * left)) ** 2 / left if left > 0.0 else math.inf

    def excess(self, q: float) -> float:
        """By how much q exceeds c, told so that an impact multiplies it by `growth`, however large it is; R > 0."""
        # The limit of growthⁿ (q₋ₙ − c), q₋ₙ ≥ 0 what q was n impacts before (G. Koenigs, Ann. Sci. Éc. Norm. Sup. (3)
        # 1 (1884) Suppl. 3–41).
        r, c, factor = self.restitution, self.critical, 1.0
        for _ in range(_MOST):
            if abs(q - c) <= _NEAR * c:
                break
            flight = 2.0 * q / (2.0 * q + 0.5 * r + math.sqrt(r * (q / 1.5 + 0.25 * r)))
            q, factor = flight / 2.0 - flight**2 / 6.0, factor * self.growth
            if factor > 1.0 / _NEAR:
                break
        return factor * (q - c)
