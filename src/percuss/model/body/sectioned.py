"""The stepped bar in SI units: sections of any cross-section and material, joined end to end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body.bar import Bar
from percuss.model.body.damping import UNDAMPED, Damping
from percuss.model.body.sized import Piece, SizedBody
from percuss.model.body.stepped import MOST_SECTIONS, SteppedBar
from percuss.model.checks import instance, non_negative, positive, several

__all__ = ["Section", "SectionedBar"]


class Section(NamedTuple):
    """One section of a bar; steel unless told otherwise.

    Parameters
    ----------
    length
        In m.
    area
        Cross-sectional area in m²; or give `diameter`.
    diameter
        Outer diameter in m of a round section, instead of `area`.
    bore
        Diameter in m of a hole along its axis.
    youngs_modulus
        In Pa.
    density
        In kg/m³.
    """

    length: float
    area: float | None = None
    diameter: float | None = None
    bore: float = 0.0
    youngs_modulus: float = Bar.STEEL_MODULUS
    density: float = 7850.0


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
        For sizes that are not positive and finite, a bore as wide as its section, both or neither of an area and
        a diameter, or too many sections.

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
        object.__setattr__(self, "sections", tuple(_section(i, one) for i, one in enumerate(given)))
        instance("damping", self.damping, Damping)
        if not (math.isfinite(self.mass) and self.mass > 0.0 and math.isfinite(self.length)):
            raise ParameterError("sections", "sizes", "sizes and densities that give the bar a finite mass")
        self.body(1.0 / self.transit_time)  # what cannot be a bar is refused here

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the driven end to the striking end."""
        ends = [0.0, *np.cumsum([section.length for section in self.sections]).tolist()]
        return tuple(_piece(ends[i], ends[i + 1], section) for i, section in enumerate(self.sections))

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
            tuple(section.length for section in self.sections),
        )

    def __str__(self) -> str:
        count, areas = len(self.pieces), [1e6 * piece.area for piece in self.pieces]
        span = f"{min(areas):.4g}" if min(areas) == max(areas) else f"{min(areas):.4g} … {max(areas):.4g}"
        return (
            f"SectionedBar: {count} section{'s' if count > 1 else ''}, {1e3 * self.length:.4g} mm × {span} mm², "
            f"{self.mass:.3g} kg, transit time {1e6 * self.transit_time:.3g} µs, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )


def _section(number: int, given: object) -> Section:
    """A section whose sizes are checked; errors say which one it is."""
    name = f"sections[{number}]"
    if isinstance(given, Mapping):
        unknown = [key for key in given if key not in Section._fields]
        if unknown or "length" not in given:
            raise ParameterError(name, unknown or dict(given), f"a length, and of {', '.join(Section._fields[1:])}")
        given = Section(**given)
    if not isinstance(given, Section):
        raise ParameterError(name, given, "a Section")
    if (given.area is None) == (given.diameter is None):
        raise ParameterError(f"{name}.area", given.area, "either an area or a diameter")
    bore = non_negative(f"{name}.bore", given.bore)
    area = None if given.area is None else positive(f"{name}.area", given.area)
    diameter = None if given.diameter is None else positive(f"{name}.diameter", given.diameter)
    if diameter is not None and bore >= diameter:
        raise ParameterError(f"{name}.bore", bore, f"less than the diameter, {diameter:g}")
    return Section(
        positive(f"{name}.length", given.length),
        area,
        diameter,
        bore,
        positive(f"{name}.youngs_modulus", given.youngs_modulus),
        positive(f"{name}.density", given.density),
    )


def _piece(start: float, end: float, section: Section) -> Piece:
    if section.diameter is None:
        area = float(section.area or 0.0)
        outer = math.sqrt(4.0 / math.pi * area + section.bore**2)
    else:
        outer = section.diameter
        area = math.pi / 4.0 * (outer - section.bore) * (outer + section.bore)
    return Piece(start, end, area, section.youngs_modulus, section.density, outer, section.bore)
