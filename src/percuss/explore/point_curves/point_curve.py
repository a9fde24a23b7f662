"""A curve of located points over two parameters as a value."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.kinds import BranchEvent
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady import PeriodicOrbit

__all__ = ["CurvePoint", "PointCurve"]


@dataclass(frozen=True)
class CurvePoint(Shown):
    """A point of a curve at which something happens; made by `follow_point`.

    Parameters
    ----------
    kind
        What happens.
    values
        Of both parameters.
    orbit
        The motion there.
    beyond
        What lies beyond, in a sentence.
    """

    kind: CurveEvent
    values: tuple[float, float]
    orbit: PeriodicOrbit = field(repr=False)
    beyond: str

    def __str__(self) -> str:
        return f"{self.kind.value} at {self.values[0]:.12g}, {self.values[1]:.12g}: {self.beyond}"


@dataclass(frozen=True)
class PointCurve(Shown):
    """The orbits z=p/n over two parameters that are all folds, flips, grazings …; made by `follow_point`.

    Parameters
    ----------
    event
        What they are.
    parameters
        The names of both.
    impacts, periods, modes
        p, n and N.
    values
        Of both parameters along the curve; shape (m, 2).
    times
        Times of the impacts in rad, unwrapped; shape (m, p).
    is_orbit
        Where the motion is possible otherwise; elsewhere it touches the wall in another place, or strikes backwards.
        Shape (m,).
    angles
        Of the multipliers on the unit circle, in rad: 0 for folds, π for flips; NaN for grazings and corners. Shape
        (m,).
    units
        Of both parameters; empty for plain numbers.
    points
        What happens, in order along the curve, its two ends first and last; of a closed one both are where it closes.
    """

    event: BranchEvent
    parameters: tuple[str, str]
    impacts: int
    periods: int
    modes: int
    values: Array = field(repr=False)
    times: Array = field(repr=False)
    is_orbit: npt.NDArray[np.bool_] = field(repr=False)
    angles: Array = field(repr=False)
    units: tuple[str, str]
    points: tuple[CurvePoint, ...]

    @property
    def label(self) -> str:
        """z=p/n."""
        return f"z={self.impacts}/{self.periods}"

    @property
    def kind(self) -> str:
        """The word of what they are."""
        return str(self.event.value)

    @property
    def real(self) -> Array:
        """`values`, NaN where the motion is no orbit; shape (m, 2)."""
        return np.where(self.is_orbit[:, None], self.values, np.nan)

    @property
    def phases(self) -> Array:
        """Phases of the load at the impacts, in [0, 2π); shape (m, p)."""
        return np.mod(self.times, 2.0 * np.pi)

    @property
    def ends(self) -> tuple[CurvePoint, CurvePoint]:
        """Its first and its last point."""
        return self.points[0], self.points[-1]

    def at(self, kind: CurveEvent) -> tuple[CurvePoint, ...]:
        """The points of a kind."""
        return tuple(point for point in self.points if point.kind is kind)

    def __str__(self) -> str:
        low, high = self.values.min(axis=0), self.values.max(axis=0)
        ranges = ", ".join(f"{name} {a:.9g} to {b:.9g}" for name, a, b in zip(self.parameters, low, high, strict=True))
        head = f"{self.event.value} of {self.label}: {len(self.values)} points, {ranges}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])
