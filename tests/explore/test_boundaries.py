"""Boundaries: closed forms, independent roots in many digits, signs on both sides, and simulation on both sides."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp

import naive
from percuss import Load, Start, Stop, System, run, stability_of, steady_states
from percuss.errors import ParameterError
from percuss.explore.boundary_curves.boundary import KINDS, Boundaries, BoundaryCurve, boundaries, exact_crossings
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import Line, bracketed_roots, orbit_on, roots_on
from percuss.explore.family import Axis, SystemFamily
from percuss.explore.jobs.progress import JobProgress
from percuss.explore.parameters import vary
from percuss.halting import halting
from percuss.stability import floquet_multipliers, reduced_criterion, stability_plane
from percuss.steady import Orbit, PeriodicOrbit, Reason
from percuss.steady.flight import flight_check, stays_off, tops
from strategies import oracle

R = np.linspace(0.0, 0.9, 31)
RHO = (1.0 - R) / (1.0 + R)
STIFF = 1e7
WAVY = Load.fourier([1.0, 1.0, 0.5 - 0.3j, 0.25j])


def pneumatic(s: float = STIFF, d: float = 0.0, r: float = 0.5) -> System:
    return System(s=s, d=d, restitution=r, load=Load.harmonic(0.9, 1.0))


def square(d: float = 0.0) -> System:
    return System(s=STIFF, d=d, restitution=0.5, load=Load.square(1.0, 1.3, 8))


def only(found: Boundaries, kind: str) -> BoundaryCurve:
    (curve,) = found.of(kind)
    return curve


def beside(
    curve: BoundaryCurve, system: System, name: str, step: float = 0.0, i: int = 0, m: int = 1, **asked
) -> Orbit:
    """The steady motion nearest in phase to point `i` of a curve, where y is a step more."""
    here = vary(system, {name: float(curve.y[i]) + step})
    phase = float(curve.phase[i])
    return min(
        steady_states(here, m, **asked).orbits, key=lambda o: abs(math.remainder(o.phase - phase, 2.0 * math.pi))
    )


def error(found: object, expected: object) -> float:
    return float(np.max(np.abs(np.asarray(found) / np.asarray(expected) - 1.0)))


# ---------------------------------------------------------------- roots


def test_roots_of_many_brackets_at_once():
    low, high = np.array([0.0, 2.0]), np.array([2.0, 5.0])
    found = bracketed_roots(np.cos, low, high, np.cos(low), np.cos(high))
    assert error(found, np.pi * np.array([0.5, 1.5])) < 1e-15
    roots = [roots_on(lambda x, a=a: x**3 - a, np.linspace(-1.0, 3.0, 7)) for a in (0.1, 1.7, 5.0)]
    assert error([float(r[0]) for r in roots], np.cbrt([0.1, 1.7, 5.0])) < 1e-14


def test_two_roots_between_two_nodes_and_poles():
    nodes = np.linspace(0.0, 1.0, 8)
    close = roots_on(lambda x: (x - 0.51) ** 2 - 1e-4, nodes)
    assert close == pytest.approx([0.5, 0.52], abs=1e-14)
    assert roots_on(lambda x: (x - 0.51) ** 2 + 1e-4, nodes).size == 0
    pole = 0.51
    assert roots_on(lambda x: 1.0 / np.where(x == pole, 1e-300, x - pole), nodes).size == 0
    assert roots_on(lambda x: x - nodes[3], nodes) == pytest.approx([nodes[3]], abs=1e-15)


# ---------------------------------------------------------------- closed forms of theory §§6, 7


@pytest.mark.parametrize("m", [1, 2, 10])
@pytest.mark.parametrize("s", [STIFF, 1.01 / math.pi, 0.7])
def test_pneumatic_range(m, s):
    found = boundaries(pneumatic(s), ("restitution", R), ("load_factor", 0.0, 8.0), m, kinds=("fold", "flip"))
    sigma = RHO * 0.5 * ((1.0 / s) / math.sin(1.0 / s) - 1.0)
    lower = (1 + R) ** 2 / np.sqrt(4 * (1 + R**2 + (1 - R**2) * sigma) ** 2 + (np.pi * m * (1 - R**2)) ** 2)
    assert error(only(found, "fold").y, (1 + R) / (np.pi * m * (1 - R))) < 1e-12
    assert error(only(found, "flip").y, lower) < 1e-12
    assert np.all(np.cos(only(found, "flip").phase) < 0.0)
    for curve in found.curves:
        assert curve.found.all() and curve.residual.max() < 1e-13
    data = found.to_xarray()
    assert data["kind"].values.tolist() == ["fold", "flip"] and data["y"].dims == ("curve", "restitution")
    assert np.array_equal(data["y"], [curve.y for curve in found.curves])


@pytest.mark.parametrize("m", [1, 2])
def test_hydraulic_limit(m):
    found = boundaries(square(), ("restitution", R), ("kappa", 1.0 + 1e-6, 2.0 - 1e-6), m, kinds=("fold",))
    assert error(only(found, "fold").y, (1 - m * RHO) + np.sqrt(1 + (m * RHO) ** 2)) < 1e-12
    assert np.allclose(only(found, "fold").phase, np.pi * only(found, "fold").y, rtol=0, atol=1e-12)


def test_hydraulic_has_no_flip():
    found = boundaries(
        square(), ("restitution", [0.0, 0.4, 0.8]), ("kappa", 1.01, 1.98), kinds=("flip", "neimark-sacker")
    )
    assert found.curves == ()


def test_spiral_of_the_reduced_criterion():
    """A pair of roots passes the unit circle, |ξ|² = a_0/a_2 = 1: needs several harmonics and a soft bar."""
    load = Load.fourier([1.0, 0.59 - 0.82j, 0.89 + 0.73j, 0.32 - 0.5j])
    system = System(s=0.42, d=0.01, restitution=0.77, load=load)
    curve = only(
        boundaries(system, ("s", [0.42]), ("load_factor", 0.0, 5.0), kinds=("neimark-sacker",)), "neimark-sacker"
    )
    sides = [beside(curve, system, "load_factor", step) for step in (-1e-9, 0.0, 1e-9)]
    moduli = [reduced_criterion(orbit).moduli for orbit in sides]
    assert moduli[1] == pytest.approx((1.0, 1.0), abs=1e-12)
    assert (moduli[0][0] - 1.0) * (moduli[2][0] - 1.0) < 0.0
    assert 0.0 < float(curve.angle[0]) < math.pi


def test_no_spiral_under_one_harmonic():
    """(1/s)/sin(1/s) never is −1, hence |a_0/a_2| < 1 as long as a_2 > 0: one harmonic has fold and flip alone."""
    found = boundaries(pneumatic(), ("s", [0.2, 0.25, 0.6]), ("load_factor", 0.0, 5.0), kinds=("neimark-sacker",))
    assert found.curves == ()


@pytest.mark.parametrize(("r", "ratio"), [(0.2, 2.544192), (0.5, 1.526824), (0.8, 1.070836)])
def test_known_thresholds(r, ratio):
    found = boundaries(pneumatic(), ("restitution", [r]), ("load_factor", 0.0, 3.0), kinds=("flip",))
    assert 1.0 / float(found.greatest("flip")[0]) == pytest.approx(ratio, abs=5e-7)


# ---------------------------------------------------------------- damping: roots in many digits


@pytest.mark.parametrize("d", [0.03 / (2 * math.pi), 0.4])
@pytest.mark.parametrize("m", [1, 3])
def test_damped_range_against_mpmath(d, m):
    restitution = [0.0, 0.35, 0.9]
    plane = ("restitution", restitution), ("load_factor", 0.0, 8.0), m
    found = boundaries(pneumatic(d=d), *plane, kinds=("fold", "flip"))
    with mp.workdps(30):
        d, t = mp.mpf(d), 2 * mp.pi * m
        e = mp.exp(-d * t)
        for i, r in enumerate(map(mp.mpf, restitution)):
            level = t * (1 + r * e) / ((1 + r) * (1 - e)) - 1 / d  # c/p_0

            def factor(phase, level=level):
                return mp.re(mp.expj(phase) / (d + 1j)) / level

            def flip(phase, r=r, factor=factor):  # a_2 − a_1 + a_0 with σ = 0
                slope = mp.re(1j * mp.expj(phase) / (d + 1j)) / factor(phase)
                return 2 + 2 * r**2 * e + (1 - e) / (d * t) * (1 + r) ** 2 * slope

            phase = mp.findroot(flip, (mp.mpf("1.6"), mp.atan2(1, d) + mp.pi / 2 - mp.mpf("1e-9")), solver="ridder")
            assert float(found.greatest("flip")[i]) == pytest.approx(float(factor(phase)), rel=1e-12)
            fold = 1 / mp.sqrt(1 + d**2) / level
            assert float(found.greatest("fold")[i]) == pytest.approx(float(fold), rel=1e-12)


def test_damped_hydraulic_limit_against_mpmath():
    d = 0.03 / (2 * math.pi)
    found = boundaries(square(d), ("restitution", [0.0, 0.5, 0.9]), ("kappa", 1.01, 1.999), kinds=("fold",))
    with mp.workdps(30):
        for r, kappa in zip([0.0, 0.5, 0.9], found.greatest("fold"), strict=True):

            def excess(k, r=r):
                case = naive.Case.of(naive.Square.of(1, k), 1, d, r, 1)
                return naive.v_f(case, k * mp.pi) - naive.level(case)

            root = mp.findroot(excess, (mp.mpf(float(kappa)) - 1e-3, mp.mpf(float(kappa)) + 1e-3), solver="anderson")
            assert float(kappa) == pytest.approx(float(root), abs=1e-12)


# ---------------------------------------------------------------- any load, any parameter: both sides of each point


def test_every_fold_of_a_general_load_changes_the_number_of_motions():
    system = System(s=8.0, d=0.05, restitution=0.0, load=WAVY)
    found = boundaries(system, ("restitution", [0.1, 0.6]), ("load_factor", 0.0, 5.0), kinds=("fold",))
    assert len(found.curves) >= 1
    for curve in found.curves:
        for r, y in zip(curve.x, curve.y, strict=True):
            below, above = (int(stability_plane(system, r, y * (1 + step)).roots) for step in (-1e-11, 1e-11))
            assert abs(below - above) == 2


@pytest.mark.parametrize(
    ("system", "x", "y"),
    [
        (System(s=2.0, d=0.02, restitution=0.3, load=WAVY), ("d", [0.0, 0.3]), ("load_factor", 0.0, 3.0)),
        (System(s=2.0, d=0.02, restitution=0.3, load=WAVY), ("load_factor", [0.4]), ("restitution", 0.0, 0.95)),
        (System(s=2.0, d=0.02, restitution=0.3, load=WAVY), ("mean", [0.5]), ("amplitude", 0.2, 4.0)),
        (System(s=2.0, d=0.02, restitution=0.3, load=WAVY), ("s", [0.9, 3.0]), ("mean", 0.05, 3.0)),
        (System(s=2.0, d=0.02, restitution=0.3, load=WAVY.with_mean(0.43)), ("amplitude", [1.0]), ("d", 0.0, 0.5)),
        (System(s=2.0, d=0.02, restitution=0.8, load=Load.harmonic(0.907, 1.0)), ("d", [0.01]), ("s", 0.4, 3.0)),
        (
            System(s=30.0, d=0.1, restitution=0.2, load=Load.steps([0, 1, 2.4, 4], [1.22, 0.38, -0.88, -1.51], 40)),
            ("restitution", [0.15, 0.2]),
            ("load_factor", 0.02, 2.0),
        ),
    ],
)
def test_flips_have_a_sign_on_either_side(system, x, y):
    found = boundaries(system, x, y, kinds=("fold", "flip"))
    points = 0
    for curve in found.of("flip"):
        assert np.nanmax(curve.residual) < 1e-10
        for i in np.flatnonzero(curve.found):
            base = vary(system, {x[0]: float(curve.x[i])})
            sides = []
            for step in (-1e-9, 1e-9):
                a_0, a_1, a_2 = reduced_criterion(beside(curve, base, y[0], step, i)).a
                sides.append(a_2 - a_1 + a_0)
            assert sides[0] * sides[1] < 0.0, (curve.kind, curve.x[i], curve.y[i], sides)
            points += 1
    assert points > 0


def test_the_same_curve_by_another_parameter():
    """Swapping the axes, or moving another parameter, comes back to the same points."""
    system = System(s=0.9, d=0.05, restitution=0.4, load=WAVY)
    for kind in ("fold", "flip"):
        y = float(
            boundaries(system, ("restitution", [0.4]), ("load_factor", 0.0, 3.0), kinds=(kind,)).greatest(kind)[0]
        )
        ranges = {"restitution": (0.3, 0.5), "d": (0.0, 0.1), "amplitude": (0.8, 1.2), "s": (0.8, 1.0)}
        for name, (low, high) in ranges.items():
            here = vary(system, {"load_factor": y})
            if name == "s" and kind == "fold":
                continue  # folds do not depend on s
            fixed = ("mean", [here.load.mean]) if name == "amplitude" else ("load_factor", [y])
            found = boundaries(here, fixed, (name, low, high), kinds=(kind,))
            ys = np.concatenate([curve.y for curve in found.of(kind)])
            expected = {"restitution": 0.4, "d": 0.05, "amplitude": 1.0, "s": 0.9}[name]
            assert np.min(np.abs(ys - expected)) < 1e-10, (kind, name, ys)


def test_load_periods_as_a_parameter():
    found = boundaries(pneumatic(), ("m", [1, 2, 5]), ("load_factor", 0.0, 2.0), kinds=("fold",))
    assert error(found.greatest("fold"), 3.0 / (np.pi * np.array([1, 2, 5]))) < 1e-14


# ---------------------------------------------------------------- the exact map


@pytest.mark.parametrize(("s", "d", "m"), [(1.3, 0.05, 1), (0.9, 0.0048, 1), (4.9, 0.0, 2)])
def test_exact_crossings_in_fifty_digits(s, d, m):
    system = pneumatic(s, d, 0.5 if m == 1 else 0.8)
    plane = ("s", [s]), ("load_factor", 0.2, 1.4), m
    found = boundaries(system, *plane, criterion="exact", modes=5, kinds=("flip", "neimark-sacker"))
    assert found.curves
    for curve in found.curves:
        here = vary(system, {"load_factor": float(curve.y[0])})
        values = naive.multipliers(naive.orbit(oracle(here, m), mp.mpf(float(curve.phase[0])), 5))
        wanted = np.exp(1j * float(curve.angle[0]))
        assert np.min(np.abs(values - wanted)) < 1e-8
        assert curve.residual[0] < 1e-11

        sizes = []
        for step in (-1e-6, 1e-6):
            near = floquet_multipliers(beside(curve, system, "load_factor", step, m=m, modes=5), 5).values
            sizes.append(float(np.abs(near[np.argmin(np.abs(near - wanted))])) - 1.0)
        assert sizes[0] * sizes[1] < 0.0


def test_exact_and_reduced_flips_meet_for_stiff_bars():
    plane = ("restitution", [0.2, 0.6]), ("load_factor", 0.0, 2.0)
    reduced = boundaries(pneumatic(37.3, 0.05), *plane, kinds=("flip",))
    exact = boundaries(pneumatic(37.3, 0.05), *plane, criterion="exact", modes=6, kinds=("flip",))
    assert error(exact.greatest("flip"), reduced.greatest("flip")) < 2e-3
    rigid = boundaries(pneumatic(d=0.05), *plane, criterion="exact", modes=0, kinds=("flip",))
    assert (
        error(rigid.greatest("flip"), boundaries(pneumatic(d=0.05), *plane, kinds=("flip",)).greatest("flip")) < 1e-11
    )


N = 8


def as_orbit(motion: Orbit) -> PeriodicOrbit:
    """A steady motion told as an orbit with one impact, whose multipliers share no code with the boundaries."""
    return PeriodicOrbit(motion.system, motion.periods, (motion.phase,), N)


@pytest.mark.parametrize(
    ("s", "r", "m"), [(5.0, 0.8, 2), (1.05, 0.58, 2), (0.71, 0.66, 2), (3.1, 0.52, 2), (2.0, 0.5, 1)]
)
def test_a_crossing_is_what_it_is_called(s, r, m):
    found = boundaries(pneumatic(s, 0.0, r), ("s", [s]), ("load_factor", 0.2, 1.3), m, "exact", modes=N,
                       kinds=("flip", "neimark-sacker"))  # fmt: skip
    assert found.curves
    for curve in found.curves:
        there = vary(pneumatic(s, 0.0, r), {"load_factor": float(curve.y[0])})
        orbit = PeriodicOrbit(there, m, (float(curve.phase[0]),), N)
        values = orbit.multipliers().values
        angle = float(curve.angle[0])
        turning = values[np.abs(values.imag) > 1e-6]
        if curve.kind == "flip":
            assert np.abs(values + 1.0).min() < 1e-8
        else:
            assert np.abs(turning - np.exp(1j * angle)).min() < 1e-8
        scale = np.prod(1.0 + np.abs(values))
        assert abs(orbit.characteristic(complex(np.exp(1j * angle)))) < 1e-10 * scale
        outside = np.count_nonzero(np.abs(values) > 1.0 + 1e-7)
        assert outside == curve.outside[0]


def test_elastic_instability_that_b77_cannot_see():
    """Theory §5: between two crossings of pairs an elastic mode flips; at d = 0 by −1.000147, and damping holds it."""
    system = pneumatic(5.0, 0.0, 0.8)
    found = boundaries(system, ("s", [5.0]), ("load_factor", 0.7, 1.2), 2, "exact", modes=N, kinds=("neimark-sacker",))
    assert found.curves
    orbit = steady_states(system, 2, modes=N).orbits[-1]
    verdict = stability_of(orbit, modes=N)
    assert verdict.reduced.stable and verdict.kind is Reason.ELASTIC
    assert "turns over and grows by a factor of 1.000147" in verdict.reason
    assert as_orbit(orbit).multipliers().values[0] == pytest.approx(-1.000147, abs=5e-7)
    for d, sign in ((2.337e-5, 1), (2.339e-5, -1)):
        values = as_orbit(steady_states(pneumatic(5.0, d, 0.8), 2, modes=N).orbits[-1]).multipliers()
        assert math.copysign(1.0, values.largest - 1.0) == sign and values.values[0].imag == 0.0


def test_what_b77_cannot_see_are_flips_of_elastic_modes():
    """Undamped, under one harmonic: motions that B77's criterion calls stable and an elastic mode makes unstable."""
    random, flips, pairs = np.random.default_rng(5), 0, 0
    for _ in range(300):
        s, r = float(10.0 ** random.uniform(-0.2, 1.3)), float(random.uniform(0.2, 0.97))
        system, m = (
            vary(pneumatic(s, 0.0, r), {"load_factor": float(random.uniform(0.2, 1.3))}),
            int(random.integers(1, 4)),
        )
        for motion in steady_states(system, m, modes=N).orbits:
            if stability_of(motion, modes=N).kind is Reason.ELASTIC:
                values = as_orbit(motion).multipliers().values
                outside = values[np.abs(values) > 1.0 + 1e-10]
                assert outside.size
                real = bool(np.all(np.abs(outside.imag) < 1e-6))
                flips, pairs = flips + (real and bool(np.all(outside.real < 0.0))), pairs + (not real)
    assert flips > 3
    assert pairs <= 0.2 * flips


def outside(stretch, t: float, modes: int) -> int:
    """How many multipliers are outside the circle at a place of a branch: all eigenvalues of the dense map."""
    orbit, side = orbit_on(stretch, t)
    return int(np.count_nonzero(np.abs(np.linalg.eigvals(orbit.linear_map(modes, side).dense())) > 1.0))


def crossings_and_misses(seed: int, systems: int, places: int) -> tuple[int, list[str]]:
    """Changes of the number of multipliers outside the circle on a dense scan, and those that were not solved for.

    Random systems with up to twelve harmonics, three modes, R, d and s over their ranges.
    """
    rng = np.random.default_rng(seed)
    seen, missed = 0, []
    for _ in range(systems):
        harmonics = int(rng.integers(1, 13))
        waves = (rng.normal(size=harmonics) + 1j * rng.normal(size=harmonics)) / np.sqrt(np.arange(1, harmonics + 1))
        s, d = float(10 ** rng.uniform(-0.3, 1.3)), float(10 ** rng.uniform(-3, -0.5))
        r, m = float(rng.uniform(0, 0.95)), int(rng.choice([1, 1, 2]))
        system = System(s, d, r, Load.fourier(np.array([0.3, *waves])))
        line = Line(SystemFamily(system), {"restitution": r}, "load_factor", 0.0, 2.0, m, 2)
        for stretch in folds_and_stretches(line, 33)[1]:
            phases = np.array([crossing.phase for crossing in exact_crossings(stretch, None, 2)])
            found = np.mod(phases - stretch.start, 2.0 * math.pi) / (stretch.stop - stretch.start)
            nodes = np.linspace(1e-6, 1.0 - 1e-6, places)
            counts = [outside(stretch, float(t), 2) for t in nodes]
            for i in np.flatnonzero(np.diff(counts)):
                seen += 1
                if not np.any((found >= nodes[i] - 1e-8) & (found <= nodes[i + 1] + 1e-8)):
                    missed.append(f"{system!r}, m = {m}, t = {nodes[i]}: {counts[i]} to {counts[i + 1]}")
    return seen, missed


def test_flips_beside_a_striking_speed_of_zero_are_found():
    """There the secular function has a pole, which once hid the root between the same two samples."""
    seen, missed = crossings_and_misses(1, 3, 401)
    assert seen > 8 and missed == []


@pytest.mark.slow
def test_no_crossing_of_the_exact_map_is_missed():
    seen, missed = crossings_and_misses(2, 45, 1201)
    assert seen >= 140 and missed == []


def test_points_on_motions_that_strike_backward_are_kept_apart():
    """A soft bar's end can fly off the wall when its equations have it strike; no curve of real motions goes there."""
    rng = np.random.default_rng(0)
    backward = forward = 0
    for _ in range(12):
        load = Load.fourier(np.array([0.3, *(rng.normal(size=3) + 1j * rng.normal(size=3))]))
        system = System(float(rng.uniform(0.3, 1.5)), 0.05, 0.4, load)
        found = boundaries(system, ("restitution", [0.2, 0.6]), ("load_factor", 0.0, 2.0), kinds=("fold", "flip"))
        for curve in found.curves:
            for i in np.flatnonzero(curve.found):
                here = vary(system, {"restitution": float(curve.x[i]), "load_factor": float(curve.y[i])})
                speed = Orbit(here, 1, float(curve.phase[i])).impact_velocity
                assert (curve.impact_velocity[i] > 0.0) == (speed > 0.0)
                backward, forward = backward + (speed <= 0.0), forward + (speed > 0.0)
        kept = [int(curve.found.sum()) for curve in found.real]
        assert sum(kept) == sum(int((c.found & (c.impact_velocity > 0.0)).sum()) for c in found.curves)
        assert all((curve.impact_velocity[curve.found] > 0.0).all() for curve in (*found.real, *found.of_stability))
    assert backward > 5 and forward > 5


def test_progress_counts_values_of_x_and_can_end_it():
    seen: list[JobProgress] = []
    plane = ("restitution", np.linspace(0.0, 0.8, 5)), ("load_factor", 0.0, 2.0)
    found = boundaries(pneumatic(20.0), *plane, kinds=("fold", "grazing"), progress=seen.append)
    assert seen[-1].done == seen[-1].size == 5 and seen[-1].seconds_left == 0.0 and found.failed == ()
    ended = boundaries(pneumatic(20.0), *plane, kinds=("fold", "grazing"), progress=lambda p: p.done >= 1)
    assert 0 < len(ended.failed) < 5 and {why for _, why in ended.failed} == {"given up"}
    assert np.isfinite(ended.greatest("fold")[0]) and np.isnan(ended.greatest("fold")[-1])


def test_one_value_of_x_has_an_estimate_and_can_be_ended(monkeypatch):
    clock = itertools.count(0.0, 0.2)
    monkeypatch.setattr("percuss.explore.jobs.progress.time.monotonic", lambda: next(clock))
    plane = ("restitution", [0.5]), ("load_factor", 0.0, 2.0)
    for asked in ({"kinds": ("grazing",)}, {"kinds": ("flip", "neimark-sacker"), "criterion": "exact", "modes": 4}):
        seen: list[JobProgress] = []
        found = boundaries(pneumatic(20.0, 0.005, 0.5), *plane, **asked, progress=seen.append)
        under_way = [p for p in seen if 0.0 < p.fraction < 1.0]
        assert len(under_way) > 10 and all(p.done == 0 for p in under_way) and found.failed == ()
        assert all(math.isfinite(p.rate) and math.isfinite(p.seconds_left) for p in under_way[2:])
        assert np.all(np.diff([p.fraction for p in seen]) >= 0.0) and seen[-1].fraction == 1.0
        asked_again: list[float] = []
        ended = boundaries(
            pneumatic(20.0, 0.005, 0.5), *plane, **asked,
            progress=lambda p, told=asked_again: told.append(p.fraction) or p.fraction > 0.2,
        )  # fmt: skip
        assert ended.failed == ((0.5, "given up"),) and ended.curves == ()
        assert sum(fraction > 0.2 for fraction in asked_again) <= 2  # once when it ends, and the last word


def test_what_stops_the_caller_stops_the_boundaries():
    with halting(lambda: True):
        found = boundaries(pneumatic(20.0), ("restitution", [0.5]), ("load_factor", 0.0, 2.0), kinds=("grazing",))
    assert found.failed == ((0.5, "given up"),)


# ---------------------------------------------------------------- grazing


def deepest(orbit: Orbit, looks: int, finer: int) -> float:
    """The greatest gap between the impacts, all modes at very many times."""
    t = np.linspace(0.0, orbit.period, looks)[1:-1]
    for _ in range(4):
        y = orbit.end_motion(t, orbit.modes)[0]
        best = int(np.argmax(y))
        t = np.linspace(t[max(best - 1, 0)], t[min(best + 1, t.size - 1)], finer)
    return float(y[best])


def test_grazing_of_a_bar_that_rings():
    """To 1e-10, where 1300 modes take part; halves of a step, each with a proof, came to 1e-8."""
    system = pneumatic(20.0, 0.005, 0.5)
    curve = only(boundaries(system, ("restitution", [0.5]), ("load_factor", 0.0, 2.0), kinds=("grazing",)), "grazing")
    orbits = [beside(curve, system, "load_factor", step) for step in (-1e-6, 0.0, 1e-6)]
    depths = [deepest(Orbit(orbit.system, 1, orbit.phase, tolerance=1e-11), 2001, 401) for orbit in orbits]
    assert depths[0] > 0.0 > depths[2]
    assert abs(depths[1] / (depths[2] - depths[0]) * 2e-6) < 1e-10
    assert abs(depths[1]) < 1e-10 * orbits[1].rigid_stroke


def test_grazing_proves_few_motions(monkeypatch):
    """What each proof takes grows with the modes: of one touch there is one, beside it, and none on the way there."""
    proved = []
    monkeypatch.setattr("percuss.steady.orbit.flight_check", lambda m: proved.append(m) or flight_check(m))
    plane = ("restitution", [0.5]), ("load_factor", 0.0, 2.0)
    found = boundaries(pneumatic(20.0, 0.005, 0.5), *plane, kinds=("grazing",))
    assert len(found.curves) == 1 and len(proved) < 2 * 33 + 5  # the samples of two branches, and a few


def square_loaded() -> System:
    """Steps ring up 512 modes, whose ringing after the impact comes back each time the impact moves by a round trip."""
    return System(20.0, 0.005, 0.5, Load.square(1.0, 1.3))


def test_grazing_under_steps_looks_with_few_modes(monkeypatch):
    """A first look at each motion once took 512 modes at 4096 times, two million products of both."""
    looks = []
    plain = Orbit.end_motion
    monkeypatch.setattr(Orbit, "end_motion", lambda o, t, n: looks.append(t.size * n) or plain(o, t, n))
    plane = ("restitution", [0.5]), ("kappa", 1.40, 1.42)
    found = boundaries(square_loaded(), *plane, kinds=("grazing",), samples=9)
    assert found.failed == () and len(found.curves) == 1
    assert sum(looks) < 3_000_000  # for 18 motions and one root


def test_grazing_under_steps_by_slow_looks_on_both_sides():
    """With all modes at 5·10⁴ times: the bar touches at the root, and passes the wall on one side of it alone."""
    plane = ("restitution", [0.5]), ("kappa", 1.50, 1.57)
    found = boundaries(square_loaded(), *plane, kinds=("grazing",), samples=33)
    assert len(found.curves) >= 2
    for curve in found.curves:
        orbits = [beside(curve, square_loaded(), "kappa", step) for step in (-1e-6, 0.0, 1e-6)]
        depths = [deepest(orbit, 50_001, 101) for orbit in orbits]
        assert min(depths[0], depths[2]) < 0.0 < max(depths[0], depths[2])
        assert abs(depths[1]) < 1e-10 * orbits[1].rigid_stroke


def test_a_short_proof_says_what_the_long_one_says():
    rng = np.random.default_rng(5)
    verdicts = []
    for load in (Load.square(1.0, 1.3), WAVY, Load.harmonic(0.9, 1.0)):
        for phase in rng.uniform(0.0, 2.0 * math.pi, 12):
            motion = Orbit(System(7.0, 0.02, float(rng.uniform()), load), 1, float(phase))
            verdicts.append(stays_off(motion))
            assert verdicts[-1] == (flight_check(motion).violation is None)
    assert 5 < sum(verdicts) < 31


def test_the_greatest_gap_is_in_the_cells_that_are_left():
    rng = np.random.default_rng(6)
    for load in (Load.square(1.0, 1.3), WAVY):
        for phase in rng.uniform(0.0, 2.0 * math.pi, 4):
            motion = Orbit(System(5.0, 0.02, 0.4, load), 1, float(phase))
            low, high = np.sort(rng.uniform(0.3, motion.period - 0.3, 2))
            centres, half = tops(motion, float(low), float(high))
            t = np.linspace(low, high, 20_001)
            y = motion.end_motion(t, motion.truncation.some)[0]
            assert np.min(np.abs(centres - t[np.argmax(y)])) <= half * (1.0 + 1e-9) + 2e-4
            assert 2.0 * half * centres.size < 0.5 * (high - low)


def test_grazing_from_rest_at_once():
    """R = 0: the bar starts from rest and leaves only if p(φ) ≤ 0, hence p_0/p_1 ≤ 1/sqrt(1 + π²): below the fold."""
    found = boundaries(pneumatic(), ("restitution", [0.0]), ("load_factor", 0.0, 2.0), modes=0, kinds=("grazing",))
    ys = np.array([curve.y[0] for curve in found.curves])
    assert np.min(np.abs(ys - 1.0 / math.sqrt(1.0 + math.pi**2))) < 1e-10


@pytest.mark.parametrize("r", [0.1, 0.3, 0.8])
def test_rigid_grazing_against_mpmath(r):
    found = boundaries(pneumatic(), ("restitution", [r]), ("load_factor", 0.0, 2.0), modes=0, kinds=("grazing",))
    curve = only(found, "grazing")
    orbit = Orbit(vary(pneumatic(), {"restitution": r, "load_factor": float(curve.y[0])}), 1, float(curve.phase[0]))
    times = np.linspace(0.2, 2 * np.pi - 0.2, 4001)
    rigid = replace(orbit, requested_modes=0)
    guess = float(times[np.argmax(rigid.end_motion(times, 0)[0])])
    with mp.workdps(30):
        rr = mp.mpf(r)

        def touch(phase, t):
            p = mp.sin(phase) * (1 + rr) / (mp.pi * (1 - rr))
            w = 2 * mp.pi * p / (1 + rr)
            y = -rr * w * t + p * t**2 / 2 + mp.cos(phase) - mp.cos(phase + t) - t * mp.sin(phase)
            return y, -rr * w + p * t + mp.sin(phase + t) - mp.sin(phase)

        phase, _ = mp.findroot(touch, (mp.mpf(float(curve.phase[0])), mp.mpf(guess)))
        y = mp.sin(phase) * (1 + rr) / (mp.pi * (1 - rr))
    assert float(curve.y[0]) == pytest.approx(float(y), abs=1e-10)
    assert curve.residual[0] < 1e-10


@pytest.mark.parametrize(("system", "modes"), [(pneumatic(1.5, 0.5, 0.3), None), (pneumatic(2.0, 0.01, 0.3), 6)])
def test_elastic_grazing_has_a_verdict_on_either_side(system, modes):
    found = boundaries(
        system, ("restitution", [0.3]), ("load_factor", 0.2, 0.5), modes=modes, kinds=("grazing",), samples=5
    )
    assert found.curves
    for curve in found.curves:
        sides = [
            beside(curve, system, "load_factor", step, modes=modes, tolerance=1e-12).admissible
            for step in (-1e-8, 1e-8)
        ]
        assert sides[0] != sides[1]


# ---------------------------------------------------------------- simulation on both sides


def rigid_label(r: float, factor: float, phase: float) -> str:
    """The motion of a rigid bar that starts almost on the motion with this impact phase."""
    system = vary(pneumatic(), {"restitution": r, "load_factor": factor})
    leaving = -r * 2 * math.pi * factor / (1 + r)
    start = Start.rigid(position=0.0, velocity=leaving * (1 + 1e-4), time=phase)
    return run(system, start, modes=0, stop=Stop(impacts=20_000)).label


@pytest.mark.parametrize("r", [0.2, 0.5, 0.8])
def test_motions_by_simulation_on_both_sides(r):
    found = boundaries(pneumatic(), ("restitution", [r]), ("load_factor", 0.0, 5.0), kinds=("fold", "flip"))
    flip, fold = only(found, "flip"), only(found, "fold")
    phase = float(flip.phase[0])
    assert rigid_label(r, float(flip.y[0]) * 1.01, phase) == "z=1/1"
    assert rigid_label(r, float(flip.y[0]) * 0.99, phase) == "z=2/2"
    assert rigid_label(r, float(fold.y[0]) * 0.995, 0.5 * math.pi + 0.1) == "z=1/1"
    assert rigid_label(r, float(fold.y[0]) * 1.005, 0.5 * math.pi + 0.1) != "z=1/1"


def test_inadmissible_motions_are_not_found_by_simulation():
    """R = 0 on B77's stable branch, above and below the grazing: above it the bar rests instead of leaving at once."""
    fold, graze = 1.0 / math.pi, 1.0 / math.sqrt(1.0 + math.pi**2)
    above, below = 0.5 * (fold + graze), 0.99 * graze
    for factor, label in ((above, False), (below, True)):
        phase = math.pi - math.asin(math.pi * factor)
        assert (rigid_label(0.0, factor, phase) == "z=1/1") is label


# ---------------------------------------------------------------- what is refused, what is left out


@pytest.mark.parametrize(
    ("x", "y", "asked", "says"),
    [
        (None, ("load_factor", 1.0, 1.0), {}, "two different ends"),
        (None, ("restitution", 0.0, 1.0), {}, "beside"),
        (("mean", [1.0]), None, {}, "beside"),
        (("hardness", [1.0]), None, {}, "restitution, load_factor"),
        (None, ("kappa", 1.1, 1.9), {}, "square load"),
        (None, None, {"criterion": "best"}, "reduced, exact"),
        (None, None, {"kinds": ("folds",)}, "fold, flip"),
        (("m", [1.5]), None, {}, "whole number"),
        (None, ("m", 1.0, 3.0), {}, "whole number"),
    ],
)
def test_refusals(x, y, asked, says):
    with pytest.raises(ParameterError, match=says):
        boundaries(pneumatic(), x or ("restitution", [0.5]), y or ("load_factor", 0.0, 1.0), **asked)


def test_a_value_that_fails_leaves_nan_and_says_why():
    resonant = 1.0 / math.pi
    found = boundaries(
        pneumatic(), Axis("s", np.array([resonant, 1.0])), ("load_factor", 0.0, 2.0), kinds=("fold", "flip")
    )
    assert [value for value, _ in found.failed] == [resonant]
    assert "B77 16" in found.failed[0][1]
    assert np.isnan(found.greatest("fold")[0]) and np.isfinite(found.greatest("fold")[1])
    assert KINDS == ("fold", "flip", "neimark-sacker", "grazing")
    assert "fold, branch" in str(found)
    with pytest.raises(ParameterError, match="one of"):
        found.of("edge")


def test_full_restitution_without_damping_has_no_curve():
    found = boundaries(pneumatic(), ("restitution", [1.0]), ("load_factor", 0.0, 2.0), kinds=("fold", "flip"))
    assert found.curves == () and np.isnan(found.least("fold")).all()
