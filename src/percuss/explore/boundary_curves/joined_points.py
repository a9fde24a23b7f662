"""Boundaries as curves over a parameter, and how points are joined to curves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.boundary_curves.crossings import FLIP, SPIRAL, Crossing
from percuss.explore.boundary_curves.grazing import GRAZING
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["FOLD", "KINDS", "Boundaries", "Curve", "linked"]

FOLD = "fold"

KINDS = (FOLD, FLIP, SPIRAL, GRAZING)
"""What can happen on a branch of steady motions."""

_FAR = 0.75  # in shares of the range of y and of a half turn: points farther apart are not of one curve
_GAP = 1e-3  # what each missing value of x adds to that


@dataclass(frozen=True, eq=False)
class Curve(Shown):
    """One boundary over x; every array of shape (n,), NaN where x has none.

    Parameters
    ----------
    kind
        One of `KINDS`.
    branch
        The monotone arc of v_f (for a fold: its extremum) on which the curve begins, counted by phase from 0.
    x, y
        The parameters, in their own units.
    phase
        Load phase of the impact there, rad in [0, 2π).
    residual
        Estimate of the error of y that is left: the step that Newton's method would still make.
    angle
        Of the multiplier on the unit circle, in rad: 0 at a fold, π at a flip; NaN for a grazing.
    outside
        How many other multipliers are outside the circle there: where there are some, the motion is unstable on both
        sides. NaN for folds and grazing.
    impact_velocity
        Striking speed of the motion there, dimensionless. Where it is not greater than 0 the motion strikes backward:
        the equations have it, a bar does not.
    """

    kind: str
    branch: int
    x: Array
    y: Array
    phase: Array
    residual: Array
    angle: Array
    outside: Array
    impact_velocity: Array

    @property
    def found(self) -> npt.NDArray[np.bool_]:
        """Where there is a boundary."""
        return ~np.isnan(self.y)

    def without(self, points: npt.NDArray[np.bool_]) -> Curve:
        """The curve with gaps at some of its points."""
        return replace(self, y=np.where(points, math.nan, self.y))


@dataclass(frozen=True, eq=False)
class Boundaries(Shown):
    """All boundaries of a plane.

    Parameters
    ----------
    x_name, y_name
        The parameters.
    x
        Values of the first, shape (n,).
    low, high
        Range of the second.
    curves
        The boundaries, in order of kind.
    failed
        Values of x at which nothing could be computed, with the reason.
    """

    x_name: str
    y_name: str
    x: Array
    low: float
    high: float
    curves: tuple[Curve, ...]
    failed: tuple[tuple[float, str], ...] = ()

    def of(self, kind: str) -> tuple[Curve, ...]:
        """The curves of one kind."""
        if kind not in KINDS:
            raise ParameterError("kind", kind, f"one of {', '.join(KINDS)}")
        return tuple(curve for curve in self.curves if curve.kind == kind)

    @property
    def real(self) -> tuple[Curve, ...]:
        """The curves without points on motions that strike backward."""
        kept = [c if c.kind == GRAZING else c.without(c.impact_velocity <= 0.0) for c in self.curves]
        return tuple(curve for curve in kept if curve.found.any())

    @property
    def of_stability(self) -> tuple[Curve, ...]:
        """The curves at which stability or existence of motions that there can be ends.

        Without crossings of motions that are unstable anyhow, or strike backward.
        """
        kept = [c.without(c.outside > 0.0) for c in self.real if c.kind != GRAZING]
        return tuple(curve for curve in kept if curve.found.any())

    def greatest(self, kind: str) -> Array:
        """The greatest y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmax)

    def least(self, kind: str) -> Array:
        """The least y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmin)

    def _extreme(self, kind: str, choose: np.ufunc) -> Array:
        found = np.full(self.x.shape, math.nan)
        for curve in self.of(kind):
            found = choose(found, curve.y)
        return found

    def __str__(self) -> str:
        head = f"{self.y_name} from {self.low:g} to {self.high:g} over {self.x.size} values of {self.x_name}"
        return "\n".join([head, *(f"  {c.kind}, branch {c.branch}: {int(c.found.sum())} points" for c in self.curves)])


def linked(kind: str, x: Array, rows: list[list[tuple[int, Crossing]]], span: float) -> list[Curve]:
    """Join the points of one kind to curves: each goes on with the point that is nearest in y and phase."""
    threads: list[dict[int, tuple[int, Crossing]]] = []
    for i, row in enumerate(rows):
        points = [(branch, crossing) for branch, crossing in row if crossing.kind == kind]
        pairs = sorted(
            (_distance(thread[max(thread)][1], point[1], span) + _GAP * (i - 1 - max(thread)), a, b)
            for a, thread in enumerate(threads)
            for b, point in enumerate(points)
        )
        taken_threads: set[int] = set()
        taken_points: set[int] = set()
        for distance, a, b in pairs:
            if distance < _FAR and a not in taken_threads and b not in taken_points:
                threads[a][i] = points[b]
                taken_threads.add(a)
                taken_points.add(b)
        threads += [{i: point} for b, point in enumerate(points) if b not in taken_points]
    return [_curve(kind, x, thread) for thread in threads]


def _distance(a: Crossing, b: Crossing, span: float) -> float:
    return abs(a.y - b.y) / span + abs(math.remainder(a.phase - b.phase, 2.0 * math.pi)) / math.pi


def _curve(kind: str, x: Array, thread: dict[int, tuple[int, Crossing]]) -> Curve:
    columns = np.full((6, x.size), math.nan)
    for i, (_, point) in thread.items():
        columns[:, i] = point.y, point.phase, point.residual, point.angle, point.outside, point.speed
    return Curve(kind, thread[min(thread)][0], x, *columns)
