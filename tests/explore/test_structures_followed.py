"""Structures that are held, over two parameters and in diagrams: Budd & Dux's oscillator (Phil. Trans. R. Soc. A 347
(1994) 365–389)."""

import numpy as np
import pytest

from percuss.explore import BranchEvent, follow, follow_point
from percuss.explore.diagrams.diagram_job import running_pass
from percuss.model import Kept, Load, ModalBody, System
from percuss.simulate import Stop
from percuss.steady import orbits

OMEGA = 2.8


def oscillator(restitution: float, gap: float) -> System:
    body = ModalBody((1.0 / OMEGA,), (0.0,), (1.0,), (1.0,), gap)
    return System(body, Load.harmonic(0.0, 1.0 / OMEGA**2), Kept(restitution))


def flip(restitution: float):
    branch = follow(orbits(oscillator(restitution, -0.1), 1, 1).orbits[0], "gap", (-0.2, 0.0))
    (found,) = branch.at(BranchEvent.FLIP)
    return found


def test_the_curve_of_flips_goes_through_those_of_other_restitutions():
    curve = follow_point(flip(0.8), ("gap", "restitution"), ((-0.2, 0.0), (0.72, 0.84)))
    assert [one.kind for one in curve.ends] == [BranchEvent.LIMIT] * 2
    assert [one.values[1] for one in curve.ends] == pytest.approx([0.72, 0.84])
    assert curve.is_orbit.all()
    for gap, restitution in (curve.values[0], curve.values[3]):
        assert gap == pytest.approx(flip(restitution).value, abs=1e-10)


def test_a_death_keeps_its_gap_whatever_the_restitution():
    """An impact without speed turns nothing over: the motion there is the free one, which knows no restitution."""
    branch = follow(orbits(oscillator(0.8, -0.1), 1, 1).orbits[0], "gap", (-0.2, 0.3))
    (death,) = branch.at(BranchEvent.DEATH)
    swing = 1.0 / (OMEGA**2 - 1.0)
    assert death.value == pytest.approx(swing, abs=1e-11)
    curve = follow_point(death, ("gap", "restitution"), ((-0.2, 0.3), (0.72, 0.84)))
    assert curve.values[:, 0] == pytest.approx(swing, abs=1e-10)
    assert sorted(one.values[1] for one in curve.ends) == pytest.approx([0.72, 0.84])


def test_a_motion_taken_along_meets_the_wall_of_each_gap():
    """Its cycles are orbits of the system of their own gap, not of the one it began with."""
    systems = [oscillator(0.8, gap) for gap in (-0.1, -0.095, -0.09)]
    taken = running_pass(systems, 1, Stop(impacts=3000), 0, 0.0, 0, lambda: False)
    for row, system in enumerate(systems):
        p, n = int(taken["cycle_impacts"][row]), int(taken["cycle_periods"][row])
        assert 1 <= p <= 3 and n <= 3
        phases = np.sort(taken["phases"][row][:p])
        known = [np.sort(orbit.phases) for orbit in orbits(system, p, n, tries=100).orbits]
        assert min(float(np.abs(phases - other).max()) for other in known) < 1e-5
