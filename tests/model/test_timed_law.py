"""The law of a blow that takes time: what it refuses, and its algebra."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.model import Timed

shares = st.floats(0.0, 1.0)


@given(
    r=shares, duration=st.floats(0.0, 1.0), share=shares, velocity=st.floats(-10.0, 10.0), force=st.floats(-5.0, 5.0)
)
def test_impulse_and_velocity_are_inverse(
    r: float, duration: float, share: float, velocity: float, force: float
) -> None:
    law = Timed(r, duration, share * duration)
    assert law.velocity(law.impulse(velocity, force), force) == pytest.approx(velocity, abs=1e-13)
    # a blow under a constant load, taken apart: velocity at the contact's start, and the push during the contact
    start = velocity - force * law.force_centroid
    push = force * law.after_centroid
    assert law.impulse(velocity, force) == pytest.approx((1.0 + r) * (start + push), abs=1e-12)


@given(s=st.floats(0.3, 1e3), heavier=st.floats(1.0, 1e4), speed=st.floats(0.1, 10.0))
def test_a_uniform_bar_on_a_rod(s: float, heavier: float, speed: float) -> None:
    rod = heavier * s  # impedance; the bar's own is s
    r = (rod - s) / (rod + s)
    law = Timed.of_uniform_bar(s, r)
    force = speed * s * rod / (s + rod)  # St Venant: constant during one round trip
    assert law.impulse(speed, 0.0) == pytest.approx(force * law.duration, rel=1e-12)
    assert law.advance_per_impulse * force * law.duration == pytest.approx(force / rod * law.duration, rel=1e-9)
    assert law.arm == 0.0
    assert Timed.of_uniform_bar(s, r, "pushed back").advance_per_impulse == 0.0
    assert Timed.of_uniform_bar(s, 1.0).advance_per_impulse == 0.0


def test_drag_takes_of_the_impulse_what_it_does_over_the_advance() -> None:
    law = Timed(0.5, 0.1, 0.05, 0.02)
    impulse = law.steady_impulse(0.9, 6.0, 0.3)
    assert impulse == pytest.approx(0.9 * 6.0 - 0.3 * 0.02 * impulse, rel=1e-15)
    assert law.steady_impulse(0.9, 6.0, 0.0) == 0.9 * 6.0


def test_ringing_left() -> None:
    law = Timed(0.5, 0.1, 0.05, ringing_share=0.25)
    assert law.ringing_left(0.0, 6.0) == 0.5
    assert law.ringing_left(0.2, 6.0) == pytest.approx(0.5 * math.exp(-1.2))
