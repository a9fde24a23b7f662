"""A curve of located points over two parameters as a value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.continuation.branch import BranchEvent, event_of
from percuss.explore.continuation.rest_following import RestEvent
from percuss.explore.point_curves.conditions import CurveEvent
from percuss.model.checks import Array, numbers, several
from percuss.shown import Shown
from percuss.steady import PeriodicOrbit


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
        The motion there, its impacts in the order of the curve.
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

    def at(self, kind: CurveEvent | str) -> tuple[CurvePoint, ...]:
        """The points of a kind, which may be told by its word; ParameterError for an unknown one."""
        wanted = event_of(CurveEvent, kind)
        return tuple(point for point in self.points if point.kind is wanted)

    def __str__(self) -> str:
        low, high = self.values.min(axis=0), self.values.max(axis=0)
        ranges = ", ".join(f"{name} {a:.9g} to {b:.9g}" for name, a, b in zip(self.parameters, low, high, strict=True))
        head = f"{self.event.value} of {self.label}: {len(self.values)} points, {ranges}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


# ---- A curve of ends of cycles with rest over two parameters as a value


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

    def at(self, kind: CurveEvent | str) -> tuple[RestCurvePoint, ...]:
        """The points of a kind, which may be told by its word; ParameterError for an unknown one."""
        wanted = event_of(CurveEvent, kind)
        return tuple(point for point in self.points if point.kind is wanted)

    def __str__(self) -> str:
        low, high = self.values.min(axis=0), self.values.max(axis=0)
        ranges = ", ".join(f"{name} {a:.9g} to {b:.9g}" for name, a, b in zip(self.parameters, low, high, strict=True))
        head = f"{self.event.value} of {self.label}: {len(self.values)} points, {ranges}"
        return "\n".join([head, *(f"  {point}" for point in self.points)])


# ---- The ranges in which two parameters are varied, and by how much each changes for what counts as a step of 1

Ranges: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

_ENDLESS = (-math.inf, math.inf)
_TWO = "two ranges, or None for one without ends"
_UNITS = 4.0  # of a range, which count as a step of 1 rad
_WIDE = 1e9  # a range wider than so many times the parameter says nothing of how it scales


def ranges_around(between: Sequence[tuple[float, float] | None] | None, here: tuple[float, float]) -> Ranges:
    """Two ranges that hold a place, checked; an endless one for None."""
    if between is None:
        return _ENDLESS, _ENDLESS
    given = several("between", between, _TWO)
    if len(given) != 2:
        raise ParameterError("between", between, _TWO)
    first, second = (_around(between, one, value) for one, value in zip(given, here, strict=True))
    return first, second


def _around(between: object, given: object, here: float) -> tuple[float, float]:
    if given is None:
        return _ENDLESS
    ends = numbers("between", given, _TWO)
    if ends.shape != (2,) or not ends[0] < ends[1]:
        raise ParameterError("between", between, f"{_TWO}, each from a lower to a higher value")
    if not ends[0] <= here <= ends[1]:
        raise ParameterError("between", between, f"a range around {here:.9g}, the point")
    return float(ends[0]), float(ends[1])


def units_of(bounds: Ranges, here: tuple[float, float]) -> tuple[float, float]:
    """By how much each parameter changes for a step of 1, powers of 2, so that nothing is rounded by it."""
    first, second = (_unit(low, high, value) for (low, high), value in zip(bounds, here, strict=True))
    return first, second


def _unit(low: float, high: float, value: float) -> float:
    scale = max(1.0, abs(value))
    size = scale if math.isinf(low) or math.isinf(high) else min((high - low) / _UNITS, _WIDE * scale)
    return float(2.0 ** round(math.log2(size)))
