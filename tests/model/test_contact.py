"""Contact laws: what an impact does to each mode, what it takes, and what of the theory holds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Kept, Load, Reversed, System, steady_states
from percuss.errors import ParameterError
from percuss.model import Contact, External, Result, SteppedBar, UniformBar
from percuss.model.contact import LAWS, restitution_of_ratio


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


def test_equal_sections_are_a_uniform_bar() -> None:
    load = Load.fourier([0.4, 1.0, 0.3j])
    stepped, uniform = (
        SteppedBar(9.0, (3.0, 3.0, 3.0), (1.0, 2.0, 0.5), External(0.01)),
        UniformBar(9.0, External(0.01)),
    )
    assert stepped.is_uniform and stepped.is_harmonic
    ours, theirs = (steady_states(System(bar, load, Reversed(0.4))).orbits for bar in (stepped, uniform))
    assert len(ours) == len(theirs) == 2
    for one, other in zip(ours, theirs, strict=True):
        assert one.phase == pytest.approx(other.phase, rel=1e-9)
        assert one.impact_velocity == pytest.approx(other.impact_velocity, rel=1e-9)
        assert one.delivered_energy == pytest.approx(other.delivered_energy, rel=1e-9)


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
