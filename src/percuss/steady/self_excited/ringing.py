"""Which multipliers of an elastic machine belong to its rhythm and which to its ringing, and to which mode.

By participation factors l_n·r_n of the left and right eigenvectors (I. J. Pérez-Arriaga, G. C. Verghese and
F. C. Schweppe, IEEE Trans. Power Apparatus and Systems 101, 1982), which do not depend on the scales of
the coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["ModeShare", "Parted", "Ringing", "parted"]

_NOTHING = 1e-7  # a multiplier that is 0 but for rounding, which several zeros together magnify
_BELONGS = 0.5  # share of the motion as a whole from which a multiplier is one of the rhythm
_TOLD = 0.1  # share from which a mode is told


class ModeShare(NamedTuple):
    """A coordinate of the machine by its number (0: the motion as a whole), and its part in a multiplier, 0 to 1."""

    mode: int
    share: float


@dataclass(frozen=True)
class Ringing(Shown):
    """What rings longest of a machine in its cycle.

    Parameters
    ----------
    multiplier
        The greatest of those that belong to the elastic modes; of a pair that with the positive imaginary part.
    shares
        What each mode has of it, the greatest first; they sum to 1. Of a machine with a chamber the modes are its own
        (`Machine.modes`), which the chamber couples.
    """

    multiplier: complex
    shares: tuple[ModeShare, ...]

    @property
    def mode(self) -> int:
        """The mode with the greatest share."""
        return self.shares[0].mode

    @property
    def told(self) -> tuple[ModeShare, ...]:
        """The modes that are worth telling: that with the greatest share, and all with a tenth or more."""
        return tuple(one for i, one in enumerate(self.shares) if i == 0 or one.share >= _TOLD)

    @property
    def decay(self) -> float:
        """Cycles in which it falls to 1/e; infinite where it does not die out."""
        modulus = abs(self.multiplier)
        return -1.0 / math.log(modulus) if modulus < 1.0 else math.inf

    def __str__(self) -> str:
        return f"Ringing: mode {self.mode} ({100.0 * self.shares[0].share:.3g} %), modulus {abs(self.multiplier):.4g}"


class Parted(NamedTuple):
    """The greatest multiplier of the motion as a whole, and the ringing; None where there is none."""

    rhythm: complex | None
    ringing: Ringing | None


def parted(slope: Array, modes: int) -> Parted:
    """The multipliers of a cycle's map, parted into rhythm and ringing; pending orders are part of the rhythm."""
    from scipy.linalg import eig  # slow to import

    values, left, right = (np.asarray(one, dtype=complex) for one in eig(slope, left=True, right=True))
    felt = np.flatnonzero((np.abs(values) > _NOTHING) & (values.imag >= 0.0))
    felt = felt[np.argsort(-np.abs(values[felt]), kind="stable")]
    factors = left[:, felt].conj() * right[:, felt]
    size = 2 * (modes + 1)
    own = np.abs(factors[:size].reshape(modes + 1, 2, -1).sum(axis=1))
    own[0] += np.abs(factors[size:]).sum(axis=0)
    shares = own / np.maximum(own.sum(axis=0), np.finfo(float).tiny)
    whole = shares[0] > _BELONGS
    rhythm = complex(values[felt[whole][0]]) if whole.any() else None
    if whole.all():
        return Parted(rhythm, None)
    first = int(np.flatnonzero(~whole)[0])
    order = np.argsort(-shares[:, first], kind="stable").tolist()
    parts = tuple(ModeShare(mode, float(shares[mode, first])) for mode in order)
    return Parted(rhythm, Ringing(complex(values[felt[first]]), parts))
