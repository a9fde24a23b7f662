"""A curve of ends of cycles with rest over two parameters as a value."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.rest_branch import RestEvent
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["RestCurvePoint", "RestPointCurve"]


@dataclass(frozen=True)
class RestCurvePoint(Shown):
    """A point of a curve of ends of cycles with rest at which something happens; made by `follow_point`.

    Parameters
    ----------
    kind
        What happens.
    values
        Of both parameters.
    beyond
        What lies beyond, in a sentence.
    """

    kind: CurveEvent
    values: tuple[float, float]
    beyond: str

    def __str__(self) -> str:
        return f"{self.kind.value} at {self.values[0]:.12g}, {self.values[1]:.12g}: {self.beyond}"


@dataclass(frozen=True)
class RestPointCurve(Shown):
    """Where cycles with rest end, over two parameters; made by `follow_point`.

    Parameters
    ----------
    event
        How they end: an onset, a touch, the death of an impact, or the last release.
    label, modes
        chatter/n or rest/n, and N.
    parameters
        The names of both.
    values
        Of both parameters along the curve; shape (m, 2).
    release_phases
        When the bar is let go whose way ends so, in [0, 2π); shape (m,).
    event_phases
        When it does: the release that its rest meets, the touch, the least load. Shape (m,).
    is_orbit
        Where the cycle is there beside the curve; elsewhere the bar let go comes back otherwise. Shape (m,).
    units
        Of both parameters; empty for plain numbers.
    points
        What happens, in order along the curve, its two ends first and last; of a closed one both are where it closes.
    """

    event: RestEvent
    label: str
    modes: int
    parameters: tuple[str, str]
    values: Array = field(repr=False)
    release_phases: Array = field(repr=False)
    event_phases: Array = field(repr=False)
    is_orbit: npt.NDArray[np.bool_] = field(repr=False)
    units: tuple[str, str]
    points: tuple[RestCurvePoint, ...]

    @property
    def kind(self) -> str:
        """The word of how they end."""
        return str(self.event.value)

    @property
    def real(self) -> Array:
        """`values`, NaN where the cycle is not there; shape (m, 2)."""
        return np.where(self.is_orbit[:, None], self.values, np.nan)

    @property
    def ends(self) -> tuple[RestCurvePoint, RestCurvePoint]:
        """Its first and its last point."""
        return self.points[0], self.points[-1]

    def at(self, kind: CurveEvent) -> tuple[RestCurvePoint, ...]:
        """The points of a kind."""
        return tuple(point for point in self.points if point.kind is kind)

    def __str__(self) -> str:
        low, high = self.values.min(axis=0), self.values.max(axis=0)
        ranges = ", ".join(f"{name} {a:.9g} to {b:.9g}" for name, a, b in zip(self.parameters, low, high, strict=True))
        head = f"{self.event.value} of {self.label}: {len(self.values)} points, {ranges}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])
