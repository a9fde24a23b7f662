"""The maps of the elastic modes through a cycle, with its times held, along a way beside a curve of orbits."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.explore.continuation.segment import Segment
from percuss.explore.continuation.solution_curve import CurvePoint
from percuss.model.checks import Array
from percuss.steady.oscillator import propagator

__all__ = ["ModeMaps", "mode_maps"]


class ModeMaps(NamedTuple):
    """M_n of every elastic mode along x(place) = x + place rate + place² bend.

    Parameters
    ----------
    x, rate, bend
        Of the times of the impacts, and whatever follows them; shape (m,) each.
    omega, damping
        Frequencies and damping at place 0; shape (N,) each.
    faster, duller
        How they change with the place.
    kept, turned
        What an impact makes of the strain and of the velocity of a mode: factors.
    period
        T.
    impacts
        p.
    """

    x: Array
    rate: Array
    bend: Array
    omega: Array
    damping: Array
    faster: Array
    duller: Array
    kept: float
    turned: float
    period: float
    impacts: int

    def beside(self, place: float, point: CurvePoint) -> ModeMaps:
        """The same along the tangent of a point of the curve at a place."""
        rate = point.tangent / float(self.rate @ point.tangent) * float(self.rate @ self.rate)
        return self._replace(x=point.x - place * rate, rate=rate, bend=np.zeros_like(rate))

    def turning(self, length: float) -> Array:
        """By how much the angles of the modes may change over so much of the way; shape (N,)."""
        p = self.impacts
        moved = 2.0 * np.abs(np.diff(length * self.rate[:p] + length**2 * self.bend[:p])).sum()
        beyond = self.omega + length * self.faster
        return np.asarray(np.abs(length * self.faster) * self.period + np.maximum(self.omega, beyond) * moved)

    def determinants(self, n: npt.NDArray[np.intp] | slice, places: Array) -> Array:
        """det(1 − M_n) and det(−1 − M_n) of some modes; shape (2, k, l) for places of the shape (k, l) or (l,)."""
        p, at = self.impacts, places[..., None]
        times = self.x[:p] + at * self.rate[:p] + at**2 * self.bend[:p]
        flights = np.concatenate([times[..., 1:], times[..., :1] + self.period], axis=-1) - times
        omega = self.omega[n, None] + places * self.faster[n, None]
        damping = self.damping[n, None] + places * self.duller[n, None]
        step = propagator(omega[..., None], damping[..., None], flights)
        a, b, c, e = (part[..., 0] for part in step[:4])
        a, b, c, e = self.kept * a, self.kept * b, self.turned * c, self.turned * e
        for i in range(1, p):
            sa, sb, sc, se = (part[..., i] for part in step[:4])
            a, c = self.kept * (sa * a + sb * c), self.turned * (sc * a + se * c)
            b, e = self.kept * (sa * b + sb * e), self.turned * (sc * b + se * e)
        trace, size = a + e, a * e - b * c
        return np.stack([1.0 - trace + size, 1.0 + trace + size])


def mode_maps(segment: Segment) -> ModeMaps | None:
    """Those along a segment; None without elastic modes, or where the other end has other ones."""
    curve, length = segment.curve, segment.length
    if not curve.modes or not length > 0.0:
        return None
    systems = [curve.system(curve.value(point.x)) for point in (segment.start, segment.stop)]
    first, last = (system.body.modes(curve.modes, system.load.at) for system in systems)
    omega, damping = np.asarray(first.omega), np.asarray(first.damping) + np.zeros(np.shape(first.omega))
    if not omega.size or np.shape(last.omega) != omega.shape:
        return None
    start, ahead, contact = segment.start.x, segment.start.tangent, systems[0].contact
    return ModeMaps(
        start, ahead, (segment.stop.x - start - length * ahead) / length**2,
        omega, damping, (np.asarray(last.omega) - omega) / length, (np.asarray(last.damping) - damping) / length,
        contact.strain_factor, contact.velocity_factor, 2.0 * math.pi * curve.periods, curve.impacts,
    )  # fmt: skip
