"""Where a sum of waves turns round, and where on an arc between two such phases it meets a level.

What is found depends on the alternating load and on the drag alone, so that a change of R, of the bar or of the mean
load finds it made already.
"""

from __future__ import annotations

from bisect import bisect_left
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model.checks import Array, ComplexArray
from percuss.steady.trigonometric import (
    Curve,
    Terms,
    harmonic_sums,
    on_circle,
    polished,
    polished_one,
    trigonometric_roots,
)

__all__ = ["phases_of_waves", "turns_of_waves"]

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
    """The phase on arc number `arc`, between two of the `ends`, where Re Σ c_k exp(ikθ) equals `level`.

    Parameters
    ----------
    ends, heights
        Phases where the sum turns round, the first one again a turn later, and the sum there.
    arc, level
        Equal shapes, or they broadcast; the level lies between the heights at the ends of its arc.
    plain
        Whether a few of them may be found in plain numbers, a quarter of the time of arrays. Rows of a map may not: the
        bits would depend on how the map is parted.
    """
    if k.size == 1:  # V cos k(θ − θ_0): arccos from the extreme where the arc starts
        from_top = np.clip(level / heights[arc], -1.0, 1.0)
        return np.asarray(ends[arc] + np.arccos(from_top) / k[0])
    waves = k.tobytes(), factor.tobytes()
    if plain and level.ndim == 1 and level.size <= _FEW and k[-1] <= _FEW:
        each = zip(arc.tolist(), level.tolist(), strict=True)
        return np.array([_one_phase(waves, float(ends[i]), float(ends[i + 1]), at) for i, at in each], dtype=float)
    low, high, start = np.empty(level.shape), np.empty(level.shape), np.empty(level.shape)
    for number in np.unique(arc):
        look()
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
