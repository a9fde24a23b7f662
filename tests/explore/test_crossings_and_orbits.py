"""What the boundaries call a flip or a Neimark–Sacker crossing, by the multipliers of orbits, which share no code."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, stability_of, steady_states
from percuss.explore import boundaries, vary
from percuss.steady import Orbit, PeriodicOrbit, Reason

N = 8


def as_orbit(motion: Orbit) -> PeriodicOrbit:
    """A steady motion told as an orbit with one impact."""
    return PeriodicOrbit(motion.system, motion.periods, (motion.phase,), N)


def pulled(s: float, d: float, r: float, load_factor: float = 0.9) -> System:
    return System(s=s, d=d, restitution=r, load=Load.harmonic(load_factor, 1.0))


@pytest.mark.parametrize(
    ("s", "r", "m"), [(5.0, 0.8, 2), (1.05, 0.58, 2), (0.71, 0.66, 2), (3.1, 0.52, 2), (2.0, 0.5, 1)]
)
def test_a_crossing_is_what_it_is_called(s: float, r: float, m: int) -> None:
    found = boundaries(pulled(s, 0.0, r), ("s", [s]), ("load_factor", 0.2, 1.3), m, "exact", modes=N,
                       kinds=("flip", "neimark-sacker"))  # fmt: skip
    assert found.curves
    for curve in found.curves:
        there = vary(pulled(s, 0.0, r), {"load_factor": float(curve.y[0])})
        orbit = PeriodicOrbit(there, m, (float(curve.phase[0]),), N)
        values = orbit.multipliers().values
        angle = float(curve.angle[0])
        turning = values[np.abs(values.imag) > 1e-6]
        if curve.kind == "flip":
            assert np.abs(values + 1.0).min() < 1e-8
        else:
            assert np.abs(turning - np.exp(1j * angle)).min() < 1e-8
        scale = np.prod(1.0 + np.abs(values))
        assert abs(orbit.characteristic(complex(np.exp(1j * angle)))) < 1e-10 * scale
        outside = np.count_nonzero(np.abs(values) > 1.0 + 1e-7)
        assert outside == curve.outside[0]


def test_an_elastic_mode_alone_leaves_by_a_flip() -> None:
    """ξ = −1.000147 at d = 0, and a damping of 2.338e-5 brings it back."""
    motion = steady_states(pulled(5.0, 0.0, 0.8), 2, modes=N).orbits[-1]
    verdict = stability_of(motion, modes=N)
    assert verdict.kind is Reason.ELASTIC
    assert "turns over and grows by a factor of 1.000147" in verdict.reason
    first = as_orbit(motion).multipliers().values[0]
    assert first == pytest.approx(-1.000147, abs=1e-6)
    for d, sign in ((2.337e-5, 1), (2.339e-5, -1)):
        damped = steady_states(pulled(5.0, d, 0.8), 2, modes=N).orbits[-1]
        values = as_orbit(damped).multipliers()
        assert math.copysign(1.0, values.largest - 1.0) == sign
        assert values.values[0].imag == 0.0


def test_what_b77_cannot_see_are_flips_of_elastic_modes() -> None:
    """Undamped, under one harmonic: motions that B77's criterion calls stable and an elastic mode makes unstable."""
    random, flips, pairs = np.random.default_rng(5), 0, 0
    for _ in range(300):
        s, r = float(10.0 ** random.uniform(-0.2, 1.3)), float(random.uniform(0.2, 0.97))
        system, m = pulled(s, 0.0, r, float(random.uniform(0.2, 1.3))), int(random.integers(1, 4))
        for motion in steady_states(system, m, modes=N).orbits:
            if stability_of(motion, modes=N).kind is Reason.ELASTIC:
                values = as_orbit(motion).multipliers().values
                outside = values[np.abs(values) > 1.0 + 1e-10]
                assert outside.size
                real = bool(np.all(np.abs(outside.imag) < 1e-6))
                flips, pairs = flips + (real and bool(np.all(outside.real < 0.0))), pairs + (not real)
    assert flips > 3
    assert pairs <= 0.2 * flips
