"""Contact laws: what an impact does to each mode, what it takes, and what of the theory holds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Kept, Load, Reversed, System
from percuss.errors import ParameterError
from percuss.model import Contact, Result, UniformBar
from percuss.model.contact import LAWS


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


def test_the_strain_is_reversed_on_uniform_bars_only() -> None:
    class Stepped(UniformBar):
        kind = "stepped"

    load = Load.harmonic(0.5, 1.0)
    assert System(UniformBar(1.0), load, Reversed(0.2)).contact.strain_factor == -0.2
    with pytest.raises(ParameterError, match="kept"):
        System(Stepped(1.0), load, Reversed(0.2))


def test_a_system_is_made_in_one_of_two_ways() -> None:
    load, bar = Load.harmonic(0.5, 1.0), UniformBar(1.0)
    assert (
        System(bar, load, Kept(0.2)) == System(s=1.0, d=0.0, restitution=0.2, load=load) == System(1.0, 0.0, 0.2, load)
    )
    for wrong in (
        {"body": bar, "load": load, "contact": Kept(0.2), "restitution": 0.3},
        {"body": bar, "load": load},
        {"s": 1.0, "load": load},
        {"load": load, "contact": Kept(0.2)},
    ):
        with pytest.raises(ParameterError):
            System(**wrong)
    with pytest.raises(ParameterError):
        System(bar, load, Kept(0.2), None)
    with pytest.raises(ParameterError, match="not two"):
        System(1.0, 0.0, 0.2, load, s=1.0)
