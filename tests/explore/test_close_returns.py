"""Starts of a search from simulated motions that nearly come back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System
from percuss.errors import ParameterError
from percuss.explore import orbit_seeds, switched_seeds
from percuss.explore.orbit_starts import SIMULATED, SWITCHED
from percuss.stability import orbit_multipliers
from percuss.steady import orbits
from random_hammers import random_hammer

TURN = 2.0 * math.pi


def test_an_attractor_that_random_times_miss_is_found() -> None:
    hammer = random_hammer(221)
    plain = orbits(hammer.system, 4, 4, modes=hammer.modes, tries=30)
    seeds = orbit_seeds(hammer.system, 4, 4, modes=hammer.modes, motions=8)
    found = orbits(hammer.system, 4, 4, modes=hammer.modes, tries=30, near=seeds)
    assert not plain.orbits
    assert found.sources[SIMULATED].orbits == 1
    assert orbit_multipliers(found.orbits[0]).stable
    assert found.orbits[0].admissible


def test_unstable_orbits_inside_an_aperiodic_motion_are_found() -> None:
    """Beyond the end of its cascade the hammer moves aperiodically near orbits of every length."""
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.58, 1.0))
    rows = orbit_seeds(system, 6, 6, modes=0, motions=16)[SIMULATED]
    assert rows.shape[1] == 6
    assert np.all(np.diff(rows) > 0.0)
    assert np.all(np.ptp(rows, axis=1) < 6.0 * TURN)
    assert np.all((rows[:, 0] >= 0.0) & (rows[:, 0] < TURN))


def test_the_same_seed_gives_the_same_starts() -> None:
    hammer = random_hammer(221)
    one, other = (orbit_seeds(hammer.system, 2, 2, modes=8, motions=4, seed=5)[SIMULATED] for _ in range(2))
    assert np.array_equal(one, other)


def test_what_is_none_is_refused() -> None:
    hammer = random_hammer(0)
    with pytest.raises(ParameterError):
        orbit_seeds(hammer.system, 0)
    with pytest.raises(ParameterError):
        orbit_seeds(hammer.system, 2, motions=0)


def test_a_doubled_orbit_is_found_from_the_flip_of_the_shorter_one() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.588, 1.0))
    plain = orbits(system, 4, 4, modes=0, tries=2)
    found = orbits(system, 4, 4, modes=0, tries=2, near=switched_seeds(system, 4, 4, modes=0, reach=0.03))
    assert not plain.orbits
    assert found.sources[SWITCHED].orbits == 1


def test_an_orbit_with_an_impact_more_is_found_from_a_grazing() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.53, 1.0))
    rows = switched_seeds(system, 3, 1, modes=0, reach=0.02)[SWITCHED]
    found = orbits(system, 3, 1, modes=0, tries=1, near={SWITCHED: rows})
    assert found.sources[SWITCHED].orbits >= 1
    assert all(orbit.admissible for orbit in found.orbits)


def test_nothing_begins_where_nothing_shorter_exists() -> None:
    system = System(s=5.0, d=0.2, restitution=0.1, load=Load.harmonic(1.5, 1.0))
    assert switched_seeds(system, 3, 2, modes=4)[SWITCHED].shape == (0, 3)
