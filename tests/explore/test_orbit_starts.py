"""Where a search for orbits starts, and the orbit that a simulated motion has settled on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from percuss import Load, Start, System
from percuss.errors import ParameterError
from percuss.explore import orbit_of, orbit_seeds, switched_seeds
from percuss.explore.orbit_starts import SIMULATED, SWITCHED
from percuss.simulate import Stop, run
from percuss.steady import orbits
from random_hammers import random_hammer

TURN = 2.0 * math.pi


def hammer(mean: float) -> System:
    return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))


def test_an_attractor_that_random_times_miss_is_found() -> None:
    drawn = random_hammer(221)
    plain = orbits(drawn.system, 4, 4, modes=drawn.modes, tries=30)
    seeds = orbit_seeds(drawn.system, 4, 4, modes=drawn.modes, motions=8)
    found = orbits(drawn.system, 4, 4, modes=drawn.modes, tries=30, near=seeds)
    assert not plain.orbits
    assert found.sources[SIMULATED].orbits == 1
    assert found.orbits[0].multipliers().stable
    assert found.orbits[0].admissible


def test_unstable_orbits_inside_an_aperiodic_motion_are_found() -> None:
    """Beyond the end of its cascade the hammer moves aperiodically near orbits of every length."""
    system = hammer(0.58)
    rows = orbit_seeds(system, 6, 6, modes=0, motions=16)[SIMULATED]
    assert rows.shape[1] == 6
    assert np.all(np.diff(rows) > 0.0)
    assert np.all(np.ptp(rows, axis=1) < 6.0 * TURN)
    assert np.all((rows[:, 0] >= 0.0) & (rows[:, 0] < TURN))


def test_the_same_seed_gives_the_same_starts() -> None:
    drawn = random_hammer(221)
    one, other = (orbit_seeds(drawn.system, 2, 2, modes=8, motions=4, seed=5)[SIMULATED] for _ in range(2))
    assert np.array_equal(one, other)


def test_what_is_none_is_refused() -> None:
    for impacts, motions in ((0, 64), (2, 0)):
        with pytest.raises(ParameterError):
            orbit_seeds(hammer(0.6), impacts, motions=motions)
    with pytest.raises(ParameterError, match="simulated motion"):
        orbit_of(np.zeros(3))


def test_a_doubled_orbit_is_found_from_the_flip_of_the_shorter_one() -> None:
    system = hammer(0.588)
    plain = orbits(system, 4, 4, modes=0, tries=2)
    found = orbits(system, 4, 4, modes=0, tries=2, near=switched_seeds(system, 4, 4, modes=0, reach=0.03))
    assert not plain.orbits
    assert found.sources[SWITCHED].orbits == 1


def test_an_orbit_with_an_impact_more_is_found_from_a_grazing() -> None:
    system = hammer(0.53)
    rows = switched_seeds(system, 3, 1, modes=0, reach=0.02)[SWITCHED]
    found = orbits(system, 3, 1, modes=0, tries=1, near={SWITCHED: rows})
    assert found.sources[SWITCHED].orbits >= 1
    assert all(orbit.admissible for orbit in found.orbits)


def test_nothing_begins_where_nothing_shorter_exists() -> None:
    system = System(s=5.0, d=0.2, restitution=0.1, load=Load.harmonic(1.5, 1.0))
    assert switched_seeds(system, 3, 2, modes=4)[SWITCHED].shape == (0, 3)


def stable(system: System, p: int, n: int, modes: int = 0):
    """The stable orbit of a label."""
    return next(o for o in orbits(system, p, n, modes=modes, tries=100).orbits if o.multipliers().stable)


@pytest.mark.parametrize(("mean", "p", "n"), [(0.7, 1, 1), (0.665, 2, 1), (0.62, 2, 2), (0.634, 3, 1)])
def test_a_settled_motion_has_the_orbit_of_its_label(mean: float, p: int, n: int) -> None:
    system = hammer(mean)
    wanted = stable(system, p, n)
    motion = run(system, Start.orbit(wanted, velocity=[-1e-5]), modes=0)
    found = orbit_of(motion)
    assert motion.label == wanted.label == found.label
    assert found.times == pytest.approx(wanted.times, abs=1e-11)
    assert found.modes == motion.modes == 0


def test_a_motion_that_settles_slowly_is_on_its_way_to_an_orbit() -> None:
    """Close before its flip z=1/1 loses a disturbance so slowly that no state comes back to 1e-9."""
    system = hammer(0.6551)
    wanted = stable(system, 1, 1)
    motion = run(system, Start.orbit(wanted, velocity=[-1e-3]), modes=0, stop=Stop(150))
    assert motion.cycle is None
    found = orbit_of(motion)
    assert found.times == pytest.approx(wanted.times, abs=1e-11)


def test_a_long_cycle_is_found_in_what_is_called_aperiodic() -> None:
    """A cycle that the simulation has not noticed."""
    system = hammer(0.665)
    wanted = stable(system, 2, 1)
    motion = run(system, Start.orbit(wanted), modes=0, stop=Stop(200, periodic=False))
    for label in ("aperiodic", "undecided"):
        assert orbit_of(replace(motion, label=label, cycle=None)).label == "z=2/1"


@pytest.mark.parametrize("seed", [12, 9])
def test_chaos_and_rest_have_none(seed: int) -> None:
    drawn = random_hammer(seed)
    motion = run(drawn.system, Start.rigid(), modes=drawn.modes, stop=Stop(400))
    assert not motion.label.startswith("z=")
    assert orbit_of(motion) is None


def test_too_few_impacts_have_none() -> None:
    motion = run(hammer(0.7), Start.rigid(), modes=0, stop=Stop(2))
    assert orbit_of(motion) is None
    assert orbit_of(run(hammer(0.7), Start.rigid(), modes=0, stop=Stop(0))) is None
