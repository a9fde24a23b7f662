"""The numbers of one harmonic or step of a load as parameters: put, swept and followed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Load, System
from percuss.errors import ParameterError
from percuss.explore import PARAMETERS, BranchEvent, SystemFamily, follow, sweep, vary
from percuss.explore.parameters import label_of
from percuss.steady import orbits

FOURIER = System(s=5.0, d=0.02, restitution=0.5, load=Load.fourier([0.6, 1.0, 0.3j]))
SQUARE = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, 1.65))
STEPS = System(s=5.0, d=0.0, restitution=0.5, load=Load.steps([0.2, 1.0, 3.0], [1.5, -0.3, 0.1]))


@given(st.integers(1, 2), st.floats(1e-3, 5.0), st.floats(-3.1, 3.1))
def test_amplitude_and_phase_of_a_harmonic_come_back(number: int, amplitude: float, phase: float) -> None:
    names = f"amplitude{number}", f"phase{number}"
    system = vary(FOURIER, {names[1]: phase, names[0]: amplitude})
    assert PARAMETERS[names[0]].get(system) == pytest.approx(amplitude, rel=1e-14)
    assert PARAMETERS[names[1]].get(system) == pytest.approx(phase, abs=1e-14)
    t = np.linspace(0.0, 6.0, 7)
    change = amplitude * np.cos(number * t + phase) - np.real(
        FOURIER.load.coefficients[number] * np.exp(1j * number * t)
    )
    assert system.load.value(t) == pytest.approx(FOURIER.load.value(t) + change, abs=1e-13)


@given(st.floats(-5.0, 5.0), st.floats(0.21, 2.9))
def test_steps_and_breaks_come_back(value: float, place: float) -> None:
    system = vary(STEPS, {"step3": value, "break2": place})
    assert system.load.values == (1.5, -0.3, value)
    assert system.load.breaks == (0.2, place, 3.0)
    assert system.load.at == STEPS.load.at


@pytest.mark.parametrize("name", ["amplitude3", "phase3", "step1", "break1"])
def test_a_load_without_it_is_refused(name: str) -> None:
    assert PARAMETERS[name].get(FOURIER) is None
    with pytest.raises(ParameterError, match=name):
        vary(FOURIER, {name: 0.1})
    with pytest.raises(ParameterError, match=name):
        SystemFamily(FOURIER).check({name: ""})


@pytest.mark.parametrize("place", [0.2, 3.0, -1.0])
def test_a_break_stays_between_its_neighbours(place: float) -> None:
    with pytest.raises(ParameterError, match="break2"):
        vary(STEPS, {"break2": place})


@pytest.mark.parametrize("name", ["amplitude0", "phase", "amplitude01", "step-1", "Amplitude1"])
def test_other_names_are_none(name: str) -> None:
    assert name not in PARAMETERS
    with pytest.raises(KeyError):
        PARAMETERS[name]


def test_they_have_labels() -> None:
    assert label_of("phase2") == "phase of harmonic 2"
    assert PARAMETERS["break2"].meaning == "phase in rad at which the load's step 2 begins"


def test_an_orbit_moves_with_the_phase_of_the_only_harmonic() -> None:
    """Nothing else happens: the whole load is shifted."""
    system = System(s=5.0, d=0.02, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    branch = follow(orbits(system, 1, 1, modes=2).orbits[-1], "phase1", (-0.5, 0.5))
    assert [point.kind for point in branch.points] == [BranchEvent.LIMIT] * 2
    shifted = branch.times[:, 0] + branch.values
    assert shifted == pytest.approx(np.full(shifted.shape, shifted[0]), abs=1e-12)


def test_a_break_is_kappa() -> None:
    start = orbits(SQUARE, 1, 1, modes=0).orbits[-1]
    by_kappa, by_break = follow(start, "kappa", (1.64, 1.75)), follow(start, "break2", (1.64 * math.pi, 1.75 * math.pi))
    assert [point.kind for point in by_break.points] == [point.kind for point in by_kappa.points]
    expected = [math.pi * point.value for point in by_kappa.points]
    assert [point.value for point in by_break.points] == pytest.approx(expected, rel=0, abs=1e-10)


def test_an_amplitude_is_followed_and_swept() -> None:
    start = orbits(FOURIER, 1, 1, modes=0).orbits[-1]
    branch = follow(start, "amplitude2", (0.1, 0.5))
    assert branch.values.max() <= 0.5
    found = sweep(FOURIER, "amplitude2=0.1,0.3", quantities=["phase"], workers=1)
    at_start = found["phase"][1]
    assert np.mod(np.mod(at_start, 2.0 * math.pi) - start.phase + 1.0, 2.0 * math.pi) == pytest.approx(1.0, abs=1e-9)
