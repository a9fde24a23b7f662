"""A branch of cycles with rest over a parameter as a value: the cycles, and its two ends."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady import RestCycle

__all__ = ["RestBranch", "RestBranchPoint", "RestEvent"]


class RestEvent(Enum):
    """What happens at a point of a branch of cycles with rest; its value is the word in files and tables."""

    ONSET = "onset"
    TOUCH = "grazing_touch"
    DEATH = "grazing_impact_dies"
    RELEASE_LOST = "release_lost"
    CHANGE = "label_changes"
    NO_SYSTEM = "parameter_end"
    LIMIT = "limit"
    STOPPED = "stopped"


@dataclass(frozen=True)
class RestBranchPoint(Shown):
    """A point of a branch of cycles with rest: one of its two ends.

    Parameters
    ----------
    kind
        What happens.
    value
        Of the parameter, to 1e-10 of it or better.
    cycle
        The cycle there.
    beyond
        What lies beyond, in a sentence.
    touch_phase
        Phase of the load at which the bar touches the wall; or None.
    impact
        Number of the impact, from 1 on through the whole cycle, that dies or, at a touch, is born; or None.
    """

    kind: RestEvent
    value: float
    cycle: RestCycle = field(repr=False)
    beyond: str
    touch_phase: float | None = None
    impact: int | None = None

    def __str__(self) -> str:
        return f"{self.kind.value} of {self.cycle.label} at {self.value:.12g}: {self.beyond}"


@dataclass(frozen=True)
class RestBranch(Shown):
    """Cycles with rest followed through a parameter; made by `follow_rest_cycle`.

    The impacts of a chatter have no last one, so that a branch keeps the cycles themselves.

    Parameters
    ----------
    parameter
        Its name.
    values
        Of the parameter, increasing; shape (m,).
    cycles
        The cycle at each.
    points
        The two ends.
    """

    parameter: str
    values: Array = field(repr=False)
    cycles: tuple[RestCycle, ...] = field(repr=False)
    points: tuple[RestBranchPoint, RestBranchPoint]

    @property
    def label(self) -> str:
        """chatter/n or rest/n, the same all along."""
        return self.cycles[0].label

    @property
    def modes(self) -> int:
        """N."""
        return self.cycles[0].modes

    @property
    def rest_times(self) -> Array:
        """The shortest rest of each cycle, in rad of the load; shape (m,)."""
        return np.array([cycle.rest_times.min() for cycle in self.cycles])

    def __str__(self) -> str:
        low, high = float(self.values[0]), float(self.values[-1])
        head = f"{self.label} over {self.parameter}: {self.values.size} points from {low:.9g} to {high:.9g}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])
