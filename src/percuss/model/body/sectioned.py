"""The stepped bar in SI units: sections of any cross-section and material, joined end to end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import accumulate, pairwise
from typing import ClassVar

from percuss.errors import ParameterError
from percuss.model.body.bar import Bar
from percuss.model.body.damping import UNDAMPED, Damping
from percuss.model.body.sized import Piece, SizedBody
from percuss.model.body.stepped import MOST_SECTIONS, SteppedBar
from percuss.model.checks import instance, non_negative, positive, several

__all__ = ["MOST_JUMP", "Section", "SectionedBar", "section_of"]

MOST_JUMP = 1e6
"""Areas of two neighbours that differ by more are a slip of units, not a bar."""


@dataclass(frozen=True)
class Section:
    """One section of a bar; steel unless told otherwise.

    Parameters
    ----------
    length
        In m; None for the endless last section of a rod that is struck, which no bar has.
    area
        Cross-sectional area in m², a bore taken off; or give `diameter`.
    diameter
        Outer diameter in m of a round section, instead of `area`.
    bore
        Diameter in m of a hole along its axis.
    youngs_modulus
        In Pa.
    density
        In kg/m³.

    Raises
    ------
    ParameterError
        For sizes that are not positive and finite, a bore as wide as the section, both or neither of an area and
        a diameter.

    Examples
    --------
    >>> Section(0.25, diameter=0.04, bore=0.01).youngs_modulus
    210000000000.0
    """

    length: float | None
    area: float | None = None
    diameter: float | None = None
    bore: float = 0.0
    youngs_modulus: float = Bar.STEEL_MODULUS
    density: float = 7850.0

    def __post_init__(self) -> None:
        checks = {"bore": non_negative, "youngs_modulus": positive, "density": positive}
        if self.length is not None:
            checks["length"] = positive
        if (self.area is None) == (self.diameter is None):
            raise ParameterError("area", self.area, "either an area or a diameter")
        checks |= {"area": positive} if self.diameter is None else {"diameter": positive}
        for name, check in checks.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))
        if self.diameter is not None and self.bore >= self.diameter:
            raise ParameterError("bore", self.bore, f"less than the diameter, {self.diameter:g}")

    def piece(self, start: float) -> Piece:
        """The same from a place on, in m; one without a length reaches to infinity."""
        if self.diameter is None:
            area = float(self.area or 0.0)
            outer = math.sqrt(4.0 / math.pi * area + self.bore**2)
        else:
            outer = self.diameter
            area = math.pi / 4.0 * (outer - self.bore) * (outer + self.bore)
        end = math.inf if self.length is None else start + self.length
        return Piece(start, end, area, self.youngs_modulus, self.density, outer, self.bore)


@dataclass(frozen=True)
class SectionedBar(SizedBody):
    """A bar of sections in SI units, such as a piston with a head and a shoulder.

    Parameters
    ----------
    sections
        From the driven end to the striking end, 1 to 200 of them; each a `Section`, or a dict of what makes one.
    damping
        A law of damping with its times in s.

    Raises
    ------
    ParameterError
        For too many sections, none, or what is none.

    Examples
    --------
    >>> piston = SectionedBar([Section(0.12, diameter=0.052), Section(0.25, diameter=0.04, bore=0.01)])
    >>> print(piston)
    SectionedBar: 2 sections, 370 mm × 1178 … 2124 mm², 4.31 kg, transit time 71.5 µs, first mode 6442 Hz
    """

    kind: ClassVar[str] = "stepped"

    sections: tuple[Section, ...]
    damping: Damping = UNDAMPED

    def __post_init__(self) -> None:
        given = several("sections", self.sections, "a list of sections")
        if not 1 <= len(given) <= MOST_SECTIONS:
            raise ParameterError("sections", f"{len(given)} of them", f"1 to {MOST_SECTIONS} sections")
        object.__setattr__(self, "sections", tuple(section_of(i, one) for i, one in enumerate(given)))
        for i, section in enumerate(self.sections):
            if section.length is None:
                raise ParameterError(f"sections[{i}].length", None, "a length in m", "only a struck rod can be endless")
        instance("damping", self.damping, Damping)
        if not (math.isfinite(self.mass) and self.mass > 0.0 and math.isfinite(self.length)):
            raise ParameterError("sections", "sizes", "sizes and densities that give the bar a finite mass")
        self._check_jumps()
        self.body(1.0 / self.transit_time)  # what cannot be a bar is refused here

    def _check_jumps(self) -> None:
        areas = [piece.area for piece in self.pieces]
        for i, (one, other) in enumerate(pairwise(areas), 1):
            if max(one, other) >= MOST_JUMP * min(one, other):
                wanted = f"an area that differs from its neighbour's by a factor of less than {MOST_JUMP:,.0f}"
                raise ParameterError(f"sections[{i}].area", other, wanted, "check the units of its sizes")

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the driven end to the striking end."""
        starts = accumulate(self._lengths[:-1], initial=0.0)
        return tuple(section.piece(start) for section, start in zip(self.sections, starts, strict=True))

    @property
    def _lengths(self) -> tuple[float, ...]:
        return tuple(section.length for section in self.sections if section.length is not None)

    @property
    def length(self) -> float:  # type: ignore[override]  # what the contract reads
        """L in m."""
        return self.pieces[-1].end

    def body(self, angular_frequency: float) -> SteppedBar:
        """The dimensionless bar under a load whose fundamental has the angular frequency Ω, in rad/s."""
        omega = positive("angular_frequency", angular_frequency)
        return SteppedBar(
            1.0 / (self.transit_time * omega),
            tuple(piece.impedance for piece in self.pieces),
            tuple(piece.transit_time for piece in self.pieces),
            self.damping.per_radian(omega),
            self._lengths,
        )

    def __str__(self) -> str:
        count, areas = len(self.pieces), [1e6 * piece.area for piece in self.pieces]
        span = f"{min(areas):.4g}" if min(areas) == max(areas) else f"{min(areas):.4g} … {max(areas):.4g}"
        return (
            f"SectionedBar: {count} section{'s' if count > 1 else ''}, {1e3 * self.length:.4g} mm × {span} mm², "
            f"{self.mass:.3g} kg, transit time {1e6 * self.transit_time:.3g} µs, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )


def section_of(number: int, given: object) -> Section:
    """A section, or the one that a dict makes; errors say which one it is."""
    name = f"sections[{number}]"
    if isinstance(given, Section):
        return given
    keys = [field.name for field in fields(Section)]
    if not isinstance(given, Mapping) or not {"length"} <= given.keys() <= set(keys):
        raise ParameterError(name, given, f"a Section, or a dict with a length and of {', '.join(keys[1:])}")
    try:
        return Section(**given)
    except ParameterError as error:
        raise ParameterError(f"{name}.{error.name}", error.value, error.accepted, error.remedy) from None
