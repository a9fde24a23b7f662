"""The parts of a blow: contacts, pulses, peaks, how it ended, and the figures that hammers are compared by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.blow.blow import Blow


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


# ---- The figures of a blow that hammers are compared by, each once: what it means, and how it is found


@dataclass(frozen=True)
class BlowFigure:
    """A figure of a blow.

    Parameters
    ----------
    label
        What it is called before its value.
    meaning
        The same in a few words more.
    unit
        Its unit in SI without a prefix; "" for a ratio.
    value
        Of a blow; None where there is no such figure, as there is no wave in a wall.

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
    value: Callable[[Blow], float | None]


def _rock_energy(blow: Blow) -> float | None:
    return None if blow.greatest_penetration is None else blow.rock_work


def _incident_energy(blow: Blow) -> float | None:
    return None if blow.first_pulse is None else blow.first_pulse.energy


def _ringing(blow: Blow) -> float | None:
    before = blow.energy_before
    return blow.vibration_energy_after / before if before > 0.0 else None


def _peak_stress(blow: Blow) -> float:
    return max(max(peak.compression, peak.tension) for peak in blow.peaks)


FIGURES: dict[str, BlowFigure] = {
    "effective_restitution": BlowFigure(
        "restitution",
        "−V₁/V₀, velocities of the striker's centre of mass after and before",
        "",
        lambda blow: blow.effective_restitution,
    ),
    "rock_energy": BlowFigure("energy into the rock", "work of the bit on the rock", "J", _rock_energy),
    "rock_efficiency": BlowFigure(
        "efficiency", "work of the bit on the rock over the energy before", "", lambda blow: blow.efficiency
    ),
    "incident_energy": BlowFigure(
        "energy of the incident wave", "the first pulse into the rod, until a returned wave arrives", "J",
        _incident_energy,
    ),
    "peak_stress": BlowFigure(
        "peak stress", "the greatest compression or tension in striker and rod; dimensionless: the force", "Pa",
        _peak_stress,
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
