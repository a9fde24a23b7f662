"""Shares of attractors among random starts, with intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING

from percuss.errors import ParameterError
from percuss.model.checks import count, finite
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import AnyAttractor

__all__ = ["CONFIDENCE", "Share", "share_of", "wilson"]

CONFIDENCE = 0.95


def wilson(successes: int, trials: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Wilson's interval of a probability, from counts; (0, 1) when nothing was tried.

    It never leaves [0, 1] and has its confidence, nearly, at 0 and at all successes too.

    Raises
    ------
    ParameterError
        For counts below 0, more successes than trials, or a confidence outside (0, 1).

    References
    ----------
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209–212, doi:10.1080/01621459.1927.10502953.

    Examples
    --------
    >>> [round(x, 5) for x in wilson(8, 10)]
    [0.49016, 0.94332]
    """
    n, k = count("trials", trials, least=0), count("successes", successes, least=0)
    c = finite("confidence", confidence)
    if k > n:
        raise ParameterError("successes", successes, f"at most the number of trials, {n}")
    if not 0.0 < c < 1.0:
        raise ParameterError("confidence", confidence, "a number between 0 and 1")
    if n == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + 0.5 * c)
    share, fade = k / n, z * z / n
    middle = (share + 0.5 * fade) / (1.0 + fade)
    half = z / (1.0 + fade) * math.sqrt(share * (1.0 - share) / n + 0.25 * fade / n)
    return (0.0 if k == 0 else max(middle - half, 0.0)), (1.0 if k == n else min(middle + half, 1.0))


@dataclass(frozen=True)
class Share(Shown):
    """The share of the starts that ends in an attractor.

    Parameters
    ----------
    attractor
        Which.
    share, low, high
        The part, and Wilson's interval of 95 % of its probability.
    """

    attractor: AnyAttractor
    share: float
    low: float
    high: float

    @property
    def label(self) -> str:
        """The label of the motion, as `Trajectory.label` or `MachineTrajectory.label` gives it."""
        return self.attractor.label

    @property
    def members(self) -> int:
        """How many starts end there."""
        return self.attractor.members

    @property
    def phases(self) -> tuple[float, ...]:
        """Load phases (rad) of the impacts of one cycle, from the fastest on; empty without a period or a clock."""
        return self.attractor.phases

    @property
    def impact_velocities(self) -> tuple[float, ...]:
        """Striking speeds of the same."""
        return self.attractor.impact_velocities

    def __str__(self) -> str:
        return f"{self.label}: {self.share:.4%} ({self.low:.4%} … {self.high:.4%})"


def share_of(attractor: AnyAttractor, starts: int) -> Share:
    """The share of an attractor among so many starts."""
    return Share(attractor, attractor.members / starts, *wilson(attractor.members, starts))
