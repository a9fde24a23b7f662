"""A body with its sizes in SI: what joins a dimensionless `Body` to metres, kilograms and pascals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np

from percuss.model.body.body import Body
from percuss.model.body.damping import Damping
from percuss.model.checks import Array, count

__all__ = ["Piece", "SizedBody"]


class Piece(NamedTuple):
    """A length of one cross-section and one material, as it is drawn and as stress is told of it.

    Parameters
    ----------
    start, end
        From the driven end, in m.
    area
        Cross-sectional area in m².
    youngs_modulus
        In Pa.
    density
        In kg/m³.
    diameter, bore
        Outer and inner diameter in m of a round cross-section; where only the area is known, those of a solid one.
    """

    start: float
    end: float
    area: float
    youngs_modulus: float
    density: float
    diameter: float
    bore: float

    @property
    def impedance(self) -> float:
        """A sqrt(E ρ) in N·s/m."""
        return self.area * float(np.sqrt(self.youngs_modulus * self.density))

    @property
    def transit_time(self) -> float:
        """Time of a wave through it, in s."""
        return (self.end - self.start) * float(np.sqrt(self.density / self.youngs_modulus))

    @property
    def mass(self) -> float:
        """In kg."""
        return self.density * self.area * (self.end - self.start)


class SizedBody(ABC):
    """A body in SI units. To write one, write `length`, `damping`, `pieces` and `body`; everything else follows.

    A body with a mass that none of its pieces has, such as a point mass at an end, writes `mass`, too. Its blows cannot
    be resolved by waves (`percuss.blow`), which run through the pieces alone.
    """

    kind: ClassVar[str]
    """Its word in JSON, the same as its dimensionless body's."""

    length: float
    """L in m."""

    damping: Damping
    """The law of its damping, with times in s (`Damping.per_radian`)."""

    @property
    @abstractmethod
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the driven end to the striking end."""

    @abstractmethod
    def body(self, angular_frequency: float) -> Body:
        """The dimensionless body under a load whose fundamental has the angular frequency Ω, in rad/s."""

    @property
    def mass(self) -> float:
        """Mass of the whole bar in kg."""
        return sum(piece.mass for piece in self.pieces)

    @property
    def transit_time(self) -> float:
        """Time of a wave from end to end, in s."""
        return sum(piece.transit_time for piece in self.pieces)

    @property
    def wave_speed(self) -> float:
        """Length over transit time, in m/s: C of a uniform bar."""
        return self.length / self.transit_time

    @property
    def contact_duration(self) -> float:
        """Twice the transit time, in s: a wave runs through the bar and back."""
        return 2.0 * self.transit_time

    @property
    def impedance(self) -> float:
        """A sqrt(E ρ) at the striking end, in N·s/m."""
        return self.pieces[-1].impedance

    @property
    def rigid_drag(self) -> float:
        """Force per velocity of the bar as a whole, in N·s/m."""
        return self.damping.rigid * self.mass

    def youngs_modulus_at(self, x: Array) -> Array:
        """Young's modulus in Pa at the places x, from 0 at the driven end to 1; same shape. Stress is E u_x."""
        ends = np.array([piece.end for piece in self.pieces[:-1]]) / self.length
        moduli = np.array([piece.youngs_modulus for piece in self.pieces])
        return np.asarray(moduli[np.searchsorted(ends, x, side="right")])

    def natural_frequencies(self, modes: int) -> Array:
        """Damped natural frequencies of the elastic modes 1 … `modes` of the free bar.

        Returns
        -------
        numpy.ndarray
            Shape (modes,), in Hz: λ_n/2π; 0 for a mode that is overdamped.
        """
        rate = 1.0 / self.transit_time  # any would do; with this one the numbers are of order 1
        found = self.body(rate).modes(count("modes", modes, most=1 << 20))
        squares = np.maximum(found.omega**2 - (0.5 * found.damping) ** 2, 0.0)
        return np.asarray(rate * np.sqrt(squares) / (2.0 * np.pi))
