"""The map from blow to blow of a rigid bar whose blows take time, by quadrature of the load; no code of the package."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from percuss import Load

_X, _W = np.polynomial.legendre.leggauss(16)


class Blow(NamedTuple):
    """The numbers of a law: restitution, duration, centroid of the force, advance per impulse."""

    r: float
    duration: float
    centroid: float
    advance: float


def flight(load: Load, d: float, start: float, velocity: float, until: float) -> tuple[float, float]:
    """Displacement and velocity at `until` of x'' + d x' = p from x = 0 and `velocity` at `start`."""
    cuts = [start, until, *np.linspace(start, until, 24)]
    for turn in range(math.floor(start / math.tau) - 1, math.ceil(until / math.tau) + 1):
        cuts += [b + math.tau * turn for b in load.breaks if start < b + math.tau * turn < until]
    edges = np.unique(cuts)
    half, middle = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    times = (middle[:, None] + half[:, None] * _X).ravel()
    weights = (half[:, None] * _W).ravel() * load.value(times)
    left = until - times
    if d * (until - start) < 1e-6:  # first order is enough for the digits that are compared
        moved, kept = left - 0.5 * d * left**2, 1.0 - d * left
    else:
        moved, kept = -np.expm1(-d * left) / d, np.exp(-d * left)
    whole = until - start
    along = whole if d == 0.0 else -math.expm1(-d * whole) / d
    return velocity * along + float(weights @ moved), velocity * math.exp(-d * whole) + float(weights @ kept)


def after(load: Load, blow: Blow, d: float, periods: int, time: float, velocity: float) -> tuple[float, float]:
    """Time and mean velocity at the next blow's centroid."""
    force = float(load.value(time))
    dragged = 1.0 + 0.25 * (1.0 + blow.r) * d * blow.centroid
    impulse = (1.0 + blow.r) * dragged * (velocity - (2.0 * blow.centroid - blow.duration) * force)
    at_contact = velocity - force * blow.centroid

    def off(later: float) -> float:
        moved, arrival = flight(load, d, time, velocity - impulse, later)
        begun = arrival - float(load.value(later)) * blow.centroid
        return moved - blow.advance * impulse - blow.centroid * (begun - at_contact)

    middle, width = time + math.tau * periods, 0.05 * periods
    later = brentq(off, middle - width, middle + width, xtol=1e-14, rtol=1e-15)
    return later, flight(load, d, time, velocity - impulse, later)[1]
