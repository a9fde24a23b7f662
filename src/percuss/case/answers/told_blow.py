"""One blow of a case, and what of it is told: the waves at a gauge, sections with their sizes, values with units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import number, quantity
from percuss.model.body import SizedBody
from percuss.model.body.sized import Piece
from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.blow import Blow, Peak, Rod, Waves
    from percuss.case.answers.gauge_record import MeasuredGauge

__all__ = ["BlowUnits", "ToldBlow"]


@dataclass(frozen=True)
class BlowUnits:
    """Values of a blow in words, with their units; those of a dimensionless bar as plain numbers."""

    is_si: bool

    def time(self, value: float, digits: int = 4) -> str:
        """A time with its unit."""
        return quantity(value, "s", digits) if self.is_si else f"{number(value, digits)} rad"

    def force(self, value: float, digits: int = 4) -> str:
        """A force with its unit."""
        return quantity(value, "N", digits) if self.is_si else number(value, digits)

    def energy(self, value: float, digits: int = 4) -> str:
        """An energy with its unit."""
        return quantity(value, "J", digits) if self.is_si else number(value, digits)

    def momentum(self, value: float, digits: int = 4) -> str:
        """An impulse with its unit."""
        return f"{number(value, digits)} N·s" if self.is_si else number(value, digits)

    def stress(self, value: float, digits: int = 4) -> str:
        """A stress with its unit; the force of a dimensionless bar."""
        return quantity(value, "Pa", digits) if self.is_si else number(value, digits)

    def place(self, value: float, digits: int = 4) -> str:
        """A place along a body with its unit."""
        return quantity(value, "m", digits) if self.is_si else number(value, digits)

    def speed(self, value: float, digits: int = 4) -> str:
        """A velocity with its unit."""
        return f"{number(value, digits)} m/s" if self.is_si else number(value, digits)


@dataclass(frozen=True)
class ToldBlow(Shown):
    """One blow of a case, resolved by waves.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    blow
        The blow: contacts, forces, energies, stresses.
    speed
        Where the speed comes from, in words.
    gauge
        Place on the rod, from the struck face, that waves are told of: m, or dimensionless a time of a wave; None
        where there is no rod.
    notes
        What was assumed, one sentence each.
    measured
        What a strain gauge measured there, laid over the blow; None without a record.
    """

    name: str
    title: str
    blow: Blow
    speed: str
    gauge: float | None
    notes: tuple[str, ...] = ()
    measured: MeasuredGauge | None = None

    @property
    def is_si(self) -> bool:
        """Whether the striker has sizes; else mass, length and angular frequency are 1."""
        return isinstance(self.blow.striker, SizedBody)

    @property
    def waves(self) -> Waves | None:
        """The waves at the gauge."""
        return None if self.gauge is None else self.blow.waves_at(self.gauge)

    @property
    def rod(self) -> Rod | None:
        """The rod that is struck; None for a wall."""
        from percuss.blow import Rod

        return self.blow.target if isinstance(self.blow.target, Rod) else None

    @property
    def beta(self) -> float | None:
        """β = K₁T/Z of the first pulse, T long, in the longest section of the rod (Lundberg 1973).

        None without rock, pulse or energy, and on elastic rock, which keeps nothing.
        """
        rod, pulse, before = self.rod, self.blow.first_pulse, self.blow.energy_before
        if rod is None or rod.rock is None or pulse is None or not before > 0.0 or rod.rock.unloading_ratio == 1.0:
            return None
        longest = max(rod.pieces, key=lambda piece: piece.end - piece.start)
        return rod.rock.stiffness * pulse.length / longest.impedance

    @property
    def pieces(self) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]:
        """Sections of the striker and of the rod with their sizes; empty where these are not known."""
        rod = self.rod
        own = self.blow.striker.pieces if isinstance(self.blow.striker, SizedBody) else ()
        return own, () if rod is None or not own else rod.pieces

    @property
    def peaks(self) -> tuple[tuple[Peak, ...], tuple[Peak, ...]]:
        """The greatest stresses of the striker's sections, and of the rod's."""
        from percuss.blow.striker import striker_sections

        own = striker_sections(self.blow.striker).impedance.size
        return self.blow.peaks[:own], self.blow.peaks[own:]

    @property
    def units(self) -> BlowUnits:
        """How its values are told."""
        return BlowUnits(self.is_si)
