"""What is told of a blow: its contacts, pulses and peaks, how it ended, and the figures that blows are compared by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any


class BlowOutcome(Enum):
    """How the window of a blow ends; the value is a sentence."""

    OVER = "the blow is over: no further contact is possible"
    SPENT = "the striker has given its momentum and energy away"
    STILL_IN_CONTACT = "the window ended while the faces were in contact"
    GAP_CLOSING = "the window ended with the gap open and closing"
    WINDOW_ENDED = "the window ended with the gap open; a further contact is not excluded"
    TOO_MANY_PIECES = "the waves have more pieces than allowed: the window was cut short"


class Fineness(Enum):
    """How finely the waves of a blow are followed; the value is what a report says of it."""

    EXACT = "exact but for rounding"
    SMOOTHED = "without steps below 0.01 % and bends below 0.5 % of the first wave, as exact ones have too many pieces"
    COARSE = (
        "without steps below 0.1 % and bends below 1 % of the first wave, and times below 0.4 % of the shortest "
        "section's transit time, as finer ones have too many pieces"
    )


@dataclass(frozen=True)
class ContactInterval:
    """A time during which the faces are pressed together, in s, or radians of a dimensionless striker.

    `end` is None where the contact outlasts the window; `impulse` is ∫ N dt, and `peak_force` the greatest N.
    """

    start: float
    end: float | None
    impulse: float
    peak_force: float


@dataclass(frozen=True)
class Pulse:
    """The incident wave in the rod, until its force falls to 0 or a returned wave arrives.

    Its `length` in time, the time of its `rise` to its greatest force, the `peak`, and what is in it: the energy
    Z ∫ f² dt and the momentum Z ∫ f dt.
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


@dataclass(frozen=True)
class BlowFigure:
    """A figure of a `Blow` by which hammers are compared: its label, its meaning, its unit in SI ("" for a ratio).

    `value` finds it; None where there is no such figure, as there is no wave in a wall.

    Examples
    --------
    >>> from percuss.blow import Wall, strike
    >>> from percuss.model import UniformBar
    >>> FIGURES["effective_restitution"].value(strike(UniformBar(20.0), Wall(), 1.0))
    1.0
    """

    label: str
    meaning: str
    unit: str
    value: Callable[[Any], float | None]


def _ringing(blow: Any) -> float | None:
    before = blow.energy_before
    return float(blow.vibration_energy_after / before) if before > 0.0 else None


FIGURES: dict[str, BlowFigure] = {
    "effective_restitution": BlowFigure(
        "restitution", "−V₁/V₀, velocities of the striker's centre of mass after and before", "",
        lambda blow: blow.effective_restitution,
    ),
    "rock_energy": BlowFigure(
        "energy into the rock", "work of the bit on the rock", "J",
        lambda blow: None if blow.greatest_penetration is None else blow.rock_work,
    ),
    "rock_efficiency": BlowFigure(
        "efficiency", "work of the bit on the rock over the energy before", "", lambda blow: blow.efficiency
    ),
    "incident_energy": BlowFigure(
        "energy of the incident wave", "the first pulse into the rod, until a returned wave arrives", "J",
        lambda blow: None if blow.first_pulse is None else blow.first_pulse.energy,
    ),
    "peak_stress": BlowFigure(
        "peak stress", "the greatest compression or tension in striker and rod; dimensionless: the force", "Pa",
        lambda blow: max(max(peak.compression, peak.tension) for peak in blow.peaks),
    ),
    "contact_duration": BlowFigure(
        "duration of contact", "from the start of the first contact to the end of the last", "s",
        lambda blow: blow.contact_duration,
    ),
    "ringing": BlowFigure(
        "ringing", "share of the energy before that vibrates in the striker afterwards", "", _ringing
    ),
}  # fmt: skip
"""By name, as in maps."""
