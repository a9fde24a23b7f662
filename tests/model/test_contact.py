"""Laws of the contact, of a blow that takes time too: what they do and take; chatter under a push that falls to 0."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Kept, Load, Reversed, System
from percuss.errors import ParameterError
from percuss.model import Contact, Result, SteppedBar, Timed, UniformBar
from percuss.model.contact import LAWS, restitution_of_ratio
from percuss.model.contact.falling_push import FallingPush
from percuss.steady.resting.flight_chain import ForcedResponse, GapState, ReleasedFlight

# -- contact laws ----------------------------------------------------------------------------------------------------


@given(r=st.floats(0.0, 1.0), u=st.floats(-1e3, 1e3), v=st.floats(-1e3, 1e3), omega=st.floats(0.1, 100.0))
def test_the_energy_taken_is_what_is_missing_after(r: float, u: float, v: float, omega: float) -> None:
    for law in (Kept(r), Reversed(r)):
        after_u, after_v = law.after(np.array(u), np.array(v))
        before, after = v**2 + omega**2 * u**2, after_v**2 + omega**2 * after_u**2
        assert before - float(after) == pytest.approx(law.energy_taken(v**2, omega**2 * u**2), abs=1e-12 * before)
        assert law.energy_taken(v**2, omega**2 * u**2) >= 0.0


def test_kept_and_reversed() -> None:
    assert Kept(0.3).after(np.ones(2), np.ones(2))[0].tolist() == [1.0, 1.0]
    assert Reversed(0.3).after(np.ones(2), np.ones(2))[0].tolist() == [-0.3, -0.3]
    assert Kept(0.3).velocity_factor == Reversed(0.3).velocity_factor == -0.3
    assert Kept(0.3).duration == 0.0
    assert list(LAWS.items()) == [("kept", Kept), ("reversed", Reversed)]
    assert Kept(0.3) != Reversed(0.3) and Reversed(0.3).with_restitution(0.5) == Reversed(0.5)


def test_what_does_not_hold_is_refused_with_the_reason() -> None:
    class Other(Kept):
        kind = "other"
        results = frozenset({Result.LEVEL})

    law: Contact = Other(0.3)
    law.need(Result.LEVEL)
    with pytest.raises(ParameterError, match="exact multipliers"):
        law.need(Result.REDUCED)


def test_the_strain_is_reversed_on_bars_that_send_no_wave_back_only() -> None:
    load, law = Load.harmonic(0.5, 1.0), Reversed(0.2)
    assert System(UniformBar(1.0), load, law).contact.strain_factor == -0.2
    assert System(SteppedBar(1.0, (2.0,), (1.0,)), load, law).contact == law
    assert System(SteppedBar(1.0, (0.1 * 3, 0.3), (1.0, 4.0), lengths=(3.0, 1.0)), load, law).contact == law
    with pytest.raises(ParameterError, match="kept"):
        System(SteppedBar(1.0, (2.0, 1.9999), (1.0, 1.0)), load, law)


def test_what_a_bar_of_sections_is() -> None:
    assert not SteppedBar(9.0, (1.0, 1.0), (1.0, 1.0), lengths=(1.0, 2.0)).is_uniform  # the second one is faster
    assert SteppedBar(9.0, (1.0, 1.0), (1.0, 1.0), lengths=(1.0, 2.0)).is_harmonic
    assert not SteppedBar(9.0, (1.0, 2.0), (1.0, 1.0)).is_harmonic


@given(r=st.floats(0.0, 1.0))
def test_what_depends_on_the_restitution(r: float) -> None:
    for law in (Kept(r), Reversed(r)):
        assert law.impulse == 1.0 + r
        assert restitution_of_ratio(law.impedance_ratio) == pytest.approx(r, abs=1e-15)
        assert law.is_lossless == (r == 1.0) and law.rebounds == (r > 0.0)
        assert law.keeps_strain == isinstance(law, Kept)
        # B77 (10): the impulse and the ratio say how a wave meets the rod of that ratio
        assert law.impulse * (1.0 + law.impedance_ratio) == pytest.approx(2.0)
        assert float(law.restitutions_of(law.impedance_ratio)) == pytest.approx(r, abs=1e-15)
        many = np.array([[r, 0.5], [0.0, r]])
        for i, one in np.ndenumerate(many):
            assert law.impedance_ratios(many)[i] == law.with_restitution(float(one)).impedance_ratio
            assert law.velocity_factors(many)[i] == law.with_restitution(float(one)).velocity_factor
            assert law.strain_factors(many)[i] == law.with_restitution(float(one)).strain_factor


def test_a_system_is_made_in_one_of_two_ways() -> None:
    load, bar = Load.harmonic(0.5, 1.0), UniformBar(1.0)
    assert (
        System(bar, load, Kept(0.2)) == System(s=1.0, d=0.0, restitution=0.2, load=load) == System(1.0, 0.0, 0.2, load)
    )


# -- the law of a blow that takes time -------------------------------------------------------------------------------


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


# -- chatter under a push that falls to 0, and the flights that it is made of ----------------------------------------


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
    leg = ReleasedFlight(ForcedResponse(System(s=5.0, d=d, restitution=0.5, load=load), 0), begin,
              GapState(gap, rate, rate, np.zeros(0), np.zeros(0)))  # fmt: skip
    (y,), (v,) = leg.gap(np.array([t]))
    assert leg.gap_at(t) == (pytest.approx(y, rel=1e-13, abs=1e-14 * t), pytest.approx(v, rel=1e-13, abs=1e-14))
