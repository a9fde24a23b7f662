"""Multipliers of orbits with several impacts: figures, one impact, K(ξ) against the dense map, differences."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from orbit_cases import ENTRIES, motions, of_kind, orbit_at, periods_of, system_of, times_of
from percuss import Kept, Load, System, steady_states
from percuss.errors import ParameterError
from percuss.model import External, Reversed, UniformBar
from percuss.stability import floquet_multipliers
from percuss.steady import PeriodicOrbit, orbit_near

TURN = 2.0 * math.pi


def apart(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest distance of theirs, which may be some only, under the best matching."""
    distance = np.abs(ours[:, None] - theirs[None, :])
    rows, columns = linear_sum_assignment(distance)
    return float(distance[rows, columns].max())


@pytest.mark.parametrize("name", of_kind("orbit"))
def test_multipliers_of_the_figures(name: str) -> None:
    entry = ENTRIES[name]
    orbit = orbit_near(system_of(entry), times_of(entry), periods_of(entry), modes=entry["system"]["modes"])
    assert orbit is not None
    found = orbit.multipliers()
    wanted = np.array([complex(*pair) for pair in entry["multipliers"]])
    assert found.values.size == 2 * orbit.modes + 2
    assert apart(found.values, wanted) < 1e-8 * abs(wanted[0])
    assert found.stable is entry["stable"]
    assert found.largest == pytest.approx(entry["largest_modulus"], rel=1e-8)


@pytest.mark.parametrize("name", of_kind("branch_points"))
def test_multipliers_at_the_special_points_of_the_figures(name: str) -> None:
    for point in ENTRIES[name]["points"]:
        if point["type"].startswith("grazing"):
            continue
        wanted = np.array([complex(*pair) for pair in point["multipliers"]])
        found = orbit_at(ENTRIES[name], point).multipliers().values
        assert apart(found, wanted) < 1e-8 * max(1.0, float(np.abs(wanted).max()))


@pytest.mark.parametrize("contact", [Kept(0.6), Reversed(0.6)])
@pytest.mark.parametrize("load", [Load.harmonic(0.7, 1.0), Load.square(1.0, 1.15)])
def test_one_impact_has_the_map_of_the_steady_motion(contact, load: Load) -> None:
    system = System(UniformBar(3.0, External(0.02)), load, contact)
    for motion in steady_states(system, modes=6).orbits:
        orbit = PeriodicOrbit(system, 1, (motion.phase,), 6)
        for side in ("left", "right"):
            dense = motion.linear_map(6, side).dense()
            assert orbit.map(side=side).dense() == pytest.approx(dense, abs=1e-10 * np.abs(dense).max())
        assert orbit.multipliers().largest == pytest.approx(floquet_multipliers(motion, 6).largest, rel=1e-9)


@settings(max_examples=30)
@given(motions(), st.sampled_from([1.0, -1.0, 0.3 + 0.4j, -1.3 + 0.2j, 1j, complex(math.cos(1.0), math.sin(1.0))]))
def test_the_small_determinant_is_the_characteristic_polynomial(orbit: PeriodicOrbit, xi: complex) -> None:
    if np.abs(orbit.speeds).min() < 1e-3 * np.abs(orbit.speeds).max():
        return
    whole = orbit.map().dense()
    values = np.linalg.eigvals(whole)
    room = 1e-11 * float(np.prod(np.abs(xi) + np.abs(values)))  # of the product, whose factors may nearly vanish
    assert orbit.characteristic(xi) == pytest.approx(complex(np.prod(xi - values)), abs=max(room, 1e-9))


@given(motions())
def test_the_determinant_of_the_map_is_that_of_its_parts(orbit: PeriodicOrbit) -> None:
    """Of a rigid bar each impact multiplies it by β², as its time is one of the two numbers of the state."""
    if orbit.modes or np.abs(orbit.speeds).min() < 1e-3:
        return
    contact, system = orbit.system.contact, orbit.system
    wanted = contact.velocity_factor ** (2 * orbit.impacts) * math.exp(-system.d * orbit.period)
    whole = orbit.map().dense()
    assert np.linalg.det(whole) == pytest.approx(wanted, abs=1e-12 * (1.0 + float(np.abs(whole).max()) ** 2))


def test_an_impact_without_speed_has_a_matrix_but_no_multipliers() -> None:
    entry = ENTRIES["branch_21"]
    point = next(point for point in entry["points"] if point["type"] == "grazing_impact_dies")
    orbit = orbit_at(entry, point)
    assert np.isfinite(orbit.linearised()).all()
    assert abs(np.linalg.det(orbit.linearised())) > 0.1
    assert orbit.multipliers().largest > 1e9  # the speed is rounding


def test_too_many_modes_are_refused() -> None:
    system = System(s=5.0, d=0.01, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    with pytest.raises(ParameterError, match="at most 512 modes"):
        PeriodicOrbit(system, 1, (0.4, 2.3), 513).multipliers()
