"""The waveform criterion for designers (theory §11): only the force at the moment of impact matters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.model.body import need_free
from percuss.model.checks import instance
from percuss.model.contact import Contact, Result
from percuss.shown import Shown
from percuss.steady import Orbit

__all__ = ["Waveform", "waveform_bounds", "waveform_criterion"]


@dataclass(frozen=True)
class Waveform(Shown):
    """Stable when lower < p(φ)/p_0 < upper, for a rigid bar without damping and any periodic load.

    Parameters
    ----------
    ratio
        p(φ)/p_0; the value farther outside the bounds when the load jumps at the impact.
    lower
        −[(1 − R)/(1 + R)]², where the motion flips (period doubling).
    upper
        1, where two motions meet in a fold.
    mean
        p_0, dimensionless.
    restitution_needed
        The restitution below which this force at the impact would be stable; None when none would do.
    """

    ratio: float
    lower: float
    upper: float
    mean: float
    restitution_needed: float | None

    @property
    def stable(self) -> bool:
        """Whether the force at the impact lies between the bounds."""
        return self.lower < self.ratio < self.upper

    @property
    def force(self) -> float:
        """p(φ), dimensionless; times `system.force_scale` in N."""
        return self.ratio * self.mean

    @property
    def force_lower(self) -> float:
        """Least force at the impact for a stable blow, dimensionless."""
        return self.lower * self.mean

    @property
    def force_upper(self) -> float:
        """Greatest force at the impact for a stable blow, dimensionless."""
        return self.upper * self.mean


def waveform_bounds(contact: Contact) -> tuple[float, float]:
    """Between which p(φ)/p_0 a blow is stable: −[(1 − R)/(1 + R)]² and 1 (B77 36).

    Raises
    ------
    ParameterError
        For a contact law that the criterion does not hold for.
    """
    contact.need(Result.WAVEFORM)
    return -(contact.impedance_ratio**2), 1.0


def waveform_criterion(orbit: Orbit) -> Waveform:
    """The criterion −[(1 − R)/(1 + R)]² < p(φ)/p_0 < 1 for an orbit.

    Raises
    ------
    ParameterError
        For a contact law that it does not hold for.
    """
    need_free(instance("orbit", orbit, Orbit).system.body, "the criterion of the waveform")
    load, contact = orbit.system.load, orbit.system.contact
    lower, upper = waveform_bounds(contact)
    sides = [float(load.value(orbit.phase, side)) / load.mean for side in load.sides]
    middle = 0.5 * (lower + upper)
    ratio = max(sides, key=lambda side: abs(side - middle))
    return Waveform(ratio, lower, upper, load.mean, _needed(contact, ratio, upper))


def _needed(contact: Contact, ratio: float, upper: float) -> float | None:
    """The restitution below which a force is stable."""
    root = math.sqrt(max(-ratio, 0.0))
    return float(contact.restitutions_of(root)) if ratio < upper and root < 1.0 else None
