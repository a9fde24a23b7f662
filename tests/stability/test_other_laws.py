"""A contact law is one file: laws that the package does not have, written by the contract alone, go through it all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from percuss import Load, Start, Stop, System, run, steady_states
from percuss.explore import Axis, boundaries, sweep
from percuss.model import External, Kept, Ratio, SteppedBar, UniformBar
from percuss.model.checks import Array
from percuss.model.contact import Contact, Result
from percuss.stability import reduced_criterion, stability_of, stability_plane, waveform_criterion
from percuss.steady import grows
from secular_roots import secular_roots

LOAD = Load.fourier([0.2, 1.0, 0.3j])
BODIES = [UniformBar(4.0, Ratio(0.01)), SteppedBar(5.0, (2.0, 1.0), (1.0, 2.0), External(0.05))]


@dataclass(frozen=True, init=False)
class Squared(Contact):
    """The velocity turns to −R² times itself, and the strain stays: B77's law under another name of R."""

    kind: ClassVar[str] = "squared"
    sentence: ClassVar[str] = "the impact leaves R² of the velocity"
    results: ClassVar[frozenset[Result]] = frozenset(Result)

    @property
    def strain_factor(self) -> float:
        return 1.0

    def velocity_factors(self, restitution: Any) -> Array:
        return -(np.asarray(restitution, dtype=float) ** 2)

    def restitutions_of(self, impedance_ratios: Any) -> Array:
        return np.sqrt(super().restitutions_of(impedance_ratios))


@dataclass(frozen=True, init=False)
class Halved(Squared):
    """The same law, which also takes half of the strain."""

    kind: ClassVar[str] = "halved"
    results: ClassVar[frozenset[Result]] = frozenset()

    @property
    def strain_factor(self) -> float:
        return 0.5


@pytest.mark.parametrize("body", BODIES, ids=str)
@pytest.mark.parametrize("r", [0.0, 0.3, 0.6])
def test_another_name_of_the_restitution_changes_nothing_but_the_name(body: Any, r: float) -> None:
    ours, theirs = System(body, LOAD, Squared(r)), System(body, LOAD, Kept(r**2))
    found, known = steady_states(ours).orbits, steady_states(theirs).orbits
    assert len(found) == len(known) == 2
    for one, other in zip(found, known, strict=True):
        assert one.phase == pytest.approx(other.phase, rel=1e-14)
        assert one.impact_velocity == pytest.approx(other.impact_velocity, rel=1e-14)
        assert one.delivered_energy == pytest.approx(other.delivered_energy, rel=1e-13)
        assert one.admissible == other.admissible
        assert stability_of(one).margin == pytest.approx(stability_of(other).margin, abs=1e-12)
        assert np.abs(reduced_criterion(one).moduli) == pytest.approx(np.abs(reduced_criterion(other).moduli))
        needed, square = waveform_criterion(one).restitution_needed, waveform_criterion(other).restitution_needed
        assert (needed is None) == (square is None)
        assert needed is None or square is None or needed**2 == pytest.approx(square)
    pushed = LOAD.with_mean(30.0)
    nearest, other_nearest = (steady_states(system.with_load(pushed)).nearest for system in (ours, theirs))
    assert nearest is not None and other_nearest is not None
    assert nearest.mean == pytest.approx(other_nearest.mean, rel=1e-14)


def test_the_restitution_that_is_missing_is_the_laws_own() -> None:
    """The motion that is found with it has the greatest level that there is."""
    system = System(UniformBar(20.0), Load.harmonic(0.9, 1.0), Squared(0.1))
    nearest = steady_states(system).nearest
    assert nearest is not None and nearest.restitution is not None
    assert not steady_states(system.with_restitution(nearest.restitution - 1e-9)).orbits
    assert len(steady_states(system.with_restitution(nearest.restitution + 1e-9)).orbits) == 2


def test_a_map_over_another_name_of_the_restitution() -> None:
    r, factor = np.array([0.0, 0.2, 0.4, 0.8, 1.0]), np.array([0.2, 0.5, 1.1])
    ours, theirs = (
        System(UniformBar(7.0, External(0.01)), Load.harmonic(0.4, 1.0), law(0.5)) for law in (Squared, Kept)
    )
    asked = {"quantities": ["orbits", "phases", "reduced_margin", "margin"], "workers": 1}
    found = sweep(ours, Axis("restitution", np.sqrt(r)), Axis("load_factor", factor), **asked)
    known = sweep(theirs, Axis("restitution", r), Axis("load_factor", factor), **asked)
    for name in asked["quantities"]:
        assert np.allclose(found[name], known[name], rtol=1e-9, atol=1e-12, equal_nan=True), name
    assert np.asarray(known["orbits"]).max() == 2


@pytest.mark.parametrize("kind", ["fold", "flip"])
def test_curves_over_another_name_of_the_restitution(kind: Any) -> None:
    ours, theirs = (
        System(UniformBar(7.0, External(0.01)), Load.harmonic(0.4, 1.0), law(0.5)) for law in (Squared, Kept)
    )
    found = boundaries(ours, ("load_factor", [0.7, 1.0, 1.4]), ("restitution", 0.05, 0.95), 1, kinds=(kind,))
    known = boundaries(theirs, ("load_factor", [0.7, 1.0, 1.4]), ("restitution", 0.05**2, 0.95**2), 1, kinds=(kind,))
    assert [curve.x.tolist() for curve in found.curves] == [curve.x.tolist() for curve in known.curves]
    assert found.curves and not found.failed
    for one, other in zip(found.curves, known.curves, strict=True):
        assert one.y**2 == pytest.approx(other.y, rel=1e-6, nan_ok=True)


def test_full_rebound_under_another_name() -> None:
    load = Load.fourier([0.3, 1.0, 0.5j])
    ours, theirs = System(UniformBar(20.0), load, Squared(1.0)), System(UniformBar(20.0), load, Kept(1.0))
    phases = [orbit.phase for orbit in steady_states(theirs, modes=0).orbits]
    assert grows(ours, phases).tolist() == grows(theirs, phases).tolist() == [True, True]
    assert not grows(ours.with_restitution(0.99), phases).any()


@pytest.mark.parametrize("body", BODIES, ids=str)
@pytest.mark.parametrize("r", [0.3, 0.6, 0.9])
def test_a_law_of_ones_own_moves_as_it_is_said_to(body: Any, r: float) -> None:
    """The simulation meets the steady motion, and energy closes."""
    orbits = [orbit for orbit in steady_states(System(body, LOAD, Halved(r)), modes=6).orbits if orbit.admissible]
    assert orbits
    for orbit in orbits:
        motion = run(orbit.system, Start.orbit(orbit), modes=6, stop=Stop(impacts=2, periodic=False))
        hits = motion.events.of("impact")
        assert hits.time[0] == pytest.approx(orbit.phase + orbit.period, rel=0.0, abs=1e-10)
        assert hits.impact_velocity[0] == pytest.approx(orbit.impact_velocity, rel=1e-10)
        assert abs(motion.energy_balance().imbalance) <= 1e-12 * hits.impact_velocity[0] ** 2
        matrix = orbit.linear_map(6)
        roots = secular_roots(matrix)
        assert roots.sum() == pytest.approx(np.trace(matrix.dense()), abs=1e-9 * max(1.0, np.abs(roots).max()))


def test_the_levels_of_a_plane_are_those_of_the_law() -> None:
    system = System(UniformBar(9.0), Load.harmonic(0.25, 1.0), Squared(0.5))
    plane = stability_plane(system, np.array([0.3, 0.7]), 0.25)
    for i, r in enumerate((0.3, 0.7)):
        phases = [orbit.phase for orbit in steady_states(system.with_restitution(r)).orbits]
        assert len(phases) == 2
        assert np.sort(plane.phase[:, i]) == pytest.approx(phases, abs=1e-9)
