"""Where in a step an elastic mode comes back after a cycle almost by itself, and multipliers may change in a moment.

With M_n the map of mode n through a cycle at fixed times, K(ξ) has the poles det(ξ − M_n) = 0. A mode without much
damping brings det(1 − M_n) or det(−1 − M_n) near to 0 in narrow places, and the two flips or folds on both sides of
one leave no trace at the ends of a step. The maps depend on the flights and the frequencies alone, and tell the places
without any orbit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.explore.continuation.segment import Segment
from percuss.model.checks import Array
from percuss.steady.oscillator import propagator

__all__ = ["resonant_places"]

_FINE = 0.25  # rad, by which the fastest mode goes on from sample to sample
_FEWEST, _MOST = 9, 1025
_NEAR = 0.5  # of det(±1 − M_n), above which nothing is narrow
_PEAK = 17  # samples of each finer look at a least value
_LOOKS = 3
_PLACES = 12  # in a step, of the lowest modes and the deepest first


class _Modes(NamedTuple):
    """Frequencies and damping of some modes at both ends of a segment; each of the shape (n,)."""

    omega: Array
    damping: Array
    beyond: Array
    damped: Array

    def some(self, which: slice) -> _Modes:
        """Some of them."""
        return _Modes(*(values[which] for values in self))


def resonant_places(segment: Segment) -> list[float]:
    """The places inside a segment at which det(1 − M_n) or det(−1 − M_n) of a mode has a small least value."""
    modes = _modes(segment)
    samples = 0 if modes is None else _samples(segment, modes)
    if modes is None or not samples:
        return []
    places = np.linspace(0.0, segment.length, samples)
    found = []
    for n, which, i in _lowest(_determinants(segment, modes, places)):
        one, low, high = modes.some(slice(n, n + 1)), places[i - 1], places[i + 1]
        for _ in range(_LOOKS):
            closer = np.linspace(low, high, _PEAK)
            j = int(np.argmin(_determinants(segment, one, closer)[which, 0]))
            low, high = closer[max(j - 1, 0)], closer[min(j + 1, _PEAK - 1)]
        found.append(float(closer[j]))
    return sorted({place for place in found if 0.0 < place < segment.length})


def _lowest(values: Array) -> list[tuple[int, int, int]]:
    """Number of the mode from 0 on, 0 for ξ = 1 or 1 for ξ = −1, and number of the sample, of small least values."""
    inside = values[..., 1:-1]
    least = (inside <= values[..., :-2]) & (inside < values[..., 2:]) & (inside < _NEAR)
    which, modes, samples = np.nonzero(least)
    order = np.argsort(values[which, modes, samples + 1] * (modes + 1.0) ** 2, kind="stable")[:_PLACES]
    return [(int(modes[k]), int(which[k]), int(samples[k]) + 1) for k in order]


def _modes(segment: Segment) -> _Modes | None:
    """The elastic modes; None where there are none, or other ones at the other end."""
    curve, found = segment.curve, []
    if not curve.modes:
        return None
    for point in (segment.start, segment.stop):
        system = curve.system(curve.value(point.x))
        known = system.body.modes(curve.modes, system.load.at)
        found += [np.asarray(known.omega), np.asarray(known.damping)]
    return _Modes(*found) if found[0].shape == found[2].shape and found[0].size else None


def _samples(segment: Segment, modes: _Modes) -> int:
    """How many samples show every turn of every mode; 0 where none needs to be looked at."""
    period = 2.0 * math.pi * segment.curve.periods
    if not segment.length > 0.0 or np.all(modes.damping * period > 2.0 * math.log(1e3)):
        return 0
    p = segment.curve.impacts
    moved = 2.0 * np.abs(np.diff(segment.stop.x[:p] - segment.start.x[:p])).sum()
    turned = np.abs(modes.beyond - modes.omega) * period + np.maximum(modes.omega, modes.beyond) * moved
    return min(max(math.ceil(float(turned.max()) / _FINE) + 1, _FEWEST), _MOST)


def _determinants(segment: Segment, modes: _Modes, places: Array) -> Array:
    """det(1 − M_n) and det(−1 − M_n) of some modes at places of a segment; shape (2, n, len(places))."""
    curve, length = segment.curve, segment.length
    p, period = curve.impacts, 2.0 * math.pi * curve.periods
    share = (places / length)[:, None]
    bend = segment.stop.x - segment.start.x - length * segment.start.tangent
    x = segment.start.x + places[:, None] * segment.start.tangent + share**2 * bend
    flights = np.concatenate([x[:, 1:p], x[:, :1] + period], axis=1) - x[:, :p]
    omega = modes.omega + share * (modes.beyond - modes.omega)
    damping = modes.damping + share * (modes.damped - modes.damping)
    step = propagator(omega[:, None, :], damping[:, None, :], flights[..., None])
    contact = curve.system(curve.value(segment.start.x)).contact
    alpha, beta = contact.strain_factor, contact.velocity_factor
    a, b, c, e = np.ones_like(omega), np.zeros_like(omega), np.zeros_like(omega), np.ones_like(omega)
    for i in range(p):
        sa, sb, sc, se = (part[:, i, :] for part in step[:4])
        a, c = alpha * (sa * a + sb * c), beta * (sc * a + se * c)
        b, e = alpha * (sa * b + sb * e), beta * (sc * b + se * e)
    trace, size = a + e, a * e - b * c
    return np.stack([(1.0 - trace + size).T, (1.0 + trace + size).T])
