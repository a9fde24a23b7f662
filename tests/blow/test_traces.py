"""Traces: sums of pieces, and their envelope."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from blow_strategies import collisions, exact_collisions, struck
from collisions import Collision
from percuss.blow import Rock, Rod, Trace, Wall, strike
from percuss.blow.over_time import cells_over_time, force_envelope
from percuss.blow.trace import extreme
from percuss.errors import ParameterError
from percuss.model import Bar, Section, SectionedBar

# -- traces against plain polynomials, and the greatest force of a long blow against its states ----------------------


SERIES = np.polynomial.Chebyshev
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


@st.composite
def traces(draw: st.DrawFn) -> Trace:
    """Pieces of different lengths and degrees, some of them constant or 0."""
    size, width = draw(st.integers(1, 6)), draw(st.integers(1, 7))
    lengths = draw(st.lists(st.floats(0.1, 2.0), min_size=size, max_size=size))
    rows = [draw(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=width)) for _ in range(size)]
    coefficients = np.array([row + [0.0] * (width - len(row)) for row in rows])
    return Trace(np.cumsum([0.0, *lengths]), coefficients)


def series(trace: Trace) -> list[np.polynomial.Chebyshev]:
    ends = zip(trace.times[:-1], trace.times[1:], strict=True)
    return [SERIES(row, domain=pair) for row, pair in zip(trace.coefficients, ends, strict=True)]


@given(traces(), traces())
def test_integrals_of_products_are_those_of_polynomials(one: Trace, other: Trace) -> None:
    expected = 0.0
    for p in series(one):
        for q in series(other):
            low, high = max(p.domain[0], q.domain[0]), min(p.domain[1], q.domain[1])
            if high > low:
                t = 0.5 * (low + high) + 0.5 * (high - low) * NODES
                expected += 0.5 * float((high - low) * (p(t) * q(t) @ WEIGHTS))
    assert one.product_integral(other) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@given(traces())
def test_the_integral_of_a_square_is_that_of_the_product_with_a_copy(trace: Trace) -> None:
    copy = Trace(trace.times, trace.coefficients)
    assert trace.product_integral(trace) == pytest.approx(trace.product_integral(copy), rel=1e-12, abs=1e-300)


@given(traces())
def test_no_value_of_a_piece_exceeds_its_peak_and_one_reaches_it(trace: Trace) -> None:
    x = np.cos(np.linspace(0.0, np.pi, 2001))
    for row, peak in zip(trace.coefficients, trace.piece_peaks, strict=True):
        greatest = np.polynomial.chebyshev.chebval(x, row).max()
        assert greatest - 1e-13 <= peak <= greatest + 1e-4


@settings(max_examples=5)
@given(st.floats(0.5, 3.0), st.floats(5.0, 9.0))
def test_no_state_of_a_long_blow_exceeds_its_peaks(bit: float, transits: float) -> None:
    """Thousands of bent pieces, in blocks: what is passed over must not matter."""
    sizes = ((0.0731, 0.04), (0.2187, 0.05), (0.1493, 0.03478))
    striker = SectionedBar([Section(length, diameter=d) for length, d in sizes])
    rod = Rod(
        [Section(0.4, diameter=0.045), Section(1.1, diameter=0.038)],
        "rock",
        bit_mass=bit,
        rock=Rock(4e8, unloading_ratio=0.3),
    )
    blow = strike(striker, rod, 10.0, until=transits * striker.transit_time)
    for i, peak in enumerate(blow.peaks[:3]):
        area = 0.25 * np.pi * sizes[i][1] ** 2
        both = (1.0, peak.compression, peak.compression_time), (-1.0, peak.tension, peak.tension_time)
        for sign, value, when in both:
            assert when is not None
            found = []
            for time in np.append(np.linspace(0.0, blow.until, 60), when):
                state = blow.state_at(float(time)).striker
                found.append(float((sign * state.force[state.section == i]).max()) / area)
            assert max(found) <= value * (1.0 + 1e-9)
            assert found[-1] >= value * (1.0 - 1e-3)


# -- the greatest force at every place -------------------------------------------------------------------------------


CELLS = 24
TWO_PEAKS = Collision(
    striker=((1.1547819846894583, 1.0), (7.498942093324558, 1.0)), velocity=(1.0, 1.0), until=8.0,
    rod=((10.0, 1.0), (8.659643233600654, 1.0)), end="free", bit_mass=10.0, joint_masses=((1, 10.0),),
)  # fmt: skip
"""In the last section the greatest force is where a wave has a maximum that is not its greatest within the piece."""
GOLDEN = 0.3819660112501051
"""No instant that is a golden part of a step is one at which breaks of waves in whole numbers meet."""


@settings(max_examples=20)
@given(case=collisions())
@example(case=TWO_PEAKS)
def test_no_place_has_more_than_its_section(case: Collision) -> None:
    blow = struck(case)
    own, speed = len(case.striker), (2.0 * blow.energy_before / blow.striker_mass) ** 0.5
    known = (blow.peaks[:own], case.striker), (blow.peaks[own:], case.rod or ())
    for body, (peaks, chain) in zip(force_envelope(blow, CELLS, 2.0), known, strict=True):
        if body is None:
            assert not chain
            continue
        area = np.array([float(z) for z, _ in chain])  # stresses are forces over impedances, E = ρ = 1
        for name in ("compression", "tension"):
            most = (np.array([getattr(peak, name) for peak in peaks]) * area)[body.section]
            values = getattr(body, name)
            rounding = 1e-9 * float(most.max(initial=0.0)) + 1e-13 * speed * float(area.max())
            assert (values >= 0.0).all() and (values <= most + rounding).all()


@settings(max_examples=20)
@given(case=exact_collisions())
def test_stepwise_waves_are_never_missed(case: Collision) -> None:
    """What cells show at instants between all breaks is within what they show at most."""
    blow = struck(case)
    times = blow.until * (np.arange(60) + GOLDEN) / 60.0
    envelopes, shown = force_envelope(blow, CELLS, 2.0), cells_over_time(blow, times, CELLS, 2.0)
    for most, cells in zip(envelopes, shown, strict=True):
        if most is None or cells is None:
            assert most is cells is None
            continue
        np.testing.assert_allclose(most.edges, cells.edges)
        scale = max(float(abs(cells.force).max()), 1e-300)
        assert (cells.force.max(axis=0) <= most.compression + 1e-9 * scale).all()
        assert ((-cells.force).max(axis=0) <= most.tension + 1e-9 * scale).all()


def test_a_bar_on_a_wall_is_pressed_everywhere_alike() -> None:
    bar = Bar(0.5, area=1e-3)
    own, rod = force_envelope(strike(bar, Wall(), 10.0), 50, 1.0)
    force = 10.0 * 1e-3 * (bar.youngs_modulus * bar.density) ** 0.5
    np.testing.assert_allclose(own.compression, force, rtol=1e-12)
    assert rod is None and not own.tension.any()


def test_a_pulse_comes_back_from_a_free_end_as_tension() -> None:
    """Its whole force at every place that it has passed alone, 2τ long."""
    bar, length = Bar(0.2, area=1e-3), 2.0
    speed = bar.wave_speed
    until = 1.6 * length / speed
    _, rod = force_envelope(strike(bar, Rod([Section(length, area=1e-3)], "free"), 10.0, until=until), 80, 1.0)
    assert rod is not None
    force = 0.5 * 10.0 * 1e-3 * (bar.youngs_modulus * bar.density) ** 0.5
    x = 0.5 * (rod.edges[1:] + rod.edges[:-1])
    back, passed = (2.0 * length - x) / speed, (x + 2.0 * bar.length) / speed
    alone = np.maximum(back, passed) < until
    np.testing.assert_allclose(rod.compression, force, rtol=1e-12)
    np.testing.assert_allclose(rod.tension[alone], force, rtol=1e-12)
    assert alone.sum() > 40 and not rod.tension[back > until].any()


def test_nonsense_is_refused() -> None:
    blow = strike(Bar(0.5, area=1e-3), Wall(), 10.0)
    for cells, reach in ((0, 1.0), (10, 0.0), (10, float("nan"))):
        with pytest.raises(ParameterError):
            force_envelope(blow, cells, reach)


def test_a_coefficient_that_is_hardly_a_number_is_nothing() -> None:
    assert extreme(np.array([0.0, 4.0, 0.0, 2e-313])) == 4.0
    assert extreme(np.array([3.0, 1e-310])) == 3.0
