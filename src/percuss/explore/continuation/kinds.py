"""What may happen on a branch of orbits: the kinds of points, with their words."""

from __future__ import annotations

from enum import Enum
from typing import Self

__all__ = ["BranchEvent"]


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
