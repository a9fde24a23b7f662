"""How a machine starts, and when following it ends."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from percuss.errors import ParameterError
from percuss.model.checks import count, finite, flag, non_negative

__all__ = ["Ending", "Limits", "Release"]

_MOST_PERIODS = 10**6
_MOST_IMPACTS = 10**6


class Ending(Enum):
    """Why a machine was followed no further; the value is a sentence."""

    SETTLED = "a periodic motion is found"
    PERIODS = "the number of load periods is reached"
    IMPACTS = "the number of impacts is reached"
    CANCELLED = "the caller ended it"


@dataclass(frozen=True)
class Release:
    """A start: the striker, free of stress, moves as a rigid body at some distance from what it strikes.

    Parameters
    ----------
    gap
        Distance between the faces in lengths of the striker, 0 or greater.
    velocity
        Toward the struck face, over LΩ.
    time
        In radians of the load.

    Raises
    ------
    ParameterError
        For numbers that are not finite, or a gap less than 0.
    """

    gap: float = 1.0
    velocity: float = 0.0
    time: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", non_negative("gap", self.gap))
        object.__setattr__(self, "velocity", finite("velocity", self.velocity))
        object.__setattr__(self, "time", finite("time", self.time))


@dataclass(frozen=True)
class Limits:
    """When to end; whichever comes first.

    Parameters
    ----------
    periods
        Load periods from the start.
    impacts
        Impacts from the start.
    settled
        Whether to end when a periodic motion is found.
    tolerance
        How near the state must come back at the end of load periods to be the same: the energy of the difference of
        two states, as a speed, and the difference of their gaps over a period, both over the greatest striking speed.

    Raises
    ------
    ParameterError
        For numbers out of range.
    """

    periods: int = 400
    impacts: int = 2000
    settled: bool = True
    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        object.__setattr__(self, "periods", count("periods", self.periods, most=_MOST_PERIODS))
        object.__setattr__(self, "impacts", count("impacts", self.impacts, most=_MOST_IMPACTS))
        object.__setattr__(self, "settled", flag("settled", self.settled))
        found = finite("tolerance", self.tolerance)
        if not 1e-12 <= found <= 0.1:
            raise ParameterError("tolerance", self.tolerance, "a number from 1e-12 to 0.1")
        object.__setattr__(self, "tolerance", found)
