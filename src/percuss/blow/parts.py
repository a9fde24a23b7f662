"""The parts of a blow: contacts, pulses, peaks, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class BlowOutcome(Enum):
    """How the window of a blow ends; the value is a sentence."""

    OVER = "the blow is over: no further contact is possible"
    SPENT = "the striker has given its momentum and energy away"
    STILL_IN_CONTACT = "the window ended while the faces were in contact"
    GAP_CLOSING = "the window ended with the gap open and closing"
    WINDOW_ENDED = "the window ended with the gap open; a further contact is not excluded"
    TOO_MANY_PIECES = "the waves have more pieces than allowed: the window was cut short"


@dataclass(frozen=True)
class ContactInterval:
    """A time during which the faces are pressed together.

    Parameters
    ----------
    start, end
        In s, or radians of a dimensionless striker; `end` is None where the contact outlasts the window.
    impulse
        ∫ N dt.
    peak_force
        The greatest N.
    """

    start: float
    end: float | None
    impulse: float
    peak_force: float


@dataclass(frozen=True)
class Pulse:
    """The incident wave in the rod, until its force falls to 0 or a returned wave arrives.

    Parameters
    ----------
    length
        Its duration.
    rise
        Time from its start to its greatest force.
    peak
        The greatest force.
    energy, momentum
        Z ∫ f² dt and Z ∫ f dt.
    """

    length: float
    rise: float
    peak: float
    energy: float
    momentum: float


@dataclass(frozen=True)
class Peak:
    """The greatest compression and tension in one section, over its whole length and the whole window.

    Stress where the area is known, else force; compression and tension are both positive or 0. Places run along the
    body that the section belongs to, in m (dimensionless: time of a wave) from the driven end or the struck face;
    place and time are None where the section never was in compression, or in tension.
    """

    compression: float
    compression_place: float | None
    compression_time: float | None
    tension: float
    tension_place: float | None
    tension_time: float | None
