"""The two multipliers of a rhythm of blows that take time: finite differences, closed bounds, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import strategies
from percuss import Kept, Load, System
from percuss.model import SteppedBar, Timed
from percuss.stability import timed_stability
from percuss.steady import Reason, TimedOrbit, timed_states
from percuss.steady.forced import forced_response
from timed_oracle import Blow, after


def test_the_drifter() -> None:
    whole = 0.0731 + 0.2187 + 0.1493
    body = SteppedBar(40.0, (1.2566, 1.9635, 0.9503), (0.0731 / whole, 0.2187 / whole, 0.1493 / whole))
    law = Timed(0.41528390670042886, 0.066923600090682378, 0.02807555306396961, 1.0 / 101.13533508847935)
    orbit = timed_states(System(body, Load.harmonic(0.66, 1.0), Kept(0.2)), law).orbits[1]
    judged = timed_stability(orbit)
    pair = complex(-0.23175885550464095, 0.3447217584903476)
    assert judged.multipliers == pytest.approx((pair, pair.conjugate()), abs=1e-9)
    assert judged.stable and judged.kind is Reason.STABLE
    assert judged.margin == pytest.approx(1.0 - abs(pair), abs=1e-9)


def _differences(orbit: TimedOrbit) -> np.ndarray:
    """The map's derivative by central differences of the quadrature."""
    blow = Blow(orbit.law.restitution, orbit.law.duration, orbit.law.force_centroid, orbit.law.advance_per_impulse)
    steps = 1e-5, 1e-5 * orbit.rigid_velocity
    columns = []
    for i, step in enumerate(steps):
        results = []
        for sign in (1.0, -1.0):
            place = [orbit.phase, orbit.rigid_velocity]
            place[i] += sign * step
            results.append(np.array(after(orbit.system.load, blow, orbit.system.d, orbit.periods, *place)))
        columns.append((results[0] - results[1]) / (2.0 * step))
    return np.array(columns).T


@settings(max_examples=20)
@given(data=st.data(), s=st.floats(5.0, 50.0), d=st.sampled_from([0.0, 0.01, 0.3]), r=st.floats(0.0, 0.9))
def test_finite_differences_of_the_map(data: st.DataObject, s: float, d: float, r: float) -> None:
    alternating = data.draw(strategies.coefficients(3))
    m = data.draw(st.integers(1, 3))
    unit = strategies.level_of_one(d, r, m)
    mean = 0.7 * strategies.highest_velocity(alternating, d) / unit
    system = System(s, d, r, Load.fourier(np.array([mean, *alternating])))
    duration = data.draw(st.floats(0.0, 0.05))
    law = Timed(r, duration, data.draw(st.floats(0.2, 0.8)) * duration, data.draw(st.floats(0.0, 0.02)))
    assume(not strategies.resonant(system))
    for orbit in timed_states(system, law, m).orbits:
        slow = orbit.contact_velocity < 0.2 * orbit.rigid_velocity
        if slow or orbit.fold or abs(timed_stability(orbit).multipliers[0]) > 30.0:
            continue
        matrix = _differences(orbit)
        pair = timed_stability(orbit).multipliers
        size = max(1.0, float(np.abs(matrix).max()))
        assert sum(pair).real == pytest.approx(float(np.trace(matrix)), abs=1e-6 * size)
        assert (pair[0] * pair[1]).real == pytest.approx(float(np.linalg.det(matrix)), abs=1e-6 * size)


def _forced_velocity(orbit: TimedOrbit) -> float:
    """v_f at the impact."""
    return float(forced_response(orbit.system).rigid_velocity(np.array([orbit.phase]))[0])


@given(drawn=st.one_of(strategies.fourier_systems(6), strategies.square_systems()))
def test_without_duration_it_is_b77s_quadratic_of_a_rigid_bar(drawn: strategies.Drawn) -> None:
    assume(not strategies.resonant(drawn.system))
    system, m = drawn
    d, r, load = system.d, system.restitution, system.load
    for orbit in timed_states(system, Timed(r), m).orbits:
        velocity = _forced_velocity(orbit)
        forces = {float(load.value(orbit.phase, side)) for side in load.sides}
        moduli = []
        for force in forces:
            slope = (force - load.mean - d * velocity) / load.mean  # v_f' over p_0
            decay = math.exp(-d * orbit.period)
            gain = (1.0 - decay) / (d * orbit.period) if d * orbit.period > 1e-8 else 1.0
            linear = -1.0 - r**2 * decay - gain * (1.0 + r) ** 2 * slope  # B77 (29)–(31) with σ = 0
            moduli.append(float(np.abs(np.roots([1.0, linear, r**2 * decay])).max()))
        judged = timed_stability(orbit)
        assert abs(judged.multipliers[0]) == pytest.approx(max(moduli), rel=1e-6, abs=1e-6)


@settings(max_examples=30)
@given(drawn=strategies.fourier_systems(6), duration=st.floats(1e-3, 0.02), share=st.floats(0.2, 0.8))
def test_of_two_that_meet_in_a_fold_the_rising_one_is_unstable(
    drawn: strategies.Drawn, duration: float, share: float
) -> None:
    assume(not strategies.resonant(drawn.system))
    law = Timed(drawn.system.restitution, duration, share * duration, 0.01)
    states = timed_states(drawn.system, law, drawn.periods)
    for orbit in states.orbits:
        if orbit.fold or orbit.contact_velocity <= 0.0:
            continue
        here = orbit.phase
        slope = float(np.diff(states.curve(np.array([here - 1e-6, here + 1e-6])))[0]) / 2e-6
        pair = timed_stability(orbit).multipliers
        at_one = ((1.0 - pair[0]) * (1.0 - pair[1])).real
        if abs(slope) > 1e-4 * drawn.system.load.mean and abs(at_one) > 1e-6 * abs(pair[0]):
            assert at_one * slope < 0.0


@pytest.mark.parametrize(("s", "r", "m"), [(40.0, 0.6, 1), (20.0, 0.3, 1), (30.0, 0.8, 2), (5.0, 0.6, 1)])
def test_the_flip_of_a_uniform_bar_is_closed(s: float, r: float, m: int) -> None:
    """−1 is a multiplier where (1 − R)² V + p [(1 + R)(T + 2A) − 4 t_J] + 2 (1 − R) t_J² p' = 0; to first order
    p/p_0 = −[(1 − R)/(1 + R)]² T/(T − t_c) on a rod that stays where the blow puts it."""
    law = Timed.of_uniform_bar(s, r)

    def stable_one(mean: float) -> TimedOrbit:
        return timed_states(System(s, 0.0, r, Load.harmonic(mean, 1.0)), law, m).orbits[-1]

    fold = (1.0 + r) / (math.pi * m * (1.0 - r))

    def at_minus_one(mean: float) -> float:
        first, second = timed_stability(stable_one(mean)).multipliers
        return float(((1.0 + first) * (1.0 + second)).real)

    flip = brentq(at_minus_one, 0.05 * fold, 0.999 * fold, xtol=1e-14)
    orbit = stable_one(flip)
    load, period, half = orbit.system.load, orbit.period, law.force_centroid
    force, slope = float(load.value(orbit.phase)), float(load.derivative(orbit.phase))
    bracket = (1.0 + r) * (period + 2.0 * law.advance_per_impulse) - 4.0 * half
    closed = (1.0 - r) ** 2 * orbit.rigid_velocity + force * bracket + 2.0 * (1.0 - r) * half**2 * slope
    assert closed == pytest.approx(0.0, abs=1e-9 * orbit.rigid_velocity)
    bound = -(((1.0 - r) / (1.0 + r)) ** 2) * period / (period - law.duration)
    assert force / load.mean == pytest.approx(bound, abs=2.0 * half**2 / flip)
    assert timed_stability(stable_one(flip * 1.001)).stable
    below = timed_stability(stable_one(flip * 0.999))
    assert below.kind is Reason.FLIP and "flip" in below.reason


def test_a_load_that_jumps_during_the_contact_is_judged_by_its_worst_value() -> None:
    law = Timed(0.5, 0.1, 0.05)
    load = Load.steps([0.0, 2.0, 4.0], [1.5, 0.1, -0.9])
    states = timed_states(System(40.0, 0.0, 0.5, load), law)
    for orbit in states.orbits:
        judged = timed_stability(orbit)
        alone = [
            timed_stability(TimedOrbit(orbit.system, law, 1, orbit.phase, False, force)).multipliers
            for force in orbit.forces
        ]
        assert abs(judged.multipliers[0]) >= max(abs(pair[0]) for pair in alone) - 1e-12


def test_a_blow_at_a_jump_is_not_judged() -> None:
    law, square = Timed(0.5, 0.1, 0.02), Load.square(1.0, 1.71)
    found = []
    for factor in np.linspace(0.97, 1.12, 9):
        states = timed_states(System(40.0, 0.0, 0.5, square.with_mean(factor * square.mean)), law)
        found += [timed_stability(orbit) for orbit in states.orbits if orbit.straddles]
    assert found and all(one.kind is None and not one.stable and "not judged" in one.reason for one in found)
