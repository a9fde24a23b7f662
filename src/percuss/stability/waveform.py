"""The waveform criterion for designers (theory §11): only the force at the moment of impact matters."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.model.checks import instance
from percuss.model.contact import Contact, Result, restitution_of_ratio
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
    """

    ratio: float
    lower: float
    upper: float
    mean: float

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

    @property
    def restitution_needed(self) -> float | None:
        """The restitution below which this force at the impact would be stable; None when none would do."""
        if self.ratio >= self.upper:
            return None
        root = (-self.ratio) ** 0.5 if self.ratio < 0.0 else 0.0
        return restitution_of_ratio(root) if root < 1.0 else None


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
    instance("orbit", orbit, Orbit)
    load = orbit.system.load
    lower, upper = waveform_bounds(orbit.system.contact)
    sides = [float(load.value(orbit.phase, side)) / load.mean for side in load.sides]
    middle = 0.5 * (lower + upper)
    return Waveform(max(sides, key=lambda ratio: abs(ratio - middle)), lower, upper, load.mean)
