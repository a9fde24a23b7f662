"""Pieces of waves that are joined: within the bound of what they stand for, and far fewer of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from numpy.polynomial import chebyshev

from percuss.blow import BlowOutcome, Rock, Rod, strike
from percuss.blow.kernels.rows import joined
from percuss.blow.kernels.wave_records import APART, MOST_JOINED, WIDTH
from percuss.model import Section, SectionedBar

_joined: Any = njit(joined.py_func)  # by itself it can be called by compiled functions only
SERIES = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=7)
SHARES = st.floats(0.02, 0.98)


def part(whole: np.ndarray, low: float, high: float) -> np.ndarray:
    """A series on a part of [−1, 1], by interpolation."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return chebyshev.chebinterpolate(lambda x: chebyshev.chebval(middle + half * x, whole), whole.size - 1)


def result(p: np.ndarray, c: np.ndarray, share: float, spent: float = 0.0) -> tuple[np.ndarray | None, float]:
    """What p and c, which are on so much of the interval and on the rest, are joined to, and the error it tells."""
    out, work = np.zeros(WIDTH), np.zeros((3, WIDTH))
    room = [np.pad(one, (0, WIDTH - one.size)) for one in (p, c)]
    degree, error = _joined(room[0], p.size - 1, share, room[1], c.size - 1, 1.0 - share, spent, out, work)
    return (None if degree < 0 else out[: degree + 1], error)


def distance(found: np.ndarray, p: np.ndarray, c: np.ndarray, share: float) -> float:
    """The greatest difference from both, on a fine grid."""
    x = np.linspace(-1.0, 1.0, 201)
    first = chebyshev.chebval(share * (1.0 + x) - 1.0, found) - chebyshev.chebval(x, p)
    second = chebyshev.chebval(share + (1.0 - share) * x, found) - chebyshev.chebval(x, c)
    return float(max(abs(first).max(), abs(second).max()))


@given(series=SERIES, share=SHARES)
def test_two_parts_of_one_polynomial_are_joined_to_it(series: list[float], share: float) -> None:
    whole, cut = np.array(series), 2.0 * share - 1.0
    found, error = result(part(whole, -1.0, cut), part(whole, cut, 1.0), share)
    assert found is not None
    assert found.size <= MOST_JOINED + 1
    difference = np.zeros(max(found.size, whole.size))
    difference[: found.size] = found
    difference[: whole.size] -= whole
    assert abs(difference).sum() < 1e-13
    assert error <= APART


@given(series=SERIES, share=SHARES, bends=st.lists(st.floats(-18.0, -8.0), min_size=1, max_size=4))
def test_what_is_joined_is_within_the_bound_and_tells_its_error(
    series: list[float], share: float, bends: list[float]
) -> None:
    """The second part differs by powers of the time from the first, small or not."""
    whole, cut = np.array(series), 2.0 * share - 1.0
    p, c = part(whole, -1.0, cut), part(whole, cut, 1.0)
    for k, size in enumerate(bends):
        power = chebyshev.chebpow(np.array([0.5, 0.5]), k)  # ((1 + x)/2)^k, flat where it begins
        c = chebyshev.chebadd(c, 10.0**size * power)
    found, error = result(p, c, share)
    if found is None:
        assert error == 0.0
    else:
        apart = distance(found, p, c, share)
        assert apart <= error + 1e-15 * (1.0 + abs(whole).sum())
        assert error <= APART


@given(series=SERIES, share=SHARES)
def test_what_jumps_is_not_joined(series: list[float], share: float) -> None:
    whole, cut = np.array(series), 2.0 * share - 1.0
    c = part(whole, cut, 1.0)
    c[0] += 4.0 * APART
    assert result(part(whole, -1.0, cut), c, share)[0] is None


def test_errors_of_one_piece_add_up_to_the_bound_and_no_further() -> None:
    whole = np.array([0.3, 0.2, 0.1])
    p, c = part(whole, -1.0, 0.0), part(whole, 0.0, 1.0)
    assert result(p, c, 0.5)[0] is not None
    assert result(p, c, 0.5, spent=1.1 * APART)[0] is None


def drilled(bit_mass: float) -> Any:
    """Three sections and two, in sizes of a drifter, for twenty transits of the piston."""
    sizes = ((0.0731, 0.04), (0.2187, 0.05), (0.1493, 0.03478))
    piston = SectionedBar([Section(length, diameter=d, youngs_modulus=206e9) for length, d in sizes])
    rod = [Section(0.4, diameter=0.045), Section(1.1, diameter=0.038)]
    rock = Rock(4e8, unloading_ratio=0.3)
    return strike(piston, Rod(rod, "rock", bit_mass=bit_mass, rock=rock), 10.0, until=20.0 * piston.transit_time)


@pytest.mark.parametrize(("bit_mass", "most"), [(1.5, 130_000), (1e-6, 260_000)])
def test_the_waves_of_a_drifter_have_no_pieces_but_those_that_they_need(bit_mass: float, most: int) -> None:
    """Unjoined, the first has 267 000; the second more than a window may have, unless fast motions are let go."""
    blow = drilled(bit_mass)
    assert blow.outcome is not BlowOutcome.TOO_MANY_PIECES
    assert blow._course.held.waves.pieces.sum() < most
    assert abs(blow.energy_error) < 1e-12
    assert abs(blow.momentum_error) < 1e-12
