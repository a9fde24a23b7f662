"""The striker as a chain of sections: impedances, transit times, where they lie, and areas where they are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.blow.target import Rod
from percuss.errors import ParameterError
from percuss.model import Body, SizedBody, SteppedBar, UniformBar
from percuss.model.body.sized import Piece
from percuss.model.checks import Array

__all__ = ["Sections", "Striker", "rod_sections", "striker_sections"]

Striker = SizedBody | Body
"""What strikes: with its sizes in SI, or dimensionless."""


@dataclass(frozen=True)
class Sections:
    """A row of sections.

    Parameters
    ----------
    impedance, transit, length, speed
        Of each, shape (K,), inf for the transit time and the length of an endless one. SI, or the scales of a
        dimensionless body, whose lengths are shares of the whole; a rod of which only the impedance is known has the
        speed 1, so that places along it are times of a wave.
    area
        In m², or None where only the impedances are known.
    """

    impedance: Array
    transit: Array
    length: Array
    speed: Array
    area: Array | None


def striker_sections(striker: Striker) -> Sections:
    """The sections of a striker from the driven end on.

    Raises
    ------
    ParameterError
        For anything that is no chain of sections.
    """
    if isinstance(striker, SizedBody):
        return _of_pieces(striker.pieces)
    if isinstance(striker, SteppedBar):
        chain = striker.sections
        return Sections(chain.impedance, chain.transit, chain.width, 1.0 / chain.slowness, None)
    if isinstance(striker, UniformBar):
        return Sections(
            np.array([striker.s]), np.array([striker.transit_time]), np.ones(1), np.array([striker.s]), None
        )
    raise ParameterError("striker", striker, "a bar: Bar, SectionedBar, UniformBar or SteppedBar")


def rod_sections(rod: Rod, striker: Striker) -> Sections:
    """The sections of a rod from the struck face on, in the units of the striker.

    Raises
    ------
    ParameterError
        For a rod with sizes in front of a striker without.
    """
    if rod.impedance is not None:
        endless = np.array([np.inf])
        return Sections(np.array([rod.impedance]), endless, endless, np.ones(1), None)
    if not isinstance(striker, SizedBody):
        raise ParameterError("target", rod, "a wall, or Rod.of_impedance", "a dimensionless striker has no sizes")
    return _of_pieces(rod.pieces)


def _of_pieces(pieces: tuple[Piece, ...]) -> Sections:
    return Sections(
        np.array([piece.impedance for piece in pieces]),
        np.array([piece.transit_time for piece in pieces]),
        np.array([piece.end - piece.start for piece in pieces]),
        np.array([(piece.youngs_modulus / piece.density) ** 0.5 for piece in pieces]),
        np.array([piece.area for piece in pieces]),
    )
