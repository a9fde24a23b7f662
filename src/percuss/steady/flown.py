"""What must be known of a flight to prove that the bar does not touch the wall before its end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from percuss.model.checks import Array
from percuss.steady.truncation import Truncation, Untruncated

if TYPE_CHECKING:
    from percuss.steady.impact_state import ModalState

__all__ = ["Flown"]


class Flown(Untruncated, Protocol):
    """A flight from impact to impact: `Motion` has one of them, and `percuss.steady.periodic.flight.Flight` is one."""

    @property
    def phase(self) -> float:
        """Load phase of the impact from which the flight starts."""
        ...

    @property
    def period(self) -> float:
        """Duration of the flight."""
        ...

    @property
    def periods(self) -> int:
        """The load periods that it takes, rounded up."""
        ...

    @property
    def cut(self) -> bool: ...
    @property
    def modes(self) -> int: ...
    @property
    def truncation(self) -> Truncation: ...
    @property
    def state(self) -> ModalState:
        """The elastic modes at the impact from which the flight starts."""
        ...

    @property
    def error_bound(self) -> float: ...
    @property
    def rigid_rebound(self) -> float:
        """Mean velocity of the bar at the start of the flight."""
        ...

    @property
    def rebound_velocity(self) -> float:
        """Velocity of the striking end at the start of the flight."""
        ...

    @property
    def impact_velocity(self) -> float:
        """Velocity of the striking end at its end."""
        ...

    def end_motion(self, t: Array, modes: int) -> tuple[Array, Array]:
        """Gap function and its velocity with the first `modes` elastic modes; each of shape (len(t),)."""
        ...
