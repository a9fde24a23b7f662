"""Stability: the reduced criterion, exact multipliers by every road, the waveform criterion, verdicts."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

import naive
from orbit_cases import ENTRIES as FIGURES
from orbit_cases import motions, of_kind, periods_of, system_of, times_of
from orbit_cases import orbit_at as figure_at
from percuss import Kept, Load, System, stability_of, steady_states
from percuss.errors import ConvergenceError, ParameterError
from percuss.explore import REASONS, sweep
from percuss.model import External, Reversed, UniformBar
from percuss.stability import LinearMap, floquet_multipliers, reduced_criterion, waveform_criterion
from percuss.stability.verdict import quadratic_coefficients, schur_quotients
from percuss.steady import Orbit, PeriodicOrbit, Reason, orbit_near
from percuss.steady.multipliers import VERDICTS
from secular_roots import farthest, roots_of_poles, secular_roots
from strategies import Drawn, fourier_systems, oracle, square_systems

ENTRIES = naive.reference()
STATES = [pytest.param(entry, i, id=f"{entry['name']}-{i}") for entry in ENTRIES for i in range(len(entry["states"]))]


def orbit_of(entry: dict[str, Any], i: int, modes: int | None = None) -> Orbit:
    load = Load.fourier(entry["load"]["coefficients"])
    system = System(s=entry["s"], d=entry["d"], restitution=entry["R"], load=load)
    return steady_states(system, entry["m"], modes=modes).orbits[i]


def orbit_at(s: float, d: float, r: float, m: int, load: Load, i: int = -1) -> Orbit:
    return steady_states(System(s=s, d=d, restitution=r, load=load), m, modes=4).orbits[i]


# ---------------------------------------------------------------- the reference states


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_reference_reduced_numbers(entry: dict[str, Any], i: int) -> None:
    state, reduced = entry["states"][i], reduced_criterion(orbit_of(entry, i))
    assert reduced.sigma == pytest.approx(float(state["sigma"]), rel=1e-12, abs=1e-12)
    a_2, a_1, a_0 = (float(a) for a in state["a"])  # the file begins with a_2
    assert reduced.a == pytest.approx((a_0, a_1, a_2), rel=1e-12, abs=1e-12)
    assert reduced.schur == pytest.approx([float(x) for x in state["schur"]], rel=1e-12, abs=1e-12)
    assert reduced.moduli == pytest.approx([float(x) for x in state["reduced_moduli"]], rel=1e-12, abs=1e-12)
    assert reduced.stable is state["reduced_stable"]
    assert reduced.other_side is None


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_reference_exact_moduli(entry: dict[str, Any], i: int) -> None:
    found = floquet_multipliers(orbit_of(entry, i), 8)
    assert found.values.shape == (18,)
    assert found.moduli[:3] == pytest.approx(entry["states"][i]["exact_moduli_N8_top3"], rel=0, abs=1e-8)
    assert found.largest == found.moduli[0]
    assert np.all(np.diff(found.moduli) <= 1e-12)
    assert stability_of(orbit_of(entry, i), modes=8).multipliers.largest == found.largest


@pytest.mark.parametrize(
    ("name", "i", "modes"), [("elastic instability", 1, 5), ("slow wave", 1, 4), ("random-1-2", 1, 3)]
)
def test_multipliers_by_differences_of_the_map(name: str, i: int, modes: int) -> None:
    """Fly the nonlinear map itself, in 50 digits, and difference it."""
    entry = next(e for e in ENTRIES if e["name"] == name)
    case = naive.reference_case(entry)
    expected = naive.multipliers_by_difference(naive.orbit(case, naive.phases(case)[i], modes))
    ours = floquet_multipliers(orbit_of(entry, i), modes).values
    assert farthest(ours, np.array([complex(z) for z in expected])) < 1e-9


# ---------------------------------------------------------------- the reduced criterion


@given(st.floats(0, 3), st.floats(0, 1), st.floats(0.1, 70), st.floats(-2, 2), st.floats(-5, 5))
def test_schur_is_the_moduli(d: float, r: float, period: float, sigma: float, slope: float) -> None:
    a_0, a_1, a_2 = (float(a) for a in quadratic_coefficients(d, -r, period, sigma, slope))
    assume(abs(a_2) > 1e-6)
    roots = np.abs(np.roots([a_2, a_1, a_0]))
    largest = float(roots.max(initial=0.0))
    assume(abs(largest - 1) > 1e-7)
    first, second = schur_quotients(np.array(a_0), np.array(a_1), np.array(a_2))
    assert bool(max(first, second) < 1) == (largest < 1)


@settings(max_examples=20)
@given(fourier_systems(8))
def test_reduced_numbers_against_the_oracle(drawn: Drawn) -> None:
    case = oracle(*drawn)
    for orbit in steady_states(drawn.system, drawn.periods).orbits[:2]:
        reduced = reduced_criterion(orbit)
        sigma = naive.sigma_closed(case, orbit.phase)
        expected = naive.reduced_coefficients(case, orbit.phase, sigma)
        size = sum(
            abs(
                naive.sigma_closed(
                    naive.Case.of(
                        naive.Fourier.of([drawn.system.load.mean, *[0] * (k - 1), p]),
                        drawn.system.s,
                        drawn.system.d,
                        0,
                        drawn.periods,
                    ),
                    x,
                )
            )
            for k, p in [(int(k), complex(drawn.system.load.coefficients[k])) for k in drawn.system.load.harmonics]
            for x in (0.3, 1.9)
        )
        scale = max(float(size), 1.0, max(abs(float(a)) for a in expected))
        k = drawn.system.load.harmonics
        sharp = max(
            1.0,
            float(np.abs(1.0 / np.sin(np.sqrt(k * (k - 1j * drawn.system.d)) / drawn.system.s)).max())
            * 1e-3
            * float(k.max())
            / drawn.system.s,
        )
        assert reduced.sigma == pytest.approx(float(sigma), abs=1e-12 * scale * sharp)
        assert reduced.a == pytest.approx([float(a) for a in expected], abs=1e-11 * scale * sharp)


@settings(max_examples=20)
@given(square_systems())
def test_reduced_sigma_of_a_square_takes_its_harmonics(drawn: Drawn) -> None:
    for orbit in steady_states(drawn.system, drawn.periods).orbits[:1]:
        load = naive.Fourier.of(drawn.system.load.coefficients.tolist())
        case = naive.Case.of(load, drawn.system.s, drawn.system.d, drawn.system.restitution, drawn.periods)
        expected = float(naive.sigma_closed(case, orbit.phase))
        assume(abs(expected) < 1e3)
        assert reduced_criterion(orbit).sigma == pytest.approx(expected, rel=1e-7, abs=1e-9)


# ---------------------------------------------------------------- the linear map


@settings(max_examples=30)
@given(st.one_of(fourier_systems(8), square_systems()), st.integers(0, 30))
def test_liouville_and_trace(drawn: Drawn, modes: int) -> None:
    """The product of all multipliers is R**(N + 2) E**(N + 1) up to its sign, their sum is the trace."""
    system, m = drawn
    orbits = steady_states(system, m, modes=4).orbits
    assume(orbits and (system.restitution < 1 or system.d > 1e-6))
    matrix = orbits[0].linear_map(modes)
    assume(abs(matrix.speed) > 1e-3 * abs(matrix.g).max())
    values = floquet_multipliers(orbits[0], modes).values
    size = float(np.abs(matrix.dense()).sum(axis=1).max())
    assume(size < 1e6)
    assert values.size == 2 * modes + 2
    assert complex(values.sum()) == pytest.approx(np.trace(matrix.dense()), abs=1e-11 * size)
    expected = (modes + 2) * math.log(max(system.restitution, 1e-300)) - system.d * orbits[0].period * (modes + 1)
    sign, logarithm = np.linalg.slogdet(matrix.dense())
    if expected > -25.0:
        assert sign == (-1.0) ** modes
        assert logarithm == pytest.approx(
            expected, abs=1e-7 * max(1.0, math.log(size + 1)) + 1e-9 * size * math.exp(-expected / (2 * modes + 2))
        )
    # complex ones come in pairs
    assert farthest(values, values.conj()) <= 1e-7 * max(1.0, size)


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("modes", [0, 1, 5])
def test_map_entry_by_entry(modes: int, side: Any) -> None:
    """The saltation matrix times the flight, on the section: the oracle keeps the phase instead of u_0."""
    load = Load.fourier([0.05, 1.0, 0.4j])
    orbit = orbit_at(1.7, 0.05, 0.4, 2, load)
    ours = floquet_multipliers(orbit, modes, side=side).values
    theirs = naive.multipliers(naive.orbit(oracle(orbit.system, 2), orbit.phase, modes))
    assert farthest(ours, theirs) < 1e-9


@pytest.mark.parametrize("d", [0.0, 1e-6, 0.02])
def test_square_load_multipliers(d: float) -> None:
    orbit = orbit_at(3.0, d, 0.5, 1, Load.square(1.0, 1.3), 0)
    ours = floquet_multipliers(orbit, 4).values
    theirs = naive.multipliers(naive.orbit(oracle(orbit.system, 1), orbit.phase, 4))
    assert farthest(ours, theirs) < 1e-9


@pytest.mark.parametrize("modes", [-1, 1.5, 20000, "3", True])
def test_modes_out_of_range(modes: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        floquet_multipliers(orbit_at(5.0, 0.1, 0.5, 1, Load.harmonic(0.1, 1.0)), modes)
    assert caught.value.name == "modes"


# ---------------------------------------------------------------- secular roots against dense eigenvalues


def secular_against_dense(matrix: LinearMap, tolerance: float = 1e-9) -> None:
    roots = secular_roots(matrix)
    dense = np.linalg.eigvals(matrix.dense())
    # eigenvalues of a matrix far from normal move by more than rounding: ask how far
    noise = np.random.default_rng(0).normal(size=(dense.size, dense.size)) / math.sqrt(dense.size)
    moved = np.linalg.eigvals(matrix.dense() + 1e-15 * np.linalg.norm(matrix.dense(), 2) * noise)
    doubt = farthest(dense, moved)
    assert roots.size == dense.size
    assert np.all(np.isfinite(roots))
    assert farthest(roots, dense) <= tolerance * max(1.0, float(np.abs(dense).max())) + 1e3 * doubt


@pytest.mark.parametrize(
    ("s", "d", "m", "kappa", "modes"),
    [(0.42785311, 8.031994e-06, 4, 1.3, 56), (1.0, 0.00106147, 1, 1.2, 60), (22.829557, 1.0945661e-06, 5, 1.3, 60)],
)
def test_secular_roots_in_a_crowd(s: float, d: float, m: int, kappa: float, modes: int) -> None:
    """With R = 1 and next to no damping the poles crowd at 1 and −1, and most roots lie among them."""
    orbits = steady_states(System(s=s, d=d, restitution=1.0, load=Load.square(1.0, kappa, 16)), m, modes=4).orbits
    assert orbits
    for orbit in orbits:
        secular_against_dense(orbit.linear_map(modes))


@pytest.mark.parametrize("modes", [41, 120])
@pytest.mark.parametrize(
    ("s", "d", "r", "m"),
    [
        (5.0, 0.0, 0.8, 2),
        (20.0, 0.0048, 0.6, 1),
        (2.0, 0.01, 0.0, 1),
        (2.0, 0.0, 0.0, 3),
        (7.3, 0.003, 1.0, 1),
        (0.5, 9.0, 0.5, 1),
        (0.31, 0.3, 0.2, 10),
        (1.0 / math.pi * 1.5, 0.0, 0.6, 1),
        (0.5 / math.pi, 0.01, 0.4, 2),
        (1.25 / math.pi, 1e-8, 0.3, 4),
        (1000.0, 1e-12, 0.5, 1),
    ],
    ids=[
        "plain",
        "damped",
        "R=0",
        "R=0 d=0",
        "R=1",
        "overdamped",
        "long",
        "two poles",
        "one pole",
        "clusters",
        "stiff",
    ],
)
def test_secular_roots_of_many_modes(s: float, d: float, r: float, m: int, modes: int) -> None:
    """With s m rational to 1/pi the modes share a few angles and nearly all poles coincide."""
    load = Load.fourier([1e-3 if d > 0.2 else 0.05, 0.0, 0.0, 1.0] if abs(s * math.pi * 2 % 1) < 1e-9 else [1e-3, 1.0])
    if s * math.pi * 2 % 1 < 1e-9 and d == 0.0:
        load = Load.fourier([0.05, 1.0])
    orbit = orbit_at(s, d, r, m, load)
    secular_against_dense(orbit.linear_map(modes), 1e-8)


@given(st.integers(1, 30), st.integers(0, 2**32 - 1), st.sampled_from(["spread", "clustered", "equal", "weak"]))
def test_secular_roots_of_random_poles(n: int, seed: int, kind: str) -> None:
    """Against the eigenvalues of diag(poles) minus a matrix of rank one."""
    rng = np.random.default_rng(seed)
    poles = rng.uniform(-1, 1, n)
    if kind == "clustered":
        poles = np.round(poles, 1) + 1e-9 * rng.normal(size=n)
    if kind == "equal":
        poles = np.round(poles, 1)
    residues = rng.normal(size=n) * (1e-12 if kind == "weak" else 1.0 / n)
    roots = roots_of_poles(poles, residues)
    dense = np.linalg.eigvals(np.diag(poles) - np.outer(np.ones(n), residues))
    moved = np.linalg.eigvals(np.diag(poles) - np.outer(np.ones(n), residues * (1 + 1e-15 * rng.normal(size=n))))
    assert farthest(roots, dense) <= 1e-9 + 1e3 * farthest(dense, moved)
    assert complex(roots.sum()) == pytest.approx(float(poles.sum() - residues.sum()), abs=1e-11 * n)


@pytest.mark.parametrize("kind", ["cosines", "crowds", "towards 0", "far apart"])
@pytest.mark.parametrize("n", [513, 3000])
def test_secular_roots_of_very_many_poles(n: int, kind: str) -> None:
    """What far poles add is interpolated: beside sums over all poles, in long numbers."""
    rng = np.random.default_rng(n)
    poles = np.cos(rng.uniform(0.0, math.pi, n))
    if kind == "crowds":
        poles = rng.choice([-0.7, -0.2, 0.1, 0.9], n) + rng.normal(size=n) * 10.0 ** rng.uniform(-8, -1, n)
    elif kind == "towards 0":
        poles = rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(-8, 0, n)
    elif kind == "far apart":
        poles[0], poles[1:] = 50.0, 1e-3 * poles[1:]
    poles.sort()
    residues = rng.random(n) * np.gradient(poles) * 10.0 ** rng.uniform(-4, -0.5, n)
    roots = roots_of_poles(poles, residues).real
    wide, x = poles.astype(np.longdouble), roots.astype(np.longdouble)
    apart = x[:, None] - wide
    np.fill_diagonal(apart, np.inf)
    others = (residues / apart).sum(axis=1)
    noise = 1e-15 * np.abs(residues / apart).sum(axis=1)
    off = np.abs(x - (wide - residues / (1.0 + others)))
    assert (off <= 4e-16 * np.abs(x) + np.abs(residues) * (1e-14 + 100.0 * noise)).all()


def test_secular_roots_of_dead_and_of_equal_poles() -> None:
    assert sorted(roots_of_poles(np.array([0.3, -0.2]), np.zeros(2)).real) == [-0.2, 0.3]
    roots = roots_of_poles(np.array([0.5, 0.5, 0.5]), np.array([0.1, 0.1, 0.1]))
    assert np.sort(roots.real) == pytest.approx([0.2, 0.5, 0.5], abs=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("r", [0.0, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("d", [0.0, 1e-3])
def test_secular_roots_of_a_thousand_modes(d: float, r: float) -> None:
    orbit = orbit_at(5.0, d, r, 1, Load.harmonic(0.2, 1.0))
    secular_against_dense(orbit.linear_map(260), 1e-8)
    many = floquet_multipliers(orbit, 1024)
    assert many.values.size == 2050
    assert complex(many.values.sum()) == pytest.approx(np.trace(orbit.linear_map(1024).dense()), abs=1e-7)


@pytest.mark.parametrize("modes", [39, 40, 41, 42])
def test_both_methods_meet_where_they_change_over(modes: int) -> None:
    orbit = orbit_at(4.0, 0.001, 0.7, 1, Load.fourier([0.2, 1.0, 0.3j]))
    matrix = orbit.linear_map(modes)
    assert farthest(floquet_multipliers(orbit, modes).values, np.linalg.eigvals(matrix.dense())) < 1e-9


# ---------------------------------------------------------------- verdicts


def test_elastic_instability_that_the_reduced_criterion_misses() -> None:
    """Theory §5: s = 5, d = 0, R = 0.8, p = 0.9 + cos t, m = 2, N = 8."""
    system = System(s=5.0, d=0.0, restitution=0.8, load=Load.harmonic(0.9, 1.0))
    verdicts = [stability_of(orbit, modes=8) for orbit in steady_states(system, 2).orbits]
    elastic = verdicts[1]
    assert elastic.reduced.stable
    assert not elastic.stable
    assert elastic.multipliers.largest == pytest.approx(1.000147, abs=6e-7)
    assert elastic.margin == pytest.approx(-0.000147, abs=6e-7)
    assert elastic.disagreement is not None
    assert "unstable" in elastic.disagreement
    assert "elastic mode" in elastic.reason
    assert elastic.multipliers.dominant_mode >= 1


@pytest.mark.parametrize(("s", "within"), [(20.0, 2e-4), (2.0, 0.02), (1.0, 0.06)])
def test_reduced_and_exact_agree_where_the_wave_is_fast(s: float, within: float) -> None:
    """Theory §5: four digits at s = 20, 2 % at s = 2; at s = 1 it is 5 % here. The saddle's multiplier stands alone."""
    system = System(s=s, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    orbit = steady_states(system).orbits[0]  # the saddle: its large multiplier stands alone
    verdict = stability_of(orbit)
    assert max(verdict.reduced.moduli) > 1.5
    assert verdict.multipliers.largest == pytest.approx(max(verdict.reduced.moduli), rel=within)
    assert verdict.disagreement is None


def test_reasons() -> None:
    def verdicts(mean: float, r: float, m: int = 1, d: float = 0.001, s: float = 50.0) -> list[Any]:
        system = System(s=s, d=d, restitution=r, load=Load.harmonic(mean, 1.0))
        return [stability_of(orbit) for orbit in steady_states(system, m).orbits]

    saddle, node = verdicts(0.9, 0.6)
    assert "fold" in saddle.reason
    assert not saddle.stable
    assert node.stable
    assert node.reason.startswith("stable")
    assert node.margin == pytest.approx(1 - node.multipliers.largest, rel=1e-15)
    below_the_flip = verdicts(0.3, 0.6)[1]
    assert not below_the_flip.stable
    assert "flip" in below_the_flip.reason
    assert float(below_the_flip.multipliers.values[0].real) < -1
    for verdict in (saddle, node, below_the_flip):
        assert verdict.stable == (verdict.margin > 0)
        assert verdict.disagreement is None


def test_fold_is_said_to_be_one() -> None:
    r = 0.5
    top = (1 + r) / (math.pi * (1 - r))
    system = System(s=30.0, d=0.0, restitution=r, load=Load.harmonic(top, 1.0))
    orbits = steady_states(system).orbits
    assert len(orbits) == 1
    assert orbits[0].fold
    verdict = stability_of(orbits[0])
    assert not verdict.stable
    assert "fold" in verdict.reason
    assert verdict.multipliers.largest == pytest.approx(1.0, abs=1e-5)


@settings(max_examples=30)
@given(fourier_systems(8))
def test_stable_means_all_moduli_below_one(drawn: Drawn) -> None:
    for orbit in steady_states(drawn.system, drawn.periods, modes=4).orbits[:2]:
        assume(abs(orbit.impact_velocity) > 1e-9 * orbit.rigid_velocity)
        verdict = stability_of(orbit)
        assert verdict.multipliers.modes == 4
        if abs(verdict.margin) > 1e-9 and not orbit.fold:
            assert verdict.stable == bool(np.all(verdict.multipliers.moduli < 1))
            assert (verdict.disagreement is not None) == (verdict.stable != verdict.reduced.stable)
        assert verdict.reason


def test_default_number_of_modes() -> None:
    system = System(s=5.0, d=0.01, restitution=0.5, load=Load.harmonic(0.2, 1.0))
    assert stability_of(steady_states(system).orbits[0]).multipliers.modes == 32
    assert stability_of(steady_states(system, modes=7).orbits[0]).multipliers.modes == 7
    assert stability_of(steady_states(system, modes=7).orbits[0], modes=3).multipliers.modes == 3


# ---------------------------------------------------------------- the waveform criterion (theory §11)


@settings(max_examples=75)
@given(st.one_of(fourier_systems(12), square_systems()), st.floats(0.0, 1.0))
def test_waveform_is_exact_for_the_rigid_undamped_bar(drawn: Drawn, r: float) -> None:
    system = System(s=1e3 / math.e, d=0.0, restitution=r, load=drawn.system.load)
    for orbit in steady_states(system, drawn.periods, modes=0).orbits[:4]:
        waveform, exact = waveform_criterion(orbit), floquet_multipliers(orbit, 0)
        assert exact.values.size == 2
        assert complex(np.prod(exact.values)).real == pytest.approx(r**2, abs=1e-9 * max(1, exact.largest**2))
        trace = (1 + r) ** 2 * waveform.ratio - 2 * r
        assert complex(exact.values.sum()).real == pytest.approx(trace, rel=1e-9, abs=1e-9)
        # B77's own numbers say the same with sigma = 0
        distance = min(abs(waveform.ratio - waveform.lower), abs(waveform.ratio - waveform.upper))
        if distance > 1e-7 and r < 1 - 1e-6:
            assert waveform.stable == (exact.largest < 1)
        assert waveform.force == pytest.approx(waveform.ratio * system.load.mean, rel=1e-15)
        assert waveform.lower == pytest.approx(-(((1 - r) / (1 + r)) ** 2), rel=1e-14)
        assert (waveform.force_lower < waveform.force < waveform.force_upper) == waveform.stable


@given(fourier_systems(5))
def test_restitution_needed(drawn: Drawn) -> None:
    for orbit in steady_states(drawn.system, drawn.periods).orbits[:2]:
        waveform = waveform_criterion(orbit)
        needed = waveform.restitution_needed
        if needed is None:
            assert waveform.ratio >= 1 or waveform.ratio <= -1
        elif needed > 1e-9:
            for r, stable in ((needed * (1 - 1e-9), True), (min(1.0, needed * (1 + 1e-9)), False)):
                lower = -(((1 - r) / (1 + r)) ** 2)
                if waveform.ratio < 0:
                    assert (lower < waveform.ratio) is stable


def test_both_sides_of_a_jump() -> None:
    """A square wave at the fold: the root sits on the break, and the load has two values there."""
    r = 0.4
    rho = (1 - r) / (1 + r)
    limit = 1 - rho + math.sqrt(1 + rho**2)
    orbit = Orbit(System(s=50.0, d=0.0, restitution=r, load=Load.square(1.0, limit)), 1, limit * math.pi, fold=True)
    here = reduced_criterion(orbit)
    other = here.other_side
    assert other is not None
    assert other.other_side is None
    # B77 (29): a_1 differs by (1 + R)**2 times the jump of v_f'/p_0
    assert here.a[1] - other.a[1] == pytest.approx(-((1 + r) ** 2) * (-1 - 1) / (limit - 1), rel=1e-9)
    assert here.sigma == other.sigma
    assert not here.stable
    assert waveform_criterion(orbit).ratio == pytest.approx(-1 / (limit - 1), rel=1e-12)
    left, right = (floquet_multipliers(orbit, 0, side=side).largest for side in ("left", "right"))  # type: ignore[arg-type]
    assert left != right
    assert stability_of(orbit).multipliers.largest >= max(1.0, min(left, right))
    assert not stability_of(orbit).stable


def test_secular_roots_that_converge_slowly() -> None:
    """R = 1 and little damping: poles close to +-sqrt(E) in two crowds, strong residues."""
    load = Load.fourier([0.014238350175330051, 1.0, -0.5224413639190784 - 1.6061770608253054j])
    orbit = orbit_at(1.3884068775361385, 0.016765193869253035, 1.0, 3, load, 0)
    matrix = orbit.linear_map(80)
    dense = np.linalg.eigvals(matrix.dense())
    assert farthest(floquet_multipliers(orbit, 80).values, dense) < 1e-6
    square = orbit_at(1.0, 0.01, 1.0, 1, Load.square(1.0, 1.4995, 16), 0)
    for modes in (15, 60):
        secular_against_dense(square.linear_map(modes))


@pytest.mark.parametrize("modes", [120, 1000])
def test_many_modes_of_a_bar_that_rebounds_fully(modes: int) -> None:
    square = orbit_at(1.0, 0.01, 1.0, 1, Load.square(1.0, 1.4995, 16), 0)
    try:
        values = floquet_multipliers(square, modes).values
    except ConvergenceError as error:  # crowds of poles 1e-13 apart: refused beyond the reach of dense eigenvalues
        assert modes > 300
        assert "modes" in error.remedy
        return
    assert complex(values.sum()) == pytest.approx(np.trace(square.linear_map(modes).dense()), abs=1e-8)


# ---------------------------------------------------------------- two margins: rhythm and ringing


def followed_from_apart(matrix: LinearMap) -> NDArray[Any]:
    """The rigid motion's two multipliers, followed from where the elastic modes have no say in when the bar strikes."""
    whole = matrix.dense()
    jump = np.stack([matrix.g, matrix.g_velocity], axis=1).reshape(-1) / matrix.speed
    flight = np.stack([matrix.blocks.a, matrix.blocks.b], axis=1).reshape(-1) * np.repeat(matrix.blocks.gamma, 2)
    elastic = np.where(np.arange(flight.size) < 2, 0.0, flight)
    now = np.linalg.eigvals(whole + np.outer(jump, elastic))
    own = np.linalg.eigvals((whole + np.outer(jump, elastic))[:2, :2])
    which = linear_sum_assignment(np.abs(own[:, None] - now))[1]
    for coupling in np.linspace(0.0, 1.0, 201)[1:]:
        then = np.linalg.eigvals(whole + (1.0 - coupling) * np.outer(jump, elastic))
        now = then[linear_sum_assignment(np.abs(now[:, None] - then))[1]]
    return np.asarray(now[which])


@pytest.mark.parametrize("r", [0.0, 1e-9, 0.15, 0.6, 0.9])
@pytest.mark.parametrize(
    ("s", "d"), [(4.0, 0.0), (4.0, 0.004), (20.0, 0.0), (20.0, 0.004), (20.0, 0.3), (122.936, 0.3)]
)
def test_the_rhythm_is_that_of_the_rigid_motion_followed_from_apart(s: float, d: float, r: float) -> None:
    system = System(s=s, d=d, restitution=r, load=Load.fourier([0.3, 1.0, 0.4j]))
    orbits = steady_states(system).orbits
    assert orbits or r < 0.2
    for orbit in orbits:
        found = floquet_multipliers(orbit, 9)
        apart = np.abs(followed_from_apart(orbit.linear_map(9)))
        assert found.rhythm == pytest.approx(float(apart.max()), abs=1e-9)


@pytest.mark.parametrize(("s", "within"), [(20.0, 2e-3), (200.0, 2e-5)])
def test_the_rhythm_is_what_the_reduced_criterion_judges(s: float, within: float) -> None:
    """B77's quadratic is the rigid motion's: with a fast wave its roots are those two multipliers."""
    for r in (0.0, 0.1, 0.5):
        system = System(s=s, d=0.01, restitution=r, load=Load.harmonic(0.3, 1.0))
        for orbit in steady_states(system).orbits:
            verdict = stability_of(orbit)
            own = sorted(np.abs(verdict.multipliers.values[list(verdict.multipliers.rigid)]), reverse=True)
            assert own == pytest.approx(list(verdict.reduced.moduli), rel=within, abs=within)
            assert 1.0 - verdict.margin_rhythm == pytest.approx(max(verdict.reduced.moduli), rel=within, abs=within)


@settings(max_examples=30)
@given(fourier_systems(8), st.integers(0, 8))
def test_the_margin_is_the_lesser_of_both(drawn: Drawn, modes: int) -> None:
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:2]:
        assume(abs(orbit.impact_velocity) > 1e-9 * orbit.rigid_velocity)
        verdict = stability_of(orbit)
        first, second = verdict.multipliers.rigid
        assert 0 <= first < second < 2 * modes + 2
        if modes == 0:
            assert verdict.margin_ringing is None
            assert verdict.margin_rhythm == verdict.margin
        else:
            assert verdict.margin_ringing is not None
            assert verdict.margin == min(verdict.margin_rhythm, verdict.margin_ringing)
            assert 1 <= verdict.multipliers.ringing_mode <= modes


def test_participation_by_both_eigenvectors() -> None:
    """l_0·r_0 with l·r = 1 from a dense eigensolver; over all multipliers it sums to the two states of the mode."""
    from scipy.linalg import eig

    matrix = orbit_at(3.0, 0.02, 0.6, 1, Load.fourier([0.3, 1.0, 0.2j])).linear_map(6)
    values, left, right = eig(matrix.dense(), left=True)
    both = np.conj(left) * right
    expected = both[:2].sum(axis=0) / both.sum(axis=0)
    assert np.abs(matrix.participation(values) - expected).max() < 1e-9
    assert complex(expected.sum()) == pytest.approx(2.0, abs=1e-9)


def test_the_rhythm_of_very_many_modes_is_that_of_some() -> None:
    for r in (0.0, 0.1, 0.6):
        orbit = orbit_at(30.0, 0.01, r, 1, Load.harmonic(0.3, 1.0))
        few, many = floquet_multipliers(orbit, 40), floquet_multipliers(orbit, 500)
        assert many.rhythm == pytest.approx(few.rhythm, abs=1e-5)
        assert many.ringing == pytest.approx(few.ringing, abs=0.02)


# -- orbits with several impacts ---------------------------------------------------------------------------------------


TURN = 2.0 * math.pi


def apart(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest distance of theirs, which may be some only, under the best matching."""
    distance = np.abs(ours[:, None] - theirs[None, :])
    rows, columns = linear_sum_assignment(distance)
    return float(distance[rows, columns].max())


@pytest.mark.parametrize("name", of_kind("orbit"))
def test_multipliers_of_the_figures(name: str) -> None:
    entry = FIGURES[name]
    orbit = orbit_near(system_of(entry), times_of(entry), periods_of(entry), modes=entry["system"]["modes"])
    assert orbit is not None
    found = orbit.multipliers()
    wanted = np.array([complex(*pair) for pair in entry["multipliers"]])
    assert found.values.size == 2 * orbit.modes + 2
    assert apart(found.values, wanted) < 1e-8 * abs(wanted[0])
    assert found.stable is entry["stable"]
    assert found.largest == pytest.approx(entry["largest_modulus"], rel=1e-8)


@pytest.mark.parametrize("name", of_kind("branch_points"))
def test_multipliers_at_the_special_points_of_the_figures(name: str) -> None:
    for point in FIGURES[name]["points"]:
        if point["type"].startswith("grazing"):
            continue
        wanted = np.array([complex(*pair) for pair in point["multipliers"]])
        found = figure_at(FIGURES[name], point).multipliers().values
        assert apart(found, wanted) < 1e-8 * max(1.0, float(np.abs(wanted).max()))


@pytest.mark.parametrize("contact", [Kept(0.6), Reversed(0.6)])
@pytest.mark.parametrize("load", [Load.harmonic(0.7, 1.0), Load.square(1.0, 1.15)])
def test_one_impact_has_the_map_of_the_steady_motion(contact, load: Load) -> None:
    system = System(UniformBar(3.0, External(0.02)), load, contact)
    for motion in steady_states(system, modes=6).orbits:
        orbit = PeriodicOrbit(system, 1, (motion.phase,), 6)
        for side in ("left", "right"):
            dense = motion.linear_map(6, side).dense()
            assert orbit.map(side=side).dense() == pytest.approx(dense, abs=1e-10 * np.abs(dense).max())
        assert orbit.multipliers().largest == pytest.approx(floquet_multipliers(motion, 6).largest, rel=1e-9)


@settings(max_examples=30)
@given(motions(), st.sampled_from([1.0, -1.0, 0.3 + 0.4j, -1.3 + 0.2j, 1j, complex(math.cos(1.0), math.sin(1.0))]))
def test_the_small_determinant_is_the_characteristic_polynomial(orbit: PeriodicOrbit, xi: complex) -> None:
    if np.abs(orbit.speeds).min() < 1e-3 * np.abs(orbit.speeds).max():
        return
    whole = orbit.map().dense()
    values = np.linalg.eigvals(whole)
    room = 1e-11 * float(np.prod(np.abs(xi) + np.abs(values)))  # of the product, whose factors may nearly vanish
    assert orbit.characteristic(xi) == pytest.approx(complex(np.prod(xi - values)), abs=max(room, 1e-9))


@given(motions())
def test_the_determinant_of_the_map_is_that_of_its_parts(orbit: PeriodicOrbit) -> None:
    """Of a rigid bar each impact multiplies it by β², as its time is one of the two numbers of the state."""
    if orbit.modes or np.abs(orbit.speeds).min() < 1e-3:
        return
    contact, system = orbit.system.contact, orbit.system
    wanted = contact.velocity_factor ** (2 * orbit.impacts) * math.exp(-system.d * orbit.period)
    whole = orbit.map().dense()
    assert np.linalg.det(whole) == pytest.approx(wanted, abs=1e-12 * (1.0 + float(np.abs(whole).max()) ** 2))


def test_an_impact_without_speed_has_a_matrix_but_no_multipliers() -> None:
    entry = FIGURES["branch_21"]
    point = next(point for point in entry["points"] if point["type"] == "grazing_impact_dies")
    orbit = figure_at(entry, point)
    assert np.isfinite(orbit.linearised()).all()
    assert abs(np.linalg.det(orbit.linearised())) > 0.1
    assert orbit.multipliers().largest > 1e9  # the speed is rounding


def test_too_many_modes_are_refused() -> None:
    system = System(s=5.0, d=0.01, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    with pytest.raises(ParameterError, match="at most 512 modes"):
        PeriodicOrbit(system, 1, (0.4, 2.3), 513).multipliers()


# -- one list of reasons -----------------------------------------------------------------------------------------------


SENTENCES = {
    Reason.STABLE: ("stable: ",),
    Reason.FOLD: ("unstable, beyond the fold", "fold: ", "one of a continuum", "two motions meet here"),
    Reason.FLIP: ("flip",),
    Reason.SPIRAL: ("unstable, a spiral",),
    Reason.ELASTIC: ("elastic mode ",),
    Reason.NEUTRAL: ("neutral: ",),
}


def test_the_numbers_in_archives_keep_their_words() -> None:
    assert REASONS == ("stable", "fold", "flip", "spiral", "elastic", "neutral")
    assert tuple(Reason(word) for word in REASONS) == VERDICTS
    assert len({reason.words for reason in Reason}) == len(Reason)


@settings(max_examples=30, deadline=None)
@given(
    s=st.floats(0.7, 30.0),
    d=st.sampled_from([0.0, 0.01, 0.3]),
    restitution=st.floats(0.0, 0.95),
    factor=st.floats(0.05, 1.5),
    periods=st.integers(1, 3),
    modes=st.sampled_from([0, 4, 12]),
)
def test_the_kind_is_what_the_largest_multiplier_does(
    s: float, d: float, restitution: float, factor: float, periods: int, modes: int
) -> None:
    system = System(s=s, d=d, restitution=restitution, load=Load.harmonic(factor, 1.0))
    for orbit in steady_states(system, periods).orbits:
        found = stability_of(orbit, modes=modes)
        largest = max(found.multipliers.values, key=abs)
        assert found.reason.startswith(SENTENCES[found.kind])
        told = re.search(r"(?:by a factor of|multiplier) (-?\d+\.\d+)", found.reason)
        assert told is None or abs(float(told[1])) == pytest.approx(abs(largest), rel=0, abs=6e-4)
        assert (found.kind is Reason.STABLE) == found.stable
        if orbit.fold or found.stable:
            continue
        assert found.kind is Reason.NEUTRAL or abs(largest) > 1.0
        if found.kind is Reason.ELASTIC:
            assert max(found.reduced.moduli) < 1.0
        if found.kind in (Reason.FOLD, Reason.FLIP):
            assert abs(largest.imag) <= 1e-6 * abs(largest)
            assert (largest.real > 0.0) == (found.kind is Reason.FOLD)
        if found.kind is Reason.SPIRAL:
            assert abs(largest.imag) > 1e-6 * abs(largest)


@pytest.mark.parametrize("s", [0.9, 2.2, 7.0])
def test_a_map_gives_the_reason_of_the_verdict(s: float) -> None:
    """Soft bars too, in which an elastic mode has the greatest share in a flip that B77's criterion sees as well."""
    system = System(s=s, d=0.001, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    axes = ("restitution=0.1:0.9:6", "load_factor=0.1:1.0:6")
    found = sweep(system, *axes, quantities=["reason", "margin"], modes=8, workers=1)
    seen = set()
    for (i, j), number in np.ndenumerate(found["reason"]):
        there = system.with_restitution(found.axes[0].values[i]).with_load_factor(found.axes[1].values[j])
        verdicts = [stability_of(orbit, modes=8) for orbit in steady_states(there, modes=8).orbits]
        if not verdicts:
            assert number == -1
            continue
        best = max(verdicts, key=lambda verdict: verdict.margin)
        assert REASONS[number] == best.kind.value
        seen.add(best.kind)
    assert len(seen) > 1


def test_an_orbit_that_is_not_physical_says_why() -> None:
    seen = set()
    for s in (0.25, 1.1, 20.0):
        for factor in (0.1, 0.25, 0.5, 0.9):
            system = System(s=s, d=0.01, restitution=0.21, load=Load.harmonic(factor, 1.0))
            for orbit in (*steady_states(system, 1).orbits, *steady_states(system, 2).orbits):
                seen.add(orbit.obstacle)
                assert orbit.admissible == (orbit.obstacle is None)
                assert (orbit.obstacle is Reason.NO_BLOW) == (orbit.impact_velocity <= 0.0)
                if orbit.obstacle is Reason.THROUGH_WALL:
                    assert orbit.motion(np.linspace(0.0, orbit.period, 4001)).max() > 0.0
    assert seen == {None, Reason.NO_BLOW, Reason.THROUGH_WALL}
