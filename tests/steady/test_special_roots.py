"""Roots of B77 (14) that are special: at the knots of steps, of a bar that rebounds fully, in resonance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, stability_of, steady_states
from percuss.errors import ResonanceError
from percuss.stability import exact_plane, stability_plane
from percuss.steady import Orbit, grows
from percuss.steady.forced import HarmonicResponse, forced_response
from percuss.steady.phases import Arcs, level

TURN = 2.0 * math.pi
CROSSED = Load.steps([0.0, 1.0, 2.0], [1.0, 0.5, -1.5 / (TURN - 2.0)])  # v_f rises on, more slowly, through phase 1
FLAT = Load.steps([0.0, 1.0, 2.0, 3.0], [1.0, 0.0, 0.5, -1.5 / (TURN - 3.0)])  # v_f rests from phase 1 to 2


def touching(load: Load, knot: int, d: float = 0.0, r: float = 0.5, s: float = 20.0) -> System:
    """The load with the mean at which the level is v_f of one of its knots."""
    system = System(s, d, r, load.with_mean(0.0))
    height = float(Arcs.of(forced_response(system)).velocities[knot])
    return System(s, d, r, load.with_mean(height / float(level(1.0, d, r, TURN))))


@pytest.mark.parametrize("d", [0.0, 0.02, 0.2])
def test_two_motions_meet_at_a_kink_without_a_multiplier_of_one(d: float) -> None:
    """The two motions just below the level end in the two sides that the reason names."""
    at = touching(CROSSED, 2, d)
    orbits = steady_states(at).orbits
    assert [orbit.fold for orbit in orbits] == [True] and orbits[0].phase == 2.0
    verdict = stability_of(orbits[0])
    assert not verdict.stable and "multiplier is 1" not in verdict.reason and "two motions meet" in verdict.reason
    near = System(at.s, d, 0.5, at.load.with_mean(at.load.mean * (1 - 1e-9)))
    moduli = [stability_of(orbit).multipliers.largest for orbit in steady_states(near).orbits]
    assert len(moduli) == 2
    for modulus, where in zip(moduli, ("before", "after"), strict=True):
        assert f"{modulus:.4g} just {where}" in verdict.reason
    assert verdict.margin == pytest.approx(1.0 - max(moduli), abs=1e-5)
    above = System(at.s, d, 0.5, at.load.with_mean(at.load.mean * (1 + 1e-9)))
    assert not steady_states(above).orbits


@pytest.mark.parametrize("d", [0.0, 0.02])
def test_a_level_that_crosses_at_a_knot_is_no_fold(d: float) -> None:
    at = touching(CROSSED, 1, d)
    for share in (1.0 - 1e-9, 1.0, 1.0 + 1e-9):
        found = steady_states(System(at.s, d, 0.5, at.load.with_mean(at.load.mean * share)))
        assert [orbit.fold for orbit in found.orbits] == [False, False]
        assert found.orbits[0].phase == pytest.approx(1.0, abs=1e-7)
        assert "fold: two" not in stability_of(found.orbits[0]).reason


@pytest.mark.parametrize(("load", "knot"), [(CROSSED, 1), (CROSSED, 2), (Load.harmonic(1.0, 1.0), 0)])
def test_planes_call_the_same_roots_folds(load: Load, knot: int) -> None:
    at = touching(load, knot)
    plane = stability_plane(at, 0.5, at.load.load_factor)
    expected = {round(orbit.phase, 6): orbit.fold for orbit in steady_states(at).orbits}
    for phase, fold in zip(plane.phase, plane.fold, strict=True):
        if not np.isnan(phase):
            assert fold == expected[round(float(phase), 6)]


def test_a_plateau_at_the_level_is_a_continuum() -> None:
    at = touching(FLAT, 1)
    found = steady_states(at)
    middle, other = found.orbits
    assert middle.continuum == (1.0, 2.0) and middle.phase == pytest.approx(1.5) and other.continuum is None
    assert "from 1 to 2 rad" in found.note and "continuum" in found.note
    verdict = stability_of(middle, modes=0)
    assert "continuum" in verdict.reason and not verdict.stable
    assert verdict.margin == pytest.approx(0.0, abs=1e-10)
    for phase in np.linspace(1.0, 2.0, 5):  # each of them is a motion: v_f meets the level there
        assert float(found.rigid_velocity(phase)) == pytest.approx(found.level, abs=1e-14)
    for share in (1.0 - 1e-6, 1.0 + 1e-6):
        beside = steady_states(System(at.s, 0.0, 0.5, at.load.with_mean(at.load.mean * share)))
        assert not beside.note and all(orbit.continuum is None for orbit in beside.orbits)
        assert len(beside.orbits) == 2


def test_a_damped_plateau() -> None:
    """With damping the step that holds v_f up equals d·v_f above the mean."""
    d = 0.3

    def rate(value: float) -> tuple[float, System]:
        load = Load.steps([0.0, 1.0, 2.0], [1.0, value, -1.0]).with_mean(0.0)
        response = forced_response(System(20.0, d, 0.5, load))
        return float(load.values[1] - d * response.knot_velocity[1]), System(20.0, d, 0.5, load)  # type: ignore[union-attr]

    low, high = -1.0, 1.0
    for _ in range(200):
        value = 0.5 * (low + high)
        low, high = (value, high) if rate(value)[0] < 0.0 else (low, value)
    at = touching(rate(value)[1].load, 1, d)
    assert at.load.mean > 0.0
    continua = [orbit.continuum for orbit in steady_states(at).orbits if orbit.continuum]
    assert continua == [(1.0, 2.0)]


def test_smooth_folds_are_what_they_were() -> None:
    at = touching(Load.harmonic(1.0, 1.0), 0)
    orbits = steady_states(at).orbits
    assert [orbit.fold for orbit in orbits] == [True]
    assert stability_of(orbits[0]).reason == "fold: two motions meet here, the multiplier is 1"


# -- R = 1 without damping ---------------------------------------------------------------------------------------------


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


# -- Resonance of undamped bars under steps ----------------------------------------------------------------------------


HALVES = ([0.0, math.pi], [1.0, -0.3])  # no even harmonic
QUARTERS = ([0.3, 0.3 + math.pi / 2, 0.3 + math.pi, 0.3 + 1.5 * math.pi], [1.0, 0.4, 0.7, -0.5])  # none of 4, 8, …


@pytest.mark.parametrize("harmonics", [1, 8, 64, 65, 128])
@pytest.mark.parametrize(
    ("s", "k", "n"), [(65 / math.pi, 65, 1), (65 / (3 * math.pi), 65, 3), (5001 / math.pi, 5001, 1)]
)
def test_beyond_the_kept_harmonics(harmonics: int, s: float, k: int, n: int) -> None:
    system = System(s, 0.0, 0.5, Load.square(1.0, 1.3, harmonics))
    with pytest.raises(ResonanceError) as refused:
        steady_states(system)
    assert (refused.value.harmonic, refused.value.mode) == (k, n)
    assert steady_states(System(s * (1 + 1e-9), 0.0, 0.5, system.load)).orbits
    assert steady_states(System(s, 1e-9, 0.5, system.load)).orbits


@pytest.mark.parametrize(("steps", "k"), [(HALVES, 2), (HALVES, 66), (QUARTERS, 4), (QUARTERS, 8)])
def test_a_harmonic_that_the_steps_do_not_contain_is_no_resonance(
    steps: tuple[list[float], list[float]], k: int
) -> None:
    """The forced motion is that of the other harmonics, summed here; the mode that is met only lets its swing open."""
    load = Load.steps(*steps, harmonics=4096)
    assert load.coefficients[k] == 0.0
    system = System(k / math.pi, 0.0, 0.5, load)
    theta = np.linspace(0.1, 6.0, 9)
    exact, summed = forced_response(system).modal(6, theta), HarmonicResponse(system).modal(6, theta)
    assert exact[0] == pytest.approx(summed[0], abs=1e-8)
    assert exact[1] == pytest.approx(summed[1], abs=2e-4)
    for orbit in steady_states(system).orbits:
        assert np.isfinite(orbit.impact_velocity) and np.isfinite(stability_of(orbit).margin)


def test_a_smooth_load_is_refused_for_the_harmonics_it_has() -> None:
    smooth = Load.fourier([0.3, 1.0, 0.0, 0.5])
    for k in (1, 3):
        with pytest.raises(ResonanceError, match=f"k = {k} "):
            steady_states(System(k / math.pi, 0.0, 0.5, smooth))
    assert steady_states(System(2 / math.pi, 0.0, 0.5, smooth)).orbits
