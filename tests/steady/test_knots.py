"""Roots of B77 (14) at the knots of a load of steps: meetings, crossings and plateaus."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, stability_of, steady_states
from percuss.stability import exact_plane, stability_plane
from percuss.steady.forced import forced_response
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
    found = exact_plane(at, 0.5, at.load.load_factor, plane=plane)
    expected = {round(orbit.phase, 6): orbit.fold for orbit in steady_states(at).orbits}
    for phase, fold in zip(plane.phase, found.fold, strict=True):
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
