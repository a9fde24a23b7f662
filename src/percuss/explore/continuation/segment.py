"""A step along a curve of orbits, and the places in it where a number of the orbit vanishes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from percuss.explore.boundary_curves.roots import bracketed_roots
from percuss.explore.continuation.solution_curve import CurvePoint, Number, SolutionCurve
from percuss.model.checks import Array

__all__ = ["Segment"]


@dataclass(frozen=True)
class Segment:
    """The curve between two of its points; places in it are counted along the tangent at the first one.

    Parameters
    ----------
    curve
        The curve.
    start, stop
        Its ends.
    """

    curve: SolutionCurve
    start: CurvePoint
    stop: CurvePoint
    _points: dict[float, CurvePoint] = field(default_factory=dict, repr=False, compare=False)

    @property
    def length(self) -> float:
        """The place of the second point."""
        return float(self.start.tangent @ (self.stop.x - self.start.x))

    def at(self, place: float) -> CurvePoint:
        """The point at a place; Strayed where there is none."""
        if place == 0.0:
            return self.start
        if place == self.length:
            return self.stop
        if place not in self._points:
            ahead, length = self.start.tangent, self.length
            bend = self.stop.x - self.start.x - length * ahead
            near = self.start.x + place * ahead + (place / length) ** 2 * bend
            self._points[place] = self.curve.corrected(near, ahead)
        return self._points[place]

    def root(self, number: Number, low: float = 0.0, high: float | None = None, below: float | None = None) -> float:
        """Where a number vanishes that changes its sign between two places, to rounding.

        Parameters
        ----------
        number
            Of a point.
        low, high
            The places; the whole segment by default.
        below
            The number at `low`, where rounding would decide on its sign.
        """
        last = self.length if high is None else high
        first, second = number(self.at(low)) if below is None else below, number(self.at(last))

        def several(places: Array) -> Array:
            return np.array([number(self.at(float(place))) for place in places])

        if first * second >= 0.0:
            return low if abs(first) < abs(second) else last
        ends = (np.array([low]), np.array([last]), np.array([first]), np.array([second]))
        return float(bracketed_roots(several, *ends, steps=60)[0])
