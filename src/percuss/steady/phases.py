"""All phases at which the rigid velocity meets a level, and the proof that there are no others.

The critical points of v_f cut the circle into arcs on which v_f is monotone, so that each arc holds at most one root,
and holds one exactly when the level lies between the values at its ends. The critical points themselves are roots of a
sum of waves, found with proof (`percuss.steady.trigonometric`).
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.piecewise import PiecewiseResponse
from percuss.steady.trigonometric import (
    TURN,
    Curve,
    Terms,
    harmonic_sums,
    on_circle,
    polished,
    polished_one,
    trigonometric_roots,
)

__all__ = ["Arcs", "Response", "forced_response"]

_EPS = np.finfo(float).eps
_NODES = 129  # of the table that starts Newton's method on an arc
_FEW = 8  # phases, and harmonics, up to which plain numbers are faster than arrays

Response: TypeAlias = HarmonicResponse | PiecewiseResponse


@lru_cache(maxsize=32)
def forced_response(system: System) -> Response:
    """The forced response, exact for the load's own form: piecewise where that is known, else by harmonics.

    The last few are kept: every motion of a system, and whatever is asked of it, shares one.
    """
    return PiecewiseResponse(system) if system.load.is_piecewise else HarmonicResponse(system)


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

    @cached_property
    def turning(self) -> npt.NDArray[np.bool_]:
        """At which ends v_f turns round, so that two motions meet there; shape (n + 1,).

        All critical points count. At a break of a load of steps v_f has a kink, and may go on in its direction.
        """
        if not isinstance(self.response, PiecewiseResponse):
            return np.ones(self.ends.shape, dtype=bool)
        rise = np.where(self.response.flat, 0.0, np.sign(np.diff(self.velocities)))
        turning = np.roll(rise, 1) * rise < 0.0
        return np.append(turning, turning[0])

    def plateaus(self, level: float) -> npt.NDArray[np.intp]:
        """The arcs on which v_f stays at a level: every phase of theirs is a root."""
        if not isinstance(self.response, PiecewiseResponse):
            return np.empty(0, dtype=np.intp)
        return np.flatnonzero(self.response.flat & (np.abs(self.velocities[:-1] - level) <= self.tolerance))

    def folded(self, phase: Array, level: Array) -> npt.NDArray[np.bool_]:
        """Whether two motions meet in a root: the level touches an end of its arc, where v_f turns round."""
        arc = (np.searchsorted(self.ends[:-1], phase, side="right") - 1) % (self.ends.size - 1)
        folded = np.zeros(np.shape(phase), dtype=bool)
        for end in (arc, arc + 1):
            folded |= self.turning[end] & (np.abs(self.velocities[end] - level) <= self.tolerance)
        return folded

    def roots(self, level: float) -> tuple[Array, Array]:
        """All phases in [0, 2π) with v_f = level, increasing, and whether each is a tangency (fold).

        Of a plateau at the level the middle, as a fold.

        Returns
        -------
        phases, folds
            Equal shapes (n,).
        """
        off = self.velocities - level
        touching = np.abs(off) <= self.tolerance
        knots, folded = self.ends[:-1][touching[:-1]], self.turning[:-1][touching[:-1]]
        flat = self.plateaus(level)
        if flat.size:  # the breaks that bound it belong to it
            beside = np.isin(np.flatnonzero(touching[:-1]), np.concatenate([flat, (flat + 1) % (self.ends.size - 1)]))
            middles = 0.5 * (self.ends[flat] + self.ends[flat + 1])
            knots, folded = np.append(knots[~beside], middles), np.append(folded[~beside], np.ones(flat.size, bool))
        crossed = ((off[:-1] < 0.0) != (off[1:] < 0.0)) & ~touching[:-1] & ~touching[1:]
        index = np.flatnonzero(crossed)
        simple = self.invert(index, np.full(index.size, level)) if index.size > _FEW else self._one_by_one(index, level)
        phases = on_circle(np.concatenate([simple, knots]))
        tangent = np.concatenate([np.zeros(simple.size, bool), folded])
        order = np.argsort(phases)
        return phases[order], tangent[order]

    def phase_on(self, arc: int, level: float) -> float:
        """The phase on one arc where v_f equals one level: `invert` for plain numbers."""
        return float(self._one_by_one(np.array([arc]), level)[0])

    def _one_by_one(self, arc: npt.NDArray[np.intp], level: float) -> Array:
        """The phases of one level on a few arcs: `invert` in plain numbers, in a quarter of the time of arrays."""
        r = self.response
        if isinstance(r, PiecewiseResponse) or r.k.size == 1 or r.k[-1] > _FEW:
            return self.invert(arc, np.full(arc.size, level))
        waves = r.k.tobytes(), r.rigid_factor.tobytes()
        ends = [(float(self.ends[i]), float(self.ends[i + 1])) for i in arc.tolist()]
        return np.array([_one_phase(waves, start, stop, level) for start, stop in ends], dtype=float)

    def invert(self, arc: npt.NDArray[np.intp], level: Array) -> Array:
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
        low, high, start = np.empty(level.shape), np.empty(level.shape), np.empty(level.shape)
        for number in np.unique(arc):
            look()
            here, ends = arc == number, self.ends[number : number + 2]
            low[here], high[here], start[here] = _bracketed(level[here], *_nodes(*waves, *ends.tolist()))
        return polished(low, high, _waves(*waves), level, start)


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
