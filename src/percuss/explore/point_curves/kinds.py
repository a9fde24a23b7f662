"""What may happen on a curve of points in two parameters: points of codimension two, and its ends."""

from __future__ import annotations

from enum import Enum
from typing import Self

__all__ = ["CurveEvent"]


class CurveEvent(Enum):
    """A kind of point on a curve of folds, flips, grazings …; its value is the word in files and tables.

    Attributes
    ----------
    words
        The same in a sentence.

    Examples
    --------
    >>> CurveEvent("cusp") is CurveEvent.CUSP, CurveEvent.CUSP.words
    (True, 'two folds meet and vanish: the curve has a cusp')
    """

    words: str

    def __new__(cls, word: str, words: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words = word, words
        return made

    CUSP = "cusp", "two folds meet and vanish: the curve has a cusp"
    GENERALIZED_FLIP = "generalized_flip", "beyond, the doubled orbit begins towards the other side"
    WITH_FOLD = "with_fold", "another multiplier is 1: a curve of folds goes through here"
    WITH_FLIP = "with_flip", "another multiplier is −1: a curve of flips goes through here"
    RESONANCE_1 = "resonance_1_1", "a double multiplier 1: a curve of Neimark–Sacker points ends on one of folds"
    RESONANCE_2 = "resonance_1_2", "a double multiplier −1: a curve of Neimark–Sacker points ends on one of flips"
    RESONANCE_3 = "resonance_1_3", "the pair turns by 120° in a cycle: strong resonance"
    RESONANCE_4 = "resonance_1_4", "the pair turns by 90° in a cycle: strong resonance"
    RESONANT_GRAZING = "resonant_grazing", "the multiplier that grows without bound beside grazing changes its sign"
    FLAT_GRAZING = "flat_grazing", "the striking end has no acceleration where it grazes"
    WITH_TOUCH = "with_touch", "the striking end touches the wall in another place as well"
    WITH_DEATH = "with_death", "another impact has no speed"
    WITH_STICKING = "with_sticking", "the striking end would rest on the wall after an impact (R = 0)"
    WITH_CORNER = "with_corner", "an impact meets a step of the load"
    OTHER_CYCLE = "other_cycle", "beyond, what is let go does not come back as this cycle does"
    UNPRESSED = "unpressed", "the strain no longer presses the bar on the wall where its chatter ends"
    ENDLESS = "endless_chatter", "the chatter has more impacts than are followed: where R = 1 it has no end"
    HALVING = (
        "period_halving",
        "the orbit becomes one of half its period, at its flip: the curve would go back over itself",
    )
    COALESCENCE = "impacts_coalesce", "two impacts, or an impact and the touch, fall together"
    NO_PUSH = "load_stops_pushing", "the mean load is 0"
    NO_SYSTEM = "parameter_end", "a parameter goes no further"
    LIMIT = "limit", "the end of a range that was asked for"
    CLOSED = "closed", "the curve comes back to where it began"
    STOPPED = "stopped", "the following was stopped"
    LOST = "lost", "no further point of the curve was found"
