"""Traces against plain polynomials, and the greatest force of a long blow against its states."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.blow import Rock, Rod, Trace, strike
from percuss.model import Section, SectionedBar

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
