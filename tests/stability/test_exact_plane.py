"""Exact multipliers over arrays, beside those of single orbits."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import strategies
from percuss import Load, System, steady_states
from percuss.errors import ConvergenceError, ParameterError, ResonanceError
from percuss.stability import exact_plane, floquet_multipliers, reduced_criterion, stability_of, stability_plane
from percuss.stability.plane import KINDS, OUTCOMES
from percuss.steady import Orbit
from percuss.steady.forced import forced_response
from percuss.steady.phases import level
from strategies import Drawn, fourier_systems, square_systems

PNEUMATIC = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))


def orbits(found, system, restitution, load_factor, periods=1):
    """Every root of a plane: its place, and the single orbit there."""
    r, factor = np.broadcast_arrays(restitution, load_factor)
    unit = abs(complex(system.load.coefficients[system.load.harmonics[0]]))
    for place in map(tuple, np.argwhere(~np.isnan(found.plane.phase))):
        cell = place[1:]
        load = system.load.with_mean(float(factor[cell] * unit))
        here = system.with_restitution(float(r[cell])).with_load(load)
        yield place, Orbit(here, periods, float(found.plane.phase[place]), bool(found.plane.fold[place]))


def single(orbit, modes):
    """The multipliers of one orbit, the worse of both sides, and how far rounding may move the largest."""
    sides = {float(orbit.system.load.value(orbit.phase, side)): side for side in ("left", "right")}
    worst = max((floquet_multipliers(orbit, modes, side=s) for s in sides.values()), key=lambda m: m.largest)
    blur = 0.0
    for side in sides.values():
        matrix = orbit.linear_map(modes, side).dense()
        values, right = np.linalg.eig(matrix)
        other, left = np.linalg.eig(matrix.T)
        i = int(np.argmax(np.abs(values)))
        x, y = right[:, i], left[:, int(np.argmin(np.abs(other - values[i])))]
        blur = max(blur, 1e-14 * float(np.linalg.norm(matrix)) / max(abs(complex(x @ y)), 1e-300))
        ringing = float(np.abs(np.delete(values, i) - 1.0).min(initial=1.0))
        blur = max(blur, 1e-14 / max(ringing, 1e-300))  # a hardly damped mode that the load drives rings by so much
    return worst, blur


systems = st.builds(
    System,
    s=st.floats(0.05, 200.0),
    d=st.sampled_from([0.0, 0.0, 1e-12, 1e-6, 0.0048, 0.1, 1.0, 5.0]),
    restitution=st.just(0.5),
    load=st.one_of(
        st.builds(Load.harmonic, st.just(1.0), st.just(1.0), st.integers(1, 3)),
        st.builds(
            lambda z: Load.fourier([1.0, 1.0, *z]),
            st.lists(st.complex_numbers(max_magnitude=2.0, allow_subnormal=False), min_size=1, max_size=3),
        ),
        st.builds(
            lambda gaps, values: Load.steps(np.cumsum(gaps), values, harmonics=16),
            st.lists(st.floats(0.1, 1.5), min_size=4, max_size=4),
            st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4, unique=True),
        ),
    ),
)


@settings(max_examples=75)
@given(
    system=systems,
    restitution=st.one_of(st.sampled_from([0.0, 1e-9, 0.999999, 1.0]), st.floats(0.0, 1.0)),
    load_factor=st.lists(st.floats(1e-3, 2.0), min_size=4, max_size=4),
    periods=st.integers(1, 10),
    modes=st.sampled_from([0, 1, 2, 5, 16, 24]),
)
def test_every_cell_is_like_the_single_orbit(system, restitution, load_factor, periods, modes):
    factor = np.array(load_factor)
    try:
        found = exact_plane(system, restitution, factor, periods, modes, workers=1)
    except ResonanceError:
        assume(False)
    assert not np.any(found.outcome == OUTCOMES.index("unsolved"))
    for place, orbit in orbits(found, system, np.array(restitution), factor, periods):
        if OUTCOMES[found.outcome[place]] == "grows":
            assert restitution == 1.0 and system.d == 0.0
            continue
        expected, blur = single(orbit, modes)
        assert abs(found.largest[place] - expected.largest) <= max(1e-9, blur) * max(1.0, expected.largest)


@settings(max_examples=50)
@given(drawn=st.one_of(strategies.fourier_systems(), strategies.square_systems(harmonics=16)), modes=st.integers(0, 20))
def test_every_system_is_like_its_single_orbits(drawn, modes):
    system, periods = drawn
    factor = system.load.load_factor * np.array([0.3, 1.0])
    try:
        found = exact_plane(system, system.restitution, factor, periods, modes, workers=1)
    except ResonanceError:
        assume(False)
    for place, orbit in orbits(found, system, np.array(system.restitution), factor, periods):
        if OUTCOMES[found.outcome[place]] == "done":
            expected, blur = single(orbit, modes)
            assert abs(found.largest[place] - expected.largest) <= max(1e-9, blur) * max(1.0, expected.largest)
        else:
            assert OUTCOMES[found.outcome[place]] == "grows"


def test_verdicts_kinds_and_modes_are_those_of_single_orbits():
    r, factor = np.linspace(0.05, 0.9, 7)[:, None], np.linspace(0.05, 1.0, 9)
    seen = set()
    for s, modes in ((0.7, 8), (5.0, 8), (20.0, 0), (20.0, 8)):
        system = System(s=s, d=0.01, restitution=0.6, load=PNEUMATIC.load)
        found = exact_plane(system, r, factor, modes=modes)
        kinds = found.kind
        for place, orbit in orbits(found, system, r, factor):
            verdict = stability_of(orbit, modes=modes)
            first = complex(verdict.multipliers.values[0])
            assert found.stable[place] == verdict.stable
            assert found.margin[place] == pytest.approx(verdict.margin, abs=1e-9)
            kind = KINDS[kinds[place]]
            seen.add(kind)
            if not verdict.stable and "elastic mode" in verdict.reason:
                assert kind == "elastic" and f"mode {found.mode[place]} " in verdict.reason
            if "beyond the fold" in verdict.reason and verdict.multipliers.dominant_mode == 0:
                assert kind == "rigid, real +"
            if verdict.reason.startswith("flip") and verdict.multipliers.dominant_mode == 0:
                assert kind == "rigid, real −"
            if kind == "rigid, complex":
                assert abs(first.imag) > 1e-6 * abs(first)
                assert found.multiplier[place].imag == pytest.approx(first.imag, abs=1e-9)
    assert seen == set(KINDS[1:])


def test_many_modes_are_the_secular_roots():
    found = exact_plane(PNEUMATIC.uniform(s=5.0), 0.6, np.array([0.45, 0.9]), modes=200)
    for place, orbit in orbits(found, PNEUMATIC.uniform(s=5.0), np.array(0.6), np.array([0.45, 0.9])):
        assert found.largest[place] == pytest.approx(floquet_multipliers(orbit, 200).largest, rel=1e-9)


def test_known_elastic_instability():
    """Theory §5: stable by B77's criterion, and not."""
    system = System(s=5.0, d=0.0, restitution=0.8, load=Load.harmonic(0.9, 1.0))
    found = exact_plane(system, 0.8, 0.9, periods=2, modes=8)
    upper = found.plane.stable
    assert upper.sum() == 1 and not found.stable.any()
    assert found.largest[upper][0] == pytest.approx(1.000147, abs=5e-7)
    assert found.mode[upper][0] > 0


def test_the_worse_side_of_a_jump_decides():
    system = System(s=3.0, d=0.05, restitution=0.4, load=Load.steps([0.5, 2.0, 3.0, 4.5], [1.5, 0.2, -1.0, -0.4]))
    response = forced_response(replace(system, load=system.load.with_mean(0.0)))
    period = 2.0 * math.pi
    unit = abs(complex(system.load.coefficients[1]))
    tried = 0
    for i in (1, 3):  # v_f is monotone across these jumps
        velocity = float(response.knot_velocity[i])
        if velocity <= 0.0:
            continue
        factor = velocity / float(level(1.0, system.d, 0.4, period)) / unit
        found = exact_plane(system, 0.4, factor, modes=6)
        for place, orbit in orbits(found, system, np.array(0.4), np.array(factor)):
            verdict = stability_of(orbit, modes=6)
            assert found.largest[place] == pytest.approx(verdict.multipliers.largest, rel=1e-9)
            tried += verdict.reduced.other_side is not None
    assert tried


def test_a_fold_is_not_stable():
    system = System(s=20.0, d=0.0, restitution=0.5, load=Load.harmonic(1.0, 1.0))
    edge = 1.5 / (math.pi * 0.5)
    factors = edge * (1.0 + np.arange(-8, 1) * 2.0**-52)
    found = exact_plane(system, 0.5, factors)
    assert found.plane.fold.any() and not found.stable.any()
    near = exact_plane(system, 0.5, 0.9 * edge)
    assert not near.plane.fold.any() and near.stable.any()


def test_no_motion_and_none_that_lasts():
    system = System(s=3.0, d=0.0, restitution=0.5, load=Load.fourier([0.5, 1.0, 0.4j]))
    found = exact_plane(system, [[0.5], [1.0]], [-1.0, 0.0, 0.3, 50.0])
    assert np.isnan(found.largest[..., [0, 1]]).all() and np.all(found.mode[..., [0, 1]] == -1)
    assert not found.stable[..., 0].any() and np.all(found.kind[..., 0] == 0)
    words = np.array(OUTCOMES)[found.outcome]
    assert np.all(words[:, 1, 2][~np.isnan(found.plane.phase[:, 1, 2])] == "grows")
    alone = steady_states(system.with_restitution(1.0).with_load_factor(0.3))
    assert not alone.orbits and "grows" in alone.note
    assert "done" in words[:, 0, 2] and "unsolved" not in words
    empty = exact_plane(system, np.empty(0), 0.3)
    assert empty.largest.shape[1:] == (0,)


def test_a_cell_that_cannot_be_solved_is_a_value(monkeypatch):
    def fails(*arguments, **more):
        raise ConvergenceError("crowded")

    from percuss.steady import secular_kernels as exact_kernels

    solved = exact_plane(PNEUMATIC, 0.6, 0.9)
    monkeypatch.setattr(exact_kernels, "largest_multipliers", lambda *a: a[-1].fill(-1))
    alone = exact_plane(PNEUMATIC, 0.6, 0.9)
    np.testing.assert_allclose(alone.largest, solved.largest, rtol=1e-11)
    monkeypatch.setattr(Orbit, "multipliers", fails)
    found = exact_plane(PNEUMATIC, 0.6, 0.9)
    assert np.all(found.outcome == OUTCOMES.index("unsolved")) and np.isnan(found.largest).all()
    assert not found.stable.any() and np.all(found.kind == 0)


def test_threads_and_portions_do_not_show():
    r, factor = np.linspace(0.0, 0.9, 60)[:, None], np.linspace(0.01, 1.0, 120)
    plane = stability_plane(PNEUMATIC, r, factor)
    assert plane.roots.sum() > 2 * 4096
    one, two = exact_plane(PNEUMATIC, r, factor, workers=1), exact_plane(PNEUMATIC, r, factor, plane=plane, workers=3)
    few = exact_plane(PNEUMATIC, r[7:9], factor)
    for name in ("multiplier", "mode", "outcome"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
        np.testing.assert_array_equal(getattr(one, name)[:, 7:9], getattr(few, name))


@pytest.mark.parametrize(
    ("arguments", "more"),
    [
        ((PNEUMATIC, 1.2, 0.5), {}),
        ((PNEUMATIC, 0.5, 0.5), {"modes": -1}),
        ((PNEUMATIC, 0.5, 0.5), {"modes": 5000}),
        ((PNEUMATIC, 0.5, 0.5), {"workers": 0}),
        ((PNEUMATIC, 0.5, 0.5), {"plane": stability_plane(PNEUMATIC, [0.5, 0.6], 0.5)}),
        ((PNEUMATIC, 0.5, 0.5), {"plane": 3}),
        (("system", 0.5, 0.5), {}),
    ],
)
def test_nonsense_is_refused(arguments, more):
    with pytest.raises(ParameterError):
        exact_plane(*arguments, **more)


# -- the plane of the reduced criterion --------------------------------------------------------------------------------


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


def test_a_blow_that_loses_nothing_is_neutral_where_nothing_drags() -> None:
    system = System(s=20.0, d=0.0, restitution=1.0, load=Load.harmonic(1.2, 1.0))
    plane = stability_plane(system, 1.0, 1.2)
    assert np.all(plane.schur[0] == 1.0)
    assert (plane.schur[1] < 1.0).any()
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
