"""The law of a blow that takes time, against blows that are resolved by waves under a load."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss import Kept, Load, System
from percuss.blow import Blow, Rod, strike
from percuss.model import SteppedBar, Timed, UniformBar
from percuss.steady import timed_states


def law_of(blow: Blow, rod: float) -> Timed:
    """The law of a blow on a rod that stays where the blow puts it."""
    assert blow.effective_restitution is not None
    assert blow.contact_duration is not None and blow.force_centroid is not None
    return Timed(blow.effective_restitution, blow.contact_duration, blow.force_centroid, 1.0 / rod)


def pushed(bar: SteppedBar, rod: Rod, load: float) -> Blow:
    """A blow of a bar that a constant load accelerates: mean velocity 1 at the contact's start, force p (1 − m(x))."""
    impedances, transits = np.array(bar.impedances), np.array(bar.transit_times)
    masses = np.append(0.0, np.cumsum(impedances * transits))
    ends = np.append(0.0, np.cumsum(transits))

    def velocity(x: np.ndarray) -> np.ndarray:
        return np.ones_like(x)

    def force(x: np.ndarray) -> np.ndarray:
        return load * (1.0 - np.interp(x, ends / ends[-1], masses / masses[-1]))

    return strike(bar, rod, None, load=[(0.0, load)], field=(velocity, force), until=12.0 / bar.s)


@settings(max_examples=25)
@given(
    impedances=st.lists(st.floats(0.5, 2.0), min_size=1, max_size=3),
    shares=st.lists(st.floats(0.1, 1.0), min_size=3, max_size=3),
    heavier=st.floats(1.5, 20.0),
    load=st.floats(0.01, 2.0),
)
def test_a_load_adds_what_the_law_says_to_the_impulse(
    impedances: list[float], shares: list[float], heavier: float, load: float
) -> None:
    """J = (1 + R)(V − e p) with V at the centroid; exact while the load ends no contact and begins none."""
    bar = SteppedBar(30.0, tuple(impedances), tuple(shares[: len(impedances)]))
    own = np.array(impedances) / np.dot(impedances, bar.transit_times) * sum(bar.transit_times) * bar.s
    impedance = heavier * float(own.max())
    rod = Rod.of_impedance(impedance)
    free = strike(bar, rod, 1.0)
    assume(len(free.contacts) == 1 and free.effective_restitution is not None and free.effective_restitution >= 0.0)
    law = law_of(free, impedance)
    blow = pushed(bar, rod, load)
    assume(blow.contacts[0].end == pytest.approx(law.duration, rel=1e-9))
    at_centroid = 1.0 + load * law.force_centroid
    assert blow.contacts[0].impulse == pytest.approx(law.impulse(at_centroid, load), rel=1e-10)


@pytest.mark.parametrize("s", [5.0, 40.0])
def test_a_uniform_bar_has_the_closed_law(s: float) -> None:
    rod = 4.0 * s  # R = 3/5
    found, closed = law_of(strike(UniformBar(s), Rod.of_impedance(rod), 1.0), rod), Timed.of_uniform_bar(s, 0.6)
    assert (found.restitution, found.duration, found.force_centroid, found.advance_per_impulse) == pytest.approx(
        (closed.restitution, closed.duration, closed.force_centroid, closed.advance_per_impulse), rel=1e-12
    )


def test_from_the_blow_to_the_phase() -> None:
    """The drifter's piston of three sections, from its sections to the phase of the steady motion."""
    bar, rod = SteppedBar(40.0, (1.2566, 1.9635, 0.9503), (0.0731, 0.2187, 0.1493)), 101.13533508847935
    law = law_of(strike(bar, Rod.of_impedance(rod), 1.0), rod)
    orbit = timed_states(System(bar, Load.harmonic(0.66, 1.0), Kept(law.restitution)), law).orbits[1]
    assert orbit.phase == pytest.approx(2.1280786383417226, abs=1e-9)
    assert orbit.phase_b77 == pytest.approx(2.1128830416367776, abs=1e-9)
