"""The bar: a slender elastic rod with viscous damping spread along its length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, count, non_negative, positive

__all__ = ["Bar"]


@dataclass(frozen=True, init=False)
class Bar:
    """A uniform elastic bar in SI units; steel unless told otherwise.

    Parameters
    ----------
    length
        Length L in m.
    area
        Cross-sectional area A in m²; or give `diameter`.
    youngs_modulus
        Young's modulus E in Pa.
    density
        Density in kg/m³.
    damping
        D, the force per metre of bar and per velocity, in N·s/m²; or give `damping_ratio`.
    diameter
        Diameter in m of a solid round bar, instead of `area`.
    damping_ratio
        Fraction of critical damping of the first elastic mode (dimensionless), instead of `damping`:
        D = 2 ζ π C M / L.

    Raises
    ------
    ParameterError
        For sizes that are not positive and finite, or when both or neither of `area` and `diameter` are given.

    Examples
    --------
    >>> bar = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
    >>> print(bar)
    Bar: 341 mm × 1886 mm², 5.05 kg, C = 5172 m/s, impedance 7.66e+04 N·s/m, first mode 7584 Hz
    """

    STEEL_MODULUS: ClassVar[float] = 210e9
    """Young's modulus of steel in Pa, unless told otherwise."""

    length: float
    area: float
    youngs_modulus: float
    density: float
    damping: float

    def __init__(
        self,
        length: float,
        area: float | None = None,
        youngs_modulus: float = STEEL_MODULUS,
        density: float = 7850.0,
        damping: float | None = None,
        *,
        diameter: float | None = None,
        damping_ratio: float | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "length", positive("length", length))
        set_(self, "youngs_modulus", positive("youngs_modulus", youngs_modulus))
        set_(self, "density", positive("density", density))
        if area is not None and diameter is not None:
            raise ParameterError("diameter", diameter, "either area or diameter, not both")
        if area is None and diameter is None:
            raise ParameterError("area", None, "an area (m²) or a diameter (m) greater than 0")
        round_area = None if diameter is None else math.pi / 4.0 * positive("diameter", diameter) ** 2
        set_(self, "area", positive("area", area if round_area is None else round_area))
        if damping is not None and damping_ratio is not None:
            raise ParameterError("damping_ratio", damping_ratio, "either damping or damping_ratio, not both")
        if damping_ratio is not None:
            ratio = non_negative("damping_ratio", damping_ratio)
            damping = 2.0 * ratio * math.pi * self.wave_speed * self.mass_per_length / self.length
        if not 0.0 < self.mass < math.inf:
            raise ParameterError("length", self.length, "sizes and a density that give the bar a finite mass")
        set_(self, "damping", non_negative("damping", 0.0 if damping is None else damping))

    @property
    def mass_per_length(self) -> float:
        """M in kg/m."""
        return self.density * self.area

    @property
    def mass(self) -> float:
        """Mass of the whole bar in kg."""
        return self.mass_per_length * self.length

    @property
    def wave_speed(self) -> float:
        """C = sqrt(EA/M) in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)

    @property
    def impedance(self) -> float:
        """Mechanical impedance A sqrt(E ρ) in N·s/m."""
        return self.area * math.sqrt(self.youngs_modulus * self.density)

    @property
    def contact_duration(self) -> float:
        """2L/C in s: the time a wave needs to run through the bar and back."""
        return 2.0 * self.length / self.wave_speed

    def natural_frequencies(self, modes: int) -> Array:
        """Damped natural frequencies of the elastic modes 1 … `modes` of the free bar.

        Returns
        -------
        numpy.ndarray
            Shape (modes,), in Hz: λ_n/2π; 0 for a mode that is overdamped.
        """
        n = np.arange(1, count("modes", modes, most=1 << 20) + 1)
        omega = n * math.pi * self.wave_speed / self.length
        decay = self.damping / (2.0 * self.mass_per_length)
        return np.asarray(np.sqrt(np.maximum(omega**2 - decay**2, 0.0)) / (2.0 * math.pi))

    def __str__(self) -> str:
        return (
            f"Bar: {1e3 * self.length:.4g} mm × {1e6 * self.area:.4g} mm², {self.mass:.3g} kg, "
            f"C = {self.wave_speed:.4g} m/s, impedance {self.impedance:.3g} N·s/m, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )
