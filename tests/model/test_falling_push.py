"""Chatter under a push that falls to 0, and the flights that it is made of."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Load, System
from percuss.model.contact.falling_push import FallingPush
from percuss.steady.resting.flight_chain import Leg, Motion, Swing


def next_impact(restitution: float, q: float) -> tuple[float, float]:
    """The flight σ and the next q, from y'' = τ with y = 0, y' = −q a time 1 before the push is gone."""
    flight = min(root.real for root in np.roots([-1.0 / 6.0, 0.5, -q]) if root.real > 0.0)
    speed = -q + flight - 0.5 * flight**2
    return flight, restitution * speed / (1.0 - flight) ** 2


@given(st.floats(0.01, 0.99))
def test_the_critical_impact_comes_back_to_itself(restitution: float) -> None:
    push = FallingPush(restitution)
    flight, after = next_impact(restitution, push.critical)
    assert flight == pytest.approx(push.flight, rel=1e-9)
    assert after == pytest.approx(push.critical, rel=1e-8)
    assert push.growth > 1.0


def test_without_rebound_it_is_the_last_moment() -> None:
    push = FallingPush(0.0)
    assert (push.critical, push.growth) == (pytest.approx(1.0 / 3.0), math.inf)


@pytest.mark.parametrize("restitution", [1e-300, 1e-12, 1.0 - 1e-6, math.nextafter(1.0, 0.0)])
def test_at_its_ends_it_is_known_as_well(restitution: float) -> None:
    """(1 − σ)² = R/2 for a small R, so that growth = √(32/R); growth = 1 + (1 − R) beside 1."""
    push = FallingPush(restitution)
    few = math.sqrt(32.0 / restitution) if restitution < 0.5 else 1.0 + (1.0 - restitution)
    assert push.growth == pytest.approx(few, rel=1e-5, abs=0)
    assert math.isfinite(push.excess(0.3))


@given(st.floats(0.02, 0.98), st.floats(0.3, 1.2))
def test_an_impact_multiplies_the_excess_by_the_growth(restitution: float, share: float) -> None:
    push = FallingPush(restitution)
    q = min(share * push.critical, 0.33)
    after = next_impact(restitution, q)[1]
    assert push.excess(after) == pytest.approx(push.growth * push.excess(q), rel=1e-5, abs=1e-9)
    assert math.copysign(1.0, push.excess(q)) == math.copysign(1.0, q - push.critical) or q == push.critical


@given(
    st.floats(0.0, 3.0), st.floats(-1.0, 0.0), st.floats(-1.0, 1.0), st.floats(1e-9, 7.0), st.floats(0.0, 6.0),
    st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=10),
)  # fmt: skip
def test_a_single_time_is_as_many(
    d: float, gap: float, rate: float, t: float, begin: float, sizes: list[float]
) -> None:
    load = Load.fourier([0.4, 1.0, *sizes])
    leg = Leg(Swing(System(s=5.0, d=d, restitution=0.5, load=load), 0), begin,
              Motion(gap, rate, rate, np.zeros(0), np.zeros(0)))  # fmt: skip
    (y,), (v,) = leg.gap(np.array([t]))
    assert leg.gap_at(t) == (pytest.approx(y, rel=1e-13, abs=1e-14 * t), pytest.approx(v, rel=1e-13, abs=1e-14))
