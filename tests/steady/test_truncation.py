"""What the modes left out can amount to without damping, against plain sums over very many modes."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, steady_states
from percuss.steady import Orbit
from percuss.steady.oscillator import cubic_sum

SPEEDS = [20.0, 3.3, 50.0, 0.7, 20.0000012958591, 7.0000007 / math.pi, 2.5 / math.pi * (1 + 1e-6), 22.0 / 7.0]


def factor(s: float, periods: int, n: int) -> float:
    """1/(2‖nπsm‖) in 40 digits."""
    with mpmath.workdps(40):
        turns = mpmath.pi * mpmath.mpf(s) * periods * n
        return float(1 / (2 * abs(turns - mpmath.nint(turns))))


def lost(orbit: Orbit, most: int) -> float:
    """The greatest position at sampled times, relative to the stroke, that the modes after those kept give.

    z_n = −f_n' sin(λT)/(ω(1 − cos λT)) (1 + R)/(1 − R), z_n' = −f_n' (1 + R)/(1 − R), with angles in 40 digits where
    they are nearly whole turns.
    """
    system = orbit.system
    n = np.arange(orbit.modes + 1, most + 1)
    omega, (k, p) = n * math.pi * system.s, (1, complex(system.load.coefficients[1]))
    velocity = (1j * k * p * np.exp(1j * orbit.phase)).real / (omega**2 - k**2)
    turns = n * math.pi * system.s * orbit.periods
    cotangent = 1.0 / np.tan(math.pi * (turns - np.rint(turns)))
    for i in np.argsort(-np.abs(cotangent))[:50]:
        with mpmath.workdps(40):
            exact = mpmath.cot(mpmath.pi * mpmath.pi * mpmath.mpf(system.s) * orbit.periods * int(n[i]))
        cotangent[i] = float(exact)
    full = (1.0 + system.restitution) / (1.0 - system.restitution)
    sign = np.where(n % 2, -2.0, 2.0)
    z, rate = -full * velocity * cotangent / omega * sign, -full * velocity / omega * sign
    wave, greatest = z - 1j * rate, 0.0
    step = np.exp(1j * omega * (orbit.period * (math.sqrt(5.0) - 1.0) / 2.0))  # its multiples fill a period evenly
    for _ in range(200):
        wave *= step
        greatest = max(greatest, abs(float((wave.sum() - z.sum()).real)))
    return greatest / orbit.rigid_stroke


@pytest.mark.parametrize("s", SPEEDS)
@pytest.mark.parametrize("restitution", [0.6, 0.99])
def test_the_bound_without_damping_is_one(s: float, restitution: float) -> None:
    load = Load.harmonic(0.5 if s == 20.0000012958591 else 0.1, 1.0)
    for orbit in steady_states(System(s, 0.0, restitution, load)).orbits:
        assert lost(orbit, 150_000) <= orbit.error_bound
        assert orbit.error_bound <= 1e-10 or orbit.warnings
        assert orbit.error_bound < 1e-6


def test_a_resonance_far_beyond_the_probe_is_counted() -> None:
    """Mode 7000 swings a whole number of times but for 1e-9: it is neither missed nor taken as exactly resonant."""
    for orbit in steady_states(System(20.0000012958591, 0.0, 0.99, Load.harmonic(0.5, 1.0))).orbits:
        assert orbit.modes >= 7000
        state = orbit.modal_state(7000)
        share = 2.0 * float(state.amplitude[6999]) / orbit.rigid_stroke
        gain = 199.0 * abs(float(state.forced_velocity[6999])) / float(state.omega[6999]) * 2.0 / orbit.rigid_stroke
        assert share == pytest.approx(gain * factor(20.0000012958591, 1, 7000) * 2.0 / math.pi, rel=0.15)


@settings(max_examples=30)
@given(st.sampled_from(SPEEDS) | st.floats(0.3, 100.0), st.integers(1, 5), st.integers(1, 3000))
def test_sums_over_small_divisors(s: float, periods: int, start: int) -> None:
    n = np.arange(start + 1, 60_000)
    with mpmath.workdps(80):  # in whole numbers: with s m near a multiple of 1/π all of them are near resonance
        turn, whole = 2**200, int(mpmath.pi * mpmath.mpf(s) * periods * 2**200)
    off = np.array([min(left, turn - left) / turn for left in (k * whole % turn for k in n.tolist())])
    terms = n**-3.0 * (1.0 + 0.5 / off)
    plain = float(terms.sum())
    bound = cubic_sum(s, periods, start)
    assert plain <= bound * (1.0 + 1e-6)
    assert bound <= 100.0 * plain + 100.0 / 60_000.0**2 * math.log(60_000.0) or bound > 1e3 * float(terms.max())
    capped = cubic_sum(s, periods, start, 5.0)
    assert float((n**-3.0 * np.minimum(terms * n**3.0, 5.0)).sum()) <= capped <= bound
    assert cubic_sum(s, periods, start, 1e9, 1e-12) >= min(plain, float(np.minimum(terms * n**3.0, 1e9) @ n**-3.0))


@pytest.mark.parametrize("d", [1e-12, 1e-9, 1e-6])
def test_hardly_any_damping_is_as_good_as_none(d: float) -> None:
    for s in SPEEDS[:4]:
        none = steady_states(System(s, 0.0, 0.6, Load.harmonic(0.5, 1.0))).orbits
        some = steady_states(System(s, d, 0.6, Load.harmonic(0.5, 1.0))).orbits
        for one, two in zip(none, some, strict=True):
            assert two.error_bound <= 4.0 * max(one.error_bound, 1e-10)
