"""The figures of a blow that hammers are compared by, each once: what it means, and how it is found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.blow.blow import Blow


@dataclass(frozen=True)
class Figure:
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


FIGURES: dict[str, Figure] = {
    "effective_restitution": Figure(
        "restitution",
        "−V₁/V₀, velocities of the striker's centre of mass after and before",
        "",
        lambda blow: blow.effective_restitution,
    ),
    "rock_energy": Figure("energy into the rock", "work of the bit on the rock", "J", _rock_energy),
    "rock_efficiency": Figure(
        "efficiency", "work of the bit on the rock over the energy before", "", lambda blow: blow.efficiency
    ),
    "incident_energy": Figure(
        "energy of the incident wave", "the first pulse into the rod, until a returned wave arrives", "J",
        _incident_energy,
    ),
    "peak_stress": Figure(
        "peak stress", "the greatest compression or tension in striker and rod; dimensionless: the force", "Pa",
        _peak_stress,
    ),
    "contact_duration": Figure(
        "duration of contact", "from the start of the first contact to the end of the last", "s",
        lambda blow: blow.contact_duration,
    ),
    "ringing": Figure("ringing", "share of the energy before that vibrates in the striker afterwards", "", _ringing),
}  # fmt: skip
"""By name, as in maps."""
