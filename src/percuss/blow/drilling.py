"""Blows that drill: what a blow is worth in advance, and what of its energy goes where."""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.errors import ParameterError
from percuss.model.checks import positive

# ---- How far the hole gets with a blow: by the crater that it leaves, or by the work that the rock takes per volume


@dataclass(frozen=True)
class Drilling:
    """A bit and what of its penetration, or of the work that it does, is advance of the hole.

    Parameters
    ----------
    bit_diameter
        Of the hole, in m.
    crater_factor
        Advance over the residual penetration: buttons leave rock between their craters.
    specific_energy
        Work that stays in the rock per volume drilled, in J/m³, as measured; instead of `crater_factor`.

    Examples
    --------
    >>> Drilling(0.064, specific_energy=220e6).area
    0.0032169908772759484
    """

    bit_diameter: float
    crater_factor: float | None = None
    specific_energy: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "bit_diameter", positive("bit_diameter", self.bit_diameter))
        for name in ("crater_factor", "specific_energy"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, positive(name, value))
        if (self.crater_factor is None) == (self.specific_energy is None):
            accepted = "either a crater_factor or a specific_energy"
            raise ParameterError("crater_factor", self.crater_factor, accepted, "a measured specific energy is better")

    @property
    def area(self) -> float:
        """Cross-section of the hole, in m²."""
        return 0.25 * math.pi * self.bit_diameter**2
