"""Known limits, with their order, and symmetries: stiff bars, no damping, finer series, other units, other clocks."""

from __future__ import annotations

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss import Bar, Load, System, rest_on_wall, si_report, stability_of, steady_states
from percuss.errors import ParameterError
from percuss.mechanics.flow import excess, phi1, phi2
from percuss.stability import floquet_multipliers, reduced_criterion, stability_plane, waveform_criterion
from percuss.steady import Orbit
from percuss.steady.oscillator import cubic_sum
from strategies import Drawn, fourier_systems, square_systems

TURN = 2.0 * math.pi


def turned(a: float, b: float) -> float:
    """Distance of two phases on the circle."""
    return abs((a - b + math.pi) % TURN - math.pi)


def slope_of(x: list[float], y: list[float]) -> float:
    """Slope of log y against log x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


@pytest.mark.parametrize("function", [phi1, phi2, excess])
def test_functions_that_stay_exact_do_not_ask_what_stands_beside(function: Callable[[np.ndarray], np.ndarray]) -> None:
    """All small, all large or some of each: each value as it is beside others, and that of 50 digits."""
    x = np.array([0.0, 1e-300, 1e-9, 1e-3, 0.1, 0.9, 1.0, 1.1, 3.0, 30.0])
    every = function(x)
    for part in (slice(0, 1), slice(0, 3), slice(1, 6), slice(6, 10), slice(8, 9)):
        np.testing.assert_array_equal(function(x[part]), every[part])
    with mpmath.workdps(700):  # 1 − exp(−1e-300) cancels 300 digits, twice
        exact = {phi1: lambda t: (1 - mpmath.exp(-t)) / t, phi2: lambda t: (mpmath.exp(-t) - 1 + t) / t**2}
        exact[excess] = lambda t: mpmath.sin(t) - t
        wanted = [float(exact[function](mpmath.mpf(t))) for t in x[1:].tolist()]
    np.testing.assert_allclose(every[1:], wanted, rtol=4e-15, atol=0.0)
    assert every[0] == {phi1: 1.0, phi2: 0.5, excess: 0.0}[function]


# ---------------------------------------------------------------- s to infinity: the pneumatic hammer (theory §6)


@pytest.mark.parametrize("m", [1, 3])
@pytest.mark.parametrize("r", [0.0, 0.4, 0.9])
def test_pneumatic_hammer_of_a_stiff_bar(r: float, m: int) -> None:
    """sin phi = pi m (p_0/p_1)(1 - R)/(1 + R), whatever s (B77 35, 38); the striking speed is the rigid one."""
    fold = (1 + r) / (math.pi * m * (1 - r))
    for share in (0.2, 0.99):
        expected = math.asin(share)
        for s in (1.0, 30.0, 1e6):
            found = steady_states(System(s=s, d=0.0, restitution=r, load=Load.harmonic(share * fold, 1.0)), m, modes=40)
            assert [orbit.phase for orbit in found.orbits] == pytest.approx([expected, math.pi - expected], abs=1e-13)
        for orbit in found.orbits:
            assert orbit.impact_velocity == pytest.approx(share * fold * TURN * m / (1 + r), rel=1e-9)
            assert orbit.blow_energy == pytest.approx(0.5 * orbit.impact_velocity**2, rel=1e-9)
        assert not steady_states(System(s=5.0, d=0.0, restitution=r, load=Load.harmonic(1.0001 * fold, 1.0)), m).exists


def test_sigma_of_the_pneumatic_hammer() -> None:
    """The closed form of B77 (37), exactly; it falls like 1/s**2."""
    r, values, speeds = 0.3, [], [10.0, 20.0, 40.0, 80.0]
    for s in (0.45, 0.9, 3.0, *speeds):
        system = System(s=s, d=0.0, restitution=r, load=Load.harmonic(0.3, 1.0))
        for orbit in steady_states(system).orbits:
            expected = (1 - r) / (1 + r) * 0.5 * ((1 / s) / math.sin(1 / s) - 1)
            assert reduced_criterion(orbit).sigma == pytest.approx(expected, rel=1e-12)
        values.append(expected)
    assert slope_of(speeds, values[-4:]) == pytest.approx(-2.0, abs=0.01)


@pytest.mark.parametrize("m", [1, 4])
@pytest.mark.parametrize("r", [0.0, 0.1, 0.5, 0.9])
def test_stable_range_of_the_pneumatic_hammer(r: float, m: int) -> None:
    """B77 (39) by the exact multipliers of a bar that is nearly rigid, and by the waveform criterion."""
    fold = (1 + r) / (math.pi * m * (1 - r))
    flip = (1 + r) ** 2 / math.sqrt(4 * (1 + r**2) ** 2 + (math.pi * m * (1 - r**2)) ** 2)
    for factor, stable, value in (
        (flip * (1 + 1e-5), True, -1.0),
        (flip * (1 - 1e-5), False, -1.0),
        (fold * (1 - 1e-9), True, 1.0),
    ):
        orbit = steady_states(System(s=1e6, d=0.0, restitution=r, load=Load.harmonic(factor, 1.0)), m, modes=0).orbits[
            1
        ]
        found = floquet_multipliers(orbit, 0)
        assert (found.largest < 1) is stable
        assert found.values[0].real == pytest.approx(value, abs=1e-3)
        assert waveform_criterion(orbit).stable is stable
        assert reduced_criterion(orbit).stable is stable


@pytest.mark.parametrize("d", [0.0, 0.02])
def test_order_in_the_wave_speed(d: float) -> None:
    """Striking speed, displacement and multipliers of the elastic bar tend to the rigid ones like 1/s**2."""
    load = Load.fourier([0.1, 1.0, 0.3 - 0.2j])
    speeds = [20.0, 40.0, 80.0, 160.0]
    errors: dict[str, list[float]] = {"speed": [], "energy": [], "place": [], "sigma": []}
    for s in speeds:
        orbit = steady_states(System(s=s, d=d, restitution=0.5, load=load), 2, tolerance=1e-13).orbits[1]
        rigid = Orbit(orbit.system, 2, orbit.phase, requested_modes=0)
        t = np.linspace(0, orbit.period, 400)
        errors["speed"].append(abs(orbit.impact_velocity - rigid.impact_velocity))
        errors["energy"].append(abs(orbit.blow_energy - rigid.blow_energy))
        errors["place"].append(float(np.abs(orbit.motion(t) - rigid.motion(t)).max()))
        errors["sigma"].append(abs(reduced_criterion(orbit).sigma))
    assert slope_of(speeds, errors["speed"]) < -1.8
    assert slope_of(speeds, errors["energy"]) < -1.8
    assert slope_of(speeds, errors["place"]) < -1.8
    assert slope_of(speeds, errors["sigma"]) == pytest.approx(-2.0, abs=0.05)


def test_rigid_pair_inside_the_exact_multipliers() -> None:
    speeds, errors = [10.0, 20.0, 40.0, 80.0], []
    for s in speeds:
        orbit = steady_states(System(s=s, d=0.01, restitution=0.5, load=Load.harmonic(0.3, 1.0))).orbits[0]
        rigid = floquet_multipliers(orbit, 0).largest
        errors.append(abs(floquet_multipliers(orbit, 24).largest - rigid))
    assert slope_of(speeds, errors) < -1.5


# ---------------------------------------------------------------- s to infinity: the hydraulic hammer (theory §7)


@pytest.mark.parametrize("m", [1, 2])
@pytest.mark.parametrize("r", [0.0, 0.3, 0.6, 0.9])
def test_hydraulic_hammer_is_never_stable(r: float, m: int) -> None:
    """B77 (41): p(phi) = +q or -q, and neither will do."""
    seen = 0
    for kappa in np.linspace(1.01, 1.99, 25):
        system = System(s=1e6, d=0.0, restitution=r, load=Load.square(1.0, float(kappa)))
        for orbit in steady_states(system, m, modes=0).orbits:
            seen += 1
            ratio = waveform_criterion(orbit).ratio
            assert abs(ratio) == pytest.approx(1 / (kappa - 1), rel=1e-9)
            reduced = reduced_criterion(orbit)
            assert not reduced.stable
            assert not floquet_multipliers(orbit, 0).largest < 1 - 1e-9
            middle = 1 + (1 + r) ** 2 / (1 + r**2) * (math.copysign(1, ratio) - kappa + 1) / (kappa - 1)
            # |a_1/(a_0 + a_2)| of (41): 1 + ... is minus the quotient
            assert reduced.schur[1] == pytest.approx(abs(middle), rel=1e-6)
    assert seen > 5


# ---------------------------------------------------------------- d to 0


@pytest.mark.parametrize("kind", ["smooth", "square"])
@pytest.mark.parametrize("m", [1, 5])
def test_no_damping_is_the_limit_of_little_damping(kind: str, m: int) -> None:
    """Down to d = 0 everything moves in proportion to d, and below 1e-12 no further than rounding."""
    load = Load.fourier([0.02, 1.0, 0.3 - 0.2j]) if kind == "smooth" else Load.square(1.0, 1.05)

    def numbers(d: float) -> np.ndarray:
        found = steady_states(System(s=3.7, d=d, restitution=0.6, load=load), m, modes=12)
        assert len(found.orbits) == 2
        row = [found.level, found.level_max]
        for orbit in found.orbits:
            reduced = reduced_criterion(orbit)
            multipliers = floquet_multipliers(orbit, 4)
            t = np.linspace(0, orbit.period, 7)[1:-1]
            row += [
                orbit.phase,
                orbit.impact_velocity,
                orbit.blow_energy,
                reduced.sigma,
                *reduced.a,
                multipliers.largest,
            ]
            row += [orbit.energy.input, *orbit.motion(t)]
        return np.array(row)

    still = numbers(0.0)
    size = np.maximum(np.abs(still), 1e-2)
    dampings = [1e-5, 1e-6, 1e-7, 1e-8]
    errors = [float((np.abs(numbers(d) - still) / size).max()) for d in dampings]
    assert slope_of(dampings, errors) == pytest.approx(1.0, abs=0.1)
    for d in (1e-9, 1e-12, 1e-13, 1e-15, 1e-18, 1e-30, 1e-200, 5e-324):
        difference = float((np.abs(numbers(d) - still) / size).max())
        assert difference <= 3 * errors[-1] / 1e-8 * d + 1e-10, d


def test_no_jump_in_between() -> None:
    """Where a series takes over from a formula nothing shows: second differences in log d stay tiny."""
    grid = 10.0 ** np.linspace(-15, -0.5, 400)
    levels, sizes = [], []
    for d in grid:
        found = steady_states(System(s=3.7, d=float(d), restitution=0.6, load=Load.square(1.0, 1.02)), 2)
        levels.append([found.level / found.system.load.mean, found.level_max])
        sizes.append(found.level)
    values = np.array(levels)
    bends = np.abs(np.diff(values, 2, axis=0)) / values[1:-1]
    assert np.all(bends < 5e-3)
    calm = grid[1:-1] < 1e-9
    assert np.all(bends[calm] < 1e-8)


# ---------------------------------------------------------------- the phase of the load is a choice of clock


@settings(max_examples=30)
@given(st.one_of(fourier_systems(10), square_systems()), st.floats(-10.0, 10.0))
def test_a_shifted_load_shifts_the_phase_and_nothing_else(drawn: Drawn, shift: float) -> None:
    system, m = drawn
    assume(system.restitution < 1.0 or system.d > 1e-6)
    shifted = System(s=system.s, d=system.d, restitution=system.restitution, load=system.load.shifted(shift))
    a, b = steady_states(system, m, modes=6), steady_states(shifted, m, modes=6)
    assume(a.level < a.level_max * (1 - 1e-9) and all(not o.fold for o in (*a.orbits, *b.orbits)))
    assert b.level == a.level
    assert b.level_max == pytest.approx(a.level_max, rel=1e-11)
    assert len(a.orbits) == len(b.orbits)
    for orbit in a.orbits[:3]:
        twin = min(b.orbits, key=lambda o, phase=orbit.phase: turned(o.phase + shift, phase))  # type: ignore[misc]
        v = a.rigid_velocity([orbit.phase, orbit.phase + 1e-5, orbit.phase - 1e-5])
        steep = abs(v[1] - v[2]) / 2e-5 / a.level_max
        assume(steep > 1e-5)
        assert turned(twin.phase + shift, orbit.phase) < 1e-11 / steep
        twin = Orbit(shifted, m, (orbit.phase - shift) % TURN, requested_modes=6)
        speed = abs(orbit.impact_velocity) + orbit.rigid_velocity
        divisor = float(orbit.state.divisor.min())
        assume(divisor > 1e-5)
        k = system.load.harmonics
        omega = orbit.state.omega[:, None]
        assume(float(np.abs(omega**2 / (omega**2 - k * (k - 1j * system.d))).max()) < 1e4)
        assert twin.impact_velocity == pytest.approx(orbit.impact_velocity, abs=1e-8 * speed)
        t = np.linspace(0, orbit.period, 9)
        size = orbit.stroke + speed
        assert twin.motion(t) == pytest.approx(orbit.motion(t), abs=1e-8 * size)
        assert twin.blow_energy == pytest.approx(orbit.blow_energy, rel=1e-7)


# ---------------------------------------------------------------- a Fourier square tends to the square


def test_fourier_square_tends_to_the_piecewise_one() -> None:
    """v_f has coefficients like 1/k**2 and kinks: away from them its partial sums err like 1/K**2, at the top like 1/K.
    The error wiggles with K, so the worst of ten neighbours is taken; the modes kept resonate below K = 72."""
    kappa, m = 1.2, 1

    def numbers(load: Load, i: int) -> tuple[float, float, float]:
        found = steady_states(System(s=2.3, d=0.05, restitution=0.5, load=load), m, modes=10)
        orbit = found.orbits[i]
        return orbit.phase, orbit.impact_velocity, found.level_max

    ks = [100, 200, 400, 800]
    for i in (0, 1):
        exact = numbers(Load.square(1.0, kappa), i)
        errors = []
        for K in ks:
            runs = [numbers(Load.fourier(Load.square(1.0, kappa, n).coefficients), i) for n in range(K, K + 10)]
            errors.append(np.abs(np.array(runs) - exact).max(axis=0))
        phase, speed, top = np.array(errors).T
        assert slope_of(ks, phase.tolist()) == pytest.approx(-2.0, abs=0.25)
        assert slope_of(ks, speed.tolist()) == pytest.approx(-2.0, abs=0.25)
        assert slope_of(ks, top.tolist()) == pytest.approx(-1.0, abs=0.1)


@pytest.mark.parametrize("modes", [3, 10])
def test_fourier_square_flies_like_the_piecewise_one(modes: int) -> None:
    exact = steady_states(System(s=2.3, d=0.05, restitution=0.5, load=Load.square(1.0, 1.2)), modes=modes).orbits[1]
    t = np.linspace(0, TURN, 50)
    errors = []
    for K in (100, 800):
        worst = 0.0
        for n in range(K, K + 10):
            load = Load.fourier(Load.square(1.0, 1.2, n).coefficients)
            near = steady_states(System(s=2.3, d=0.05, restitution=0.5, load=load), modes=modes).orbits[1]
            worst = max(worst, float(np.abs(near.motion(t) - exact.motion(t)).max()))
        errors.append(worst)
        ours, theirs = floquet_multipliers(near, 3).values, floquet_multipliers(exact, 3).values
        assert np.abs(np.sort(np.abs(ours)) - np.sort(np.abs(theirs))).max() < 30 / K
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 30


# ---------------------------------------------------------------- units of force


@settings(max_examples=30)
@given(st.one_of(fourier_systems(10), square_systems()), st.sampled_from([2.0**-40, 0.125, 1024.0, 2.0**40]))
def test_a_stronger_load_is_the_same_motion_enlarged(drawn: Drawn, factor: float) -> None:
    """Load and mean times f: positions and speeds times f, energies times f squared, phases and multipliers stay.
    f is a power of 2, so that not even rounding differs."""
    system, m = drawn
    assume(system.restitution < 1.0 or system.d > 1e-6)
    scaled = System(s=system.s, d=system.d, restitution=system.restitution, load=system.load.scaled(factor))
    a, b = steady_states(system, m, modes=6), steady_states(scaled, m, modes=6)
    assert [o.phase for o in b.orbits] == pytest.approx([o.phase for o in a.orbits], abs=1e-12)
    assert b.level == pytest.approx(factor * a.level, rel=1e-14)
    for one, two in list(zip(a.orbits, b.orbits, strict=True))[:2]:
        assert two.impact_velocity == pytest.approx(factor * one.impact_velocity, rel=1e-9, abs=1e-12 * factor)
        assert two.stroke == pytest.approx(factor * one.stroke, rel=1e-9)
        assert two.blow_energy == pytest.approx(factor**2 * one.blow_energy, rel=1e-9)
        assert two.admissible == one.admissible
        assert two.error_bound == pytest.approx(one.error_bound, rel=1e-9)
        if one.violation and two.violation:
            assert two.violation.time == pytest.approx(one.violation.time, abs=1e-9)
        ours, theirs = stability_of(two), stability_of(one)
        assert ours.reduced.schur == pytest.approx(theirs.reduced.schur, rel=1e-9, abs=1e-12)
        assert ours.multipliers.moduli == pytest.approx(theirs.multipliers.moduli, rel=1e-9, abs=1e-9)
        assert (ours.stable, ours.reason) == (theirs.stable, theirs.reason)


# ---------------------------------------------------------------- B77 counts periods of the impact (theory §1)


@settings(max_examples=20)
@given(fourier_systems(4), st.integers(2, 5))
def test_the_clock_of_b77(drawn: Drawn, stretch: int) -> None:
    """The same motion with time measured `stretch` times slower: the load is its own harmonic number `stretch`, impacts
    come every m/stretch periods, s and d grow by it, forces by its square, and every phase appears `stretch` times."""
    system, _ = drawn
    m, f = 2 * stretch, stretch
    assume(system.restitution < 1.0 or system.d > 1e-6)
    here = system.load.coefficients
    there = np.zeros((here.size - 1) * f + 1, dtype=complex)
    there[::f] = here * f**2
    twin = System(s=system.s * f, d=system.d * f, restitution=system.restitution, load=Load.fourier(there))
    a, b = steady_states(system, m, modes=5), steady_states(twin, m // f, modes=5)
    assume(not any(o.fold for o in (*a.orbits, *b.orbits)) and a.level < a.level_max * (1 - 1e-8))
    assert b.level == pytest.approx(a.level * f, rel=1e-12)
    assert b.level_max == pytest.approx(a.level_max * f, rel=1e-12)
    assert len(b.orbits) == f * len(a.orbits)
    for i, orbit in enumerate(a.orbits[:2]):
        copies = [o for j, o in enumerate(b.orbits) if j % len(a.orbits) == i]
        v = a.rigid_velocity([orbit.phase + 1e-5, orbit.phase - 1e-5])
        steep = abs(v[0] - v[1]) / 2e-5 / a.level_max
        assume(steep > 1e-4 and float(orbit.state.divisor.min()) > 1e-4)
        for j, copy in enumerate(copies):
            assert turned(copy.phase, orbit.phase / f + TURN * j / f) < 1e-11 / steep
        copy = copies[-1]
        scale = f * (abs(orbit.impact_velocity) + orbit.rigid_velocity)
        k = system.load.harmonics
        omega = orbit.state.omega[:, None]
        assume(float(np.abs(omega**2 / (omega**2 - k * (k - 1j * system.d))).max()) < 1e3)
        assert copy.impact_velocity == pytest.approx(f * orbit.impact_velocity, abs=1e-7 * scale / steep)
        t = np.linspace(0, orbit.period, 9)
        assert copy.motion(t / f) == pytest.approx(orbit.motion(t), abs=1e-7 * (orbit.stroke + scale) / steep)
        ours, theirs = floquet_multipliers(copy, 0).values, floquet_multipliers(orbit, 0).values
        assert np.abs(ours - theirs).max() <= 1e-6 * max(1.0, float(np.abs(theirs).max())) / steep
        assert reduced_criterion(copy).sigma == pytest.approx(reduced_criterion(orbit).sigma, rel=1e-6, abs=1e-9)


# ---------------------------------------------------------------- corners of the parameter space


@pytest.mark.parametrize("d", [1e-14, 1e-9, 1e-6])
def test_hardly_any_damping_hides_no_passage(d: float) -> None:
    """The rigorous bound of the modes left out grows like 1/d; it must neither say nothing nor excuse anything."""
    load = Load.harmonic(0.3, 1.0)
    free = steady_states(System(s=0.4, d=0.0, restitution=0.5, load=load)).orbits[0]
    damped = steady_states(System(s=0.4, d=d, restitution=0.5, load=load)).orbits[0]
    assert damped.error_bound < 1e-6
    assert not damped.admissible
    assert damped.violation is not None
    assert free.violation is not None
    assert damped.violation.depth == pytest.approx(free.violation.depth, rel=1e-2)
    assert damped.stroke == pytest.approx(free.stroke, rel=1e-2)


def test_a_deep_passage_counts_whatever_the_modes_left_out_may_do() -> None:
    orbit = steady_states(System(s=0.3, d=0.0, restitution=0.5, load=Load.square(1.0, 1.2))).orbits[0]
    assert orbit.error_bound > 1.0
    assert orbit.violation is not None
    assert any("position error" in warning for warning in orbit.warnings)


def test_rest_of_a_bar_that_swallows_its_load() -> None:
    rest = rest_on_wall(System(s=0.05, d=1e6, restitution=0.5, load=Load.harmonic(0.3, 1.0)))
    assert rest.possible
    assert rest.least_contact_force == pytest.approx(0.3, rel=1e-12)


def test_resonance_by_a_hair_keeps_its_energy_finite() -> None:
    system = System(s=1.0 / math.pi, d=1e-14, restitution=0.5, load=Load.harmonic(0.5, 1.0))
    for orbit in steady_states(system, modes=8).orbits:
        energy = orbit.energy
        assert math.isfinite(energy.damping)
        assert math.isfinite(energy.input)


@pytest.mark.parametrize(
    ("ask", "name"),
    [
        (lambda: steady_states("hammer"), "system"),
        (lambda: rest_on_wall(None), "system"),
        (lambda: stability_of(3), "orbit"),
        (lambda: si_report("orbit"), "orbit"),
        (lambda: System.from_si(1, 2, 3), "bar"),
        (lambda: stability_plane(System(1.0, 0.0, 0.5, Load.harmonic(1, 1)), [0.1, 0.2, 0.3], [1, 2]), "load_factor"),
        (lambda: one_orbit().position(2.0, 0.0), "x"),
        (lambda: one_orbit().position([[0.5]], 0.0), "x"),
        (lambda: one_orbit().velocity(0.5, math.nan), "t"),
        (lambda: Bar(1e300, 1e300), "length"),
        (lambda: System(1.0, 0.0, 0.5, Load.harmonic(1e300, 1.0)), "load"),
    ],
)
def test_nonsense_at_the_doors(ask: Callable[[], object], name: str) -> None:
    with pytest.raises(ParameterError) as caught:
        ask()
    assert caught.value.name == name


def one_orbit() -> Orbit:
    return steady_states(System(s=5.0, d=0.01, restitution=0.5, load=Load.harmonic(0.5, 1.0)), modes=4).orbits[0]


@pytest.mark.parametrize(
    ("s", "d", "r", "m", "modes", "k"),
    [
        (1.5936018788755544, 0.24489099222950395, 0.2075779880943727, 2, 0, 5),
        (0.5315817578227969, 0.0033217439767694867, 0.3475838660942475, 2, 0, 5),
        (0.3205860490973789, 0.0011019889898896157, 0.10057303377273981, 1, 0, 1),
        (2.549213663521261, 0.003141907940612534, 0.7264511370841409, 1, 0, 8),
        (20.0, 0.01, 0.5, 1, 1, 3),
    ],
)
def test_the_bound_of_a_cut_bar_holds_also_at_a_resonance_left_out(
    s: float, d: float, r: float, m: int, modes: int, k: int
) -> None:
    """A requested number of modes cuts the forced part too, and the mode left out may be the one that resonates."""
    coefficients = np.zeros(k + 1)
    coefficients[0], coefficients[1] = 0.05, 0.3
    coefficients[k] += 1.0
    system = System(s=s, d=d, restitution=r, load=Load.fourier(coefficients))
    for cut, fine in zip(*(steady_states(system, m, modes=n).orbits[:2] for n in (modes, 1000)), strict=True):
        t = np.linspace(0.0, cut.period, 301)
        gap = float(np.abs(cut.motion(t) - fine.motion(t)).max())
        assert 0.0 < gap <= cut.error_bound * cut.rigid_stroke


# -- what the modes left out can amount to without damping -------------------------------------------------------------


SPEEDS = [20.0, 3.3, 50.0, 0.7, 20.0000012958591, 7.0000007 / math.pi, 2.5 / math.pi * (1 + 1e-6), 22.0 / 7.0]


def factor(s: float, periods: int, n: int) -> float:
    """1/(2‖nπsm‖) in 40 digits."""
    with mpmath.workdps(40):
        turns = mpmath.pi * mpmath.mpf(s) * periods * n
        return float(1 / (2 * abs(turns - mpmath.nint(turns))))


def lost(orbit: Orbit, most: int) -> float:
    """The greatest position at sampled times, relative to the stroke, that the modes after those kept give.

    z_n = −f_n' sin(λT)/(ω(1 − cos λT)) (1 + R)/(1 − R), z_n' = −f_n' (1 + R)/(1 − R), with angles in 40 digits where
    they are nearly whole turns.
    """
    system = orbit.system
    n = np.arange(orbit.modes + 1, most + 1)
    omega, (k, p) = n * math.pi * system.s, (1, complex(system.load.coefficients[1]))
    velocity = (1j * k * p * np.exp(1j * orbit.phase)).real / (omega**2 - k**2)
    turns = n * math.pi * system.s * orbit.periods
    cotangent = 1.0 / np.tan(math.pi * (turns - np.rint(turns)))
    for i in np.argsort(-np.abs(cotangent))[:50]:
        with mpmath.workdps(40):
            exact = mpmath.cot(mpmath.pi * mpmath.pi * mpmath.mpf(system.s) * orbit.periods * int(n[i]))
        cotangent[i] = float(exact)
    full = (1.0 + system.restitution) / (1.0 - system.restitution)
    sign = np.where(n % 2, -2.0, 2.0)
    z, rate = -full * velocity * cotangent / omega * sign, -full * velocity / omega * sign
    wave, greatest = z - 1j * rate, 0.0
    step = np.exp(1j * omega * (orbit.period * (math.sqrt(5.0) - 1.0) / 2.0))  # its multiples fill a period evenly
    for _ in range(200):
        wave *= step
        greatest = max(greatest, abs(float((wave.sum() - z.sum()).real)))
    return greatest / orbit.rigid_stroke


@pytest.mark.parametrize("s", SPEEDS)
@pytest.mark.parametrize("restitution", [0.6, 0.99])
def test_the_bound_without_damping_is_one(s: float, restitution: float) -> None:
    load = Load.harmonic(0.5 if s == 20.0000012958591 else 0.1, 1.0)
    for orbit in steady_states(System(s, 0.0, restitution, load)).orbits:
        assert lost(orbit, 150_000) <= orbit.error_bound
        assert orbit.error_bound <= 1e-10 or orbit.warnings
        assert orbit.error_bound < 1e-6


def test_a_resonance_far_beyond_the_probe_is_counted() -> None:
    """Mode 7000 swings a whole number of times but for 1e-9: it is neither missed nor taken as exactly resonant."""
    for orbit in steady_states(System(20.0000012958591, 0.0, 0.99, Load.harmonic(0.5, 1.0))).orbits:
        assert orbit.modes >= 7000
        state = orbit.modal_state(7000)
        share = 2.0 * float(state.amplitude[6999]) / orbit.rigid_stroke
        gain = 199.0 * abs(float(state.forced_velocity[6999])) / float(state.omega[6999]) * 2.0 / orbit.rigid_stroke
        assert share == pytest.approx(gain * factor(20.0000012958591, 1, 7000) * 2.0 / math.pi, rel=0.15)


@settings(max_examples=30)
@given(st.sampled_from(SPEEDS) | st.floats(0.3, 100.0), st.integers(1, 5), st.integers(1, 3000))
def test_sums_over_small_divisors(s: float, periods: int, start: int) -> None:
    n = np.arange(start + 1, 60_000)
    with mpmath.workdps(80):  # in whole numbers: with s m near a multiple of 1/π all of them are near resonance
        turn, whole = 2**200, int(mpmath.pi * mpmath.mpf(s) * periods * 2**200)
    off = np.array([min(left, turn - left) / turn for left in (k * whole % turn for k in n.tolist())])
    terms = n**-3.0 * (1.0 + 0.5 / off)
    plain = float(terms.sum())
    bound = cubic_sum(s, periods, start)
    assert plain <= bound * (1.0 + 1e-6)
    assert bound <= 100.0 * plain + 100.0 / 60_000.0**2 * math.log(60_000.0) or bound > 1e3 * float(terms.max())
    capped = cubic_sum(s, periods, start, 5.0)
    assert float((n**-3.0 * np.minimum(terms * n**3.0, 5.0)).sum()) <= capped <= bound
    assert cubic_sum(s, periods, start, 1e9, 1e-12) >= min(plain, float(np.minimum(terms * n**3.0, 1e9) @ n**-3.0))


@pytest.mark.parametrize("d", [1e-12, 1e-9, 1e-6])
def test_hardly_any_damping_is_as_good_as_none(d: float) -> None:
    for s in SPEEDS[:4]:
        none = steady_states(System(s, 0.0, 0.6, Load.harmonic(0.5, 1.0))).orbits
        some = steady_states(System(s, d, 0.6, Load.harmonic(0.5, 1.0))).orbits
        for one, two in zip(none, some, strict=True):
            assert two.error_bound <= 4.0 * max(one.error_bound, 1e-10)
