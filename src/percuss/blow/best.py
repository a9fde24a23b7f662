"""The best blow within ranges, under a limit of stress."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.blow.figures import FIGURES, BlowOutcome
from percuss.errors import ConvergenceError, Interrupted, ParameterError, PercussError, extra_package
from percuss.model.checks import Array, callback, choice, count, finite, positive

if TYPE_CHECKING:
    from percuss.blow.blow import Blow

OBJECTIVES = {
    "rock-energy": ("rock_energy", 1.0),
    "efficiency": ("rock_efficiency", 1.0),
    "incident-energy": ("incident_energy", 1.0),
    "peak-stress": ("peak_stress", -1.0),
}
"""What a search may look for: the figure, and whether more of it is better (1) or less (−1)."""

_NONE = 1e9  # cost of a blow that there is not

_LOCAL = 0.25  # share of the blows that is kept for the search around the best place

_PER_RANGE = 10  # places per range in each generation

_EDGE = 0.05  # of the first simplex, inside the unit cube


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


class _Ended(Exception):
    """The progress callback has ended the search."""


@dataclass
class _Search:
    """Costs of places in the unit cube: above the limit by how much, else below 0 (Deb 2000); keeps the best."""

    made: Callable[[tuple[float, ...]], Blow]
    ranges: Array
    objective: str
    below: float | None
    most: int
    progress: Callable[[int, int], bool] | None
    blows: int = 0
    cost: float = inf
    best: tuple[tuple[float, ...], Blow, float] | None = None
    refused: PercussError | None = None

    def place(self, values: Sequence[float]) -> Array:
        """Where values lie in the unit cube."""
        low, high = self.ranges.T
        return np.asarray(np.clip((np.asarray(values, dtype=float) - low) / (high - low), 0.0, 1.0))

    def __call__(self, place: Array) -> float:
        if self.progress is not None and self.progress(self.blows, self.most):
            raise _Ended
        self.blows += 1
        low, high = self.ranges.T
        values = tuple(np.clip(low + (high - low) * np.asarray(place), low, high).tolist())
        try:
            blow = self.made(values)
            if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
                raise ConvergenceError("the waves of such a blow have too many pieces", "leave out short sections")
        except Interrupted:
            raise
        except PercussError as error:
            self.refused = error
            return _NONE
        figure, sign = OBJECTIVES[self.objective]
        value = FIGURES[figure].value(blow)
        if value is None:
            return _NONE
        stress = (FIGURES["peak_stress"].value(blow) or 0.0) if self.below is not None else 0.0
        if self.below is not None and stress > self.below:
            cost = stress / self.below - 1.0
        else:
            cost = -value if sign > 0.0 else -1.0 / max(value, 1e-300)
        if cost < self.cost:
            self.cost, self.best = cost, (values, blow, value)
        return cost


def best_blow(
    made: Callable[[tuple[float, ...]], Blow],
    ranges: Sequence[tuple[float, float]],
    objective: str = "rock-energy",
    *,
    below: float | None = None,
    first: Sequence[float] | None = None,
    seed: int = 0,
    most: int = 1500,
    progress: Callable[[int, int], bool] | None = None,
) -> Best:
    """The best blow within ranges: differential evolution (Storn & Price 1997), then a simplex (Nelder & Mead 1965).

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
        Called before each blow with the number of those done and of all; true ends the search with the best so far.

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
    limits = np.array([_range(i, one) for i, one in enumerate(ranges)]).reshape(-1, 2)
    if not limits.size:
        raise ParameterError("ranges", ranges, "one range or more")
    most, seed = count("most", most, 20, 10**7), count("seed", seed, 0, 2**32 - 1)
    callback("progress", progress)
    search = _Search(made, limits, objective, None if below is None else positive("below", below), most, progress)
    complete = True
    try:
        _searched(search, first, seed)
    except _Ended:
        complete = False
    if search.best is None and not complete:
        raise Interrupted(search.blows, most, None, "no blow has been found yet")
    if search.best is None:
        why = "" if search.refused is None else f"the last refusal: {search.refused}"
        raise ParameterError("ranges", limits.tolist(), "ranges in which a blow has this figure", why)
    values, blow, value = search.best
    return Best(values, blow, value, search.cost < 0.0, search.blows, complete)


def _searched(search: _Search, first: Sequence[float] | None, seed: int) -> None:
    extra_package("scipy", "io")
    from scipy.optimize import Bounds, differential_evolution, minimize

    start = None
    if first is not None:
        start = search.place(first)
        search(start)
    ranges = len(search.ranges)
    size = max(5, _PER_RANGE * ranges)
    rounds = max(1, int((1.0 - _LOCAL) * search.most) // size - 1)
    unit = Bounds(np.zeros(ranges), np.ones(ranges))
    differential_evolution(
        search, unit, popsize=_PER_RANGE, maxiter=rounds, tol=1e-4, seed=seed, polish=False, x0=start
    )
    if search.best is None:
        return
    place = search.place(search.best[0])
    options: Any = {
        "maxfev": max(10, int(_LOCAL * search.most)),
        "xatol": 1e-6,
        "fatol": 1e-9 * abs(search.cost),
        "initial_simplex": [place, *(place + np.diag(np.where(place + _EDGE <= 1.0, _EDGE, -_EDGE)))],
    }
    minimize(search, place, method="Nelder-Mead", bounds=unit, options=options)


def _range(number: int, given: tuple[float, float]) -> tuple[float, float]:
    low, high = (finite(f"ranges[{number}]", one) for one in given)
    if not low < high:
        raise ParameterError(f"ranges[{number}]", given, "two different ends, the smaller one first")
    return low, high
