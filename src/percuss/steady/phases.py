"""All phases at which the rigid velocity meets a level, and the proof that there are no others.

The critical points of v_f cut the circle into arcs on which v_f is monotone, so that each arc holds at most one root,
and holds one exactly when the level lies between the values at its ends. The critical points themselves are found by
subdivision with a curvature bound: a cell is dropped only when Taylor's theorem proves that it holds no root, and
accepted only when it proves that it holds at most one.
"""

from __future__ import annotations

import cmath
import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.piecewise import PiecewiseResponse

__all__ = ["Arcs", "Response", "forced_response", "harmonic_sums", "on_circle", "trigonometric_roots"]

TURN = 2.0 * math.pi
_EPS = np.finfo(float).eps
_LAST_STEP = 1e-8
_NODES = 129  # of the table that starts Newton's method on an arc
_FEW = 8  # phases that are found one by one: numpy takes as long for one number as for a hundred
_LEVELS = 26  # of bisection: a multiple root is then taken as one point

Response: TypeAlias = HarmonicResponse | PiecewiseResponse
Curve: TypeAlias = Callable[[Array], tuple[Array, Array]]


@lru_cache(maxsize=32)
def forced_response(system: System) -> Response:
    """The forced response, exact for the load's own form: piecewise where that is known, else by harmonics.

    The last few are kept: every motion of a system, and whatever is asked of it, shares one.
    """
    return PiecewiseResponse(system) if system.load.is_piecewise else HarmonicResponse(system)


def trigonometric_roots(k: Array, coefficients: ComplexArray) -> Array:
    """All real roots in [0, 2π) of g(θ) = Re Σ c_k exp(ikθ), increasing.

    A root of even order, where g touches zero within rounding, may be given once, twice or not at all; all others
    are found, each once.

    Parameters
    ----------
    k, coefficients
        Wave numbers k ≥ 0 and complex coefficients, equal shapes.
    """
    curvature = float(np.sum(k**2 * np.abs(coefficients)))
    if curvature < np.finfo(float).tiny / _EPS:
        return np.empty(0)  # a constant, or nothing above the smallest numbers
    noise = 8.0 * _EPS * float(np.sum((1.0 + k) * np.abs(coefficients)))

    def value(theta: Array) -> tuple[Array, Array]:
        g, slope = harmonic_sums(theta, k, coefficients, 1j * k * coefficients)
        return g, slope

    count = max(32, 8 * int(k.max(initial=1.0)))
    cells = np.arange(count)  # cell j of the level's count reaches from edge j to edge j + 1
    brackets: list[np.typing.NDArray[np.int64]] = []  # in units of the finest grid
    for level in range(_LEVELS + 1):
        half = math.pi / count
        g, slope = value(np.asarray(half * (2.0 * cells + 1.0), dtype=float))
        empty = np.abs(g) > np.abs(slope) * half + 0.5 * curvature * half**2 + noise
        monotone = ~empty & (np.abs(slope) > curvature * half + noise)
        if level == _LEVELS:
            monotone = ~empty
        brackets.append(cells[monotone] << (_LEVELS - level))
        brackets.append((cells[monotone] + 1) << (_LEVELS - level))
        left = cells[~empty & ~monotone]
        cells, count = np.concatenate([2 * left, 2 * left + 1]), 2 * count
        if not cells.size:
            break
    finest = (count >> (level + 1)) << _LEVELS
    low, high = np.concatenate(brackets[::2]), np.concatenate(brackets[1::2])
    # every edge is looked at once, so that a root on an edge belongs to one of its two cells and not to both or none
    edges, where = np.unique(np.concatenate([low, high]) % finest, return_inverse=True)
    below = (value(TURN * edges / finest)[0] < 0.0)[where]
    crossed = below[: low.size] != below[low.size :]
    starts, stops = TURN * low[crossed] / finest, TURN * high[crossed] / finest
    roots = _polished(starts, stops, value, np.zeros(starts.size))
    return np.sort(on_circle(roots))


def on_circle(theta: Array) -> Array:
    """The phases in [0, 2π); a rounding below 0 becomes 0 and not 2π."""
    phases = np.mod(theta, TURN)
    return np.asarray(np.where(phases >= TURN, 0.0, phases))


def harmonic_sums(theta: Array, k: Array, *coefficients: ComplexArray) -> list[Array]:
    """Re Σ c_k exp(ikθ) for several sets of coefficients at once, by Horner's rule in exp(iθ).

    Parameters
    ----------
    theta
        Any shape.
    k
        Whole wave numbers ≥ 0, increasing.
    coefficients
        Each of the shape of `k`.
    """
    turn = np.exp(1j * np.asarray(theta, dtype=float))
    totals = [np.zeros_like(turn) for _ in coefficients]
    dense = np.zeros((len(coefficients), int(k.max(initial=0.0)) + 1), dtype=complex)
    dense[:, k.astype(int)] = coefficients
    for column in dense.T[::-1]:
        for total, coefficient in zip(totals, column, strict=True):
            total *= turn
            total += coefficient
    return [total.real for total in totals]


def _polished(low: Array, high: Array, value: Curve, level: Array, start: Array | None = None) -> Array:
    """Newton's method kept inside brackets [low, high] on which `value` is monotone; equal shapes (n,)."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    theta = 0.5 * (low + high) if start is None else np.array(start, dtype=float)
    if not low.size:
        return theta
    below = value(low)[0] < level
    active = np.arange(low.size)
    for _ in range(100):
        here = theta[active]
        g, slope = value(here)
        g = g - level[active]
        left = (g < 0.0) == below[active]
        low[active] = np.where(left, here, low[active])
        high[active] = np.where(left, high[active], here)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = here - g / slope
        slack = 4.0 * _EPS * (1.0 + np.abs(here))  # a root on the bracket's edge must stay in reach
        inside = (step >= low[active] - slack) & (step <= high[active] + slack)
        new = np.where(g == 0.0, here, np.where(inside, step, 0.5 * (low[active] + high[active])))
        theta[active] = new
        # after a Newton step this small the next would be below rounding; a bisection says no such thing
        active = active[np.abs(new - here) > np.where(inside, _LAST_STEP, slack)]
        if not active.size:
            break
    return theta


@dataclass(frozen=True)
class Arcs:
    """The arcs of the circle on which v_f is monotone.

    Parameters
    ----------
    ends
        Phases of the n critical points or breaks, increasing, and the first one again a turn later; shape (n + 1,).
    velocities
        v_f there.
    response
        What v_f belongs to.
    """

    ends: Array
    velocities: Array
    response: Response

    @staticmethod
    @lru_cache(maxsize=32)
    def of(response: Response) -> Arcs:
        """Cut the circle at the critical points (or kinks) of the rigid velocity; the last few are kept."""
        if isinstance(response, PiecewiseResponse):
            ends = response.starts
        elif response.k.size == 1:
            k = int(response.k[0])
            ends = np.sort(on_circle((np.pi * np.arange(2 * k) - np.angle(response.rigid_factor[0])) / k))
        else:
            ends = _critical_phases(response.k.tobytes(), response.rigid_factor.tobytes())
        ends = np.append(ends, ends[0] + TURN)
        return Arcs(ends, response.rigid_velocity(np.append(ends[:-1], ends[0])), response)

    @property
    def highest(self) -> float:
        """max v_f."""
        return float(self.velocities.max())

    @property
    def tolerance(self) -> float:
        """Differences of v_f below this are rounding."""
        return 32.0 * _EPS * self.response.rigid_bounds()[0]

    def roots(self, level: float) -> tuple[Array, Array]:
        """All phases in [0, 2π) with v_f = level, increasing, and whether each is a tangency (fold).

        Returns
        -------
        phases, folds
            Equal shapes (n,).
        """
        off = self.velocities - level
        touching = np.abs(off) <= self.tolerance
        folds = self.ends[:-1][touching[:-1]]
        crossed = (off[:-1] * off[1:] < 0.0) & ~touching[:-1] & ~touching[1:]
        index = np.flatnonzero(crossed)
        simple = self.invert(index, np.full(index.size, level))
        phases = on_circle(np.concatenate([simple, folds]))
        tangent = np.concatenate([np.zeros(simple.size, bool), np.ones(folds.size, bool)])
        order = np.argsort(phases)
        return phases[order], tangent[order]

    def invert(self, arc: np.typing.NDArray[np.intp], level: Array) -> Array:
        """The phase on arc number `arc` where v_f equals `level`, which must lie between its ends; broadcasts."""
        r = self.response
        if isinstance(r, PiecewiseResponse):
            d, v = r.system.d, r.knot_velocity[arc]
            x = d * (level - v) / (r.pull[arc] - d * v)  # v_f moves exponentially: 1 − exp(−dτ) = x
            with np.errstate(divide="ignore", invalid="ignore"):
                stretch = np.where(x == 0.0, 1.0, -np.log1p(-x) / np.where(x == 0.0, 1.0, x))
            return np.asarray(self.ends[arc] + (level - v) / (r.pull[arc] - d * v) * stretch)

        if r.k.size == 1:  # v_f = V cos k(θ − θ_0): arccos from the extreme where the arc starts
            from_top = np.clip(level / self.velocities[arc], -1.0, 1.0)
            return np.asarray(self.ends[arc] + np.arccos(from_top) / r.k[0])

        waves = r.k.tobytes(), r.rigid_factor.tobytes()
        if level.size <= _FEW and r.k[-1] <= _FEW:
            pairs = zip(arc.ravel().tolist(), level.ravel().tolist(), strict=True)
            found = [_one_phase(waves, float(self.ends[i]), float(self.ends[i + 1]), v) for i, v in pairs]
            return np.array(found, dtype=float).reshape(level.shape)

        low, high, start = np.empty(level.shape), np.empty(level.shape), np.empty(level.shape)
        for number in np.unique(arc):
            here, ends = arc == number, self.ends[number : number + 2]
            low[here], high[here], start[here] = _bracketed(level[here], *_nodes(*waves, *ends.tolist()))
        return _polished(low, high, _waves(*waves), level, start)


# What follows depends on the alternating load and on d alone, so that a change of R, of s or of the mean load finds it
# made already.


def _waves(k: bytes, factor: bytes) -> Curve:
    """v_f and v_f' of a load's harmonics."""
    numbers, velocity = np.frombuffer(k), np.frombuffer(factor, dtype=complex)

    def value(theta: Array) -> tuple[Array, Array]:
        v, slope = harmonic_sums(theta, numbers, velocity, 1j * numbers * velocity)
        return v, slope

    return value


@lru_cache(maxsize=64)
def _critical_phases(k: bytes, factor: bytes) -> Array:
    """Where v_f' = 0, increasing."""
    numbers, velocity = np.frombuffer(k), np.frombuffer(factor, dtype=complex)
    roots = trigonometric_roots(numbers, 1j * numbers * velocity)
    roots.setflags(write=False)
    return roots


@lru_cache(maxsize=256)
def _nodes(k: bytes, factor: bytes, start: float, stop: float) -> tuple[Array, Array]:
    """Phases of an arc that crowd at its ends, where v_f is flat, and v_f there, which never falls; shapes (129,)."""
    nodes = start + (stop - start) * np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, _NODES)) ** 2
    heights = _waves(k, factor)(nodes)[0]
    if heights[0] > heights[-1]:
        nodes, heights = nodes[::-1], heights[::-1]
    heights = np.maximum.accumulate(heights)  # rounding where the arc is flat
    nodes.setflags(write=False)
    heights.setflags(write=False)
    return nodes, heights


@lru_cache(maxsize=64)
def _terms(k: bytes, factor: bytes) -> tuple[tuple[complex, complex], ...]:
    """Coefficients of v_f and v_f', for Horner's rule: from the highest wave number down to 0."""
    known = dict(zip(np.frombuffer(k).tolist(), np.frombuffer(factor, dtype=complex).tolist(), strict=True))
    return tuple((known.get(n, 0j), 1j * n * known.get(n, 0j)) for n in range(int(max(known)), -1, -1))


def _one_phase(waves: tuple[bytes, bytes], start: float, stop: float, level: float) -> float:
    """The phase on one arc where v_f equals one level: `_bracketed` and `_polished` in plain numbers."""
    nodes, heights = _nodes(*waves, start, stop)
    right = min(max(bisect_left(heights, level), 1), _NODES - 1)
    a, b, from_, to = (float(x) for x in (heights[right - 1], heights[right], nodes[right - 1], nodes[right]))
    theta = from_ + (to - from_) * ((level - a) / (b - a) if b > a else 0.5)
    for _ in range(100):
        turn, v, slope = cmath.exp(1j * theta), 0j, 0j
        for wave, rise in _terms(*waves):
            v, slope = v * turn + wave, slope * turn + rise
        off = v.real - level
        if off == 0.0:
            break
        if off < 0.0:  # heights rise from `from_` to `to`
            from_ = theta
        else:
            to = theta
        low, high = min(from_, to), max(from_, to)
        slack = 4.0 * _EPS * (1.0 + abs(theta))
        step = theta - off / slope.real if slope.real else math.inf
        inside = low - slack <= step <= high + slack
        new = step if inside else 0.5 * (low + high)
        moved, theta = abs(new - theta), new
        if moved <= (_LAST_STEP if inside else slack):
            break
    return theta


def _bracketed(level: Array, nodes: Array, heights: Array) -> tuple[Array, Array, Array]:
    """Two phases around each level, and a first guess between them; each of the shape of `level`."""
    right = np.clip(np.searchsorted(heights, level), 1, _NODES - 1)
    a, b, low, high = heights[right - 1], heights[right], nodes[right - 1], nodes[right]
    with np.errstate(divide="ignore", invalid="ignore"):
        start = low + (high - low) * np.where(b > a, (level - a) / (b - a), 0.5)
    return np.minimum(low, high), np.maximum(low, high), start
