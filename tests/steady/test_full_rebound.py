"""R = 1 without damping: which roots of B77 (14) are motions of the bar, against the bar's own impact map."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, steady_states
from percuss.stability import exact_plane, stability_plane
from percuss.steady import Orbit, grows

TURN = 2.0 * math.pi
UNSYMMETRIC = Load.fourier([0.3, 1.0, 0.5j])


def misses(system: System, phase: float, periods: int, modes: int) -> float:
    """How far the best state just after the impact is from coming back, mode by mode: the least-squares residual of
    x = D(Φ(x − f) + f), with the forced motion summed term by term; relative to the forced velocity's terms."""
    k = system.load.harmonics
    worst = 0.0
    for n in range(1, modes + 1):
        omega = n * math.pi * system.s
        waves = system.load.coefficients[k] * np.exp(1j * k * phase) / (omega**2 - k**2)
        f = np.array([waves.real.sum() + system.load.mean / omega**2, (1j * k * waves).real.sum()])
        turn = omega * TURN * periods
        flight = np.array([[math.cos(turn), math.sin(turn) / omega], [-omega * math.sin(turn), math.cos(turn)]])
        impact, unit = np.diag([1.0, -1.0]), np.diag([omega, 1.0])
        matrix = unit @ (np.eye(2) - impact @ flight) @ np.linalg.inv(unit)
        right = unit @ impact @ (np.eye(2) - flight) @ f
        state = np.linalg.lstsq(matrix, right, rcond=1e-9)[0]
        worst = max(worst, float(np.abs(matrix @ state - right).max() / np.abs(k * waves).sum()))
    return worst


def test_a_bar_of_fewer_modes_is_judged_by_those_it_has() -> None:
    """A rigid bar has no elastic modes that could ring; the first mode is enough to have one."""
    system = System(s=20.0, d=0.0, restitution=1.0, load=UNSYMMETRIC)
    rigid = steady_states(system, modes=0)
    assert len(rigid.orbits) == 2 and not rigid.note
    for orbit in rigid.orbits:
        assert abs(float(system.load.antiderivative(orbit.phase))) < 1e-13  # v_f = 0: B77 (14) with c = 0
    for modes in (1, 8, 100, None):
        found = steady_states(system, modes=modes)
        assert not found.orbits and "grows without bound" in found.note


def test_a_load_symmetric_about_the_impact_drives_no_mode() -> None:
    """Of the roots of one load those where it is symmetric in time are motions, the others are not."""
    system = System(s=20.0, d=0.0, restitution=1.0, load=Load.fourier([0.1, 1.0, 0.0, -1.5]))
    found = steady_states(system)
    assert [orbit.phase for orbit in found.orbits] == pytest.approx([0.0, math.pi], abs=1e-12)
    assert "grows" not in steady_states(System(s=20.0, d=0.0, restitution=1.0, load=Load.harmonic(0.1, 1.0))).note
    others = [o.phase for o in steady_states(system, modes=0).orbits if o.phase not in (0.0, math.pi)]
    for phase in others:
        assert f"{phase:.6g}" in found.note
        assert misses(system, phase, 1, 3) > 1e-3
    for orbit in found.orbits:
        assert misses(system, orbit.phase, 1, 3) < 1e-9


def test_steps_symmetric_about_the_impact() -> None:
    """The middles of a square wave's halves; steps of three values have no such middle."""
    square = steady_states(System(s=20.0, d=0.0, restitution=1.0, load=Load.square(1.0, 1.3)))
    assert [orbit.phase for orbit in square.orbits] == pytest.approx([0.65 * math.pi, 1.65 * math.pi], abs=1e-12)
    crooked = System(s=20.3, d=0.0, restitution=1.0, load=Load.steps([0.0, 1.0, 2.5], [1.0, 0.4, -0.3], harmonics=1))
    assert len(steady_states(crooked, modes=0).orbits) == 2
    assert not steady_states(crooked).orbits and not steady_states(crooked, modes=1).orbits
    # every jump meets the waves of the others in step (breaks at multiples of 2τ = 0.1): calm in the last step only
    in_step = System(s=20.0, d=0.0, restitution=1.0, load=crooked.load)
    assert [orbit.phase for orbit in steady_states(in_step).orbits] == [steady_states(in_step, modes=0).orbits[1].phase]


@pytest.mark.parametrize("modes", [None, 1, 5])
def test_modes_that_swing_a_whole_number_of_times_come_back(modes: int | None) -> None:
    """s = 2/π: every mode swings 2n times between two impacts, whatever drives it."""
    system = System(s=2.0 / math.pi, d=0.0, restitution=1.0, load=Load.fourier([0.3, 1.0, 0.0, 0.5j]))
    found = steady_states(system, modes=modes)
    assert len(found.orbits) == 2 and not found.note
    for orbit in found.orbits:
        assert misses(system, orbit.phase, 1, 5) < 1e-9
        assert abs(orbit.impact_velocity - orbit.rigid_velocity) < 1.0  # no mode strikes
        assert np.abs(orbit.modal_state(5).velocity).max() == 0.0


@settings(max_examples=30)
@given(st.floats(0.5, 50.0), st.integers(1, 3), st.integers(1, 6), st.floats(0.0, TURN), st.floats(0.0, TURN))
def test_growing_is_what_the_impact_map_says(s: float, periods: int, modes: int, a: float, b: float) -> None:
    load = Load.fourier([0.2, np.exp(1j * a), 0.3 * np.exp(1j * b)])
    system = System(s=s + math.sqrt(2) * 1e-3, d=0.0, restitution=1.0, load=load)
    for orbit in steady_states(system, periods, modes=0).orbits:
        missed = misses(system, orbit.phase, periods, modes)
        if not 1e-10 < missed < 1e-6:
            assert grows(system, orbit.phase, periods, modes=modes) == (missed > 1e-8)


def test_anything_that_takes_energy_lets_it_be() -> None:
    system = System(s=20.0, d=0.0, restitution=1.0, load=UNSYMMETRIC)
    phases = np.array([0.1, np.nan, 3.0])
    assert grows(system, phases, restitution=np.array([1.0, 1.0, 0.999])).tolist() == [True, False, False]
    assert not grows(System(s=20.0, d=1e-9, restitution=1.0, load=UNSYMMETRIC), phases).any()
    assert grows(system, 0.1).shape == ()


def test_planes_tell_the_same() -> None:
    system = System(s=20.0, d=0.0, restitution=1.0, load=UNSYMMETRIC)
    plane = stability_plane(system, np.array([0.9, 1.0]), 0.3)
    for modes, driven in ((0, False), (1, True), (16, True)):
        outcome = exact_plane(system, np.array([0.9, 1.0]), 0.3, modes=modes, plane=plane).outcome
        there = ~np.isnan(plane.phase)
        assert (outcome[:, 1][there[:, 1]] == 2).all() == driven
        assert not (outcome[:, 0] == 2).any()
        assert driven != any(isinstance(orbit, Orbit) for orbit in steady_states(system, modes=modes).orbits)
