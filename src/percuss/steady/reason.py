"""Why a steady motion can be sustained or not: one list of words for verdicts, maps, tables and the page."""

from __future__ import annotations

from enum import Enum
from typing import Self

__all__ = ["VERDICTS", "Reason"]


class Reason(Enum):
    """What decides whether a hammer can sustain a steady motion; its value is the word that files and tables have.

    The first six are verdicts on the stability of a motion, the next two say why a motion is not physical, the last
    one why there is none.

    Attributes
    ----------
    words
        The same in a few words; of the motions that are not physical, what the striking end does.

    Examples
    --------
    >>> Reason("flip") is Reason.FLIP, Reason.FLIP.words
    (True, 'the rigid motion grows and turns over with every impact (period doubling)')
    """

    words: str

    def __new__(cls, word: str, words: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words = word, words
        return made

    STABLE = "stable", "small disturbances die out"
    FOLD = "fold", "two motions meet here, or the motion lies beyond the place where they met"
    FLIP = "flip", "the rigid motion grows and turns over with every impact (period doubling)"
    SPIRAL = "spiral", "the rigid motion grows while its phase turns"
    ELASTIC = "elastic", "an elastic mode grows, where B77's reduced criterion says stable"
    NEUTRAL = "neutral", "the largest multiplier has the modulus 1, as far as rounding tells"
    NO_BLOW = "no blow", "does not strike forward"
    THROUGH_WALL = "through the wall", "passes through the wall"
    NO_MOTION = "no motion", "the level is above what the load can reach"


VERDICTS = tuple(Reason)[:6]
"""The reasons that are verdicts, in the order of the numbers by which maps and archives keep them."""
