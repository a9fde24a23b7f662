"""When a place of the body first enters a region in a flight, or the proof that it does not: bounds, not a scan.

In a cell of time of the width h, r, r′ and r″ are known at its left edge, and |r‴| is bounded from the free motion of
the derivatives: the acceleration a of a coordinate obeys a″ + d a′ + ω² a = 0, so that in every regime of damping
|a′| ≤ |a′₀| + ω² min(h, 1/ω)|a₀|. A cell is done with when Taylor's theorem proves that r keeps its sign there, or only
falls, or only rises; others are halved.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.steady.self_excited.modal_flight import ModalFlight

__all__ = ["Entering", "Regions", "farthest", "first_entering"]

_EPS = 2.0**-52
_CELLS = 32
_NARROWEST = 1e-13  # of the flight: narrower cells are not split
_MOST_WORK = 20_000_000  # coordinates × times
_TOUCH = 1e-11  # of the levels: an edge met this nearly at the end of the flight is met there


@dataclass(frozen=True)
class Regions:
    """What is looked at: r = rows · displacements − levels, entered where r rises through 0.

    Parameters
    ----------
    rows, levels
        Shapes (k, N + 1) and (k,).
    scale
        Length against which a touch is small.
    """

    rows: Array
    levels: Array
    scale: float


@dataclass(frozen=True)
class Entering:
    """The first time at which a region is entered, infinite for none, which one, and whether this is proved."""

    time: float
    which: int
    proven: bool


@dataclass(frozen=True)
class _Cells:
    """r and its derivatives at left edges of cells, and the bound of the third; each of shape (k, cells)."""

    r: Array
    first: Array
    second: Array
    third: Array

    def greatest(self, h: float) -> Array:
        """A bound of r above, within the cells."""
        bent = np.maximum(self.second, 0.0) * (0.5 * h * h)
        return self.r + np.maximum(self.first, 0.0) * h + bent + self.third * (h**3 / 6.0)

    def least(self, h: float) -> Array:
        bent = np.minimum(self.second, 0.0) * (0.5 * h * h)
        return self.r + np.minimum(self.first, 0.0) * h + bent - self.third * (h**3 / 6.0)

    def greatest_rate(self, h: float) -> Array:
        return self.first + np.maximum(self.second, 0.0) * h + self.third * (0.5 * h * h)

    def least_rate(self, h: float) -> Array:
        return self.first + np.minimum(self.second, 0.0) * h - self.third * (0.5 * h * h)


def _cells(flight: ModalFlight, regions: Regions, left: Array, h: float) -> _Cells:
    modes = flight.modes
    omega, damping = modes.omega[:, None], modes.damping[:, None]
    u, v = flight.at(left)
    a = (flight.force * modes.driven)[:, None] - omega**2 * u - damping * v
    jerk = np.abs(omega**2 * v + damping * a) + omega * np.minimum(omega * h, 1.0) * np.abs(a)
    rows = regions.rows
    return _Cells(rows @ u - regions.levels[:, None], rows @ v, rows @ a, np.abs(rows) @ jerk)


def first_entering(flight: ModalFlight, regions: Regions) -> Entering:
    """The first region that is entered before the end of the flight; one whose edge is met at its end is not."""
    span, best, which, work, proven = flight.duration, np.inf, -1, 0, True
    if span <= 0.0 or not len(regions.rows):
        return Entering(np.inf, -1, True)
    h, touch = span / _CELLS, _TOUCH * regions.scale
    left: Array = _halved(h * np.arange(0, _CELLS, 2), 2.0 * h)
    while left.size:
        work += left.size * flight.modes.omega.size
        if h < _NARROWEST * span or work > _MOST_WORK:
            proven = False
            break
        now = _cells(flight, regions, left, h)
        from_rest = (now.r <= touch) & (now.first <= 0.0) & (now.second + now.third * h < 0.0)
        falls = now.greatest_rate(h) < 0.0
        sinks = (left == 0.0) & (now.r >= -touch) & (now.first >= 0.0) & (now.second - now.third * h > 0.0)
        if (at_once := np.any(sinks & (now.r <= touch), axis=1)).any():
            return Entering(0.0, int(np.argmax(at_once)), True)
        done = (now.greatest(h) < 0.0) | (now.least(h) > 0.0) | falls | from_rest
        rises = ~done & (now.least_rate(h) > 0.0)
        for region, cell in zip(*np.nonzero(rises), strict=True):
            start = float(left[cell])
            stop = min(start + h, span)
            over = touch if stop >= span * (1.0 - 1e-12) else 0.0
            if now.r[region, cell] < 0.0 and start < best and _r(flight, regions, region, stop) > over:
                time = _root(flight, regions, region, start, stop)
                if time < best:
                    best, which = time, int(region)
        open_ = np.any(~(done | rises), axis=0) & (left < best)
        left = _halved(left[open_], h)
        h *= 0.5
    return Entering(best, which, proven)


def _halved(left: npt.NDArray[np.floating], h: float) -> Array:
    """Left edges of the halves of cells."""
    return np.asarray(np.sort(np.concatenate([left, left + 0.5 * h])), dtype=float)


def _r(flight: ModalFlight, regions: Regions, region: int, t: float) -> float:
    return float(regions.rows[region] @ flight.at(np.array([t]))[0][:, 0] - regions.levels[region])


def _root(flight: ModalFlight, regions: Regions, region: int, start: float, stop: float) -> float:
    from scipy.optimize import brentq  # slow to import

    return float(brentq(lambda t: _r(flight, regions, region, t), start, stop, xtol=_EPS * stop, rtol=4.0 * _EPS))


def farthest(flight: ModalFlight, row: Array) -> float:
    """The greatest of −row · displacements in a flight, by bounds: cells that cannot hold it are dropped."""
    regions, span = Regions(-row[None, :], np.zeros(1), 1.0), flight.duration
    best = max(_r(flight, regions, 0, 0.0), _r(flight, regions, 0, span))
    h = span / _CELLS
    left: Array = _halved(h * np.arange(0, _CELLS, 2), 2.0 * h)
    while left.size and h > _NARROWEST * span:
        now = _cells(flight, regions, left, h)
        best = max(best, float(now.r.max()))
        level = (now.greatest_rate(h)[0] < 0.0) | (now.least_rate(h)[0] > 0.0)  # the edges are looked at
        left = left[(now.greatest(h)[0] > best * (1.0 + 1e-14)) & ~level]
        if left.size == 1:  # the top: one cell, bent down all over it?
            only = _cells(flight, regions, left, h)
            if float(only.second[0, 0] + only.third[0, 0] * h) < 0.0:
                return max(best, _top(flight, regions, float(left[0]), min(float(left[0]) + h, span)))
        left = _halved(left, h)
        h *= 0.5
    return best


def _top(flight: ModalFlight, regions: Regions, start: float, stop: float) -> float:
    """The greatest r between two times between which it is bent down."""
    from scipy.optimize import brentq  # slow to import

    def rate(t: float) -> float:
        return float(regions.rows[0] @ flight.at(np.array([t]))[1][:, 0])

    if rate(start) <= 0.0 or rate(stop) >= 0.0:
        return max(_r(flight, regions, 0, start), _r(flight, regions, 0, stop))
    return _r(flight, regions, 0, float(brentq(rate, start, stop, xtol=_EPS * stop, rtol=4.0 * _EPS)))
