"""How far a parameter may move before a motion is lost: against the cascade, the fold and simulations beside them."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss import Load, Start, System, run
from percuss.errors import ParameterError
from percuss.explore import reach
from percuss.explore.continuation.branch import BranchEvent
from percuss.stability import orbit_multipliers
from percuss.steady import PeriodicOrbit, orbit_near, steady_states


def rigid(mean: float, restitution: float = 0.5) -> System:
    return System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, 1.0))


def stable(system: System) -> PeriodicOrbit | None:
    """The stable motion with one impact in one period, if there is one."""
    every = [PeriodicOrbit(system, 1, (one.phase,), 0) for one in steady_states(system, modes=0).orbits]
    return next((one for one in every if one.admissible and orbit_multipliers(one).stable), None)


@settings(max_examples=3, deadline=None)
@given(st.floats(0.05, 0.9), st.floats(0.3, 0.99))
def test_the_mean_load_reaches_from_the_flip_to_the_fold(restitution: float, share: float) -> None:
    """Closed forms: the fold where p_0 π(1−R)/(1+R) is the amplitude; before it motions that keep striking are lost."""
    fold = (1.0 + restitution) / (math.pi * (1.0 - restitution))
    system = rigid(share * fold, restitution)
    orbit = stable(system)
    assume(orbit is not None)
    assert orbit is not None
    found = reach(orbit, "mean", (0.0, 2.0 * fold))
    assert found.below.value < system.load.mean < found.above.value
    if found.above.kind is BranchEvent.FOLD:
        assert found.above.value == pytest.approx(fold, rel=1e-9)
    for end, way in ((found.below, -1), (found.above, 1)):
        inside = rigid(end.value - way * 1e-3 * (found.above.value - found.below.value), restitution)
        assert stable(inside) is not None, end


def test_what_comes_then_is_what_a_simulation_does() -> None:
    orbit = stable(rigid(0.8))
    assert orbit is not None
    found = reach(orbit, "mean", (0.3, 1.2))
    for end, factor in ((found.below, 0.99), (found.above, 1.01)):
        beyond = run(rigid(factor * end.value), Start.orbit(end.orbit), modes=0)
        assert end.then == beyond.label
        assert not end.is_open
    assert found.below.then == "z=2/2"


def test_a_range_that_ends_before_the_motion_is_open() -> None:
    orbit = stable(rigid(0.8))
    assert orbit is not None
    found = reach(orbit, "mean", (0.75, 0.85))
    assert (found.below.value, found.above.value) == (0.75, 0.85)
    assert found.below.is_open
    assert found.above.then is None
    assert found.value == 0.8


def test_an_unstable_motion_has_no_reach() -> None:
    orbit = orbit_near(rigid(0.6), [2.43], modes=0)
    assert orbit is not None
    with pytest.raises(ParameterError, match="stable"):
        reach(orbit, "mean", (0.5, 0.7))
