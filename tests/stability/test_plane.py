"""The vectorised plane against the orbits themselves, cell by cell, and B77's boundaries on it."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, steady_states
from percuss.errors import ParameterError
from percuss.stability import reduced_criterion, stability_plane
from strategies import Drawn, fourier_systems, square_systems


def same_as_the_orbits(system: System, m: int, r: np.ndarray, factor: np.ndarray) -> int:
    plane = stability_plane(system, r, factor, m)
    compared = 0
    for cell in np.ndindex(r.shape):
        one = system.with_restitution(float(r[cell])).with_load_factor(float(factor[cell]))
        found = steady_states(one, m)
        if found.note or any(orbit.fold for orbit in found.orbits):
            continue
        assert plane.level[cell] == pytest.approx(found.level, rel=1e-13)
        column = plane.phase[(slice(None), *cell)]
        order = np.flatnonzero(~np.isnan(column))
        order = order[np.argsort(column[order])]
        assert plane.roots[cell] == len(found.orbits) == order.size
        assert column[order] == pytest.approx([orbit.phase for orbit in found.orbits], abs=1e-7)
        for branch, orbit in zip(order, found.orbits, strict=True):
            at = (int(branch), *cell)
            reduced = reduced_criterion(orbit)
            size = max(1.0, *(abs(a) for a in reduced.a))
            loss = 1e-15 / max(abs(float(plane.slope[at])) / size, 1e-9) * 1e3  # at a fold the phase is lost first
            assert plane.sigma[at] == pytest.approx(reduced.sigma, abs=1e-10 * size + loss * size)
            assert [plane.a[(j, *at)] for j in range(3)] == pytest.approx(reduced.a, abs=1e-9 * size + loss * size)
            if min(abs(q - 1) for q in reduced.schur) > 1e-6:
                assert bool(plane.stable[at]) == reduced.stable
                assert [plane.schur[(j, *at)] for j in range(2)] == pytest.approx(reduced.schur, rel=1e-6, abs=1e-9)
            compared += 1
        missing = np.isnan(column)
        assert not plane.stable[(slice(None), *cell)][missing].any()
    return compared


CELLS = st.integers(0, 2**32 - 1)


def random_cells(seed: int, system: System) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    r = np.concatenate([[0.0, 1.0], rng.uniform(0, 1, 6)]).reshape(2, 4)
    return r, np.exp(rng.uniform(-4, 2, 8)).reshape(2, 4) * min(system.load.load_factor, 1e3)


@settings(max_examples=75)
@given(st.one_of(fourier_systems(1), fourier_systems(12), square_systems(16)), CELLS)
def test_every_cell_is_that_of_its_orbits(drawn: Drawn, seed: int) -> None:
    same_as_the_orbits(*drawn, *random_cells(seed, drawn.system))


def test_chunks_do_not_show() -> None:
    """More cells than one chunk holds, in an odd shape."""
    system = System(s=8.0, d=0.01, restitution=0.0, load=Load.fourier([0.5, 1.0, 0.3j]))
    r, factor = np.linspace(0, 0.99, 211)[:, None], np.linspace(0.01, 1.5, 317)[None, :]
    whole = stability_plane(system, r, factor)
    assert whole.phase.shape[1:] == whole.level.shape == whole.roots.shape == (211, 317)
    assert whole.a.shape[0] == 3
    assert whole.schur.shape[0] == 2
    part = stability_plane(system, r[[5, 200]], factor[:, ::40])
    for name in ("phase", "sigma", "slope", "stable"):
        ours, theirs = getattr(part, name), getattr(whole, name)[:, [5, 200]][:, :, ::40]
        assert np.array_equal(ours, theirs, equal_nan=True)


def test_boundaries_of_the_pneumatic_hammer() -> None:
    """Theory (38), (39): the fold above, the flip below, at any m and s."""
    for m in (1, 2, 5):
        for s in (0.9, 3.0, 1e6):
            r = np.linspace(0.02, 0.97, 25)
            x = 1 / s
            sigma = (1 - r) / (1 + r) * 0.5 * (x / math.sin(x) - 1)
            fold = (1 + r) / (math.pi * m * (1 - r))
            bend = 2 * (1 + r**2 + (1 - r**2) * sigma)
            flip = (1 + r) ** 2 / np.sqrt(bend**2 + (math.pi * m * (1 - r**2)) ** 2)
            system = System(s=s, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 1.0))
            for factor, roots in ((fold * (1 - 1e-9), 2), (fold * (1 + 1e-9), 0)):
                assert np.all(stability_plane(system, r, factor, m).roots == roots)
            assert np.all(flip < fold)
            for factor, stable in ((flip * (1 + 1e-9), True), (flip * (1 - 1e-9), False), (fold * (1 - 1e-9), True)):
                plane = stability_plane(system, r, factor, m)
                assert np.all(plane.stable.any(axis=0) == stable)
                falling = plane.slope < 0  # cos phi < 0
                assert not plane.stable[~falling].any()


def test_scalars_and_empty_planes() -> None:
    system = System(s=8.0, d=0.01, restitution=0.0, load=Load.harmonic(0.5, 1.0))
    assert stability_plane(system, 0.5, 0.3).roots.shape == ()
    assert stability_plane(system, np.zeros((0, 3)), 0.3).roots.shape == (0, 3)


def test_cells_that_do_not_push() -> None:
    system = System(s=8.0, d=0.0, restitution=0.0, load=Load.harmonic(0.5, 1.0))
    plane = stability_plane(system, np.array([0.0, 0.5, 1.0]), np.array([[-0.3], [0.0], [-1e300]]))
    assert np.all(plane.roots == 0)
    assert not plane.stable.any()


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        *(("restitution", (np.array(r), 0.5)) for r in ([0.5, 1.1], [-0.1], [math.nan], math.inf)),
        ("load_factor", (0.5, [0.5, math.nan])),
        ("periods", (0.5, 0.5, 0)),
    ],
)
def test_bad_planes(name: str, arguments: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        stability_plane(System(s=8.0, d=0.0, restitution=0.0, load=Load.harmonic(0.5, 1.0)), *arguments)
    assert caught.value.name == name
    with pytest.raises(ParameterError, match="alternating"):
        stability_plane(System(s=8.0, d=0.0, restitution=0.0, load=Load.fourier([1.0])), 0.5, 0.5)


@pytest.mark.slow
def test_a_million_cells_take_seconds_at_most() -> None:
    """The bench measures; this only catches an accident (a Python loop over cells would take minutes)."""
    system = System(s=20.0, d=0.0048, restitution=0.0, load=Load.harmonic(1.0, 1.0))
    start = time.perf_counter()
    plane = stability_plane(system, np.linspace(0, 1, 1000)[:, None], np.linspace(0.01, 2, 1000)[None, :])
    assert time.perf_counter() - start < 20
    assert plane.roots.shape == (1000, 1000)


def test_resolution_at_the_fold_of_many_harmonics() -> None:
    rng = np.random.default_rng(4)
    alternating = rng.normal(size=5) + 1j * rng.normal(size=5)
    system = System(s=8.0, d=0.01, restitution=0.5, load=Load.fourier([1.0, *alternating]))
    nearest = steady_states(system.with_load_factor(1e6)).nearest
    assert nearest is not None
    assume_below, above = nearest.load_factor * (1 - 1e-11), nearest.load_factor * (1 + 1e-11)
    assert stability_plane(system, 0.5, assume_below).roots == 2
    assert stability_plane(system, 0.5, above).roots == 0
