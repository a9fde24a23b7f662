"""The uniform bar in SI units: a slender elastic rod of one cross-section and one material."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from percuss.errors import ParameterError
from percuss.model.body.damping import UNDAMPED, Damping, External, Ratio, share_of_critical
from percuss.model.body.sized import Piece, SizedBody
from percuss.model.body.uniform import UniformBar
from percuss.model.checks import instance, non_negative, positive

__all__ = ["Bar"]


@dataclass(frozen=True, init=False)
class Bar(SizedBody):
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
        A law of damping with its times in s; or give `damping_ratio` or `drag`.
    diameter
        Diameter in m of a solid round bar, instead of `area`.
    damping_ratio
        ζ, the share of critical damping of every elastic mode (dimensionless), instead of `damping`: `Ratio(ζ)`.
    drag
        D, the force per metre of bar and per velocity, in N·s/m², instead of `damping`: `External(D/M)`.

    Raises
    ------
    ParameterError
        For sizes that are not positive and finite, when both or neither of `area` and `diameter` are given, or more
        than one damping.

    Examples
    --------
    >>> bar = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
    >>> print(bar)
    Bar: 341 mm × 1886 mm², 5.05 kg, C = 5172 m/s, impedance 7.66e+04 N·s/m, first mode 7584 Hz
    """

    kind: ClassVar[str] = "uniform"

    STEEL_MODULUS: ClassVar[float] = 210e9
    """Young's modulus of steel in Pa, unless told otherwise."""

    length: float
    area: float
    youngs_modulus: float
    density: float
    damping: Damping

    def __init__(
        self,
        length: float,
        area: float | None = None,
        youngs_modulus: float = STEEL_MODULUS,
        density: float = 7850.0,
        damping: Damping | None = None,
        *,
        diameter: float | None = None,
        damping_ratio: float | None = None,
        drag: float | None = None,
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
        if not 0.0 < self.mass < math.inf:
            raise ParameterError("length", self.length, "sizes and a density that give the bar a finite mass")
        set_(self, "damping", self._law(damping, damping_ratio, drag))

    def _law(self, damping: Damping | None, ratio: float | None, drag: float | None) -> Damping:
        given = {"damping": damping, "damping_ratio": ratio, "drag": drag}
        several = [name for name, value in given.items() if value is not None]
        if len(several) > 1:
            raise ParameterError(several[1], given[several[1]], f"either {several[0]} or {several[1]}, not both")
        if ratio is not None:
            return Ratio(share_of_critical("damping_ratio", ratio))
        if drag is not None:
            return External(non_negative("drag", drag) / self.mass_per_length)
        return UNDAMPED if damping is None else instance("damping", damping, Damping)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The one section that it is."""
        diameter = math.sqrt(4.0 / math.pi * self.area)
        return (Piece(0.0, self.length, self.area, self.youngs_modulus, self.density, diameter, 0.0),)

    def body(self, angular_frequency: float) -> UniformBar:
        """The dimensionless bar under a load whose fundamental has the angular frequency Ω, in rad/s."""
        omega = positive("angular_frequency", angular_frequency)
        return UniformBar(self.wave_speed / (self.length * omega), self.damping.per_radian(omega))

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

    def __str__(self) -> str:
        return (
            f"Bar: {1e3 * self.length:.4g} mm × {1e6 * self.area:.4g} mm², {self.mass:.3g} kg, "
            f"C = {self.wave_speed:.4g} m/s, impedance {self.impedance:.3g} N·s/m, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )
