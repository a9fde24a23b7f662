"""All phases at which the rigid velocity meets a level, and the proof that there are no others.

The critical points of v_f cut the circle into arcs on which v_f is monotone, so that each arc holds at most one root,
and holds one exactly when the level lies between the values at its ends. The critical points themselves are roots of a
sum of waves, found with proof (`percuss.steady.trigonometric`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.piecewise import PiecewiseResponse
from percuss.steady.response import Response
from percuss.steady.trigonometric import TURN, on_circle

__all__ = ["Arcs", "Response", "forced_response"]

_EPS = np.finfo(float).eps


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
        ends = response.ends
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
        return self.response.turning(self.velocities)

    def plateaus(self, level: float) -> npt.NDArray[np.intp]:
        """The arcs on which v_f stays at a level: every phase of theirs is a root."""
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
        simple = self._few(index, np.full(index.size, level))
        phases = on_circle(np.concatenate([simple, knots]))
        tangent = np.concatenate([np.zeros(simple.size, bool), folded])
        order = np.argsort(phases)
        return phases[order], tangent[order]

    def phase_on(self, arc: int, level: float) -> float:
        """The phase on one arc where v_f equals one level: `invert` for plain numbers."""
        return float(self._few(np.array([arc]), np.array([level]))[0])

    def _few(self, arc: npt.NDArray[np.intp], level: Array) -> Array:
        return self.response.phases_at(self.ends, self.velocities, arc, level, plain=True)

    def invert(self, arc: npt.NDArray[np.intp], level: Array) -> Array:
        """The phase on arc number `arc` where v_f equals `level`, which must lie between its ends; broadcasts."""
        return self.response.phases_at(self.ends, self.velocities, arc, level)
