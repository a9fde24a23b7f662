"""Resonance of undamped bars under steps: every harmonic that the steps contain, and no other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, stability_of, steady_states
from percuss.errors import ResonanceError
from percuss.steady.forced import HarmonicResponse, forced_response

TURN = 2.0 * math.pi
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
