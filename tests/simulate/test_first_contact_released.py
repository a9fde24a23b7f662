"""First contacts of bars that the load pulls off the wall, laid there within some ulps of where it begins to pull."""

import math

import mpmath
import numpy as np
import pytest

from interval_oracle import Flight, first_contact
from percuss.model import Load, System
from percuss.simulate import Start, Stop, run

mp = mpmath.MPContext()
mp.dps = 40


def released(coefficients, d, phase, after):
    """y and y' of a rigid bar `after` its release: its forced motion and the free one, in 40 digits."""
    p, d = [mp.mpc(complex(c)) for c in coefficients], mp.mpf(d)
    t0, t = mp.mpf(phase), mp.mpf(phase) + mp.mpf(after)
    shape = [p[k] / (1j * k * d - k * k) for k in range(1, len(p))]

    def forced(at):
        turns = [c * mp.exp(1j * (k + 1) * at) for k, c in enumerate(shape)]
        return mp.re(mp.fsum(turns)), mp.re(mp.fsum(1j * (k + 1) * c for k, c in enumerate(turns)))

    mean, gone = mp.re(p[0]), mp.mpf(after)
    first = -mp.expm1(-d * gone) / d if d else gone
    second = (gone - first) / d if d else gone * gone / 2
    (y0, v0), (y1, v1) = forced(t0), forced(t)
    return float(y1 - y0 - v0 * first + mean * second), float(v1 - v0 * (1 - d * first) + mean * first)


def onset(coefficients):
    """A phase at which a Fourier series turns from push to pull, rounded, or None; and how long it pulls at least."""
    k = np.arange(len(coefficients))

    def force(t):
        return float(np.real(np.exp(1j * k * t) @ coefficients))

    t = np.linspace(0.0, 2.0 * math.pi, 721)
    p = np.array([force(x) for x in t])
    falls = np.flatnonzero((p[:-1] > 0.0) & (p[1:] <= 0.0))
    if not falls.size or p[(falls[0] + 12) % 720] >= 0.0:
        return None
    low, high = (mp.mpf(float(t[falls[0]])), mp.mpf(float(t[falls[0] + 1])))
    exact = [mp.mpc(complex(c)) for c in coefficients]
    for _ in range(120):
        middle = (low + high) / 2
        value = mp.re(mp.fsum(c * mp.exp(1j * n * middle) for n, c in enumerate(exact)))
        low, high = (middle, high) if value > 0 else (low, middle)
    return float(low)


@pytest.mark.parametrize("starts", [40, pytest.param(600, marks=pytest.mark.slow)])
def test_released_within_ulps(starts):
    """The flight is that of a bar released where the load begins to pull, on whichever side the bar is laid down."""
    rng, seen = np.random.default_rng(872), 0
    while seen < starts:
        count = int(rng.integers(1, 4))
        parts = (rng.normal(size=count) + 1j * rng.normal(size=count)) / np.arange(1, count + 1)
        coefficients = np.array([float(rng.uniform(-1.0, 1.0)), *parts])
        d = 0.0 if rng.random() < 0.4 else float(10.0 ** rng.uniform(-3, 4))
        phase = onset(coefficients)
        if phase is None:
            continue
        y, v = released(coefficients, d, phase, 0.05)
        if not y < -1e-12:
            continue
        flight = Flight(1.0, d, tuple(map(complex, coefficients)), (), (), phase + 0.05, np.array([y]), np.array([v]))
        horizon = 60.0
        true = first_contact(flight, horizon)
        system, stop = System(1.0, d, 0.7, Load.fourier(coefficients)), Stop(impacts=1, time=horizon, periodic=False)
        seen += 1
        for ulps in (0, *(int(k) for k in rng.integers(-12, 13, 4))):
            motion = run(system, Start.rigid(0.0, 0.0, phase + ulps * np.spacing(phase)), modes=0, stop=stop)
            struck = motion.events.of("impact")
            where = f"{coefficients}, d = {d}, {ulps} ulps: {true}, {motion.events.kind} at {motion.events.time}"
            if true.kind == "contact":
                assert len(struck) == 1, where
                error = 1e-9 if true.speed < 1e-6 else 1e-11 / true.speed
                assert abs(struck.time[0] - (phase + 0.05 + true.time)) < 1e-12 + error, where
            elif true.kind == "none":
                assert len(struck) == 0 or struck.time[0] > phase + horizon - 0.1, where
