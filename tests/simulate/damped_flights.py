"""Flights in the regions where increments, noise and bounds are hardest, and how well rounding lets a gap be known.

Overdamped modes, modes at critical damping, damping up to 1e6, flights of up to 1e6 radians, bars that leave the wall
strained and slowly. Nothing here is shared with the package.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import flint
import numpy as np
from numpy.typing import NDArray

from interval_oracle import Flight, _stretches, gap

__all__ = ["REGIONS", "Sums", "damped_flight"]

Floats = NDArray[np.float64]

REGIONS = ("overdamped", "critical", "stiff", "crawling", "strained", "touching")
_MODES = (0, 1, 1, 2, 3, 5, 8, 16)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _load(rng: np.random.Generator, steps: float) -> tuple[tuple[complex, ...], tuple[float, ...], tuple[float, ...]]:
    """Fourier coefficients, or breaks and values; mostly with a mean that pushes."""
    push = _log(rng, 0.05, 2.0) * (1.0 if rng.random() < 0.9 else -1.0)
    if rng.random() < steps:
        pieces = int(rng.integers(2, 6))
        breaks = tuple(sorted(float(x) for x in rng.uniform(0, 2 * math.pi, pieces)))
        return (), breaks, tuple(push + float(x) for x in rng.normal(0, 1, pieces))
    harmonics = int(rng.integers(0, 5))
    raw = (rng.normal(size=harmonics) + 1j * rng.normal(size=harmonics)) / np.arange(1, harmonics + 1)
    return (complex(push), *(complex(x) for x in raw)), (), ()


def _mean(flight: Flight) -> float:
    """Of the load; of steps the mean over a period."""
    if flight.coefficients:
        return flight.coefficients[0].real
    lengths = np.diff([*flight.breaks, flight.breaks[0] + 2 * math.pi])
    return float(lengths @ flight.values) / (2 * math.pi)


def damped_flight(rng: np.random.Generator, region: str) -> tuple[Flight, float, bool]:
    """A flight of a region, its horizon, and whether it starts on the wall."""
    if region == "touching":
        return _touching(rng)
    count = int(rng.choice(_MODES[1:]))
    s, time, horizon = _log(rng, 0.005, 3.0), float(rng.uniform(0, 2 * math.pi)), _log(rng, 3.0, 30.0)
    n = int(rng.integers(1, count + 1))
    if region == "critical":
        off = 10.0 ** rng.uniform(-16, -1) * (1.0 if rng.random() < 0.5 else -1.0)
        d = 2.0 * n * math.pi * s * (1.0 + off)
    elif region == "stiff":
        s, d = _log(rng, 0.01, 100.0), _log(rng, 10.0, 1e6)
    elif region == "crawling":
        count, s, d = int(rng.choice([0, 0, 0, 1, 2])), _log(rng, 0.1, 10.0), _log(rng, 1.0, 1e4)
        horizon = _log(rng, 1e2, 3e4 if rng.random() < 0.95 else 1e6)
    else:
        d = 2.0 * n * math.pi * s * _log(rng, 1.0, 100.0)
    coefficients, breaks, values = _load(rng, 0.0 if region == "crawling" else 0.25)
    order = np.arange(1, count + 1)
    sign = np.where(order % 2 == 0, 2.0, -2.0)
    depart = _log(rng, 1e-3, 5.0)
    size = _log(rng, 1e-3, 3.0) * depart * rng.normal(size=(2, count)) / order**2
    u, v = size[0], size[1]
    if rng.random() < 0.4:
        u, v = 0.0 * u, 0.0 * v
    flight = Flight(s, d, coefficients, breaks, values, time, np.append(0.0, u), np.append(0.0, v))
    on_wall = region == "strained" or (region != "crawling" and rng.random() < 0.5)
    speed = depart * float(rng.uniform(-1, 1))
    rigid = -float(sign @ u)
    if on_wall:
        leave = _log(rng, 1e-9, 1e-2) if region == "strained" else depart
        if region == "strained":
            v = 0.0 * v if rng.random() < 0.5 else v
        speed = -leave - float(sign @ v)
    elif region in ("stiff", "crawling"):
        away = _mean(flight) * (horizon * float(rng.uniform(0.05, 1.1))) / d
        rigid -= max(abs(away), 1e-12) + (max(speed, 0.0) / d if rng.random() < 0.5 else 0.0)
    else:
        rigid -= _log(rng, 1e-6, 1.0)
    return replace(flight, displacement=np.append(rigid, u), velocity=np.append(speed, v)), horizon, on_wall


def _touching(rng: np.random.Generator) -> tuple[Flight, float, bool]:
    """A flight of another region away from the wall, moved so that a summit of its gap comes very near the wall."""
    bits, flint.ctx.prec = flint.ctx.prec, 128
    try:
        while True:
            flight, horizon, on_wall = damped_flight(rng, str(rng.choice(["overdamped", "critical", "stiff"])))
            summit = None if on_wall else _summit(rng, flight, horizon)
            if summit is None:
                continue
            distance = _log(rng, 1e-13, 1e-3) * (1.0 if rng.random() < 0.5 else -1.0)
            moved = flight.displacement.copy()
            moved[0] += distance - summit
            if gap(replace(flight, displacement=moved), 0.0)[0] < -1e-9:
                return replace(flight, displacement=moved), horizon, False
    finally:
        flint.ctx.prec = bits


def _summit(rng: np.random.Generator, flight: Flight, horizon: float) -> float | None:
    """The height of a summit of the gap that nothing before it reaches."""
    _, length, stretch = next(iter(_stretches(flight, horizon, False)))
    t = np.sort(np.concatenate([np.linspace(1e-3, 1.0, 30), np.geomspace(1e-6, 1.0, 30)])) * length
    y = np.array([float(stretch.at(flint.arb(float(x)))[0]) for x in t])
    tops = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:])) + 1
    tops = tops[y[tops] >= np.maximum.accumulate(y)[tops]]
    if not tops.size:
        return None
    at = float(t[int(rng.choice(tops))])
    for _ in range(12):
        value, rate, curve = (float(x) for x in stretch.at(flint.arb(at)))
        if not curve < 0.0:
            return None
        at -= rate / curve
    return value if 0.0 < at < length and abs(rate) < 1e-9 * (1.0 + abs(curve)) else None


@dataclass(frozen=True)
class Sums:
    """Sums of the absolute values of what makes up a gap at some time of a flight, in increments since its start.

    The rounding error of a gap is a few eps times `place`, that of its rate a few eps times `rate`. Written down from
    the closed form of the motion (theory §2), each part with a bound of its own: h is the answer of a mode to a unit
    push, at most min(t, 1/d, 1/λ), and of g = 1 − (what is left of a displacement) it is at most min(2, ω² t²/2).
    """

    place: float
    rate: float

    @classmethod
    def of(cls, flight: Flight, time: float, on_wall: bool) -> Sums:
        omega = math.pi * flight.s * np.arange(1, len(flight.displacement))
        d, t = flight.d, time
        lasting = 1.0 / d if d > 0.0 else math.inf  # of the drift
        u, v = 2.0 * np.abs(flight.displacement[1:]), 2.0 * np.abs(flight.velocity[1:])
        k = np.arange(1, len(flight.coefficients))
        pk = np.abs(np.asarray(flight.coefficients[1:], dtype=complex))
        rigid = pk / np.abs(1j * k * d - k**2) if k.size else np.zeros(0)
        answer = 2.0 * pk[:, None] / np.abs(omega**2 - k[:, None] ** 2 + 1j * k[:, None] * d)
        push = abs(flight.coefficients[0]) if flight.coefficients else max(map(abs, flight.values))
        still = 2.0 * push / omega**2
        q0 = u + answer.sum(axis=0) + still  # at most: of the free motion, as are
        q1 = v + (k @ answer if k.size else 0.0)
        drift = abs(flight.velocity[0]) + float(k @ rigid)
        lam = np.sqrt(np.abs(omega**2 - 0.25 * d * d))
        # modes kept as amplitude and phase: these hold (q' + d q/2)/λ, and the phase counts as long as they last
        turning = 0.95 * omega > 0.5 * d
        q1 = np.where(turning, (q1 + 0.5 * d * q0) * omega / np.maximum(lam, 1e-300), q1)
        h = np.minimum(t, np.minimum(2.0 * lasting, np.where(turning, 1.0 / np.maximum(lam, 1e-300), math.inf)))
        g = np.minimum(2.0, 0.5 * (omega * t) ** 2)
        spun = np.where(turning, omega * min(t, 2.0 * lasting), 0.0)
        oscillating = float(k @ (rigid + answer.sum(axis=1))) if k.size else 0.0
        place = 0.0 if on_wall else float(abs(flight.displacement[0]) + u.sum())
        place += drift * min(t, lasting) + push * min(0.5 * t * t, t * lasting) + oscillating * min(t, 2.0)
        place += float(q1 @ h + q0 @ g + (q0 + q1 * h) @ (spun * np.minimum(1.0, omega * t)))
        fast = np.minimum(omega, omega**2 * lasting) if d > 0.0 else omega
        rate = drift + push * min(t, lasting) + oscillating + float(q1.sum() + q0 @ (fast * (1.0 + spun)))
        return cls(place, rate)
