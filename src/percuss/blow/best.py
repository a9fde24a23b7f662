"""The best blow within ranges, under a limit of stress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.blow.figures import FIGURES, BlowOutcome
from percuss.errors import ConvergenceError, ParameterError, PercussError
from percuss.model.checks import callback, choice, count, finite, positive
from percuss.optimum import Candidate, SearchProgress, best_place

if TYPE_CHECKING:
    from percuss.blow.blow import Blow

OBJECTIVES = {
    "rock-energy": ("rock_energy", 1.0),
    "efficiency": ("rock_efficiency", 1.0),
    "incident-energy": ("incident_energy", 1.0),
    "peak-stress": ("peak_stress", -1.0),
}
"""What a search may look for: the figure, and whether more of it is better (1) or less (−1)."""


@dataclass(frozen=True)
class Best:
    """What a search has found: the values, one for each range, the blow there, and the value of its figure.

    `allowed`: whether its stress is below the limit; where no blow's was, the one of least stress is told. `blows` is
    how many were computed, `complete` false where `progress` ended the search.
    """

    values: tuple[float, ...]
    blow: Blow
    value: float
    allowed: bool
    blows: int
    complete: bool = True


def best_blow(
    made: Callable[[tuple[float, ...]], Blow],
    ranges: Sequence[tuple[float, float]],
    objective: str = "rock-energy",
    *,
    below: float | None = None,
    first: Sequence[float] | None = None,
    seed: int = 0,
    most: int = 1500,
    progress: Callable[[SearchProgress], object] | None = None,
) -> Best:
    """The best blow within ranges, by `percuss.optimum.best_place`.

    Parameters
    ----------
    made
        The blow at values, one for each range; a `PercussError` says that there is none.
    ranges, first
        Least and greatest value of each, and values to begin with, inside the ranges.
    objective, below
        One of `OBJECTIVES`, and a limit of the greatest stress in striker and rod, in Pa (dimensionless: the force).
    seed, most
        Of the random places: the same seed finds the same blow. About how many blows are computed.
    progress
        Called before each blow with a `SearchProgress`; something true ends the search with the best so far.

    Raises
    ------
    ParameterError
        For values out of range, or where no place in the ranges has such a figure.
    Interrupted
        When `progress` ended it before there was any blow.
    MissingExtraError
        When scipy is not installed.

    Examples
    --------
    >>> from percuss.blow import Rock, Rod, strike
    >>> from percuss.model import Bar, Section
    >>> def struck(values):
    ...     rod = Rod([Section(1.0, area=1e-3)], "rock", rock=Rock(1e8, 0.5))
    ...     return strike(Bar(values[0], 1e-3), rod, 10.0, until=5e-4)
    >>> found = best_blow(struck, [(0.1, 0.4)], "efficiency", most=60)
    >>> round(found.values[0], 3), round(found.value, 3)
    (0.4, 0.322)
    """
    choice("objective", objective, *OBJECTIVES)
    limits = [_range(i, one) for i, one in enumerate(ranges)]
    if not limits:
        raise ParameterError("ranges", ranges, "one range or more")
    most, seed = count("most", most, 20, 10**7), count("seed", seed, 0, 2**32 - 1)
    callback("progress", progress)
    limit = None if below is None else positive("below", below)
    figure, sign = OBJECTIVES[objective]

    def candidate(values: tuple[float, ...]) -> Candidate[Blow]:
        blow = made(values)
        if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
            raise ConvergenceError("the waves of such a blow have too many pieces", "leave out short sections")
        slacks = () if limit is None else (1.0 - (FIGURES["peak_stress"].value(blow) or 0.0) / limit,)
        return Candidate(blow, FIGURES[figure].value(blow), slacks)

    found = best_place(candidate, limits, greatest=sign > 0.0, first=first, seed=seed, most=most, progress=progress)
    if found is None or isinstance(found, PercussError):
        why = "" if found is None else f"the last refusal: {found}"
        raise ParameterError("ranges", limits, "ranges in which a blow has this figure", why)
    return Best(
        found.values, found.candidate.thing, found.candidate.value or 0.0, found.allowed, found.tried, found.complete
    )


def _range(number: int, given: tuple[float, float]) -> tuple[float, float]:
    low, high = (finite(f"ranges[{number}]", one) for one in given)
    if not low < high:
        raise ParameterError(f"ranges[{number}]", given, "two different ends, the smaller one first")
    return low, high
