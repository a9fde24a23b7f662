"""What happens at a point of a line of a diagram."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.continuation.rest_branch import RestEvent
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["DiagramPoint"]

_PLAIN = ("value", "label", "beyond", "impact", "touch_phase", "energy")


@dataclass(frozen=True)
class DiagramPoint(Shown):
    """A point of a branch at which something happens; dimensionless, phases in radians.

    Parameters
    ----------
    kind
        What happens.
    value
        Of the parameter.
    label
        Of the motion there: z=p/n, chatter/n or rest/n.
    phases, speeds
        Of its impacts; shape (p,). Of a cycle with rest those that its branch has.
    beyond
        What lies beyond, in a sentence.
    impact
        Number of the impact that dies or meets a step; or None.
    touch_phase
        Phase of the load at which the bar touches the wall; or None.
    energy
        Mean kinetic energy before an impact; of a cycle with rest, before a main blow.
    """

    kind: BranchEvent | RestEvent
    value: float
    label: str
    phases: Array = field(repr=False)
    speeds: Array = field(repr=False)
    beyond: str
    impact: int | None = None
    touch_phase: float | None = None
    energy: float = np.nan

    def __str__(self) -> str:
        return f"{self.kind.value} of {self.label} at {self.value:.12g}: {self.beyond}"

    @property
    def plain(self) -> dict[str, Any]:
        """Of JSON's types."""
        texts = {"kind": self.kind.value, "phases": self.phases.tolist(), "speeds": self.speeds.tolist()}
        return texts | {name: getattr(self, name) for name in _PLAIN}

    @classmethod
    def of(cls, row: Mapping[str, Any], kinds: Mapping[str, BranchEvent | RestEvent]) -> DiagramPoint:
        """A point from what was its `plain`; `kinds`: what may happen, by the words for it."""
        phases, speeds = np.array(row["phases"]), np.array(row["speeds"])
        return cls(kind=kinds[row["kind"]], phases=phases, speeds=speeds, **{name: row[name] for name in _PLAIN})
