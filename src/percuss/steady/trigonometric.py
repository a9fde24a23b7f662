"""Sums of waves Re Σ c_k exp(ikθ): their values, all their real roots with proof, and Newton's method in a bracket.

The roots are found by subdivision with a curvature bound: a cell is dropped only when Taylor's theorem proves that it
holds no root, and accepted only when it proves that it holds at most one.
"""

from __future__ import annotations

import cmath
import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.halting import check_interrupted
from percuss.model.checks import Array, ComplexArray

TURN = 2.0 * math.pi
_EPS = np.finfo(float).eps
_LAST_STEP = 1e-8
_LEVELS = 26  # of bisection: a multiple root is then taken as one point

Curve: TypeAlias = Callable[[Array], tuple[Array, Array]]
Terms: TypeAlias = Sequence[tuple[complex, complex]]


def trigonometric_roots(k: Array, coefficients: ComplexArray) -> Array:
    """All real roots in [0, 2π) of g(θ) = Re Σ c_k exp(ikθ), increasing; wave numbers k ≥ 0."""
    # A root of even order may be given once, twice or not at all; all others are found, each once.
    curvature = float(np.sum(k**2 * np.abs(coefficients)))
    if curvature < np.finfo(float).tiny / _EPS:
        return np.empty(0)  # a constant, or nothing above the smallest numbers
    noise = 8.0 * _EPS * float(np.sum((1.0 + k) * np.abs(coefficients)))

    def value(theta: Array) -> tuple[Array, Array]:
        g, slope = harmonic_sums(np.mod(theta, TURN), k, coefficients, 1j * k * coefficients)
        return g, slope

    return np.sort(on_circle(bounded_roots(value, TURN, max(32, 8 * int(k.max(initial=1.0))), curvature, noise)[0]))


def bounded_roots(value: Curve, length: float, count: int, curvature: float, noise: float) -> tuple[Array, Array]:
    """All roots of a curve in [0, length) at which it changes its sign, and where it may touch 0 without."""
    # `value` gives the curve and its slope, `curvature` bounds the second derivative and `noise` the rounding; `count`
    # cells are looked at first.
    cells = np.arange(count)  # cell j of the level's count reaches from edge j to edge j + 1
    kept: list[npt.NDArray[np.int64]] = []  # low and high edges in units of the finest grid, and whether narrowest
    for level in range(_LEVELS + 1):
        check_interrupted()
        half = 0.5 * length / count
        g, slope = value(np.asarray(half * (2.0 * cells + 1.0), dtype=float))
        empty = np.abs(g) > np.abs(slope) * half + 0.5 * curvature * half**2 + noise
        monotone = ~empty & (np.abs(slope) > curvature * half + noise)
        held = cells[~empty if level == _LEVELS else monotone]
        narrowest = np.isin(held, cells[~monotone])
        kept.append(np.stack([held << (_LEVELS - level), (held + 1) << (_LEVELS - level), narrowest]))
        left = cells[~empty & ~monotone]
        cells, count = np.concatenate([2 * left, 2 * left + 1]), 2 * count
        if not cells.size:
            break
    finest = (count >> (level + 1)) << _LEVELS
    low, high, narrow = np.concatenate(kept, axis=1)
    # every edge is looked at once, so that a root on an edge belongs to one of its two cells and not to both or none
    edges, where = np.unique(np.concatenate([low, high]), return_inverse=True)
    below = (value(length * edges / finest)[0] < 0.0)[where]
    crossed = below[: low.size] != below[low.size :]
    starts, stops = length * low[crossed] / finest, length * high[crossed] / finest
    touched = ~crossed & (narrow == 1)
    return polished(starts, stops, value, np.zeros(starts.size)), 0.5 * length * (low + high)[touched] / finest


def on_circle(theta: Array) -> Array:
    """The phases in [0, 2π); a rounding below 0 becomes 0 and not 2π."""
    phases = np.mod(theta, TURN)
    return np.asarray(np.where(phases >= TURN, 0.0, phases))


def harmonic_sums(theta: Array, k: Array, *coefficients: ComplexArray) -> list[Array]:
    """Re Σ c_k exp(ikθ) for several sets of coefficients at once, by Horner's rule in exp(iθ); `k` increases."""
    turn = np.exp(1j * np.asarray(theta, dtype=float))
    totals = [np.zeros_like(turn) for _ in coefficients]
    turned = np.empty_like(turn)  # not in place: numpy rounds the product of a single number with itself otherwise
    dense = np.zeros((len(coefficients), int(k.max(initial=0.0)) + 1), dtype=complex)
    dense[:, k.astype(int)] = coefficients
    for column in dense.T[::-1]:
        for total, coefficient in zip(totals, column, strict=True):
            np.multiply(total, turn, out=turned)
            np.add(turned, coefficient, out=total)
    return [total.real for total in totals]


def polished(low: Array, high: Array, value: Curve, level: Array, start: Array | None = None) -> Array:
    """Newton's method kept inside brackets [low, high] on which `value` is monotone; equal shapes (n,)."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    theta = 0.5 * (low + high) if start is None else np.array(start, dtype=float)
    if not low.size:
        return theta
    below = value(low)[0] < level
    active = np.arange(low.size)
    for _ in range(100):
        check_interrupted()
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


def polished_one(terms: Terms, level: float, from_: float, to: float, theta: float) -> float:
    """One root as `polished` finds it, in plain numbers, between `from_` below the level and `to`; highest k first."""
    for _ in range(100):
        turn, v, slope = cmath.exp(1j * theta), 0j, 0j
        for wave, rise in terms:
            v, slope = v * turn + wave, slope * turn + rise
        off = v.real - level
        if off == 0.0:
            break
        if off < 0.0:  # the sum rises from `from_` to `to`
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


# ---- Where a sum of waves turns round, and where on an arc between two such phases it meets a level
#
# What is found depends on the alternating load and on the drag alone, so that a change of R, of the bar or of the mean
# load finds it made already.

_NODES = 129  # of the table that starts Newton's method on an arc
_FEW = 8  # phases, and harmonics, up to which plain numbers are faster than arrays


def turns_of_waves(k: Array, factor: ComplexArray) -> Array:
    """The phases in [0, 2π) where Re Σ c_k exp(ikθ) turns round, increasing."""
    if k.size == 1:
        number = int(k[0])
        return np.sort(on_circle((np.pi * np.arange(2 * number) - np.angle(factor[0])) / number))
    return _critical_phases(k.tobytes(), factor.tobytes())


def phases_of_waves(
    k: Array,
    factor: ComplexArray,
    ends: Array,
    heights: Array,
    arc: npt.NDArray[np.intp],
    level: Array,
    plain: bool = False,
) -> Array:
    """The phase on arc number `arc`, between two of the `ends`, where Re Σ c_k exp(ikθ) equals `level`; broadcasts."""
    # The level lies between the heights at the ends of its arc; the first end comes again a turn later. `plain`: a few
    # of them may be found in plain numbers, a quarter of the time of arrays. Rows of a map may not: the bits would
    # depend on how the map is parted.
    if k.size == 1:  # V cos k(θ − θ_0): arccos from the extreme where the arc starts
        from_top = np.clip(level / heights[arc], -1.0, 1.0)
        return np.asarray(ends[arc] + np.arccos(from_top) / k[0])
    waves = k.tobytes(), factor.tobytes()
    if plain and level.ndim == 1 and level.size <= _FEW and k[-1] <= _FEW:
        each = zip(arc.tolist(), level.tolist(), strict=True)
        return np.array([_one_phase(waves, float(ends[i]), float(ends[i + 1]), at) for i, at in each], dtype=float)
    low, high, start = np.empty(level.shape), np.empty(level.shape), np.empty(level.shape)
    for number in np.unique(arc):
        check_interrupted()
        here, between = arc == number, ends[number : number + 2]
        low[here], high[here], start[here] = _bracketed(level[here], *_nodes(*waves, *between.tolist()))
    return polished(low, high, _waves(*waves), level, start)


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
    unit = velocity / np.abs(velocity).max()  # of any size: below the smallest numbers no proof would count
    roots = trigonometric_roots(numbers, 1j * numbers * unit)
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
def _terms(k: bytes, factor: bytes) -> Terms:
    """Coefficients of v_f and v_f', for Horner's rule: from the highest wave number down to 0."""
    known = dict(zip(np.frombuffer(k).tolist(), np.frombuffer(factor, dtype=complex).tolist(), strict=True))
    return tuple((known.get(n, 0j), 1j * n * known.get(n, 0j)) for n in range(int(max(known)), -1, -1))


def _one_phase(waves: tuple[bytes, bytes], start: float, stop: float, level: float) -> float:
    """The phase on one arc where v_f equals one level."""
    nodes, heights = _nodes(*waves, start, stop)
    right = min(max(bisect_left(heights, level), 1), _NODES - 1)
    a, b, from_, to = (float(x) for x in (heights[right - 1], heights[right], nodes[right - 1], nodes[right]))
    guess = from_ + (to - from_) * ((level - a) / (b - a) if b > a else 0.5)
    return polished_one(_terms(*waves), level, from_, to, guess)


def _bracketed(level: Array, nodes: Array, heights: Array) -> tuple[Array, Array, Array]:
    """Two phases around each level, and a first guess between them; each of the shape of `level`."""
    right = np.clip(np.searchsorted(heights, level), 1, _NODES - 1)
    a, b, low, high = heights[right - 1], heights[right], nodes[right - 1], nodes[right]
    with np.errstate(divide="ignore", invalid="ignore"):
        start = low + (high - low) * np.where(b > a, (level - a) / (b - a), 0.5)
    return np.minimum(low, high), np.maximum(low, high), start
