"""Maps, boundaries, experiments and basins of every body, law of damping and contact law."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, steady_states
from percuss.explore import Axis, basins, boundaries, experiment, sweep
from percuss.model import Kept, Reversed
from percuss.model.body import External, KelvinVoigt, Ratio, SteppedBar, UniformBar
from percuss.simulate import Stop
from percuss.stability import floquet_multipliers, reduced_criterion, stability_of
from percuss.steady.multipliers import NEUTRAL

HARMONIC = Load.harmonic(0.7, 1.0)
THREE = Load.fourier([0.6, 0.5 - 0.2j, 0.3j, 0.1])


def stepped(damping: Ratio | KelvinVoigt | External) -> SteppedBar:
    return SteppedBar(9.0, (2.0, 1.0, 1.4), (0.4, 0.5, 0.1), damping)


SYSTEMS = {
    "ratio": System(UniformBar(7.0, Ratio(0.01)), HARMONIC, Kept(0.5)),
    "kelvin-voigt, reversed": System(UniformBar(7.0, KelvinVoigt(1e-4)), THREE, Reversed(0.5)),
    "drag, reversed": System(UniformBar(6.0, External(0.05)), HARMONIC, Reversed(0.4)),
    "stepped": System(stepped(Ratio(0.01)), THREE, Kept(0.5)),
    "stepped, at a step": System(stepped(External(0.05)), HARMONIC.acting_at(1), Kept(0.5)),
}
each_system = pytest.mark.parametrize("name", SYSTEMS)


def varied(system: System, name: str, value: float) -> System:
    """Another way to the systems of a map than the table of parameters."""
    if name == "restitution":
        return system.with_restitution(value)
    return system.with_load_factor(value)


@each_system
def test_the_cells_of_a_plane_are_the_steady_motions_one_by_one(name: str) -> None:
    system = SYSTEMS[name]
    r, factor = np.array([0.2, 0.5, 0.8]), np.array([0.3, 0.8, 1.4, 5.0])
    axes = Axis("restitution", r), Axis("load_factor", factor)
    asked = ["orbits", "phases", "reduced_margin", "margin"]
    found = sweep(system, *axes, quantities=asked, modes=None, workers=1)
    for i, j in np.ndindex(r.size, factor.size):
        here = varied(varied(system, "restitution", r[i]), "load_factor", factor[j])
        assert here.contact == type(system.contact)(r[i]) and here.body == system.body
        orbits = steady_states(here).orbits
        assert found["orbits"][i, j] == len(orbits)
        phases = found["phases"][i, j]
        assert np.allclose(phases[~np.isnan(phases)], [orbit.phase for orbit in orbits], rtol=0, atol=1e-6)
        if orbits:
            reduced = max(1.0 - max(reduced_criterion(orbit).moduli) for orbit in orbits)
            exact = max(stability_of(orbit, modes=32).margin for orbit in orbits)
            assert found["reduced_margin"][i, j] == pytest.approx(reduced, abs=1e-6)
            assert found["margin"][i, j] == pytest.approx(exact, abs=1e-6)


@each_system
@pytest.mark.parametrize("y", ["load_factor", "restitution", "s"])
def test_folds_bound_the_steady_motions(name: str, y: str) -> None:
    """On one side of a fold there are two motions more than on the other."""
    system, m = SYSTEMS[name], 1
    low, high = {"load_factor": (0.05, 4.0), "restitution": (0.0, 0.95), "s": (4.0, 12.0)}[y]
    x = ("restitution", [0.3, 0.6]) if y != "restitution" else ("load_factor", [1.0, 1.6])
    found = boundaries(system, x, (y, low, high), m, kinds=("fold",))
    assert not found.failed
    counted = 0
    for curve in found.curves:
        for value, here in zip(curve.x.tolist(), curve.y.tolist(), strict=True):
            if not math.isfinite(here):
                continue
            counted += 1
            step = 1e-6 * (high - low)
            sides = [
                sweep(
                    system, Axis(x[0], np.array([value])), Axis(y, np.array([here + sign * step])),
                    quantities=["orbits"], workers=1,
                )["orbits"][0, 0]
                for sign in (-1.0, 1.0)
            ]  # fmt: skip
            assert abs(int(sides[0]) - int(sides[1])) == 2, (value, here, sides)
    assert counted or y == "s"


@each_system
@pytest.mark.parametrize("y", ["load_factor", "restitution"])
def test_flips_of_the_exact_map_have_a_multiplier_of_minus_one(name: str, y: str) -> None:
    system = SYSTEMS[name]
    x = ("restitution", [0.6]) if y == "load_factor" else ("load_factor", [0.7])
    span = (0.05, 2.5) if y == "load_factor" else (0.0, 0.95)
    found = boundaries(system, x, (y, *span), criterion="exact", modes=12, kinds=("flip",))
    assert not found.failed and (found.curves or y == "restitution")
    for curve in found.curves:
        for value, here, phase in zip(curve.x.tolist(), curve.y.tolist(), curve.phase.tolist(), strict=True):
            there = varied(varied(system, x[0], value), y, here)
            orbits = steady_states(there, modes=12).orbits
            nearest = min(orbits, key=lambda orbit: abs(math.remainder(orbit.phase - phase, 2.0 * math.pi)))
            assert abs(math.remainder(nearest.phase - phase, 2.0 * math.pi)) < 1e-6
            assert np.abs(floquet_multipliers(nearest, 12).values + 1.0).min() < 1e-5


@each_system
def test_starts_are_where_their_striking_end_is_said_to_be(name: str) -> None:
    system = SYSTEMS[name]
    found = basins(
        system, ("position", -1.0, -0.2, 3), ("u_2", -0.01, 0.01, 3), at={"velocity": 0.3}, modes=4,
        stop=Stop(impacts=60), workers=1,
    )  # fmt: skip
    u, gap = found.columns["start_displacement"], found.columns["position"]
    assert u.shape == (9, 3) and np.array_equal(np.unique(gap), [-1.0, -0.6, -0.2])
    assert np.array_equal(np.unique(u[:, 2]), [-0.01, 0.0, 0.01])
    end = u[:, 0] + system.body.driven_shapes(np.array([1.0]), 2, system.load.at).displacement @ u[:, 1:].T
    assert np.allclose(end, gap, atol=1e-15)
    assert (found.label != "").all()


@each_system
def test_an_experiment_ends_where_the_steady_motion_is(name: str) -> None:
    system = SYSTEMS[name].with_restitution(0.5)
    found = experiment(system, 20, "wall", seed=3, modes=6, stop=Stop(impacts=3000), workers=1)
    stable = [orbit for orbit in steady_states(system, modes=6).orbits if stability_of(orbit, modes=6).margin > NEUTRAL]
    settled = [share for share in found.shares if share.label == "z=1/1"]
    assert bool(settled) <= bool(stable)
    for share in settled:
        phases = [orbit.phase for orbit in stable]
        assert min(abs(math.remainder(share.phases[0] - phase, 2.0 * math.pi)) for phase in phases) < 1e-5
