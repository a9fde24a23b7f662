"""A recorded load read as a valve, and what of it is told: the reading, the verdict of a clock, the machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.shown import Shown

if TYPE_CHECKING:
    from percuss.case.answers.machine_answer import MachineAnswer
    from percuss.steady import RecordedValve

__all__ = ["ByClock", "ToldRecord"]


@dataclass(frozen=True)
class ByClock(Shown):
    """What B77's clock says of the recorded motion.

    Attributes
    ----------
    exists
        Whether a motion with the blow at the recorded phase is possible.
    stable
        Whether it is stable; None without one.
    multiplier
        The greatest multiplier of its rhythm; None without one.
    """

    exists: bool
    stable: bool | None
    multiplier: complex | None


@dataclass(frozen=True)
class ToldRecord(Shown):
    """A recorded load read as a valve; `RecordedAnswer` says what the fields are."""

    read: RecordedValve
    clock: ByClock
    answer: MachineAnswer

    @property
    def runs(self) -> bool:
        """Whether the machine of the best reading runs."""
        return self.answer.runs
