"""Bars, stepped ones above all: modes, shapes, receptance and bounds against oracles that share no code with them."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from percuss.model import Body, External, KelvinVoigt, Ratio, SteppedBar, UniformBar
from stepped_oracle import end_force, finite_elements, receptance, sections, stepped_bars
from strategies import decades

FIGURES = json.loads((Path(__file__).parents[1] / "data" / "blow.json").read_text(encoding="utf-8"))
STEADY = [case for case in FIGURES if case["kind"] == "steady"]
X = np.linspace(0.0, 1.0, 11)
PISTON = SteppedBar(12.0, (1.0, 3.0, 1.5), (1.0, 1.0, 0.5), lengths=(1.0, 2.0, 1.0))
JUMPS = SteppedBar(7.0, (1.0, 9e5, 1.0, 1.2e-6, 1.0), (1.0, 0.3, 0.7, 0.2, 0.1))
ROUGH = SteppedBar(20.0, tuple(10.0 ** (2.9 * math.sin(7.0 * i * i)) for i in range(40)), (1.0, 0.5) * 20)
UNIFORM = decades(-2.0, 2.0).map(UniformBar)
BARS = pytest.mark.parametrize("bar", [PISTON, JUMPS, ROUGH], ids=["piston", "jumps", "rough"])


def grid(bar: SteppedBar, points: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Gauss–Legendre points in every section, and masses that go with them."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    ends = np.append(bar.sections.start, 1.0)
    mass = bar.sections.impedance * bar.sections.transit
    x = [low + 0.5 * (nodes + 1.0) * (high - low) for low, high in pairwise(ends)]
    return np.concatenate(x), np.concatenate([0.5 * weights * own for own in mass])


# ---------------------------------------------------------------- figures


@pytest.mark.parametrize("case", STEADY, ids=lambda case: case["name"])
def test_frequencies_and_couplings_of_the_reference(case: dict) -> None:
    bar = SteppedBar(
        float(case["s"]), [float(z) for z in case["impedances"]], [float(t) for t in case["transit_times"]]
    )
    modes = bar.modes(8)
    assert modes.omega == pytest.approx([float(w) for w in case["expect"]["omega_N8"]], rel=1e-13)
    assert modes.gamma == pytest.approx([float(g) for g in case["expect"]["gamma_N8"]], rel=1e-12)


# ---------------------------------------------------------------- the uniform bar as a limit


@given(
    s=st.floats(0.05, 1000.0),
    parts=st.lists(st.floats(0.01, 1.0), min_size=1, max_size=12),
    x=st.floats(0.0, 1.0),
    source=st.floats(0.0, 1.0),
    z=st.complex_numbers(min_magnitude=1e-4, max_magnitude=200.0),
)
def test_equal_sections_are_a_uniform_bar(s: float, parts: list[float], x: float, source: float, z: complex) -> None:
    bar, uniform = SteppedBar(s, (3.0,) * len(parts), tuple(parts)), UniformBar(s)
    at = np.array([x, *X, *bar.places])
    assert bar.frequencies(32) == pytest.approx(uniform.frequencies(32), rel=1e-14)
    assert bar.inertia(32) == pytest.approx(uniform.inertia(32), rel=1e-12)
    for own, other in zip(bar.shapes(at, 32), uniform.shapes(at, 32), strict=True):
        assert own == pytest.approx(other, abs=1e-12 * np.abs(other).max())
    for own, other in zip(bar.static_shape(at, source), uniform.static_shape(at, source), strict=True):
        assert own == pytest.approx(other, abs=1e-14 / s**2)
    frequency = np.array([complex(abs(z.real), -max(abs(z.imag), 1e-2 * abs(z)))]) * s
    found, wanted = (own.lossless_receptance(frequency, at, source) for own in (bar, uniform))
    for own, other, least in zip(found, wanted, (abs(frequency[0]) ** -2, s**-2), strict=True):
        assert np.abs(own - other).max() <= 1e-12 * max(np.abs(other).max(), 1e-3 * least) * max(1.0, abs(z))
    assert bar.coupling_bound == pytest.approx(2.0, rel=1e-13)
    assert bar.frequency_floor(7) == pytest.approx(uniform.frequency_floor(7), rel=1e-14)


# ---------------------------------------------------------------- modes: orthogonal, complete, none missed


@BARS
def test_modes_are_orthogonal_with_modal_mass_1(bar: SteppedBar) -> None:
    count = 48
    x, mass = grid(bar)
    shapes = bar.shapes(x, count).displacement / np.sqrt(bar.inertia(count))
    omega = bar.frequencies(count)
    apart = np.abs(omega[:, None] / omega - 1.0) + np.eye(count)  # modes that near each other mix, as their sums may
    assert np.all(np.abs(shapes.T * mass @ shapes - np.eye(count)) <= 1e-11 + 1e-15 / apart)
    assert np.abs(mass @ shapes).max() <= 1e-11  # and to the rigid motion


@BARS
def test_strain_is_the_slope_and_the_modes_hold_as_much_strain_as_kinetic_energy(bar: SteppedBar) -> None:
    count, step = 16, 1e-6
    x, mass = grid(bar)
    strain = bar.shapes(x, count).strain / np.sqrt(bar.inertia(count))
    flow = mass / bar.sections.slowness[bar.sections.locate(x)[0]] ** 2
    assert flow @ strain**2 == pytest.approx(bar.frequencies(count) ** 2, rel=1e-11)
    inside = np.array([0.5 * (low + high) for low, high in zip(bar.places, (*bar.places[1:], 1.0), strict=True)])
    low, high = (bar.shapes(inside + way * step, count).displacement for way in (-1.0, 1.0))
    slope = bar.shapes(inside, count).strain
    assert np.abs((high - low) / (2.0 * step) - slope).max() <= 1e-5 * np.abs(slope).max()


@given(bar=stepped_bars(most=6, spread=1.0))
@settings(max_examples=15)
def test_no_mode_is_missed(bar: SteppedBar) -> None:
    """Finite elements count the modes in their own way, and find each of them from above."""
    elements = finite_elements(bar, 12)
    own = bar.frequencies(8)
    assert np.all(elements[:8] >= own * (1.0 - 1e-7)) and elements[:8] == pytest.approx(own, rel=2e-2)


@given(bar=stepped_bars(most=40), n=st.integers(1, 200))
@settings(max_examples=25)
def test_the_end_is_free_at_every_frequency(bar: SteppedBar, n: int) -> None:
    """The force at the striking end changes its sign within rounding of each frequency, in 300 digits."""
    omega = mpf(float(bar.frequencies(n)[-1]))
    with mp.workdps(300):
        low, high = (end_force(bar, omega * (1 + way * mpf(10) ** -11)) for way in (-1, 1))
    assert (low * high <= 0) != _pairs(bar, n)


def _pairs(bar: SteppedBar, n: int) -> bool:
    """Whether another mode is so near that both change the sign."""
    omega = bar.frequencies(n + 1)
    near = np.abs(omega - omega[n - 1]) <= 3e-11 * omega[n - 1]
    return bool(near.sum() % 2 == 0)


@given(bar=stepped_bars() | UNIFORM)
@settings(max_examples=30)
def test_modes_are_in_order_and_within_their_bounds(bar: Body) -> None:
    count = 300
    omega, n = bar.frequencies(count), np.arange(1, count + 1)
    assert np.all(np.diff(omega) >= 0.0) and omega[0] > 0.0
    for first in (1, 128, 200):
        floor = bar.frequency_floor(first)
        later = np.arange(count - first + 1)
        assert np.all(omega[first - 1 :] >= (floor + later * np.pi * bar.s) * (1.0 - 1e-12))
    assert bar.frequency_floor(128) > 0.0
    lag = bar.sections.lag if isinstance(bar, SteppedBar) else 0.0
    assert np.all(np.abs(omega - n * np.pi * bar.s) <= lag * bar.s + 1e-9 * omega)
    shapes = bar.shapes(np.append(X, bar.places), 64).displacement / np.sqrt(bar.inertia(64))
    assert np.abs(shapes).max() ** 2 <= bar.coupling_bound * (1.0 + 1e-12)
    assert np.all(np.isfinite(bar.modes(64).gamma)) and np.all(bar.inertia(64) > 0.0)


@BARS
def test_all_modes_together_are_the_static_shape(bar: SteppedBar) -> None:
    """Σ φ(x) φ(p)/ω² with the tail's bound: neither a mode too few nor one twice."""
    count = 4096
    omega, shapes = bar.frequencies(count), bar.shapes(X, count).displacement / np.sqrt(bar.inertia(count))
    tail = (shapes**2).max() / omega[-1] * 2.0 / (np.pi * bar.s)
    whole = np.array([bar.static_shape(X, p).displacement for p in X])
    assert np.abs((shapes / omega**2) @ shapes.T - whole).max() <= tail + 1e-11 * np.abs(whole).max()


# ---------------------------------------------------------------- receptance and static shape


@given(
    bar=stepped_bars(most=12, s=3.0),
    share=st.one_of(st.floats(1e-4, 0.9), st.floats(1.1, 300.0)),
    loss=st.sampled_from([0.0, 1e-3, 0.3, 3.0]),
    x=st.floats(0.0, 1.0),
    place=st.integers(0, 100),
)
@settings(max_examples=20)
def test_receptance_by_transfer_matrices_in_many_digits(
    bar: SteppedBar, share: float, loss: float, x: float, place: int
) -> None:
    """At any frequency, from far below the first mode to far above, at any point, for a load at any step."""
    z = float(bar.frequencies(1)[0]) * share * (1.0 - 1j * loss)
    places = [*bar.places, 1.0]
    source = places[place % len(places)]
    at = np.array([x, source, 0.0, 1.0])
    near = float(np.min(np.abs(bar.frequencies(400) / abs(z) - 1.0))) if loss == 0.0 else 1.0
    assume(near > 1e-4)
    with mp.workdps(250 + int(abs(z.imag) / bar.s)):  # waves that grow by e^(Im z/s), less those that fall as much
        wanted = np.array([receptance(bar, z, own, source) for own in at])
    found = bar.lossless_receptance(np.array([z]), at, source).displacement[0]
    own = np.abs(bar.static_shape(np.array([source]), source).displacement[0])
    scale = max(np.abs(wanted).max(), own if share < 1.0 else abs(z) ** -2.0)
    assert np.abs(found - wanted).max() <= 1e-11 * scale * max(1.0, 1e-2 / near)


@BARS
@pytest.mark.parametrize("law", [External(0.3), Ratio(1e-2), KelvinVoigt(1e-4)], ids=str)
def test_receptance_is_the_sum_of_damped_modes(bar: SteppedBar, law) -> None:
    """With the static shape for the modes that are not summed: the rest falls off like 1/N³."""
    damped = SteppedBar(bar.s, bar.impedances, bar.transit_times, law, bar.lengths)
    k = np.array([1.0, 3.0, 40.0])
    for at in (0, len(bar.places) - 1):
        whole, some = damped.receptance(k, X, at), damped.receptance(k, X, at, 3000)
        rest = damped.static(X, at).displacement - damped.static(X, at, 3000).displacement
        rest = np.outer(law.lossless(k).factor, rest)  # far above the load: d_n k/ω_n² is 0, or that of every mode
        most = np.abs(whole.displacement).max()
        assert np.abs(whole.displacement - some.displacement - rest).max() <= 3e-4 * np.abs(rest).max() + 1e-10 * most


@given(bar=stepped_bars(most=30) | UNIFORM, x=st.floats(0.0, 1.0), y=st.floats(0.0, 1.0))
@settings(max_examples=20)
def test_reciprocity_inside_the_bar(bar: Body, x: float, y: float) -> None:
    z = bar.frequencies(3)[[0, 2]] * np.array([0.3 - 0.01j, 1.2 - 0.3j])
    one, other = np.array([x]), np.array([y])
    there, here = bar.lossless_receptance(z, one, y).displacement, bar.lossless_receptance(z, other, x).displacement
    most = np.abs(bar.lossless_receptance(z, np.array([x, y]), x).displacement).max()
    assert np.abs(there - here).max() <= 1e-11 * max(most, np.abs(there).max())
    still = bar.static_shape(one, y).displacement[0], bar.static_shape(other, x).displacement[0]
    assert still[0] == pytest.approx(still[1], rel=1e-12, abs=1e-300)


@given(bar=stepped_bars(most=60))
@settings(max_examples=30)
def test_a_bar_turned_round(bar: SteppedBar) -> None:
    """Reciprocity: the same frequencies and couplings of the ends, whichever end strikes."""
    turned = SteppedBar(bar.s, bar.impedances[::-1], bar.transit_times[::-1])
    assert bar.frequencies(40) == pytest.approx(turned.frequencies(40), rel=1e-11)
    gap = np.diff(bar.frequencies(41)) / bar.frequencies(40)
    gap = np.minimum(gap, np.append(1.0, gap[:-1]))
    modes, own, other = bar.modes(40), bar.modes(40).gamma, turned.modes(40).gamma
    # modes that are near each other mix by rounding over their gap, the one at home here with the one at home there
    mixed = 1e-14 / gap * np.sqrt(modes.weight.max() / modes.inertia.min())
    assert np.all(np.abs(np.abs(own) - np.abs(other)) <= 1e-11 * np.maximum(np.abs(own), 1e-3) + mixed)
    z = np.array([0.3 - 0.01j, 40.0 - 3.0j]) * bar.s
    ends = bar.lossless_receptance(z, np.array([1.0])), turned.lossless_receptance(z, np.array([1.0]))
    assert np.abs(ends[0].displacement - ends[1].displacement).max() <= 1e-11 * np.abs(ends[0].displacement).max()


@BARS
def test_static_shape_is_in_balance(bar: SteppedBar) -> None:
    """No mean displacement; EA u_x is what accelerates the mass behind it, less the force where it works."""
    x, mass = grid(bar, 20)
    for source in (*bar.places[:3], 1.0):
        shape = bar.static_shape(x, source)
        assert abs(mass @ shape.displacement) <= 1e-13 * np.abs(shape.displacement).max()
        force = shape.strain * bar.sections.stiffness[bar.sections.locate(x)[0]]
        before = bar.sections.masses(*bar.sections.locate(x))[0]
        assert force == pytest.approx(before - (x >= source), abs=1e-14)


def test_motion_of_a_heavy_and_a_light_section() -> None:
    """Two masses on a light spring: ω² = k/m₁ + k/m₂ to the spring's share of the mass."""
    bar = SteppedBar(1.0, (1.0, 1e-5, 3.0), (1e-3, 1.0, 1e-3))
    z, tau = (np.array([float(v) for v in part]) for part in sections(bar))
    spring, one, other = z[1] / tau[1], z[0] * tau[0], z[2] * tau[2]
    assert bar.frequencies(1)[0] == pytest.approx(math.sqrt(spring / one + spring / other), rel=1e-2)


# ---------------------------------------------------------------- loads at steps, small things, nonsense


def test_a_load_at_the_node_of_a_mode_does_not_drive_it() -> None:
    bar = SteppedBar(4.0, (2.0, 2.0), (1.0, 1.0))
    assert bar.places == (0.0, 0.5)
    assert bar.modes(4, at=1).gamma == pytest.approx([0.0, -2.0, 0.0, 2.0], abs=1e-14)
    assert bar.modes(4, at=1).weight == pytest.approx([0.0, 2.0, 0.0, 2.0], abs=1e-14)


def test_where_x_is_follows_the_lengths() -> None:
    plain = SteppedBar(5.0, (2.0, 1.0), (1.0, 3.0))
    sized = SteppedBar(5.0, (2.0, 1.0), (1.0, 3.0), lengths=(2.0, 2.0))
    assert plain.places == (0.0, 0.25) and sized.places == (0.0, 0.5)
    there, here = sized.shapes(np.array([0.25, 0.75]), 6), plain.shapes(np.array([0.125, 0.625]), 6)
    assert there.displacement == pytest.approx(here.displacement, abs=1e-13)
    assert there.strain == pytest.approx(here.strain * np.array([[0.5], [1.5]]), abs=1e-11)


def test_only_ratios_of_impedances_and_times_matter() -> None:
    one, other = SteppedBar(5.0, (2.0, 1.0), (1.0, 2.0)), SteppedBar(5.0, (8e5, 4e5), (1e-6, 2e-6))
    assert one.frequencies(9) == pytest.approx(other.frequencies(9), rel=1e-14)
    assert one.modes(9).gamma == pytest.approx(other.modes(9).gamma, rel=1e-13)


def test_more_modes_do_not_change_the_first_ones() -> None:
    assert JUMPS.frequencies(1000)[:10].tolist() == JUMPS.frequencies(10).tolist()


@BARS
def test_masses_follow_from_the_forces_in_the_bar(bar: SteppedBar) -> None:
    """What a body says of its masses, and what its static shape tells of them by itself."""
    ends = np.append(bar.sections.start, 1.0)
    assert bar.mass_before(ends) == pytest.approx(bar.sections.before, abs=1e-13)
    assert Body.mass_before(bar, X) == pytest.approx(bar.mass_before(X), abs=1e-7)
