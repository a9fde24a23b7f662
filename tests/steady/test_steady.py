"""Steady motions against the oracle: all phases, the state, the fields, energy, admissibility, rest."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import naive
from naive import mp
from percuss import Load, System, rest_on_wall, steady_states
from percuss.errors import LoadError, ParameterError, ResonanceError
from percuss.model import UniformBar
from percuss.steady import Orbit
from percuss.steady.forced import forced_response
from percuss.steady.oscillator import free_sum
from percuss.steady.phases import Arcs
from strategies import (
    Drawn,
    coefficients,
    dampings,
    fourier_systems,
    highest_velocity,
    level_of_one,
    oracle,
    restitutions,
    square_systems,
    wave_speeds,
)

ENTRIES = naive.reference()
STATES = [pytest.param(entry, i, id=f"{entry['name']}-{i}") for entry in ENTRIES for i in range(len(entry["states"]))]
TURN = 2.0 * math.pi


def system_of(entry: dict[str, Any]) -> System:
    load = Load.fourier(entry["load"]["coefficients"])
    return System(s=entry["s"], d=entry["d"], restitution=entry["R"], load=load)


def turned(a: float, b: float) -> float:
    """Distance of two phases on the circle."""
    return abs((a - b + math.pi) % TURN - math.pi)


def ringing(orbit: Orbit) -> float:
    """How many times a mode moves its usual share near a resonance with the load or the impacts: where it is large,
    rounding of the frequencies themselves decides the last digits."""
    system, modes = orbit.system, max(1, min(orbit.modes, 2048))
    omega = np.pi * system.s * np.arange(1, modes + 1)[:, None]
    k = system.load.harmonics[None, :]
    with_load = float((omega**2 / np.abs(omega**2 - k * (k - 1j * system.d))).max())
    divisor = orbit.modal_state(modes).divisor
    with_impacts = float(1.0 / max(divisor.min(), 1e-300)) if system.restitution < 1.0 or system.d > 0.0 else 1.0
    return max(with_load, with_impacts)


# ---------------------------------------------------------------- the 14 reference cases


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry["name"])
def test_reference_levels(entry: dict[str, Any]) -> None:
    found = steady_states(system_of(entry), entry["m"])
    assert found.level == pytest.approx(float(entry["level_c"]), rel=1e-13)
    assert len(found.orbits) == len(entry["states"])
    assert found.exists
    assert found.level <= found.level_max
    phases = [orbit.phase for orbit in found.orbits]
    assert phases == sorted(phases)


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_reference_states(entry: dict[str, Any], i: int) -> None:
    state = entry["states"][i]
    found = steady_states(system_of(entry), entry["m"], modes=16)
    assert turned(found.orbits[i].phase, float(state["phi"])) < 1e-12
    speed = float(state["striking_speed_N16"])
    assert found.orbits[i].impact_velocity == pytest.approx(speed, rel=1e-8)
    assert found.orbits[i].impact_velocity == pytest.approx(speed, rel=1e-11, abs=1e-12)  # and better than asked
    assert found.orbits[i].modes == 16


# ---------------------------------------------------------------- the level


@given(st.one_of(st.just(0.0), st.floats(-300, 4).map(lambda x: 10.0**x)), restitutions, st.integers(1, 1000))
def test_level_keeps_its_digits(d: float, r: float, m: int) -> None:
    """c of B77 (14), from d = 0 through 1e-300 to overflow: 1e-13 relative (theory §4)."""
    from percuss.steady import level

    assume(d * m < 1e4 or d == 0.0)
    with mp.workdps(60):
        expected = naive.level(naive.Case.of(naive.Fourier.of([1, 1]), 1, d, r, m)) if d > 1e-40 or d == 0 else None
    ours = float(level(1.0, d, r, TURN * m))
    if expected is None:  # the textbook form wants 300 digits there; the limit is as good: c = c(0) + d T**2/12
        period = TURN * m
        expected = period * (1 - r) / (2 * (1 + r)) + d * period**2 / 12
    assert ours == pytest.approx(float(expected), rel=1e-13)


# ---------------------------------------------------------------- all phases, and no others


def companion_phases(alternating: list[complex], d: float, level: float) -> tuple[NDArray[np.float64], float]:
    """Real roots of v_f = level by companion eigenvalues, and how clearly the others are off the circle."""
    k = np.arange(1, len(alternating) + 1)
    half = np.array(alternating) / (d + 1j * k) / 2.0
    while half.size and half[-1] == 0:
        half = half[:-1]
    polynomial = np.concatenate([half[::-1], [-level], np.conj(half)])
    roots = np.roots(polynomial)
    off = np.abs(np.log(np.abs(roots)))
    on = off < 1e-6
    clear = float(np.min(off[~on], initial=1.0)) if np.all(off[on] < 1e-9) else 0.0
    gaps = np.diff(np.sort(np.mod(np.angle(roots[on]), TURN)))
    return np.sort(np.mod(np.angle(roots[on]), TURN)), min(clear, float(gaps.min(initial=1.0)))


@settings(max_examples=125)
@given(coefficients(20), dampings, restitutions, st.integers(1, 10), st.floats(1e-3, 1.2))
def test_every_phase_is_found(alternating: list[complex], d: float, r: float, m: int, share: float) -> None:
    unit = level_of_one(d, r, m)
    mean = share * (highest_velocity(alternating, d) / unit if unit > 1e-3 else 1.0)
    assume(mean > 1e-9)
    system = System(s=1e3 / math.e, d=d, restitution=r, load=Load.fourier(np.array([mean, *alternating])))
    found = steady_states(system, m)
    if found.note:
        return  # R = 1 without damping: see below
    phases = np.array([orbit.phase for orbit in found.orbits])
    size = sum(abs(p) / abs(d + 1j * k) for k, p in enumerate(alternating, 1))
    assert np.abs(found.rigid_velocity(phases) - found.level).max(initial=0.0) <= 1e-13 * size
    assert np.all((phases >= 0.0) & (phases < TURN))
    expected, clearance = companion_phases(alternating, d, found.level)
    if clearance > 1e-5:
        assert phases.size == expected.size
        assert all(np.min([turned(a, b) for b in expected]) < 1e-5 for a in phases)
        assert all(np.min([turned(a, b) for b in phases]) < 1e-5 for a in expected)


@settings(max_examples=100)
@given(coefficients(8), dampings, st.floats(-1.0, 1.0), st.sampled_from([0.0, 1e-3, 1e-6, 1e-9, 1e-12]))
def test_a_few_phases_are_those_of_many(alternating: list[complex], d: float, share: float, near: float) -> None:
    """A level is met at the same phases alone and in a row of levels, near the ends of an arc as well."""
    assume(sum(map(abs, alternating)) > 1e-6)
    response = forced_response(System(s=math.e, d=d, restitution=0.5, load=Load.fourier(np.array([0.5, *alternating]))))
    arcs = Arcs.of(response)
    slack = arcs.tolerance + 4e-15 * response.rigid_bounds()[1]  # the rounding of a phase, too
    low, high = np.sort([arcs.velocities[:-1], arcs.velocities[1:]], axis=0)
    middle = 0.5 * (low + high) + share * (0.5 - near) * (high - low)
    for arc in np.flatnonzero(high - low > 4.0 * arcs.tolerance):
        row = arcs.invert(np.full(9, arc), np.full(9, middle[arc]))
        assert np.ptp(row) == 0.0
        for phase in (arcs.phase_on(int(arc), middle[arc]), row[0]):
            assert arcs.ends[arc] - 1e-9 <= phase <= arcs.ends[arc + 1] + 1e-9
            assert abs(float(response.rigid_velocity(phase)) - middle[arc]) <= slack


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1e-20, 1e20, 1e100])
def test_the_phases_do_not_depend_on_the_size_of_the_load(scale: float) -> None:
    def phases(size: float) -> list[float]:
        load = Load.fourier(size * np.array([0.3, 1.0, 0.5]))
        return [orbit.phase for orbit in steady_states(System(s=8.0, d=0.01, restitution=0.3, load=load)).orbits]

    assert len(phases(1.0)) == 2
    assert phases(scale) == pytest.approx(phases(1.0), abs=1e-13)


@settings(max_examples=25)
@given(fourier_systems(12))
def test_every_phase_by_polynomial_roots_in_many_digits(drawn: Drawn) -> None:
    system, m = drawn
    assume(system.restitution < 1.0 or system.d > 1e-9)
    found = steady_states(system, m)
    case = oracle(system, m)
    expected = naive.phases(case)
    if any(orbit.fold for orbit in found.orbits):
        return
    assert len(found.orbits) == len(expected)
    size = float(sum(abs(p) / abs(case.d + 1j * k) for k, p in case.load.harmonics()))
    for orbit, phase in zip(found.orbits, expected, strict=True):
        slope = abs(float(naive.v_f_slope(case, phase)))
        flat = math.sqrt(1e-15)  # at a fold half of the digits are lost, whatever the method
        assert turned(orbit.phase, float(phase)) < 1e-14 + min(4e-15 * size / max(slope, 1e-300), 10 * flat)


@pytest.mark.parametrize("b", range(2, 13))
def test_every_phase_of_loads_with_symmetries(b: int) -> None:
    """Two equal harmonics: critical points and roots fall on round fractions of the circle, where cells meet."""
    for a in range(1, b):
        for turn in (1, 1j, -1, -1j):
            alternating = [0j] * b
            alternating[a - 1], alternating[b - 1] = 1.0 + 0j, complex(turn)
            for share in (0.05, 0.37, 0.5, 0.9):
                mean = share * highest_velocity(alternating, 0.0) / math.pi
                found = steady_states(System(s=7.0, d=0.0, restitution=0.0, load=Load.fourier([mean, *alternating])))
                expected, clearance = companion_phases(alternating, 0.0, found.level)
                if clearance < 1e-5:
                    continue
                assert len(found.orbits) == expected.size, (a, b, turn, share)
                assert all(np.min([turned(o.phase, y) for y in expected]) < 1e-7 for o in found.orbits)


@pytest.mark.parametrize(("a", "b", "roots"), [(5, 7, 14), (1, 5, 10), (3, 5, 10), (1, 7, 14), (3, 7, 14), (5, 9, 18)])
def test_critical_points_on_round_fractions(a: int, b: int, roots: int) -> None:
    """cos a t + cos b t = 2 cos((a + b)t/2) cos((b - a)t/2)."""
    from percuss.steady.trigonometric import trigonometric_roots

    found = trigonometric_roots(np.array([a, b], dtype=float), np.array([1.0, 1.0], dtype=complex))
    sums, differences = (a + b) // 2, (b - a) // 2
    expected = np.unique(
        np.round([(2 * j + 1) * math.pi / (2 * n) for n in (sums, differences) for j in range(2 * n)], 12)
    )
    assert expected.size == roots
    assert found == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("K", [1, 2, 7])
@pytest.mark.parametrize("excess", [-1e-2, -1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6, 1e-2])
def test_near_the_fold(K: int, excess: float) -> None:
    """At the maximum of v_f two phases meet; just below there are two, just above none, at it one or two."""
    rng = np.random.default_rng(K)
    alternating = (rng.normal(size=K) + 1j * rng.normal(size=K)).tolist()
    half = [mp.mpc(p) for p in alternating]

    def v(t: Any) -> Any:
        return mp.re(mp.fsum(p * mp.expj(k * t) / (1j * k) for k, p in enumerate(half, 1)))

    start = np.linspace(0, TURN, 10001)
    best = start[np.argmax([float(v(t)) for t in start[::10]]) * 10]
    peak = mp.findroot(lambda t: mp.re(mp.fsum(p * mp.expj(k * t) for k, p in enumerate(half, 1))), mp.mpf(best))
    level = float(v(peak)) * (1.0 + excess)
    mean = level / level_of_one(0.0, 0.4, 2)
    found = steady_states(System(s=7.0, d=0.0, restitution=0.4, load=Load.fourier(np.array([mean, *alternating]))), 2)
    others = sum(1 for orbit in found.orbits if turned(orbit.phase, float(peak)) > 0.3)
    near = [orbit for orbit in found.orbits if turned(orbit.phase, float(peak)) <= 0.3]
    assert others % 2 == 0
    if excess < -1e-13:
        assert len(near) == 2
        curve = abs(float(mp.diff(v, peak, 2)))
        reach = math.sqrt(2 * level * -excess / curve)
        tolerance = 0.05 * reach + 1e-15 / reach
        assert [turned(orbit.phase, float(peak)) for orbit in near] == pytest.approx([reach, reach], abs=tolerance)
        assert not any(orbit.fold for orbit in near)
    elif excess > 1e-13:
        assert not near
        if not found.orbits:
            assert found.nearest is not None
            assert found.nearest.load_factor == pytest.approx(found.system.load.load_factor / (1 + excess), rel=1e-12)
    else:
        assert len(near) in (1, 2)
        assert any(orbit.fold for orbit in near)


@given(fourier_systems(8, shares=st.floats(1.01, 5.0)))
def test_the_nearest_existing_motion(drawn: Drawn) -> None:
    system, m = drawn
    found = steady_states(system, m)
    assume(not found.exists and not found.note)
    assert found.level > found.level_max
    nearest = found.nearest
    assert nearest is not None
    for factor, exists in ((1 - 1e-9, True), (1 + 1e-9, False)):
        moved = steady_states(system.with_load_factor(nearest.load_factor * factor), m)
        assert bool(moved.orbits) is exists
        assert moved.system.load.mean == pytest.approx(nearest.mean * factor, rel=1e-12)
    if nearest.restitution is None:
        assert not steady_states(system.with_restitution(1.0), m).orbits
    else:
        assert nearest.restitution > system.restitution
        moved = steady_states(system.with_restitution(min(1.0, nearest.restitution * (1 + 1e-9))), m)
        assert moved.orbits or moved.note
        assert not steady_states(system.with_restitution(nearest.restitution * (1 - 1e-9)), m).orbits


def test_loads_without_steady_impacts() -> None:
    for load in (
        Load.fourier([1.0]),
        Load.harmonic(0.0, 1.0),
        Load.harmonic(-0.1, 1.0),
        Load.square(1.0, 1.0),
        Load.square(1.0, 0.7),
    ):
        with pytest.raises(LoadError):
            steady_states(System(s=5.0, d=0.1, restitution=0.5, load=load))
    constant = Load.steps([0.0, 1.0], [2.0, 2.0])
    with pytest.raises(LoadError, match="constant"):
        steady_states(System(s=5.0, d=0.1, restitution=0.5, load=constant))


@pytest.mark.parametrize("value", [0, -1, 1.5, True, "2", None, 10**9])
def test_periods_are_whole_numbers(value: Any) -> None:
    system = System(s=5.0, d=0.1, restitution=0.5, load=Load.harmonic(0.1, 1.0))
    with pytest.raises(ParameterError) as caught:
        steady_states(system, value)
    assert caught.value.name == "periods"
    with pytest.raises(ParameterError) as caught:
        steady_states(system, modes=-1 if value is None else value if value != 0 else -3)
    assert caught.value.name == "modes"
    with pytest.raises(ParameterError) as caught:
        steady_states(system, tolerance=0.0 if value in (None, 10**9, 1.5) else "x")
    assert caught.value.name == "tolerance"


@pytest.mark.parametrize(("k", "n"), [(1, 1), (3, 1), (3, 2), (20, 7), (1, 3)])
def test_exact_resonance_is_refused(k: int, n: int) -> None:
    s = k / (n * math.pi)
    load = Load.fourier([0.01, *[0.0] * (k - 1), 1.0])
    with pytest.raises(ResonanceError) as caught:
        steady_states(System(s=s, d=0.0, restitution=0.5, load=load))
    assert caught.value.harmonic == k
    assert caught.value.mode * k == n * k
    assert str(k) in str(caught.value)
    assert steady_states(System(s=s * (1 + 1e-9), d=0.0, restitution=0.5, load=load)).exists
    assert steady_states(System(s=s, d=1e-6, restitution=0.5, load=load)).exists
    absent = Load.fourier([0.01, *[0.0] * k, 1.0])
    if n * (k + 1) % k:
        assert steady_states(System(s=s, d=0.0, restitution=0.5, load=absent)).exists


# ---------------------------------------------------------------- the square wave in closed form (theory §7)


@given(st.floats(0.1, 10), st.floats(1.001, 1.999), restitutions, st.integers(1, 10), wave_speeds)
def test_undamped_square_in_closed_form(q: float, kappa: float, r: float, m: int, s: float) -> None:
    found = steady_states(System(s=s, d=0.0, restitution=r, load=Load.square(q, kappa)), m)
    top, c = math.pi * q * kappa * (2 - kappa) / 2, TURN * m * q * (kappa - 1) * (1 - r) / (2 * (1 + r))
    assert found.level == pytest.approx(c, rel=1e-12, abs=1e-15 * q)
    assert found.level_max == pytest.approx(top, rel=1e-12)
    margin = kappa * (2 - kappa) * (1 + r) - 2 * m * (kappa - 1) * (1 - r)
    assume(abs(margin) > 1e-9)
    if r == 1.0:
        return
    assert len(found.orbits) == (2 if margin > 0 else 0)
    if found.orbits:  # a triangle: up with slope q(2 - kappa) from -top, down with q kappa from top
        expected = [(c + top) / (q * (2 - kappa)), kappa * math.pi + (top - c) / (q * kappa)]
        assert [orbit.phase for orbit in found.orbits] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("r", [0.0, 0.1, 0.5, 0.9])
def test_limit_of_the_hydraulic_hammer(r: float) -> None:
    """Fig. 8: m = 1 exists for kappa up to (1 - rho) + sqrt(1 + rho**2)."""
    rho = (1 - r) / (1 + r)
    limit = 1 - rho + math.sqrt(1 + rho**2)

    def count(kappa: float) -> int:
        return len(steady_states(System(s=5.0, d=0.0, restitution=r, load=Load.square(1.0, kappa))).orbits)

    assert count(limit * (1 - 1e-12)) == 2
    assert count(limit * (1 + 1e-12)) == 0
    at = steady_states(System(s=5.0, d=0.0, restitution=r, load=Load.square(1.0, limit)))
    assert len(at.orbits) in (0, 1, 2)
    if len(at.orbits) == 1:
        assert at.orbits[0].fold
        assert at.orbits[0].phase == pytest.approx(limit * math.pi, rel=1e-12)


@settings(max_examples=20)
@given(square_systems())
def test_damped_square_against_the_oracle(drawn: Drawn) -> None:
    system, m = drawn
    assume(system.restitution < 1.0 or system.d > 1e-9)
    found = steady_states(system, m)
    case = oracle(system, m)
    top = float(naive.v_f(case, case.load.breaks[1]))
    assert found.level_max == pytest.approx(top, rel=1e-12)
    assume(abs(found.level / top - 1) > 1e-10)
    expected = naive.phases(case)
    assert len(found.orbits) == len(expected)
    for orbit, phase in zip(found.orbits, expected, strict=True):
        slope = abs(float(naive.v_f_slope(case, phase)))
        assert turned(orbit.phase, float(phase)) < 1e-13 + 1e-14 * top / max(slope, 1e-9 * top)


# ---------------------------------------------------------------- energy (theory §4)


def energy_scale(orbit: Orbit) -> float:
    """The energy put in; where it is the small rest of large exchanges to and fro, a little of those as well."""
    load, d = orbit.system.load, orbit.system.d
    k = load.harmonics
    gross = orbit.period * float(np.sum(np.abs(load.coefficients[k]) ** 2 / np.abs(d + 1j * k)))
    state = orbit.state
    stored = float(np.sum((state.omega * state.displacement) ** 2 + state.velocity**2))  # large near a resonance
    return abs(orbit.energy.input) + 1e-3 * (orbit.blow_energy + gross + stored)


def closes(drawn: Drawn, modes: int | None) -> None:
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:4]:
        amplified = max(1.0, 1e-4 * ringing(orbit))
        assert abs(orbit.energy.imbalance) <= 1e-10 * amplified * energy_scale(orbit)
        assert orbit.energy.impact >= 0.0
        assert orbit.energy.damping >= -1e-10 * amplified * energy_scale(orbit)
        if drawn.system.d == 0.0:
            assert orbit.energy.damping == 0.0


@settings(max_examples=150)
@given(st.one_of(fourier_systems(), square_systems()), st.sampled_from([0, 1, 8, 30]))
def test_energy_closes_with_fixed_modes(drawn: Drawn, modes: int) -> None:
    closes(drawn, modes)


@settings(max_examples=35)
@given(st.one_of(fourier_systems(12), square_systems()))
def test_energy_closes_for_the_continuous_bar(drawn: Drawn) -> None:
    closes(drawn, None)


@settings(max_examples=10, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(fourier_systems(5), st.integers(0, 6))
def test_energy_terms_by_quadrature(drawn: Drawn, modes: int) -> None:
    assume(drawn.system.s < 30 and drawn.periods <= 5 and (drawn.system.d > 1e-6 or drawn.system.restitution < 1))
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:1]:
        assume(ringing(orbit) < 1e4)
        expected = naive.energy(naive.orbit(oracle(*drawn), orbit.phase, modes))
        scale = energy_scale(orbit)
        assert orbit.energy.input == pytest.approx(expected.input, abs=1e-9 * scale)
        assert orbit.energy.damping == pytest.approx(expected.damping, abs=1e-9 * scale)
        assert orbit.energy.impact == pytest.approx(expected.impact, abs=1e-9 * scale)


# ---------------------------------------------------------------- the fields


def compare_fields(orbit: Orbit, case: naive.Case, modes: int, tolerance: float = 1e-10) -> None:
    twin = naive.orbit(case, orbit.phase, modes)
    x, t = [0.0, 0.31, 1.0], [0.0, 0.013 * orbit.period, 0.62 * orbit.period, orbit.period]
    field = orbit.field(x, t)
    expected = np.array([[[float(v) for v in naive.field(twin, a, b)] for b in t] for a in x])
    speed = float(max(abs(expected[:, :, 1]).max(), orbit.rigid_velocity))
    scales = (speed * orbit.period, speed * max(1.0, modes), speed * max(1.0, modes))
    for ours, theirs, scale in zip(field, np.moveaxis(expected, 2, 0), scales, strict=True):
        assert np.abs(ours - theirs).max() <= tolerance * scale
    assert orbit.position(x, t) == pytest.approx(field.displacement, abs=1e-300)
    assert orbit.impact_velocity == pytest.approx(float(naive.striking_speed(twin)), abs=tolerance * speed)
    assert orbit.blow_energy == pytest.approx(float(naive.blow_energy(twin)), rel=tolerance)
    assert orbit.impact_field(x) == pytest.approx(field.velocity[:, -1], abs=tolerance * speed * max(1, modes))


@settings(max_examples=40)
@given(st.one_of(fourier_systems(6), square_systems()), st.sampled_from([0, 1, 5, 12]))
def test_fields_are_the_modal_sums(drawn: Drawn, modes: int) -> None:
    assume(drawn.system.restitution < 1.0 or drawn.system.d > 1e-6)
    orbits = steady_states(drawn.system, drawn.periods, modes=modes).orbits
    assume(orbits and ringing(orbits[-1]) < 1e4)
    compare_fields(orbits[-1], oracle(*drawn), modes)


@pytest.mark.parametrize("s", [0.4, 2.0])
@pytest.mark.parametrize("d", [3.0, 8.0])
def test_overdamped_modes(s: float, d: float) -> None:
    load = Load.fourier([0.02, 1.0, 0.3j])
    system = System(s=s, d=d, restitution=0.3, load=load)
    for orbit in steady_states(system, 2, modes=6).orbits:
        compare_fields(orbit, oracle(system, 2), 6)


def test_critically_damped_mode() -> None:
    """d = 2 n pi s for n = 1, to the last digit and a little beside it."""
    for change in (0.0, 1e-15, -1e-12, 1e-9, 1e-5, -1e-3):
        s = 0.5
        system = System(s=s, d=TURN * s * (1 + change), restitution=0.3, load=Load.fourier([0.02, 1.0]))
        for orbit in steady_states(system, modes=4).orbits:
            compare_fields(orbit, oracle(system, 1), 4)


@settings(max_examples=20)
@given(fourier_systems(6), st.floats(0.05, 0.95), st.floats(0.05, 0.95))
def test_velocity_and_strain_are_slopes(drawn: Drawn, x: float, share: float) -> None:
    orbits = steady_states(drawn.system, drawn.periods, modes=6).orbits
    assume(orbits and drawn.system.s < 50)
    orbit = orbits[0]
    t = share * orbit.period
    h = 1e-4 / (6 * math.pi * max(1.0, drawn.system.s, 20 / 6))
    along = orbit.position([x - h, x, x + h], t)[:, 0]
    ahead = orbit.position(x, [t - h, t, t + h])[0]
    size = 2.0 * float(orbit.state.amplitude.sum()) + float(np.abs(ahead).max()) + float(np.abs(along).max())
    slack = 1e-8 * size / 1e-4 * 6 * math.pi * max(1.0, drawn.system.s, 20 / 6)
    assert (along[2] - along[0]) / (2 * h) == pytest.approx(float(orbit.strain(x, t)[0, 0]), abs=slack)
    assert (ahead[2] - ahead[0]) / (2 * h) == pytest.approx(float(orbit.velocity(x, t)[0, 0]), abs=slack)


@settings(max_examples=30)
@given(st.one_of(fourier_systems(), square_systems()), st.sampled_from([0, 7]))
def test_the_impact(drawn: Drawn, modes: int) -> None:
    """y = 0 at both ends of the flight; the displacement stays, the whole velocity field turns over (B77 10)."""
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:3]:
        x, ends = np.linspace(0, 1, 7), np.array([0.0, orbit.period])
        assume(ringing(orbit) < 1e5)
        u, v, _ = orbit.field(x, ends)
        size = orbit.stroke + float(orbit.state.amplitude.sum())
        assert np.abs(orbit.motion(ends)).max() <= 1e-11 * size
        assert np.abs(u[:, 0] - u[:, 1]).max() <= 1e-10 * size
        speed = float(np.abs(v).max()) + orbit.rigid_velocity
        assert np.abs(v[:, 0] + drawn.system.restitution * v[:, 1]).max() <= 1e-9 * speed
        assert orbit.rebound_velocity == pytest.approx(v[-1, 0], abs=1e-9 * speed)
        assert orbit.impact_velocity == pytest.approx(v[-1, 1], abs=1e-9 * speed)
        mean = drawn.system.load.mean * orbit.period / (1 + drawn.system.restitution)
        assert orbit.rigid_velocity == pytest.approx(mean, rel=1e-14)
        later = orbit.motion(0.3 * orbit.period + orbit.period)  # the motion goes on
        assert later == pytest.approx(orbit.motion(0.3 * orbit.period), abs=1e-9 * size)


def test_shapes_of_the_fields() -> None:
    orbit = steady_states(System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))).orbits[1]
    assert orbit.position([0.1, 0.2, 0.3], [1.0, 2.0]).shape == (3, 2)
    assert orbit.velocity(0.5, 1.0).shape == orbit.strain(0.5, 1.0).shape == (1, 1)
    assert orbit.motion([1.0, 2.0, 3.0]).shape == orbit.driven_end([1.0, 2.0, 3.0]).shape == (3,)
    assert orbit.impact_field([0.0, 1.0]).shape == (2,)
    assert orbit.driven_end(1.0)[0] == orbit.position(0.0, 1.0)[0, 0]


@pytest.mark.parametrize(("s", "d"), [(20.0, 0.0048), (3.0, 0.3), (1.3, 1.0)])
def test_boundary_conditions_of_the_continuous_bar(s: float, d: float) -> None:
    """-s**2 u_x(0, t) = p(t) and u_x(1, t) = 0 (B77 4), with all modes of the forced part."""
    load = Load.fourier([0.2, 1.0, 0.3 - 0.2j])
    for orbit in steady_states(System(s=s, d=d, restitution=0.5, load=load)).orbits:
        t = np.linspace(0.2, 0.8, 5) * orbit.period
        p = load.value(orbit.phase + t)
        strain = orbit.strain([0.0, 1.0], t)
        assert -(s**2) * strain[0] == pytest.approx(p, abs=1e-12)
        assert strain[1] == pytest.approx(0.0, abs=1e-12)
        inside = np.array([0.01, 0.02, 0.03, 0.04])  # and it is a limit, not a value at one point
        near = -(s**2) * orbit.strain(inside, t)
        weights = np.array([4.0, -6.0, 4.0, -1.0])
        assert weights @ near == pytest.approx(p, abs=1e-2 * float(np.abs(p).max()))


@pytest.mark.parametrize(("s", "d", "r"), [(20.0, 0.0048, 0.6), (2.3, 0.01, 0.3), (5.0, 0.0, 0.8), (0.7, 0.5, 0.0)])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_error_bound_bounds(s: float, d: float, r: float, tolerance: float) -> None:
    """The default sums against ones with many more modes."""
    load = Load.fourier([0.05, 1.0, 0.3 - 0.2j])
    system = System(s=s, d=d, restitution=r, load=load)
    for orbit in steady_states(system, tolerance=tolerance).orbits:
        best = Orbit(system, 1, orbit.phase, tolerance=1e-13)
        t = np.linspace(0.0, orbit.period, 301)[1:-1]
        error = np.abs(orbit.motion(t) - best.motion(t)).max()
        stroke = np.ptp(orbit.rigid_motion(np.linspace(0, orbit.period, 500))[0])
        assert error <= (orbit.error_bound + best.error_bound) * stroke + 1e-13
        assert orbit.error_bound <= tolerance or orbit.warnings


@settings(max_examples=25)
@given(st.one_of(fourier_systems(5), square_systems()), st.sampled_from([2, 5, 20]))
def test_error_bound_of_fixed_modes(drawn: Drawn, modes: int) -> None:
    assume(drawn.system.restitution < 1.0 or drawn.system.d > 1e-3)
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:1]:
        best = Orbit(drawn.system, drawn.periods, orbit.phase, requested_modes=600)
        t = np.linspace(0.0, orbit.period, 200)
        error = float(np.abs(orbit.motion(t) - best.motion(t)).max())
        stroke = float(np.ptp(orbit.rigid_motion(np.linspace(0, orbit.period, 64 * drawn.periods + 1))[0]))
        assert error <= 2.0 * (orbit.error_bound + best.error_bound) * stroke * (1 + 1e-9) + 1e-12 * stroke


# ---------------------------------------------------------------- admissibility (theory §4)


def looked(orbit: Orbit, samples: int = 4_001) -> tuple[float | None, float]:
    """First time and greatest depth of a passage through the wall, by a dense look at plain sums and bisection."""
    n = np.arange(1, orbit.modes + 1)
    signs, state = 2.0 * (-1.0) ** n, orbit.state

    def y(t: NDArray[np.float64]) -> NDArray[np.float64]:
        if orbit.requested_modes is None:
            return orbit.motion(t)
        rigid = orbit.rigid_motion(t)[0]
        forced = signs @ orbit.response.modal(orbit.modes, orbit.phase + t)[0]
        free = signs @ orbit.transient(t)[0]
        start = signs @ state.displacement
        return np.asarray(rigid + forced + free - start)

    t = np.linspace(0.0, orbit.period, samples)
    values = np.concatenate([y(part) for part in np.array_split(t, 8)])
    inside = values[1:-1]
    touch = 1e-12 * float(np.ptp(values))
    above = np.flatnonzero(inside > touch) + 1
    depth = float(inside.max(initial=0.0))
    for i in np.argsort(inside)[-20:] + 1:  # a peak may be narrower than the samples
        depth = max(depth, float(y(np.linspace(t[i - 1], t[i + 1], 41)[1:-1]).max()))
    if not above.size:
        return None, depth
    high = float(t[above[0]])
    low = float(t[above[0] - 1])
    if above[0] > 1:
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if y(np.array([middle]))[0] > touch else (middle, high)
    return high, depth


def agrees_with_a_look(drawn: Drawn, modes: int | None) -> None:
    for orbit in steady_states(drawn.system, drawn.periods, modes=modes).orbits[:3]:
        time, depth = looked(orbit)
        step = orbit.period / 4_000
        violation = orbit.violation
        assert orbit.admissible == (violation is None and orbit.impact_velocity > 0.0)
        if violation is None:
            assert orbit.proven is False or depth <= 1e-11 * orbit.stroke, "missed a passage"
            continue
        assert violation.depth >= depth * (1 - 1e-4) - 1e-10 * orbit.stroke, "depth seen by looking is greater"
        if time is not None:
            assert violation.time <= time + 1e-6, "first passage seen by looking is earlier"
            assert violation.depth <= depth + 0.02 * abs(depth) + 1e-6 * orbit.stroke
            if violation.time < time - 1e-6:  # a passage between two looks: there it is
                assert time <= 2 * step or float(orbit.motion(violation.time)[0]) > -1e-12 * orbit.stroke
        else:
            assert violation.time <= step or violation.depth < 1e-3 * orbit.stroke


@pytest.mark.slow
@settings(max_examples=40)
@given(st.one_of(fourier_systems(6), square_systems()), st.sampled_from([0, 3, 12]))
def test_admissibility_against_a_dense_look(drawn: Drawn, modes: int) -> None:
    agrees_with_a_look(drawn, modes)


@settings(max_examples=20)
@given(fourier_systems(4, shares=st.floats(0.3, 0.999)))
def test_admissibility_when_the_bar_starts_from_rest(drawn: Drawn) -> None:
    """R = 0: velocity and displacement both start from 0, the acceleration decides."""
    agrees_with_a_look(Drawn(drawn.system.with_restitution(0.0), drawn.periods), 4)


@pytest.mark.parametrize(
    ("s", "kappa", "m"), [(28.193157324501545, 1.0088981358396545, 6), (47.166362167614196, 1.0299502290001574, 3)]
)
def test_depth_is_the_greatest_of_the_flight(s: float, kappa: float, m: int) -> None:
    """A tiny passage comes first, a deep one later."""
    system = System(s=s, d=0.0, restitution=0.0, load=Load.square(1.0, kappa))
    for orbit in steady_states(system, m, modes=12).orbits:
        t = np.concatenate([np.linspace(0, 0.05, 40_001), np.linspace(0, orbit.period, 100_001)])
        seen = float(orbit.motion(t).max())
        if seen > 1e-9:
            assert orbit.violation is not None
            assert orbit.violation.depth == pytest.approx(seen, rel=1e-3)


def test_rigid_bar_without_jerk() -> None:
    """R = 0, no elastic modes, a constant force: the third derivative vanishes."""
    system = System(s=1.0, d=0.0, restitution=0.0, load=Load.square(1.0, 1.2))
    for orbit in steady_states(system, modes=0).orbits:
        time, _ = looked(orbit)
        assert orbit.admissible == (time is None)


@pytest.mark.parametrize("r", [0.0, 0.3, 0.8, 1.0])
def test_rigid_bar_against_its_parabola_and_cosine(r: float) -> None:
    """modes = 0, d = 0: y(t) = p_0 t**2/2 + ... in closed form; violations at its first zero."""
    for m in (1, 3):
        for factor in (0.1, 0.7):
            top = (1 + r) / (math.pi * m * (1 - r)) if r < 1 else 1.0
            system = System(s=10.0, d=0.0, restitution=r, load=Load.harmonic(factor * top, 1.0))
            for orbit in steady_states(system, m, modes=0).orbits:
                p0, phi = system.load.mean, orbit.phase
                w = p0 * orbit.period / (1 + r)
                t = np.linspace(0, orbit.period, 200_001)
                y = p0 * t**2 / 2 - (np.cos(phi + t) - math.cos(phi)) - (r * w + math.sin(phi)) * t
                assert orbit.motion(t[::1000]) == pytest.approx(y[::1000], abs=1e-10)
                bad = np.flatnonzero(y[1:-1] > 1e-11) + 1
                if bad.size:
                    assert orbit.violation is not None
                    assert orbit.violation.time == pytest.approx(t[bad[0]], abs=2 * t[1] + 1e-6)
                    assert orbit.violation.depth == pytest.approx(float(y.max()), rel=1e-6)
                else:
                    assert orbit.admissible


def test_a_bar_that_strikes_backward_is_not_admissible() -> None:
    """Strong ringing can turn the striking speed: it is found out."""
    found = 0
    rng = np.random.default_rng(5)
    for _ in range(200):
        alternating = rng.normal(size=4) + 1j * rng.normal(size=4)
        system = System(
            s=float(rng.uniform(0.3, 1.0)), d=0.01, restitution=0.3, load=Load.fourier([0.02, *alternating])
        )
        for orbit in steady_states(system, modes=10).orbits:
            if orbit.impact_velocity <= 0.0:
                found += 1
                assert not orbit.admissible
                assert orbit.violation is not None  # y falls to 0 from above before the impact, or rises after it
    assert found > 10


def test_a_short_touch_is_not_missed() -> None:
    """Tune the mean load until the bar just grazes the wall in the middle of its flight."""

    def deepest(factor: float) -> tuple[float, Orbit]:
        system = System(s=30.0, d=0.0, restitution=0.6, load=Load.harmonic(factor, 1.0))
        orbit = steady_states(system, 3, modes=0).orbits[0]
        t = np.linspace(0.05, 0.95, 2001) * orbit.period
        y = orbit.motion(t)
        inner = [y[i] for i in range(1, y.size - 1) if y[i] >= y[i - 1] and y[i] >= y[i + 1]]
        if not inner:
            return -1.0, orbit
        fine = t[int(np.flatnonzero(y == max(inner))[0])] + np.linspace(-1, 1, 4001) * t[1]
        return float(orbit.motion(fine).max()), orbit

    factors = np.linspace(0.05, 0.3, 60)
    depths = [deepest(float(f))[0] for f in factors]
    crossing = [i for i in range(59) if (depths[i] > 0) != (depths[i + 1] > 0) and min(depths[i : i + 2]) > -0.9]
    assert crossing
    low, high = float(factors[crossing[0]]), float(factors[crossing[0] + 1])
    if depths[crossing[0]] > 0:
        low, high = high, low
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if deepest(middle)[0] <= 0 else (low, middle)
    graze = 0.5 * (low + high)
    step = 1e-8 * abs(graze) * math.copysign(1.0, high - low)
    assert deepest(graze - step)[1].violation is None
    violation = deepest(graze + step)[1].violation
    assert violation is not None
    assert 0 < violation.depth < 1e-6


# ---------------------------------------------------------------- rest (theory §4)


@settings(max_examples=30)
@given(fourier_systems(8))
def test_rest_against_a_fine_look(drawn: Drawn) -> None:
    system, m = drawn
    rest = rest_on_wall(system)
    assume(math.isfinite(rest.least_contact_force))
    k = system.load.harmonics
    q = np.sqrt(k * (k - 1j * system.d)) / system.s
    force = system.load.coefficients[k] / np.cos(q)
    t = np.linspace(0, TURN, 20001)
    seen = float((system.load.mean + (np.exp(1j * np.outer(t, k)) @ force).real).min())
    size = system.load.mean + float(np.abs(force).sum())
    assert rest.least_contact_force <= seen + 1e-12 * size
    assert rest.least_contact_force >= seen - size * float(k.max()) ** 2 * (t[1] ** 2) - 1e-12 * size
    assert rest.possible == (rest.least_contact_force >= 0.0)
    assert rest.phase is not None
    at = float(naive.contact_force(oracle(system, m), mp.mpf(rest.phase)))
    assert rest.least_contact_force == pytest.approx(
        at, abs=1e-12 * size * max(1.0, float(np.abs(q).max()) * float(np.abs(1 / np.cos(q)).max()))
    )


@given(fourier_systems(8))
def test_rest_of_a_stiff_bar_feels_the_load_itself(drawn: Drawn) -> None:
    load = drawn.system.load
    stiff = rest_on_wall(System(s=1e9, d=drawn.system.d, restitution=0.5, load=load))
    t = np.linspace(0, TURN, 20001)
    seen = float(load.value(t).min())
    size = float(np.abs(load.coefficients).sum())
    assert stiff.least_contact_force == pytest.approx(seen, abs=1e-4 * size)
    assert stiff.least_contact_force == pytest.approx(stiff.quasi_static, abs=1e-12 * size)


def test_rest_in_resonance_and_without_a_period() -> None:
    s = 2 / math.pi  # cos(1/s) = 0: the held bar's first mode
    resting = rest_on_wall(System(s=s, d=0.0, restitution=0.5, load=Load.harmonic(5.0, 1.0)))
    assert not resting.possible
    assert resting.least_contact_force == -math.inf
    assert rest_on_wall(System(s=s, d=0.5, restitution=0.5, load=Load.harmonic(5.0, 1.0))).possible
    assert rest_on_wall(System(s=1.0, d=0.0, restitution=0.5, load=Load.fourier([1.0]))).possible
    assert not rest_on_wall(System(s=1.0, d=0.0, restitution=0.5, load=Load.fourier([-1.0]))).possible


# ---------------------------------------------------------------- the whole oracle once more, in polyroots' own words


def test_impact_history_repeats_the_impact() -> None:
    orbit = steady_states(System(s=5.0, d=0.01, restitution=0.5, load=Load.harmonic(0.5, 1.0)), modes=8).orbits[1]
    rows = orbit.impact_history(3)
    assert rows.shape == (3, 4)
    assert np.diff(rows[:, 0]) == pytest.approx([orbit.period] * 2)
    assert rows[:, 2] == pytest.approx(float(orbit.velocity(1.0, orbit.period)[0, 0]), rel=1e-12)
    assert rows[:, 3] == pytest.approx(float(orbit.velocity(1.0, 0.0)[0, 0]), rel=1e-12)
    with pytest.raises(ParameterError):
        orbit.impact_history(0)


@pytest.mark.parametrize("d", [0.0, 0.005, 3.0, 400.0])
@pytest.mark.parametrize(("modes", "times"), [(8, 48), (700, 129), (1300, 1000), (0, 60)])
def test_free_motion_at_even_times_is_that_of_each_time_by_itself(d, modes, times):
    rng = np.random.default_rng(modes + times)
    n = np.arange(1, modes + 1)
    start = rng.normal(size=modes) / n**3, rng.normal(size=modes) / n**2
    omega, rows = UniformBar(20.0).frequencies(modes), rng.normal(size=(2, modes))
    t = np.linspace(0.3, 6.0, times)
    together = free_sum(omega, d, start, t, rows)
    apart = [free_sum(omega, d, start, one[None], rows) for one in t]
    for i, whole in enumerate(together):
        single = np.concatenate([pair[i] for pair in apart], axis=1)
        assert np.abs(whole - single).max(initial=0.0) < 1e-12 * (1.0 + np.abs(single).max(initial=0.0))
