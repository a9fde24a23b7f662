"""The ground floor: bar, load, contact, system. Each object refuses nonsense by name and gives back what went in."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Bar, Kept, Load, System
from percuss.errors import ParameterError, PercussError
from percuss.model import Ratio
from strategies import coefficients, dampings, kappas, restitutions, wave_speeds

BAR = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
SMOOTH = Load.fourier([0.9, 1.0, 0.2 - 0.3j])
SQUARE = Load.square(1.5, 1.3)
STEPS = Load.steps([0.3, 1.0, 4.0], [1.0, -0.5, 2.0])
SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=SMOOTH)
# ---------------------------------------------------------------- nonsense is refused, by name


def test_the_errors_explain_themselves() -> None:
    with pytest.raises(PercussError) as caught:
        Bar(length=-0.3, area=1e-3)
    text = str(caught.value)
    assert "length" in text
    assert "-0.3" in text
    assert "greater than 0" in text
    assert isinstance(caught.value, ValueError)
    with pytest.raises(ParameterError, match="restitution instead"):
        Kept(receiving_area=0.4, area=0.5)
    revived = pickle.loads(pickle.dumps(caught.value))
    assert str(revived) == text


# ---------------------------------------------------------------- values: immutable, equal, printable, picklable

OBJECTS = [
    BAR,
    SMOOTH,
    SQUARE,
    STEPS,
    Kept(0.3),
    SYSTEM,
    System.from_si(BAR, Load.harmonic(4e3, 9e3, frequency=60.0), Kept(0.2)),
]


@pytest.mark.parametrize("thing", OBJECTS, ids=lambda thing: type(thing).__name__)
def test_objects_are_values(thing: Any) -> None:
    for other in (copy.deepcopy(thing), pickle.loads(pickle.dumps(thing)), dataclasses.replace(thing)):
        assert other == thing
        assert hash(other) == hash(thing)
    for field in dataclasses.fields(thing):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(thing, field.name, 1.0)
    assert type(thing).__name__ in str(thing)
    assert "\n" not in str(thing)
    assert thing != "something else"


def test_the_repr_of_every_object_shows_its_numbers() -> None:
    assert "0.341" in repr(BAR)
    assert "0.3" in repr(Kept(0.3))
    assert "s=20.0" in repr(SYSTEM)
    assert len(repr(Load.square(1.0, 1.3, 4096))) < 2000  # a large load does not flood the screen


def test_a_load_is_not_changed_through_its_arrays() -> None:
    given = np.array([0.9, 1.0, 0.2 - 0.3j])
    load = Load.fourier(given)
    given[1] = 7.0
    assert load.coefficients[1] == 1.0
    for view in (load.coefficients, pickle.loads(pickle.dumps(load)).coefficients, copy.deepcopy(load).coefficients):
        with pytest.raises(ValueError, match="read-only"):
            view[1] = 5.0


def test_loads_differ_when_anything_differs() -> None:
    different = [
        SMOOTH,
        Load.fourier([0.9, 1.0, 0.2 + 0.3j]),
        Load.fourier([0.9, 1.0]),
        dataclasses.replace(SMOOTH, frequency=60.0),
        SQUARE,
        Load.square(1.5, 1.3, 65),
        Load.fourier(SQUARE.coefficients),
        Load.square(1.5, 1.31),
    ]
    for i, a in enumerate(different):
        for b in different[i + 1 :]:
            assert a != b
    assert len(set(different)) == len(different)
    assert Load.fourier([[0.9, 0.0], [1.0, 0.0], [0.2, -0.3]]) == SMOOTH


def test_two_pairs_of_numbers_are_pairs() -> None:
    assert Load.fourier([[0.9, 0.0], [1.0, 0.5]]).coefficients.tolist() == [0.9, 1.0 + 0.5j]


# ---------------------------------------------------------------- the bar


@given(st.floats(0.01, 10.0), st.floats(0.005, 1.0), st.floats(0.0, 2.0))
def test_bar_formulas(length: float, diameter: float, ratio: float) -> None:
    area, wave = math.pi * diameter**2 / 4, math.sqrt(210e9 / 7850)
    bar = Bar(length=length, diameter=diameter, drag=2.0 * ratio * math.pi * wave / length * 7850 * area)
    assert bar.area == pytest.approx(area, rel=1e-15)
    assert bar.mass == pytest.approx(7850 * area * length, rel=1e-14)
    assert bar.wave_speed == pytest.approx(wave, rel=1e-15)
    assert bar.impedance == pytest.approx(bar.mass_per_length * wave, rel=1e-14)
    assert bar.contact_duration == pytest.approx(2 * length / wave, rel=1e-14)
    # the first elastic mode: u'' + (D/M) u' + (pi C/L)**2 u, D/M = 2 zeta omega
    omega = math.pi * wave / length
    assert bar.damping.rigid == pytest.approx(2 * ratio * omega, rel=1e-14, abs=1e-300)
    assert Bar(length=length, area=area, damping=bar.damping).damping == bar.damping
    frequencies = bar.natural_frequencies(3)
    expected = [math.sqrt(max((n * omega) ** 2 - (ratio * omega) ** 2, 0.0)) / (2 * math.pi) for n in (1, 2, 3)]
    assert frequencies == pytest.approx(expected, rel=1e-7, abs=1e-6 * omega)


@given(st.floats(0.01, 10.0), st.floats(0.0, 1.0))
def test_a_damping_ratio_is_that_of_every_elastic_mode(length: float, ratio: float) -> None:
    bar = Bar(length=length, diameter=0.05, damping_ratio=ratio)
    assert bar.damping == Ratio(ratio)
    assert bar.rigid_drag == 0.0
    first = bar.wave_speed / (2.0 * length)
    expected = [n * first * math.sqrt(1.0 - ratio**2) for n in (1, 2, 3)]
    assert bar.natural_frequencies(3) == pytest.approx(expected, rel=1e-7, abs=1e-6 * first)


def test_receiving_rod_of_the_laboratory_striker() -> None:
    """Ø22 onto Ø32: R = 0.358; equal areas take everything, a wall gives everything back."""
    contact = Kept(receiving_area=math.pi * 0.016**2, area=math.pi * 0.011**2)
    assert round(contact.restitution, 3) == 0.358
    assert contact.restitution == pytest.approx((32**2 - 22**2) / (32**2 + 22**2), rel=1e-14)
    assert Kept(receiving_area=1.0, area=1.0).restitution == 0.0
    assert Kept(receiving_area=1e300, area=1e-3).restitution == 1.0


# ---------------------------------------------------------------- the load


def straight(load: Load, t: float) -> complex:
    return sum(complex(p) * np.exp(1j * k * t) for k, p in enumerate(load.coefficients))


@given(coefficients(), st.floats(-2, 2), st.floats(-20, 20))
def test_smooth_load(alternating: list[complex], mean: float, t: float) -> None:
    load = Load.fourier(np.array([mean, *alternating]))
    size = 1.0 + sum(abs(p) * k for k, p in enumerate(alternating, 1))
    assert load.mean == mean
    assert float(load.value(t)) == pytest.approx(straight(load, t).real, abs=1e-13 * size)
    assert load.value(t, "left") == load.value(t, "right")
    h = 1e-5
    slope = float(load.value(t + h) - load.value(t - h)) / (2 * h)
    assert float(load.derivative(t)) == pytest.approx(slope, abs=1e-7 * size * len(alternating) ** 2)
    rise = float(load.antiderivative(t + h) - load.antiderivative(t - h)) / (2 * h)
    assert rise == pytest.approx(float(load.value(t)) - mean, abs=1e-7 * size * len(alternating))
    circle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    assert float(load.antiderivative(circle).mean()) == pytest.approx(0, abs=1e-14 * size)
    assert float(load.antiderivative(t + 2 * np.pi)) == pytest.approx(float(load.antiderivative(t)), abs=1e-13 * size)
    assert not load.jumps


def test_values_keep_the_shape_of_the_phases() -> None:
    for load in (SMOOTH, SQUARE, Load.fourier([1.0])):
        for shape in ((), (3,), (2, 3), (0,)):
            t = np.zeros(shape)
            assert load.value(t).shape == load.derivative(t).shape == load.antiderivative(t).shape == shape


STEP_LOADS = st.one_of(
    st.builds(Load.square, st.floats(0.1, 10.0), kappas),
    st.lists(st.tuples(st.floats(0.05, 1.0), st.floats(-3.0, 3.0)), min_size=2, max_size=6).map(
        lambda pieces: Load.steps((0.1 + np.cumsum([w for w, _ in pieces])).tolist(), [v for _, v in pieces])
    ),
)


@given(STEP_LOADS, st.floats(-20, 20))
def test_piecewise_load(load: Load, t: float) -> None:
    edges = [*load.breaks, load.breaks[0] + 2 * math.pi]
    lengths = np.diff(edges)
    assert load.mean == pytest.approx(float(np.dot(lengths, load.values)) / (2 * math.pi), abs=1e-14 * 10)
    angle = t % (2 * math.pi)
    if min(abs(angle - e) for e in [*edges, 0.0]) > 1e-9:
        pieces = zip(edges, edges[1:], load.values, strict=False)
        inside = [v for a, b, v in pieces if a <= angle < b or a <= angle + 2 * math.pi < b]
        assert [float(load.value(t))] == inside
        h = 1e-10
        rise = float(load.antiderivative(t + h) - load.antiderivative(t - h)) / (2 * h)
        assert rise == pytest.approx(inside[0] - load.mean, abs=1e-3)
    # the antiderivative: continuous, mean zero (exactly integrable: parabola by Simpson in every piece)
    mean = 0.0
    for a, b in pairwise(edges):
        middle, low, high = load.antiderivative([(a + b) / 2, a, b])
        mean += (b - a) * (low + 4 * middle + high) / 6
        assert float(load.antiderivative(a - 1e-12)) == pytest.approx(low, abs=1e-10)
        assert float(load.antiderivative(np.nextafter(a, -1.0))) == pytest.approx(low, abs=1e-13 * max(1.0, abs(low)))
    assert mean == pytest.approx(0, abs=1e-12)
    # the coefficients are those of the steps
    for k in (1, 2, 5):
        by_hand = (
            sum(
                v * (np.exp(-1j * k * b) - np.exp(-1j * k * a)) / (-1j * k)
                for a, b, v in zip(edges, edges[1:], load.values, strict=False)
            )
            / math.pi
        )
        assert complex(load.coefficients[k]) == pytest.approx(by_hand, abs=1e-12)


def test_one_sided_values() -> None:
    at = 1.3 * math.pi
    assert [float(SQUARE.value(at, side)) for side in ("left", "right")] == [1.5, -1.5]
    assert [float(SQUARE.value(0.0, side)) for side in ("left", "right")] == [-1.5, 1.5]
    assert [float(SQUARE.value(2 * math.pi, side)) for side in ("left", "right")] == [-1.5, 1.5]
    assert float(SQUARE.value(at - 1e-9)) == 1.5
    assert float(SQUARE.value(at + 1e-9, "left")) == -1.5
    assert [(j.phase, j.before, j.after) for j in SQUARE.jumps] == [(0.0, -1.5, 1.5), (at, 1.5, -1.5)]
    assert len(STEPS.jumps) == 3
    assert Load.steps([0.0, 1.0, 2.0], [1.0, 1.0, 2.0]).jumps[0].phase == 0.0
    assert len(Load.steps([0.0, 1.0, 2.0], [1.0, 1.0, 2.0]).jumps) == 2
    for turn in (1, -3, 40):  # the same jump some turns away
        assert float(SQUARE.value(at + 2 * math.pi * turn, "left")) == 1.5
        assert float(SQUARE.value(at + 2 * math.pi * turn, "right")) == -1.5


def test_square_coefficients_are_those_of_b77() -> None:
    """B77 (34)."""
    q, kappa = 1.5, 1.3
    k = np.arange(1, 65)
    expected = 2 * q / (np.pi * k) * (np.sin(k * kappa * np.pi) + 1j * (np.cos(k * kappa * np.pi) - 1))
    assert np.abs(SQUARE.coefficients[1:] - expected).max() < 1e-14
    assert SQUARE.mean == pytest.approx(q * (kappa - 1), rel=1e-14)


@given(
    st.one_of(STEP_LOADS, st.just(SMOOTH)), st.floats(-10, 10), st.floats(-7, 7), st.floats(0.1, 5), st.floats(-2, 2)
)
def test_shifted_scaled_and_other_means(load: Load, t: float, shift: float, factor: float, mean: float) -> None:
    clear = all(
        min((t + x - b) % (2 * np.pi), (b - t - x) % (2 * np.pi)) > 1e-9 for b in load.breaks for x in (0.0, shift)
    )
    shifted, scaled, other = load.shifted(shift), load.scaled(factor), load.with_mean(mean)
    if clear:
        assert float(shifted.value(t)) == pytest.approx(float(load.value(t + shift)), abs=1e-12)
        assert float(scaled.value(t)) == pytest.approx(factor * float(load.value(t)), abs=1e-12)
        assert float(other.value(t)) == pytest.approx(float(load.value(t)) - load.mean + mean, abs=1e-12)
    assert float(shifted.antiderivative(t)) == pytest.approx(float(load.antiderivative(t + shift)), abs=1e-11)
    assert float(other.antiderivative(t)) == pytest.approx(float(load.antiderivative(t)), abs=1e-11)
    assert shifted.mean == load.mean
    assert other.mean == mean
    assert np.abs(shifted.coefficients) == pytest.approx(np.abs(load.coefficients), rel=1e-14)
    back = shifted.shifted(-shift)
    assert np.abs(back.coefficients - load.coefficients).max() < 1e-12
    assert (
        np.array(sorted(back.breaks)) % 6.28 == pytest.approx(np.array(sorted(load.breaks)) % 6.28, abs=1e-13)
        or load.breaks[0] == 0
    )
    if load.is_piecewise:  # coefficients and steps still belong together
        k = 3
        again = Load.steps(shifted.breaks, shifted.values)
        assert complex(again.coefficients[k]) == pytest.approx(complex(shifted.coefficients[k]), abs=1e-12)
        assert Load.steps(other.breaks, other.values).mean == pytest.approx(mean, abs=1e-12)


def test_load_factor_takes_the_lowest_harmonic_present() -> None:
    assert Load.harmonic(0.9, -2.0, 3).load_factor == pytest.approx(0.45, rel=1e-15)
    assert Load.harmonic(0.9, 0.0).is_constant
    system = SYSTEM.with_load_factor(0.3)
    assert system.load.load_factor == pytest.approx(0.3, rel=1e-15)
    assert system.load.coefficients[1:].tolist() == SYSTEM.load.coefficients[1:].tolist()


# ---------------------------------------------------------------- SI and back


@given(
    st.floats(0.02, 10.0),
    st.floats(0.01, 1.0),
    st.floats(0.0, 0.5),
    st.floats(0.5, 500.0),
    st.floats(1.0, 1e6),
    restitutions,
)
def test_si_round_trip(length: float, diameter: float, ratio: float, frequency: float, force: float, r: float) -> None:
    critical = 2.0 * math.pi * math.sqrt(210e9 * 7850) * math.pi / 4 * diameter**2 / length
    bar = Bar(length=length, diameter=diameter, drag=ratio * critical)
    load = Load.harmonic(0.4 * force, force, frequency=frequency)
    system = System.from_si(bar, load, Kept(r))
    omega = 2 * math.pi * frequency
    assert system.is_si
    assert system.s == pytest.approx(bar.wave_speed / (length * omega), rel=1e-14)
    assert system.d == pytest.approx(2 * ratio * math.pi * system.s, rel=1e-13, abs=1e-300)
    assert system.restitution == r
    assert system.angular_frequency == pytest.approx(omega, rel=1e-15)
    mass_per_length = bar.mass / length
    assert system.force_scale == pytest.approx(mass_per_length * (length * omega) ** 2, rel=1e-13)
    assert system.energy_scale == pytest.approx(mass_per_length * length**3 * omega**2, rel=1e-13)
    assert system.power_scale == pytest.approx(mass_per_length * length**3 * omega**3, rel=1e-13)
    assert system.speed_scale == pytest.approx(length * omega, rel=1e-14)
    assert system.time_scale == pytest.approx(1 / omega, rel=1e-14)
    back = system.load.scaled(system.force_scale, frequency=frequency)
    assert np.abs(back.coefficients - load.coefficients).max() <= 1e-14 * force
    # static strain under the mean force: s**2 u_x = p is E A u_x = P
    assert system.load.mean / system.s**2 == pytest.approx(load.mean / (bar.youngs_modulus * bar.area), rel=1e-13)


def test_scales_belong_to_si_systems_only() -> None:
    for name in (
        "angular_frequency",
        "length_scale",
        "time_scale",
        "speed_scale",
        "force_scale",
        "energy_scale",
        "power_scale",
        "stress_scale",
    ):
        with pytest.raises(ParameterError, match="from_si"):
            getattr(SYSTEM, name)
    assert not SYSTEM.is_si


@given(wave_speeds, dampings, restitutions)
def test_system_keeps_what_it_is_given(s: float, d: float, r: float) -> None:
    system = System(s=s, d=d, restitution=r, load=SMOOTH)
    assert (system.s, system.d, system.restitution, system.load) == (s, d, r, SMOOTH)
    assert system.with_restitution(0.25) == System(s=s, d=d, restitution=0.25, load=SMOOTH)
    assert f"R = {r:.6g}" in str(system)


# -- a load from a function -------------------------------------------------------------------------------------------


def half_sine(t: float) -> float:
    """One that takes no arrays, with two kinks."""
    return 2.0 * math.sin(t) - 0.5 if t < math.pi else -0.5


@pytest.mark.parametrize("tolerance", [0.1, 1e-2, 1e-3])
@pytest.mark.parametrize("function", [half_sine, lambda t: np.exp(np.cos(t - 0.3)) + 0.2 * np.sin(7 * t)])
def test_a_function_is_met_to_the_tolerance_with_as_few_harmonics_as_that_takes(
    function: Any, tolerance: float
) -> None:
    load = Load.from_function(function, tolerance=tolerance)
    assert load.error is not None
    assert load.error <= tolerance
    phases = np.linspace(0.0, 2.0 * math.pi, 5001)
    values = np.array([float(function(t)) for t in phases])
    alternating = np.abs(values - load.mean).max()
    assert np.abs(load.value(phases) - values).max() <= 1.25 * tolerance * alternating  # also where it was not looked
    fewer = Load.from_function(function, harmonics=load.coefficients.size - 2)
    assert fewer.error is not None
    assert fewer.error > tolerance
    same = load.shifted(0.3).scaled(2.0)
    assert same.error == load.error


def test_a_function_that_is_a_sum_of_harmonics_is_that_sum() -> None:
    load = Load.from_function(lambda t: 0.9 + np.cos(3 * t) - 0.2 * np.sin(5 * t), frequency=40.0)
    assert load.coefficients == pytest.approx([0.9, 0, 0, 1.0, 0, 0.2j], abs=1e-14)
    assert load.harmonics.tolist() == [3, 5]  # not what rounding leaves of the others
    assert load.frequency == 40.0
    assert Load.from_function(lambda t: 2.5).is_constant
    half = Load.from_function(half_sine, tolerance=1e-4)
    known = [2.0 / math.pi - 0.5, -1.0j, -4.0 / (3.0 * math.pi), 0.0, -4.0 / (15.0 * math.pi)]
    assert half.coefficients[:5] == pytest.approx(known, abs=1e-7)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (3.0, "a function of the load phase"),
        (lambda t: np.sign(np.sin(t)), "Load.steps"),
        (lambda t: t, r"f\(0\) = 0 and f\(2π\) = 6.28"),
        (lambda t: math.inf, "a finite force"),
        (lambda t: "x", "a number for a phase"),
        (lambda: 1.0, "a number for a phase"),
        (lambda t: np.exp(1j * t), "complex"),
        (lambda t: complex(math.cos(t), 1.0), "complex"),
        (lambda t: np.where(np.abs(t - 3.0) < 1e-3, np.nan, 1.0), r"not at the phase (2\.99|3\.00)"),
        (lambda t: 0.4 + np.exp(-(((t - 2.0034) / 5e-4) ** 2)), "4096 harmonics"),
    ],
)
def test_functions_that_are_no_load(function: Any, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        Load.from_function(function)


@pytest.mark.parametrize("k", [255, 256, 512, 1023, 1024, 2048, 4096])
@pytest.mark.parametrize("slow", [0.0, 1.0])
def test_fast_harmonics_of_a_function_are_not_taken_for_slow_ones(k: int, slow: float) -> None:
    """On a grid of 2π/1024 cos 1024t is 1, and cos 1023t is cos t."""
    load = Load.from_function(lambda t: 0.4 + slow * np.cos(t) + 0.5 * np.cos(k * t))
    expected = np.zeros(k + 1, dtype=complex)
    expected[0], expected[1], expected[k] = 0.4, slow, 0.5
    assert load.coefficients == pytest.approx(expected, abs=1e-12)
    few = Load.from_function(lambda t: 0.4 + slow * np.cos(t) + 0.5 * np.cos(k * t), harmonics=3)
    assert few.coefficients[:2] == pytest.approx([0.4, slow], abs=1e-12)
    assert few.error is not None
    assert few.error == pytest.approx(0.5 / (0.5 + slow), rel=1e-2) if not slow else few.error > 0.3


def test_a_narrow_spike_of_a_function_is_kept() -> None:
    """It is 0.0058 wide, and stands between two of 1024 phases."""
    load = Load.from_function(lambda t: 0.4 + np.maximum(1.0 - ((t - 2.00338) / 2.9e-3) ** 2, 0.0) ** 3, tolerance=0.02)
    assert load.value(2.00338) == pytest.approx(1.4, abs=0.02)
    assert load.value(2.1) == pytest.approx(0.4, abs=0.02)


def test_what_goes_wrong_in_a_function_is_the_cause_of_the_error() -> None:
    def broken(t: Any) -> float:
        raise KeyError("pressure")

    with pytest.raises(ParameterError, match=r"at the phase 0 it ends with KeyError: 'pressure'") as caught:
        Load.from_function(broken)
    assert isinstance(caught.value.__cause__, KeyError)
