"""A branch of orbits over a parameter as a value: what was walked through, what happens on it, and where it ends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from typing import NamedTuple, Self, TypeVar

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, ComplexArray, choice
from percuss.shown import Shown
from percuss.steady import PeriodicOrbit

# ---- What may happen on a branch of orbits: the kinds of points, with their words


class BranchEvent(Enum):
    """A kind of point on a branch; its value is the word in files and tables.

    Attributes
    ----------
    words
        The same in a few words.
    ends
        Whether the branch ends there.

    Examples
    --------
    >>> BranchEvent("grazing_touch") is BranchEvent.TOUCH, BranchEvent.TOUCH.ends, BranchEvent.FOLD.ends
    (True, True, False)
    """

    words: str
    ends: bool

    def __new__(cls, word: str, ends: bool, words: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.ends, made.words = word, ends, words
        return made

    FOLD = "fold", False, "a multiplier is 1: the branch turns back"
    FLIP = "flip", False, "a multiplier is −1: an orbit of twice the period begins"
    NEIMARK_SACKER = "neimark_sacker", False, "a pair of multipliers is on the unit circle"
    CROSSING = "branch_point", False, "a multiplier is 1, and another branch crosses this one"
    CORNER = "corner", False, "an impact meets a step of the load: the branch has a corner"
    NONSMOOTH_FOLD = "nonsmooth_fold", False, "an impact meets a step of the load: the branch turns back"
    TOUCH = "grazing_touch", True, "the striking end touches the wall between two impacts"
    DEATH = "grazing_impact_dies", True, "an impact has no speed"
    COALESCENCE = "impacts_coalesce", True, "two impacts fall together"
    STICKING = "sticking", True, "the striking end would rest on the wall after an impact (R = 0)"
    HALVING = "period_halving", True, "the orbit becomes one of half the period, at its flip"
    NO_PUSH = "load_stops_pushing", True, "the mean load is 0"
    NO_SYSTEM = "parameter_end", True, "the parameter goes no further"
    LIMIT = "limit", True, "the end of the range that was asked for"
    CLOSED = "closed", True, "the branch comes back to where it began"
    RESONANCE = "resonance", True, "a mode comes back after a cycle by itself, so that its amplitude is free"
    STOPPED = "stopped", True, "the following was stopped"
    LOST = "lost", True, "no further point of the branch was found"


Event = TypeVar("Event", bound=Enum)


def event_of(kinds: type[Event], kind: Event | str) -> Event:
    """A kind of point, as itself or by its word; ParameterError, with all the words, for anything else."""
    if isinstance(kind, kinds):
        return kind
    choice("kind", kind, *(one.value for one in kinds))
    return kinds(kind)


# ---- A branch of orbits over a parameter as a value: what was walked through, what happens on it, and where it ends


@dataclass(frozen=True)
class BranchPoint(Shown):
    """A point of a branch at which something happens.

    Parameters
    ----------
    kind
        What happens.
    value
        Of the parameter, to 1e-10 of it or better.
    orbit
        The orbit there, its impacts in the order of the branch.
    multipliers
        Its multipliers, largest modulus first; None where they grow without bound.
    beyond
        What lies beyond, in a sentence.
    impact
        Number, from 1 on, of the impact of the orbit and the branch that dies or meets a step, or after which the bar
        stays on the wall; or None.
    touch_phase
        Phase of the load at which the bar touches the wall; or None.
    """

    kind: BranchEvent
    value: float
    orbit: PeriodicOrbit = field(repr=False)
    multipliers: ComplexArray | None = field(repr=False)
    beyond: str
    impact: int | None = None
    touch_phase: float | None = None

    def __str__(self) -> str:
        return f"{self.kind.value} of {self.orbit.label} at {self.value:.12g}: {self.beyond}"


class Doubling(NamedTuple):
    """A flip of a cascade: which orbit doubles there, the parameter, and the ratio of this interval to the next one."""

    label: str
    value: float
    ratio: float | None


@dataclass(frozen=True)
class Branch(Shown):
    """Orbits z=p/n followed through a parameter; made by `follow`.

    Parameters
    ----------
    parameter
        Its name.
    impacts, periods, modes
        p, n and N.
    values
        Of the parameter, along the branch: it may turn back. Shape (m,).
    times
        Times of the impacts in rad, unwrapped, in the order of the orbit that it was followed from: the first impact
        stays the same all along. Shape (m, p).
    speeds
        Of the striking end just before the impacts; shape (m, p).
    unstable
        How many multipliers are outside the unit circle, -1 where they grow without bound; shape (m,).
    points
        What happens, in order along the branch, its two ends first and last; of a closed one both are where it closes.
    switched
        The branches that begin at its points, as far as they were asked for; the first point of each is that.
    """

    parameter: str
    impacts: int
    periods: int
    modes: int
    values: Array = field(repr=False)
    times: Array = field(repr=False)
    speeds: Array = field(repr=False)
    unstable: npt.NDArray[np.int64] = field(repr=False)
    points: tuple[BranchPoint, ...]
    switched: tuple[Branch, ...] = ()

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def phases(self) -> Array:
        """Phases of the load at the impacts, in [0, 2π); shape (m, p)."""
        return np.mod(self.times, 2.0 * np.pi)

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Whether no multiplier is outside the unit circle; shape (m,)."""
        return np.asarray(self.unstable == 0)

    @property
    def ends(self) -> tuple[BranchPoint, BranchPoint]:
        """Its first and its last point."""
        return self.points[0], self.points[-1]

    def at(self, kind: BranchEvent | str) -> tuple[BranchPoint, ...]:
        """The points of a kind, which may be told by its word; ParameterError for an unknown one."""
        wanted = event_of(BranchEvent, kind)
        return tuple(point for point in self.points if point.kind is wanted)

    def family(self) -> Iterator[Branch]:
        """This branch and all that were switched to from it."""
        yield self
        for branch in self.switched:
            yield from branch.family()

    @property
    def cascade(self) -> tuple[Doubling, ...]:
        """The longest chain of flips, each of the branch that begins at the one before.

        Where the period doubles without end the ratios of the intervals tend to 4.669 (Feigenbaum, J. Stat. Phys. 19
        (1978) 25–52).
        """
        chain = _chain(self)
        gaps = [first - second for (_, first), (_, second) in pairwise(chain)]
        ratios = [None, *(first / second if second else None for first, second in pairwise(gaps)), None]
        return tuple(Doubling(label, value, ratio) for (label, value), ratio in zip(chain, ratios, strict=False))

    def __str__(self) -> str:
        low, high = float(self.values.min()), float(self.values.max())
        head = f"{self.label} over {self.parameter}: {self.values.size} points from {low:.9g} to {high:.9g}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


def _chain(branch: Branch) -> list[tuple[str, float]]:
    """Labels and flips of the longest cascade from a branch on."""
    longer = [
        [(branch.label, child.points[0].value), *_chain(child)]
        for child in branch.switched
        if child.points[0].kind is BranchEvent.HALVING
    ]
    last = [[(branch.label, point.value)] for point in branch.at(BranchEvent.FLIP)[:1]]
    return max([*longer, *last], key=len, default=[])
