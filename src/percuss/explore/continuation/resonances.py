"""Where in a step an elastic mode comes back after a cycle almost by itself, and multipliers may change in a moment.

With M_n the map of mode n through a cycle at fixed times, K(ξ) has the poles det(ξ − M_n) = 0. A mode without much
damping brings det(1 − M_n) or det(−1 − M_n) near to 0 in narrow places, and the two flips or folds on both sides of
one leave no trace at the ends of a step. The maps depend on the flights and the frequencies alone, and tell the places
without any orbit.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.explore.continuation.segment import Segment
from percuss.model.checks import Array
from percuss.steady.oscillator import propagator

__all__ = ["resonant_places"]

_FINE = 0.25  # rad, by which the fastest mode goes on from sample to sample
_FEWEST, _MOST = 9, 2049
_NEAR = 0.5  # of det(±1 − M_n), above which nothing is narrow
_PEAK = 17  # samples of each finer look at a least value
_LOOKS = 3


def resonant_places(segment: Segment, first: float, last: float) -> list[float]:
    """The places between two of a segment at which det(1 − M_n) or det(−1 − M_n) of a mode has a small least value."""
    samples = _samples(segment, first, last)
    if samples is None:
        return []
    places = np.linspace(first, last, samples)
    found = []
    for n, i in zip(*_lowest(_determinants(segment, places)), strict=True):
        low, high = places[max(i - 1, 0)], places[min(i + 1, samples - 1)]
        for _ in range(_LOOKS):
            closer = np.linspace(low, high, _PEAK)
            j = int(np.argmin(_determinants(segment, closer)[n]))
            low, high = closer[max(j - 1, 0)], closer[min(j + 1, _PEAK - 1)]
        found.append(float(closer[j]))
    return sorted({place for place in found if first < place < last})


def _lowest(values: Array) -> tuple[list[int], list[int]]:
    """Rows and columns of the small least values inside the rows."""
    inside = values[:, 1:-1]
    least = (inside <= values[:, :-2]) & (inside < values[:, 2:]) & (inside < _NEAR)
    rows, columns = np.nonzero(least)
    return rows.tolist(), (columns + 1).tolist()


def _ends(segment: Segment) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Frequencies and damping of the elastic modes at both ends."""
    curve, found = segment.curve, []
    for point in (segment.start, segment.stop):
        system = curve.system(curve.value(point.x))
        known = system.body.modes(curve.modes, system.load.at)
        found.append((np.asarray(known.omega), np.asarray(known.damping)))
    return found[0], found[1]


def _samples(segment: Segment, first: float, last: float) -> int | None:
    """How many samples show every turn of every mode; None where none needs to be looked at."""
    if not first < last:  # of a walk that begins at a limit
        return None
    (omega, damping), (beyond, _) = _ends(segment)
    period = 2.0 * math.pi * segment.curve.periods
    if not omega.size or omega.shape != beyond.shape or np.all(damping * period > 2.0 * math.log(1e3)):
        return None
    p = segment.curve.impacts
    moved = np.abs(np.diff(segment.stop.x[:p] - segment.start.x[:p])).sum() * 2.0
    turned = float((np.abs(beyond - omega) * period + np.maximum(omega, beyond) * moved).max())
    share = (last - first) / segment.length
    return min(max(math.ceil(turned * share / _FINE) + 1, _FEWEST), _MOST)


def _determinants(segment: Segment, places: Array) -> Array:
    """det(1 − M_n) of all modes and then det(−1 − M_n), at places of a segment; shape (2N, len(places))."""
    curve, length = segment.curve, segment.length
    p, period = curve.impacts, 2.0 * math.pi * curve.periods
    share = (places / length)[:, None]
    ahead = segment.start.tangent
    bend = segment.stop.x - segment.start.x - length * ahead
    x = segment.start.x + places[:, None] * ahead + share**2 * bend
    flights = np.concatenate([x[:, 1:p], x[:, :1] + period], axis=1) - x[:, :p]
    (omega, damping), (beyond, damped) = _ends(segment)
    omega, damping = omega + share * (beyond - omega), damping + share * (damped - damping)
    step = propagator(omega[:, None, :], damping[:, None, :], flights[..., None])
    contact = curve.system(curve.value(segment.start.x)).contact
    alpha, beta = contact.strain_factor, contact.velocity_factor
    a, b, c, e = np.ones_like(omega), np.zeros_like(omega), np.zeros_like(omega), np.ones_like(omega)
    for i in range(p):
        sa, sb, sc, se = (part[:, i, :] for part in step[:4])
        a, c = alpha * (sa * a + sb * c), beta * (sc * a + se * c)
        b, e = alpha * (sa * b + sb * e), beta * (sc * b + se * e)
    trace, size = a + e, a * e - b * c
    return np.concatenate([(1.0 - trace + size).T, (1.0 + trace + size).T])
