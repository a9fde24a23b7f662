"""When a place of a body first enters a region in a flight, or the proof that it does not: bounds, not a scan.

In a cell of time of the width h, r, r′ and r″ are known at its left edge, and |r‴| is bounded from the free motion of
the derivatives: the acceleration a of a coordinate obeys a″ + d a′ + ω² a = 0, so that in every regime of damping
|a′| ≤ |a′₀| + ω² min(h, 1/ω)|a₀|. A cell is done with when Taylor's theorem proves that r keeps its sign there, or only
falls, or only rises; others are halved.

A place that leaves an edge is measured from there by how far it has moved, and not by where it is: the way back after a
slow rebound is far less than the rounding error of a place. A rebound too short for the cells is a parabola.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.mechanics.flow import ModalFlight
from percuss.model.checks import Array

_EPS = 2.0**-52
_CELLS = 32
_NARROWEST = 1e-13  # of the flight: narrower cells are not split
_MOST_WORK = 20_000_000  # coordinates × times
_BENT = 0.1  # of the acceleration: what the third derivative adds to it until a short rebound turns
_TOUCH = 1e-11  # of the levels: an edge met this nearly at the end of the flight is met there
_MOST_HALVINGS = 200  # each leaves at most half, or Newton's method converges


class Regions(NamedTuple):
    """What is looked at: r = rows · displacements − levels − drifts · time, entered where r rises through 0.

    Shapes (k, N + 1), (k,) and (k,); against the length `scale` a touch is small.
    """

    rows: Array
    levels: Array
    scale: float
    drifts: Array


class Entering(NamedTuple):
    """The first time at which a region is entered, infinite for none, which one, and whether this is proved."""

    time: float
    which: int
    proven: bool


class _Cells(NamedTuple):
    """r and its derivatives at left edges of cells, and the bound of the third; each of shape (k, cells)."""

    r: Array
    first: Array
    second: Array
    third: Array

    def greatest(self, h: float) -> Array:
        """A bound of r above, within the cells."""
        bent = np.maximum(self.second, 0.0) * (0.5 * h * h)
        return self.r + np.maximum(self.first, 0.0) * h + bent + self.third * (h**3 / 6.0)

    def greatest_rate(self, h: float) -> Array:
        return self.first + np.maximum(self.second, 0.0) * h + self.third * (0.5 * h * h)

    @property
    def reversed(self) -> _Cells:
        """Those of −r, whose bounds above are those of r below."""
        return _Cells(-self.r, -self.first, -self.second, self.third)


@dataclass(frozen=True)
class _Sight:
    """r of some rows in a flight, `off` being r at its start."""

    flight: ModalFlight
    rows: Array
    off: Array
    drifts: Array

    def _derivatives(self, t: Array, h: float | Array) -> tuple[Array, Array, Array, Array]:
        """How far the coordinates have moved, two derivatives, and a bound of the third within h."""
        flight, modes = self.flight, self.flight.modes
        omega, damping = modes.omega[:, None], modes.damping[:, None]
        moved, v = flight.moved(t)
        force = modes.driven[:, None] * (flight.force + flight.ramp * t)
        a = force - omega**2 * (flight.begin[:, :1] + moved) - damping * v
        turned = np.abs(omega**2 * v + damping * a - (modes.driven * flight.ramp)[:, None])
        return moved, v, a, turned + omega * np.minimum(omega * h, 1.0) * np.abs(a)

    def cells(self, left: Array, h: float) -> _Cells:
        moved, v, a, jerk = self._derivatives(left, h)
        off, drifts = self.off[:, None], self.drifts[:, None]
        r, first = off + self.rows @ moved - drifts * left, self.rows @ v - drifts
        return _Cells(r, first, self.rows @ a, np.abs(self.rows) @ jerk)

    def r(self, region: int, t: float) -> float:
        moved = self.rows[region] @ self.flight.moved(np.array([t]))[0][:, 0]
        return float(self.off[region] + moved - self.drifts[region] * t)

    def root(self, region: int, start: float, stop: float) -> float:
        """Where r rises through 0 between two times: Newton's method, halving where it would leave them."""
        row, off, drift, t = self.rows[region], self.off[region], self.drifts[region], 0.5 * (start + stop)
        for _ in range(_MOST_HALVINGS):
            moved, v = self.flight.moved(np.array([t]))
            r, rate = float(off + row @ moved[:, 0] - drift * t), float(row @ v[:, 0] - drift)
            start, stop = (t, stop) if r < 0.0 else (start, t)
            step = t - r / rate if rate > 0.0 else start
            if abs(step - t) <= 4.0 * _EPS * stop or stop - start <= 4.0 * _EPS * stop:
                return t
            t = step if start < step < stop else 0.5 * (start + stop)
        return t

    def bounces(self, span: float) -> Array:
        """When what leaves an edge is back there, where the parabola from the start decides that; else infinite."""
        found, begin = np.full(len(self.rows), np.inf), np.zeros(1)
        _, v, a, _ = self._derivatives(begin, 0.0)
        first, second = (self.rows @ v)[:, 0] - self.drifts, (self.rows @ a)[:, 0]
        for region in np.flatnonzero((self.off == 0.0) & (first < 0.0) & (second > 0.0)).tolist():
            turned = float(-first[region] / second[region])
            bent = float((np.abs(self.rows[region]) @ self._derivatives(begin, 3.0 * turned)[3])[0]) * turned
            if 3.0 * turned <= span and bent <= _BENT * second[region]:
                found[region] = self.root(region, 1.5 * turned, 3.0 * turned)
        return found


def first_entering(flight: ModalFlight, regions: Regions) -> Entering:
    """The first region that is entered before the end of the flight; one whose edge is met at its end is not."""
    span, best, which, work, proven = flight.duration, np.inf, -1, 0, True
    if span <= 0.0 or not len(regions.rows):
        return Entering(np.inf, -1, True)
    h, touch = span / _CELLS, _TOUCH * regions.scale
    slow = touch / span
    off, leaves = regions.rows @ flight.begin[:, 0] - regions.levels, regions.rows @ flight.begin[:, 1] < regions.drifts
    sight = _Sight(flight, regions.rows, np.where((np.abs(off) <= touch) & leaves, 0.0, off), regions.drifts)
    bounces = sight.bounces(span)
    bounced = np.isfinite(bounces)
    if bounced.any():
        best, which = float(bounces.min()), int(np.argmin(bounces))
    left = h * np.arange(_CELLS, dtype=float)
    while left.size:
        work += left.size * flight.modes.omega.size
        if h < _NARROWEST * span or work > _MOST_WORK:
            proven = False
            break
        now = sight.cells(left, h)
        below = now.reversed
        from_rest = (now.r <= touch) & (now.first <= slow) & (now.second + now.third * h < 0.0)
        falls = now.greatest_rate(h) < 0.0
        sinks = (left == 0.0) & (now.r >= -touch) & (now.first >= -slow) & (now.second - now.third * h > 0.0)
        sinks &= ~bounced[:, None]
        if (at_once := np.any(sinks & (now.r <= touch), axis=1)).any():
            return Entering(0.0, int(np.argmax(at_once)), True)
        done = (now.greatest(h) < 0.0) | (below.greatest(h) < 0.0) | falls | from_rest | bounced[:, None]
        rises = ~done & (below.greatest_rate(h) < 0.0)
        for region, cell in zip(*np.nonzero(rises), strict=True):
            start = float(left[cell])
            stop = min(start + h, span)
            over = touch if stop >= span * (1.0 - 1e-12) else 0.0
            if now.r[region, cell] < 0.0 and start < best and sight.r(region, stop) > over:
                time = sight.root(region, start, stop)
                if time < best:
                    best, which = time, int(region)
        open_ = np.any(~(done | rises), axis=0) & (left < best)
        left, h = _halved(left[open_], h), 0.5 * h
    return Entering(best, which, proven)


def _halved(left: npt.NDArray[np.floating], h: float) -> Array:
    """Left edges of the halves of cells."""
    return np.asarray(np.sort(np.concatenate([left, left + 0.5 * h])), dtype=float)


def farthest(flight: ModalFlight, row: Array, drift: float = 0.0) -> float:
    """The greatest of −row · displacements − drift · time in a flight: cells that cannot hold it are dropped."""
    sight, span = _Sight(flight, -row[None, :], -row @ flight.begin[:, :1], np.array([drift])), flight.duration
    best = max(sight.r(0, 0.0), sight.r(0, span))
    h = span / _CELLS
    left = h * np.arange(_CELLS, dtype=float)
    while left.size and h > _NARROWEST * span:
        now = sight.cells(left, h)
        best = max(best, float(now.r.max()))
        level = (now.greatest_rate(h)[0] < 0.0) | (now.reversed.greatest_rate(h)[0] < 0.0)  # the edges are looked at
        left = left[(now.greatest(h)[0] > best * (1.0 + 1e-14)) & ~level]
        if left.size == 1:  # the top: one cell, bent down all over it?
            only = sight.cells(left, h)
            if float(only.second[0, 0] + only.third[0, 0] * h) < 0.0:
                return max(best, _top(sight, float(left[0]), min(float(left[0]) + h, span)))
        left, h = _halved(left, h), 0.5 * h
    return best


def _top(sight: _Sight, low: float, high: float) -> float:
    """The greatest r between two times between which it is bent down: Newton's method for the rate, or halving."""
    t, best = low, max(sight.r(0, low), sight.r(0, high))
    for _ in range(_MOST_HALVINGS):
        _, v, a, _ = sight._derivatives(np.array([t]), 0.0)
        rate, bent = float(sight.rows[0] @ v[:, 0] - sight.drifts[0]), float(sight.rows[0] @ a[:, 0])
        low, high = (t, high) if rate > 0.0 else (low, t)
        step = t - rate / bent
        following = step if low < step < high else 0.5 * (low + high)
        if abs(following - t) <= 4.0 * _EPS * high:
            break
        t = following
    return max(best, sight.r(0, t))
