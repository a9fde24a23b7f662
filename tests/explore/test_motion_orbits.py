"""The orbit that a simulated motion has settled on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from percuss import Load, Start, System
from percuss.errors import ParameterError
from percuss.explore import orbit_of
from percuss.simulate import Stop, run
from percuss.stability import orbit_multipliers
from percuss.steady import orbits
from random_hammers import random_hammer

TURN = 2.0 * math.pi


def hammer(mean: float) -> System:
    return System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(mean, 1.0))


def stable(system: System, p: int, n: int, modes: int = 0):
    """The stable orbit of a label."""
    return next(o for o in orbits(system, p, n, modes=modes, tries=100).orbits if orbit_multipliers(o).stable)


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


def test_what_is_no_motion_is_refused() -> None:
    with pytest.raises(ParameterError, match="simulated motion"):
        orbit_of(np.zeros(3))
