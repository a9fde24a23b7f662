"""The best place within ranges, under limits: one search for all that is made of some numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, PercussError, extra_package

Thing = TypeVar("Thing")

_Array = npt.NDArray[np.float64]

_NOTHING = 1e9  # cost where nothing can be made

_FAULTY = 1e6  # of one that cannot be used, however well it keeps the limits

_LOCAL = 0.25  # share of all that is kept for the search around the best place

_PER_RANGE = 10  # places per range in each generation

_EDGE = 0.05  # of the first simplex, inside the unit cube

_NO_WORTH = 2.0  # what the polish takes for the value, about 1, where there is nothing

_INSIDE = 1e-7  # share of a limit that the polish stays away from it


class Candidate(NamedTuple, Generic[Thing]):
    """What was made at a place: its figure, None where it has none, and how far it is inside each limit.

    `slacks` are shares of the limits, negative beyond them. A `fault` greater than 0 says that it cannot be used at
    all, and how far it is from that.
    """

    thing: Thing
    value: float | None
    slacks: tuple[float, ...] = ()
    fault: float = 0.0

    @property
    def excess(self) -> float:
        """Sum of what it is beyond its limits."""
        return sum(max(0.0, -slack) for slack in self.slacks)


class Found(NamedTuple, Generic[Thing]):
    """The best place, what was made there, whether it keeps all limits, how many were made, and whether to the end."""

    values: tuple[float, ...]
    candidate: Candidate[Thing]
    allowed: bool
    tried: int
    complete: bool


@dataclass(frozen=True)
class SearchProgress:
    """How far a search has come: how many were made, of about how many, and the best so far that keeps all limits."""

    tried: int
    most: int
    best: float | None = None

    @property
    def fraction(self) -> float:
        """0 to 1."""
        return min(self.tried / self.most, 1.0)


class _Ended(Exception):
    """The progress callback has ended the search."""


@dataclass
class _Search(Generic[Thing]):
    """Costs of places in the unit cube: beyond the limits by how much, else below 0 (Deb 2000); keeps the best."""

    made: Callable[[tuple[float, ...]], Candidate[Thing]]
    ranges: _Array
    greatest: bool
    most: int
    progress: Callable[[SearchProgress], object] | None
    tried: int = 0
    cost: float = inf
    best: tuple[tuple[float, ...], Candidate[Thing]] | None = None
    refused: PercussError | None = None
    _rows: dict[bytes, _Array] = field(default_factory=dict)

    def place(self, values: Sequence[float]) -> _Array:
        """Where values lie in the unit cube."""
        low, high = self.ranges.T
        return np.asarray(np.clip((np.asarray(values, dtype=float) - low) / (high - low), 0.0, 1.0))

    def __call__(self, place: _Array) -> float:
        return self.judged(place)[0]

    def judged(self, place: _Array) -> tuple[float, Candidate[Thing] | None]:
        """The cost of a place and what was made there."""
        allowed = self.best[1].value if self.best is not None and self.cost < 0.0 else None
        if self.progress is not None and self.progress(SearchProgress(self.tried, self.most, allowed)):
            raise _Ended
        self.tried += 1
        low, high = self.ranges.T
        values = tuple(np.clip(low + (high - low) * np.asarray(place), low, high).tolist())
        try:
            candidate = self.made(values)
        except Interrupted:
            raise
        except PercussError as error:
            self.refused = error
            return _NOTHING, None
        if candidate.value is None:
            return _NOTHING, None
        if candidate.fault > 0.0:
            cost = _FAULTY * (1.0 + candidate.fault) + min(candidate.excess, _FAULTY)
        else:
            cost = candidate.excess or -self._worth(candidate.value)
        if cost < self.cost:
            self.cost, self.best = cost, (values, candidate)
        return cost, candidate

    def _worth(self, value: float) -> float:
        """A number greater than 0 that is the greater the better the value."""
        positive = value if value > 1e-100 else 1e-100 / (1.0 - value)
        return positive if self.greatest else 1.0 / positive

    def row(self, place: _Array, scale: float) -> _Array:
        """The value, the less the better, and the slacks at a place; kept, as the polish asks again."""
        key = place.tobytes()
        if key not in self._rows:
            candidate = self.judged(place)[1]
            if candidate is None or candidate.value is None or candidate.fault > 0.0:
                limits = 0 if self.best is None else len(self.best[1].slacks)
                self._rows[key] = np.array([_NO_WORTH, *(-1.0 for _ in range(limits))])
            else:
                value = (-candidate.value if self.greatest else candidate.value) / scale
                self._rows[key] = np.array([value, *(slack - _INSIDE for slack in candidate.slacks)])
        return self._rows[key]


def best_place(
    made: Callable[[tuple[float, ...]], Candidate[Thing]],
    ranges: Sequence[tuple[float, float]],
    *,
    greatest: bool = True,
    first: Sequence[float] | None = None,
    seed: int = 0,
    most: int = 1500,
    progress: Callable[[SearchProgress], object] | None = None,
    finely: Callable[[tuple[float, ...]], Candidate[Thing]] | None = None,
) -> Found[Thing] | PercussError | None:
    """The place within ranges whose figure is the greatest, or the least, of those that keep all limits.

    Differential evolution (Storn & Price 1997) with the rules of Deb (2000): what keeps its limits goes before what
    does not, and of two that do not, the one that is beyond them by less. Then, around the best place, quadratic models
    in a region of trust (COBYQA, Ragonneau 2022), which go along limits; without limits then a simplex (Nelder & Mead
    1965), which takes kinks.

    Parameters
    ----------
    made, finely
        What there is at values, one for each range; a `PercussError` says that there is nothing. Around the best place
        `finely` makes it, where that is given.
    ranges, first
        Least and greatest value of each, and values to begin with, inside the ranges.
    seed, most
        Of the random places: the same seed finds the same place. About how many are made.
    progress
        Called before each with a `SearchProgress`; something true ends the search with the best so far.

    Returns
    -------
    What was found; the last refusal where nothing could be made anywhere, None where that gave no reason.

    Raises
    ------
    Interrupted
        When `progress` ended it before there was anything.
    MissingExtraError
        When scipy is not installed.

    Examples
    --------
    The greatest area of a rectangle whose sides are 3 m long together, and none longer than 1.2 m:

    >>> def rectangle(sides):
    ...     return Candidate(None, sides[0] * sides[1], slacks=(1.0 - sum(sides) / 3.0,))
    >>> found = best_place(rectangle, [(0.1, 1.2), (0.1, 4.0)], most=300)
    >>> [round(side, 4) for side in found.values], found.allowed
    ([1.2, 1.8], True)
    """
    search = _Search(made, np.asarray(ranges, dtype=float).reshape(-1, 2), greatest, most, progress)
    complete = True
    try:
        _searched(search, first, seed, finely)
    except _Ended:
        complete = False
    if search.best is not None:
        return Found(*search.best, search.cost < 0.0, search.tried, complete)
    if not complete:
        raise Interrupted(search.tried, most, None, "nothing has been found yet")
    return search.refused


def _searched(
    search: _Search[Thing],
    first: Sequence[float] | None,
    seed: int,
    finely: Callable[[tuple[float, ...]], Candidate[Thing]] | None,
) -> None:
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
    if finely is not None:
        coarse, search.made, search.cost = search.best, finely, inf
        search(search.place(coarse[0]))  # against those alike
        search.best = search.best if search.cost < inf else coarse
    most = max(10, int(_LOCAL * search.most))
    _along_limits(search, most // 2, 2.0 * _EDGE)
    if search.best[1].slacks:  # anew from there: models of what lies along limits are soon too small
        _along_limits(search, most - most // 2, 0.4 * _EDGE)
        return
    place = search.place(search.best[0])
    options: Any = {
        "maxfev": most - most // 2,
        "xatol": 1e-6,
        "fatol": 1e-9 * abs(search.cost),
        "initial_simplex": [place, *(place + np.diag(np.where(place + _EDGE <= 1.0, _EDGE, -_EDGE)))],
    }
    minimize(search, place, method="Nelder-Mead", bounds=unit, options=options)


def _along_limits(search: _Search[Any], most: int, radius: float) -> None:
    """From the best place on by models of figure and limits; whatever they come by is judged as all others are."""
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    assert search.best is not None
    values, candidate = search.best
    scale, ranges = abs(candidate.value or 0.0) or 1.0, len(values)
    unused = np.zeros((len(candidate.slacks), ranges))  # slopes: scipy would compute them, and nobody asks
    limits: Any = NonlinearConstraint(lambda place: search.row(place, scale)[1:], 0.0, inf, jac=lambda _: unused)
    asked: Any = {"maxfev": most, "initial_tr_radius": radius, "final_tr_radius": 1e-8}
    minimize(
        lambda place: search.row(place, scale)[0], search.place(values), method="COBYQA",
        bounds=Bounds(np.zeros(ranges), np.ones(ranges)), constraints=limits if candidate.slacks else (),
        options=asked,
    )  # fmt: skip
